//! What is proposed for a vehicle, from one of its models.

use seatrial::gains::commission::{
    Evidence, Foreseen, MOST_REPEATS, NoProposal, StepTest, foresee, propose as designed,
};
use seatrial_core::{CascadeSettings, SchedulePoint, YawModel};

use super::step_run::Patience;
use crate::Error;
use crate::models::{ModelPoint, Models};

/// Lag of a rudder where nothing tells it, s.
const ORDINARY_LAG_S: f64 = 0.1;
/// Noise of an autopilot's yaw rate where nothing tells it, rad/s, and of its heading, rad.
const RATE_NOISE_RAD_S: f64 = 0.006;
/// The least that it is taken for under way, rad/s, where a still vehicle has told it.
const LEAST_RATE_NOISE_RAD_S: f64 = 0.002;
const HEADING_NOISE_RAD: f64 = 0.005;
/// A model without intervals is taken for known to this share.
const UNKNOWN: f64 = 0.1;
/// Times that steps are held, s.
const SHORTEST_HOLD_S: f64 = 8.0;
const LONGEST_HOLD_S: f64 = 60.0;
/// What foreseen boats settle for at least before their first step, s.
const SETTLE_S: f64 = 5.0;

/// How the autopilot controls its heading, as it was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Control {
    /// Its settings.
    pub settings: CascadeSettings<f64>,
    /// Between two of its loops, s.
    pub loop_interval_s: f64,
    /// Between two samples of the record, s.
    pub sample_interval_s: f64,
    /// What the outputs make of the controller's steering at the model's speed.
    pub output_scale: f64,
    /// The share of its steering that the model's thrust takes.
    pub steering_taken: f64,
    /// Does it keep a speed by itself, or a thrust?
    pub keeps_speed: bool,
    /// White noise of its yaw rate, rad/s, where no engine and no wave shakes it more under way.
    pub rate_noise_rad_s: Option<f64>,
}

/// Other settings for a vehicle, and what is believed of it.
#[derive(Clone, Debug)]
pub struct Proposal {
    /// What the settings rest on.
    pub evidence: Evidence,
    /// How the autopilot was found.
    pub control: Control,
    /// The settings proposed.
    pub settings: CascadeSettings<f64>,
    /// The model, and the speed or thrust at which it was found.
    pub model: SchedulePoint<f64>,
    /// The steps by which both are tried.
    pub test: StepTest,
    /// The heading is averaged over so long, s.
    pub smoothing_s: f64,
    /// What the old settings are foreseen to do.
    pub old_foreseen: Foreseen,
    /// What the new ones are.
    pub new_foreseen: Foreseen,
}

impl Proposal {
    /// How long the steps take at most, s: with the old gains, a small one and with the new ones, each away and back once the
    /// vehicle has settled, and with steps that are repeated.
    pub fn duration_s(&self) -> f64 {
        let repeats = MOST_REPEATS as f64;
        let waits_s =
            (1.0 + repeats) * self.old_patience().longest_s + 2.0 * self.new_patience().longest_s;
        waits_s + 2.0 * (3.0 + repeats) * self.test.hold_s
    }

    /// How far the vehicle goes meanwhile at most, m, where its speed is known.
    pub fn distance_m(&self) -> Option<f64> {
        Some(self.duration_s() * self.model.surge_speed_m_s?)
    }

    /// How long it is waited for the vehicle to settle with its old gains.
    pub(super) fn old_patience(&self) -> Patience {
        Patience::with_known(&self.test, self.smoothing_s)
    }

    /// How long with the new ones.
    pub(super) fn new_patience(&self) -> Patience {
        Patience::with_new(&self.test, self.smoothing_s, &self.settings)
    }
}

/// The settings that a model gives, tried by steps of this size. `full_rudder_rad` is the rudder at full steering for which
/// the model was identified.
pub fn propose(
    point: &ModelPoint,
    full_rudder_rad: f64,
    control: &Control,
    step_rad: f64,
) -> Result<Proposal, NoProposal> {
    let evidence = evidence(point, full_rudder_rad * control.output_scale, control);
    let settings = designed(&evidence, &control.settings)?;
    let smoothing_s = 0.2 / settings.angle_gain_per_s;
    let (test, new_foreseen) = held_steps(&evidence, &settings, step_rad, control, smoothing_s);
    Ok(Proposal {
        old_foreseen: foresee(&evidence, &control.settings, &test, smoothing_s),
        new_foreseen,
        evidence,
        control: *control,
        settings,
        model: point.point,
        test,
        smoothing_s,
    })
}

/// Steps that are held for as long as boats with these settings take to settle, and what they are foreseen to do.
pub(super) fn held_steps(
    evidence: &Evidence,
    settings: &CascadeSettings<f64>,
    step_rad: f64,
    control: &Control,
    smoothing_s: f64,
) -> (StepTest, Foreseen) {
    let loops = (control.sample_interval_s / control.loop_interval_s).round().max(1.0);
    let longest = StepTest {
        step_rad,
        settle_s: SETTLE_S,
        hold_s: LONGEST_HOLD_S,
        sample_interval_s: loops * control.loop_interval_s,
        loop_interval_s: control.loop_interval_s,
    }
    .learnt(settings);
    let settled_s = foresee(evidence, settings, &longest, smoothing_s).settling_s.high;
    let test = StepTest {
        hold_s: (2.5 * settled_s + 2.0).clamp(SHORTEST_HOLD_S, LONGEST_HOLD_S),
        ..longest
    };
    (test, foresee(evidence, settings, &test, smoothing_s))
}

/// The model identified nearest to a speed, or the fastest where speeds are not known. It must not be faster than the
/// autopilot goes, m/s.
pub fn model_at(
    models: &Models,
    wanted_m_s: Option<f64>,
    highest_m_s: Option<f64>,
) -> Result<ModelPoint, Error> {
    let distance = |point: &ModelPoint| {
        let speeds = point.point.surge_speed_m_s.zip(wanted_m_s.or(highest_m_s));
        speeds.map_or(f64::INFINITY, |(speed, wanted)| (speed - wanted).abs())
    };
    let fits = |point: &&ModelPoint| {
        let speeds = point.point.surge_speed_m_s.zip(highest_m_s);
        speeds.is_none_or(|(speed, highest)| speed <= 1.02 * highest)
    };
    let found = models.points.iter().rev().filter(fits);
    let nearest = found.min_by(|a, b| distance(a).total_cmp(&distance(b)));
    nearest.copied().ok_or_else(|| {
        Error::Rejected(format!(
            "{}: every model is of a speed above the {:.2} m/s of the autopilot (WP_SPEED or CRUISE_SPEED): raise that, or run a trial at this speed",
            models.origin,
            highest_m_s.unwrap_or(f64::NAN)
        ))
    })
}

/// What is believed of a boat of this model, its rudder in fractions of full.
pub(super) fn evidence(point: &ModelPoint, full_rad: f64, control: &Control) -> Evidence {
    let model = point.point.model;
    let unit = [1.0, full_rad, 1.0];
    let stated = point.covariance.unwrap_or_else(|| {
        let mut covariance = [[0.0; 3]; 3];
        for (i, parameter) in model.theta().iter().enumerate() {
            covariance[i][i] = (0.5 * UNKNOWN * parameter).powi(2);
        }
        covariance
    });
    let covariance =
        std::array::from_fn(|i| std::array::from_fn(|j| unit[i] * unit[j] * stated[i][j]));
    let timing = point.allowance.timing;
    let lag_s = match timing.sample_interval_s {
        Some(interval_s) => (timing.delay_s - interval_s).max(0.0),
        None => ORDINARY_LAG_S,
    };
    Evidence {
        model: YawModel { b2_per_s2: model.b2_per_s2 * full_rad, ..model },
        covariance,
        lag_s,
        delay_s: control.loop_interval_s,
        rate_noise_rad_s: control
            .rate_noise_rad_s
            .map_or(RATE_NOISE_RAD_S, |noise| noise.max(LEAST_RATE_NOISE_RAD_S)),
        heading_noise_rad: point.noise.map_or(HEADING_NOISE_RAD, |[heading, _]| heading),
        disturbance_rad_s2: point.noise.map_or(0.0, |[_, disturbance]| disturbance),
        loop_interval_s: control.loop_interval_s,
        steering_taken: control.steering_taken,
    }
}
