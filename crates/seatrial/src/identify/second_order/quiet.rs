//! How strong a disturbance the quiet end of a record allows.

use seatrial_core::Sample;

use super::comparisons::Comparisons;
use super::theta::{C0, HEADING, Theta, YAW_RATE};
use crate::manoeuvre::Manoeuvre;
use seatrial_core::refine::Disturbance;

/// The quiet part begins so many time constants of the vehicle after the last stroke of the rudder, and lasts at
/// least so many.
const AFTER_TIME_CONSTANTS: f64 = 2.0;
const LEAST_TIME_CONSTANTS: f64 = 5.0;

/// Log likelihood that a disturbance may lose against the likeliest: half of 95 % of chi-squared on one
/// degree of freedom, above the likeliest strength only, is 1.35.
const LOST: f64 = 1.5;

/// Strengths tried, in squared rates of the vehicle times the heading noise, by halves of a decade.
const STRENGTHS: [f64; 8] = [3.0, 1.0, 0.3, 0.1, 0.03, 0.01, 0.003, 0.0];

/// Where the record ends in a quiet part: of each time constant the strongest disturbance that the heading there
/// allows. The rudder does too little there for the structure of the model to matter. `None` without a quiet part.
pub(super) fn disturbances(
    samples: &[Sample<f64>],
    block: usize,
    first: &Theta,
    scale_per_s: f64,
    time_constants_s: &[f64],
) -> Option<Vec<Disturbance>> {
    let last_stroke = Manoeuvre::find(samples)?.strokes.last()?.window.to_s;
    let from_s = last_stroke + AFTER_TIME_CONSTANTS / scale_per_s;
    let quiet = &samples[samples.partition_point(|sample| sample.time_s < from_s)..];
    let duration_s = quiet.last()?.time_s - quiet.first()?.time_s;
    if duration_s < LEAST_TIME_CONSTANTS / scale_per_s {
        return None;
    }
    let record = Comparisons::new(quiet, block);
    let mut start = *first;
    start[HEADING] = 0.0;
    start[YAW_RATE] = 0.0;
    let log_likelihood = |disturbance: Disturbance| {
        const MOST_STEPS: u32 = 6;
        let summit = record.climb(&start, &[C0, HEADING, YAW_RATE], disturbance, MOST_STEPS)?;
        Some((disturbance, summit.likelihood.log))
    };
    let of_time_constant = |time_constant_s: f64| -> Vec<(Disturbance, f64)> {
        STRENGTHS
            .into_iter()
            .map(|strength| Disturbance {
                relative: strength * scale_per_s.powi(2),
                time_constant_s,
            })
            .filter_map(log_likelihood)
            .collect()
    };
    let tried: Vec<Vec<(Disturbance, f64)>> = time_constants_s
        .iter()
        .map(|time_constant_s| of_time_constant(*time_constant_s))
        .collect();
    let best = tried
        .iter()
        .flatten()
        .map(|(_, log)| *log)
        .fold(f64::NEG_INFINITY, f64::max);
    let strongest = |tried: &Vec<(Disturbance, f64)>| {
        let allowed = tried.iter().find(|(_, log)| *log >= best - LOST)?;
        Some(allowed.0)
    };
    Some(tried.iter().filter_map(strongest).collect())
}
