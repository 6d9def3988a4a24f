//! What holds for the estimator whatever the record.

use std::array::from_fn;

use proptest::prelude::*;
use seatrial_core::{
    Cause, Estimator, EstimatorSettings, Forgetting, Intake, RecursiveLeastSquares,
};

/// A turning vehicle with its rudder, sample k at 20 Hz.
fn sample(k: u32) -> (f64, f64, f64) {
    let t = f64::from(k) * 0.05;
    let rudder = if (k / 40).is_multiple_of(2) { 0.2 } else { -0.2 };
    (t, 0.3 * (0.9 * t).sin() + 0.05 * t, rudder)
}

fn estimator(settings: EstimatorSettings<f64>) -> Estimator<f64> {
    Estimator::new(settings).unwrap()
}

const IDENTITY: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn determinant(p: [[f64; 3]; 3]) -> f64 {
    p[0][0] * (p[1][1] * p[2][2] - p[1][2] * p[2][1])
        - p[0][1] * (p[1][0] * p[2][2] - p[1][2] * p[2][0])
        + p[0][2] * (p[1][0] * p[2][1] - p[1][1] * p[2][0])
}

proptest! {
    /// The recursion solves (I/p0 + sum Phi Phi^T) Theta = sum Phi y: least squares with its prior.
    #[test]
    fn prop_recursive_is_batch_with_the_matching_prior(
        rows in prop::collection::vec((prop::array::uniform2(-1.0..1.0_f64), -1.0..1.0_f64), 5..60),
    ) {
        let p0 = 10.0;
        let keep = Forgetting { factor: 1.0, trace_limit: 3.0 * p0 };
        let mut recursion = RecursiveLeastSquares::<f64, 3>::new(p0);
        let mut information = IDENTITY.map(|row| row.map(|value| value / p0));
        let mut right = [0.0; 3];
        for ([a, b], y) in rows {
            let phi = [a, b, 1.0];
            prop_assert!(recursion.update(phi, y, keep));
            right = from_fn(|i| right[i] + phi[i] * y);
            information = from_fn(|i| from_fn(|j| information[i][j] + phi[i] * phi[j]));
        }
        let (theta, p) = (recursion.theta(), recursion.covariance());
        for ((row, right), unit) in information.iter().zip(right).zip(IDENTITY) {
            // At most 60 updates, information up to 60.
            prop_assert!((dot(row, &theta) - right).abs() < 1e-10);
            for (column, unit) in p.iter().zip(unit) {
                prop_assert!((dot(row, column) - unit).abs() < 1e-10);
            }
        }
    }

    /// P is symmetric to the bit and positive, from any regressors, with and without forgetting.
    #[test]
    fn prop_covariance_is_symmetric_and_positive(
        rows in prop::collection::vec(prop::array::uniform3(-2.0..2.0_f64), 1..200),
        factor in prop::sample::select(vec![0.95, 0.99, 1.0]),
    ) {
        let keep = Forgetting { factor, trace_limit: 3e6 };
        let mut recursion = RecursiveLeastSquares::<f64, 3>::new(1e6);
        for phi in rows {
            prop_assert!(recursion.update(phi, 0.3, keep));
            let p = recursion.covariance();
            prop_assert_eq!(p[0][1], p[1][0]);
            prop_assert_eq!(p[0][2], p[2][0]);
            prop_assert_eq!(p[1][2], p[2][1]);
            prop_assert!(p[0][0] > 0.0 && p[1][1] > 0.0 && p[2][2] > 0.0);
            // Every principal minor, up to the roundings of its terms.
            let bound = p[0][0] * p[1][1] * p[2][2] * 1e-14;
            prop_assert!(determinant(p) > -bound);
            prop_assert!(p[0][0] * p[1][1] - p[0][1] * p[0][1] > -1e-14 * p[0][0] * p[1][1]);
        }
    }

    /// Angles in another unit (a power of 2, whose scaling rounds nothing) scale C0 and nothing else.
    #[test]
    fn prop_another_unit_of_angle_scales_only_c0(exponent in -3..4_i32) {
        let unit = 2.0_f64.powi(exponent);
        let settings = EstimatorSettings {
            // A prior too weak to show that it does not scale.
            initial_covariance: 1e12,
            ..EstimatorSettings::paper()
        };
        let (mut radians, mut other) = (estimator(settings), estimator(settings));
        for k in 0..400 {
            let (t, heading, rudder) = sample(k);
            let _ = radians.update(t, heading, rudder);
            let _ = other.update(t, heading * unit, rudder * unit);
        }
        let (one, two) = (radians.model(), other.model());
        // Roundings of P0 = 1e12 against 1 in f64.
        prop_assert!((one.a22_per_s / two.a22_per_s - 1.0).abs() < 1e-6);
        prop_assert!((one.b2_per_s2 / two.b2_per_s2 - 1.0).abs() < 1e-6);
        prop_assert!((unit * one.c0_rad_per_s2 / two.c0_rad_per_s2 - 1.0).abs() < 1e-6);
    }

    /// Whatever garbage comes in, what is estimated stays a number and garbage leaves no trace.
    #[test]
    fn prop_refused_samples_leave_no_trace(
        garbage in prop::collection::vec((0..400_u32, 0..5_u8), 0..60),
    ) {
        let (mut clean, mut dirty) = (estimator(EstimatorSettings::default()), estimator(EstimatorSettings::default()));
        for k in 0..400 {
            let (t, heading, rudder) = sample(k);
            prop_assert_eq!(clean.update(t, heading, rudder), Intake::Used);
            prop_assert_eq!(dirty.update(t, heading, rudder), Intake::Used);
            for (_, kind) in garbage.iter().filter(|(at, _)| *at == k).take(4) {
                let (sample, cause) = match kind {
                    0 => ((t + 0.01, f64::NAN, rudder), Cause::NonFinite),
                    1 => ((t + 0.01, heading, f64::INFINITY), Cause::NonFinite),
                    2 => ((t, heading, rudder), Cause::RepeatedTime),
                    3 => ((t - 3.0, heading, rudder), Cause::ReversedTime),
                    _ => ((t + 0.01, heading + 1.0, rudder), Cause::Spike),
                };
                prop_assert_eq!(dirty.update(sample.0, sample.1, sample.2), Intake::Rejected(cause));
            }
        }
        prop_assert_eq!(clean.model(), dirty.model());
        prop_assert_eq!(clean.covariance(), dirty.covariance());
    }
}

/// After `restart` the estimator is one whose filters were only warmed so far.
#[test]
fn prop_restart_is_fresh() {
    let mut used = estimator(EstimatorSettings::default());
    let mut unused = used;
    for k in 0..400 {
        let (t, heading, rudder) = sample(k);
        let _ = used.update(t, heading, rudder);
        let _ = unused.warm(t, heading, rudder);
        if k == 200 {
            used.excitation_ended();
        }
    }
    used.restart();
    assert_eq!(used, unused);
}

/// A gap keeps Theta and P, pauses the recursion for 8/lambda and then goes on learning.
#[test]
fn exact_gap_pauses_the_recursion() {
    let mut estimator = estimator(EstimatorSettings::default());
    for k in 0..200 {
        let (t, heading, rudder) = sample(k);
        assert_eq!(estimator.update(t, heading, rudder), Intake::Used);
    }
    let (model, covariance) = (estimator.model(), estimator.covariance());
    let mut paused = 0;
    for k in 220..400 {
        let (t, heading, rudder) = sample(k);
        if estimator.update(t, heading, rudder) == Intake::Used {
            break;
        }
        assert_eq!((estimator.model(), estimator.covariance()), (model, covariance));
        paused += 1;
    }
    assert_eq!(estimator.rejected().gaps, 1);
    // 8/1.5 s are 106.7 samples, and the sample that ends the gap only starts the filters.
    assert_eq!(paused, 107);
    assert_ne!(estimator.model(), model);
}

/// A vehicle that turns against its rudder as soon as the instrument has taken over: where the instrument cannot learn from a
/// sample, the sample is not to blame.
#[test]
fn prop_an_instrument_that_cannot_learn_refuses_no_sample() {
    let mut unlearnt = 0;
    for takes_over in 20..80 {
        let mut estimator = estimator(EstimatorSettings::default());
        let turned_rad = |k: u32| sample(k).1;
        for k in 0..400 {
            let (t, _, rudder) = sample(k);
            if k == takes_over {
                estimator.excitation_ended();
            }
            let back_rad = 3.0 * (turned_rad(k) - turned_rad(takes_over));
            let heading = match k < takes_over {
                true => turned_rad(k),
                false => turned_rad(takes_over) - back_rad,
            };
            unlearnt += u32::from(estimator.update(t, heading, rudder) == Intake::Warming);
        }
        assert_eq!(estimator.rejected().samples(), 0);
    }
    assert!(unlearnt > 0);
}

/// A manoeuvre a hundred times slower: everything follows the time scale.
#[test]
fn prop_settings_follow_the_time_scale() {
    let mut fast = estimator(EstimatorSettings::for_time_scale(1.0));
    let mut slow = estimator(EstimatorSettings::for_time_scale(128.0));
    for k in 0..400 {
        let (t, heading, rudder) = sample(k);
        assert_eq!(fast.update(t, heading, rudder), Intake::Used);
        assert_eq!(slow.update(128.0 * t, heading, rudder), Intake::Used);
    }
    let (fast, slow) = (fast.model(), slow.model());
    // P0 = 1e6 I is a prior that does not scale, of relative weight 128^4/1e6 over the information of 400 samples.
    assert!((slow.a22_per_s * 128.0 / fast.a22_per_s - 1.0).abs() < 0.05);
}

#[test]
fn exact_invalid_settings_are_named() {
    let good = EstimatorSettings::<f64>::default();
    let mut bad = [(good, ""); 5];
    bad[0] = (EstimatorSettings { lambda_rad_s: 0.0, ..good }, "lambda_rad_s");
    bad[1] = (EstimatorSettings { forgetting_factor: 1.1, ..good }, "forgetting_factor");
    bad[2] = (EstimatorSettings { initial_covariance: f64::NAN, ..good }, "initial_covariance");
    bad[3] = (EstimatorSettings::for_time_scale(-1.0), "lambda_rad_s");
    bad[4].0.convergence.consecutive = 0;
    bad[4].1 = "convergence.consecutive";
    for (settings, field) in bad {
        assert_eq!(Estimator::new(settings).unwrap_err().field, field);
    }
}
