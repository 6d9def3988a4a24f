//! The recursion, sample by sample: ours and others' formulas.

use std::hint::black_box;

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};
use ndarray::{Array1, Array2, arr1, arr2};
use seatrial_core::estimator::{Estimator, EstimatorSettings, Method};
use seatrial_core::{FixedRateEstimator, FixedRateSettings};

use crate::{INITIAL_COVARIANCE, INTERVAL_S, LAMBDA_RAD_S};

pub fn ours(settings: &FixedRateSettings<f64>, heading: &[f64], rudder: &[f64]) -> [f64; 3] {
    let mut estimator = FixedRateEstimator::new(settings, heading[0], rudder[0]).unwrap();
    let _ = estimator.learn();
    for (heading, rudder) in heading[1..].iter().zip(&rudder[1..]) {
        let _ = estimator.update(*heading, *rudder);
    }
    estimator.model().theta()
}

pub fn ours_f32(settings: &FixedRateSettings<f64>, heading: &[f32], rudder: &[f32]) -> [f64; 3] {
    let settings = FixedRateSettings::<f32> {
        sample_interval_s: settings.sample_interval_s as f32,
        lambda_rad_s: settings.lambda_rad_s as f32,
        heading_hold: settings.heading_hold,
        filter_start: settings.filter_start,
        initial_covariance: 100.0,
    };
    let mut estimator = FixedRateEstimator::new(&settings, heading[0], rudder[0]).unwrap();
    let _ = estimator.learn();
    for (heading, rudder) in heading[1..].iter().zip(&rudder[1..]) {
        let _ = estimator.update(*heading, *rudder);
    }
    estimator.model().theta().map(f64::from)
}

/// The estimator of a trial: guard, lost samples, convergence, and here least squares throughout.
pub fn of_a_trial(heading: &[f64], rudder: &[f64]) -> [f64; 3] {
    let mut estimator = Estimator::new(EstimatorSettings {
        method: Method::LeastSquares,
        initial_covariance: INITIAL_COVARIANCE,
        lambda_rad_s: LAMBDA_RAD_S,
        ..EstimatorSettings::paper()
    })
    .unwrap();
    for (k, (heading, rudder)) in heading.iter().zip(rudder).enumerate() {
        let _ = estimator.update(k as f64 * INTERVAL_S, *heading, *rudder);
    }
    estimator.model().theta()
}

/// Theta of a trial's estimator with its default settings, whose instrument takes over after the first doublet.
pub fn with_the_instrument(heading: &[f64], rudder: &[f64]) -> [f64; 3] {
    const EXCITATION_ENDS: usize = 130;
    let mut estimator = Estimator::new(EstimatorSettings::for_lambda(LAMBDA_RAD_S)).unwrap();
    for (k, (heading, rudder)) in heading.iter().zip(rudder).enumerate() {
        if k == EXCITATION_ENDS {
            estimator.excitation_ended();
        }
        let _ = estimator.update(k as f64 * INTERVAL_S, *heading, *rudder);
    }
    assert!(estimator.instrument().is_some(), "least squares throughout");
    estimator.model().theta()
}

pub fn nalgebra(heading: &[f64], rudder: &[f64]) -> [f64; 3] {
    let x = LAMBDA_RAD_S * INTERVAL_S;
    let e = black_box(-x).exp();
    let c = x * e;
    let a = Matrix2::new(e, 0.0, -c, e);
    let aq = Matrix2::new(e, 0.0, c, e);
    let bq = Vector2::new(1.0 - e, 1.0 - e - c);
    let mut state = Vector2::new(-heading[0], 0.0);
    let mut q = Vector2::zeros();
    let mut p = Matrix3::identity() * INITIAL_COVARIANCE;
    let mut theta = Vector3::zeros();
    for k in 0..heading.len() {
        if k > 0 {
            state = a * state - Vector2::new(heading[k] - heading[k - 1], 0.0);
            q = aq * q + bq * rudder[k - 1];
        }
        let phi = Vector3::new(LAMBDA_RAD_S * state[1], q[1], 1.0);
        let gain = p * phi / (1.0 + phi.dot(&(p * phi)));
        theta += gain * (-LAMBDA_RAD_S * LAMBDA_RAD_S * state.sum() - phi.dot(&theta));
        p = (Matrix3::identity() - gain * phi.transpose()) * p;
    }
    theta.into()
}

pub fn ndarray(heading: &[f64], rudder: &[f64]) -> [f64; 3] {
    let x = LAMBDA_RAD_S * INTERVAL_S;
    let e = (-x).exp();
    let c = x * e;
    let a = arr2(&[[e, 0.0], [-c, e]]);
    let aq = arr2(&[[e, 0.0], [c, e]]);
    let bq = arr1(&[1.0 - e, 1.0 - e - c]);
    let mut state = arr1(&[-heading[0], 0.0]);
    let mut q: Array1<f64> = Array1::zeros(2);
    let mut p: Array2<f64> = Array2::eye(3) * INITIAL_COVARIANCE;
    let mut theta: Array1<f64> = Array1::zeros(3);
    for k in 0..heading.len() {
        if k > 0 {
            state = a.dot(&state);
            state[0] -= heading[k] - heading[k - 1];
            q = aq.dot(&q) + &bq * rudder[k - 1];
        }
        let phi = arr1(&[LAMBDA_RAD_S * state[1], q[1], 1.0]);
        let g = p.dot(&phi);
        let gain = &g / (1.0 + phi.dot(&g));
        let error = -LAMBDA_RAD_S * LAMBDA_RAD_S * state.sum() - phi.dot(&theta);
        theta = theta + &gain * error;
        for i in 0..3 {
            for j in 0..3 {
                p[[i, j]] -= gain[i] * g[j];
            }
        }
    }
    [theta[0], theta[1], theta[2]]
}
