//! From a log to models: the manoeuvres of each speed are found, joined and identified, and each model is judged.

mod speeds;
mod windows;

use std::path::{Path, PathBuf};

use seatrial::campaign::speeds::SpeedLaw;
use seatrial::identification::{Reason, ReasonCode, Subject, Verdict};
use seatrial::identify::Proposal;
use seatrial::identify::mission::is_ordinary_steering;
use seatrial::identify::{IdentifyError, IdentifySettings, ValidationData, identify};
use seatrial::log::Servo;
use seatrial::motions::pitch;
use seatrial::{Identification, Window};
use seatrial_core::Axis;
use seatrial_logs::Quantity;

use crate::Error;
use crate::logs::{NoObserver, Observer, OpenedLog, ReadSettings};

pub use speeds::{SpeedModel, foremost, identify_speeds};
use speeds::{identify_proposals, share_over_speed, whole_verdict};
pub use windows::{Logs, Part, Windows};

/// How a log is read and identified. The default is what `seatrial identify LOG` does.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Options {
    /// The motion: heading under the rudder, or pitch under the elevator, from the columns `pitch_rad` and `elevator_rad`
    /// where [`reading`](Options::reading) names no others as heading and rudder. Pitch is identified from one window.
    pub axis: Axis,
    /// Columns, units and servo.
    pub reading: ReadSettings,
    /// Further logs of the same vehicle and load, read like the first. One model a speed is made of all of them.
    pub more_logs: Vec<PathBuf>,
    /// What is for training and what for validation; only of one log.
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
    /// The law over speed by which these models borrow from each other, where one does.
    pub law: Option<SpeedLaw>,
    model: Option<Box<Identification>>,
    verdict: Verdict,
}

/// Identifies a log, as `seatrial identify LOG` does: without windows its manoeuvres are looked for, those of one speed
/// joined, and each model validated on a manoeuvre that it was not trained on; a log without manoeuvres, or that is
/// one, is for training as a whole. Ordinary steering is fitted as a whole and checked on its last two fifths.
///
/// A model that may not be used is no error: look at [`IdentifiedLog::verdict`].
///
/// # Errors
/// A log that cannot be read, a column or unit that it does not have, or a window without samples; each error says where, what was
/// found and what to do.
pub fn identify_log(path: &Path, options: &Options) -> Result<IdentifiedLog, Error> {
    identify_log_observed(path, options, &mut NoObserver)
}

/// [`identify_log`], telling an observer what is found on the way.
pub fn identify_log_observed(
    path: &Path,
    options: &Options,
    observer: &mut dyn Observer,
) -> Result<IdentifiedLog, Error> {
    let reading = options.reading.on_axis(options.axis);
    let mut logs = options.windows.open(path, &reading, observer)?;
    if !options.more_logs.is_empty() {
        if options.windows.are_given() || options.axis == Axis::Pitch {
            return Err(Error::Setting(
                "windows, another log to validate on and the axis of pitch are of one log: leave them out, or name one log; of several logs one validates the model of the others".into(),
            ));
        }
        logs.join(&options.more_logs, &reading, observer)?;
    }
    identify_opened(logs, options, observer)
}

/// [`identify_log`] of what was opened with the windows of these options.
pub fn identify_opened(
    logs: Logs,
    options: &Options,
    observer: &mut dyn Observer,
) -> Result<IdentifiedLog, Error> {
    let mut found = match options.windows.are_given() {
        true => one_model(&logs.log, logs.training, logs.validation_data(), options)?,
        false => {
            let found = (logs.parts.len() > 1).then(|| logs.proposals());
            models_of(&logs.log, options, found, observer)?
        }
    };
    if let Some(servo) = logs.log.servo {
        found.behind(servo);
    }
    Ok(IdentifiedLog {
        axis: options.axis,
        models: found.models,
        law: found.law,
        model: found.model,
        verdict: naming_other_columns(found.verdict, &logs.log),
        logs,
    })
}

/// What another heading, the other motor of two, or another rudder of the log explains.
fn naming_other_columns(verdict: Verdict, log: &OpenedLog) -> Verdict {
    let verdict = naming_another_rudder(verdict, log);
    let verdict = match &log.mirrored_motor {
        Some(motor) => motor.before(verdict),
        None => verdict,
    };
    match &log.other_heading {
        Some(other) => other.before(verdict),
        None => verdict,
    }
}

/// A log may have both the command of the rudder and its measured angle: where one gives no model, the other may.
fn naming_another_rudder(mut verdict: Verdict, log: &OpenedLog) -> Verdict {
    let is_for_want_of_a_rudder = |reason: &Reason| {
        matches!(
            (&reason.code, &reason.of),
            (ReasonCode::Constant, Some(Subject::Rudder))
                | (ReasonCode::Contradicted, _)
                | (ReasonCode::RudderNotFollowed, None | Some(Subject::Rudder))
                | (
                    ReasonCode::NotIdentifiable
                        | ReasonCode::UnderExcited
                        | ReasonCode::DoesNotFit
                        | ReasonCode::LowR2,
                    None
                )
        )
    };
    if !verdict.accepted
        && let Some(cause) = verdict.reasons.first_mut()
        && is_for_want_of_a_rudder(cause)
        && let Some(other) = log.description.other_columns(Quantity::Rudder).first()
    {
        cause.action = format!("Try column `{other}` for the rudder. {}", cause.action);
    }
    verdict
}

/// May a model of this log be used, as `identify` without windows says it of the manoeuvres that were found?
pub fn verdict_of(log: &OpenedLog, proposals: Vec<Proposal>) -> Result<Verdict, Error> {
    let found = models_of(log, &Options::default(), Some(proposals), &mut NoObserver)?;
    Ok(found.verdict)
}

/// The models of a log, the foremost one and the verdict on all.
struct LogModels {
    models: Option<Vec<SpeedModel>>,
    law: Option<SpeedLaw>,
    model: Option<Box<Identification>>,
    verdict: Verdict,
}

impl LogModels {
    fn identifications(&mut self) -> impl Iterator<Item = &mut Identification> {
        let of_speeds = self.models.iter_mut().flatten();
        of_speeds.filter_map(|model| model.identification.as_mut()).chain(self.model.as_deref_mut())
    }

    /// The lag that was given is known, and 0 of a measured angle.
    fn behind(&mut self, servo: Servo) {
        self.identifications().for_each(|i| i.behind(servo));
        let of_speeds = self.models.iter_mut().flatten().map(|m| &mut m.verdict);
        of_speeds.chain([&mut self.verdict]).for_each(Verdict::lag_is_known);
    }

    fn refused(reason: Reason) -> Self {
        Self { models: None, law: None, model: None, verdict: Verdict::refused(reason) }
    }
}

/// The model of each speed, where manoeuvres are found, else one of the whole. `proposals` are the manoeuvres, where they are known.
fn models_of(
    log: &OpenedLog,
    options: &Options,
    proposals: Option<Vec<Proposal>>,
    observer: &mut dyn Observer,
) -> Result<LogModels, Error> {
    let settings = &options.settings;
    let whole = || one_model(log, Window::ALL, None, options);
    if log.description.aircraft.is_some() || settings.as_paper || options.axis == Axis::Pitch {
        return whole();
    }
    if is_ordinary_steering(&log.record.samples) {
        return whole();
    }
    let models = match proposals {
        Some(proposals) => identify_proposals(log, proposals, settings, observer)?,
        None => identify_speeds(log, settings, observer)?,
    };
    match models {
        Some(mut models) => Ok(LogModels {
            law: share_over_speed(&mut models),
            model: foremost(&models).and_then(|model| model.identification.clone().map(Box::new)),
            verdict: whole_verdict(&models),
            models: Some(models),
        }),
        None => whole(),
    }
}

/// One model of the training window.
fn one_model(
    log: &OpenedLog,
    training: Window,
    data: Option<ValidationData>,
    options: &Options,
) -> Result<LogModels, Error> {
    if let Some(aircraft) = &log.description.aircraft {
        return Ok(LogModels::refused(not_a_vessel(aircraft)));
    }
    let record = &log.record;
    let found = match options.axis {
        Axis::Yaw => identify(record, training, data, &options.settings),
        Axis::Pitch => pitch::identify(record, training, data),
    };
    match found {
        Ok(identification) => Ok(LogModels {
            models: None,
            law: None,
            verdict: identification.verdict.clone(),
            model: Some(Box::new(identification)),
        }),
        Err(IdentifyError::Refused(reason)) => Ok(LogModels::refused(reason)),
        Err(error) => Err(no_model(log, error)),
    }
}

/// The log is of what does not steer in the water.
fn not_a_vessel(aircraft: &str) -> Reason {
    let text = format!("This is the log of {aircraft}, which has no rudder in the water.");
    Reason {
        action: "Use the log of a boat, a ship or an underwater vehicle.".into(),
        ..Reason::new(ReasonCode::NotAVessel, text)
    }
}

impl IdentifiedLog {
    /// The model, or the surest of several. `None` where the data refused one; the verdict says why.
    pub fn identification(&self) -> Option<&Identification> {
        self.model.as_deref()
    }

    /// The law over speed by which the models borrow from each other, for people.
    pub fn law_text(&self) -> Option<String> {
        let first = self.models.as_ref()?.first()?;
        let unit = match first.surge_speed_m_s {
            Some(_) => "u in m/s",
            None => "u the thrust, 1 is full",
        };
        Some(format!("{}, {unit}: speeds with little excitation borrow from the others", self.law?))
    }

    /// May the models be used? Of several it is no better than the verdict on any of those that may be.
    pub fn verdict(&self) -> &Verdict {
        &self.verdict
    }
}

/// Why there is no model.
pub fn no_model(log: &OpenedLog, error: IdentifyError) -> Error {
    let said = |text: &str| format!("{}: {text}", log.path.display());
    match error {
        IdentifyError::Setting(error) => Error::Setting(error.to_string()),
        IdentifyError::Refused(reason) => Error::Rejected(said(reason.measured())),
        _ => Error::Input(said(&error.to_string())),
    }
}
