//! The routes.

mod commission;
mod control;
mod damage;
mod extract;
mod history;
mod logs;
mod models;
#[cfg(feature = "openapi")]
mod openapi;
mod trial;

use std::panic::AssertUnwindSafe;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::extract::{DefaultBodyLimit, Request};
use axum::http::StatusCode;
use axum::http::header::CONTENT_TYPE;
use axum::http::{Method, Uri};
use axum::middleware::{Next, from_fn, from_fn_with_state};
use axum::response::{IntoResponse, Response};
use axum::routing::{any, get, post};
use futures_util::FutureExt;
use tower_http::compression::CompressionLayer;
use tower_http::timeout::RequestBodyTimeoutLayer;

use crate::blueos;
use crate::guard::guard;
use crate::page;
use crate::refusal::Refusal;
use crate::server_state::ServerState;

#[cfg(feature = "openapi")]
pub use openapi::openapi_of_types;

/// Largest body of a command, bytes.
const COMMAND_LIMIT: usize = 64 * 1024;
/// Largest document of a model, bytes: those of logs with many speeds have some 100 kB.
const DOCUMENT_LIMIT: usize = 4 << 20;
/// How long a body may stand still.
const BODY_WITHIN: Duration = Duration::from_secs(5);

/// The OpenAPI document of the server. It is made of the types by the feature `openapi`, which costs a build much of its time; a test
/// holds the file against them.
pub const OPENAPI_JSON: &str = include_str!("../../openapi.json");

/// Everything that is served.
pub fn router(shared: Arc<ServerState>, upload_limit: usize) -> Router {
    let logs = Router::new()
        .route("/logs/identify", post(logs::identify))
        .route("/logs/inspect", post(logs::inspect))
        .route("/logs/report", post(logs::report_log))
        .route("/logs/track/{format}", post(logs::track))
        .route("/logs/columns", post(logs::columns))
        .route("/logs/sensor-list", post(logs::sensor_list))
        .layer(DefaultBodyLimit::max(upload_limit));
    let models = Router::new()
        .route("/models/limits", post(models::model_limits))
        .route("/models/files/{file}", post(models::model_file))
        .layer(DefaultBodyLimit::max(DOCUMENT_LIMIT));
    let api = Router::new()
        .route("/status", get(control::status))
        .route("/openapi.json", get(control::openapi))
        .route("/control", post(control::take).delete(control::release))
        .route("/audit", get(control::audit))
        .route("/live", any(control::live))
        .route("/vehicles", get(trial::vehicles))
        .route("/plans/default", get(trial::default_plan))
        .route("/plans/preview", post(trial::preview))
        .route("/preflight", post(trial::preflight))
        .route("/trial", post(trial::start))
        .route("/trial/abort", post(trial::abort))
        .route("/trial/repeat", post(trial::repeat))
        .route("/trial/go-on", post(trial::go_on))
        .route("/commission", get(commission::commission_state).post(commission::start_commission))
        .route("/commission/preview", post(commission::preview_commission))
        .route("/commission/undo/preview", post(commission::preview_undo))
        .route("/commission/undo", post(commission::undo_commission))
        .route("/campaigns", get(history::campaigns))
        .route("/campaigns/{id}", get(history::campaign))
        .route("/campaigns/{id}/runs/{run}/review", post(history::review))
        .route("/campaigns/{id}/runs/{run}/series", get(history::series))
        .route("/campaigns/{id}/schedule", get(history::schedule))
        .route("/campaigns/{id}/report.html", get(history::report))
        .route("/campaigns/{id}/samples.csv", get(history::csv))
        .route("/campaigns/{id}/samples.mcap", get(history::mcap))
        .route("/campaigns/{id}/gains.param", get(models::param))
        .route("/campaigns/{id}/gains/{format}", get(models::gains))
        .route("/campaigns/{id}/limits", get(models::campaign_limits))
        .route("/campaigns/{id}/files/{file}", get(models::campaign_file))
        .route("/compare", get(history::compare))
        .layer(from_fn_with_state(Arc::clone(&shared), damage::told))
        .layer(DefaultBodyLimit::max(COMMAND_LIMIT));
    Router::new()
        .nest("/api/v1", logs.merge(models).merge(api))
        .route(blueos::PATH, get(blueos::register_service))
        .fallback(get(page::file))
        .method_not_allowed_fallback(not_allowed)
        .with_state(Arc::clone(&shared))
        .layer(RequestBodyTimeoutLayer::new(BODY_WITHIN))
        .layer(from_fn(without_panic))
        .layer(from_fn_with_state(shared, guard))
        .layer(CompressionLayer::new())
}

async fn not_allowed(method: Method, uri: Uri) -> Refusal {
    Refusal::new(
        StatusCode::METHOD_NOT_ALLOWED,
        "method_not_allowed",
        format!("{method} is not for {}", uri.path()),
    )
}

/// Refuses a request at which the program panics.
async fn without_panic(request: Request, next: Next) -> Response {
    let answered = AssertUnwindSafe(next.run(request)).catch_unwind().await;
    answered.unwrap_or_else(|_| {
        Refusal::internal("a bug: the program failed at this request; the trial goes on")
            .into_response()
    })
}

/// Calls what computes for long or waits for a disk, on a thread for that; a few such calls run at a time, also where their clients
/// have left.
async fn blocking<T: Send + 'static>(
    shared: Arc<ServerState>,
    call: impl FnOnce(&Arc<ServerState>) -> Result<T, Refusal> + Send + 'static,
) -> Result<T, Refusal> {
    let lanes = Arc::clone(&shared.lanes);
    let lane = lanes.acquire_owned().await.map_err(Refusal::internal)?;
    let called = tokio::task::spawn_blocking(move || {
        let _lane = lane;
        call(&shared)
    })
    .await;
    called.unwrap_or_else(|_| {
        Err(Refusal::internal("a bug: the program failed at this request; the trial goes on"))
    })
}

/// A file to be kept.
fn download(kind: &'static str, name: &str, bytes: impl Into<axum::body::Body>) -> Response {
    let disposition = format!("attachment; filename=\"{name}\"");
    let headers =
        [(CONTENT_TYPE, kind.to_owned()), (axum::http::header::CONTENT_DISPOSITION, disposition)];
    (headers, bytes.into()).into_response()
}
