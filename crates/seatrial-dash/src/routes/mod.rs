//! The routes, and the OpenAPI document made from them.

mod asked;
mod commission;
mod control;
mod history;
mod logs;
mod trial;

use std::any::Any;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::extract::DefaultBodyLimit;
use axum::http::StatusCode;
use axum::http::header::CONTENT_TYPE;
use axum::http::{Method, Uri};
use axum::middleware::from_fn_with_state;
use axum::response::{IntoResponse, Response};
use axum::routing::{any, get, post};
use tower_http::catch_panic::CatchPanicLayer;
use tower_http::compression::CompressionLayer;
use tower_http::timeout::RequestBodyTimeoutLayer;
use utoipa::OpenApi;

use crate::api;
use crate::blueos;
use crate::guard::guard;
use crate::page;
use crate::refusal::Refusal;
use crate::shared::Shared;

/// Largest body of a command, bytes.
const COMMAND_LIMIT: usize = 64 * 1024;
/// How long a body may stand still.
const BODY_WITHIN: Duration = Duration::from_secs(5);

/// The OpenAPI document.
#[derive(OpenApi)]
#[openapi(
    info(
        title = "seatrial",
        description = "Watch, command and look up sea trials. Quantities are SI, angles radians; missing things are null. \
Where a token is needed it goes into `Authorization: Bearer TOKEN`. Commands need control: take it with POST /api/v1/control \
and send its lease in the header `seatrial-lease`; aborting a trial needs none.",
        license(name = "MIT OR Apache-2.0")
    ),
    paths(
        control::status,
        control::openapi,
        control::take,
        control::release,
        control::audit,
        control::live,
        trial::vehicles,
        trial::default_plan,
        trial::preview,
        trial::preflight,
        trial::start,
        trial::abort,
        trial::repeat,
        trial::go_on,
        commission::preview_commission,
        commission::start_commission,
        commission::commission_state,
        history::campaigns,
        history::campaign,
        history::review,
        history::schedule,
        history::series,
        history::report,
        history::csv,
        history::mcap,
        history::param,
        history::gains,
        history::compare,
        logs::identify,
        logs::inspect,
        logs::columns,
        logs::sensor_list,
    ),
    components(schemas(api::Hello, api::LiveMessage))
)]
struct Api;

/// The OpenAPI document of the server, pretty JSON.
pub fn openapi_json() -> String {
    Api::openapi()
        .to_pretty_json()
        .expect("the document is made of plain data")
        + "\n"
}

/// Everything that is served.
pub fn router(shared: Arc<Shared>, upload_limit: usize) -> Router {
    let logs = Router::new()
        .route("/logs/identify", post(logs::identify))
        .route("/logs/inspect", post(logs::inspect))
        .route("/logs/columns", post(logs::columns))
        .route("/logs/sensor-list", post(logs::sensor_list))
        .layer(DefaultBodyLimit::max(upload_limit));
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
        .route(
            "/commission",
            get(commission::commission_state).post(commission::start_commission),
        )
        .route("/commission/preview", post(commission::preview_commission))
        .route("/campaigns", get(history::campaigns))
        .route("/campaigns/{id}", get(history::campaign))
        .route("/campaigns/{id}/runs/{run}/review", post(history::review))
        .route("/campaigns/{id}/runs/{run}/series", get(history::series))
        .route("/campaigns/{id}/schedule", get(history::schedule))
        .route("/campaigns/{id}/report.html", get(history::report))
        .route("/campaigns/{id}/samples.csv", get(history::csv))
        .route("/campaigns/{id}/samples.mcap", get(history::mcap))
        .route("/campaigns/{id}/gains.param", get(history::param))
        .route("/campaigns/{id}/gains/{format}", get(history::gains))
        .route("/compare", get(history::compare))
        .layer(DefaultBodyLimit::max(COMMAND_LIMIT));
    Router::new()
        .nest("/api/v1", logs.merge(api))
        .route(blueos::PATH, get(blueos::register_service))
        .fallback(get(page::file))
        .method_not_allowed_fallback(not_allowed)
        .with_state(Arc::clone(&shared))
        .layer(RequestBodyTimeoutLayer::new(BODY_WITHIN))
        .layer(CatchPanicLayer::custom(panicked))
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

fn panicked(_: Box<dyn Any + Send>) -> Response {
    Refusal::internal("a bug: the program failed at this request; the trial goes on")
        .into_response()
}

/// Calls what computes for long or waits for a disk, on a thread for that; a few such calls run at a time.
async fn blocking<T: Send + 'static>(
    shared: Arc<Shared>,
    call: impl FnOnce(&Arc<Shared>) -> Result<T, Refusal> + Send + 'static,
) -> Result<T, Refusal> {
    let served = Arc::clone(&shared);
    let _lane = served.lanes.acquire().await.map_err(Refusal::internal)?;
    let called = tokio::task::spawn_blocking(move || call(&shared)).await;
    called.unwrap_or_else(|_| {
        Err(Refusal::internal(
            "a bug: the program failed at this request; the trial goes on",
        ))
    })
}

/// A file to be kept.
fn download(kind: &'static str, name: &str, bytes: impl Into<axum::body::Body>) -> Response {
    let disposition = format!("attachment; filename=\"{name}\"");
    let headers = [
        (CONTENT_TYPE, kind.to_owned()),
        (axum::http::header::CONTENT_DISPOSITION, disposition),
    ];
    (headers, bytes.into()).into_response()
}
