//! Vehicles, plans, the trial.

use std::sync::Arc;

use axum::extract::State;
use axum::http::StatusCode;
use axum::{Extension, Json};
use seatrial_core::Plan;
use serde::Serialize;
use serde_json::Value;

use super::asked::Body;
use super::blocking;
use super::control::role_name;
use crate::api::{
    ErrorBody, GoOnOrder, PlanOrder, PlanPreview, Preflight, RepeatOrder, TrialOrder, TrialState,
    Vehicles,
};
use crate::refusal::Refusal;
use crate::shared::{Caller, Shared, must_be_operator};
use crate::trials;

/// The vehicles that may be asked for.
#[utoipa::path(get, path = "/api/v1/vehicles", tag = "trial",
    responses((status = 200, body = Vehicles), (status = "4XX", description = "Refused", body = ErrorBody)))]
pub async fn vehicles(State(shared): State<Arc<Shared>>) -> Json<Vehicles> {
    Json(Vehicles {
        vehicles: shared.workshop.vehicles(),
    })
}

/// The default plan, the paper's; its form is that of `seatrial plan`.
#[utoipa::path(get, path = "/api/v1/plans/default", tag = "trial",
    responses((status = 200, description = "The plan", body = Object), (status = "4XX", description = "Refused", body = ErrorBody)))]
pub async fn default_plan() -> Json<Value> {
    Json(serde_json::to_value(Plan::<f64>::paper()).unwrap_or_default())
}

/// What a plan will do on the vehicle expected: intervals, track and time.
#[utoipa::path(post, path = "/api/v1/plans/preview", tag = "trial", request_body = PlanOrder,
    responses((status = 200, body = PlanPreview), (status = "4XX", description = "Refused", body = ErrorBody)))]
pub async fn preview(
    State(shared): State<Arc<Shared>>,
    Body(order): Body<PlanOrder>,
) -> Result<Json<PlanPreview>, Refusal> {
    Ok(Json(
        blocking(shared, move |shared| trials::preview(shared, order)).await?,
    ))
}

/// The checklist before a trial. Looks at the vehicle without touching its controls.
#[utoipa::path(post, path = "/api/v1/preflight", tag = "trial", request_body = PlanOrder,
    responses((status = 200, body = Preflight), (status = "4XX", description = "Refused", body = ErrorBody)))]
pub async fn preflight(
    State(shared): State<Arc<Shared>>,
    Extension(caller): Extension<Caller>,
    Body(order): Body<PlanOrder>,
) -> Result<Json<Preflight>, Refusal> {
    must_be_operator(&caller)?;
    Ok(Json(
        blocking(shared, move |shared| trials::preflight(shared, order)).await?,
    ))
}

/// Carries out a command that starts a trial.
async fn begun<Order: Clone + Serialize + Send + 'static>(
    shared: Arc<Shared>,
    caller: Caller,
    command: &'static str,
    order: Order,
    trial_of: fn(&Shared, Order) -> Result<TrialOrder, Refusal>,
) -> Result<(StatusCode, Json<TrialState>), Refusal> {
    let started = blocking(shared, move |shared| {
        shared.command(&caller, command, &order, |_| {
            trials::start(shared, trial_of(shared, order.clone())?)
        })
    });
    Ok((StatusCode::CREATED, Json(started.await?)))
}

/// Starts a trial.
#[utoipa::path(post, path = "/api/v1/trial", tag = "trial", request_body = TrialOrder,
    params(("seatrial-lease" = Option<String>, Header, description = "The lease of control")),
    responses((status = 201, body = TrialState), (status = "4XX", description = "Refused", body = ErrorBody)))]
pub async fn start(
    State(shared): State<Arc<Shared>>,
    Extension(caller): Extension<Caller>,
    Body(order): Body<TrialOrder>,
) -> Result<(StatusCode, Json<TrialState>), Refusal> {
    begun(shared, caller, "start_trial", order, |_, order| Ok(order)).await
}

/// Runs one speed of a campaign again.
#[utoipa::path(post, path = "/api/v1/trial/repeat", tag = "trial", request_body = RepeatOrder,
    params(("seatrial-lease" = Option<String>, Header, description = "The lease of control")),
    responses((status = 201, body = TrialState), (status = "4XX", description = "Refused", body = ErrorBody)))]
pub async fn repeat(
    State(shared): State<Arc<Shared>>,
    Extension(caller): Extension<Caller>,
    Body(order): Body<RepeatOrder>,
) -> Result<(StatusCode, Json<TrialState>), Refusal> {
    begun(shared, caller, "repeat_speed", order, trials::repeat).await
}

/// Goes on with a campaign that was aborted or interrupted, at the first speed that is not done.
#[utoipa::path(post, path = "/api/v1/trial/go-on", tag = "trial", request_body = GoOnOrder,
    params(("seatrial-lease" = Option<String>, Header, description = "The lease of control")),
    responses((status = 201, body = TrialState), (status = "4XX", description = "Refused", body = ErrorBody)))]
pub async fn go_on(
    State(shared): State<Arc<Shared>>,
    Extension(caller): Extension<Caller>,
    Body(order): Body<GoOnOrder>,
) -> Result<(StatusCode, Json<TrialState>), Refusal> {
    begun(shared, caller, "go_on", order, trials::go_on).await
}

/// Aborts the trial: neutral rudder, heading hold, the vehicle handed back. Every operator may, with control or without.
#[utoipa::path(post, path = "/api/v1/trial/abort", tag = "trial",
    responses((status = 202, description = "Asked for; the live stream tells the end", body = TrialState),
        (status = "4XX", description = "Refused", body = ErrorBody)))]
pub async fn abort(
    State(shared): State<Arc<Shared>>,
    Extension(caller): Extension<Caller>,
) -> Result<(StatusCode, Json<TrialState>), Refusal> {
    // First of all, and not behind anything that waits for a disk.
    let result = must_be_operator(&caller).and_then(|()| shared.stop_trial());
    let stopped = blocking(shared, move |shared| {
        let actor = shared
            .commander(&caller)
            .unwrap_or_else(|_| role_name(&caller));
        let told = result.as_ref().map(|_| ());
        shared.audit(&caller, &actor, "abort_trial", &(), told);
        let campaign = result?;
        let (trial, _) = shared.live.trial();
        let begun = trial.filter(|trial| Some(trial.campaign) == campaign);
        begun.ok_or_else(|| {
            Refusal::conflict(
                "not_begun",
                "the vehicle was still being taken; it is given back",
            )
        })
    });
    Ok((StatusCode::ACCEPTED, Json(stopped.await?)))
}
