//! The hot kernels, each once, for `cargo xtask instructions`, which counts what they execute.

use std::hint::black_box;

use seatrial::Window;
use seatrial::identify::evenly_sampled::EvenlySampled;
use seatrial::identify::output_error::output_error;
use seatrial::identify::refined::refined_estimate;
use seatrial::identify::{IdentifySettings, ValidationData, identify};
use seatrial_core::model::{YawModel, YawState};
use seatrial_core::{Estimator, EstimatorSettings, FixedRateEstimator, FixedRateSettings, Sample};

const INTERVAL_S: f64 = 0.05;
const SHORT: usize = 330;
const LONG: usize = 32_768;
/// Samples of a whole log, trained on its first half and validated on the other.
const LOG: usize = 3_801;

fn main() {
    if !cfg!(target_arch = "x86_64") {
        println!("other instructions");
        return;
    }
    let samples = signals();
    let heading: Vec<f64> = samples.iter().map(|s| s.heading_rad).collect();
    let rudder: Vec<f64> = samples.iter().map(|s| s.rudder_rad).collect();
    let times: Vec<f64> = samples.iter().map(|s| s.time_s).collect();
    let settings = FixedRateSettings::for_lambda(1.5, INTERVAL_S);
    kernel_online(&settings, &heading, &rudder);
    kernel_trial(&samples);
    kernel_batch(&times, &heading, &rudder);
    kernel_refined(&samples[..SHORT]);
    kernel_averaged(&samples[..SHORT]);
    kernel_identify(&samples[..LOG]);
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
fn kernel_batch(time_s: &[f64], heading_rad: &[f64], rudder_rad: &[f64]) {
    let record = EvenlySampled { time_s, heading_rad, rudder_rad };
    let _ = black_box(record.least_squares(1.5).ok());
}

#[inline(never)]
fn kernel_refined(samples: &[Sample<f64>]) {
    let start = YawModel::from_theta([-1.0, 1.0, 0.01]);
    let _ = black_box(output_error(samples, Some(start)).ok());
}

#[inline(never)]
fn kernel_averaged(samples: &[Sample<f64>]) {
    let _ = black_box(refined_estimate(samples, None).ok());
}

#[inline(never)]
fn kernel_identify(samples: &[Sample<f64>]) {
    let record = samples.iter().copied().collect();
    let end_s = INTERVAL_S * LOG as f64;
    let window = |from_s, to_s| Window { from_s, to_s };
    let validation = ValidationData { record: &record, window: window(0.5 * end_s, end_s) };
    let settings = IdentifySettings::default();
    let _ =
        black_box(identify(&record, window(0.0, 0.5 * end_s), Some(validation), &settings).ok());
}
