//! Why a request is refused, as status, code and words.

use axum::Json;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use seatrial::identification::Reader;
use seatrial::words::{plain, shortened};
use seatrial_app::advice::addressed;

use crate::api::ErrorBody;

/// A refused request.
#[derive(Clone, Debug, PartialEq)]
pub struct Refusal {
    pub(crate) status: StatusCode,
    pub(crate) code: &'static str,
    pub(crate) message: String,
}

impl Refusal {
    /// A refusal, in the words of the page; what others wrote in it cannot turn its lines around.
    pub(crate) fn new(status: StatusCode, code: &'static str, message: impl ToString) -> Self {
        Self {
            status,
            code,
            message: addressed(&plain(&shortened(&message.to_string())), Reader::Dashboard),
        }
    }

    /// What is asked for is not there.
    pub(crate) fn not_found(message: impl ToString) -> Self {
        Self::new(StatusCode::NOT_FOUND, "not_found", message)
    }

    /// The request conflicts with the state of the server.
    pub(crate) fn conflict(code: &'static str, message: impl ToString) -> Self {
        Self::new(StatusCode::CONFLICT, code, message)
    }

    /// The request was understood, but cannot be done.
    pub fn unprocessable(code: &'static str, message: impl ToString) -> Self {
        Self::new(StatusCode::UNPROCESSABLE_ENTITY, code, message)
    }

    /// The server's own fault: a damaged logbook, a full disk, a bug.
    pub(crate) fn internal(message: impl ToString) -> Self {
        Self::new(StatusCode::INTERNAL_SERVER_ERROR, "internal", message)
    }
}

impl From<seatrial_logbook::Error> for Refusal {
    fn from(error: seatrial_logbook::Error) -> Self {
        match error {
            seatrial_logbook::Error::NoCampaign { .. } => Self::not_found(error),
            error => Self::internal(error),
        }
    }
}

impl IntoResponse for Refusal {
    fn into_response(self) -> Response {
        let body = ErrorBody { code: self.code.into(), message: self.message };
        (self.status, Json(body)).into_response()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_a_refusal_cannot_turn_its_lines_around() {
        let refusal = Refusal::not_found("no configuration \u{202e}txet\u{1b}[2J");
        assert_eq!(refusal.message, "no configuration \\u{202e}txet\\u{1b}[2J");
    }
}
