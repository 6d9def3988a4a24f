//! Why a record gives no model.

use std::fmt;

use seatrial_core::InvalidSetting;

use crate::identification::Reason;
use crate::record::{Record, Window};

/// Why there is no model.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum IdentifyError {
    /// No sample lies in a window.
    #[error("no sample lies in the {wanted} window, {window}; {}", extent(*.log_s))]
    EmptyWindow {
        /// What the window is for.
        wanted: WindowUse,
        /// The window.
        window: Window,
        /// Times of the first and of the last sample of the log, s.
        log_s: Option<[f64; 2]>,
    },
    /// A run was not trained or not validated.
    #[error("the run has no training or no validation stage")]
    MissingStage,
    /// A setting is out of its range.
    #[error("{0}")]
    Setting(InvalidSetting),
    /// Nothing can be estimated from these samples.
    #[error("{}", .0.measured())]
    Refused(Reason),
}

/// What a window of a record is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WindowUse {
    /// The model is made from it.
    Training,
    /// The model is judged by it.
    Validation,
}

impl fmt::Display for WindowUse {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Self::Training => "training",
            Self::Validation => "validation",
        })
    }
}

fn extent(log_s: Option<[f64; 2]>) -> String {
    match log_s {
        Some([first, last]) => format!("the log runs from {first} s to {last} s"),
        None => "the log has no samples".into(),
    }
}

impl IdentifyError {
    pub(crate) fn empty_window(wanted: WindowUse, window: Window, record: &Record) -> Self {
        let ends = record.samples.first().zip(record.samples.last());
        Self::EmptyWindow {
            wanted,
            window,
            log_s: ends.map(|(first, last)| [first.time_s, last.time_s]),
        }
    }
}
