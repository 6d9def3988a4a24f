//! The refined estimate of a stage kept without a heap.

use seatrial_core::model::YawState;
use seatrial_core::refine::{
    Disturbance, Full, Hypotheses, RefineFailure, Series, StageRecord, refine,
};
use seatrial_core::{Sample, YawModel};

const INTERVAL_S: f64 = 0.05;
const TRUTH: [f64; 3] = [-1.07, 1.08, 0.012];

/// A doublet of 16.5 s with a compass that reads in steps.
fn doublet(step_rad: f64, rudder_rad: f64) -> Vec<Sample<f64>> {
    let model = YawModel::from_theta(TRUTH);
    let mut state = YawState { heading_rad: 3.0, yaw_rate_rad_s: 0.0 };
    (0..330)
        .map(|k| {
            let rudder_rad = match k {
                60..130 => rudder_rad,
                130..200 => -rudder_rad,
                _ => 0.0,
            };
            let sample = Sample {
                time_s: INTERVAL_S * f64::from(k),
                heading_rad: (state.heading_rad / step_rad).round() * step_rad,
                rudder_rad,
                ..Sample::default()
            };
            state = model.advance(state, rudder_rad, INTERVAL_S);
            sample
        })
        .collect()
}

fn kept(samples: &[Sample<f64>]) -> StageRecord<330> {
    let mut record = StageRecord::new(INTERVAL_S);
    for sample in samples {
        record.push(sample).unwrap();
    }
    record
}

#[test]
fn recover_the_model_of_a_stage_with_the_truth_in_its_intervals() {
    let samples = doublet(0.01, 0.26);
    let found = refine(kept(&samples).series(), None).unwrap();
    let intervals = [found.a22_per_s, found.b2_per_s2, found.c0_rad_per_s2];
    for ((truth, found), [low, high]) in TRUTH.into_iter().zip(found.model.theta()).zip(intervals) {
        assert!(low < truth && truth < high, "{low} {truth} {high}");
        // Steps of 0.01 rad are a noise of 0.003 rad, by which C0 is known to a twelfth.
        assert!((found / truth - 1.0).abs() < 0.1, "{found} {truth}");
    }
    // 0.01 rad over sqrt(12), to the accuracy of a variance from 330 residuals that are no normal noise.
    assert!((found.heading_noise_rad / 0.0029 - 1.0).abs() < 0.2);
}

/// A record without noise has a model, and one within its intervals: what is read off between dampings is no variance below 0.
#[test]
fn recover_the_model_of_a_record_without_noise() {
    let model = YawModel::from_theta(TRUTH);
    let mut state = YawState::default();
    let mut samples = Vec::new();
    for k in 0..800 {
        let rudder_rad = match k % 400 {
            40..80 => 0.2,
            80..120 => -0.2,
            _ => 0.0,
        };
        samples.push(Sample {
            time_s: INTERVAL_S * f64::from(k),
            heading_rad: state.heading_rad,
            rudder_rad,
            ..Sample::default()
        });
        state = model.advance(state, rudder_rad, INTERVAL_S);
    }
    let mut record = StageRecord::<800>::new(INTERVAL_S);
    for sample in &samples {
        record.push(sample).unwrap();
    }
    let found = refine(record.series(), None).unwrap();
    for (found, truth) in found.model.theta().into_iter().zip(model.theta()) {
        // Rounding of the headings.
        assert!((found / truth - 1.0).abs() < 1e-5, "{found} {truth}");
    }
    let [low, high] = found.a22_per_s;
    assert!(low < high && found.heading_noise_rad > 0.0);
}

#[test]
fn exact_a_stage_fits_where_the_plan_says() {
    let samples = doublet(0.01, 0.26);
    let mut record = kept(&samples);
    assert_eq!(record.push(&samples[0]), Err(Full));
    assert_eq!(record.series().heading_rad.len(), 330);
    // 25 kB are promised.
    assert!(size_of::<Hypotheses>() < 26_000);
    assert_eq!(size_of_val(&record) / 330, 24);
}

#[test]
fn prop_what_gives_no_model_is_refused() {
    let still = doublet(0.01, 0.0);
    assert_eq!(refine(kept(&still).series(), None), Err(RefineFailure::NotExcited));
    let mut short = StageRecord::<14>::new(INTERVAL_S);
    for sample in &doublet(0.01, 0.26)[60..74] {
        short.push(sample).unwrap();
    }
    assert_eq!(refine(short.series(), None), Err(RefineFailure::TooShort { found: 14 }));
}

#[test]
fn prop_the_filter_follows_a_clock_that_changes_once() {
    let record = kept(&doublet(0.01, 0.26));
    let record = record.series();
    let disturbance = Disturbance { relative: 10.0, time_constant_s: 3.0 };
    let log_likelihood = |interval_s: &[f64]| {
        let record = Series { interval_s, ..record };
        record.fit(TRUTH[0], disturbance).unwrap().log_likelihood
    };
    let changes_once: Vec<f64> = (0..330).map(|k| if k < 150 { 0.05 } else { 0.1 }).collect();
    // A clock that changes all the time, by too little to matter.
    let changes_always: Vec<f64> =
        (0..330).map(|k| changes_once[k] * (1.0 + 3e-6 * f64::from(k as u8 % 2))).collect();
    let difference = log_likelihood(&changes_once) - log_likelihood(&changes_always);
    // 330 comparisons, whose intervals differ by 3e-6 of them.
    assert!(difference.abs() < 0.01, "{difference}");
}
