//! Errors of the middleware that carries ROS 2.

use thiserror::Error;

/// What a middleware refused, and why.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct MiddlewareError(String);

impl From<String> for MiddlewareError {
    fn from(text: String) -> Self {
        Self(text)
    }
}
