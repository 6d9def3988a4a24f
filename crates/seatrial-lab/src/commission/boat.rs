//! One simulated boat that is commissioned, beside other ways to choose gains.

use seatrial::gains::commission::{
    Boat, Draw, Evidence, Foreseen, MOST_REPEATS, Response, Stage, StepInstant, StepTest, foresee,
    judge_repeats, propose, scatter_rad,
};
use seatrial_core::{CascadeSettings, YawModel};
use serde::Serialize;

/// Time constants of the classes, s.
pub const CLASSES_S: [[f64; 2]; 3] = [[0.2, 0.6], [0.6, 2.0], [2.0, 6.0]];
/// Turn rate at full steering times the time constant, rad.
const TURN_RAD: [f64; 2] = [0.15, 0.5];
/// Lag and dead time of the rudder, s.
const LAG_S: [f64; 2] = [0.0, 0.3];
const DELAY_S: [f64; 2] = [0.02, 0.06];
/// C0 as a share of the acceleration at full steering, either way.
const OFF_CENTRE: f64 = 0.03;
/// Noise of the yaw rate, rad/s, and of the heading, rad.
const RATE_NOISE_RAD_S: f64 = 0.005;
const HEADING_NOISE_RAD: f64 = 0.002;
/// In a sea: noise of the heading, rad, and deviation of the sea as a share of the acceleration at full steering.
const NOISE_IN_A_SEA_RAD: [f64; 2] = [0.002, 0.008];
const SEA: [f64; 2] = [0.0, 0.02];
/// What a trial errs by: a22 and B as shares, the lag as a share and at least that many s; standard deviations.
const MODEL_ERROR: f64 = 0.04;
const LAG_ERROR: f64 = 0.15;
const LAG_ERROR_S: f64 = 0.02;
/// Steps of 30 degrees, held for so many time constants and at least so long, s.
const STEP_RAD: f64 = std::f64::consts::FRAC_PI_6;
const HOLD_TIME_CONSTANTS: f64 = 20.0;
const HOLD_S: f64 = 15.0;
const SMALL_STEP_RAD: f64 = 0.14;
/// Boats settle for at least so long before them, s.
const SETTLE_S: f64 = 5.0;

/// How gains are chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// As ArduPilot's Rover comes.
    Defaults,
    /// QuickTune's rule: FF is 0.9 of steering by turn rate, P and I half of FF; the rest as it comes.
    QuickTune,
    /// As proposed from the model.
    Proposed,
    /// What a commission leaves: the proposed gains where they are kept, else the defaults.
    Commissioned,
}

impl Method {
    /// Every one.
    pub const ALL: [Self; 4] =
        [Self::Defaults, Self::QuickTune, Self::Proposed, Self::Commissioned];
}

/// What one boat made of its steps.
#[derive(Clone, Copy, Debug)]
pub struct Commissioning {
    /// With each method, in the order of [`Method::ALL`].
    pub responses: [Response; 4],
    /// Were the proposed gains kept?
    pub is_kept: bool,
    /// Would they be kept, were there no sea and no noise?
    pub is_better: bool,
    /// Was the overshoot that was measured in the interval that was foreseen?
    pub is_as_foreseen: bool,
}

/// Rover's settings as they come, 4.6.
pub fn defaults() -> CascadeSettings<f64> {
    CascadeSettings {
        angle_gain_per_s: 2.0,
        feed_forward_s: 0.2,
        rate_gain_s: 0.2,
        rate_integral_gain: 0.2,
        rate_derivative_gain_s2: 0.0,
        integral_limit: 1.0,
        target_filter_hz: 0.0,
        error_filter_hz: 10.0,
        derivative_filter_hz: 0.0,
        rate_limit_rad_s: 120_f64.to_radians(),
        acceleration_limit_rad_s2: 120_f64.to_radians(),
        steering_limit: 1.0,
        shaping: None,
    }
}

/// QuickTune's rule for a boat, from its documentation.
fn quick_tuned(boat: &Boat) -> CascadeSettings<f64> {
    let feed_forward_s = 0.9 * -boat.model.a22_per_s / boat.model.b2_per_s2;
    CascadeSettings {
        feed_forward_s,
        rate_gain_s: 0.5 * feed_forward_s,
        rate_integral_gain: 0.5 * feed_forward_s,
        ..defaults()
    }
}

/// The boat of a class that a seed draws, in calm water.
pub fn boat_of(class_s: [f64; 2], seed: u64) -> Boat {
    drawn(class_s, &mut Draw::new(seed))
}

/// The boat in the sea that a seed draws.
fn in_a_sea(boat: Boat, seed: u64) -> Boat {
    let mut draw = Draw::new(!seed);
    let mut even = |[low, high]: [f64; 2]| low + (high - low) * draw.uniform();
    Boat {
        heading_noise_rad: even(NOISE_IN_A_SEA_RAD),
        disturbance_rad_s2: even(SEA) * boat.model.b2_per_s2,
        ..boat
    }
}

/// Commissions one boat of a class, in a sea or not; `None` where no gains are proposed for it.
pub fn commission_one(
    class_s: [f64; 2],
    seed: u64,
    loop_interval_s: f64,
    has_sea: bool,
) -> Option<Commissioning> {
    let mut draw = Draw::new(seed);
    let boat = drawn(class_s, &mut draw);
    let boat = if has_sea { in_a_sea(boat, seed) } else { boat };
    let evidence = evidence(&boat, &mut draw, loop_interval_s);
    let test = full_steps(&boat, loop_interval_s);
    let proposed = propose(&evidence, &defaults()).ok()?;
    let smoothing_s = 0.2 / proposed.angle_gain_per_s;
    let trial = Steps { boat: &boat, seed, smoothing_s };
    let respond = |settings: &CascadeSettings<f64>| trial.response(settings, &test);
    let (old, new) = (respond(&defaults())?, respond(&proposed)?);
    let small_test = StepTest { step_rad: SMALL_STEP_RAD, ..test };
    let foreseen =
        |test: &StepTest| foresee(&evidence, &proposed, &test.learnt(&proposed), smoothing_s);
    let stages =
        [(Stage::Small, small_test), (Stage::Full, test)].map(|(s, t)| (s, t, foreseen(&t)));
    let overshoot = stages[1].2.overshoot;
    let calm =
        Boat { rate_noise_rad_s: 0.0, heading_noise_rad: 0.0, disturbance_rad_s2: 0.0, ..boat };
    let truly = Steps { boat: &calm, ..trial };
    let is_kept = trial.keeps(&proposed, &test, &stages)?;
    Some(Commissioning {
        is_better: truly.keeps(&proposed, &test, &stages[1..])?,
        is_as_foreseen: (overshoot.low..=overshoot.high).contains(&new.overshoot),
        responses: [old, respond(&quick_tuned(&boat))?, new, if is_kept { new } else { old }],
        is_kept,
    })
}

/// The steps that a boat is tried by.
fn full_steps(boat: &Boat, loop_interval_s: f64) -> StepTest {
    StepTest {
        step_rad: STEP_RAD,
        settle_s: SETTLE_S,
        hold_s: HOLD_S.max(HOLD_TIME_CONSTANTS / -boat.model.a22_per_s),
        sample_interval_s: (0.05 / loop_interval_s).round() * loop_interval_s,
        loop_interval_s,
    }
}

/// Steps of a boat in its sea.
#[derive(Clone, Copy)]
struct Steps<'a> {
    boat: &'a Boat,
    seed: u64,
    smoothing_s: f64,
}

impl Steps<'_> {
    fn record(
        &self,
        settings: &CascadeSettings<f64>,
        test: &StepTest,
        repeat: usize,
    ) -> [Vec<StepInstant>; 2] {
        let seed = self.seed.wrapping_add(1_000_003 * repeat as u64);
        test.learnt(settings).simulate(self.boat, settings, seed)
    }

    /// What these settings make of a test.
    fn response(&self, settings: &CascadeSettings<f64>, test: &StepTest) -> Option<Response> {
        let legs = self.record(settings, test, 0);
        let scatter_rad = scatter_rad(&legs, self.smoothing_s)?;
        Response::measure(&legs, test.step_rad, self.smoothing_s, scatter_rad)
    }

    /// Would a commission keep these settings by these stages?
    fn keeps(
        &self,
        settings: &CascadeSettings<f64>,
        test: &StepTest,
        stages: &[(Stage, StepTest, Foreseen)],
    ) -> Option<bool> {
        let old = self.record(&defaults(), test, 0);
        let mut repeats = 0;
        for (stage, test, foreseen) in stages {
            let mut records = Vec::new();
            loop {
                records.push(self.record(settings, test, repeats));
                let stage = (*stage, test.step_rad);
                let judgement =
                    judge_repeats(stage, &records, (&old, STEP_RAD), foreseen, self.smoothing_s)?
                        .judgement;
                if judgement.keep {
                    break;
                }
                if repeats == MOST_REPEATS || !judgement.is_worth_repeating() {
                    return Some(false);
                }
                repeats += 1;
            }
        }
        Some(true)
    }
}

fn drawn(class_s: [f64; 2], draw: &mut Draw) -> Boat {
    let mut even = |[low, high]: [f64; 2]| low + (high - low) * draw.uniform();
    let logarithmic = |ends: [f64; 2]| ends.map(libm::log);
    let time_constant_s = libm::exp(even(logarithmic(class_s)));
    let turn_rad = libm::exp(even(logarithmic(TURN_RAD)));
    let authority = turn_rad / (time_constant_s * time_constant_s);
    let off_centre = even([-OFF_CENTRE, OFF_CENTRE]);
    Boat {
        model: YawModel::from_theta([-1.0 / time_constant_s, authority, off_centre * authority]),
        lag_s: even(LAG_S),
        delay_s: even(DELAY_S),
        rate_noise_rad_s: RATE_NOISE_RAD_S,
        heading_noise_rad: HEADING_NOISE_RAD,
        disturbance_rad_s2: 0.0,
        steering_taken: 0.0,
    }
}

/// What a trial finds of a boat, with its errors.
fn evidence(boat: &Boat, draw: &mut Draw, loop_interval_s: f64) -> Evidence {
    let model = boat.model;
    let found = |value: f64, draw: &mut Draw| value * (1.0 + MODEL_ERROR * draw.normal());
    let a22_per_s = found(model.a22_per_s, draw);
    let b2_per_s2 = found(model.b2_per_s2, draw);
    let lag_error_s = (LAG_ERROR * boat.lag_s).max(LAG_ERROR_S) * draw.normal();
    let variance = |value: f64| (MODEL_ERROR * value).powi(2);
    Evidence {
        model: YawModel { a22_per_s, b2_per_s2, ..model },
        covariance: [[variance(a22_per_s), 0.0, 0.0], [0.0, variance(b2_per_s2), 0.0], [0.0; 3]],
        lag_s: (boat.lag_s + lag_error_s).max(0.0),
        delay_s: boat.delay_s,
        rate_noise_rad_s: boat.rate_noise_rad_s,
        heading_noise_rad: boat.heading_noise_rad,
        disturbance_rad_s2: boat.disturbance_rad_s2,
        loop_interval_s,
        steering_taken: 0.0,
    }
}
