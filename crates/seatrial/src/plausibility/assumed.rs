//! Units that nobody stated.

use super::doubt::Doubt;
use super::turn;
use super::units::{LEAST_PULSE, numbers, wraps_at};
use crate::record::{Record, RudderUnit};
use crate::stated_units::{ColumnUnit, Origin};

/// Units of time by their counts in a second.
const TIMES: [(f64, &str); 4] = [(1.0, "s"), (1e2, "cs"), (1e3, "ms"), (1e6, "us")];
/// Units of speed by their counts in 1 m/s.
const SPEEDS: [(f64, &str); 2] = [(1.0, "m/s"), (1.95, "kn")];

/// The columns whose unit nobody stated and nothing in the log shows. A turn through north shows that of the heading, a date that of the
/// time, and a yaw rate in a unit that is known both, where it agrees; of the rudder a pulse width alone shows itself.
pub(super) fn doubt(record: &Record) -> Option<Doubt> {
    let units = &record.units;
    let [is_time, is_heading, is_rudder] =
        [units.time, units.heading, units.rudder].map(|unit| unit.origin == Origin::Assumed);
    let is_measured = units.yaw_rate.origin != Origin::Assumed && turn::agrees(record);
    let headings = numbers(record, |s| s.heading_rad, &units.heading);
    let is_angle = record.rudder_unit == RudderUnit::Rad;
    let is_pulse = !is_angle && units.rudder.per_si > LEAST_PULSE;
    let wraps = wraps_at(&headings, std::f64::consts::TAU * units.heading.per_si);
    let rudder = match (is_angle, units.rudder.is_degrees()) {
        (true, true) => "deg",
        (true, false) => "rad",
        (false, _) if units.rudder.per_si > 1.0 => "percent",
        (false, _) => "fraction",
    };
    let heading = if units.heading.is_degrees() { "deg" } else { "rad" };
    let first = |units: &[(f64, &'static str)], of: &ColumnUnit, last| {
        let is_of = |(per_si, _): &&(f64, &str)| of.per_si < 1.01 * per_si;
        units.iter().find(is_of).map_or(last, |(_, unit)| *unit)
    };
    let time = first(&TIMES, &units.time, "ns");
    let of_log = [
        ("heading", heading, is_heading && !wraps && !is_measured),
        ("rudder", rudder, is_rudder && !is_pulse),
        ("time", time, is_time && !units.time_is_a_date && !is_measured),
    ];
    let mut columns: Vec<_> = of_log
        .into_iter()
        .filter(|(_, _, is_assumed)| *is_assumed)
        .map(|(column, unit, _)| (column, unit))
        .collect();
    // By itself it makes no model doubtful.
    if !columns.is_empty() && units.speed.origin == Origin::Assumed {
        columns.push(("speed", first(&SPEEDS, &units.speed, "km/h")));
    }
    (!columns.is_empty()).then_some(Doubt::ScaleAssumed { columns })
}
