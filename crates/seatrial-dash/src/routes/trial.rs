//! Vehicles, plans, the trial.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use axum::extract::State;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use axum::{Extension, Json};
use seatrial_app::trials::simulator::Scenario;
use seatrial_core::Plan;
use serde::Serialize;
use tokio::time::timeout;

use super::blocking;
use super::control::role_name;
use super::extract::Body;
#[cfg(feature = "openapi")]
use crate::api::ErrorBody;
use crate::api::{
    GoOnOrder, PlanOrder, PlanPreview, Preflight, RepeatOrder, ScenarioForm, TrialOrder,
    TrialState, VehicleForm, Vehicles,
};
use crate::refusal::Refusal;
use crate::server_state::{Caller, ServerState, must_be_operator};
use crate::trials::{self, Allowance};

/// A client that waits for its answer; dropped with its request.
struct WaitingClient(Arc<AtomicBool>);

impl Default for WaitingClient {
    fn default() -> Self {
        Self(Arc::new(AtomicBool::new(true)))
    }
}

impl WaitingClient {
    fn flag(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.0)
    }
}

impl Drop for WaitingClient {
    fn drop(&mut self) {
        self.0.store(false, Ordering::Relaxed);
    }
}

/// The vehicles that may be asked for.
#[cfg_attr(feature = "openapi", utoipa::path(get, path = "/api/v1/vehicles", tag = "trial",
    responses((status = 200, body = Vehicles), (status = "4XX", description = "Refused", body = ErrorBody))))]
pub async fn vehicles(State(shared): State<Arc<ServerState>>) -> Json<Vehicles> {
    let vehicles = shared.vehicles.iter().map(|vehicle| VehicleForm {
        name: vehicle.name().into(),
        description: vehicle.description().into(),
        is_simulated: vehicle.is_simulated(),
        has_gains: shared.autopilot(vehicle.name()).is_ok(),
    });
    let scenarios = Scenario::built_in().into_iter();
    let scenarios = scenarios.map(|(name, description)| ScenarioForm {
        name: name.into(),
        description: description.into(),
    });
    Json(Vehicles { vehicles: vehicles.collect(), scenarios: scenarios.collect() })
}

/// The default plan, the paper's; its form is that of `seatrial plan`.
#[cfg_attr(feature = "openapi", utoipa::path(get, path = "/api/v1/plans/default", tag = "trial",
    responses((status = 200, description = "The plan", body = Object), (status = "4XX", description = "Refused", body = ErrorBody))))]
pub async fn default_plan() -> Json<Plan<f64>> {
    Json(Plan::paper())
}

/// What a plan will do on the vehicle expected: intervals, track and time.
#[cfg_attr(feature = "openapi", utoipa::path(post, path = "/api/v1/plans/preview", tag = "trial", request_body = PlanOrder,
    responses((status = 200, body = PlanPreview), (status = "4XX", description = "Refused", body = ErrorBody))))]
pub async fn preview(
    State(shared): State<Arc<ServerState>>,
    Extension(caller): Extension<Caller>,
    Body(order): Body<PlanOrder>,
) -> Result<Json<PlanPreview>, Refusal> {
    let (waiting, allowance) = (WaitingClient::default(), Allowance::of(&caller));
    let is_waited_for = waiting.flag();
    let preview =
        blocking(shared, move |shared| trials::preview(shared, order, allowance, &is_waited_for));
    Ok(Json(preview.await?))
}

/// The checklist before a trial. Looks at the vehicle without touching its controls.
#[cfg_attr(feature = "openapi", utoipa::path(post, path = "/api/v1/preflight", tag = "trial", request_body = PlanOrder,
    responses((status = 200, body = Preflight), (status = "4XX", description = "Refused", body = ErrorBody))))]
pub async fn preflight(
    State(shared): State<Arc<ServerState>>,
    Extension(caller): Extension<Caller>,
    Body(order): Body<PlanOrder>,
) -> Result<Json<Preflight>, Refusal> {
    must_be_operator(&caller)?;
    let (waiting, allowance) = (WaitingClient::default(), Allowance::of(&caller));
    let is_waited_for = waiting.flag();
    let found =
        blocking(shared, move |shared| trials::preflight(shared, order, allowance, &is_waited_for));
    Ok(Json(found.await?))
}

/// Carries out a command that starts a trial.
async fn begun<Order: Clone + Serialize + Send + 'static>(
    shared: Arc<ServerState>,
    caller: Caller,
    command: &'static str,
    order: Order,
    wanted: fn(&ServerState, Order) -> Result<TrialOrder, Refusal>,
) -> Result<(StatusCode, Json<TrialState>), Refusal> {
    let started = blocking(shared, move |shared| {
        shared.command(&caller, command, &order, |operator| {
            trials::start(shared, wanted(shared, order.clone())?, operator)
        })
    });
    Ok((StatusCode::CREATED, Json(started.await?)))
}

/// Starts a trial.
#[cfg_attr(feature = "openapi", utoipa::path(post, path = "/api/v1/trial", tag = "trial", request_body = TrialOrder,
    params(("seatrial-lease" = Option<String>, Header, description = "The lease of control")),
    responses((status = 201, body = TrialState), (status = "4XX", description = "Refused", body = ErrorBody))))]
pub async fn start(
    State(shared): State<Arc<ServerState>>,
    Extension(caller): Extension<Caller>,
    Body(order): Body<TrialOrder>,
) -> Result<(StatusCode, Json<TrialState>), Refusal> {
    begun(shared, caller, "start_trial", order, |_, order| Ok(order)).await
}

/// Runs one speed of a campaign again.
#[cfg_attr(feature = "openapi", utoipa::path(post, path = "/api/v1/trial/repeat", tag = "trial", request_body = RepeatOrder,
    params(("seatrial-lease" = Option<String>, Header, description = "The lease of control")),
    responses((status = 201, body = TrialState), (status = "4XX", description = "Refused", body = ErrorBody))))]
pub async fn repeat(
    State(shared): State<Arc<ServerState>>,
    Extension(caller): Extension<Caller>,
    Body(order): Body<RepeatOrder>,
) -> Result<(StatusCode, Json<TrialState>), Refusal> {
    begun(shared, caller, "repeat_speed", order, trials::repeat).await
}

/// Goes on with a campaign that was aborted or interrupted, at the first speed that is not done.
#[cfg_attr(feature = "openapi", utoipa::path(post, path = "/api/v1/trial/go-on", tag = "trial", request_body = GoOnOrder,
    params(("seatrial-lease" = Option<String>, Header, description = "The lease of control")),
    responses((status = 201, body = TrialState), (status = "4XX", description = "Refused", body = ErrorBody))))]
pub async fn go_on(
    State(shared): State<Arc<ServerState>>,
    Extension(caller): Extension<Caller>,
    Body(order): Body<GoOnOrder>,
) -> Result<(StatusCode, Json<TrialState>), Refusal> {
    begun(shared, caller, "go_on", order, trials::go_on).await
}

/// How long the answer to an abort waits for its entry in the audit trail.
const ENTERED_WITHIN: Duration = Duration::from_millis(50);

/// Aborts the trial: neutral rudder, heading hold, the vehicle handed back. A commission ends with the old gains. Every operator may,
/// with control or without.
#[cfg_attr(feature = "openapi", utoipa::path(post, path = "/api/v1/trial/abort", tag = "trial",
    responses((status = 202, description = "Asked for; the live stream tells the end", body = TrialState),
        (status = 204, description = "A commission is asked to end; the live stream tells how"),
        (status = "4XX", description = "Refused", body = ErrorBody))))]
pub async fn abort(
    State(shared): State<Arc<ServerState>>,
    Extension(caller): Extension<Caller>,
) -> Result<Response, Refusal> {
    let is_commission = shared.slot.is_commission();
    let result = must_be_operator(&caller).and_then(|()| shared.stop_trial());
    let entered = tokio::task::spawn_blocking({
        let (shared, result) = (Arc::clone(&shared), result.clone());
        move || enter_abort(&shared, &caller, &result)
    });
    // A busy disk enters it later.
    let _ = timeout(ENTERED_WITHIN, entered).await;
    let campaign = result?;
    if is_commission {
        return Ok(StatusCode::NO_CONTENT.into_response());
    }
    let (trial, _) = shared.live.trial();
    let begun = trial.filter(|trial| Some(trial.campaign) == campaign);
    let begun = begun.ok_or_else(|| {
        Refusal::conflict("not_begun", "the vehicle was still being taken; it is given back")
    })?;
    Ok((StatusCode::ACCEPTED, Json(begun)).into_response())
}

fn enter_abort(shared: &ServerState, caller: &Caller, result: &Result<Option<i64>, Refusal>) {
    let actor = shared.commander(caller);
    let actor = actor.unwrap_or_else(|_| role_name(caller));
    let result = result.as_ref().map(|_| ());
    shared.audit(caller, &actor, "abort_trial", &(), result);
}
