//! The refined estimates of 200 stages against those of a slower search.
//!
//! `answers.csv` was written by a search that looked for the peak of every disturbance by Newton's method, until a step was less than 0.02
//! standard deviations of a22: 0.01 of the half width of a 95 % interval, which is the tolerance of both searches.
//! Where the rudder is so small that an interval is as wide as what it is of, the likelihood is no parabola over that width; there as much again is allowed.

mod stages;

use seatrial_core::refine::{RefineFailure, Series, refine};

use stages::stage;

const ANSWERS: &str = include_str!("answers.csv");

fn name(failure: &RefineFailure) -> String {
    match failure {
        RefineFailure::TooShort { found } => format!("too_short_{found}"),
        RefineFailure::NotExcited => "not_excited".into(),
    }
}

/// The largest difference of an estimate's numbers, in half widths of their intervals.
fn difference(found: &[f64; 9], recorded: &[f64; 9]) -> f64 {
    let [a22, b2, c0, intervals @ ..] = recorded;
    let mut largest: f64 = 0.0;
    for (i, estimate) in [a22, b2, c0].into_iter().enumerate() {
        let (low, high) = (intervals[2 * i], intervals[2 * i + 1]);
        let half = 0.5 * (high - low);
        let off = [found[i] - estimate, found[3 + 2 * i] - low, found[4 + 2 * i] - high];
        largest = off.iter().fold(largest, |most: f64, off| most.max(off.abs() / half));
    }
    largest
}

#[test]
fn regress_estimates_are_those_of_a_slower_search() {
    let mut differences = Vec::new();
    for line in ANSWERS.lines().skip(1) {
        let fields: Vec<&str> = line.split(',').collect();
        let stage = stage(fields[0].parse().unwrap());
        let record = Series {
            interval_s: &stage.interval_s,
            heading_rad: &stage.heading_rad,
            rudder_rad: &stage.rudder_rad,
            block: 1,
        };
        let found = match refine(record, None) {
            Ok(found) => found,
            Err(failure) => {
                assert_eq!(name(&failure), fields[1], "stage {}", fields[0]);
                continue;
            }
        };
        assert_eq!(fields[1], "found", "stage {}", fields[0]);
        let recorded: [f64; 9] = core::array::from_fn(|i| fields[2 + i].parse().unwrap());
        let [a22, b2, c0] = found.model.theta();
        let [[a22_low, a22_high], [b2_low, b2_high], [c0_low, c0_high]] =
            [found.a22_per_s, found.b2_per_s2, found.c0_rad_per_s2];
        let found = [a22, b2, c0, a22_low, a22_high, b2_low, b2_high, c0_low, c0_high];
        let difference = difference(&found, &recorded);
        // Twice the tolerance of both searches.
        assert!(difference < 0.025, "stage {}: {difference}", fields[0]);
        differences.push(difference);
    }
    differences.sort_by(f64::total_cmp);
    let share = |share: f64| differences[(share * differences.len() as f64) as usize];
    // The search stops in one half of the stages a tenth of its tolerance away from the peak, in nine of ten half of it.
    assert!(share(0.5) < 0.002, "{}", share(0.5));
    assert!(share(0.9) < 0.006, "{}", share(0.9));
}
