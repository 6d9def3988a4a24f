//! An autopilot that is reached, and what is proposed for it.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use seatrial::FullRudder;
use seatrial_core::{CascadeSettings, Plan, RudderUnit, SchedulePoint};
use seatrial_links::autopilot::PutBack;

use super::{Control, GainsLease, Proposal, model_at, propose};
use crate::Error;
use crate::models::Models;
use crate::trials::order::{Change, Preflight, TrialVehicle, VehicleError};

/// A vehicle whose autopilot steers to headings by gains of its own, which a commission can try.
pub trait GainsVehicle: TrialVehicle {
    /// Reaches the vehicle and looks at it, without touching its controls. `stop` is set when the operator wants it back.
    fn reach(
        &self,
        plan: &Plan<f64>,
        stop: &Arc<AtomicBool>,
    ) -> Result<Box<dyn AutopilotContact>, VehicleError>;

    /// What a trial or a commission has changed on it and kept: each parameter as it is and as it was. Nothing is written.
    fn kept(&self, stop: &Arc<AtomicBool>) -> Result<RestoreFile, VehicleError>;

    /// Puts back what this file keeps, as `seatrial vehicle restore` does.
    fn put_back(&self, file: &Path, stop: &Arc<AtomicBool>) -> Result<RestoreResult, VehicleError>;
}

/// What a file keeps of an autopilot.
#[derive(Clone, Debug, PartialEq)]
pub struct RestoreFile {
    /// The file.
    pub file: PathBuf,
    /// What would be written.
    pub parameters: Vec<PutBack>,
    /// The mode, which is put back unless somebody has chosen another since.
    pub mode: Option<u32>,
}

/// What putting back has reached.
#[derive(Clone, Debug, PartialEq)]
pub struct RestoreResult {
    /// Is everything as it was, read back?
    pub is_complete: bool,
    /// In words.
    pub line: String,
    /// Each parameter before and now.
    pub parameters: Vec<PutBack>,
}

/// An autopilot that was looked at and not touched.
pub trait AutopilotContact {
    /// What must be so, and what is changed until the hand-back.
    fn preflight(&self) -> &Preflight;

    /// How it controls its heading at the speed or the thrust of a model; `None` where it did not say.
    fn control(&self, model: &SchedulePoint<f64>) -> Option<Control>;

    /// Its default speed, m/s, where it says one.
    fn default_speed_m_s(&self) -> Option<f64>;

    /// Its parameters that other settings change.
    fn changes(&self, to: &CascadeSettings<f64>) -> Vec<Change>;

    /// Takes it. Where this fails, it has been handed back.
    fn take(self: Box<Self>) -> Result<Box<dyn GainsLease>, VehicleError>;
}

/// What gains are wanted from and for.
#[derive(Clone, Debug)]
pub struct Request {
    /// The models, one of which gives the gains.
    pub models: Models,
    /// The plan whose envelope holds.
    pub plan: Plan<f64>,
    /// The speed whose model is taken, m/s; `None` is the autopilot's own.
    pub at_speed_m_s: Option<f64>,
    /// Size of the steps, rad.
    pub step_rad: f64,
}

/// Smallest and largest step, rad.
const STEPS_RAD: [f64; 2] = [0.087, 1.571];

/// Refuses steps that are too small or too large to tell anything.
pub fn check_step(step_rad: f64) -> Result<(), Error> {
    let [least, most] = STEPS_RAD;
    if (least..=most).contains(&step_rad) {
        return Ok(());
    }
    let deg = step_rad.to_degrees();
    Err(Error::Setting(format!("steps of {deg:.0} degrees: expected an angle from 5 to 90")))
}

impl Request {
    /// Refuses steps that the envelope does not allow, and ones that tell nothing.
    pub fn check(&self) -> Result<(), Error> {
        check_step(self.step_rad)?;
        let allowed_rad = self.plan.envelope.heading_excursion_max_rad;
        if self.step_rad < allowed_rad {
            return Ok(());
        }
        Err(Error::Setting(format!(
            "steps of {:.0} degrees: the envelope allows {:.0} degrees from the heading",
            self.step_rad.to_degrees(),
            allowed_rad.to_degrees()
        )))
    }

    /// The settings that the model gives for an autopilot.
    pub fn proposal(&self, reached: &dyn AutopilotContact) -> Result<Proposal, Error> {
        let models = &self.models;
        let point = model_at(models, self.at_speed_m_s, reached.default_speed_m_s())?;
        let control = reached.control(&point.point).ok_or_else(|| {
            Error::Rejected("the autopilot's steering gains were not read".into())
        })?;
        if !control.keeps_speed && point.point.thrust.is_none() {
            return Err(Error::Rejected(format!(
                "{}: the model says no thrust, and this autopilot keeps no speed: take the campaign of a trial on this vehicle",
                models.origin
            )));
        }
        propose(&point, models.full_steering()?.0, &control, self.step_rad)
            .map_err(|error| Error::Rejected(format!("{}: {error}", models.origin)))
    }
}

/// Models that a vehicle may be given gains from. Their rudder is in the angle that their trial took for full steering, else in the
/// one of the vehicle's link. Those of a rehearsal are refused unless they are asked for.
pub fn models_for(
    models: Models,
    is_rehearsal_asked: bool,
    full_rudder: Option<FullRudder>,
) -> Result<Models, Error> {
    models.unless_rehearsed(is_rehearsal_asked)?;
    if let Some(reason) = models.rejected.first() {
        return Err(Error::Rejected(format!("{}: {reason}", models.origin)));
    }
    let models = match (models.full_rudder, models.rudder_unit) {
        (Some(_), _) | (None, RudderUnit::FullRudder) => models,
        (None, RudderUnit::Rad) => {
            models.with_full_rudder(full_rudder.map(|full| full.angle_rad))?
        }
    };
    models.limited(None)
}
