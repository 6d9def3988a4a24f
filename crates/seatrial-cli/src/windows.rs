//! The options that say which stretch of a log is for training and which is fresh.

use std::path::PathBuf;

use seatrial::Window;
use seatrial::identify::{IdentifyError, ValidationData};

use crate::log::{self, LogArgs, OpenedLog};
use crate::output::Failure;

/// The filters may be warmed on so many lengths of the training window before it.
const KEPT_BEFORE_TRAINING: f64 = 7.0;

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

/// What was opened.
pub struct Logs {
    /// The log with the training window.
    pub log: OpenedLog,
    /// The training window.
    pub training: Window,
    /// The validation window, where one was asked for.
    pub validation: Option<Window>,
    /// The log with the validation window, where it is another one.
    pub validation_log: Option<OpenedLog>,
}

impl WindowArgs {
    /// The same, but what follows the end of the training window is fresh where no validation window was given.
    pub fn with_the_rest_fresh(&self) -> Self {
        let given = self.has_validation();
        Self {
            validate_from: self.validate_from.or(self.to.filter(|_| !given)),
            ..self.clone()
        }
    }

    /// Was any window given?
    pub fn are_given(&self) -> bool {
        self.from.is_some() || self.to.is_some() || self.has_validation()
    }

    fn has_validation(&self) -> bool {
        self.validate_from.is_some() || self.validate_to.is_some() || self.validate_on.is_some()
    }

    /// Reads the windows, then as much of the logs as they need.
    pub fn open(&self, args: &LogArgs) -> Result<Logs, Failure> {
        let validation = self
            .has_validation()
            .then(|| window(self.validate_from, self.validate_to));
        let same_log = validation.filter(|_| self.validate_on.is_none());
        let from = self.from;
        // Without an end, training goes on until the fresh data begin.
        let to = self.to.or_else(|| {
            same_log
                .map(|fresh| fresh.from_s)
                .filter(|start| start.is_finite() && from.is_none_or(|from| from < *start))
        });
        let training = window(from, to);
        for window in [Some(training), validation].into_iter().flatten() {
            if window.from_s.is_nan() || window.to_s.is_nan() || window.from_s >= window.to_s {
                return Err(Failure::usage(format!("the window {window} is empty")));
            }
        }
        if let Some(fresh) = same_log
            && fresh.from_s < training.to_s
            && training.from_s < fresh.to_s
        {
            return Err(Failure::usage(format!(
                "the training window ({training}) and the validation window ({fresh}) overlap: data that were trained on are not fresh"
            )));
        }
        let before = KEPT_BEFORE_TRAINING * (training.to_s - training.from_s);
        let keep = Window {
            from_s: training.from_s - if before.is_finite() { before } else { 0.0 },
            to_s: training.to_s,
        };
        let keep = same_log.map_or(keep, |fresh| Window {
            from_s: keep.from_s.min(fresh.from_s),
            to_s: keep.to_s.max(fresh.to_s),
        });
        Ok(Logs {
            log: open_inside(args, keep)?,
            training,
            validation,
            validation_log: self
                .validate_on
                .as_ref()
                .map(|path| {
                    let keep = validation.unwrap_or(Window::ALL);
                    let args = LogArgs {
                        log: path.clone(),
                        channels: args.channels.clone(),
                    };
                    open_inside(&args, keep)
                })
                .transpose()?,
        })
    }
}

impl Logs {
    /// The fresh data.
    pub fn fresh(&self) -> Option<ValidationData<'_>> {
        self.validation.map(|window| ValidationData {
            record: &self.validation_log.as_ref().unwrap_or(&self.log).record,
            window,
        })
    }
}

/// Reads what is inside `keep`, or, to be able to say what the log has instead, all of it.
pub fn open_inside(args: &LogArgs, keep: Window) -> Result<OpenedLog, Failure> {
    let opened = log::open(&args.log, &args.channels, Some(keep))?;
    if opened.record.samples.is_empty() && keep != Window::ALL {
        return log::open(&args.log, &args.channels, None);
    }
    Ok(opened)
}

/// Why there is no model, as the command says it.
pub fn failure(log: &OpenedLog, error: IdentifyError) -> Failure {
    match error {
        IdentifyError::EmptyWindow(message) => {
            Failure::input(format!("{}: {message}", log.path.display()))
        }
        IdentifyError::Setting(error) => Failure::usage(error),
        IdentifyError::Refused(reason) => {
            Failure::rejected(format!("{}: {}", log.path.display(), reason.text))
        }
    }
}

fn window(from_s: Option<f64>, to_s: Option<f64>) -> Window {
    Window {
        from_s: from_s.unwrap_or(f64::NEG_INFINITY),
        to_s: to_s.unwrap_or(f64::INFINITY),
    }
}
