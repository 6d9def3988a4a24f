//! Where a model or a schedule of models comes from: numbers, a schedule file, a document, a campaign.

mod document;
mod of_record;
mod schedule_file;
mod statement;
mod tuning;

use std::path::Path;

use seatrial::identification::{SteadyTurn, ValidRange, interval_95};
use seatrial::motions::surge::SurgeModel;
use seatrial::{CourseChange, FullRudder, GainAllowance};
use seatrial_core::schedule::ScheduleKey;
use seatrial_core::{RudderUnit, SchedulePoint, SpeedSchedule, YawModel};
use serde::{Deserialize, Serialize};

use crate::Error;

pub use document::{of_document, of_document_alone, of_document_text};
pub use schedule_file::{SCHEDULE_FILE_HELP, of_schedule_file, write_schedule_file};
pub use tuning::TuningPoint;

/// The rudder limit where nobody gives one: the paper's, rad.
const DEFAULT_RUDDER_LIMIT_RAD: f64 = 0.26;

/// Models with their uncertainty.
#[derive(Clone, Debug)]
pub struct Models {
    /// For people.
    pub origin: String,
    /// At least one.
    pub points: Vec<ModelPoint>,
    /// Largest rudder angle, rad.
    pub rudder_limit_rad: f64,
    /// In what that and the rudder of the models are.
    pub rudder_unit: RudderUnit,
    /// The rudder at full steering with which the models were found, where it is known.
    pub full_rudder: Option<FullRudder>,
    /// The trial that the models are of.
    pub trial: Option<TrialOrigin>,
    /// How the speed follows the thrust, where a trial tells it.
    pub surge: Option<SurgeModel>,
    /// What has to be known before they are used.
    pub cautions: Vec<String>,
    /// Why the newest campaign of the logbook is not the one.
    pub passed_over: Option<String>,
    /// What the source itself says against its models.
    pub rejected: Vec<String>,
    /// What a course change will do with the gains of all of them and this rudder limit, as the source found it.
    pub promised: Option<CourseChange>,
}

/// A trial that models come from.
#[derive(Clone, Debug, PartialEq)]
pub struct TrialOrigin {
    /// Its number in the logbook.
    pub number: Option<i64>,
    /// The vehicle as given on the command line.
    pub vehicle: String,
    /// Name of the configuration (payload).
    pub configuration: String,
    /// When it began, UTC, ISO 8601.
    pub started: Option<String>,
    /// The version of seatrial that ran it.
    pub software_version: String,
    /// Was it run on a simulator?
    pub is_rehearsal: bool,
    /// The file of the faults that the simulator played.
    pub scenario: Option<String>,
}

impl TrialOrigin {
    /// Which trial it was, in a line for people.
    pub fn text(&self) -> String {
        let mut text = match self.number {
            Some(number) => format!("Campaign {number}"),
            None => "Trial".into(),
        };
        text += &format!(" on vehicle {}, configuration {}", self.vehicle, self.configuration);
        if let Some(started) = &self.started {
            text += &format!(", {started}");
        }
        text += &format!(", seatrial {}", self.software_version);
        if self.is_rehearsal {
            text += "; REHEARSAL on a simulator, not measured on a vehicle";
        }
        if let Some(scenario) = &self.scenario {
            text += &format!(", with the faults of {scenario}");
        }
        text
    }
}

/// A model with its uncertainty.
#[derive(Clone, Copy, Debug)]
pub struct ModelPoint {
    /// Thrust, speed and model.
    pub point: SchedulePoint<f64>,
    /// Covariance of [a22, b2, C0].
    pub covariance: Option<[[f64; 3]; 3]>,
    /// What a gain for this model allows for.
    pub allowance: GainAllowance,
    /// Heading noise, rad, and yaw acceleration disturbance, rad/s^2, found on its record.
    pub noise: Option<[f64; 2]>,
    /// Over what rudder, headings, speeds and frequencies it was seen.
    pub valid_range: Option<ValidRange>,
    /// Lag of the rudder that the model is behind, s; 0 where none was found.
    pub rudder_lag_s: f64,
    /// The steady turns that the hypotheses have, where the model is not made of them.
    pub steady_turn: Option<SteadyTurn>,
}

/// A value and how sure it is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema), schema(as = Figure))]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// Its 95 % interval, low and high.
    pub interval_95: Option<[f64; 2]>,
}

impl ModelPoint {
    /// A model whose uncertainty nobody knows.
    pub fn exact(point: SchedulePoint<f64>) -> Self {
        Self {
            point,
            covariance: None,
            allowance: GainAllowance::default(),
            noise: None,
            valid_range: None,
            rudder_lag_s: 0.0,
            steady_turn: None,
        }
    }

    fn is_usable(&self) -> bool {
        let keys = [self.point.thrust, self.point.surge_speed_m_s];
        self.point.model.theta().iter().all(|p| p.is_finite())
            && keys.iter().flatten().all(|k| k.is_finite() && *k > 0.0)
    }

    /// A quantity of the model with its interval. `None` where the model has no such quantity.
    pub fn estimate(&self, quantity: impl Fn(&YawModel<f64>) -> Option<f64>) -> Option<Estimate> {
        let value = quantity(&self.point.model).filter(|value| value.is_finite())?;
        let interval = |covariance| interval_95(&self.point.model, covariance, &quantity);
        Some(Estimate { value, interval_95: self.covariance.as_ref().and_then(interval) })
    }

    /// `80 %`, `1.63 m/s` or `model` for messages.
    pub fn name(&self) -> String {
        place(self.point.thrust, self.point.surge_speed_m_s)
    }
}

/// Thrust or speed of a model, as people call it.
fn place(thrust: Option<f64>, surge_speed_m_s: Option<f64>) -> String {
    match (thrust, surge_speed_m_s) {
        (Some(thrust), _) => format!("{:.0} % thrust", thrust * 100.0),
        (None, Some(speed)) => format!("{speed:.2} m/s"),
        (None, None) => "the model".into(),
    }
}

impl Models {
    /// A single model that was given in numbers.
    pub fn given(model: YawModel<f64>, surge_speed_m_s: Option<f64>) -> Self {
        Self {
            origin: "the model given".into(),
            points: vec![ModelPoint::exact(SchedulePoint { thrust: None, surge_speed_m_s, model })],
            rudder_limit_rad: DEFAULT_RUDDER_LIMIT_RAD,
            rudder_unit: RudderUnit::Rad,
            full_rudder: None,
            trial: None,
            cautions: Vec::new(),
            surge: None,
            passed_over: None,
            rejected: Vec::new(),
            promised: None,
        }
    }

    /// Checked, with this rudder limit where one is given, slowest first.
    pub fn limited(mut self, rudder_limit_rad: Option<f64>) -> Result<Self, Error> {
        if let Some(limit_rad) = rudder_limit_rad
            && limit_rad != self.rudder_limit_rad
        {
            self.rudder_limit_rad = limit_rad;
            self.promised = None;
        }
        if !(self.rudder_limit_rad > 0.0 && self.rudder_limit_rad.is_finite()) {
            return Err(Error::Setting(format!(
                "rudder limit {} rad: expected a positive angle",
                self.rudder_limit_rad
            )));
        }
        if let Some(point) = self.points.iter().find(|point| !point.is_usable()) {
            return Err(Error::Input(format!(
                "{}: {}: a22, b2 and C0 must be finite, speed and thrust positive",
                self.origin,
                point.name()
            )));
        }
        let key = |p: &ModelPoint| p.point.thrust.or(p.point.surge_speed_m_s).unwrap_or(0.0);
        self.points.sort_by(|a, b| key(a).total_cmp(&key(b)));
        Ok(self)
    }

    /// What the source says against its models, and where they are used beyond what they were seen for.
    pub fn warnings(&self) -> Vec<String> {
        let against = self.cautions.iter().chain(&self.rejected).cloned();
        against.chain(self.beyond_range()).chain(self.passed_over.clone()).collect()
    }

    /// Where the rudder limit or the speed is beyond what a model was seen with, in words.
    pub fn beyond_range(&self) -> Vec<String> {
        let beyond = |point: &ModelPoint| {
            let range = point.valid_range?;
            let rudder = range.beyond_rudder(self.rudder_limit_rad, self.rudder_unit);
            let speed_m_s = point.point.surge_speed_m_s;
            let speed = speed_m_s.and_then(|speed_m_s| range.beyond_speed(speed_m_s));
            let name = point.name();
            let named = move |beyond: String| format!("{name}: {beyond}");
            Some([rudder, speed].into_iter().flatten().map(named))
        };
        self.points.iter().filter_map(beyond).flatten().collect()
    }

    /// With the rudder at full steering, where one is given, rad. One that the source knows cannot be changed: its models
    /// were found with it.
    pub fn with_full_rudder(mut self, full_rudder_rad: Option<f64>) -> Result<Self, Error> {
        let Some(angle_rad) = full_rudder_rad else {
            return Ok(self);
        };
        if !(angle_rad > 0.0 && angle_rad < std::f64::consts::FRAC_PI_2) {
            return Err(Error::Setting(format!(
                "--full-rudder-deg {}: expected an angle above 0 and below 90 degrees",
                angle_rad.to_degrees()
            )));
        }
        if self.rudder_unit == RudderUnit::FullRudder {
            return Err(Error::Setting(format!(
                "{}: its rudder is a fraction of full, so that no angle is needed: leave --full-rudder-deg out",
                self.origin
            )));
        }
        match self.full_rudder {
            Some(known) if (known.angle_rad - angle_rad).abs() > 1e-6 => {
                Err(Error::Setting(format!(
                    "{}: its models were found with full steering at {:.1} degrees of rudder; gains for another angle need a trial with it: leave --full-rudder-deg out",
                    self.origin,
                    known.angle_rad.to_degrees()
                )))
            }
            _ => {
                self.full_rudder = Some(FullRudder { angle_rad, is_assumed: false });
                Ok(self)
            }
        }
    }

    /// Refuses models of a rehearsal, unless they are asked for: they are not for a vehicle.
    pub fn unless_rehearsed(&self, is_asked: bool) -> Result<(), Error> {
        match &self.trial {
            Some(trial) if trial.is_rehearsal && !is_asked => Err(Error::Setting(format!(
                "{}: a rehearsal on the simulator {}, whose gains are not those of a vehicle; --rehearsal takes them all the same",
                self.origin, trial.vehicle
            ))),
            _ => Ok(()),
        }
    }

    /// The models as a schedule by this key.
    pub fn schedule(&self, key: ScheduleKey) -> Result<SpeedSchedule<f64>, Error> {
        let points: Vec<SchedulePoint<f64>> = self.points.iter().map(|p| p.point).collect();
        SpeedSchedule::new(key, &points)
            .map_err(|error| Error::Input(format!("{}: {error}", self.origin)))
    }
}

fn read_text(path: &Path) -> Result<String, Error> {
    std::fs::read_to_string(path)
        .map_err(|error| Error::Input(format!("{}: {error}", path.display())))
}

/// A rudder at full steering that a source states.
fn given(full_rudder_rad: Option<f64>) -> Option<FullRudder> {
    full_rudder_rad.map(|angle_rad| FullRudder { angle_rad, is_assumed: false })
}

/// Where the rudder is a fraction of full, so is its limit.
fn limit_or_default(limit: Option<f64>, unit: RudderUnit) -> f64 {
    limit.unwrap_or(match unit {
        RudderUnit::Rad => DEFAULT_RUDDER_LIMIT_RAD,
        RudderUnit::FullRudder => 1.0,
    })
}
