//! What is made of models: of a log's document, and of a campaign.

use std::sync::Arc;

use axum::Extension;
use axum::Json;
use axum::extract::State;
use axum::http::{HeaderName, HeaderValue};
use axum::response::{IntoResponse, Response};
use seatrial::gains::export;
use seatrial_app::gains_export::Format;
use seatrial_app::model_request::{FileOfModels, ModelFile, ModelRequest};
use serde::Deserialize;

use super::extract::{At, Body, FromQuery};
use super::{blocking, download};
#[cfg(feature = "openapi")]
use crate::api::ErrorBody;
use crate::api::ModelOrder;
use crate::models;
use crate::refusal::Refusal;
use crate::server_state::{Caller, ServerState, must_be_operator};

/// What to know about a file, ` | ` between its sentences.
const NOTES: HeaderName = HeaderName::from_static("seatrial-notes");

/// Gains and turning limits of the model of a log. Nothing is kept.
#[cfg_attr(feature = "openapi", utoipa::path(post, path = "/api/v1/models/limits", tag = "models", request_body = ModelOrder,
    responses((status = 200, description = "The documents of `gains --json` and `turn --json`, and what is said against them", body = Object),
        (status = "4XX", description = "Refused", body = ErrorBody))))]
pub async fn model_limits(
    State(shared): State<Arc<ServerState>>,
    Extension(caller): Extension<Caller>,
    Body(order): Body<ModelOrder>,
) -> Result<Response, Refusal> {
    must_be_operator(&caller)?;
    blocking(shared, move |_| {
        let found = models::limits(&models::of_order(&order)?, &order.stated)?;
        Ok(Json(found).into_response())
    })
    .await
}

/// A file made of the model of a log. Nothing is kept.
#[cfg_attr(feature = "openapi", utoipa::path(post, path = "/api/v1/models/files/{file}", tag = "models", request_body = ModelOrder,
    params(("file" = String, Path, description = "Which file: the name of one of `files` of the limits", example = "vehicle")),
    responses((status = 200, description = "As `gains --export` or `export --to` writes it", body = Vec<u8>, content_type = "application/octet-stream"),
        (status = "4XX", description = "Refused", body = ErrorBody))))]
pub async fn model_file(
    State(shared): State<Arc<ServerState>>,
    Extension(caller): Extension<Caller>,
    At(file): At<ModelFile>,
    Body(order): Body<ModelOrder>,
) -> Result<Response, Refusal> {
    must_be_operator(&caller)?;
    let made =
        blocking(shared, move |_| models::file(&models::of_order(&order)?, &order.stated, file));
    Ok(answered(made.await?, BYTES, "model"))
}

/// Gains and turning limits of a campaign.
#[cfg_attr(feature = "openapi", utoipa::path(get, path = "/api/v1/campaigns/{id}/limits", tag = "models",
    params(("id" = i64, Path, description = "Number of the campaign"), ModelRequest),
    responses((status = 200, description = "The documents of `gains --json` and `turn --json`, and what is said against them", body = Object),
        (status = "4XX", description = "Refused", body = ErrorBody))))]
pub async fn campaign_limits(
    State(shared): State<Arc<ServerState>>,
    At(id): At<i64>,
    FromQuery(request): FromQuery<ModelRequest>,
) -> Result<Response, Refusal> {
    blocking(shared, move |shared| {
        let models = models::of_campaign(&shared.reader()?, id)?;
        Ok(Json(models::limits(&models, &request)?).into_response())
    })
    .await
}

/// A file made of the models of a campaign.
#[cfg_attr(feature = "openapi", utoipa::path(get, path = "/api/v1/campaigns/{id}/files/{file}", tag = "downloads",
    params(("id" = i64, Path, description = "Number of the campaign"), ("file" = String, Path, description = "Which file: the name of one of `files` of the limits", example = "vehicle"), ModelRequest),
    responses((status = 200, description = "As `gains --export` or `export --to` writes it", body = Vec<u8>, content_type = "application/octet-stream"),
        (status = "4XX", description = "Refused", body = ErrorBody))))]
pub async fn campaign_file(
    State(shared): State<Arc<ServerState>>,
    At((id, file)): At<(i64, ModelFile)>,
    FromQuery(request): FromQuery<ModelRequest>,
) -> Result<Response, Refusal> {
    of_campaign(shared, id, file, BYTES, request).await
}

async fn of_campaign(
    shared: Arc<ServerState>,
    id: i64,
    file: ModelFile,
    kind: &'static str,
    request: ModelRequest,
) -> Result<Response, Refusal> {
    let made = blocking(shared, move |shared| {
        models::file(&models::of_campaign(&shared.reader()?, id)?, &request, file)
    });
    Ok(answered(made.await?, kind, &format!("campaign-{id}")))
}

/// How a file of bytes is sent, and one that is a text.
const BYTES: &str = "application/octet-stream";
const TEXT: &str = "text/plain; charset=utf-8";

fn answered(file: FileOfModels, kind: &'static str, stem: &str) -> Response {
    // A header is ASCII.
    let notes = file.notes.join(" | ").replace(['“', '”'], "\"");
    let notes = notes.replace(|c: char| !(' '..='~').contains(&c), "?");
    let mut response = download(kind, &format!("{stem}.{}", file.extension), file.bytes);
    if let Ok(notes) = HeaderValue::from_str(&notes)
        && !notes.is_empty()
    {
        response.headers_mut().insert(NOTES, notes);
    }
    response
}

/// Whose parameters.
#[derive(Clone, Copy, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum VehicleType {
    /// Rover.
    Surface,
    /// Sub.
    Underwater,
}

/// For which autopilot.
#[derive(Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::IntoParams))]
#[cfg_attr(feature = "openapi", into_params(parameter_in = Query))]
pub struct Autopilot {
    /// [default: surface]
    #[cfg_attr(feature = "openapi", param(inline))]
    vehicle_type: Option<VehicleType>,
    /// Must be true for a rehearsal on a simulator, whose parameters are not those of a vehicle.
    #[cfg_attr(feature = "openapi", param(inline))]
    rehearsal: Option<bool>,
}

/// Parameters of ArduPilot for the fastest accepted model of a campaign.
#[cfg_attr(feature = "openapi", utoipa::path(get, path = "/api/v1/campaigns/{id}/gains.param", tag = "downloads",
    params(("id" = i64, Path, description = "Number of the campaign"), Autopilot),
    responses((status = 200, description = "As `gains --export ardupilot` writes it", body = String, content_type = "text/plain"),
        (status = "4XX", description = "Refused", body = ErrorBody))))]
pub async fn param(
    shared: State<Arc<ServerState>>,
    At(id): At<i64>,
    asked: FromQuery<Autopilot>,
) -> Result<Response, Refusal> {
    gains(shared, At((id, Format::Ardupilot)), asked).await
}

/// Gains and limits of a campaign in a form that a controller reads.
#[cfg_attr(feature = "openapi", utoipa::path(get, path = "/api/v1/campaigns/{id}/gains/{format}", tag = "downloads",
    params(("id" = i64, Path, description = "Number of the campaign"),
        ("format" = inline(Format), Path, description = "For which controller"), Autopilot),
    responses((status = 200, description = "As `gains --export` writes it", body = String, content_type = "text/plain"),
        (status = "4XX", description = "Refused", body = ErrorBody))))]
pub async fn gains(
    State(shared): State<Arc<ServerState>>,
    At((id, format)): At<(i64, Format)>,
    FromQuery(asked): FromQuery<Autopilot>,
) -> Result<Response, Refusal> {
    let request =
        ModelRequest { rehearsal: asked.rehearsal.unwrap_or(false), ..ModelRequest::default() };
    let vehicle = match asked.vehicle_type {
        Some(VehicleType::Underwater) => export::VehicleType::Underwater,
        Some(VehicleType::Surface) | None => export::VehicleType::Surface,
    };
    of_campaign(shared, id, ModelFile::Gains(format, vehicle), TEXT, request).await
}
