//! Logs that are opened in the page.

use std::path::Path;
use std::sync::Arc;

use axum::Json;
use axum::extract::State;
use serde::Deserialize;
use utoipa::IntoParams;

use super::asked::{Asked, Upload};
use super::blocking;
use crate::api::{ErrorBody, IdentifiedLog, InspectedLog};
use crate::refusal::Refusal;
use crate::series::series_of;
use crate::shared::Shared;
use crate::workshop::ReadLog;

/// A log's name.
#[derive(Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub struct Named {
    /// What the log is called; its format is found by its content.
    #[param(max_length = 200)]
    name: Option<String>,
}

/// Identifies a model from a log. The log is not kept.
#[utoipa::path(post, path = "/api/v1/logs/identify", tag = "logs", params(Named),
    request_body(content = Vec<u8>, content_type = "application/octet-stream", description = "The log, of any format that seatrial reads"),
    responses((status = 200, body = IdentifiedLog), (status = "4XX", description = "Refused", body = ErrorBody)))]
pub async fn identify(
    State(shared): State<Arc<Shared>>,
    Asked(named): Asked<Named>,
    Upload(log): Upload,
) -> Result<Json<IdentifiedLog>, Refusal> {
    let read = blocking(shared, move |shared| {
        let read = |path: &Path, name: &str| shared.workshop.identify(path, name);
        read_upload(log.path(), named, read)
    })
    .await?;
    Ok(Json(IdentifiedLog {
        series: series_of(&read.record, read.validated),
        document: read.document,
    }))
}

/// Says what is in a log: channels, rates, gaps, manoeuvres. The log is not kept.
#[utoipa::path(post, path = "/api/v1/logs/inspect", tag = "logs", params(Named),
    request_body(content = Vec<u8>, content_type = "application/octet-stream", description = "The log, of any format that seatrial reads"),
    responses((status = 200, body = InspectedLog), (status = "4XX", description = "Refused", body = ErrorBody)))]
pub async fn inspect(
    State(shared): State<Arc<Shared>>,
    Asked(named): Asked<Named>,
    Upload(log): Upload,
) -> Result<Json<InspectedLog>, Refusal> {
    let read = blocking(shared, move |shared| {
        let read = |path: &Path, name: &str| shared.workshop.inspect(path, name);
        read_upload(log.path(), named, read)
    })
    .await?;
    Ok(Json(InspectedLog {
        series: series_of(&read.record, read.validated),
        document: read.document,
    }))
}

fn read_upload(
    log: &Path,
    named: Named,
    read: impl FnOnce(&Path, &str) -> Result<ReadLog, String>,
) -> Result<ReadLog, Refusal> {
    let name: String = named
        .name
        .unwrap_or_else(|| "log".into())
        .chars()
        .take(200)
        .collect();
    read(log, &name).map_err(|why| Refusal::unprocessable("log_refused", why))
}
