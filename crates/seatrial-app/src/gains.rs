//! Gains, feed-forward and margins of the heading controller, from models and between them.
//!
//! ```no_run
//! use std::path::Path;
//!
//! use seatrial_app::gains::LoopRequirements;
//! use seatrial_app::models::of_schedule_file;
//!
//! let models = of_schedule_file(Path::new("schedule.toml"))?;
//! for point in LoopRequirements::default().gains(&models)?.points {
//!     println!("{:?} m/s: {:?}", point.surge_speed_m_s, point.proportional_gain);
//! }
//! # Ok::<(), seatrial_app::Error>(())
//! ```

use seatrial::gains::export::{OperatingPoint, Schedule};
use seatrial::gains::{DAMPING_RATIO, least_damped_schedule, longest};
use seatrial::{CourseChange, GainAllowance};
use seatrial_core::RudderUnit;
use seatrial_core::heading_loop::{LoopTiming, Poles};
use seatrial_core::schedule::{Beyond, ScheduleError, ScheduleKey};
use seatrial_core::{GainSchedule, HeadingGain, HeadingLoop, SpeedSchedule, YawModel};
use serde::Serialize;

use crate::Error;
use crate::models::{Estimate, ModelPoint, Models, TrialOrigin, TuningPoint};

/// What is asked of the heading loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoopRequirements {
    /// Damping ratio of the closed loop.
    pub damping_ratio: f64,
    /// Dead time of compass, computer and rudder, s; without, what the record tells.
    pub delay_s: Option<f64>,
    /// Interval of a sampled controller, s; 0 is continuous; without, that of the record.
    pub interval_s: Option<f64>,
    /// A place in the schedule: a thrust as a fraction of full, or a speed, m/s.
    pub at: Option<(ScheduleKey, f64)>,
    /// What to do with a place beyond the identified range.
    pub beyond: Beyond,
}

impl Default for LoopRequirements {
    /// What `seatrial gains` takes without options: a damping ratio of 1/sqrt(2), and what the record tells of the loop.
    fn default() -> Self {
        Self {
            damping_ratio: DAMPING_RATIO,
            delay_s: None,
            interval_s: None,
            at: None,
            beyond: Beyond::Refuse,
        }
    }
}

/// `gains --json`.
#[derive(Clone, Debug, Serialize)]
pub struct HeadingGains {
    /// `seatrial.gains.v1`
    pub schema: &'static str,
    /// Where the models come from.
    pub source: String,
    /// Damping ratio of the closed loop.
    pub damping_ratio: f64,
    /// Full rudder, in `rudder_unit`.
    pub rudder_limit_rad: f64,
    /// In what the rudder is.
    pub rudder_unit: RudderUnit,
    /// The trial that the models are of.
    pub trial: Option<String>,
    /// Was the trial a rehearsal, whose gains are exported only when that is asked for?
    #[serde(skip)]
    pub is_rehearsal: bool,
    /// Why the models are not to be used, where the source says so.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub rejected: Vec<String>,
    /// What a course change will do with these gains, where the source knows it and they are its own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub first_answer: Option<CourseChange>,
    /// What the loop waits for: the longest of the points.
    pub timing: LoopTiming<f64>,
    /// Gains of each model.
    pub points: Vec<PointGains>,
    /// The gain at the place that is asked for.
    pub at: Option<InterpolatedGain>,
}

/// Gains of one model.
#[derive(Clone, Debug, Serialize)]
pub struct PointGains {
    /// Thrust as a fraction of full.
    pub thrust: Option<f64>,
    /// Forward speed, m/s.
    pub surge_speed_m_s: Option<f64>,
    /// The model.
    #[serde(flatten)]
    pub model: YawModel<f64>,
    /// Nomoto's time constant, s.
    pub nomoto_t_s: Option<Estimate>,
    /// Nomoto's gain, 1/s.
    pub nomoto_k_per_s: Option<Estimate>,
    /// Why there is no gain.
    pub refused: Option<String>,
    /// The gain to load, rudder per heading error.
    pub proportional_gain: Option<Estimate>,
    /// What it allows for.
    pub allowance: GainAllowance,
    /// The paper's gain, which allows for nothing.
    pub gain_of_57: Option<Estimate>,
    /// The rudder that holds a constant heading, rad.
    pub feed_forward_rudder_rad: Option<Estimate>,
    /// The closed loop under the gain to load.
    #[serde(rename = "loop")]
    pub closed_loop: Option<LoopFigures>,
}

/// The closed loop at a fixed gain.
#[derive(Clone, Debug, Serialize)]
pub struct LoopFigures {
    /// Its poles, 1/s.
    pub poles_per_s: Poles<f64>,
    /// Damping ratio.
    pub damping_ratio: Option<Estimate>,
    /// Natural frequency, rad/s.
    pub natural_frequency_rad_s: Option<Estimate>,
    /// Overshoot of a step as a fraction of it.
    pub overshoot: Option<Estimate>,
    /// A factor; null is infinite.
    pub gain_margin: Option<Estimate>,
    /// Phase margin, rad.
    pub phase_margin_rad: Option<Estimate>,
    /// Delay margin, s.
    pub delay_margin_s: Option<Estimate>,
}

/// The gain at a place in the schedule.
#[derive(Clone, Debug, Serialize)]
pub struct InterpolatedGain {
    /// Thrust or speed.
    pub key: ScheduleKey,
    /// How much of it, as a fraction of full or in m/s.
    pub value: f64,
    /// Is it beyond the identified range?
    pub extrapolated: bool,
    /// Rudder per heading error.
    pub proportional_gain: Estimate,
    /// The rudder that holds a constant heading, rad.
    pub feed_forward_rudder_rad: f64,
    /// The closed loop with the model at the place.
    #[serde(rename = "loop")]
    pub closed_loop: Option<LoopFigures>,
}

/// Half of the last figure in which speeds are printed, m/s.
const PRINTED_M_S: f64 = 0.005;

impl LoopRequirements {
    /// With a speed beyond the models' range that a table prints as an end of it taken as that end.
    fn as_printed(&self, models: &Models) -> Self {
        let speeds = models.points.iter().filter_map(|p| p.point.surge_speed_m_s);
        let low = speeds.clone().fold(f64::INFINITY, f64::min);
        let high = speeds.fold(f64::NEG_INFINITY, f64::max);
        let at = self.at.map(|(key, value)| {
            let inside = value.max(low).min(high);
            let is_printed_so = (inside - value).abs() <= PRINTED_M_S;
            match key == ScheduleKey::Speed && is_printed_so {
                true => (key, inside),
                false => (key, value),
            }
        });
        Self { at, ..*self }
    }

    /// The models with the delay and the interval that are wanted.
    fn timed(&self, models: &Models) -> Models {
        let mut models = models.clone();
        for point in &mut models.points {
            let timing = &mut point.allowance.timing;
            timing.delay_s = self.delay_s.unwrap_or(timing.delay_s);
            if let Some(interval_s) = self.interval_s {
                timing.sample_interval_s = (interval_s != 0.0).then_some(interval_s);
            }
        }
        models
    }

    /// Are the gains those that the source of accepted models judged?
    fn is_of(&self, models: &Models) -> bool {
        let is_usual = self.damping_ratio == DAMPING_RATIO;
        let is_timed = self.delay_s.is_some() || self.interval_s.is_some();
        models.rejected.is_empty() && is_usual && !is_timed
    }

    /// Gains, feed-forward and margins of each model. A model that allows no gain says so in
    /// [`refused`](PointGains::refused).
    ///
    /// # Errors
    /// A setting that no model could satisfy, or a place outside the models' range.
    pub fn gains(&self, models: &Models) -> Result<HeadingGains, Error> {
        let models = &self.timed(models);
        let timing = longest(models.points.iter().map(|point| point.allowance));
        self.check(timing)?;
        let points = models.points.iter();
        Ok(HeadingGains {
            schema: "seatrial.gains.v1",
            source: models.origin.clone(),
            damping_ratio: self.damping_ratio,
            rudder_limit_rad: models.rudder_limit_rad,
            rudder_unit: models.rudder_unit,
            trial: models.trial.as_ref().map(TrialOrigin::text),
            is_rehearsal: models.trial.as_ref().is_some_and(|trial| trial.is_rehearsal),
            rejected: models.rejected.clone(),
            first_answer: models.promised.filter(|_| self.is_of(models)),
            timing,
            points: points.map(|p| point_gains(p, self.damping_ratio)).collect(),
            at: self.as_printed(models).interpolated(models)?,
        })
    }

    /// The gains of all models, for a controller that looks them up.
    ///
    /// # Errors
    /// A model that allows no gain.
    pub fn schedule(&self, models: &Models) -> Result<Schedule, Error> {
        let models = &self.timed(models);
        for point in &models.points {
            self.check_gain(models, point)?;
        }
        models.gain_schedule(self.damping_ratio)
    }

    /// One set of gains: at the place that is asked for, else of the fastest model.
    ///
    /// # Errors
    /// A model that allows no gain, or a place outside the models' range.
    pub fn operating_point(&self, models: &Models) -> Result<OperatingPoint, Error> {
        let models = &self.timed(models);
        let at = self.as_printed(models).at;
        let tuned = match (at, models.points.as_slice()) {
            (Some((key, value)), _) => {
                let refused = |error| self.no_such_place(key, value, error);
                let model = models.schedule(key)?.lookup(value, self.beyond).map_err(refused)?;
                let (cautious, timing) = cautious(models, key)?;
                let cautious = cautious.lookup(value, self.beyond).map_err(refused)?;
                let allowance = GainAllowance {
                    damping_per_s: cautious.value().model.a22_per_s - model.value().model.a22_per_s,
                    timing,
                };
                TuningPoint { at: *model.value(), allowance, covariance: None }
            }
            (None, [.., fastest]) => {
                self.check_gain(models, fastest)?;
                TuningPoint::from(fastest)
            }
            (None, []) => return Err(Error::Input(format!("{}: no model", models.origin))),
        };
        models.operating_point(&tuned, self.damping_ratio)
    }

    /// Refuses settings that no model could satisfy.
    fn check(&self, timing: LoopTiming<f64>) -> Result<(), Error> {
        let stable = YawModel::from_theta([-1.0, 1.0, 0.0]);
        let zeta = self.damping_ratio;
        HeadingGain::design(&stable, zeta)
            .map_err(|reason| Error::Setting(format!("--zeta {zeta}: {reason}")))?;
        HeadingLoop::new(&stable, 1.0)
            .and_then(|closed| closed.margins(timing))
            .map_err(|reason| Error::Setting(format!("--delay, --interval: {reason}")))?;
        Ok(())
    }

    /// Refuses a model without a gain.
    fn check_gain(&self, models: &Models, point: &ModelPoint) -> Result<(), Error> {
        let gain = point.allowance.design(&point.point.model, self.damping_ratio);
        let (origin, name) = (&models.origin, point.name());
        let refused = |reason| Error::Input(format!("{origin}: no gain for {name}: {reason}"));
        gain.map(drop).map_err(refused)
    }

    fn no_such_place(&self, key: ScheduleKey, value: f64, error: ScheduleError) -> Error {
        let hint = match self.beyond {
            Beyond::Extrapolate => "",
            Beyond::Refuse => " (--extrapolate allows it)",
        };
        Error::Setting(format!("{} {value}: {error}{hint}", key.name()))
    }

    fn interpolated(&self, models: &Models) -> Result<Option<InterpolatedGain>, Error> {
        let Some((key, value)) = self.at else {
            return Ok(None);
        };
        let zeta = self.damping_ratio;
        let schedule = models.schedule(key)?;
        let refused = |error| self.no_such_place(key, value, error);
        let (cautious, timing) = cautious(models, key)?;
        let gains = GainSchedule::design(cautious, zeta, timing)
            .map_err(|error| Error::Input(format!("{}: {} {error}", models.origin, key.name())))?;
        let gain = gains.lookup(value, self.beyond).map_err(refused)?;
        let model = schedule.lookup(value, self.beyond).map_err(refused)?;
        let proportional_gain = gain.value().proportional_gain;
        let here = ModelPoint::exact(*model.value());
        Ok(Some(InterpolatedGain {
            key,
            value,
            extrapolated: gain.is_extrapolated(),
            proportional_gain: Estimate {
                value: proportional_gain,
                interval_95: interpolated_interval(zeta, models, key, value, proportional_gain),
            },
            feed_forward_rudder_rad: gain.value().feed_forward_rudder_rad,
            closed_loop: loop_figures(&here, proportional_gain, timing),
        }))
    }
}

impl HeadingGains {
    /// Is there a model without a gain, or do the models contradict each other?
    pub fn is_refused(&self) -> bool {
        !self.rejected.is_empty() || self.points.iter().any(|point| point.refused.is_some())
    }
}

impl HeadingGains {
    /// Where not even the sign of a gain is known, in words.
    pub fn unsure(&self) -> Option<String> {
        let unsure = self.points.iter().filter(|p| p.sign_is_unknown());
        let places: Vec<String> = unsure
            .map(|p| match (p.thrust, p.surge_speed_m_s) {
                (Some(thrust), _) => format!("{:.0} % thrust", 100.0 * thrust),
                (None, Some(speed)) => format!("{speed:.2} m/s"),
                (None, None) => "the one speed".into(),
            })
            .collect();
        (!places.is_empty()).then(|| unsure_at(&places.join(", ")))
    }
}

/// What is said of a gain of which not even the sign is known.
pub(crate) fn unsure_at(places: &str) -> String {
    format!(
        "The interval of K_p holds 0 at {places}: do not use that gain; run that speed again with more rudder."
    )
}

impl PointGains {
    /// Does the interval of its gain hold 0, so that even its sign is not known?
    pub fn sign_is_unknown(&self) -> bool {
        let interval = self.proportional_gain.as_ref().and_then(|gain| gain.interval_95);
        interval.is_some_and(|[low, high]| low <= 0.0 && 0.0 <= high)
    }
}

/// The least damped models, for which gains are designed, and what their loops wait for.
fn cautious(
    models: &Models,
    key: ScheduleKey,
) -> Result<(SpeedSchedule<f64>, LoopTiming<f64>), Error> {
    let points = models.points.iter().map(|p| (p.point, p.allowance));
    least_damped_schedule(key, points)
        .map_err(|error| Error::Input(format!("{}: {error}", models.origin)))
}

fn point_gains(point: &ModelPoint, zeta: f64) -> PointGains {
    let model = point.point.model;
    let design = |model: &YawModel<f64>| point.allowance.design(model, zeta);
    let gain = design(&model);
    let of = |quantity: fn(HeadingGain<f64>) -> f64| {
        point.estimate(|model| Some(quantity(design(model).ok()?)))
    };
    let of_57 = |model: &YawModel<f64>| HeadingGain::design(model, zeta).ok();
    PointGains {
        thrust: point.point.thrust,
        surge_speed_m_s: point.point.surge_speed_m_s,
        model,
        nomoto_t_s: point.estimate(|model| Some(model.nomoto()?.t_s)),
        nomoto_k_per_s: point.estimate(|model| Some(model.nomoto()?.k_per_s)),
        refused: gain.err().map(|reason| reason.to_string()),
        proportional_gain: of(|gain| gain.proportional_gain),
        allowance: point.allowance,
        gain_of_57: point.estimate(|model| Some(of_57(model)?.proportional_gain)),
        feed_forward_rudder_rad: of(|gain| gain.feed_forward_rudder_rad),
        closed_loop: gain
            .ok()
            .and_then(|gain| loop_figures(point, gain.proportional_gain, point.allowance.timing)),
    }
}

fn loop_figures(point: &ModelPoint, gain: f64, timing: LoopTiming<f64>) -> Option<LoopFigures> {
    let closed = |model: &YawModel<f64>| HeadingLoop::new(model, gain).ok();
    let margins = |model: &YawModel<f64>| closed(model)?.margins(timing).ok();
    Some(LoopFigures {
        poles_per_s: closed(&point.point.model)?.poles(),
        damping_ratio: point.estimate(|model| Some(closed(model)?.damping_ratio())),
        natural_frequency_rad_s: point
            .estimate(|model| Some(closed(model)?.natural_frequency_rad_s())),
        overshoot: point.estimate(|model| Some(closed(model)?.overshoot())),
        gain_margin: point.estimate(|model| margins(model)?.gain_margin),
        phase_margin_rad: point.estimate(|model| margins(model)?.phase_margin_rad),
        delay_margin_s: point.estimate(|model| margins(model)?.delay_margin_s),
    })
}

/// The half widths of the two neighbours, weighted by their distance; their runs err independently.
fn interpolated_interval(
    zeta: f64,
    source: &Models,
    key: ScheduleKey,
    value: f64,
    gain: f64,
) -> Option<[f64; 2]> {
    let mut known: Vec<(f64, f64)> = source
        .points
        .iter()
        .filter_map(|point| {
            let design = |model: &YawModel<f64>| point.allowance.design(model, zeta).ok();
            let estimate = point.estimate(|model| Some(design(model)?.proportional_gain))?;
            let [low, high] = estimate.interval_95?;
            Some((point.point.key(key)?, (high - low) / 2.0))
        })
        .collect();
    if known.len() < source.points.len() {
        return None;
    }
    known.sort_by(|a, b| a.0.total_cmp(&b.0));
    let pair =
        known.windows(2).find(|pair| value <= pair[1].0).or_else(|| known.windows(2).last())?;
    let fraction = (value - pair[0].0) / (pair[1].0 - pair[0].0);
    let half_width = libm::hypot((1.0 - fraction) * pair[0].1, fraction * pair[1].1);
    Some([gain - half_width, gain + half_width])
}
