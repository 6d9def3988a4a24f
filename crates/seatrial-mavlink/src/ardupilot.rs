//! What ArduPilot's own parameters say about its outputs.

use std::collections::BTreeMap;

/// `SERVOn_FUNCTION` of a rudder and of a boat's or rover's steering.
const RUDDER: f64 = 21.0;
const GROUND_STEERING: f64 = 26.0;
/// `SERVOn_FUNCTION` of the two sides of differential thrust.
const THROTTLE_LEFT: f64 = 73.0;
const THROTTLE_RIGHT: f64 = 74.0;
/// `SERVOn_FUNCTION` of the two sides of a V-tail.
const V_TAIL_LEFT: f64 = 79.0;
const V_TAIL_RIGHT: f64 = 80.0;
/// `SERVOn_FUNCTION` of the motors 1 to 8, of which several steer together.
const MOTORS: std::ops::RangeInclusive<f64> = 33.0..=40.0;
/// `MIXING_GAIN` unless it is logged.
const MIXING_GAIN: f64 = 0.5;
/// Outputs that have parameters.
const OUTPUTS: usize = 32;
/// The most parameters that are kept; firmwares have about 1500.
const MOST_PARAMETERS: usize = 8192;

/// Parameters by name, as last logged.
#[derive(Debug, Default)]
pub struct Parameters(BTreeMap<String, f64>);

impl Parameters {
    /// Takes the value of a parameter; the last one counts.
    pub fn insert(&mut self, name: String, value: f64) {
        if self.0.len() < MOST_PARAMETERS || self.0.contains_key(&name) {
            self.0.insert(name, value);
        }
    }

    /// Value of a parameter; `None` where it was not logged.
    pub fn get(&self, name: &str) -> Option<f64> {
        self.0.get(name).copied()
    }

    /// What the outputs that have a function do, for messages.
    pub fn functions(&self) -> String {
        let functions: Vec<String> = (1..=OUTPUTS)
            .filter_map(|output| {
                let name = format!("SERVO{output}_FUNCTION");
                let function = self.get(&name).filter(|function| *function != 0.0)?;
                Some(format!("{name} {function}"))
            })
            .collect();
        let is_motor = |output: usize| {
            let function = self.get(&format!("SERVO{output}_FUNCTION"));
            function.is_some_and(|function| MOTORS.contains(&function))
        };
        match functions.is_empty() {
            true => "no SERVOn_FUNCTION in it".into(),
            false if (1..=OUTPUTS).any(is_motor) => format!(
                "{}; motors 33 to 40 steer together: name a yaw command, or two outputs whose difference steers, with --channels FILE",
                functions.join(", ")
            ),
            false => functions.join(", "),
        }
    }

    /// Number of the first output with this function.
    pub fn output_with(&self, function: f64, outputs: usize) -> Option<usize> {
        (1..=outputs).find(|output| self.get(&format!("SERVO{output}_FUNCTION")) == Some(function))
    }
}

/// The pulses of an input or output and what they stand for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pulse {
    /// Shortest pulse, us.
    pub lowest_us: f64,
    /// Pulse of no deflection, us.
    pub trim_us: f64,
    /// Longest pulse, us.
    pub highest_us: f64,
    /// A longer pulse deflects to port.
    pub is_reversed: bool,
}

impl Pulse {
    /// ArduPilot's defaults.
    pub const DEFAULT: Self =
        Self { lowest_us: 1100.0, trim_us: 1500.0, highest_us: 1900.0, is_reversed: false };

    /// From `SERVO1_MIN`, `_TRIM`, `_MAX` and `_REVERSED`, where the prefix is `SERVO1`.
    pub fn of(parameters: &Parameters, prefix: &str) -> Self {
        let value = |what: &str, default: f64| {
            parameters.get(&format!("{prefix}_{what}")).unwrap_or(default)
        };
        Self {
            lowest_us: value("MIN", Self::DEFAULT.lowest_us),
            trim_us: value("TRIM", Self::DEFAULT.trim_us),
            highest_us: value("MAX", Self::DEFAULT.highest_us),
            is_reversed: value("REVERSED", 0.0) != 0.0,
        }
    }

    /// ```text
    /// +-(pulse - trim) / (max - trim)  above the trim,  +-(pulse - trim) / (trim - min)  below
    /// ```
    /// An output that is off (0) has none.
    pub fn fraction(&self, pulse_us: f64) -> f64 {
        let full_us = if pulse_us >= self.trim_us {
            self.highest_us - self.trim_us
        } else {
            self.trim_us - self.lowest_us
        };
        let is_on = pulse_us > 0.0 && full_us > 0.0;
        let sign = if self.is_reversed { -1.0 } else { 1.0 };
        if is_on { sign * (pulse_us - self.trim_us) / full_us } else { f64::NAN }
    }

    /// For people.
    pub fn text(&self) -> String {
        format!(
            "{:.0} to {:.0} us about {:.0} us{}",
            self.lowest_us,
            self.highest_us,
            self.trim_us,
            if self.is_reversed { ", reversed" } else { "" }
        )
    }
}

/// The outputs that steer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Steering {
    /// A rudder or a steered motor.
    Output {
        /// Number of the output, from 1.
        number: usize,
        /// Its pulses.
        pulse: Pulse,
    },
    /// Half of what the left side has more than the right, of the most that is mixed in: thrust, or a V-tail,
    /// whose left side is (elevator + rudder) gain and whose right side is (elevator - rudder) gain.
    Differential {
        /// Number and pulses of the left output.
        left: (usize, Pulse),
        /// Number and pulses of the right output.
        right: (usize, Pulse),
        /// Share of full steering that is mixed in.
        gain: f64,
    },
}

impl Steering {
    /// By the functions of the first outputs, as many as are logged.
    pub fn find(parameters: &Parameters, outputs: usize) -> Option<Self> {
        let pulse = |number: usize| Pulse::of(parameters, &format!("SERVO{number}"));
        let single = parameters
            .output_with(RUDDER, outputs)
            .or_else(|| parameters.output_with(GROUND_STEERING, outputs));
        if let Some(number) = single {
            let pulse = pulse(number);
            return Some(Self::Output { number, pulse });
        }
        let both = |left: f64, right: f64| {
            let sides = [left, right].map(|side| parameters.output_with(side, outputs));
            sides[0].zip(sides[1])
        };
        // Another offset gives elevator and rudder shares of their own, which firmwares compute differently.
        let is_plain_mix = parameters.get("MIXING_OFFSET").unwrap_or(0.0) == 0.0;
        let mixing_gain = parameters.get("MIXING_GAIN").unwrap_or(MIXING_GAIN);
        let v_tail = both(V_TAIL_LEFT, V_TAIL_RIGHT).filter(|_| is_plain_mix && mixing_gain > 0.0);
        let (sides, gain) = match v_tail {
            Some(sides) => (sides, mixing_gain),
            None => (both(THROTTLE_LEFT, THROTTLE_RIGHT)?, 1.0),
        };
        Some(Self::Differential {
            left: (sides.0, pulse(sides.0)),
            right: (sides.1, pulse(sides.1)),
            gain,
        })
    }

    /// Steering as a fraction of full, positive to starboard, from the pulses of the outputs from 1 on.
    pub fn fraction(&self, pulse_us: impl Fn(usize) -> f64) -> f64 {
        match self {
            Self::Output { number, pulse } => pulse.fraction(pulse_us(*number)),
            Self::Differential { left, right, gain } => {
                let left = left.1.fraction(pulse_us(left.0));
                let right = right.1.fraction(pulse_us(right.0));
                0.5 * (left - right) / gain
            }
        }
    }

    /// For people.
    pub fn text(&self) -> String {
        match self {
            Self::Output { number, pulse } => format!("SERVO{number}, {}", pulse.text()),
            Self::Differential { left, right, gain } => format!(
                "(SERVO{} - SERVO{}) / {}, {} and {}",
                left.0,
                right.0,
                2.0 * gain,
                left.1.text(),
                right.1.text()
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_pulses_are_fractions_of_the_full_rudder_on_either_side() {
        let pulse =
            Pulse { lowest_us: 1000.0, trim_us: 1400.0, highest_us: 2000.0, is_reversed: true };
        let fractions = [1000.0, 1200.0, 1400.0, 1700.0, 2000.0].map(|us| pulse.fraction(us));
        assert_eq!(fractions, [1.0, 0.5, -0.0, -0.5, -1.0]);
        assert!(pulse.fraction(0.0).is_nan());
    }

    #[test]
    fn exact_the_function_of_an_output_finds_the_steering() {
        let mut parameters = Parameters::default();
        for (name, value) in [
            ("SERVO1_FUNCTION", THROTTLE_LEFT),
            ("SERVO3_FUNCTION", THROTTLE_RIGHT),
            ("SERVO3_MIN", 1300.0),
        ] {
            parameters.insert(name.into(), value);
        }
        let steering = Steering::find(&parameters, 8).unwrap();
        let pulse_us = |output: usize| if output == 1 { 1900.0 } else { 1400.0 };
        assert_eq!(steering.fraction(pulse_us), 0.5 * (1.0 + 0.5));
        let mut v_tail = Parameters::default();
        v_tail.insert("SERVO1_FUNCTION".into(), V_TAIL_LEFT);
        v_tail.insert("SERVO3_FUNCTION".into(), V_TAIL_RIGHT);
        // Elevator 0.5 and rudder 0.25 at gain 0.5: 0.375 and 0.125 of 400 us.
        let pulse_us = |output: usize| if output == 1 { 1650.0 } else { 1550.0 };
        assert_eq!(Steering::find(&v_tail, 8).unwrap().fraction(pulse_us), 0.25);
        v_tail.insert("MIXING_OFFSET".into(), 10.0);
        assert_eq!(Steering::find(&v_tail, 8), None);
        parameters.insert("SERVO4_FUNCTION".into(), RUDDER);
        assert!(matches!(Steering::find(&parameters, 8), Some(Steering::Output { number: 4, .. })));
    }
}
