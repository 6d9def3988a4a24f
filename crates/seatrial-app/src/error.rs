//! Why a use case gives no result.

use seatrial_logs::ReadError;

/// Why a use case gives no result.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A setting that makes no sense; the message names it.
    #[error("{0}")]
    Setting(String),
    /// Input that cannot be read or understood; the message says where.
    #[error("{0}")]
    Input(String),
    /// Input that was understood but gives no result.
    #[error("{0}")]
    Rejected(String),
    /// A log that cannot be read.
    #[error(transparent)]
    Log(#[from] ReadError),
    /// A logbook that cannot be read or written.
    #[cfg(feature = "trials")]
    #[error(transparent)]
    Logbook(#[from] seatrial_logbook::Error),
}
