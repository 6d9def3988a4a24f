//! Status, control, audit trail, live stream.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use axum::extract::State;
use axum::extract::ws::WebSocketUpgrade;
use axum::extract::ws::rejection::WebSocketUpgradeRejection;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use axum::{Extension, Json};
use serde::Deserialize;

use super::extract::{Body, FromQuery};
use super::{OPENAPI_JSON, blocking};
use crate::access::{Claim, LEASE};
#[cfg(feature = "openapi")]
use crate::api::ErrorBody;
use crate::api::{AuditEntry, Control, Lease, Role, Status, TakeControl};
use crate::convert::{name_of, now};
use crate::refusal::Refusal;
use crate::server_state::{Caller, ServerState, must_be_operator, taken};
use crate::stream;

/// Longest first message of a viewer, bytes. A viewer sends no other.
const LONGEST_HELLO: usize = 4096;

/// The server, the trial that runs and who has control.
#[cfg_attr(feature = "openapi", utoipa::path(get, path = "/api/v1/status", tag = "control",
    params(("seatrial-lease" = Option<String>, Header, description = "The lease of control; tells whether it is yours")),
    responses((status = 200, body = Status), (status = "4XX", description = "Refused", body = ErrorBody))))]
pub async fn status(
    State(shared): State<Arc<ServerState>>,
    Extension(caller): Extension<Caller>,
) -> Json<Status> {
    let (trial, health) = shared.live.trial();
    Json(Status {
        version: env!("CARGO_PKG_VERSION").into(),
        now: now(),
        role: caller.role.unwrap_or(Role::Viewer),
        token_needed: shared.tokens.is_some(),
        logbook: shared.logbook.display().to_string(),
        control: shared.leases.control(caller.lease.as_deref()),
        trial,
        health,
        viewers: shared.viewers.load(Ordering::Relaxed),
    })
}

/// This document.
#[cfg_attr(feature = "openapi", utoipa::path(get, path = "/api/v1/openapi.json", tag = "control",
    responses((status = 200, description = "OpenAPI 3.1", body = Object), (status = "4XX", description = "Refused", body = ErrorBody))))]
pub async fn openapi() -> Response {
    let headers = [(axum::http::header::CONTENT_TYPE, "application/json")];
    (headers, OPENAPI_JSON).into_response()
}

/// Takes control: 409 with the name of who has it, where somebody has.
#[cfg_attr(feature = "openapi", utoipa::path(post, path = "/api/v1/control", tag = "control", request_body = TakeControl,
    params(("seatrial-lease" = Option<String>, Header, description = "The lease that you have, if any")),
    responses((status = 200, body = Lease), (status = "4XX", description = "Refused", body = ErrorBody))))]
pub async fn take(
    State(shared): State<Arc<ServerState>>,
    Extension(caller): Extension<Caller>,
    Body(asked): Body<TakeControl>,
) -> Result<Json<Lease>, Refusal> {
    let lease = blocking(shared, move |shared| {
        let name = asked.name.trim();
        let result = took(shared, &caller, name);
        let entered = result.as_ref().map(|_| ());
        shared.audit(&caller, name, "take_control", &asked, entered);
        result
    });
    Ok(Json(lease.await?))
}

fn took(shared: &ServerState, caller: &Caller, name: &str) -> Result<Lease, Refusal> {
    must_be_operator(caller)?;
    if name.is_empty() || name.chars().count() > 64 || name.contains(char::is_control) {
        let expected = "name: expected 1 to 64 characters that can be seen";
        return Err(Refusal::unprocessable("out_of_range", expected));
    }
    let claim = shared.leases.take(name, caller.lease.as_deref());
    match claim.map_err(Refusal::internal)? {
        Claim::Yours { lease, .. } => {
            shared.live.tap().control(shared.leases.control(None));
            Ok(Lease { lease, lapses_after_s: LEASE.as_secs_f64() })
        }
        Claim::Taken { by, since } => Err(taken(&by, &since)),
        Claim::Free => {
            Err(Refusal::conflict("try_again", "control was just given back; try again"))
        }
    }
}

/// Gives control back.
#[cfg_attr(feature = "openapi", utoipa::path(delete, path = "/api/v1/control", tag = "control",
    params(("seatrial-lease" = Option<String>, Header, description = "The lease of control")),
    responses((status = 200, body = Control), (status = "4XX", description = "Refused", body = ErrorBody))))]
pub async fn release(
    State(shared): State<Arc<ServerState>>,
    Extension(caller): Extension<Caller>,
) -> Result<Json<Control>, Refusal> {
    let released = blocking(shared, move |shared| {
        shared.command(&caller, "release_control", &(), |_| {
            shared.leases.release();
            let control = shared.leases.control(None);
            shared.live.tap().control(control.clone());
            Ok(control)
        })
    });
    Ok(Json(released.await?))
}

/// How much of the audit trail.
#[derive(Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::IntoParams))]
#[cfg_attr(feature = "openapi", into_params(parameter_in = Query))]
pub struct AtMost {
    /// At most so many, newest first [default: 100].
    #[cfg_attr(feature = "openapi", param(maximum = 1000))]
    at_most: Option<u32>,
}

/// The commands, newest first.
#[cfg_attr(feature = "openapi", utoipa::path(get, path = "/api/v1/audit", tag = "control", params(AtMost),
    responses((status = 200, body = [AuditEntry]), (status = "4XX", description = "Refused", body = ErrorBody))))]
pub async fn audit(
    State(shared): State<Arc<ServerState>>,
    FromQuery(asked): FromQuery<AtMost>,
) -> Result<Json<Vec<AuditEntry>>, Refusal> {
    let commands = blocking(shared, move |shared| {
        Ok(shared.reader()?.commands(asked.at_most.unwrap_or(100).min(1000))?)
    });
    Ok(Json(commands.await?))
}

/// The live stream, a WebSocket: say `Hello` first; each message is a `LiveMessage`.
#[cfg_attr(feature = "openapi", utoipa::path(get, path = "/api/v1/live", tag = "live",
    responses((status = 101, description = "Text frames, each a LiveMessage; the client's first one is a Hello"),
        (status = "4XX", description = "Refused", body = ErrorBody))))]
pub async fn live(
    State(shared): State<Arc<ServerState>>,
    Extension(caller): Extension<Caller>,
    upgrade: Result<WebSocketUpgrade, WebSocketUpgradeRejection>,
) -> Response {
    let upgrade = match upgrade {
        Ok(upgrade) => upgrade,
        Err(rejection) => {
            let text = rejection.body_text();
            let expected = StatusCode::UPGRADE_REQUIRED;
            return Refusal::new(expected, "websocket_expected", text).into_response();
        }
    };
    let Some(seat) = shared.admit() else {
        let full = format!("{} viewers watch already", crate::server_state::MOST_VIEWERS);
        return Refusal::new(StatusCode::TOO_MANY_REQUESTS, "full", full).into_response();
    };
    upgrade
        .max_message_size(LONGEST_HELLO)
        .max_frame_size(LONGEST_HELLO)
        .on_upgrade(move |socket| stream::show(socket, shared, caller, seat))
}

/// The role that an abort is entered under where its sender has no control.
pub fn role_name(caller: &Caller) -> String {
    caller.role.map_or_else(String::new, name_of)
}
