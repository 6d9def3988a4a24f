//! The units that a log states, and numbers that they do not allow.

use super::clock::counts_by;
use super::doubt::Doubt;
use super::turn;
use crate::record::{Record, unwrapped_rad};
use crate::stated_units::{ColumnUnit, Origin};

/// A full turn in radians with some room for rounding.
const TURN_RAD: f64 = 6.3;
/// More turns than a heading in radians unwraps to in a trial, rad.
const MANY_TURNS_RAD: f64 = 40.0;
/// Whole numbers are within this of one: degrees go through radians.
const WHOLE: f64 = 1e-9;
/// A step by this share of a turn is a wrap.
pub(super) const WRAP: f64 = 0.8;
/// A sluggish vehicle changes its heading by at least this share of the rudder's range; a heading in radians beside a
/// rudder in degrees by 0.01 to 0.09.
const LEAST_TURN: f64 = 0.1;
/// A rudder within this number is no rudder in degrees.
const RADIANS: f64 = 0.6;
/// A rudder beyond this number is no rudder in radians: 92 deg.
const LARGEST_RUDDER_RAD: f64 = 1.6;
/// More counts in full rudder than per cent are those of a pulse width.
pub(super) const LEAST_PULSE: f64 = 100.5;
/// A share of full rudder beyond this one is none; trims and servos of uneven ends reach a little over 1.
const LARGEST_SHARE: f64 = 1.5;
/// Rudders are used up to these angles.
const USUAL_RUDDER_RAD: f64 = 0.7;
const USUAL_RUDDER_DEG: f64 = 46.0;
/// No manoeuvre is logged at longer intervals, s; a clock in milliseconds at 20 Hz shows 50.
const LONGEST_INTERVAL_S: f64 = 40.0;
/// No heading is logged at shorter intervals, s; a spreadsheet's days at 20 Hz show 6e-7.
const SHORTEST_INTERVAL_S: f64 = 5e-4;
/// No vessel turns faster, rad/s: 400 deg/s.
const FASTEST_TURN_RAD_S: f64 = 7.0;
/// A turn is looked at over so many samples, of which this share may be outliers.
const TURN_SAMPLES: usize = 20;
const OUTLIERS: f64 = 0.03;
/// The share from which a clock is doubted where every stamp is a whole number.
const LONGEST_WHOLE_INTERVAL_S: f64 = 15.0;

/// Compares the numbers with what their units allow.
pub(super) fn doubts(record: &Record) -> Vec<Doubt> {
    let against_name = record.units.rudder.is_against_name.then_some(Doubt::RudderAgainstName);
    [heading(record), rudder(record), against_name, time(record)].into_iter().flatten().collect()
}

/// A column's numbers as they stand in the file.
pub(super) fn numbers(
    record: &Record,
    of: fn(&seatrial_core::Sample<f64>) -> f64,
    unit: &ColumnUnit,
) -> Vec<f64> {
    record
        .samples
        .iter()
        .map(|sample| of(sample) * unit.per_si)
        .filter(|number| number.is_finite())
        .collect()
}

fn largest(numbers: &[f64]) -> f64 {
    numbers.iter().fold(0.0, |largest: f64, n| largest.max(n.abs()))
}

/// The lowest and the highest number.
fn ends(numbers: &[f64]) -> Option<[f64; 2]> {
    let low = numbers.iter().copied().reduce(f64::min)?;
    Some([low, numbers.iter().copied().reduce(f64::max)?])
}

fn range(numbers: &[f64]) -> f64 {
    ends(numbers).map_or(0.0, |[low, high]| high - low)
}

fn heading(record: &Record) -> Option<Doubt> {
    let unit = &record.units.heading;
    if record.units.are_given() || unit.is_scaled() {
        return None;
    }
    let headings = numbers(record, |s| s.heading_rad, unit);
    let largest = largest(&headings);
    let said_degrees = unit.is_degrees();
    let turn = if said_degrees { std::f64::consts::TAU } else { 360.0 };
    let wraps = wraps_at(&headings, turn);
    if said_degrees && is_of_half_a_turn(&headings) {
        return Some(Doubt::HeadingHalfTurn);
    }
    if said_degrees && unit.origin == Origin::Assumed && !wraps_at(&headings, 360.0) {
        let has_rate = record.samples.iter().any(|s| s.yaw_rate_rad_s.is_some());
        let are_whole = headings.iter().all(|heading| (heading - heading.round()).abs() < WHOLE);
        if !has_rate && are_whole {
            return Some(Doubt::HeadingCounts { largest });
        }
    }
    let is_doubtful = match (said_degrees, unit.origin) {
        (true, _) => largest <= TURN_RAD && (wraps || turns_too_little(record, &headings)),
        (false, Origin::Given) => wraps || begins_turned(record, &headings),
        (false, origin) => largest > MANY_TURNS_RAD && (wraps || origin == Origin::Stated),
    };
    is_doubtful.then_some(Doubt::HeadingUnit {
        said_degrees,
        largest,
        wraps,
        is_given: unit.origin == Origin::Given,
    })
}

/// Does a heading that stays within 180 deg jump between both ends, and not back at once as an outlier does?
fn is_of_half_a_turn(headings_deg: &[f64]) -> bool {
    const HALF_DEG: f64 = 180.0;
    let is_inside = |heading: &f64| (0.0..=HALF_DEG).contains(heading);
    let is_jump = |pair: &[f64]| wraps_at(pair, HALF_DEG);
    let is_alone =
        |four: &[f64]| is_jump(&four[1..3]) && !is_jump(&four[..2]) && !is_jump(&four[2..]);
    headings_deg.iter().all(is_inside) && headings_deg.windows(4).any(is_alone)
}

/// Is a step of a turn between two numbers?
pub(super) fn wraps_at(headings: &[f64], turn: f64) -> bool {
    headings
        .windows(2)
        .any(|pair| (WRAP * turn..=1.001 * turn).contains(&(pair[1] - pair[0]).abs()))
}

/// Does the heading begin more than a turn from north, with no yaw rate to show that it is in radians all the same?
fn begins_turned(record: &Record, headings_rad: &[f64]) -> bool {
    let has_rate = record.samples.iter().any(|s| s.yaw_rate_rad_s.is_some());
    !has_rate && headings_rad.first().is_some_and(|first| first.abs() > TURN_RAD)
}

/// Does the heading change by less than a tenth of the rudder's range?
fn turns_too_little(record: &Record, headings_deg: &[f64]) -> bool {
    if record.rudder_unit != crate::record::RudderUnit::Rad {
        return false;
    }
    let rudders: Vec<f64> = record.samples.iter().map(|s| s.rudder_rad).collect();
    range(headings_deg) < LEAST_TURN * range(&rudders).to_degrees()
}

fn rudder(record: &Record) -> Option<Doubt> {
    let (unit, heading) = (&record.units.rudder, &record.units.heading);
    let rudders = numbers(record, |s| s.rudder_rad, unit);
    let largest = largest(&rudders);
    let is_angle = record.rudder_unit == crate::record::RudderUnit::Rad;
    let said_degrees = unit.is_degrees();
    let is_beyond = is_angle && largest / unit.per_si > LARGEST_RUDDER_RAD;
    if is_beyond && unit.origin != Origin::Assumed && !record.units.are_given() {
        return Some(Doubt::RudderUnit { said_degrees, largest });
    }
    let share = largest / unit.per_si;
    if !is_angle && unit.origin != Origin::Assumed && share > LARGEST_SHARE {
        return Some(Doubt::RudderBeyondFull { largest: share });
    }
    let of_one_side = ends(&rudders).filter(|[low, high]| low * high > 0.0 && *low != *high);
    if let Some(ends) = of_one_side.filter(|_| !is_angle && !record.units.are_given()) {
        let shares = ends.map(|rudder| rudder / unit.per_si);
        return Some(Doubt::RudderOfOneSide { shares });
    }
    if !unit.is_open() || largest == 0.0 {
        return None;
    }
    if unit.origin == Origin::Stated {
        let is_doubtful = is_angle && said_degrees && largest <= RADIANS;
        return is_doubtful.then_some(Doubt::RudderUnit { said_degrees, largest });
    }
    let (taken_as, usual) = match (is_angle, said_degrees) {
        (true, true) => ("degrees", USUAL_RUDDER_DEG),
        // Full rudder was given in degrees.
        (true, false) if unit.per_si != 1.0 => return None,
        (true, false) => ("radians", USUAL_RUDDER_RAD),
        // A pulse width shows by its values, and its b2 is that of full rudder.
        (false, _) if unit.per_si > LEAST_PULSE => return None,
        // A share is assumed of motors alone, which have no angle.
        (false, _) if unit.per_si == 1.0 => return None,
        (false, _) => ("a share of full rudder", 0.0),
    };
    // A log that states the unit of its heading would state that of an angle of the rudder.
    let others_are_stated = heading.origin == Origin::Stated;
    let is_beside_others =
        heading.origin == Origin::Assumed && heading.is_degrees() != said_degrees;
    (largest > usual || others_are_stated || is_beside_others)
        .then_some(Doubt::RudderScale { taken_as, largest })
}

fn time(record: &Record) -> Option<Doubt> {
    let unit = &record.units.time;
    let (first, interval_s) = (record.samples.first()?, record.median_interval_s()?);
    if interval_s > 0.0 && interval_s < SHORTEST_INTERVAL_S {
        return Some(Doubt::TimeUnit { interval_s });
    }
    if let Some(yaw_rate_rad_s) = usual_turn_rad_s(record).filter(|r| *r > FASTEST_TURN_RAD_S) {
        let is_assumed = |unit: &ColumnUnit| unit.origin == Origin::Assumed;
        return Some(Doubt::TurnsTooFast {
            yaw_rate_rad_s,
            is_of_heading: is_assumed(&record.units.heading) && !is_assumed(unit),
        });
    }
    if record.units.are_given() || record.units.time_is_a_date {
        return None;
    }
    let is_taken_for_seconds = unit.is_open() && unit.per_si == 1.0;
    let is_whole = record.samples.iter().all(|s| s.time_s.fract() == 0.0);
    let is_long = is_whole && interval_s >= LONGEST_WHOLE_INTERVAL_S;
    if interval_s >= LONGEST_INTERVAL_S || (is_taken_for_seconds && is_long) {
        return Some(Doubt::TimeUnit { interval_s });
    }
    // A yaw rate of the other sense and the right size shows the time as well.
    let has_rate = record.units.yaw_rate_is_reversed
        || record.samples.iter().any(|s| s.yaw_rate_rad_s.is_some());
    let has_rate = has_rate
        && (record.units.yaw_rate.origin != Origin::Assumed || turn::agrees_closely(record));
    let is_open = !has_rate && unit.origin == Origin::Assumed;
    if is_open && unit.per_si != 1.0 {
        return Some(time_assumed(record, interval_s));
    }
    // A column that says seconds is believed, unless a program that made another column of the heading counted rows, too.
    let is_said = unit.origin == Origin::Stated && !record.units.yaw_rate_is_derived;
    // Rows that were left out leave others that may be whole seconds apart.
    let is_whole_log = record.units.heading_every_s.is_none();
    if is_taken_for_seconds && !has_rate && is_whole_log && counts_rows(record) {
        return Some(Doubt::TimeIsIndex { is_stated: is_said });
    }
    // Whole numbers from 0 may be counts of a clock; a time of day begins elsewhere.
    (is_open && is_whole && first.time_s == 0.0).then(|| time_assumed(record, interval_s))
}

/// Unusual rows or turns count for more than any interval, as a logarithm.
const FAR: f64 = 100.0;
/// Units of a clock's counts, by their number in a second.
const COUNTS: [(&str, f64); 5] = [("s", 1.0), ("cs", 1e2), ("ms", 1e3), ("us", 1e6), ("ns", 1e9)];
/// Intervals between rows that are logged at all, s.
const LOGGED_INTERVAL_S: [f64; 2] = [SHORTEST_INTERVAL_S, 5.0];
/// Intervals between rows that loggers usually write, s, and the fastest turns of usual vessels, rad/s.
const USUAL_INTERVAL_S: [f64; 2] = [0.04, 2.0];
const MOST_USUAL_INTERVAL_S: f64 = 0.1;
const USUAL_TURN_RAD_S: [f64; 2] = [0.003, 0.8];

/// The units by which rows come as loggers write them and the vehicle turns as vessels do come first, the largest count of a second last.
fn time_assumed(record: &Record, interval_s: f64) -> Doubt {
    let counts_per_s = record.units.time.per_si;
    let turn_rad_s = usual_turn_rad_s(record);
    let is_within = |value: f64, [least, most]: [f64; 2]| (least..=most).contains(&value);
    let mut units: Vec<(f64, (&str, f64))> = COUNTS
        .into_iter()
        .map(|(unit, per_s)| (unit, counts_per_s / per_s))
        .map(|(unit, times)| {
            let turns = turn_rad_s.is_none_or(|turn| is_within(turn / times, USUAL_TURN_RAD_S));
            let rows = is_within(interval_s * times, USUAL_INTERVAL_S);
            let unusual = usize::from(!turns) + usize::from(!rows);
            let from_usual = libm::log(interval_s * times / MOST_USUAL_INTERVAL_S).abs();
            (unusual as f64 * FAR + from_usual, (unit, interval_s * times))
        })
        .filter(|(_, (_, interval_s))| is_within(*interval_s, LOGGED_INTERVAL_S))
        .collect();
    units.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    units.truncate(2);
    let units = units.into_iter().map(|(_, unit)| unit).collect();
    Doubt::TimeAssumed { interval_s, units }
}

/// The fastest turn that no outlier makes.
fn usual_turn_rad_s(record: &Record) -> Option<f64> {
    let usable = || record.samples.iter().filter(|s| s.heading_rad.is_finite());
    let turned_rad = unwrapped_rad(0.0, usable().map(|s| s.heading_rad));
    let headings: Vec<(f64, f64)> = usable().map(|s| s.time_s).zip(turned_rad).collect();
    let mut rates: Vec<f64> = headings
        .windows(TURN_SAMPLES)
        .map(|part| {
            let (first, last) = (part[0], part[TURN_SAMPLES - 1]);
            (last.1 - first.1).abs() / (last.0 - first.0)
        })
        .filter(|rate| rate.is_finite())
        .collect();
    let last = rates.len().checked_sub(1)?;
    let at = last.min(((1.0 - OUTLIERS) * rates.len() as f64) as usize);
    Some(*rates.select_nth_unstable_by(at, f64::total_cmp).1)
}

/// Does the time, in the unit of its column, begin at 0 or 1 and go up by 1 with every row?
fn counts_rows(record: &Record) -> bool {
    let unit = &record.units.time;
    let first = record.samples.first();
    first.is_some_and(|first| [0.0, 1.0].contains(&(first.time_s * unit.per_si)))
        && counts_by(record, unit.per_si.recip())
}
