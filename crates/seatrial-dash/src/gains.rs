//! Gains and limits of a campaign as files that controllers read.

use std::fmt::Display;

use seatrial::export::{VehicleType, ardupilot, px4};
use seatrial_app::gains::Wanted;
use seatrial_app::gains_export::check_usable;
use seatrial_app::models::{Models, Tuned, of_entry};
use seatrial_logbook::{CampaignId, Logbook};
use serde::Deserialize;

use crate::history::DAMPING_RATIO;
use crate::refusal::Refusal;

/// A form that controllers read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum GainsFormat {
    /// Parameters of ArduPilot, .param.
    Ardupilot,
    /// Parameters of PX4, .params.
    Px4,
    /// Parameters of a ROS 2 node, YAML: the gain schedule as arrays.
    Ros2,
    /// The gain schedule as JSON.
    Json,
    /// The gain schedule as a table in a C99 header.
    C,
}

impl GainsFormat {
    /// How a file of it ends.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Ardupilot => "param",
            Self::Px4 => "params",
            Self::Ros2 => "yaml",
            Self::Json => "json",
            Self::C => "h",
        }
    }
}

/// The file of a campaign's gains. An autopilot without a gain schedule gets those of the fastest accepted model.
pub fn gains_file(
    logbook: &Logbook,
    id: i64,
    format: GainsFormat,
    vehicle: VehicleType,
    rehearsal: bool,
) -> Result<String, Refusal> {
    let entry = logbook.entry(CampaignId(id))?;
    let refused = |error: &dyn Display| Refusal::unprocessable("no_model", error);
    let models = of_entry(logbook, &entry).map_err(|error| refused(&error))?;
    models
        .unless_rehearsed(rehearsal)
        .map_err(|error| Refusal::unprocessable("rehearsal", error))?;
    check_usable(&Wanted::default(), &models)
        .map_err(|error| Refusal::unprocessable("gain_warned_of", error))?;
    let point = || {
        let tuned = tuned(&models, id)?;
        models
            .operating_point(&tuned, DAMPING_RATIO)
            .map_err(|error| Refusal::unprocessable("no_parameters", error))
    };
    let schedule = || {
        models
            .gain_schedule(DAMPING_RATIO)
            .map_err(|error| Refusal::unprocessable("no_gain", error))
    };
    Ok(match format {
        GainsFormat::Ardupilot => ardupilot::param_file(&point()?, vehicle),
        GainsFormat::Px4 => px4::params_file(&point()?, vehicle),
        GainsFormat::Ros2 => schedule()?.ros2_yaml(),
        GainsFormat::C => schedule()?.c_header(),
        GainsFormat::Json => {
            let schedule = schedule()?;
            serde_json::to_string_pretty(&schedule).map_err(Refusal::internal)? + "\n"
        }
    })
}

/// The fastest accepted model, if it has a gain.
fn tuned(models: &Models, id: i64) -> Result<Tuned, Refusal> {
    let fastest = models
        .points
        .last()
        .ok_or_else(|| Refusal::unprocessable("no_model", "the campaign has no accepted model"))?;
    fastest
        .allowance
        .design(&fastest.point.model, DAMPING_RATIO)
        .map_err(|reason| Refusal::unprocessable("no_gain", format!("campaign {id}: {reason}")))?;
    Ok(Tuned::from(fastest))
}
