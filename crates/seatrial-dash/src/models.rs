//! What is made of models: gains, turning limits, files for controllers, simulators and planners.

use seatrial_app::Error;
use seatrial_app::model_request::{FileOfModels, GainsAndLimits, ModelFile, ModelRequest};
use seatrial_app::models::{Models, of_document_text};
use seatrial_app::trials::campaign_models::of_entry;
use seatrial_logbook::{CampaignId, Logbook};

use crate::api::ModelOrder;
use crate::refusal::Refusal;

/// The models of a campaign.
pub fn of_campaign(logbook: &Logbook, id: i64) -> Result<Models, Refusal> {
    let entry = logbook.entry(CampaignId(id))?;
    of_entry(logbook, &entry).map_err(|error| Refusal::unprocessable("no_model", error))
}

/// The models of a log that was identified.
pub fn of_order(order: &ModelOrder) -> Result<Models, Refusal> {
    let speed_m_s = order.stated.surge_speed_m_s;
    of_document_text(order.origin.clone(), &order.document.to_string(), speed_m_s)
        .map_err(|error| Refusal::unprocessable("no_model", error))
}

/// Gains and turning limits.
pub fn limits(models: &Models, request: &ModelRequest) -> Result<GainsAndLimits, Refusal> {
    let limits = request.limits(models);
    limits.map_err(|error| Refusal::unprocessable("no_limits", error))
}

/// A file.
pub fn file(
    models: &Models,
    request: &ModelRequest,
    file: ModelFile,
) -> Result<FileOfModels, Refusal> {
    models
        .unless_rehearsed(request.rehearsal || !file.is_gains())
        .map_err(|error| Refusal::unprocessable("rehearsal", error))?;
    request.file(models, file).map_err(|error| match error {
        Error::Rejected(_) => Refusal::unprocessable("gain_warned_of", error),
        error => Refusal::unprocessable("no_file", error),
    })
}
