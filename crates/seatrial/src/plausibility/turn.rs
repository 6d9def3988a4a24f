//! Does the yaw rate integrate to the heading?

use seatrial_core::{Real, Sample};

use super::doubt::{Doubt, RateMismatch};
use super::units::counts;
use crate::record::Record;

/// Rows over which a change of heading is compared, the next where noise hides it over the one before.
const SPANS: [usize; 3] = [5, 20, 60];
/// Columns that correlate less do not tell each other's unit.
const LEAST_CORRELATION: f64 = 0.7;
/// Ratios in which a compass that deviates and a gyro of a wrong scale are left to the compass's own test.
const SOUND: [f64; 2] = [0.5, 2.0];

/// Change of heading over the integral of the yaw rate, over spans of some rows:
///
/// ```text
/// ratio = sum(d psi * int r dt) / sum((int r dt)^2)
/// ```
///
/// `None` where there is no yaw rate, where it does not follow the heading, or where the two agree.
pub(super) fn doubt(record: &Record) -> Option<Doubt> {
    if record.units.yaw_rate_is_reversed {
        return Some(Doubt::RateMismatch(RateMismatch::REVERSED));
    }
    if !record.units.turn_is_open() {
        return None;
    }
    let ratio = SPANS.iter().find_map(|rows| ratio(record, *rows))?;
    let agrees = (SOUND[0]..=SOUND[1]).contains(&ratio);
    (!agrees).then(|| {
        Doubt::RateMismatch(RateMismatch {
            ratio,
            interval_s: record.median_interval_s().unwrap_or(f64::NAN),
            is_index: counts(record),
        })
    })
}

/// Leaves a yaw rate out that has the opposite sense of the heading, since what is measured against it would be wrong, or that was
/// computed from the heading, since it shows nothing of it.
pub fn leave_out_unsound_yaw_rate(record: &mut Record) {
    let is_reversed = matches!(
        doubt(record),
        Some(Doubt::RateMismatch(mismatch)) if mismatch.is_reversed()
    );
    let is_derived = !record.units.are_given() && is_derived(&record.samples);
    if is_reversed || is_derived {
        for sample in &mut record.samples {
            sample.yaw_rate_rad_s = None;
        }
        record.units.yaw_rate_is_reversed = is_reversed;
        record.units.yaw_rate_is_derived = is_derived;
    }
}

/// Nearly all yaw rates of a column that was computed agree; ends and turns through north may not.
const DERIVED: f64 = 0.95;
/// Rounding of the heading by a larger share of its differences hides how the column was made.
const LARGEST_ROUNDING: f64 = 0.02;
/// Fewer rows tell nothing.
const LEAST_ROWS: usize = 20;
/// Relative; what arithmetic in single precision leaves of a difference.
const ARITHMETIC: f64 = 1e-5;
/// A change is a whole number of steps if it is within so much of one.
const WHOLE: f64 = 0.1;

/// The step to which a column was rounded, from its changes; 0 where they are no whole numbers of a step.
fn resolution(changes: impl Iterator<Item = f64> + Clone) -> f64 {
    let changes = changes.map(f64::abs).filter(|change| *change > 0.0);
    let step = changes.clone().fold(f64::INFINITY, f64::min);
    let is_whole = |change: f64| (change / step - (change / step).round()).abs() < WHOLE;
    let (all, whole) = changes.fold((0.0, 0.0), |(all, whole), change| {
        (all + 1.0, whole + f64::from(is_whole(change)))
    });
    if step.is_finite() && whole >= DERIVED * all {
        step
    } else {
        0.0
    }
}

/// Is the yaw rate a difference of the heading over the row before, the next, or both, within the rounding of the heading?
fn is_derived(samples: &[Sample<f64>]) -> bool {
    let change =
        |one: &Sample<f64>, other: &Sample<f64>| Real::wrapped(other.heading_rad - one.heading_rad);
    let slope =
        |one: &Sample<f64>, other: &Sample<f64>| change(one, other) / (other.time_s - one.time_s);
    if samples.len() < LEAST_ROWS {
        return false;
    }
    let pairs = || samples.windows(2).map(|pair| (&pair[0], &pair[1]));
    let resolution_rad = resolution(pairs().map(|(one, other)| change(one, other)));
    let resolution_rad_s = resolution(
        pairs().filter_map(|(one, other)| Some(other.yaw_rate_rad_s? - one.yaw_rate_rad_s?)),
    );
    // The row before and this one, this one and the next, both neighbours.
    let ways = [[0, 1], [1, 2], [0, 2]];
    ways.into_iter().any(|[from, to]| {
        let mut square = 0.0;
        let mut agreeing = 0;
        let mut largest_rounding = 0.0_f64;
        for three in samples.windows(3) {
            let (one, other) = (&three[from], &three[to]);
            let slope = slope(one, other);
            let rounding = 2.0 * resolution_rad / (other.time_s - one.time_s);
            largest_rounding = largest_rounding.max(rounding);
            square += slope * slope;
            let agrees = |rate: f64| {
                (rate - slope).abs() <= rounding + resolution_rad_s + ARITHMETIC * slope.abs()
            };
            agreeing += usize::from(three[1].yaw_rate_rad_s.is_some_and(agrees));
        }
        let count = (samples.len() - 2) as f64;
        largest_rounding < LARGEST_ROUNDING * (square / count).sqrt()
            && agreeing as f64 >= DERIVED * count
    })
}

/// The ratio over spans of so many rows. `None` where the columns do not correlate.
fn ratio(record: &Record, rows: usize) -> Option<f64> {
    let (mut cross, mut turned_square, mut change_square) = (0.0, 0.0, 0.0);
    for span in record.samples.chunks(rows + 1) {
        let (Some(change), Some(turned)) = (change_rad(span), turned_rad(span)) else {
            continue;
        };
        cross += change * turned;
        turned_square += turned * turned;
        change_square += change * change;
    }
    let correlation = cross / (turned_square * change_square).sqrt();
    (correlation.abs() >= LEAST_CORRELATION).then(|| cross / turned_square)
}

fn change_rad(span: &[Sample<f64>]) -> Option<f64> {
    let change: f64 = span
        .windows(2)
        .map(|pair| Real::wrapped(pair[1].heading_rad - pair[0].heading_rad))
        .sum();
    change.is_finite().then_some(change)
}

fn turned_rad(span: &[Sample<f64>]) -> Option<f64> {
    span.windows(2)
        .map(|pair| {
            let (before, after) = (pair[0].yaw_rate_rad_s?, pair[1].yaw_rate_rad_s?);
            Some(0.5 * (before + after) * (pair[1].time_s - pair[0].time_s))
        })
        .sum::<Option<f64>>()
        .filter(|turned| turned.is_finite())
}
