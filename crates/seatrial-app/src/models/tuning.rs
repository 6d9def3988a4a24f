//! What of models goes into the file of a controller.

use seatrial::GainAllowance;
use seatrial::gains::export::{OperatingPoint, Schedule};
use seatrial_core::{RudderUnit, SchedulePoint};

use super::{ModelPoint, Models};
use crate::Error;

/// The model that an autopilot without a gain schedule is tuned for.
#[derive(Clone, Copy, Debug)]
pub struct TuningPoint {
    /// Thrust, speed and model.
    pub at: SchedulePoint<f64>,
    /// What its gain allows for.
    pub allowance: GainAllowance,
    /// Covariance of [a22, b2, C0], where known.
    pub covariance: Option<[[f64; 3]; 3]>,
}

impl From<&ModelPoint> for TuningPoint {
    fn from(point: &ModelPoint) -> Self {
        Self { at: point.point, allowance: point.allowance, covariance: point.covariance }
    }
}

impl Models {
    /// What the file of an autopilot without a gain schedule is made of, in the autopilot's own unit: steering from -1 to 1.
    pub fn operating_point(
        &self,
        tuned: &TuningPoint,
        damping_ratio: f64,
    ) -> Result<OperatingPoint, Error> {
        let (full_rudder_rad, note) = self.full_steering()?;
        Ok(OperatingPoint {
            source: self.origin.clone(),
            at: tuned.at,
            damping_ratio,
            full_rudder_rad,
            seen_rudder_rad: self.seen_rudder_rad(),
            allowance: tuned.allowance,
            covariance: tuned.covariance,
            notes: self.notes().into_iter().chain(note).collect(),
        })
    }

    /// What the file of a controller with a gain schedule is made of.
    pub fn gain_schedule(&self, damping_ratio: f64) -> Result<Schedule, Error> {
        let points = self.points.iter();
        let models: Vec<_> = points.map(|p| (p.point, p.allowance)).collect();
        let schedule =
            Schedule::design(&self.origin, &models, damping_ratio, self.rudder_limit_rad)
                .map_err(|reason| Error::Input(format!("{}: no gain: {reason}", self.origin)))?;
        let full_rudder_rad = match self.rudder_unit {
            RudderUnit::Rad => self.full_rudder.map(|full| full.angle_rad),
            RudderUnit::FullRudder => Some(1.0),
        };
        Ok(schedule.with_full_rudder(full_rudder_rad).noting(self.notes()))
    }

    /// The largest rudder that every record has seen.
    fn seen_rudder_rad(&self) -> Option<f64> {
        let seen = |point: &ModelPoint| Some(point.valid_range?.largest_rudder());
        let seen: Option<Vec<f64>> = self.points.iter().map(seen).collect();
        seen?.into_iter().reduce(f64::min)
    }

    /// The rudder at full steering in the unit of the models, and what has to be known of it.
    pub fn full_steering(&self) -> Result<(f64, Option<String>), Error> {
        if self.rudder_unit == RudderUnit::FullRudder {
            return Ok((1.0, None));
        }
        if let Some(full) = self.full_rudder {
            let degrees = full.angle_rad.to_degrees();
            let note = format!(
                "full steering was ASSUMED to be {degrees:.1} degrees of rudder when the model was found; another angle gives the same steering"
            );
            return Ok((full.angle_rad, full.is_assumed.then_some(note)));
        }
        let is_autopilot = |vehicle: &str| vehicle.starts_with("mavlink:");
        match &self.trial {
            Some(trial) if is_autopilot(&trial.vehicle) => Err(Error::Setting(format!(
                "{}: the logbook does not say which rudder angle the trial took for full steering, and without it the parameters would be wrong; give the one of the trial with --full-rudder-deg DEG (35 where the trial was given none)",
                self.origin
            ))),
            _ => Ok((
                self.rudder_limit_rad,
                Some(format!(
                    "the rudder at full steering is not known and is taken to be the rudder limit, {:.1} degrees; if full steering is another angle, say --full-rudder-deg DEG",
                    self.rudder_limit_rad.to_degrees()
                )),
            )),
        }
    }

    /// What has to be known of the source.
    pub fn notes(&self) -> Vec<String> {
        let trial = self.trial.iter().map(|trial| trial.text());
        let against = self.cautions.iter().chain(&self.rejected);
        trial.chain(against.cloned()).collect()
    }
}
