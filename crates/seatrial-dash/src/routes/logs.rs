//! Logs that are opened in the page.

use std::sync::Arc;

use axum::Json;
use axum::extract::State;

use super::asked::{Asked, Upload};
use super::blocking;
use crate::api::{ErrorBody, IdentifiedLog, InspectedLog, LogReading};
use crate::refusal::Refusal;
use crate::series::series_of;
use crate::shared::Shared;

/// Identifies a model from a log. The log is not kept.
#[utoipa::path(post, path = "/api/v1/logs/identify", tag = "logs", params(LogReading),
    request_body(content = Vec<u8>, content_type = "application/octet-stream", description = "The log, of any format that seatrial reads"),
    responses((status = 200, body = IdentifiedLog), (status = "4XX", description = "Refused", body = ErrorBody)))]
pub async fn identify(
    State(shared): State<Arc<Shared>>,
    Asked(reading): Asked<LogReading>,
    Upload(log): Upload,
) -> Result<Json<IdentifiedLog>, Refusal> {
    let read = blocking(shared, move |shared| {
        let read = shared.workshop.identify(log.path(), &reading);
        read.map_err(refused)
    })
    .await?;
    Ok(Json(IdentifiedLog {
        series: series_of(&read.record, read.validated),
        document: read.document,
    }))
}

/// Says what is in a log: channels, rates, gaps, manoeuvres. The log is not kept.
#[utoipa::path(post, path = "/api/v1/logs/inspect", tag = "logs", params(LogReading),
    request_body(content = Vec<u8>, content_type = "application/octet-stream", description = "The log, of any format that seatrial reads"),
    responses((status = 200, body = InspectedLog), (status = "4XX", description = "Refused", body = ErrorBody)))]
pub async fn inspect(
    State(shared): State<Arc<Shared>>,
    Asked(reading): Asked<LogReading>,
    Upload(log): Upload,
) -> Result<Json<InspectedLog>, Refusal> {
    let read = blocking(shared, move |shared| {
        let read = shared.workshop.inspect(log.path(), &reading);
        read.map_err(refused)
    })
    .await?;
    Ok(Json(InspectedLog {
        series: series_of(&read.record, read.validated),
        document: read.document,
    }))
}

fn refused(why: String) -> Refusal {
    Refusal::unprocessable("log_refused", why)
}
