//! The units of the columns that a record was read from, and who says so.

use serde::{Deserialize, Serialize};

/// Where the unit of a column comes from, the surest first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Origin {
    /// The user.
    #[default]
    Given,
    /// The log.
    Stated,
    /// Nobody stated it: it was inferred from the values.
    Assumed,
}

/// A column's unit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ColumnUnit {
    /// Numbers in the column for one SI unit: 57.3 for degrees.
    pub per_si: f64,
    /// Where the unit comes from.
    pub origin: Origin,
    /// Was it chosen against one of another kind that the name of the column says?
    #[serde(default)]
    pub is_against_name: bool,
}

impl Default for ColumnUnit {
    fn default() -> Self {
        Self { per_si: 1.0, origin: Origin::Given, is_against_name: false }
    }
}

impl ColumnUnit {
    /// The one of two that is known less; against the name where either is.
    fn or_less_known(self, other: Self) -> Self {
        let less_known = match other.origin > self.origin {
            true => other,
            false => self,
        };
        Self { is_against_name: self.is_against_name || other.is_against_name, ..less_known }
    }

    /// Is it degrees?
    ///
    /// ```
    /// use seatrial::log::ColumnUnit;
    ///
    /// assert!(ColumnUnit { per_si: 1_f64.to_degrees(), ..ColumnUnit::default() }.is_degrees());
    /// assert!(!ColumnUnit::default().is_degrees());
    /// ```
    pub fn is_degrees(&self) -> bool {
        (self.per_si.to_radians() - 1.0).abs() < 0.01
    }

    /// Is it an angle in neither degrees nor radians: hundredths of a degree, or a column that a person scaled?
    ///
    /// ```
    /// use seatrial::log::ColumnUnit;
    ///
    /// // Hundredths of a degree, as MAVLink has them.
    /// assert!(ColumnUnit { per_si: 100.0 * 1_f64.to_degrees(), ..ColumnUnit::default() }.is_scaled());
    /// assert!(!ColumnUnit::default().is_scaled());
    /// ```
    pub fn is_scaled(&self) -> bool {
        !self.is_degrees() && (self.per_si - 1.0).abs() > 0.01
    }

    /// Was it not given by the user?
    ///
    /// ```
    /// use seatrial::log::{ColumnUnit, Origin};
    ///
    /// assert!(ColumnUnit { origin: Origin::Stated, ..ColumnUnit::default() }.is_open());
    /// assert!(!ColumnUnit::default().is_open());
    /// ```
    pub fn is_open(&self) -> bool {
        self.origin != Origin::Given
    }
}

/// Jumps of the heading that a gyro proves. They were taken off.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct HeadingJumps {
    /// How many there were.
    pub count: usize,
    /// The largest, rad, without sign.
    pub largest_rad: f64,
    /// When it was, s on the log's clock.
    pub largest_at_s: f64,
}

/// The units of the columns that a record was read from. The default is SI, and given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StatedUnits {
    /// Time.
    pub time: ColumnUnit,
    /// Heading.
    pub heading: ColumnUnit,
    /// Rudder; its numbers for one radian, or for full rudder.
    pub rudder: ColumnUnit,
    /// Yaw rate.
    pub yaw_rate: ColumnUnit,
    /// Speed.
    #[serde(default)]
    pub speed: ColumnUnit,
    /// Does the column of the heading name a course over ground?
    #[serde(default)]
    pub heading_is_course: bool,
    /// Does the time say when, as a date or as seconds since 1970? Its unit is then known.
    #[serde(default)]
    pub time_is_a_date: bool,
    /// Had the yaw rate the opposite sense of the heading? It was then left out.
    #[serde(default)]
    pub yaw_rate_is_reversed: bool,
    /// Was the yaw rate computed from the heading? It was then left out: it is no witness of heading or time.
    #[serde(default)]
    pub yaw_rate_is_derived: bool,
    /// The interval between measured headings, s, where those between were interpolated. They were then left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub heading_every_s: Option<f64>,
    /// Jumps of the heading, where it had any. They were taken off.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub heading_jumps: Option<HeadingJumps>,
    /// Do rows that differ share a time? The clock is then coarser than the rows.
    #[serde(default)]
    pub times_are_shared: bool,
    /// Were rows left out for want of a number? Intervals over them say nothing of the clock.
    #[serde(default)]
    pub rows_are_missing: bool,
    /// Was a part of the log left out because it is damaged?
    #[serde(default)]
    pub is_damaged: bool,
}

impl StatedUnits {
    /// Did the caller give them all, as one does who makes samples?
    ///
    /// ```
    /// use seatrial::Record;
    /// use seatrial::log::StatedUnits;
    ///
    /// // Who makes samples knows their units.
    /// assert!(Record::default().units.are_given());
    /// assert!(!StatedUnits { heading_is_course: true, ..StatedUnits::default() }.are_given());
    /// ```
    pub fn are_given(&self) -> bool {
        *self == Self::default()
    }

    /// Those of two records that are joined: what is doubtful in one is doubtful.
    pub(crate) fn and(&self, other: &Self) -> Self {
        let jumps = [self.heading_jumps, other.heading_jumps];
        let of_jumps = jumps.iter().flatten();
        let largest =
            (of_jumps.clone().copied()).max_by(|a, b| a.largest_rad.total_cmp(&b.largest_rad));
        Self {
            time: self.time.or_less_known(other.time),
            heading: self.heading.or_less_known(other.heading),
            rudder: self.rudder.or_less_known(other.rudder),
            yaw_rate: self.yaw_rate.or_less_known(other.yaw_rate),
            speed: self.speed.or_less_known(other.speed),
            heading_is_course: self.heading_is_course || other.heading_is_course,
            time_is_a_date: self.time_is_a_date && other.time_is_a_date,
            yaw_rate_is_reversed: self.yaw_rate_is_reversed || other.yaw_rate_is_reversed,
            yaw_rate_is_derived: self.yaw_rate_is_derived || other.yaw_rate_is_derived,
            heading_every_s: [self.heading_every_s, other.heading_every_s]
                .into_iter()
                .flatten()
                .reduce(f64::max),
            heading_jumps: largest.map(|largest| HeadingJumps {
                count: of_jumps.map(|jumps| jumps.count).sum(),
                ..largest
            }),
            times_are_shared: self.times_are_shared || other.times_are_shared,
            rows_are_missing: self.rows_are_missing || other.rows_are_missing,
            is_damaged: self.is_damaged || other.is_damaged,
        }
    }

    /// Did the log say, or was it assumed, what time, heading or yaw rate are?
    pub(crate) fn turn_is_open(&self) -> bool {
        [self.time, self.heading, self.yaw_rate].iter().any(ColumnUnit::is_open)
    }
}
