//! Logs that are opened in the page.

use std::sync::Arc;

use axum::Json;
use axum::extract::State;
use axum::response::{IntoResponse, Response};
use seatrial_app::log_reading::LogReading;
use seatrial_logs::TrackFormat;
use serde::{Deserialize, Serialize};

use axum::http::StatusCode;

use super::extract::{At, FromQuery, Upload};
use super::{blocking, download};
#[cfg(feature = "openapi")]
use crate::api::{ErrorBody, IdentifiedLog, InspectedLog, LogColumns};
use crate::logs::{self, identified, inspected, keep_sensor_list};
use crate::refusal::Refusal;
use crate::server_state::ServerState;

/// Identifies a model from a log. The log is not kept.
#[cfg_attr(feature = "openapi", utoipa::path(post, path = "/api/v1/logs/identify", tag = "logs", params(LogReading),
    request_body(content = Vec<u8>, content_type = "application/octet-stream", description = "The log, of any format that seatrial reads"),
    responses((status = 200, body = IdentifiedLog), (status = "4XX", description = "Refused", body = ErrorBody))))]
pub async fn identify(
    State(shared): State<Arc<ServerState>>,
    FromQuery(reading): FromQuery<LogReading>,
    Upload(log): Upload,
) -> Result<Response, Refusal> {
    answered(shared, move || identified(log.path(), reading)).await
}

/// Says what is in a log: channels, rates, gaps, manoeuvres. The log is not kept.
#[cfg_attr(feature = "openapi", utoipa::path(post, path = "/api/v1/logs/inspect", tag = "logs", params(LogReading),
    request_body(content = Vec<u8>, content_type = "application/octet-stream", description = "The log, of any format that seatrial reads"),
    responses((status = 200, body = InspectedLog), (status = "4XX", description = "Refused", body = ErrorBody))))]
pub async fn inspect(
    State(shared): State<Arc<ServerState>>,
    FromQuery(reading): FromQuery<LogReading>,
    Upload(log): Upload,
) -> Result<Response, Refusal> {
    answered(shared, move || inspected(log.path(), reading)).await
}

/// The report of a log: one page that needs nothing else. The log is not kept.
#[cfg_attr(feature = "openapi", utoipa::path(post, path = "/api/v1/logs/report", tag = "logs", params(LogReading),
    request_body(content = Vec<u8>, content_type = "application/octet-stream", description = "The log, of any format that seatrial reads"),
    responses((status = 200, description = "As `seatrial report LOG` writes it", body = String, content_type = "text/html"),
        (status = "4XX", description = "Refused", body = ErrorBody))))]
pub async fn report_log(
    State(shared): State<Arc<ServerState>>,
    FromQuery(reading): FromQuery<LogReading>,
    Upload(log): Upload,
) -> Result<Response, Refusal> {
    let page = blocking(shared, move |_| logs::report(log.path(), reading)).await?;
    Ok(download("text/html; charset=utf-8", "log.html", page))
}

/// A form of tracks.
#[derive(Clone, Copy, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum Track {
    /// GPX 1.1.
    Gpx,
    /// KML 2.2.
    Kml,
}

/// The track of a log that has latitude and longitude, a point a second. The log is not kept.
#[cfg_attr(feature = "openapi", utoipa::path(post, path = "/api/v1/logs/track/{format}", tag = "logs",
    params(("format" = inline(Track), Path, description = "The form"), LogReading),
    request_body(content = Vec<u8>, content_type = "application/octet-stream", description = "The log, of any format that seatrial reads"),
    responses((status = 200, description = "The track", body = Vec<u8>, content_type = "application/octet-stream"),
        (status = "4XX", description = "Refused", body = ErrorBody))))]
pub async fn track(
    State(shared): State<Arc<ServerState>>,
    At(format): At<Track>,
    FromQuery(reading): FromQuery<LogReading>,
    Upload(log): Upload,
) -> Result<Response, Refusal> {
    let format = match format {
        Track::Gpx => TrackFormat::Gpx,
        Track::Kml => TrackFormat::Kml,
    };
    let text = blocking(shared, move |_| logs::track(log.path(), reading, format)).await?;
    let name = format!("track.{}", format.extension());
    Ok(download("application/octet-stream", &name, text))
}

/// The names of a log's columns and the units of quantities, of which `rudder`, `heading` and others choose. The log is not kept.
#[cfg_attr(feature = "openapi", utoipa::path(post, path = "/api/v1/logs/columns", tag = "logs", params(LogReading),
    request_body(content = Vec<u8>, content_type = "application/octet-stream", description = "The log, of any format that seatrial reads"),
    responses((status = 200, body = LogColumns), (status = "4XX", description = "Refused", body = ErrorBody))))]
pub async fn columns(
    State(shared): State<Arc<ServerState>>,
    FromQuery(reading): FromQuery<LogReading>,
    Upload(log): Upload,
) -> Result<Response, Refusal> {
    answered(shared, move || logs::columns(log.path(), &reading)).await
}

/// A document that is made and written on a thread of its own: it is large, and others wait for their answers here.
async fn answered<T: Serialize + 'static>(
    shared: Arc<ServerState>,
    made: impl FnOnce() -> Result<T, Refusal> + Send + 'static,
) -> Result<Response, Refusal> {
    blocking(shared, move |_| Ok(Json(made()?).into_response())).await
}

/// Keeps a list of sensors (.cac), which logs of Slocum gliders need beside them, until the server ends.
#[cfg_attr(feature = "openapi", utoipa::path(post, path = "/api/v1/logs/sensor-list", tag = "logs", params(LogReading),
    request_body(content = Vec<u8>, content_type = "application/octet-stream", description = "The list, by its name in `name`"),
    responses((status = 204, description = "Kept"), (status = "4XX", description = "Refused", body = ErrorBody))))]
pub async fn sensor_list(
    State(shared): State<Arc<ServerState>>,
    FromQuery(reading): FromQuery<LogReading>,
    Upload(list): Upload,
) -> Result<StatusCode, Refusal> {
    let kept =
        move |shared: &Arc<ServerState>| keep_sensor_list(shared.uploads.path(), list, &reading);
    blocking(shared, kept).await?;
    Ok(StatusCode::NO_CONTENT)
}
