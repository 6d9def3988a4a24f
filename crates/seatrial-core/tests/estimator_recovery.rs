//! Noise-free first-order plants under the paper's protocol: the default estimator has to find them.

use seatrial_core::model::YawState;
use seatrial_core::{Estimator, EstimatorSettings, Intake, LostRudder, Real, YawModel};

/// Table II.
const PLANTS: [[f64; 3]; 5] = [
    [-0.95, 0.60, 0.0072],
    [-1.12, 0.87, 0.0107],
    [-1.07, 1.08, 0.0120],
    [-1.14, 1.37, 0.0054],
    [-1.21, 1.77, 0.0049],
];
const HEADINGS_RAD: [f64; 4] = [0.0, 0.7, 3.0, -3.1];
const INTERVAL_S: f64 = 0.05;
const SETTLING_S: f64 = 10.0;
const TRAINING_S: f64 = 16.5;

/// What happens to the samples on their way.
#[derive(Clone, Copy)]
struct Link {
    /// Share of samples that are lost.
    missing: f64,
    /// The rudder moves only when a sample arrives; otherwise it moves at samples that are lost, too.
    rudder_waits_for_samples: bool,
    /// Sampling instants are off by up to this share of the interval.
    jitter: f64,
}

const PERFECT: Link = Link { missing: 0.0, rudder_waits_for_samples: true, jitter: 0.0 };

/// Repeatable numbers in [0, 1).
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// The rudder of the paper's protocol: heading hold, 2 s of quiet, a doublet of 0.26 rad and 4 s, heading hold.
fn rudder(plant: &YawModel<f64>, state: YawState<f64>, hold_rad: f64, training_s: f64) -> f64 {
    if (2.0..4.0).contains(&training_s) {
        0.26
    } else if (4.0..6.0).contains(&training_s) {
        -0.26
    } else {
        let gain = plant.a22_per_s * plant.a22_per_s / (2.0 * plant.b2_per_s2);
        (gain * (hold_rad - state.heading_rad).wrapped()).limited_to(0.26)
    }
}

/// Runs the protocol and returns the estimator and the time.
fn run<T: Real>(
    lost: LostRudder,
    theta: [f64; 3],
    hold_rad: f64,
    link: Link,
    seed: u64,
) -> (Estimator<T>, f64) {
    let plant = YawModel::from_theta(theta);
    let mut estimator = Estimator::<T>::new(EstimatorSettings {
        lost_rudder: lost,
        ..EstimatorSettings::default()
    })
    .unwrap();
    let mut dice = Dice(seed);
    let mut state = YawState { heading_rad: hold_rad, yaw_rate_rad_s: 0.0 };
    let (mut time_s, mut delta) = (0.0, 0.0);
    let samples = ((SETTLING_S + TRAINING_S) / INTERVAL_S).round() as u32;
    for k in 0..samples {
        let due_s = (f64::from(k) + link.jitter * (2.0 * dice.roll() - 1.0)) * INTERVAL_S;
        let due_s = if k == 0 { 0.0 } else { due_s };
        state = plant.advance(state, delta, due_s - time_s);
        time_s = due_s;
        let lost = k > 0 && dice.roll() < link.missing;
        let training_s = f64::from(k) * INTERVAL_S - SETTLING_S + 1e-9;
        if !(lost && link.rudder_waits_for_samples) {
            delta = rudder(&plant, state, hold_rad, training_s);
        }
        if lost {
            continue;
        }
        let (heading, rudder) = (T::of(state.heading_rad.wrapped()), T::of(delta));
        if training_s < 0.0 {
            assert_eq!(estimator.warm(time_s, heading, rudder), Intake::Warming);
            continue;
        }
        if training_s >= 6.0 {
            estimator.excitation_ended();
        }
        assert_eq!(estimator.update(time_s, heading, rudder), Intake::Used);
    }
    (estimator, time_s)
}

/// Relative errors of a22, b2 and C0 over all plants and headings, each sorted.
fn errors<T: Real>(lost: LostRudder, link: Link, seeds: u64) -> [Vec<f64>; 3] {
    let mut errors = [vec![], vec![], vec![]];
    for truth in PLANTS {
        for heading_rad in HEADINGS_RAD {
            for seed in 0..seeds {
                let (estimator, _) = run::<T>(lost, truth, heading_rad, link, seed);
                let found = estimator.model().theta();
                for ((errors, found), truth) in errors.iter_mut().zip(found).zip(truth) {
                    errors.push((found.to_f64() / truth - 1.0).abs());
                }
            }
        }
    }
    for errors in &mut errors {
        errors.sort_by(f64::total_cmp);
    }
    errors
}

fn worst(errors: &[f64]) -> f64 {
    errors.last().copied().unwrap()
}

/// 0.1 %: the heading is not quite straight between samples. Also in f32, whose compass resolves 2e-7 rad.
#[test]
fn exact_any_heading_and_across_a_wrap() {
    for errors in errors::<f64>(LostRudder::Interpolated, PERFECT, 1) {
        assert!(worst(&errors) < 0.001, "f64 {}", worst(&errors));
    }
    for errors in errors::<f32>(LostRudder::Interpolated, PERFECT, 1) {
        assert!(worst(&errors) < 0.001, "f32 {}", worst(&errors));
    }
}

/// Sampling instants off by up to 40 % of the interval; measured 0.16 %, 0.08 % and 0.56 %.
#[test]
fn exact_jittered_sampling() {
    let link = Link { jitter: 0.4, ..PERFECT };
    for errors in errors::<f64>(LostRudder::Interpolated, link, 10) {
        assert!(worst(&errors) < 0.01, "{}", worst(&errors));
    }
}

/// a22 and b2 to 1 % in every run. C0 to 1 % in 19 of 20 runs and to 2 % in all of them: the smallest C0, 0.0049 rad/s^2, is a
/// rudder offset of 0.16 deg, and 1 % of it is less than an edge of the doublet leaves that is 1 ms off.
fn assert_one_percent([a22, b2, c0]: [Vec<f64>; 3]) {
    assert!(worst(&a22) < 0.01, "a22 {}", worst(&a22));
    assert!(worst(&b2) < 0.01, "b2 {}", worst(&b2));
    let most = c0[c0.len() * 19 / 20];
    assert!(most < 0.01, "C0 in 19 of 20 runs {most}");
    assert!(worst(&c0) < 0.02, "C0 {}", worst(&c0));
}

/// A fifth of the rows of a log are missing, and the rudder moved at some of them; measured a22 0.5 %, b2 0.3 %, C0 1.0 %.
#[test]
fn exact_missing_rows() {
    let link = Link { missing: 0.2, rudder_waits_for_samples: false, jitter: 0.0 };
    assert_one_percent(errors::<f64>(LostRudder::Interpolated, link, 20));
    assert_one_percent(errors::<f32>(LostRudder::Interpolated, link, 20));
}

/// A fifth of the samples do not arrive, and the rudder waits for the next; measured a22 0.5 %, b2 0.3 %, C0 1.6 %.
#[test]
fn exact_missing_samples_with_the_rudder_held() {
    let link = Link { missing: 0.2, ..PERFECT };
    assert_one_percent(errors::<f64>(LostRudder::Held, link, 20));
}

/// A fifth of the samples do not arrive, the rudder waits, and is assumed to move evenly as in a log: a22 and b2 stand it.
#[test]
fn exact_missing_samples_with_the_rudder_held_but_interpolated() {
    let link = Link { missing: 0.2, ..PERFECT };
    let [a22, b2, _] = errors::<f64>(LostRudder::Interpolated, link, 20);
    assert!(worst(&a22) < 0.01, "a22 {}", worst(&a22));
    assert!(worst(&b2) < 0.01, "b2 {}", worst(&b2));
}

/// Three hours on a straight course after the trial, in f32, moves the estimate by less than a thousandth.
#[test]
fn prop_idle_after_the_trial_changes_nothing() {
    let truth = PLANTS[2];
    let (mut estimator, mut time_s) = run::<f32>(LostRudder::Held, truth, 0.7, PERFECT, 0);
    let straight = -(truth[2] / truth[1]) as f32;
    for _ in 0..200_000 {
        time_s += INTERVAL_S;
        let _ = estimator.update(time_s, 0.7, straight);
    }
    for (found, truth) in estimator.model().theta().iter().zip(truth) {
        assert!((f64::from(*found) / truth - 1.0).abs() < 0.002, "{found}");
    }
}
