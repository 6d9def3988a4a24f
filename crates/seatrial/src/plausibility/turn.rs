//! Does the yaw rate integrate to the heading?

use seatrial_core::Sample;

use super::clock::counts;
use super::derived::is_derived;
use super::doubt::Doubt;
use super::mismatch::RateMismatch;

use crate::record::{Record, turns_rad};
use crate::stated_units::Origin;

/// Rows over which a change of heading is compared, the next where noise hides it over the one before.
const SPANS: [usize; 3] = [5, 20, 60];
/// Columns that correlate less do not tell each other's unit.
const LEAST_CORRELATION: f64 = 0.7;
/// Ratios in which a compass that deviates and a gyro of a wrong scale are left to the compass's own test.
const SOUND: [f64; 2] = [0.5, 2.0];

/// And for a time that counts rows, which the yaw rate must prove: less than that compass and gyro err by.
const SOUND_FOR_ROWS: [f64; 2] = [0.8, 1.25];

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
    let is_index = counts(record) && !record.units.time_is_a_date;
    // A yaw rate whose unit was chosen because it is the nearest agrees within a factor of 8 with anything.
    let is_chosen = record.units.yaw_rate.origin == Origin::Assumed;
    let [least, most] = match is_index || is_chosen {
        true => SOUND_FOR_ROWS,
        false => SOUND,
    };
    (!(least..=most).contains(&ratio)).then(|| {
        Doubt::RateMismatch(RateMismatch {
            ratio,
            interval_s: record.median_interval_s().unwrap_or(f64::NAN),
            is_index,
            time_per_s: (record.units.time.origin == Origin::Assumed)
                .then_some(record.units.time.per_si),
        })
    })
}

/// Does a yaw rate show how much and how fast the heading turns?
pub(super) fn agrees(record: &Record) -> bool {
    let ratio = SPANS.iter().find_map(|rows| ratio(record, *rows));
    ratio.is_some_and(|ratio| (SOUND[0]..=SOUND[1]).contains(&ratio))
}

/// As exactly as compass and gyro err?
pub(super) fn agrees_closely(record: &Record) -> bool {
    let ratio = SPANS.iter().find_map(|rows| ratio(record, *rows));
    ratio.is_some_and(|ratio| (SOUND_FOR_ROWS[0]..=SOUND_FOR_ROWS[1]).contains(&ratio.abs()))
}

/// Leaves a yaw rate out that has the opposite sense of the heading, since what is measured against it would be wrong, or that was
/// computed from the heading, since it shows nothing of it.
pub(super) fn leave_out_unsound_yaw_rate(record: &mut Record) {
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
    let change: f64 = turns_rad(span).sum();
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
