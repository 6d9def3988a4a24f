//! Did the heading jump while a gyro turned on?
//!
//! ```text
//! j_k = psi_(k+1) - psi_k - (r_k + r_(k+1))/2 (t_(k+1) - t_k)
//! ```
//!
//! | symbol | meaning |
//! |---|---|
//! | psi, r, t | heading, rad, yaw rate of a gyro, rad/s, and time, s, of a row |
//! | j | what the heading steps by beside the gyro, rad |
//!
//! A satellite compass that changes its satellites steps by degrees in one row, and is right again behind the step: what it steps by is known from the
//! gyro, and taken off. What changes over a gap of the record is no jump. A compass that is stuck, and steps back after a while, is left alone, and so is one that steps often.

use seatrial_core::{Real, Sample};

use super::turn;
use crate::record::{Record, median, shortest_gap_s, turned_rad, turns_rad};
use crate::stated_units::HeadingJumps;

/// Smaller steps are left to noise and to the compass's own test, rad.
const LEAST_JUMP_RAD: f64 = 0.03;
/// A jump is so many usual steps beside the gyro.
const FAR: f64 = 8.0;
/// The heading's own step is that of the jump, not the gyro's, where it stands out from the steps about it by this share of the jump.
const OWN: f64 = 0.8;
/// Rows on either side that are looked at.
const ABOUT: usize = 5;
/// More jumps are no accidents: rows for each.
const ROWS_A_JUMP: usize = 100;
/// Of a normal distribution, its deviation over its median absolute deviation.
const DEVIATION: f64 = 1.4826;

/// Takes the jumps of the heading off that a gyro proves, and says so in the record's units.
pub(super) fn take_off(record: &mut Record) {
    let found = jumps(&record.samples);
    let most = record.samples.len() / ROWS_A_JUMP;
    let Some(largest) = found.iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())) else {
        return;
    };
    if found.len() > most || !turn::agrees(record) {
        return;
    }
    record.units.heading_jumps = Some(HeadingJumps {
        count: found.len(),
        largest_rad: largest.1.abs(),
        largest_at_s: record.samples[largest.0].time_s,
    });
    let mut found = found.into_iter().peekable();
    let mut jumped_rad = 0.0;
    for (row, sample) in record.samples.iter_mut().enumerate() {
        while let Some((_, jump_rad)) = found.next_if(|(at, _)| *at == row) {
            jumped_rad += jump_rad;
        }
        if jumped_rad != 0.0 {
            sample.heading_rad = Real::wrapped(sample.heading_rad - jumped_rad);
        }
    }
}

/// The rows behind jumps, and what the heading jumps by there, rad.
fn jumps(samples: &[Sample<f64>]) -> Vec<(usize, f64)> {
    let beside = |pair: &[Sample<f64>]| {
        let mean_rad_s = 0.5 * (pair[0].yaw_rate_rad_s? + pair[1].yaw_rate_rad_s?);
        let beside =
            turned_rad(&pair[0], &pair[1]) - mean_rad_s * (pair[1].time_s - pair[0].time_s);
        beside.is_finite().then_some(beside)
    };
    let Some(beside): Option<Vec<f64>> = samples.windows(2).map(beside).collect() else {
        return Vec::new();
    };
    let steps: Vec<f64> = turns_rad(samples).collect();
    let middle = median(beside.clone()).unwrap_or(0.0);
    let apart = median(beside.iter().map(|j| (j - middle).abs()).collect());
    let least_rad = LEAST_JUMP_RAD.max(FAR * DEVIATION * apart.unwrap_or(0.0));
    let is_own = |at: usize, jump_rad: f64| {
        let about = about(&steps, at);
        let is_stuck = about.iter().filter(|step| **step == 0.0).count() > 1;
        let usual = median(about).unwrap_or(0.0);
        (steps[at] - usual).abs() > OWN * jump_rad.abs() && !is_stuck
    };
    let is_jump = |at: &usize| {
        let jump_rad = beside[*at] - middle;
        jump_rad.abs() > least_rad && is_own(*at, jump_rad)
    };
    let found: Vec<usize> = (ABOUT..steps.len().saturating_sub(ABOUT)).filter(is_jump).collect();
    if found.is_empty() {
        return Vec::new();
    }
    let gap_s = shortest_gap_s(samples);
    let is_over_a_gap = |at: usize| samples[at + 1].time_s - samples[at].time_s >= gap_s;
    found
        .into_iter()
        .filter(|at| !is_over_a_gap(*at))
        .map(|at| (at + 1, beside[at] - middle))
        .collect()
}

/// The steps about one, without it.
fn about(steps: &[f64], at: usize) -> Vec<f64> {
    let near = &steps[at - ABOUT..=at + ABOUT];
    let others = near.iter().enumerate().filter(|(i, _)| *i != ABOUT);
    others.map(|(_, step)| *step).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stated_units::{ColumnUnit, Origin};

    /// A weave of 20 deg, with jumps of the compass at these rows.
    fn weaving(jumps: &[(usize, f64)]) -> Record {
        let noise = |k: usize| 1e-3 * ((k * 7919 % 13) as f64 - 6.0);
        let samples = (0..1000).map(|k| {
            let time_s = 0.1 * k as f64;
            let jumped: f64 = jumps.iter().filter(|(row, _)| k >= *row).map(|j| j.1).sum();
            Sample {
                time_s,
                heading_rad: 0.35 * (0.3 * time_s).sin() + noise(k) + jumped,
                yaw_rate_rad_s: Some(0.35 * 0.3 * (0.3 * time_s).cos()),
                ..Sample::default()
            }
        });
        let mut record: Record = samples.collect();
        record.units.heading = ColumnUnit { origin: Origin::Stated, ..ColumnUnit::default() };
        record
    }

    #[test]
    fn recover_a_heading_that_jumped() {
        let mut record = weaving(&[(300, 0.12), (610, -0.1)]);
        take_off(&mut record);
        let found = record.units.heading_jumps.unwrap();
        assert_eq!(found.count, 2);
        assert!((found.largest_rad - 0.12).abs() < 0.015, "{found:?}");
        let sound = weaving(&[]);
        for (found, sound) in record.samples.iter().zip(&sound.samples) {
            // The noise of the rows about both jumps.
            assert!((found.heading_rad - sound.heading_rad).abs() < 0.03);
        }
    }

    #[test]
    fn exact_a_sound_heading_a_stuck_one_and_a_gyro_that_spikes_stay() {
        let sound = weaving(&[]);
        let mut stuck = weaving(&[]);
        for row in 300..308 {
            stuck.samples[row].heading_rad = stuck.samples[300].heading_rad;
        }
        let mut spike = weaving(&[]);
        spike.samples[400].yaw_rate_rad_s = Some(3.0);
        for before in [sound, stuck, spike] {
            let mut after = before.clone();
            take_off(&mut after);
            assert_eq!(after.units.heading_jumps, None);
            assert_eq!(after.samples, before.samples);
        }
    }
}
