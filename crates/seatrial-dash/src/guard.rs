//! Checks that every request passes first, and headers that every answer has.

use std::net::SocketAddr;
use std::sync::Arc;

use axum::extract::{ConnectInfo, Request, State};
use axum::http::header::{
    CACHE_CONTROL, CONTENT_SECURITY_POLICY, HeaderName, HeaderValue, REFERRER_POLICY,
    WWW_AUTHENTICATE, X_CONTENT_TYPE_OPTIONS, X_FRAME_OPTIONS,
};
use axum::http::{Method, StatusCode};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use crate::access::{bearer, is_own_origin, own_host};
use crate::api::Role;
use crate::refusal::Refusal;
use crate::server_state::{Caller, ServerState};

/// The header with the lease of control.
pub const LEASE: &str = "seatrial-lease";
/// What a request with a wrong token costs, in requests.
pub const WRONG_TOKEN: f64 = 50.0;

/// The path of the abort.
pub const ABORT: &str = "/api/v1/trial/abort";
const LIVE: &str = "/api/v1/live";
const OPENAPI: &str = "/api/v1/openapi.json";

const ALWAYS: [(HeaderName, &str); 6] = [
    (
        CONTENT_SECURITY_POLICY,
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; font-src 'self'; \
         connect-src 'self'; manifest-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    ),
    (X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (X_FRAME_OPTIONS, "DENY"),
    (REFERRER_POLICY, "no-referrer"),
    (HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
    (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
];

/// Lets a request through to where it goes, or refuses it.
pub async fn guard(
    State(shared): State<Arc<ServerState>>,
    ConnectInfo(peer): ConnectInfo<SocketAddr>,
    mut request: Request,
    next: Next,
) -> Response {
    let is_api = request.uri().path().starts_with("/api/");
    let mut response = match admitted(&shared, peer, &request) {
        Ok(caller) => {
            request.extensions_mut().insert(caller);
            next.run(request).await
        }
        Err(refusal) => refusal.into_response(),
    };
    let is_refused = response.status() == StatusCode::UNAUTHORIZED;
    let headers = response.headers_mut();
    for (name, value) in ALWAYS {
        headers.insert(name, HeaderValue::from_static(value));
    }
    if is_api {
        headers.insert(CACHE_CONTROL, HeaderValue::from_static("no-store"));
    }
    if is_refused {
        headers.insert(WWW_AUTHENTICATE, HeaderValue::from_static("Bearer"));
    }
    response
}

fn admitted(shared: &ServerState, peer: SocketAddr, request: &Request) -> Result<Caller, Refusal> {
    let address = peer.ip().to_canonical();
    let role = role_of(shared, request);
    // An operator's abort goes before everything, also where others behind the same address ask too much.
    let is_abort = *request.method() == Method::POST && request.uri().path() == ABORT;
    let is_urgent = is_abort && matches!(role, Ok(Some(Role::Operator)));
    let cost = match role {
        Err(NoRole::WrongToken) => WRONG_TOKEN,
        _ => 1.0,
    };
    if !shared.rates.allows(address, cost) && !is_urgent {
        return Err(Refusal::new(
            StatusCode::TOO_MANY_REQUESTS,
            "too_many_requests",
            "too many requests from your address; wait some seconds",
        ));
    }
    let role = role.map_err(|refused| match refused {
        NoRole::Foreign(refusal) => refusal,
        NoRole::WrongToken => token_needed("the token is not known"),
    })?;
    let path = request.uri().path();
    let is_open = !path.starts_with("/api/") || path == LIVE || path == OPENAPI;
    if role.is_none() && !is_open {
        return Err(token_needed("a token is needed: send Authorization: Bearer TOKEN"));
    }
    let lease = request.headers().get(LEASE);
    let lease = lease.and_then(|lease| lease.to_str().ok());
    Ok(Caller { role, address, lease: lease.map(String::from) })
}

/// Why a request has no role.
enum NoRole {
    /// The request comes from another site, or asks for another server.
    Foreign(Refusal),
    /// Its token is not one of ours.
    WrongToken,
}

/// What a request may do by its token; `None` where it has none.
fn role_of(shared: &ServerState, request: &Request) -> Result<Option<Role>, NoRole> {
    let (headers, path) = (request.headers(), request.uri().path());
    let forbidden =
        |code, message| NoRole::Foreign(Refusal::new(StatusCode::FORBIDDEN, code, message));
    let host = own_host(headers, shared.is_loopback, &shared.hosts).ok_or_else(|| {
        forbidden(
            "host_refused",
            "this server does not go by the name in the Host header; start it with --host NAME",
        )
    })?;
    let only_reads = matches!(*request.method(), Method::GET | Method::HEAD) && path != LIVE;
    if !only_reads && !is_own_origin(headers, host) {
        return Err(forbidden("origin_refused", "the request comes from a page of another site"));
    }
    let Some(tokens) = &shared.tokens else {
        return Ok(Some(Role::Operator));
    };
    bearer(headers).map(|token| tokens.role(token).ok_or(NoRole::WrongToken)).transpose()
}

fn token_needed(message: &str) -> Refusal {
    Refusal::new(StatusCode::UNAUTHORIZED, "token_needed", message)
}
