//! The hot kernels, each once, for `cargo xtask instructions`, which counts what they execute.

use std::hint::black_box;

use seatrial::identify::output_error::nearest_simulation;
use seatrial::identify::refined::refined_estimate;
use seatrial::sums::{Accumulator, NoisyRuns, every_theta, monte_carlo, of_records};
use seatrial_core::model::{YawModel, YawState};
use seatrial_core::{Estimator, EstimatorSettings, FixedRateEstimator, FixedRateSettings, Sample};

const INTERVAL_S: f64 = 0.05;
const SHORT: usize = 330;
const LONG: usize = 32_768;

fn main() {
    if !(is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma")) {
        println!("other instructions");
        return;
    }
    let samples = signals();
    let heading: Vec<f64> = samples.iter().map(|s| s.heading_rad).collect();
    let rudder: Vec<f64> = samples.iter().map(|s| s.rudder_rad).collect();
    let settings = FixedRateSettings::for_lambda(1.5, INTERVAL_S);
    kernel_online(&settings, &heading, &rudder);
    kernel_trial(&samples);
    kernel_short(&settings, &heading[..SHORT], &rudder[..SHORT]);
    kernel_long(&settings, &heading, &rudder);
    kernel_every(&settings, &heading, &rudder);
    kernel_many(&settings, &heading, &rudder);
    kernel_monte_carlo(&settings, &heading[..SHORT], &rudder[..SHORT]);
    kernel_refined(&samples[..SHORT]);
    kernel_averaged(&samples[..SHORT]);
}

fn signals() -> Vec<Sample<f64>> {
    let model = YawModel::from_theta([-1.07, 1.08, 0.012]);
    let mut state = YawState::default();
    (0..LONG)
        .map(|k| {
            let rudder_rad = match k % 210 {
                40..80 => 0.26,
                80..120 => -0.26,
                _ => -0.011,
            };
            let sample = Sample {
                time_s: INTERVAL_S * k as f64,
                // A compass that reads in steps of a milliradian.
                heading_rad: f64::round(state.heading_rad * 1e3) * 1e-3,
                rudder_rad,
                ..Sample::default()
            };
            state = model.advance(state, rudder_rad, INTERVAL_S);
            sample
        })
        .collect()
}

#[inline(never)]
fn kernel_online(settings: &FixedRateSettings<f64>, heading: &[f64], rudder: &[f64]) {
    let Ok(mut estimator) = FixedRateEstimator::new(settings, heading[0], rudder[0]) else {
        return;
    };
    for (heading, rudder) in heading.iter().zip(rudder) {
        let _ = estimator.update(*heading, *rudder);
    }
    black_box(estimator);
}

#[inline(never)]
fn kernel_trial(samples: &[Sample<f64>]) {
    let Ok(mut estimator) = Estimator::new(EstimatorSettings::default()) else {
        return;
    };
    for (k, sample) in samples.iter().enumerate() {
        if k == 130 {
            estimator.excitation_ended();
        }
        let _ = estimator.update(sample.time_s, sample.heading_rad, sample.rudder_rad);
    }
    black_box(estimator);
}

#[inline(never)]
fn kernel_short(settings: &FixedRateSettings<f64>, heading: &[f64], rudder: &[f64]) {
    sums(settings, heading, rudder);
}

#[inline(never)]
fn kernel_long(settings: &FixedRateSettings<f64>, heading: &[f64], rudder: &[f64]) {
    sums(settings, heading, rudder);
}

fn sums(settings: &FixedRateSettings<f64>, heading: &[f64], rudder: &[f64]) {
    if let Ok(mut accumulator) = Accumulator::new(settings) {
        accumulator.extend(heading, rudder);
        black_box(accumulator.sums().model(1e6));
    }
}

#[inline(never)]
fn kernel_every(settings: &FixedRateSettings<f64>, heading: &[f64], rudder: &[f64]) {
    let mut thetas = Vec::new();
    let _ = every_theta(settings, heading, rudder, &mut thetas);
    black_box(thetas);
}

#[inline(never)]
fn kernel_many(settings: &FixedRateSettings<f64>, heading: &[f64], rudder: &[f64]) {
    let _ = black_box(of_records(settings, SHORT, heading, rudder));
}

#[inline(never)]
fn kernel_monte_carlo(settings: &FixedRateSettings<f64>, heading: &[f64], rudder: &[f64]) {
    let runs = NoisyRuns {
        heading_rad: heading,
        rudder_rad: rudder,
        heading_noise_rad: 0.02,
        seed: 1,
        runs: 64,
    };
    let _ = black_box(monte_carlo(settings, &runs));
}

#[inline(never)]
fn kernel_refined(samples: &[Sample<f64>]) {
    let start = YawModel::from_theta([-1.0, 1.0, 0.01]);
    let _ = black_box(nearest_simulation(samples, Some(start)).ok());
}

#[inline(never)]
fn kernel_averaged(samples: &[Sample<f64>]) {
    let _ = black_box(refined_estimate(samples, None).ok());
}
