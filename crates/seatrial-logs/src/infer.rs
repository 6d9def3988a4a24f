//! Units of columns that do not state one, from their first values; and a check of those that do.
//!
//! Columns vouch for each other: a log that has its rudder in degrees has its small headings in
//! degrees too, and a yaw rate must integrate to the heading.

use std::collections::BTreeMap;

use crate::error::Fault;
use crate::{Quantity, Unit};

/// The first rows of a log: numbers as they stand there, NaN where there is none.
#[derive(Debug, Default)]
pub(crate) struct FirstRows {
    pub time_s: Vec<f64>,
    pub values: BTreeMap<Quantity, Vec<f64>>,
}

/// Units found, each with its reason, and doubts.
#[derive(Debug, Default)]
pub(crate) struct Inferred {
    pub units: BTreeMap<Quantity, (Unit, String)>,
    pub warnings: Vec<String>,
}

/// A turn in hundredths of a degree, as MAVLink has a heading.
const FULL_CDEG: f64 = 36_000.0;

/// A heading in degrees that is not wrapped reaches no more: twenty turns in the first rows.
const LARGEST_HEADING_DEG: f64 = 7200.0;

/// The largest angle of any rudder, rad, with room to spare: 92 deg.
const LARGEST_RUDDER_RAD: f64 = 1.6;
/// The largest angle of any rudder, deg.
const LARGEST_RUDDER_DEG: f64 = 90.0;
/// The largest angle that rudders are used at, rad: 46 deg.
const USUAL_RUDDER_RAD: f64 = 0.8;
/// Full thrust with some room.
const LARGEST_FRACTION: f64 = 1.1;
/// A whole turn with some room, rad.
const TURN_RAD: f64 = 6.4;
/// More turns than a heading in radians unwraps to in a trial, rad.
const MANY_TURNS_RAD: f64 = 40.0;

/// The largest value of a quantity in a unit that was assumed.
pub(crate) fn largest_plausible(quantity: Quantity, unit: Unit) -> f64 {
    match (quantity, unit) {
        (Quantity::Rudder, Unit::Radian) => LARGEST_RUDDER_RAD,
        (Quantity::Rudder, Unit::Degree) => LARGEST_RUDDER_DEG,
        (Quantity::Heading, Unit::Radian) => MANY_TURNS_RAD,
        _ => f64::INFINITY,
    }
}

impl FirstRows {
    fn of(&self, quantity: Quantity) -> Option<&[f64]> {
        self.values.get(&quantity).map(Vec::as_slice)
    }

    fn largest(&self, quantity: Quantity) -> f64 {
        self.of(quantity)
            .unwrap_or_default()
            .iter()
            .filter(|value| value.is_finite())
            .fold(0.0, |largest, value| largest.max(value.abs()))
    }

    /// Units of all matched columns; `stated` are those given by name or option.
    pub fn infer(
        &self,
        stated: &BTreeMap<Quantity, Unit>,
        columns: &BTreeMap<Quantity, String>,
    ) -> Result<Inferred, Fault> {
        let mut inferred = Inferred::default();
        let rudder = match stated.get(&Quantity::Rudder) {
            Some(unit) => *unit,
            None => {
                let (unit, because) = self.rudder_unit(columns)?;
                inferred.add(Quantity::Rudder, unit, because);
                unit
            }
        };
        let heading = match stated.get(&Quantity::Heading) {
            Some(unit) => *unit,
            None => {
                let (unit, because) = self.heading_unit(rudder);
                inferred.add(Quantity::Heading, unit, because);
                unit
            }
        };
        for quantity in columns.keys().copied() {
            if stated.contains_key(&quantity) {
                continue;
            }
            let (unit, because) = match quantity {
                Quantity::Time | Quantity::Heading | Quantity::Rudder => continue,
                Quantity::Roll | Quantity::Pitch if self.largest(quantity) > 3.2 => {
                    (Unit::Degree, format!("reaches {}", self.largest(quantity)))
                }
                Quantity::Roll | Quantity::Pitch => (heading, "as the heading".to_string()),
                Quantity::YawRate => self.yaw_rate_unit(heading),
                Quantity::Thrust if self.largest(quantity) > LARGEST_FRACTION => {
                    (Unit::Percent, format!("reaches {}", self.largest(quantity)))
                }
                Quantity::Thrust => (
                    Unit::Fraction,
                    format!("stays within {}", self.largest(quantity)),
                ),
                Quantity::Speed => {
                    if columns
                        .get(&quantity)
                        .is_some_and(|name| is_usually_in_knots(name))
                    {
                        inferred.warnings.push(
                            "speed has no unit and is taken as m/s, but speeds of this name are usually in knots; say which with --unit speed=kn or --unit speed=m/s".into(),
                        );
                    }
                    (Unit::MetrePerSecond, "nothing else is said".into())
                }
                _ => (Unit::Metre, "nothing else is said".into()),
            };
            inferred.add(quantity, unit, because);
        }
        inferred.doubt(self, stated, rudder, heading);
        Ok(inferred)
    }

    fn rudder_unit(&self, columns: &BTreeMap<Quantity, String>) -> Result<(Unit, String), Fault> {
        let largest = self.largest(Quantity::Rudder);
        let because = format!("reaches {largest}");
        let values = self.of(Quantity::Rudder).unwrap_or_default();
        let is_pulse = largest <= 2300.0 && values.iter().all(|v| !v.is_finite() || *v >= 700.0);
        if is_pulse && largest > 0.0 {
            Ok((Unit::PulseWidth, "lies between 700 and 2300".into()))
        } else if largest <= LARGEST_RUDDER_RAD {
            Ok((Unit::Radian, because))
        } else if largest <= LARGEST_RUDDER_DEG {
            Ok((Unit::Degree, because))
        } else if largest <= 100.0 {
            Ok((Unit::Percent, because))
        } else {
            Err(Fault::ImplausibleValues {
                column: columns.get(&Quantity::Rudder).cloned().unwrap_or_default(),
                quantity: Quantity::Rudder,
                largest,
            })
        }
    }

    fn heading_unit(&self, rudder: Unit) -> (Unit, String) {
        let largest = self.largest(Quantity::Heading);
        if self.wraps_at(FULL_CDEG) || largest > LARGEST_HEADING_DEG {
            (Unit::Centidegree, format!("reaches {largest}"))
        } else if largest > TURN_RAD {
            (Unit::Degree, format!("reaches {largest}"))
        } else if self.wraps_at(std::f64::consts::TAU) {
            (Unit::Radian, "wraps at 2 pi".into())
        } else if rudder == Unit::Degree {
            (Unit::Degree, "as the rudder".into())
        } else {
            (Unit::Radian, format!("stays within {largest}"))
        }
    }

    /// Does the heading jump by nearly one turn?
    fn wraps_at(&self, turn: f64) -> bool {
        self.of(Quantity::Heading)
            .unwrap_or_default()
            .windows(2)
            .any(|pair| (0.8 * turn..=turn).contains(&(pair[1] - pair[0]).abs()))
    }

    /// rad/s or deg/s, whichever integrates to the heading.
    fn yaw_rate_unit(&self, heading: Unit) -> (Unit, String) {
        let same = match heading {
            Unit::Degree => Unit::DegreePerSecond,
            _ => Unit::RadianPerSecond,
        };
        match self.heading_rate_per_yaw_rate(heading.factor()) {
            Some(scale) => {
                let to_radian = libm::log(scale.abs()).abs();
                let to_degree = libm::log(scale.abs() / Unit::DegreePerSecond.factor()).abs();
                let unit = if to_radian < to_degree {
                    Unit::RadianPerSecond
                } else {
                    Unit::DegreePerSecond
                };
                (unit, "integrates to the heading".into())
            }
            None => (same, "as the heading".into()),
        }
    }

    /// Least squares of heading change, rad, on integrated yaw rate over spans of about 1 s.
    fn heading_rate_per_yaw_rate(&self, heading_factor: f64) -> Option<f64> {
        use seatrial_core::Real;
        let heading = self.of(Quantity::Heading)?;
        let rate = self.of(Quantity::YawRate)?;
        let (mut cross, mut rate_square, mut change_square) = (0.0, 0.0, 0.0);
        let (mut integral, mut change, mut from_s) = (0.0, 0.0, *self.time_s.first()?);
        for k in 1..self.time_s.len() {
            let step_rad = ((heading[k] - heading[k - 1]) * heading_factor).wrapped();
            let area = 0.5 * (rate[k] + rate[k - 1]) * (self.time_s[k] - self.time_s[k - 1]);
            if !step_rad.is_finite() || !area.is_finite() {
                (integral, change, from_s) = (0.0, 0.0, self.time_s[k]);
                continue;
            }
            change += step_rad;
            integral += area;
            if self.time_s[k] - from_s >= 1.0 {
                cross += change * integral;
                rate_square += integral * integral;
                change_square += change * change;
                (integral, change, from_s) = (0.0, 0.0, self.time_s[k]);
            }
        }
        let correlation = cross / (rate_square * change_square).sqrt();
        // Under half the correlation the columns do not vouch for each other.
        (correlation.abs() > 0.5).then(|| cross / rate_square)
    }
}

/// Speed over ground and speed through the water, as navigators call them.
fn is_usually_in_knots(column: &str) -> bool {
    let name = column.to_lowercase();
    ["sog", "stw", "fahrt", "fdw", "füg"]
        .iter()
        .any(|usual| name.contains(usual))
}

impl Inferred {
    fn add(&mut self, quantity: Quantity, unit: Unit, because: String) {
        self.units.insert(quantity, (unit, because));
    }

    /// What people should look at before they trust the units.
    fn doubt(
        &mut self,
        rows: &FirstRows,
        stated: &BTreeMap<Quantity, Unit>,
        rudder: Unit,
        heading: Unit,
    ) {
        let largest_heading = rows.largest(Quantity::Heading);
        let largest_rudder = rows.largest(Quantity::Rudder);
        for (quantity, unit) in &self.units {
            let (unit, because) = unit;
            if matches!(quantity, Quantity::Heading | Quantity::Rudder) && *unit != Unit::Radian {
                self.warnings.push(format!(
                    "{quantity} has no unit and is taken as {unit} ({because}); say which with --unit {quantity}=UNIT"
                ));
            }
        }
        let heading_in_degrees = largest_heading > MANY_TURNS_RAD
            || (largest_heading > TURN_RAD && rows.wraps_at(360.0));
        if stated.get(&Quantity::Heading) == Some(&Unit::Radian) && heading_in_degrees {
            self.warnings.push(format!(
                "heading is given as rad but reaches {largest_heading}: degrees? try --unit heading=deg"
            ));
        }
        if stated.get(&Quantity::Rudder) == Some(&Unit::Radian)
            && largest_rudder > LARGEST_RUDDER_RAD
        {
            self.warnings.push(format!(
                "rudder is given as rad but reaches {largest_rudder}: degrees? try --unit rudder=deg"
            ));
        }
        if stated.get(&Quantity::Heading) == Some(&Unit::Degree)
            && rows.wraps_at(std::f64::consts::TAU)
            && largest_heading <= TURN_RAD
        {
            self.warnings.push(
                "heading is given as deg but wraps at 2 pi: radians? try --unit heading=rad".into(),
            );
        }
        if stated.contains_key(&Quantity::Rudder) || rudder != Unit::Radian {
            return;
        }
        if largest_rudder > USUAL_RUDDER_RAD {
            self.warnings.push(format!(
                "rudder has no unit and is taken as rad, but reaches {largest_rudder} rad: a fraction of full rudder? say so with --unit rudder=fraction --rudder-range-deg DEG"
            ));
        } else if heading == Unit::Degree && largest_rudder > 0.0 {
            self.warnings.push(format!(
                "rudder has no unit and is taken as rad, because it reaches only {largest_rudder}, beside a heading in degrees; say which with --unit rudder=UNIT"
            ));
        }
    }
}
