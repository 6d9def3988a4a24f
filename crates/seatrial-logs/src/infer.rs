//! Units of columns that do not state one, from their first values; and a check of those that do.
//!
//! Columns vouch for each other: a log that has its rudder in degrees has its small headings in
//! degrees too, and a yaw rate must integrate to the heading.

use std::collections::BTreeMap;

use crate::error::Fault;
use crate::motors::is_of_a_motor;
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

/// Units of a heading, by the number at which a whole turn ends.
const TURNS: [Unit; 13] = [
    Unit::Turn,
    Unit::Radian,
    Unit::Count8,
    Unit::Degree,
    Unit::Gradian,
    Unit::Count10,
    Unit::Decidegree,
    Unit::Count12,
    Unit::Milliradian,
    Unit::Mil,
    Unit::Count14,
    Unit::Centidegree,
    Unit::TenthMilliradian,
];
/// The unit of the largest turn.
const LARGEST_TURN: Unit = Unit::Count16;
/// Fewer headings contradict no unit that is stated.
const LEAST_HEADINGS: usize = 20;
/// A step by this share of a turn is a wrap.
const WRAP: f64 = 0.8;
/// Parts of the numbers of a turn, each of which a heading passes that turns through all of them.
const PARTS: usize = 20;
/// Wraps at least of a heading that does not pass all parts.
const LEAST_WRAPS: usize = 3;
/// The unit of the yaw rate settles that of the heading where it agrees by this factor.
const AGREES: f64 = 1.1;

/// Spans over which positions are compared with the speed, and the factor by which they may part: a current, and the chord of a turn.
const SPEED_SPANS: usize = 20;
const SPEED_AGREES: f64 = 1.25;

/// A heading in degrees that is not wrapped reaches no more: twenty turns in the first rows.
const LARGEST_HEADING_DEG: f64 = 7200.0;
/// Rows at least over which a change of heading is compared with a yaw rate.
const SPAN_ROWS: usize = 5;
/// It begins within a turn of north.
const LARGEST_FIRST_DEG: f64 = 361.0;

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
                let rate = stated.get(&Quantity::YawRate).copied();
                let (unit, because) = self.heading_unit(rudder, rate, columns)?;
                inferred.add(Quantity::Heading, unit, because);
                unit
            }
        };
        self.check_stated_heading(stated, columns)?;
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
                Quantity::Thrust => self.thrust_unit(&mut inferred.warnings),
                Quantity::Speed => {
                    let name = columns.get(&quantity).map_or("", String::as_str);
                    self.speed_unit(name, &mut inferred.warnings)
                }
                _ => (Unit::Metre, "nothing else is said".into()),
            };
            inferred.add(quantity, unit, because);
        }
        inferred.doubt(self, stated, rudder, heading);
        Ok(inferred)
    }

    /// Refuses a heading that wraps at the turn of a unit that is neither the one stated nor one that a doubt names.
    fn check_stated_heading(
        &self,
        stated: &BTreeMap<Quantity, Unit>,
        columns: &BTreeMap<Quantity, String>,
    ) -> Result<(), Fault> {
        let stated = stated.get(&Quantity::Heading);
        let is_other = |unit: &Unit| {
            !matches!(unit, Unit::Radian | Unit::Degree) && stated.is_some_and(|of| of != unit)
        };
        let wraps = self.wraps().filter(is_other);
        match wraps.filter(|unit| self.is_of_a_compass(*unit)) {
            Some(_) => Err(self.unit_unknown(Quantity::Heading, columns)),
            None => Ok(()),
        }
    }

    fn unit_unknown(&self, quantity: Quantity, columns: &BTreeMap<Quantity, String>) -> Fault {
        Fault::ImplausibleValues {
            column: columns.get(&quantity).cloned().unwrap_or_default(),
            quantity,
            largest: self.largest(quantity),
        }
    }

    fn rudder_unit(&self, columns: &BTreeMap<Quantity, String>) -> Result<(Unit, String), Fault> {
        let largest = self.largest(Quantity::Rudder);
        let values = self.of(Quantity::Rudder).unwrap_or_default();
        // A motor has no angle.
        let is_of_motors =
            columns.get(&Quantity::Rudder).is_some_and(|column| is_of_a_motor(column));
        let is_pulse = largest <= 2300.0 && values.iter().all(|v| !v.is_finite() || *v >= 700.0);
        if is_pulse && largest > 0.0 {
            return Ok((Unit::PulseWidth, "lies between 700 and 2300".into()));
        }
        let unit = match largest {
            ..=LARGEST_FRACTION if is_of_motors => Unit::Fraction,
            ..=LARGEST_RUDDER_RAD if !is_of_motors => Unit::Radian,
            ..=LARGEST_RUDDER_DEG if !is_of_motors => Unit::Degree,
            ..=100.0 => Unit::Percent,
            _ => return Err(self.unit_unknown(Quantity::Rudder, columns)),
        };
        Ok((unit, format!("reaches {}", (largest * 1e3).round() / 1e3)))
    }

    fn heading_unit(
        &self,
        rudder: Unit,
        rate: Option<Unit>,
        columns: &BTreeMap<Quantity, String>,
    ) -> Result<(Unit, String), Fault> {
        let largest = self.largest(Quantity::Heading);
        let headings = self.of(Quantity::Heading).unwrap_or_default();
        let first = headings.iter().find(|heading| heading.is_finite());
        let begins_in_a_turn = first.is_none_or(|first| first.abs() <= LARGEST_FIRST_DEG);
        if let Some(unit) = self.wraps() {
            let turn = std::f64::consts::TAU / unit.factor();
            let because = format!("wraps at {}", (turn * 1e3).round() / 1e3);
            return Ok((unit, because));
        }
        if largest > TURN_RAD
            && let Some(unit) = rate.and_then(|rate| self.heading_by_rate(rate))
        {
            return Ok((unit, "changes as the yaw rate says".into()));
        }
        if largest > LARGEST_HEADING_DEG || !begins_in_a_turn || self.wraps_elsewhere() {
            Err(self.unit_unknown(Quantity::Heading, columns))
        } else if largest > TURN_RAD {
            Ok((Unit::Degree, format!("reaches {largest}")))
        } else if rudder == Unit::Degree {
            Ok((Unit::Degree, "as the rudder".into()))
        } else {
            Ok((Unit::Radian, format!("stays within {largest}")))
        }
    }

    /// The unit whose turn ends where the heading jumps from one end of its numbers to the other: the smallest that holds them all.
    fn wraps(&self) -> Option<Unit> {
        let headings = self.of(Quantity::Heading)?;
        let finite = || headings.iter().copied().filter(|heading| heading.is_finite());
        let (low, high) =
            (finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max));
        let are_whole = finite().all(|heading| heading.fract() == 0.0);
        let is_count = |unit: Unit| unit.symbol().starts_with("turn/");
        let of_turn = |unit: Unit| std::f64::consts::TAU / unit.factor();
        let may_be = |unit: Unit| match unit {
            // Whole numbers beside north, or a step of one degree, are no turns.
            Unit::Turn => !are_whole && low >= -1.0 && high <= 1.0,
            unit => are_whole || !is_count(unit),
        };
        // Rounding may write the last number of a turn.
        let holds = |unit: &Unit| high - low <= 1.0001 * of_turn(*unit) && may_be(*unit);
        let unit = TURNS.into_iter().chain([LARGEST_TURN]).find(holds)?;
        self.wraps_at(of_turn(unit)).then_some(unit)
    }

    /// Does the heading jump between 0 and its largest number as at the end of a turn? Of no unit that is known.
    fn wraps_elsewhere(&self) -> bool {
        let headings = self.of(Quantity::Heading).unwrap_or_default();
        let turn = self.largest(Quantity::Heading);
        let part = |heading: f64| (heading / turn * PARTS as f64) as usize;
        let mut parts = [false; PARTS + 1];
        for heading in headings.iter().filter(|heading| heading.is_finite()) {
            if *heading < 0.0 {
                return false;
            }
            parts[part(*heading).min(PARTS)] = true;
        }
        let is_everywhere = parts[..PARTS].iter().all(|is_there| *is_there);
        let is_wrap = |pair: &&[f64]| (pair[1] - pair[0]).abs() > WRAP * turn;
        let wraps = headings.windows(2).filter(is_wrap).count();
        // A compass that is disturbed jumps away and comes back.
        let least = if is_everywhere { 1 } else { LEAST_WRAPS };
        headings.len() >= LEAST_HEADINGS && parts[0] && wraps >= least
    }

    /// Are there rows enough, and between them small steps and whole turns alone?
    fn is_of_a_compass(&self, unit: Unit) -> bool {
        let turn = std::f64::consts::TAU / unit.factor();
        let headings = self.of(Quantity::Heading).unwrap_or_default();
        let is_small_or_whole = |pair: &[f64]| {
            let step = (pair[1] - pair[0]).abs();
            !((1.0 - WRAP) * turn..WRAP * turn).contains(&step)
        };
        headings.len() >= LEAST_HEADINGS && headings.windows(2).all(is_small_or_whole)
    }

    /// The unit in which the heading changes as a yaw rate of a stated unit says.
    fn heading_by_rate(&self, rate: Unit) -> Option<Unit> {
        let counts_per_rate = self.heading_rate_per_yaw_rate(None)?;
        let radians_per_count = (rate.factor() / counts_per_rate).abs();
        let agrees = |unit: &Unit| {
            let ratio = unit.factor() / radians_per_count;
            (1.0 / AGREES..AGREES).contains(&ratio)
        };
        // Milliradians and mils differ by 2 %, which no gyro shows.
        let mut units = TURNS.into_iter().chain([LARGEST_TURN]).filter(agrees);
        units.next().filter(|_| units.next().is_none())
    }

    /// Does the heading jump by nearly one turn?
    fn wraps_at(&self, turn: f64) -> bool {
        self.of(Quantity::Heading)
            .unwrap_or_default()
            .windows(2)
            .any(|pair| (WRAP * turn..=1.0001 * turn).contains(&(pair[1] - pair[0]).abs()))
    }

    /// The unit of the speed at which the positions go on; m/s where there are none, which is said.
    fn speed_unit(&self, name: &str, warnings: &mut Vec<String>) -> (Unit, String) {
        let units = [Unit::MetrePerSecond, Unit::Knot, Unit::KilometrePerHour];
        let of_positions = self.speed_of_positions().and_then(|m_s_per_number| {
            let is_it = |unit: &Unit| {
                let share = m_s_per_number / unit.factor();
                (1.0 / SPEED_AGREES..SPEED_AGREES).contains(&share)
            };
            units.into_iter().find(is_it)
        });
        if let Some(unit) = of_positions {
            warnings.push(format!(
                "speed has no unit and is taken as {unit}, at which the positions go on; say which with --unit speed=UNIT"
            ));
            return (unit, "the positions go on at it".into());
        }
        let doubt = match is_usually_in_knots(name) {
            true => ", but speeds of this name are usually in knots",
            false => "",
        };
        warnings.push(format!(
            "speed has no unit and is taken as m/s{doubt}; say which with --unit speed=kn or --unit speed=m/s"
        ));
        (Unit::MetrePerSecond, "nothing else is said".into())
    }

    /// Metres that the positions go on in a second, for each number of the speed: the median over spans of rows.
    fn speed_of_positions(&self) -> Option<f64> {
        let [north, east, speed] = [Quantity::North, Quantity::East, Quantity::Speed]
            .map(|quantity| self.of(quantity).unwrap_or_default());
        let rows = self.time_s.len().min(north.len()).min(east.len()).min(speed.len());
        let span = (rows / SPEED_SPANS).max(1);
        let mut found: Vec<f64> = (0..rows.saturating_sub(span))
            .step_by(span)
            .map(|from| {
                let to = from + span;
                let way_m = libm::hypot(north[to] - north[from], east[to] - east[from]);
                let mean = speed[from..to].iter().sum::<f64>() / span as f64;
                way_m / (mean * (self.time_s[to] - self.time_s[from]))
            })
            .filter(|share| share.is_finite() && *share > 0.0)
            .collect();
        if found.len() < SPEED_SPANS / 2 {
            return None;
        }
        let middle = found.len() / 2;
        Some(*found.select_nth_unstable_by(middle, f64::total_cmp).1)
    }

    fn thrust_unit(&self, warnings: &mut Vec<String>) -> (Unit, String) {
        let largest = self.largest(Quantity::Thrust);
        if largest <= LARGEST_FRACTION {
            return (Unit::Fraction, format!("stays within {largest}"));
        }
        if largest > 100.0 * LARGEST_FRACTION {
            warnings.push(format!(
                "thrust reaches {largest}, which is no share of full in percent; give the share in one of its numbers as scale of the thrust in a [channels] file"
            ));
        }
        (Unit::Percent, format!("reaches {largest}"))
    }

    /// The unit of the yaw rate that integrates to the heading.
    fn yaw_rate_unit(&self, heading: Unit) -> (Unit, String) {
        let same = match heading {
            Unit::Radian => Unit::RadianPerSecond,
            _ => Unit::DegreePerSecond,
        };
        let Some(scale) = self.heading_rate_per_yaw_rate(Some(heading.factor())) else {
            return (same, "as the heading".into());
        };
        let distance = |unit: Unit| libm::log(scale.abs() / unit.factor()).abs();
        let units = [Unit::RadianPerSecond, Unit::DegreePerSecond, Unit::DegreePerMinute];
        let nearest =
            units.into_iter().min_by(|one, two| distance(*one).total_cmp(&distance(*two)));
        (nearest.unwrap_or(same), "integrates to the heading".into())
    }

    /// Least squares of heading change, rad, on integrated yaw rate over spans of about 1 s; of numbers that do not wrap where no
    /// factor makes radians of them.
    fn heading_rate_per_yaw_rate(&self, heading_factor: Option<f64>) -> Option<f64> {
        use seatrial_core::Real;
        let heading = self.of(Quantity::Heading)?;
        let rate = self.of(Quantity::YawRate)?;
        let (mut cross, mut rate_square, mut change_square) = (0.0, 0.0, 0.0);
        let (mut integral, mut change, mut from_s) = (0.0, 0.0, *self.time_s.first()?);
        let mut count = 0;
        for k in 1..self.time_s.len() {
            let step = heading[k] - heading[k - 1];
            let step_rad = heading_factor.map_or(step, |factor| (step * factor).wrapped());
            let area = 0.5 * (rate[k] + rate[k - 1]) * (self.time_s[k] - self.time_s[k - 1]);
            if !step_rad.is_finite() || !area.is_finite() {
                (integral, change, from_s) = (0.0, 0.0, self.time_s[k]);
                continue;
            }
            change += step_rad;
            integral += area;
            count += 1;
            // Noise hides the heading's change over a few rows.
            if self.time_s[k] - from_s >= 1.0 && count >= SPAN_ROWS {
                cross += change * integral;
                rate_square += integral * integral;
                change_square += change * change;
                (integral, change, from_s, count) = (0.0, 0.0, self.time_s[k], 0);
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
    ["sog", "stw", "fahrt", "fdw", "füg"].iter().any(|usual| name.contains(usual))
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
