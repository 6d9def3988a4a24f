//! Why a record gives no model.

use seatrial_core::InvalidSetting;

use crate::identification::Reason;
use crate::record::{Record, Window};

/// Why there is no model.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum IdentifyError {
    /// No sample lies in a window.
    #[error("{0}")]
    EmptyWindow(String),
    /// A setting is out of its range.
    #[error("{0}")]
    Setting(InvalidSetting),
    /// Nothing can be estimated from these samples.
    #[error("{}", .0.text)]
    Refused(Reason),
}

impl IdentifyError {
    pub(super) fn empty_window(name: &str, window: Window, record: &Record) -> Self {
        let span = match (record.samples.first(), record.samples.last()) {
            (Some(first), Some(last)) => {
                format!("the log runs from {} s to {} s", first.time_s, last.time_s)
            }
            _ => "the log has no samples".into(),
        };
        Self::EmptyWindow(format!(
            "no sample lies in the {name} window, {window}; {span}"
        ))
    }
}
