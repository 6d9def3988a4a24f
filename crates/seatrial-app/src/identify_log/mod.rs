//! From a log to models: the manoeuvres of each speed are found, joined and identified, and each model is judged.

mod speeds;
mod windows;

use std::path::Path;

use seatrial::Identification;
use seatrial::identification::{Reason, ReasonCode, Verdict};
use seatrial::identify::{IdentifyError, IdentifySettings, identify};
use seatrial::pitch;
use seatrial_core::Axis;

use crate::Error;
use crate::logs::{Observer, OpenedLog, ReadSettings, Unobserved};

pub use speeds::{SpeedModel, foremost, identify_speeds};
pub use windows::{Logs, Windows};

/// How a log is read and identified. The default is what `seatrial identify LOG` does.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// The motion: heading under the rudder, or pitch under the elevator, from the columns `pitch_rad` and `elevator_rad`
    /// where [`reading`](Options::reading) names no others as heading and rudder. Pitch is identified from one window.
    pub axis: Axis,
    /// Columns, units and servo.
    pub reading: ReadSettings,
    /// What is for training and what for validation.
    pub windows: Windows,
    /// The estimator.
    pub settings: IdentifySettings,
}

/// What was found in a log: a model of each speed, or one of the whole, or why there is none.
#[derive(Clone, Debug)]
pub struct IdentifiedLog {
    /// The motion.
    pub axis: Axis,
    /// What was read.
    pub logs: Logs,
    /// The model of each speed, slowest first, where manoeuvres were looked for and found.
    pub models: Option<Vec<SpeedModel>>,
    single: Result<Box<Identification>, Verdict>,
}

/// Identifies a log, as `seatrial identify LOG` does: without windows its manoeuvres are looked for, those of one speed
/// joined, and each model validated on a manoeuvre that it was not trained on; a log without manoeuvres, or that is
/// one, is for training as a whole.
///
/// A model that may not be used is no error: look at [`IdentifiedLog::verdict`].
///
/// # Errors
/// A log that cannot be read, a column or unit that it does not have, or a window without samples; each error says where, what was
/// found and what to do.
pub fn identify_log(path: &Path, options: &Options) -> Result<IdentifiedLog, Error> {
    identify_log_observed(path, options, &mut Unobserved)
}

/// [`identify_log`], telling an observer what is found on the way.
pub fn identify_log_observed(
    path: &Path,
    options: &Options,
    observer: &mut dyn Observer,
) -> Result<IdentifiedLog, Error> {
    let reading = options.reading.on_axis(options.axis);
    let logs = options.windows.open(path, &reading, observer)?;
    identify_opened(logs, options, observer)
}

/// [`identify_log`] of what was opened with the windows of these options.
pub fn identify_opened(
    logs: Logs,
    options: &Options,
    observer: &mut dyn Observer,
) -> Result<IdentifiedLog, Error> {
    let settings = &options.settings;
    if let Some(aircraft) = &logs.log.description.aircraft {
        return Ok(IdentifiedLog {
            axis: options.axis,
            models: None,
            single: Err(Verdict::refused(not_a_vessel(aircraft))),
            logs,
        });
    }
    if !options.windows.are_given()
        && !settings.as_paper
        && options.axis == Axis::Yaw
        && let Some(models) = identify_speeds(&logs.log, settings, observer)?
        && let Some(foremost) = foremost(&models)
    {
        let single = foremost.identification.clone();
        return Ok(IdentifiedLog {
            axis: options.axis,
            single: single.map(Box::new).ok_or_else(|| foremost.verdict.clone()),
            models: Some(models),
            logs,
        });
    }
    let (record, training, data) = (&logs.log.record, logs.training, logs.validation_data());
    let found = match options.axis {
        Axis::Yaw => identify(record, training, data, settings),
        Axis::Pitch => pitch::identify(record, training, data),
    };
    let single = match found {
        Ok(identification) => Ok(Box::new(identification)),
        Err(IdentifyError::Refused(reason)) => Err(Verdict::refused(reason)),
        Err(error) => return Err(no_model(&logs.log, error)),
    };
    Ok(IdentifiedLog {
        axis: options.axis,
        models: None,
        single,
        logs,
    })
}

/// The log is of what does not steer in the water.
fn not_a_vessel(aircraft: &str) -> Reason {
    Reason {
        action: "Use the log of a boat, a ship or an underwater vehicle.".into(),
        ..Reason::new(
            ReasonCode::NotAVessel,
            format!("This is the log of {aircraft}, which has no rudder in the water."),
        )
    }
}

impl IdentifiedLog {
    /// The model, or the surest of several. `None` where the data refused one; the verdict says why.
    pub fn identification(&self) -> Option<&Identification> {
        self.single.as_deref().ok()
    }

    /// May the model be used?
    pub fn verdict(&self) -> &Verdict {
        match &self.single {
            Ok(identification) => &identification.verdict,
            Err(verdict) => verdict,
        }
    }
}

/// Why there is no model.
pub fn no_model(log: &OpenedLog, error: IdentifyError) -> Error {
    let said = |text: &str| format!("{}: {text}", log.path.display());
    match error {
        IdentifyError::EmptyWindow { .. } | IdentifyError::MissingStage => {
            Error::Input(said(&error.to_string()))
        }
        IdentifyError::Setting(error) => Error::Setting(error.to_string()),
        IdentifyError::Refused(reason) => Error::Rejected(said(reason.measured())),
    }
}
