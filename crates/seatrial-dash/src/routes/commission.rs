//! Commissions: preview, start, state. The abort is that of a trial.

use std::sync::Arc;

use axum::extract::State;
use axum::http::StatusCode;
use axum::{Extension, Json};
use serde::Deserialize;

use super::blocking;
use super::extract::{Body, FromQuery};
#[cfg(feature = "openapi")]
use crate::api::ErrorBody;
use crate::api::{
    CommissionOrder, CommissionPreview, CommissionShown, CommissionState, UndoOrder, UndoPreview,
    Undone,
};
use crate::commission;
use crate::refusal::Refusal;
use crate::server_state::{Caller, ServerState, must_be_operator};

/// What a commission would do: the autopilot's own gains beside those proposed. Looks at the vehicle without touching its controls.
#[cfg_attr(feature = "openapi", utoipa::path(post, path = "/api/v1/commission/preview", tag = "commission", request_body = CommissionOrder,
    responses((status = 200, body = CommissionPreview), (status = "4XX", description = "Refused", body = ErrorBody))))]
pub async fn preview_commission(
    State(shared): State<Arc<ServerState>>,
    Extension(caller): Extension<Caller>,
    Body(order): Body<CommissionOrder>,
) -> Result<Json<CommissionPreview>, Refusal> {
    must_be_operator(&caller)?;
    let preview = blocking(shared, move |shared| commission::preview(shared, &order));
    Ok(Json(preview.await?))
}

/// Starts a commission: gains are written, tried by heading steps, and stay only where they do no worse than those before.
#[cfg_attr(feature = "openapi", utoipa::path(post, path = "/api/v1/commission", tag = "commission", request_body = CommissionOrder,
    params(("seatrial-lease" = Option<String>, Header, description = "The lease of control")),
    responses((status = 201, body = CommissionState), (status = "4XX", description = "Refused", body = ErrorBody))))]
pub async fn start_commission(
    State(shared): State<Arc<ServerState>>,
    Extension(caller): Extension<Caller>,
    Body(order): Body<CommissionOrder>,
) -> Result<(StatusCode, Json<CommissionState>), Refusal> {
    let started = blocking(shared, move |shared| {
        shared.command(&caller, "commission", &order, |_| commission::start(shared, order.clone()))
    });
    Ok((StatusCode::CREATED, Json(started.await?)))
}

/// What putting back would write: the parameters that the newest trial or commission has changed, as they are and as they were. Looks
/// at the vehicle without touching its controls.
#[cfg_attr(feature = "openapi", utoipa::path(post, path = "/api/v1/commission/undo/preview", tag = "commission", request_body = UndoOrder,
    responses((status = 200, body = UndoPreview), (status = "4XX", description = "Refused", body = ErrorBody))))]
pub async fn preview_undo(
    State(shared): State<Arc<ServerState>>,
    Extension(caller): Extension<Caller>,
    Body(order): Body<UndoOrder>,
) -> Result<Json<UndoPreview>, Refusal> {
    must_be_operator(&caller)?;
    let preview = blocking(shared, move |shared| commission::preview_undo(shared, &order));
    Ok(Json(preview.await?))
}

/// Puts the parameters back that a trial or a commission has changed, as `seatrial vehicle restore` does, and reads them back.
#[cfg_attr(feature = "openapi", utoipa::path(post, path = "/api/v1/commission/undo", tag = "commission", request_body = UndoOrder,
    params(("seatrial-lease" = Option<String>, Header, description = "The lease of control")),
    responses((status = 200, body = Undone), (status = "4XX", description = "Refused", body = ErrorBody))))]
pub async fn undo_commission(
    State(shared): State<Arc<ServerState>>,
    Extension(caller): Extension<Caller>,
    Body(order): Body<UndoOrder>,
) -> Result<Json<Undone>, Refusal> {
    let undone = blocking(shared, move |shared| {
        shared.command(&caller, "undo_commission", &order, |_| commission::undo(shared, &order))
    });
    Ok(Json(undone.await?))
}

/// Which samples.
#[derive(Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::IntoParams))]
#[cfg_attr(feature = "openapi", into_params(parameter_in = Query))]
pub struct From {
    /// The first sample that is wanted, from 0 [default: 0].
    #[cfg_attr(feature = "openapi", param(minimum = 0))]
    after: Option<u64>,
}

/// The commission that runs, or the last one, and its samples.
#[cfg_attr(feature = "openapi", utoipa::path(get, path = "/api/v1/commission", tag = "commission", params(From),
    responses((status = 200, body = CommissionShown), (status = "4XX", description = "Refused", body = ErrorBody))))]
pub async fn commission_state(
    State(shared): State<Arc<ServerState>>,
    FromQuery(asked): FromQuery<From>,
) -> Json<CommissionShown> {
    Json(shared.commission.since(asked.after.unwrap_or(0)))
}
