//! Bodies, queries and paths whose faults are refusals like all others.

use std::io::Write;
use std::sync::Arc;

use axum::extract::rejection::{JsonRejection, PathRejection, QueryRejection};
use axum::extract::{FromRequest, FromRequestParts, Path, Query, Request};
use axum::http::StatusCode;
use axum::{Json, RequestExt};
use http_body_util::{BodyExt, LengthLimitError};
use tempfile::NamedTempFile;

use crate::refusal::Refusal;
use crate::server_state::{Caller, ServerState, must_be_operator};

/// A JSON body.
#[derive(FromRequest)]
#[from_request(via(Json), rejection(Refusal))]
pub struct Body<T>(pub T);

/// A body of bytes in a file, which is removed with this.
pub struct Upload(pub NamedTempFile);

impl FromRequest<Arc<ServerState>> for Upload {
    type Rejection = Refusal;

    /// Only operators may upload, and a viewer's log is not even read. The file lies where the lists of sensors are.
    async fn from_request(request: Request, shared: &Arc<ServerState>) -> Result<Self, Refusal> {
        let caller = request.extensions().get::<Caller>();
        must_be_operator(caller.ok_or_else(|| Refusal::internal("a bug: who asks is not known"))?)?;
        let mut file = NamedTempFile::new_in(shared.uploads.path()).map_err(Refusal::internal)?;
        let mut body = request.into_limited_body();
        while let Some(frame) = body.frame().await {
            let frame = frame.map_err(|error| {
                let error = error.into_inner();
                if error.is::<LengthLimitError>() {
                    let status = StatusCode::PAYLOAD_TOO_LARGE;
                    return Refusal::new(
                        status,
                        code(status),
                        "the log is larger than this server takes",
                    );
                }
                Refusal::new(StatusCode::BAD_REQUEST, "malformed", error)
            })?;
            if let Ok(bytes) = frame.into_data() {
                // A slow disk must not hold up others' answers.
                let written = tokio::task::block_in_place(|| file.write_all(&bytes));
                written.map_err(Refusal::internal)?;
            }
        }
        Ok(Self(file))
    }
}

/// The query of an address.
#[derive(FromRequestParts)]
#[from_request(via(Query), rejection(Refusal))]
pub struct FromQuery<T>(pub T);

/// What stands in an address.
#[derive(FromRequestParts)]
#[from_request(via(Path), rejection(Refusal))]
pub struct At<T>(pub T);

fn code(status: StatusCode) -> &'static str {
    match status {
        StatusCode::PAYLOAD_TOO_LARGE => "too_large",
        StatusCode::UNSUPPORTED_MEDIA_TYPE => "json_expected",
        StatusCode::UNPROCESSABLE_ENTITY => "not_understood",
        _ => "malformed",
    }
}

impl From<JsonRejection> for Refusal {
    fn from(rejection: JsonRejection) -> Self {
        Self::new(rejection.status(), code(rejection.status()), rejection.body_text())
    }
}

impl From<QueryRejection> for Refusal {
    fn from(rejection: QueryRejection) -> Self {
        Self::new(StatusCode::UNPROCESSABLE_ENTITY, "not_understood", rejection.body_text())
    }
}

impl From<PathRejection> for Refusal {
    fn from(rejection: PathRejection) -> Self {
        Self::not_found(rejection.body_text())
    }
}
