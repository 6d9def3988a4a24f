//! What may be said about a log before it is read.

use std::collections::BTreeMap;
use std::fmt;
use std::path::PathBuf;

use crate::formats::Formats;
use crate::motors::motors_that_steer;
use crate::{Quantity, Unit};

/// What the user said about a log; everything else is found out. The default says nothing.
///
/// ```
/// use seatrial_logs::{ChannelChoice, Quantity, Unit};
///
/// let mut choice = ChannelChoice::default();
/// choice.columns.insert(Quantity::Heading, "hdg".into());
/// choice.units.insert(Quantity::Heading, Unit::Degree);
/// // The servo's pulse width stands for this angle at full deflection.
/// choice.columns.insert(Quantity::Rudder, "servo1_raw".into());
/// choice.full_rudder_rad = Some(0.6);
/// ```
///
/// It grows: programs begin with the default.
///
/// ```compile_fail,E0639
/// let choice = seatrial_logs::ChannelChoice { drop_invalid: true, ..Default::default() };
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ChannelChoice {
    /// Column of a quantity; `none` leaves an optional quantity out.
    pub columns: BTreeMap<Quantity, String>,
    /// Quantities that are half the difference of two columns: fins of a pair, thrusters of both sides. A second column that counts the
    /// other way is named with a minus.
    pub half_differences: BTreeMap<Quantity, [String; 2]>,
    /// Unit of a quantity's column.
    pub units: BTreeMap<Quantity, Unit>,
    /// What is put right before the unit.
    pub corrections: BTreeMap<Quantity, Correction>,
    /// Pulse width of the neutral rudder, us; 1500 unless given.
    pub rudder_trim: Option<f64>,
    /// Rudder angle at full deflection (400 us from the trim, 100 %, fraction 1), rad.
    pub full_rudder_rad: Option<f64>,
    /// Columns and the text that they have in the rows that are read: one vehicle of several in a file.
    pub rows_where: Vec<(String, String)>,
    /// A file of GPX or KML whose track has the positions: by its times, north and east of its first point.
    pub positions: Option<PathBuf>,
    /// Leave rows with text, NaN, a wrong number of cells or reversed time out instead of refusing the log.
    pub drop_invalid: bool,
    /// Formats that the program brings; they are asked before the built-in ones.
    pub formats: Formats,
}

impl ChannelChoice {
    /// The column of a quantity by its name; of rudder and thrust also two names with a comma between, of which half the difference is
    /// taken, as in `LEFT,RIGHT`, or `LEFT,-RIGHT` where the second counts the other way.
    ///
    /// ```
    /// use seatrial_logs::{ChannelChoice, Quantity};
    ///
    /// let mut choice = ChannelChoice::default();
    /// choice.name_column(Quantity::Rudder, "motor_l, motor_r".into());
    /// assert_eq!(choice.half_differences[&Quantity::Rudder], ["motor_l", "motor_r"]);
    /// ```
    pub fn name_column(&mut self, quantity: Quantity, name: String) {
        let is_halved = matches!(quantity, Quantity::Rudder | Quantity::Thrust);
        match name.split_once(',').filter(|_| is_halved) {
            Some((first, second)) => {
                let pair = [first.trim().into(), second.trim().into()];
                self.half_differences.insert(quantity, pair);
            }
            None => {
                self.columns.insert(quantity, name);
            }
        }
    }

    /// Takes half the difference of the two motors among these columns for the rudder, where nothing else is the rudder.
    pub(crate) fn take_motors(&mut self, columns: &[String], is_known: bool) {
        let is_chosen = self.columns.contains_key(&Quantity::Rudder)
            || self.half_differences.contains_key(&Quantity::Rudder);
        let pair = motors_that_steer(columns).filter(|_| !is_known && !is_chosen);
        self.half_differences.extend(pair.map(|pair| (Quantity::Rudder, pair)));
    }

    /// The column that names the unit of half the difference of two: the first.
    pub(crate) fn names_unit(&self, quantity: Quantity) -> Option<&String> {
        let pair = self.half_differences.get(&quantity);
        pair.map(|[first, _]| first)
    }

    /// Is it half the difference of two columns that count alike? Their trims cancel.
    pub(crate) fn is_a_difference(&self, quantity: Quantity) -> bool {
        let pair = self.half_differences.get(&quantity);
        pair.is_some_and(|[_, second]| mirrored(second).is_none())
    }
}

/// A second column that counts the other way is named with a minus.
pub(crate) fn mirrored(name: &str) -> Option<&str> {
    name.strip_prefix('-')
}

/// scale (value - offset), in the unit of the column
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Correction {
    /// Factor; negative where the column counts the other way.
    pub scale: f64,
    /// In the unit of the column; of a pulse in place of its trim.
    pub offset: Option<f64>,
}

impl fmt::Display for Correction {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        if let Some(offset) = self.offset {
            write!(f, "less {offset}, ")?;
        }
        write!(f, "times {}", self.scale)
    }
}
