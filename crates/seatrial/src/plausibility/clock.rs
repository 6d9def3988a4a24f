//! Did the clock jump, or were rows lost?
//!
//! ```text
//! d = psi(after) - psi(before),   d ~ r dt where rows were lost,   d ~ r h where the clock jumped
//! ```
//!
//! | symbol | meaning |
//! |---|---|
//! | dt, h | time over the gap, and the usual interval, s |
//! | r | yaw rate from straight lines through the headings before and after the gap, rad/s |
//!
//! Only a gap on both sides of which the vehicle turns the same way tells. Where the clock jumps and the vehicle does not turn, the
//! rudder's record is as wrong, but a model from it predicts no other manoeuvre.

use seatrial_core::{Real, Sample};

use super::doubt::Doubt;
use crate::line::Line;
use crate::record::{Record, median_interval_s, turned_rad};

/// A gap is longer than so many usual intervals, and matters to the vehicle: times that are rounded to a second are nothing to a ship.
const GAP: f64 = 3.0;
const GAP_TIME_CONSTANTS: f64 = 0.1;
/// Headings on either side, in time constants of the vehicle, and how many there must be.
const SIDE: f64 = 0.3;
const LEAST_ROWS: usize = 4;
const MOST_ROWS: usize = 40;
/// Standard deviations of a yaw rate that is one, and of a change that agrees or differs, to which shares of the turn over the gap
/// are added for a rate that changes.
const TURNS: f64 = 4.0;
const AGREES: [f64; 2] = [3.0, 0.2];
const DIFFERS: [f64; 2] = [6.0, 0.5];

/// The first gap over which the heading went on as if no time had passed.
pub(super) fn jump(samples: &[Sample<f64>], time_constant_s: f64) -> Option<Doubt> {
    let usual_s = median_interval_s(samples)?;
    let rows = ((SIDE * time_constant_s / usual_s) as usize).clamp(LEAST_ROWS, MOST_ROWS);
    let noise_rad = noise_rad(samples);
    let is_jump = |before: usize| {
        let gap_s = samples[before + 1].time_s - samples[before].time_s;
        let (left, right) = (
            samples.get((before + 1).checked_sub(rows)?..=before)?,
            samples.get(before + 1..=before + rows)?,
        );
        let (left, right) = (line(left, left.last()?)?, line(right, right.first()?)?);
        let rates = [left.slope, right.slope];
        let turns = |line: &Line| line.slope.abs() > TURNS * noise_rad * line.slope_error();
        let turns_on = rates[0] * rates[1] > 0.0 && turns(&left) && turns(&right);
        let rate_rad_s = 0.5 * (rates[0] + rates[1]);
        let [end, start] = [samples[before].heading_rad, samples[before + 1].heading_rad];
        let moved_rad = Real::wrapped(start - end) + right.at(0.0) - left.at(0.0);
        let error = |over_s: f64| {
            let of_rates = over_s * 0.5 * libm::hypot(left.slope_error(), right.slope_error());
            noise_rad * libm::hypot(of_rates, libm::hypot(left.error_at(0.0), right.error_at(0.0)))
        };
        let is_near = |over_s: f64, [deviations, share]: [f64; 2]| {
            let limit = deviations * error(over_s) + share * (rate_rad_s * gap_s).abs();
            (moved_rad - rate_rad_s * over_s).abs() < limit
        };
        let (as_a_row, as_time) = (is_near(usual_s, AGREES), is_near(gap_s, DIFFERS));
        (turns_on && as_a_row && !as_time).then_some(gap_s)
    };
    let shortest_s = (GAP * usual_s).max(GAP_TIME_CONSTANTS * time_constant_s);
    let gap_s = (0..samples.len() - 1)
        .filter(|row| samples[row + 1].time_s - samples[*row].time_s > shortest_s)
        .find_map(is_jump)?;
    Some(Doubt::ClockJumped { gap_s })
}

/// Does the time go up by exactly 1 with every row?
pub(super) fn counts(record: &Record) -> bool {
    counts_by(record, 1.0)
}

/// Does the time go up by this interval with every row, but for rounding?
pub(super) fn counts_by(record: &Record, interval_s: f64) -> bool {
    record.samples.windows(2).all(|pair| {
        let step_s = pair[1].time_s - pair[0].time_s;
        (step_s - interval_s).abs() <= 1e-6 * interval_s
    })
}

/// Standard deviation of a heading's noise from the median of second differences, rad.
fn noise_rad(samples: &[Sample<f64>]) -> f64 {
    let mut differences: Vec<f64> = samples
        .windows(3)
        .map(|three| (turned_rad(&three[1], &three[2]) - turned_rad(&three[0], &three[1])).abs())
        .collect();
    if differences.is_empty() {
        return 0.0;
    }
    let middle = differences.len() / 2;
    let (_, median, _) = differences.select_nth_unstable_by(middle, f64::total_cmp);
    // The median of |N(0, 6 sigma^2)|.
    *median / (0.674_489_75 * 6_f64.sqrt())
}

/// A straight line through headings beside a gap: times from the sample `at` next to the gap, s, and headings above its own, rad.
fn line(samples: &[Sample<f64>], at: &Sample<f64>) -> Option<Line> {
    let (times_s, headings_rad): (Vec<f64>, Vec<f64>) = samples
        .iter()
        .map(|s| (s.time_s - at.time_s, Real::wrapped(s.heading_rad - at.heading_rad)))
        .unzip();
    Line::through(&times_s, &headings_rad)
}
