//! Is the vehicle different? Tests with a stated false alarm rate, between two sets of models and along
//! mission logs: the use for early fault detection that the paper's introduction names (its reference 12).
//!
//! ```text
//! x = [a22'/a22 - 1,  b2'/b2 - 1,  (C0' - C0)/b2]
//! ```
//!
//! | symbol | identifier | unit |
//! |---|---|---|
//! | a22, b2, C0 | [`SpeedModel`] of the [`Reference`] | 1/s, 1/s^2, rad/s^2 |
//! | a22', b2', C0' | of the vehicle now, at the same speed | as above |
//! | x | [`Effects`]: damping, rudder authority, offset as an angle of the rudder | 1, 1, rad |
//!
//! The offset C0 follows wind, current and trim from one run to the next, and may be left out of a test.

mod cause;
mod change;
mod estimate;
mod not_compared;
mod pool;
mod watch;

use std::fmt;

use seatrial_core::schedule::{Beyond, ScheduleKey};
use seatrial_core::{SchedulePoint, SpeedSchedule, YawModel};
use serde::Serialize;

pub use cause::{Cause, Explanation};
pub use change::{Change, SpeedChange, compare};
pub use watch::{SkippedTime, Watch, WatchReport, WatchedWindow};

use crate::identification::Identification;
use crate::record::mean;
use crate::servo::Servo;
use not_compared::{NotCompared, Speeds};
use pool::ReferenceError;

/// A run of so many time constants of the vehicle determines the disturbance on it, and with it its own covariance,
/// as well as a quarter as many independent values would: with this, the tails of the test are right under disturbance
/// (`recover_rates_over_noise_and_disturbance`).
const TIME_CONSTANTS_PER_DEGREE_OF_FREEDOM: f64 = 4.0;
const LEAST_DEGREES_OF_FREEDOM: f64 = 5.0;

/// Speeds up to this share beyond the reference are scaled to it: a22 as u, b2 and C0 as u^2.
const LARGEST_SPEED_SCALING: f64 = 0.1;

/// Speeds that differ by less than this share are the same.
const SAME_SPEED: f64 = 0.03;

/// A test that would miss a rudder or an inertia changed by more than this cannot tell anything.
const LARGEST_UNSEEN_CHANGE: f64 = 0.3;

/// A model at one speed and how sure it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedModel {
    /// Thrust as a fraction of full.
    pub thrust: Option<f64>,
    /// Forward speed, m/s.
    pub surge_speed_m_s: Option<f64>,
    /// The model.
    pub model: YawModel<f64>,
    /// Covariance of [a22, b2, C0]; all 0 for a model that counts as exact.
    pub covariance: [[f64; 3]; 3],
    /// As of how many independent values the covariance is known.
    pub degrees_of_freedom: f64,
    /// Lag of the rudder that the model is behind, s; 0 where none was found.
    pub rudder_lag_s: f64,
}

impl SpeedModel {
    /// The model of an identification. `None` without a refined estimate, whose covariance the test needs.
    ///
    /// ```
    /// use seatrial::Window;
    /// use seatrial::health::SpeedModel;
    /// use seatrial::identify::{IdentifySettings, identify};
    ///
    /// # let vehicle = seatrial_core::YawModel::from_theta([-1.07, 1.08, 0.012]);
    /// # let mut state = seatrial_core::model::YawState::<f64>::default();
    /// # let sample = |k: u32| {
    /// #     let rudder_rad = match k % 330 { 40..80 => 0.26, 80..120 => -0.26, _ => 0.0 };
    /// #     let heading_rad = (1000.0 * state.heading_rad).round() / 1000.0;
    /// #     state = vehicle.advance(state, rudder_rad, 0.05);
    /// #     seatrial::Sample { time_s: 0.05 * f64::from(k), heading_rad, rudder_rad, ..Default::default() }
    /// # };
    /// # let record: seatrial::Record = (0..660).map(sample).collect();
    /// // Two doublets of 0.26 rad on a vehicle with a22 = -1.07 1/s, b2 = 1.08 1/s^2.
    /// let found = identify(&record, Window::ALL, None, &IdentifySettings::default())?;
    /// let at = SpeedModel::of(&found, Some(0.8), Some(1.6)).ok_or("a refined estimate")?;
    /// assert_eq!((at.model, at.rudder_lag_s), (found.model(), 0.0));
    /// // The paper's estimate has no covariance to test with.
    /// let paper = identify(&record, Window::ALL, None, &IdentifySettings::paper())?;
    /// assert_eq!(SpeedModel::of(&paper, Some(0.8), Some(1.6)), None);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn of(
        identification: &Identification,
        thrust: Option<f64>,
        surge_speed_m_s: Option<f64>,
    ) -> Option<Self> {
        let refined = identification.refined.as_ref()?;
        let duration_s = identification.training.to_s - identification.training.from_s;
        Some(Self {
            thrust,
            surge_speed_m_s,
            model: refined.model,
            covariance: refined.covariance,
            degrees_of_freedom: degrees_of_freedom(&refined.model, duration_s),
            rudder_lag_s: identification.lagging().map_or(0.0, |l| l.rudder_lag_s),
        })
    }

    fn has_thrust_of(&self, other: &Self) -> bool {
        self.thrust.zip(other.thrust).is_some_and(|(a, b)| (a - b).abs() < 1e-6)
    }

    /// The model scaled to a speed next to its own.
    fn scaled_to(&self, surge_speed_m_s: f64) -> YawModel<f64> {
        let ratio = self.surge_speed_m_s.map_or(1.0, |own| surge_speed_m_s / own);
        let [a22, b2, c0] = self.model.theta();
        YawModel::from_theta([a22 * ratio, b2 * ratio * ratio, c0 * ratio * ratio])
    }
}

/// As of how many independent values the covariance of a run is known.
///
/// ```
/// use seatrial::health::degrees_of_freedom;
/// use seatrial_core::YawModel;
///
/// let model = YawModel::from_theta([-1.0, 1.0, 0.0]);
/// // 80 time constants count as 20 values, a few as 5.
/// assert_eq!(degrees_of_freedom(&model, 80.0), 20.0);
/// assert_eq!(degrees_of_freedom(&model, 4.0), 5.0);
/// ```
pub fn degrees_of_freedom(model: &YawModel<f64>, duration_s: f64) -> f64 {
    (duration_s * model.a22_per_s.abs() / TIME_CONSTANTS_PER_DEGREE_OF_FREEDOM)
        .max(LEAST_DEGREES_OF_FREEDOM)
}

/// Why there is no test.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum HealthError {
    /// A setting is out of its range.
    #[error("{field} is {found}, expected {expected}")]
    Setting {
        /// Which one.
        field: &'static str,
        /// What it is.
        found: f64,
        /// What it has to be.
        expected: &'static str,
    },
    /// Models that are no reference.
    #[error("{0}")]
    Reference(String),
}

/// How to test.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct HealthSettings {
    false_alarm_rate: f64,
    tolerated_change: f64,
    offset_counts: bool,
}

impl HealthSettings {
    /// `false_alarm_rate`: how often an unchanged vehicle may be called changed, one answer of [`compare`] or of
    /// [`Watch::report`] counting once. Changes of a22 and b2 of up to `tolerated_change` are none. Without
    /// `offset_counts` C0 is not tested.
    ///
    /// ```
    /// use seatrial::health::HealthSettings;
    ///
    /// let error = HealthSettings::new(0.9, 0.1, true).expect_err("nine alarms in ten");
    /// assert!(error.to_string().starts_with("the false alarm rate is 0.9"));
    /// assert!(HealthSettings::new(0.01, 0.1, false).is_ok_and(|settings| !settings.offset_counts()));
    /// ```
    pub fn new(
        false_alarm_rate: f64,
        tolerated_change: f64,
        offset_counts: bool,
    ) -> Result<Self, HealthError> {
        if !(1e-6..=0.5).contains(&false_alarm_rate) {
            return Err(HealthError::Setting {
                field: "the false alarm rate",
                found: false_alarm_rate,
                expected: "a fraction from 0.000001 to 0.5",
            });
        }
        if !(0.0..=0.5).contains(&tolerated_change) {
            return Err(HealthError::Setting {
                field: "the tolerated change",
                found: tolerated_change,
                expected: "a fraction from 0 to 0.5",
            });
        }
        Ok(Self { false_alarm_rate, tolerated_change, offset_counts })
    }

    /// How often an unchanged vehicle may be called changed.
    pub fn false_alarm_rate(&self) -> f64 {
        self.false_alarm_rate
    }

    /// Changes of a22 and b2 up to this share are none.
    pub fn tolerated_change(&self) -> f64 {
        self.tolerated_change
    }

    /// Is C0 tested?
    pub fn offset_counts(&self) -> bool {
        self.offset_counts
    }

    fn parameters(&self) -> usize {
        if self.offset_counts { 3 } else { 2 }
    }
}

/// The models that the vehicle is compared with, one or several speeds.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    points: Vec<SpeedModel>,
    schedule: Option<SpeedSchedule<f64>>,
}

/// The reference at one speed.
#[derive(Clone, Debug, PartialEq)]
struct ReferencePoint {
    model: YawModel<f64>,
    /// Which points it comes from, and with which weight.
    weights: Vec<(usize, f64)>,
}

impl Reference {
    /// One model, or several of different speeds, or, where no speed is known, of different thrusts.
    ///
    /// ```
    /// use seatrial::health::Reference;
    ///
    /// assert!(Reference::new(Vec::new()).is_err());
    /// ```
    pub fn new(mut points: Vec<SpeedModel>) -> Result<Self, HealthError> {
        let refused = |text: &str| Err(HealthError::Reference(text.into()));
        if points.is_empty() {
            return refused("no model with an uncertainty to compare with");
        }
        for point in &points {
            let [a22, b2, c0] = point.model.theta();
            if a22 == 0.0 || b2 == 0.0 || ![a22, b2, c0].iter().all(|p| p.is_finite()) {
                return refused(
                    "a model whose a22 or b2 is 0 or not finite cannot be compared with",
                );
            }
        }
        if points.len() == 1 {
            return Ok(Self { points, schedule: None });
        }
        if points.iter().all(|point| point.surge_speed_m_s.is_none()) {
            let is_distinguished = |(index, point): (usize, &SpeedModel)| {
                point.thrust.is_some() && !points[..index].iter().any(|p| p.has_thrust_of(point))
            };
            return if points.iter().enumerate().all(is_distinguished) {
                Ok(Self { points, schedule: None })
            } else {
                refused("several models that neither speed nor thrust tells apart")
            };
        }
        let speed = |point: &SpeedModel| point.surge_speed_m_s.unwrap_or(0.0);
        points.sort_by(|a, b| speed(a).total_cmp(&speed(b)));
        let schedule: Vec<SchedulePoint<f64>> = points
            .iter()
            .map(|point| SchedulePoint {
                thrust: point.thrust,
                surge_speed_m_s: point.surge_speed_m_s,
                model: point.model,
            })
            .collect();
        let schedule = SpeedSchedule::new(ScheduleKey::Speed, &schedule)
            .map_err(|error| HealthError::Reference(error.to_string()))?;
        Ok(Self { points, schedule: Some(schedule) })
    }

    /// The models, slowest first.
    pub fn points(&self) -> &[SpeedModel] {
        &self.points
    }

    /// The mean lag of the rudder that the models are behind, where one was found.
    fn servo(&self) -> Option<Servo> {
        let lags = self.points.iter().map(|point| point.rudder_lag_s);
        Servo::new(0.0, mean(lags.filter(|lag_s| *lag_s > 0.0))?).ok()
    }

    fn errors(&self) -> Vec<ReferenceError> {
        self.points.iter().map(ReferenceError::of).collect()
    }

    /// The model at a speed, or why there is none.
    fn at_speed(&self, surge_speed_m_s: Option<f64>) -> Result<ReferencePoint, NotCompared> {
        let at_point = |index: usize, model| ReferencePoint { model, weights: vec![(index, 1.0)] };
        let known = |point: &SpeedModel| point.surge_speed_m_s.zip(surge_speed_m_s);
        if let ([only], None) = (self.points.as_slice(), self.points.first().and_then(known)) {
            return Ok(at_point(0, only.model));
        }
        let Some(speed) = surge_speed_m_s else {
            return Err(NotCompared::SpeedUnknown);
        };
        if self.points.len() > 1 && self.schedule.is_none() {
            return Err(NotCompared::ReferenceWithoutSpeed);
        }
        let speed_of = |index: usize| self.points[index].surge_speed_m_s.unwrap_or(speed);
        let last = self.points.len() - 1;
        let (slowest, fastest) = (speed_of(0), speed_of(last));
        let outer = if speed < slowest { 0 } else { last };
        if let Some(schedule) = self.schedule.filter(|_| (slowest..=fastest).contains(&speed)) {
            let model = schedule
                .lookup(speed, Beyond::Refuse)
                .map_err(NotCompared::OutsideSchedule)?
                .value()
                .model;
            let upper = self
                .points
                .partition_point(|p| p.surge_speed_m_s.is_some_and(|own| own < speed))
                .clamp(1, last);
            let fraction = (speed - speed_of(upper - 1)) / (speed_of(upper) - speed_of(upper - 1));
            return Ok(ReferencePoint {
                model,
                weights: vec![(upper - 1, 1.0 - fraction), (upper, fraction)],
            });
        }
        if (speed / speed_of(outer) - 1.0).abs() > LARGEST_SPEED_SCALING {
            return Err(NotCompared::TooFarInSpeed {
                share: LARGEST_SPEED_SCALING,
                speeds: Speeds { slowest, fastest: (last > 0).then_some(fastest) },
            });
        }
        Ok(at_point(outer, self.points[outer].scaled_to(speed)))
    }

    /// Was the speed of this model looked at: the one that the reference has for it?
    fn has_speed_of(&self, now: &SpeedModel) -> bool {
        let Some(speed) = now.surge_speed_m_s else {
            return false;
        };
        match self.points.iter().find(|point| point.has_thrust_of(now)) {
            Some(point) => {
                point.surge_speed_m_s.is_some_and(|own| (speed / own - 1.0).abs() < SAME_SPEED)
            }
            None => self.points.iter().all(|p| p.surge_speed_m_s.is_some()),
        }
    }

    /// The model at a thrust that was run, or else at a speed, or why there is none.
    fn at(&self, now: &SpeedModel) -> Result<ReferencePoint, NotCompared> {
        match self.points.iter().position(|p| p.has_thrust_of(now)) {
            Some(index) => {
                Ok(ReferencePoint { model: self.points[index].model, weights: vec![(index, 1.0)] })
            }
            None => self.at_speed(now.surge_speed_m_s),
        }
    }
}

/// What was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Finding {
    /// No change, and one worth knowing would have been seen.
    Unchanged,
    /// The vehicle is different.
    Changed,
    /// The data would not show a change worth knowing.
    CannotTell,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        self.serialize(f)
    }
}

/// A change and its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Effect {
    /// The change, a share of what it was, or rad.
    pub change: f64,
    /// `[low, high]`
    pub interval_95: [f64; 2],
}

/// What has changed by how much, from the reference to now.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Effects {
    /// a22, as a share of what it was.
    pub damping: Effect,
    /// b2, as a share of what it was.
    pub rudder: Effect,
    /// C0, as the angle that the rudder had to be deflected for it, rad. `None` where it is not tested.
    pub offset_rad: Option<Effect>,
}

/// The least change of one kind alone that would be found nine times in ten.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Detectable {
    /// Change of a22, as a share.
    pub damping: f64,
    /// Change of b2, as a share.
    pub rudder: f64,
    /// Change of a22 and b2 by one share, as more inertia changes them.
    pub inertia: f64,
    /// Change of C0, as an angle of the rudder, rad. `None` where it is not tested.
    pub offset_rad: Option<f64>,
}

impl Detectable {
    /// Is it worth an answer?
    fn is_enough(&self) -> bool {
        self.rudder.max(self.inertia) <= LARGEST_UNSEEN_CHANGE
    }

    /// `8 % in the rudder's effect, 12 % in the damping or 13 % in both (payload)`
    fn words(&self) -> String {
        let percent = |share: f64| format!("{:.0} %", (100.0 * share).ceil());
        let mut words = format!(
            "{} in the rudder's effect, {} in the damping",
            percent(self.rudder),
            percent(self.damping)
        );
        let both = format!("{} in both (payload)", percent(self.inertia));
        words += &match self.offset_rad {
            Some(offset) => format!(", {both} or {:.1} deg in the offset", offset.to_degrees()),
            None => format!(" or {both}"),
        };
        words
    }
}
