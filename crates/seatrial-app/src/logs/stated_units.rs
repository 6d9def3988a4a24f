//! The units of a log's columns, as plausibility checks need them.

use seatrial::log::{ColumnUnit, Origin, StatedUnits};
use seatrial_logs::{Channel, Counts, LogDescription, Quantity, UnitSource, names_a_course};

/// A clock is coarser than its rows where more than this share of them differs from the row before at the same time.
const SHARED: f64 = 0.05;
/// Where more than this share of the rows lacks a number, intervals are longer for that.
const MISSING: f64 = 0.01;

/// Which units a log states for time, heading, rudder, yaw rate and speed, and who says so. A column that a channel file scales
/// or turns was looked at by a person, and counts as given.
pub(crate) fn stated_units(description: &LogDescription, counts: &Counts) -> StatedUnits {
    let channel = |quantity| {
        let mut channels = description.channels.iter();
        channels.find(|channel| channel.quantity == quantity)
    };
    let of = |quantity| channel(quantity).map_or_else(ColumnUnit::default, column_unit);
    StatedUnits {
        time: of(Quantity::Time),
        heading: of(Quantity::Heading),
        rudder: of(Quantity::Rudder),
        yaw_rate: of(Quantity::YawRate),
        speed: of(Quantity::Speed),
        heading_is_course: channel(Quantity::Heading)
            .is_some_and(|heading| names_a_course(&heading.column)),
        time_is_a_date: description.start_utc.is_some(),
        yaw_rate_is_reversed: false,
        yaw_rate_is_derived: false,
        heading_every_s: None,
        heading_jumps: None,
        times_are_shared: counts.differing_at_a_time as f64 > SHARED * counts.rows as f64,
        rows_are_missing: counts.missing as f64 > MISSING * counts.rows as f64,
        is_damaged: counts.is_damaged,
    }
}

fn column_unit(channel: &Channel) -> ColumnUnit {
    ColumnUnit {
        per_si: 1.0 / channel.scale.abs(),
        is_against_name: channel.against.is_some(),
        origin: match channel.unit_source {
            UnitSource::Chosen => Origin::Given,
            UnitSource::Stated => Origin::Stated,
            UnitSource::Assumed => Origin::Assumed,
        },
    }
}
