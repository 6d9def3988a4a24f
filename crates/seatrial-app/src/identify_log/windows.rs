//! Which part of a log is for training and which for validation.

use std::path::{Path, PathBuf};

use seatrial::identify::{Proposal, ValidationData, propose};
use seatrial::log::segmentation::find_in_each;
use seatrial::{Record, Window};
use serde::{Deserialize, Serialize};

use crate::Error;
use crate::error::other_unit;
use crate::logs::{Observer, OpenedLog, ReadSettings, Source, open_inside};

/// The filters may be warmed on so many lengths of the training window before it.
const KEPT_BEFORE_TRAINING: f64 = 7.0;

/// Training and validation windows, half open, in the log's own seconds. Without any the log's manoeuvres are looked for.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Windows {
    /// Start of the training window, s; else the log's start.
    pub from_s: Option<f64>,
    /// End of the training window, s; else the start of the validation window, or the log's end.
    pub to_s: Option<f64>,
    /// Start of the validation window, s.
    pub validate_from_s: Option<f64>,
    /// End of the validation window, s.
    pub validate_to_s: Option<f64>,
    /// Validate on another log, read like the first; the validation window is then one of that log.
    pub validate_on: Option<PathBuf>,
}

/// What was opened.
#[derive(Clone, Debug)]
pub struct Logs {
    /// The log with the training window.
    pub log: OpenedLog,
    /// The training window.
    pub training: Window,
    /// The validation window, where one was asked for.
    pub validation: Option<Window>,
    /// The log with the validation window, where it is another one.
    pub validation_log: Option<OpenedLog>,
    /// The logs that the first one was joined with, and itself; empty where there is one log.
    pub parts: Vec<Part>,
}

/// One of several logs that are joined.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// The log.
    #[serde(flatten)]
    pub source: Source,
    /// Where it lies on the time of the joined record.
    pub window: Window,
}

impl Windows {
    /// With what follows the end of the training window for validation, where no validation window is given.
    pub fn validated_on_the_rest(&self) -> Self {
        let given = self.has_validation();
        Self {
            validate_from_s: self.validate_from_s.or(self.to_s.filter(|_| !given)),
            ..self.clone()
        }
    }

    /// Is any window given?
    pub fn are_given(&self) -> bool {
        self.from_s.is_some() || self.to_s.is_some() || self.has_validation()
    }

    fn has_validation(&self) -> bool {
        self.validate_from_s.is_some() || self.validate_to_s.is_some() || self.validate_on.is_some()
    }

    /// The training window, and that for validation where one is asked for.
    fn chosen(&self) -> Result<(Window, Option<Window>), Error> {
        let validation =
            self.has_validation().then(|| window(self.validate_from_s, self.validate_to_s));
        let same_log = validation.filter(|_| self.validate_on.is_none());
        let from_s = self.from_s;
        // Without an end, training goes on until the validation data begin.
        let to_s = self.to_s.or_else(|| {
            same_log
                .map(|validation| validation.from_s)
                .filter(|start| start.is_finite() && from_s.is_none_or(|from_s| from_s < *start))
        });
        let training = window(from_s, to_s);
        for window in [Some(training), validation].into_iter().flatten() {
            if window.from_s.is_nan() || window.to_s.is_nan() || window.from_s >= window.to_s {
                return Err(Error::Setting(format!("the window {window} is empty")));
            }
        }
        if let Some(validation) = same_log
            && validation.from_s < training.to_s
            && training.from_s < validation.to_s
        {
            return Err(Error::Setting(format!(
                "the training window ({training}) and the validation window ({validation}) overlap: data that were trained on do not validate"
            )));
        }
        Ok((training, validation))
    }

    /// Reads as much of the logs as the windows need.
    pub fn open(
        &self,
        path: &Path,
        reading: &ReadSettings,
        observer: &mut dyn Observer,
    ) -> Result<Logs, Error> {
        let (training, validation) = self.chosen()?;
        let before = KEPT_BEFORE_TRAINING * (training.to_s - training.from_s);
        let keep = Window {
            from_s: training.from_s - if before.is_finite() { before } else { 0.0 },
            to_s: training.to_s,
        };
        let same_log = validation.filter(|_| self.validate_on.is_none());
        let keep = same_log.map_or(keep, |validation| Window {
            from_s: keep.from_s.min(validation.from_s),
            to_s: keep.to_s.max(validation.to_s),
        });
        let log = open_inside(path, reading, keep, observer)?;
        let other = self.validate_on.as_ref().map(|path| {
            let keep = validation.unwrap_or(Window::ALL);
            open_inside(path, reading, keep, observer)
        });
        let validation_log = other.transpose()?;
        if let (Some(other), Some(path)) = (&validation_log, &self.validate_on)
            && other.record.rudder_unit != log.record.rudder_unit
        {
            return Err(other_unit(&path.display().to_string()));
        }
        Ok(Logs { log, training, validation, validation_log, parts: Vec::new() })
    }
}

impl Logs {
    /// Joins the first log with more of the same vehicle.
    pub(super) fn join(
        &mut self,
        paths: &[PathBuf],
        reading: &ReadSettings,
        observer: &mut dyn Observer,
    ) -> Result<(), Error> {
        let mut sources = vec![self.log.source()];
        let mut records = vec![std::mem::take(&mut self.log.record)];
        for path in paths {
            let more = open_inside(path, reading, Window::ALL, observer)?;
            if sources.iter().any(|source| source.sha256 == more.sha256) {
                let path = path.display();
                return Err(Error::Input(format!(
                    "{path}: it holds the same bytes as a log before it: name each log once"
                )));
            }
            sources.push(more.source());
            self.log.warnings.extend(more.warnings);
            records.push(more.record);
        }
        let (joined, windows) = Record::joined(&records).ok_or_else(|| {
            let is_other = |source: &&Source| source.rudder_unit != sources[0].rudder_unit;
            let other = sources.iter().find(is_other);
            other_unit(other.map_or("one of the logs", |source| &source.path))
        })?;
        self.log.record = joined;
        let parts = sources.into_iter().zip(windows);
        self.parts = parts.map(|(source, window)| Part { source, window }).collect();
        Ok(())
    }

    /// The manoeuvres of each of several logs; of a log without any, the whole.
    pub(super) fn proposals(&self) -> Vec<Proposal> {
        let windows: Vec<Window> = self.parts.iter().map(|part| part.window).collect();
        let record = &self.log.record;
        propose(record, &find_in_each(&record.samples, &windows))
    }

    /// The data for validation.
    pub fn validation_data(&self) -> Option<ValidationData<'_>> {
        self.validation.map(|window| ValidationData {
            record: &self.validation_log.as_ref().unwrap_or(&self.log).record,
            window,
        })
    }
}

fn window(from_s: Option<f64>, to_s: Option<f64>) -> Window {
    Window { from_s: from_s.unwrap_or(f64::NEG_INFINITY), to_s: to_s.unwrap_or(f64::INFINITY) }
}
