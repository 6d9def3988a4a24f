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

/// Why a rudder that is an angle is not compared with a share of full rudder, and what settles it.
pub(crate) const OTHER_UNIT: (&str, &str) = (
    "one rudder is an angle and the other a share of full",
    "Give the angle of full rudder for both with --rudder-range-deg DEG.",
);

/// [`OTHER_UNIT`] of a log or of models.
pub(crate) fn other_unit(origin: &str) -> Error {
    let (why, action) = OTHER_UNIT;
    Error::Setting(format!("{origin}: {why}. {action}"))
}
