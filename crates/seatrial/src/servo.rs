//! The rudder that acts, where a log has the command.
//!
//! ```text
//! T_d d(delta)/dt = u(t - t_d) - delta,   u constant from one sample to the next
//! ```
//!
//! | symbol | identifier | meaning | unit |
//! |---|---|---|---|
//! | u | the record's `rudder_rad` | commanded angle, positive as in the record | rad |
//! | delta | the returned `rudder_rad`, its mean until the next sample | acting angle | rad |
//! | t_d | `delay_s` | dead time | s |
//! | T_d | `lag_s` | time constant of the servo | s |
//!
//! The servo rests at the first command. What is lost by the mean is of second order in the interval over the vehicle's
//! time constant.

use seatrial_core::Sample;
use serde::{Deserialize, Serialize};

use crate::record::{Record, median_interval_s};

/// Dead time and lag of a rudder behind its command.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Servo {
    delay_s: f64,
    lag_s: f64,
}

impl std::fmt::Display for Servo {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "{} s of delay and {} s of lag", self.delay_s, self.lag_s)
    }
}

/// A servo that cannot be.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{name} {value} s: expected a time from 0 to {LONGEST_S} s")]
pub struct InvalidServo {
    /// `delay` or `lag`.
    pub name: &'static str,
    /// What was given, s.
    pub value: f64,
}

/// No rudder of the largest ship takes longer.
const LONGEST_S: f64 = 100.0;

impl Servo {
    /// Dead time and time constant, s; either may be 0.
    ///
    /// ```
    /// use seatrial::log::Servo;
    ///
    /// let error = Servo::new(0.1, -0.5).expect_err("a rudder before its command");
    /// assert_eq!(error.to_string(), "lag -0.5 s: expected a time from 0 to 100 s");
    /// ```
    pub fn new(delay_s: f64, lag_s: f64) -> Result<Self, InvalidServo> {
        for (name, value) in [("delay", delay_s), ("lag", lag_s)] {
            if !(0.0..=LONGEST_S).contains(&value) {
                return Err(InvalidServo { name, value });
            }
        }
        Ok(Self { delay_s, lag_s })
    }

    /// Dead time and time constant together, s: how long a slow movement of the rudder comes late.
    ///
    /// ```
    /// use seatrial::log::Servo;
    ///
    /// assert_eq!(Servo::new(0.25, 0.5)?.late_s(), 0.75);
    /// # Ok::<(), seatrial::log::InvalidServo>(())
    /// ```
    pub fn late_s(&self) -> f64 {
        self.delay_s + self.lag_s
    }

    /// A record with the rudder that acts in place of the command.
    ///
    /// ```
    /// use seatrial::log::Servo;
    /// use seatrial::{Record, Sample};
    ///
    /// // 0.2 s of dead time: the step of the command at 1 s acts at 1.2 s.
    /// let at = |k: u32| Sample {
    ///     time_s: 0.1 * f64::from(k),
    ///     rudder_rad: if k < 10 { 0.0 } else { 0.2 },
    ///     ..Sample::default()
    /// };
    /// let record: Record = (0..20).map(at).collect();
    /// let acting = Servo::new(0.2, 0.0)?.behind(&record);
    /// assert!(acting.samples[11].rudder_rad.abs() < 1e-9);
    /// assert!((acting.samples[12].rudder_rad - 0.2).abs() < 1e-9);
    /// # Ok::<(), seatrial::log::InvalidServo>(())
    /// ```
    pub fn behind(&self, record: &Record) -> Record {
        Record {
            samples: self.acting(&record.samples),
            rudder_unit: record.rudder_unit,
            units: record.units,
        }
    }

    /// The samples with the rudder that acts in place of the command. Samples that are not finite, or whose time does
    /// not increase, stay as they are.
    ///
    /// ```
    /// use seatrial::Sample;
    /// use seatrial::log::Servo;
    ///
    /// // A command of 0.2 rad at 1 s to a rudder with 0.5 s of lag.
    /// let commanded: Vec<_> = (0..600)
    ///     .map(|k| Sample {
    ///         time_s: 0.01 * f64::from(k),
    ///         rudder_rad: if k < 100 { 0.0 } else { 0.2 },
    ///         ..Sample::default()
    ///     })
    ///     .collect();
    /// let acting = Servo::new(0.0, 0.5)?.acting(&commanded);
    /// // After a lag 63 % of the way, after ten lags all of it.
    /// assert!((acting[150].rudder_rad - 0.2 * 0.632).abs() < 2e-3);
    /// assert!((acting[599].rudder_rad - 0.2).abs() < 1e-4);
    /// # Ok::<(), seatrial::log::InvalidServo>(())
    /// ```
    pub fn acting(&self, commanded: &[Sample<f64>]) -> Vec<Sample<f64>> {
        let usual_interval_s = median_interval_s(commanded).unwrap_or(0.0);
        let mut samples = commanded.to_vec();
        let usable: Vec<usize> = increasing(commanded);
        let Some(&first) = usable.first() else {
            return samples;
        };
        let mut motion = Motion {
            servo: self,
            time_s: commanded[first].time_s,
            commanded_rad: commanded[first].rudder_rad,
            acting_rad: commanded[first].rudder_rad,
        };
        let mut commands = usable
            .iter()
            .map(|&i| &commanded[i])
            .map(|sample| (sample.time_s + self.delay_s, sample.rudder_rad))
            .peekable();
        for (position, &i) in usable.iter().enumerate() {
            let from_s = commanded[i].time_s;
            let until_s = usable
                .get(position + 1)
                .map_or(from_s + usual_interval_s, |&next| commanded[next].time_s);
            let mut turned_rad_s = 0.0;
            while let Some((at_s, rudder_rad)) = commands.next_if(|(at_s, _)| *at_s < until_s) {
                turned_rad_s += motion.until(at_s);
                motion.commanded_rad = rudder_rad;
            }
            turned_rad_s += motion.until(until_s);
            samples[i].rudder_rad = if until_s > from_s {
                turned_rad_s / (until_s - from_s)
            } else {
                motion.acting_rad
            };
        }
        samples
    }
}

/// Positions of the samples with finite time and rudder whose time increases.
fn increasing(samples: &[Sample<f64>]) -> Vec<usize> {
    let mut positions: Vec<usize> = Vec::with_capacity(samples.len());
    let mut last_s = f64::NEG_INFINITY;
    for (i, sample) in samples.iter().enumerate() {
        if sample.time_s.is_finite() && sample.rudder_rad.is_finite() && sample.time_s > last_s {
            last_s = sample.time_s;
            positions.push(i);
        }
    }
    positions
}

struct Motion<'a> {
    servo: &'a Servo,
    time_s: f64,
    commanded_rad: f64,
    acting_rad: f64,
}

impl Motion<'_> {
    /// Moves on under the present command and returns the integral of the acting angle, rad s.
    fn until(&mut self, time_s: f64) -> f64 {
        let interval_s = (time_s - self.time_s).max(0.0);
        let off_rad = self.acting_rad - self.commanded_rad;
        let lag_s = self.servo.lag_s;
        let left = if lag_s > 0.0 { libm::exp(-interval_s / lag_s) } else { 0.0 };
        self.time_s = self.time_s.max(time_s);
        self.acting_rad = self.commanded_rad + off_rad * left;
        self.commanded_rad * interval_s + off_rad * lag_s * (1.0 - left)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(rudder_rad: &[f64], interval_s: f64) -> Record {
        (0..)
            .zip(rudder_rad)
            .map(|(k, &rudder_rad)| Sample {
                time_s: f64::from(k) * interval_s,
                rudder_rad,
                ..Sample::default()
            })
            .collect()
    }

    fn rudders(record: &Record) -> Vec<f64> {
        record.samples.iter().map(|s| s.rudder_rad).collect()
    }

    #[test]
    fn exact_dead_time_moves_the_command_and_splits_intervals() {
        let command = record(&[0.0, 1.0, 1.0, -1.0, -1.0], 0.1);
        let behind = |delay_s| rudders(&Servo::new(delay_s, 0.0).unwrap().behind(&command));
        assert_eq!(behind(0.0), rudders(&command));
        // Rounding of sums of times.
        for (found, expected) in behind(0.1).iter().zip([0.0, 0.0, 1.0, 1.0, -1.0]) {
            assert!((found - expected).abs() < 1e-12);
        }
        for (found, expected) in behind(0.025).iter().zip([0.0, 0.75, 1.0, -0.5, -1.0]) {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
    }

    #[test]
    fn exact_a_step_through_a_lag() {
        let command = record(&[0.0, 1.0, 1.0, 1.0], 0.1);
        let found = rudders(&Servo::new(0.0, 0.2).unwrap().behind(&command));
        // Mean of 1 - exp(-t/T) over an interval that begins at t.
        let mean = |t: f64| 1.0 - 0.2 / 0.1 * ((-t / 0.2).exp() - (-(t + 0.1) / 0.2).exp());
        for (found, expected) in found.iter().zip([0.0, mean(0.0), mean(0.1), mean(0.2)]) {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
    }

    #[test]
    fn exact_unusable_samples_stay() {
        let mut command = record(&[0.1, f64::NAN, 0.1, 0.1], 0.1);
        command.samples[3].time_s = 0.05;
        let behind = Servo::new(0.05, 0.1).unwrap().behind(&command);
        assert!(behind.samples[1].rudder_rad.is_nan());
        assert!((behind.samples[2].rudder_rad - 0.1).abs() < 1e-12);
        assert_eq!(behind.samples[3].rudder_rad, 0.1);
        assert_eq!(Servo::new(0.1, 0.1).unwrap().behind(&Record::default()), Record::default());
        assert!(Servo::new(-0.1, 0.0).is_err() && Servo::new(0.0, f64::NAN).is_err());
    }
}
