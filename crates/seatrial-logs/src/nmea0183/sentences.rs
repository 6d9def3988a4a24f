//! Sentences that are read, and their numbers.

use crate::Quantity::{self, *};
use crate::Unit::{self, *};

/// The cell of a number that is found by its name.
const NAMED: usize = 0;

/// A number of a sentence.
pub(super) struct Field {
    pub name: &'static str,
    /// Cells behind the sentence's name, from 1, or [`NAMED`].
    cell: usize,
    /// Cell and letter without which the number does not count.
    flag: Option<(usize, &'static str)>,
    /// Is it `ddmm.mmm` with the letter of its half of the earth in the next cell?
    is_coordinate: bool,
    /// Does L in the next cell make it negative?
    is_of_a_side: bool,
}

const fn field(name: &'static str, cell: usize) -> Field {
    Field { name, cell, flag: None, is_coordinate: false, is_of_a_side: false }
}

const fn flagged(name: &'static str, cell: usize, at: usize, flag: &'static str) -> Field {
    Field { flag: Some((at, flag)), ..field(name, cell) }
}

const fn coordinate(name: &'static str, cell: usize) -> Field {
    Field { is_coordinate: true, ..field(name, cell) }
}

const fn of_a_side(name: &'static str, cell: usize) -> Field {
    Field { is_of_a_side: true, ..field(name, cell) }
}

impl Field {
    pub fn value(&self, cells: &[&str]) -> f64 {
        let cell = |index: usize| cells.get(index).copied().unwrap_or_default();
        let counts = self.flag.is_none_or(|(at, flag)| cell(at) == flag);
        let at = match self.cell {
            NAMED => angle_of(cells, self.name).unwrap_or(usize::MAX),
            at => at,
        };
        let number: Option<f64> = cell(at).parse().ok().filter(|_| counts);
        let value = match self.is_coordinate {
            false if self.is_of_a_side && cell(at + 1) == "L" => number.map(|number| -number),
            false => number,
            true => number.map(|number| {
                let degrees = (number / 100.0).trunc() + number % 100.0 / 60.0;
                let is_negative = matches!(cell(self.cell + 1), "S" | "W");
                if is_negative { -degrees } else { degrees }
            }),
        };
        value.unwrap_or(f64::NAN)
    }
}

/// The cell of an angle in degrees whose name stands two cells behind it: `A,-5.0,D,RUDDER` for `rudder_deg`.
fn angle_of(cells: &[&str], field: &str) -> Option<usize> {
    let name = field.trim_end_matches("_deg").to_uppercase();
    // Some cut names to four letters, as `RUDR`.
    let begin = name.get(..3).unwrap_or(&name);
    let is_it =
        |four: &[&str]| four[0] == "A" && four[2] == "D" && four[3].to_uppercase().contains(begin);
    Some(cells.windows(4).position(is_it)? + 1)
}

/// Sentences that are read.
pub(super) const SENTENCES: [(&str, &[Field]); 17] = [
    ("HDT", &[field("heading_deg", 1)]),
    ("THS", &[flagged("heading_deg", 1, 2, "A")]),
    // Of $PASHR, whose heading is that of several antennas and gyros.
    ("SHR", &[flagged("heading_deg", 2, 3, "T")]),
    ("HDG", &[field("heading_deg", 1)]),
    ("HDM", &[field("heading_deg", 1)]),
    ("ROT", &[flagged("rate_deg_min", 1, 2, "A")]),
    ("RSA", &[flagged("rudder_deg", 1, 2, "A"), flagged("port_deg", 3, 4, "A")]),
    // What an autopilot orders.
    ("HTC", &[of_a_side("rudder_order_deg", 2)]),
    ("HTD", &[of_a_side("rudder_order_deg", 2)]),
    ("VHW", &[field("heading_deg", 1), field("speed_kn", 5)]),
    ("VTG", &[field("speed_kn", 5)]),
    ("RMC", &[field("speed_kn", 7), coordinate("latitude_deg", 3), coordinate("longitude_deg", 5)]),
    ("GGA", &[coordinate("latitude_deg", 2), coordinate("longitude_deg", 4)]),
    ("GLL", &[coordinate("latitude_deg", 1), coordinate("longitude_deg", 3)]),
    ("XDR", &[field("rudder_deg", NAMED)]),
    ("DPT", &[field("depth_m", 1)]),
    ("DBT", &[field("depth_m", 3)]),
];

pub(super) const CHANNELS: [(Quantity, &str, &str, Unit); 16] = [
    (Heading, "HDT", "heading_deg", Degree),
    (Heading, "THS", "heading_deg", Degree),
    (Heading, "SHR", "heading_deg", Degree),
    (Heading, "HDG", "heading_deg", Degree),
    (Heading, "HDM", "heading_deg", Degree),
    (Heading, "VHW", "heading_deg", Degree),
    (Rudder, "RSA", "rudder_deg", Degree),
    (Rudder, "RSA", "port_deg", Degree),
    (Rudder, "XDR", "rudder_deg", Degree),
    (Rudder, "HTD", "rudder_order_deg", Degree),
    (Rudder, "HTC", "rudder_order_deg", Degree),
    (YawRate, "ROT", "rate_deg_min", DegreePerMinute),
    (Speed, "VHW", "speed_kn", Knot),
    (Speed, "VTG", "speed_kn", Knot),
    (Speed, "RMC", "speed_kn", Knot),
    (Altitude, "DPT", "depth_m", Metre),
];
