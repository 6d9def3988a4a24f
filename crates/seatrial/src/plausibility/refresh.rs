//! Is every channel logged as often as the vehicle needs it?
//!
//! ```text
//! |d a22| / |a22| = 2 |late| |a22|,   late = (refresh - row) / 2
//! ```
//!
//! | symbol | meaning |
//! |---|---|
//! | refresh | interval at which a channel changes, s |
//! | row | interval between samples, s |
//!
//! One sample of delay shifts a22 by 8 to 11 % at 20 Hz and a time constant of 1 s.

use seatrial_core::Sample;

use super::doubt::Doubt;
use crate::record::{median_interval_s, turns_rad};

/// An effect on a22 under this share is left to the interval.
const LEAST_EFFECT: f64 = 0.02;
/// Rows beside each other over which the heading must turn by as many of its smallest steps.
const TURNING_ROWS: usize = 5;
/// A channel in which fewer turning rows repeat is not held: noise and resolution repeat some.
const LEAST_REPEATED: f64 = 0.4;
/// Fewer rows tell nothing.
const LEAST_ROWS: usize = 20;
/// A rudder of fewer angles is a relay's, which may stand still for long.
const LEAST_ANGLES: usize = 10;

pub(super) fn doubts(samples: &[Sample<f64>], time_constant_s: f64) -> Vec<Doubt> {
    let Some(interval_s) = median_interval_s(samples) else {
        return Vec::new();
    };
    let effect = |refresh_s: f64| (refresh_s - interval_s) / time_constant_s;
    let heading = heading_refresh(samples).map(|rows| rows * interval_s);
    let rudder = rudder_refresh(samples).map(|rows| rows * interval_s);
    let heading =
        heading.map(|refresh_s| Doubt::HeadingHeld { refresh_s, effect: effect(refresh_s) });
    let rudder = rudder.map(|refresh_s| Doubt::RudderHeld { refresh_s, effect: effect(refresh_s) });
    let matters = |doubt: &Doubt| match doubt {
        Doubt::HeadingHeld { effect, .. } | Doubt::RudderHeld { effect, .. } => {
            *effect > LEAST_EFFECT
        }
        _ => true,
    };
    heading.into_iter().chain(rudder).filter(matters).collect()
}

/// The first of the rows that share a time is kept: what the rudder did at the others shows at the next time, a quarter of the
/// interval late on average.
pub(super) fn shared_times(samples: &[Sample<f64>], time_constant_s: f64) -> Option<Doubt> {
    let interval_s = median_interval_s(samples)?;
    let effect = 0.5 * interval_s / time_constant_s;
    (effect > LEAST_EFFECT).then_some(Doubt::TimesShared { interval_s, effect })
}

/// Rows between new headings while the vehicle turns, where more than chance repeats.
fn heading_refresh(samples: &[Sample<f64>]) -> Option<f64> {
    let steps: Vec<f64> = turns_rad(samples).collect();
    let smallest = steps
        .iter()
        .map(|step| step.abs())
        .filter(|step| *step > 0.0)
        .fold(f64::INFINITY, f64::min);
    let (mut turning, mut repeated) = (0_usize, 0_usize);
    for window in steps.windows(TURNING_ROWS) {
        let turned: f64 = window.iter().sum();
        if turned.abs() > TURNING_ROWS as f64 * smallest {
            turning += 1;
            repeated += usize::from(window[TURNING_ROWS / 2] == 0.0);
        }
    }
    let share = repeated as f64 / turning.max(1) as f64;
    (turning >= LEAST_ROWS && share >= LEAST_REPEATED).then(|| 1.0 / (1.0 - share))
}

/// Rows between new rudder angles, where it takes many angles and never two in two rows.
fn rudder_refresh(samples: &[Sample<f64>]) -> Option<f64> {
    let changes: Vec<usize> = (1..samples.len())
        .filter(|row| samples[*row].rudder_rad != samples[row - 1].rudder_rad)
        .collect();
    let mut angles: Vec<f64> = changes.iter().map(|row| samples[*row].rudder_rad).collect();
    angles.sort_by(f64::total_cmp);
    angles.dedup();
    if angles.len() < LEAST_ANGLES {
        return None;
    }
    let mut gaps: Vec<usize> = changes.windows(2).map(|pair| pair[1] - pair[0]).collect();
    gaps.sort_unstable();
    // Where rows and refreshes are no multiples of each other gaps of two lengths take turns.
    let refresh =
        gaps[..gaps.len() / 2 + 1].iter().sum::<usize>() as f64 / (gaps.len() / 2 + 1) as f64;
    (gaps[gaps.len() / 20] > 1).then_some(refresh)
}
