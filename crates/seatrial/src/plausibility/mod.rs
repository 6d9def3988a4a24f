//! Do a log's numbers mean what its columns say?
//!
//! | doubt | what is compared |
//! |---|---|
//! | unit of heading or rudder | the numbers in the file with those that the unit allows |
//! | scale of the rudder | what the file says of its unit with what it says of the others |
//! | unit that is assumed | nothing in the file says it, and no turn through north, date or yaw rate shows it |
//! | unit of time or yaw rate | the heading's change with the integral of the yaw rate; without a yaw rate, the interval between samples |
//! | time and heading by which the vehicle turns too fast, given or not | the heading's change over 20 samples with 400 deg/s |
//! | yaw rate that is computed from the heading | the noise of the yaw rate with that of the heading; it is then no witness |
//! | time whose unit is assumed | there is no witness of it |
//! | heading that is a course | the name of its column |
//! | clock that jumped | the heading's change over a gap in time with its rate before and after |
//! | heading that was interpolated | straight lines that end after the same number of rows, and lines from one side of north to the other through south |
//! | heading that was smoothed | the noise of neighbouring rows, where the heading follows the rudder late |
//! | heading that jumped | its step from one row to the next beside the yaw rate, where it stands out from the steps about it |
//! | heading that stood still | equal headings in a row with the yaw rate, where the heading else changes in every row |
//! | heading that is late beside another | the shift that leaves least of their difference |
//! | slow rows, held channels | the interval at which a channel changes with the vehicle's time constant 1/|a22| |
//!
//! A unit that the user gave is doubted only where no vehicle could move so: giving it is how a doubt is settled.

mod assumed;
mod clock;
mod derived;
mod doubt;
mod heading_words;
mod interpolated;
mod jumps;
mod mismatch;
mod refresh;
mod rudder_words;
mod stood;
mod time_words;
mod turn;
mod two_headings;
mod units;

use seatrial_core::Sample;

use crate::record::Record;
pub use derived::heading_is_smoothed;
pub use doubt::Doubt;
pub use stood::heading_stood;
pub use two_headings::heading_later_s;

/// What is doubtful about the units of a record's columns, whatever model it gives.
pub fn unit_doubts(record: &Record) -> Vec<Doubt> {
    let mut doubts = units::doubts(record);
    if record.units.heading_is_course {
        doubts.push(Doubt::HeadingIsCourse);
    }
    if record.units.is_damaged {
        doubts.push(Doubt::Damaged);
    }
    doubts.extend(turn::doubt(record));
    doubts.extend(interpolated::through_south(record));
    let every_s = record.units.heading_every_s;
    doubts.extend(every_s.map(|every_s| Doubt::HeadingInterpolated { every_s }));
    doubts.extend(record.units.heading_jumps.map(Doubt::HeadingJumped));
    if !doubts.iter().any(Doubt::refuses) {
        doubts.extend(assumed::doubt(record));
    }
    doubts
}

/// Leaves out what was not measured, since it shows nothing, or a wrong model: a yaw rate of the opposite sense of the heading or computed
/// from it, rows whose heading was interpolated, and jumps of the heading that a gyro proves.
pub fn leave_out_unsound(record: &mut Record) {
    turn::leave_out_unsound_yaw_rate(record);
    if !record.units.are_given() {
        interpolated::leave_out_interpolated(record);
        jumps::take_off(record);
    }
}

/// What is doubtful about when the channels of a training record were logged, for a vehicle with this damping.
pub fn timing_doubts(samples: &[Sample<f64>], a22_per_s: f64) -> Vec<Doubt> {
    if a22_per_s.is_nan() || a22_per_s >= 0.0 {
        return Vec::new();
    }
    let time_constant_s = -1.0 / a22_per_s;
    let mut doubts = refresh::doubts(samples, time_constant_s);
    doubts.extend(clock::jump(samples, time_constant_s));
    doubts
}

/// The doubt about a training record whose clock is coarser than its rows, for a vehicle with this damping.
pub fn shared_times(samples: &[Sample<f64>], a22_per_s: f64) -> Option<Doubt> {
    refresh::shared_times(samples, a22_per_s.abs().recip())
}

/// What no model of a record that was read from a log can show, sound or not.
pub fn unchecked(record: &Record) -> Vec<Doubt> {
    if record.units.are_given() {
        return Vec::new();
    }
    let has_rate = record.samples.iter().any(|s| s.yaw_rate_rad_s.is_some_and(f64::is_finite));
    let heading = (!has_rate && !record.units.yaw_rate_is_reversed)
        .then_some(Doubt::HeadingUnchecked { is_derived: record.units.yaw_rate_is_derived });
    heading.into_iter().chain([Doubt::RudderUnchecked]).collect()
}

#[cfg(test)]
mod tests;
