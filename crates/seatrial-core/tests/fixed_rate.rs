//! The lean estimator beside the guarded one, and on what it refuses.

use proptest::prelude::*;
use seatrial_core::model::YawState;
use seatrial_core::{
    Estimator, EstimatorSettings, FixedRateEstimator, FixedRateSettings, Intake, Method, Real,
    YawModel,
};

const INTERVAL_S: f64 = 0.05;

/// A doublet on a vehicle that starts on a heading where the compass wraps: heading and rudder.
fn doublet(samples: usize) -> Vec<[f64; 2]> {
    let model = YawModel::from_theta([-1.07, 1.08, 0.012]);
    let mut state = YawState { heading_rad: 3.1, yaw_rate_rad_s: 0.0 };
    let mut record = Vec::new();
    for k in 0..samples {
        let rudder_rad = match k {
            40..80 => 0.26,
            80..120 => -0.26,
            _ => -0.011,
        };
        // A compass of 1 mrad.
        let noise_rad = 0.001 * (k as f64 * 1.7).sin() * (k as f64 * 0.31).cos();
        record.push([Real::wrapped(state.heading_rad + noise_rad), rudder_rad]);
        state = model.advance(state, rudder_rad, INTERVAL_S);
    }
    record
}

fn run<T: Real>(settings: &FixedRateSettings<T>, record: &[[f64; 2]]) -> FixedRateEstimator<T> {
    let [first, rest @ ..] = record else { panic!("no samples") };
    let [heading_rad, rudder_rad] = first.map(T::of);
    let mut lean = FixedRateEstimator::new(settings, heading_rad, rudder_rad).unwrap();
    for [heading_rad, rudder_rad] in rest {
        assert!(lean.update(T::of(*heading_rad), T::of(*rudder_rad)));
    }
    lean
}

fn lean_settings() -> FixedRateSettings<f64> {
    FixedRateSettings::for_lambda(1.5, INTERVAL_S)
}

#[test]
fn parity_with_the_guarded_estimator_at_every_sample() {
    for initial_covariance in [100.0, 1e6] {
        let improved = EstimatorSettings {
            initial_covariance,
            method: Method::LeastSquares,
            ..EstimatorSettings::default()
        };
        let mut guarded = Estimator::new(improved).unwrap();
        let settings = FixedRateSettings { initial_covariance, ..lean_settings() };
        let record = doublet(330);
        let [heading_rad, rudder_rad] = record[0];
        let mut lean = FixedRateEstimator::new(&settings, heading_rad, rudder_rad).unwrap();
        let _ = guarded.warm(0.0, heading_rad, rudder_rad);
        for (k, [heading_rad, rudder_rad]) in record.iter().enumerate().skip(1) {
            assert!(lean.update(*heading_rad, *rudder_rad));
            let intake = guarded.update(k as f64 * INTERVAL_S, *heading_rad, *rudder_rad);
            assert_eq!(intake, Intake::Used);
            for (found, expected) in lean.model().theta().iter().zip(guarded.model().theta()) {
                // Before the doublet a22 and b2 are noise over nearly nothing; the same 1e-9 is then of 1.
                let scale = expected.abs().max(1.0);
                assert!((found - expected).abs() < 1e-9 * scale, "sample {k}");
            }
        }
        for (found, expected) in lean.covariance().iter().zip(guarded.covariance()) {
            for (found, expected) in found.iter().zip(expected) {
                assert!((found / expected - 1.0).abs() < 1e-9);
            }
        }
    }
}

#[test]
fn parity_f32_agrees_with_f64() {
    let record = doublet(330);
    let double = run(&lean_settings(), &record).model().theta();
    let single = run(&FixedRateSettings::<f32>::for_lambda(1.5, 0.05), &record);
    for (single, double) in single.model().theta().iter().zip(double) {
        // A heading of 3 rad in f32 resolves 2e-7 rad; filters and 330 updates raise that to some 1e-5 of the parameters.
        let ratio = f64::from(*single) / double;
        assert!((ratio - 1.0).abs() < 1e-4, "{ratio}");
    }
}

/// P stays positive and the estimate stays put over 14 hours of straight course at 20 Hz.
#[test]
fn prop_f32_bears_a_million_idle_samples() {
    let record = doublet(330);
    let mut lean = run(&FixedRateSettings::<f32>::for_lambda(1.5, 0.05), &record);
    let [heading_rad, rudder_rad] = record[329].map(|value| value as f32);
    for _ in 0..1_000_000 {
        assert!(lean.update(heading_rad, rudder_rad));
    }
    let p = lean.covariance();
    assert!((0..3).all(|i| p[i][i] > 0.0), "{p:?}");
    assert!(lean.model().theta().iter().all(|theta| theta.is_finite()));
}

#[test]
fn exact_an_interval_set_later_is_as_one_from_the_start() {
    let record = doublet(330);
    let at_start = run(&lean_settings(), &record).model().theta();
    let [heading_rad, rudder_rad] = record[0];
    let slower = FixedRateSettings { sample_interval_s: 0.1, ..lean_settings() };
    let mut lean = FixedRateEstimator::new(&slower, heading_rad, rudder_rad).unwrap();
    assert!(lean.set_interval(INTERVAL_S));
    for refused in [0.0, -0.05, f64::NAN, f64::INFINITY, 0.5 / 1.5] {
        assert!(!lean.set_interval(refused));
    }
    for [heading_rad, rudder_rad] in &record[1..] {
        assert!(lean.update(*heading_rad, *rudder_rad));
    }
    for (found, expected) in lean.model().theta().iter().zip(at_start) {
        // The exponential by its series instead of libm's: the last bit of four coefficients.
        assert!((found / expected - 1.0).abs() < 1e-11);
    }
}

#[test]
fn exact_restart_forgets_the_estimate_and_keeps_the_filters() {
    let record = doublet(330);
    let mut lean = run(&lean_settings(), &record);
    lean.restart();
    assert_eq!(lean.model(), YawModel::default());
    assert!(lean.learn());
    // The vehicle is on a straight course: nothing but C0 to learn, and next to none of it.
    assert!(lean.model().c0_rad_per_s2.abs() < 0.05);
}

#[test]
fn exact_bad_settings_name_the_field() {
    type Spoil = fn(&mut FixedRateSettings<f64>);
    let bad: [(Spoil, &str); 5] = [
        (|s| s.sample_interval_s = 0.0, "sample_interval_s"),
        (|s| s.sample_interval_s = f64::INFINITY, "sample_interval_s"),
        (|s| s.lambda_rad_s = f64::NAN, "lambda_rad_s"),
        (|s| s.initial_covariance = -1.0, "initial_covariance"),
        (|s| s.initial_covariance = 1e10, "initial_covariance"),
    ];
    for (spoil, field) in bad {
        let mut settings = lean_settings();
        spoil(&mut settings);
        let error = FixedRateEstimator::new(&settings, 0.0, 0.0).unwrap_err();
        assert_eq!(error.field, field);
    }
    assert!(FixedRateEstimator::new(&lean_settings(), f64::NAN, 0.0).is_err());
}

fn angle() -> impl Strategy<Value = f32> {
    prop_oneof![any::<f32>(), -1e7_f32..1e7, -4.0_f32..4.0]
}

proptest! {
    /// Whatever comes in, the state stays finite, and what is no number changes nothing.
    #[test]
    fn prop_no_sample_spoils_the_state(
        samples in prop::collection::vec((angle(), angle()), 1..200),
    ) {
        let settings = FixedRateSettings::<f32>::for_lambda(1.5, 0.05);
        let mut lean = FixedRateEstimator::new(&settings, 0.0, 0.0).unwrap();
        for (heading_rad, rudder_rad) in samples {
            let before = lean;
            let learnt = lean.update(heading_rad, rudder_rad);
            if !(heading_rad.is_finite() && rudder_rad.is_finite()) {
                prop_assert!(!learnt);
                prop_assert_eq!(lean, before);
            }
            prop_assert!(lean.model().theta().iter().all(|theta| theta.is_finite()));
            prop_assert!(lean.covariance().iter().flatten().all(|p| p.is_finite()));
        }
    }
}
