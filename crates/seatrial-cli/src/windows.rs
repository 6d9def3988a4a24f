//! The options that say which part of a log is for training and which for validation.

use std::path::PathBuf;

use seatrial_app::identify_log::Windows;

/// Training and validation windows, half open, in the log's own seconds.
#[derive(clap::Args, Clone, Debug, Default)]
#[command(next_help_heading = "Windows of time")]
pub struct WindowArgs {
    /// Start of the training window, s [default: the log's start].
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    from: Option<f64>,
    /// End of the training window, s [default: the start of the validation window, or the log's end].
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    to: Option<f64>,
    /// Start of the validation window, s.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    validate_from: Option<f64>,
    /// End of the validation window, s.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    validate_to: Option<f64>,
    /// Validate on another log, read like the first; the validation window is then one of that log.
    #[arg(long, value_name = "LOG")]
    validate_on: Option<PathBuf>,
}

impl WindowArgs {
    /// The windows that these options stand for.
    pub fn windows(&self) -> Windows {
        Windows {
            from_s: self.from,
            to_s: self.to,
            validate_from_s: self.validate_from,
            validate_to_s: self.validate_to,
            validate_on: self.validate_on.clone(),
        }
    }
}
