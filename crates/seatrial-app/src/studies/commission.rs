//! Commissions of many simulated boats, beside the autopilot's defaults and QuickTune's rule.

use seatrial::gains::commission::Response;
use seatrial::gains::commission::study::{CLASSES_S, Commissioning, Method, commission_one};
use serde::Serialize;

use crate::workers::Workers;

/// `study commission --json`.
#[derive(Clone, Debug, Serialize)]
pub struct Commissions {
    /// `seatrial.commission_study.v1`
    pub schema: &'static str,
    /// The first seed.
    pub seed: u64,
    /// Boats of each class.
    pub boats: u64,
    /// Loops of the autopilot per second.
    pub loop_rate_hz: u32,
    /// Is each boat in a sea of its own?
    pub has_sea: bool,
    /// Classes of boats.
    pub classes: Vec<Class>,
}

/// Boats of a range of time constants.
#[derive(Clone, Debug, Serialize)]
pub struct Class {
    /// Least and greatest time constant, s.
    pub time_constant_s: [f64; 2],
    /// Boats for which no gains were proposed.
    pub refused: u64,
    /// Boats whose proposed gains were kept.
    pub kept: usize,
    /// Boats whose proposed gains would be kept, were there no sea and no noise.
    pub better: usize,
    /// Of these, how many were kept.
    pub better_kept: usize,
    /// Boats whose measured overshoot was in the interval that was foreseen.
    pub as_foreseen: usize,
    /// What each method makes of them.
    pub methods: Vec<Row>,
}

/// The steps of a class under the gains of a method.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Where the gains come from.
    pub method: Method,
    /// Median overshoot as a fraction of the step.
    pub overshoot_median: f64,
    /// Largest overshoot as a fraction of the step.
    pub overshoot_most: f64,
    /// Boats that do not settle.
    pub unsettled: usize,
    /// Median time to settle of those that do, s.
    pub settling_median_s: Option<f64>,
    /// Boats that settle later than with the defaults.
    pub later_than_defaults: usize,
    /// Median of the rudder's activity, full deflections per second.
    pub activity_median_per_s: f64,
    /// Largest activity, full deflections per second.
    pub activity_most_per_s: f64,
}

/// How many boats of all classes there are where each has this many.
pub fn boats_of_all(boats: u64) -> u64 {
    boats * CLASSES_S.len() as u64
}

/// Commissions `boats` of each class, in a sea or not, under an autopilot with this many loops a second.
pub fn commission_boats(
    boats: u64,
    seed: u64,
    loop_rate_hz: u32,
    has_sea: bool,
    workers: &Workers,
) -> Commissions {
    let loop_interval_s = 1.0 / f64::from(loop_rate_hz);
    let classes = CLASSES_S.iter().enumerate().map(|(number, class_s)| {
        let first = seed.wrapping_add(1_000_000 * number as u64);
        let found = workers.each(boats, |boat| {
            commission_one(*class_s, first.wrapping_add(boat), loop_interval_s, has_sea)
        });
        class(*class_s, boats, &found)
    });
    Commissions {
        schema: "seatrial.commission_study.v1",
        seed,
        boats,
        loop_rate_hz,
        has_sea,
        classes: classes.collect(),
    }
}

fn class(time_constant_s: [f64; 2], asked: u64, boats: &[Commissioning]) -> Class {
    let count = |is: fn(&Commissioning) -> bool| boats.iter().filter(|boat| is(boat)).count();
    Class {
        time_constant_s,
        refused: asked - boats.len() as u64,
        kept: count(|boat| boat.is_kept),
        better: count(|boat| boat.is_better),
        better_kept: count(|boat| boat.is_better && boat.is_kept),
        as_foreseen: count(|boat| boat.is_as_foreseen),
        methods: Method::ALL
            .iter()
            .enumerate()
            .map(|(number, method)| row(*method, number, boats))
            .collect(),
    }
}

fn row(method: Method, number: usize, boats: &[Commissioning]) -> Row {
    let of = |quantity: fn(&Response) -> f64| {
        let mut values: Vec<f64> = boats
            .iter()
            .map(|b| quantity(&b.responses[number]))
            .collect();
        values.sort_by(f64::total_cmp);
        values
    };
    let middle = |values: &[f64]| values.get(values.len() / 2).copied();
    let most = |values: &[f64]| values.last().copied().unwrap_or(f64::NAN);
    let (overshoot, activity) = (of(|r| r.overshoot), of(|r| r.activity_per_s));
    let settling = |boat: &Commissioning, number: usize| boat.responses[number].settling_s;
    let mut settled: Vec<f64> = boats.iter().filter_map(|b| settling(b, number)).collect();
    settled.sort_by(f64::total_cmp);
    let is_later = |boat: &&Commissioning| match (settling(boat, number), settling(boat, 0)) {
        (Some(found_s), Some(default_s)) => found_s > default_s,
        (None, found) => found.is_some(),
        (Some(_), None) => false,
    };
    Row {
        method,
        overshoot_median: middle(&overshoot).unwrap_or(f64::NAN),
        overshoot_most: most(&overshoot),
        unsettled: boats.len() - settled.len(),
        settling_median_s: middle(&settled),
        later_than_defaults: boats.iter().filter(is_later).count(),
        activity_median_per_s: middle(&activity).unwrap_or(f64::NAN),
        activity_most_per_s: most(&activity),
    }
}
