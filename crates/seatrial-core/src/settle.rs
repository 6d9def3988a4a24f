//! The settle gate: is the vehicle steady enough to begin?

use crate::excitation::CLOCK_RESOLUTION_S;
use crate::setting::{InvalidSetting, require};
use crate::{Real, Sample};

/// What to do with a vehicle that does not become steady.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum NotSettled {
    /// Begin all the same and say so in the run's result; the paper does.
    #[default]
    GoOn,
    /// Abort the trial.
    Abort,
}

/// When a vehicle counts as steady.
///
/// Straight lines are fitted by least squares to heading, depth and speed over pieces of
/// `steady_for_s`, so that a noisy compass does not keep a steady vehicle out; the vehicle is
/// steady if over one piece every line is within its tolerance.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(default, deny_unknown_fields, bound(deserialize = "T: Real + serde::Deserialize<'de>"))
)]
pub struct Settle<T> {
    /// Mean heading from the heading of the run, rad.
    pub heading_tolerance_rad: T,
    /// Slope of the heading, rad/s.
    pub yaw_rate_tolerance_rad_s: T,
    /// Change of depth over one piece, m.
    pub depth_tolerance_m: T,
    /// Change of forward speed over one piece, as a fraction of the speed.
    pub speed_tolerance: T,
    /// Length of a piece, s.
    pub steady_for_s: f64,
    /// Shortest settling time, s: the filters need it.
    pub at_least_s: f64,
    /// Longest settling time, s.
    pub at_most_s: f64,
    /// What to do with a vehicle that is not steady after `at_most_s`.
    pub not_settled: NotSettled,
}

impl<T: Real> Default for Settle<T> {
    fn default() -> Self {
        Self {
            heading_tolerance_rad: T::of(0.1),
            yaw_rate_tolerance_rad_s: T::of(0.02),
            depth_tolerance_m: T::of(0.3),
            speed_tolerance: T::of(0.02),
            steady_for_s: 3.0,
            at_least_s: 10.0,
            at_most_s: 40.0,
            not_settled: NotSettled::default(),
        }
    }
}

impl<T: Real> Settle<T> {
    /// Names the first setting that is out of its range, as `settle.at_most_s`.
    ///
    /// ```
    /// use seatrial_core::Settle;
    ///
    /// // At most 5 s of settling are too few for at least 10.
    /// let settle = Settle { at_most_s: 5.0, ..Settle::<f64>::default() };
    /// assert_eq!(settle.check().map_err(|error| error.field), Err("settle.at_most_s"));
    /// ```
    pub fn check(&self) -> Result<(), InvalidSetting> {
        let tolerances = [
            (self.heading_tolerance_rad, "settle.heading_tolerance_rad"),
            (self.yaw_rate_tolerance_rad_s, "settle.yaw_rate_tolerance_rad_s"),
            (self.depth_tolerance_m, "settle.depth_tolerance_m"),
            (self.speed_tolerance, "settle.speed_tolerance"),
        ];
        for (tolerance, field) in tolerances {
            require(tolerance > T::ZERO, field, "a positive number")?;
        }
        require(self.at_least_s >= 0.0, "settle.at_least_s", "a number not below 0")?;
        require(
            self.at_most_s.is_finite() && self.at_most_s >= self.at_least_s.max(self.steady_for_s),
            "settle.at_most_s",
            "at least settle.at_least_s and settle.steady_for_s",
        )
    }
}

/// Judges the samples of a settling stage.
#[derive(Clone, Copy, Debug)]
pub struct SettleGate<T> {
    settings: Settle<T>,
    piece_start_s: f64,
    heading: Line<T>,
    depth: Line<T>,
    speed: Line<T>,
}

/// Has the vehicle settled?
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SettleState {
    /// Not judged yet.
    Waiting,
    /// It is steady.
    Steady,
    /// It is not, and the time allowed is over.
    TimedOut,
}

impl<T: Real> SettleGate<T> {
    /// A gate that has seen nothing; `elapsed_s` counts from now.
    pub fn new(settings: Settle<T>) -> Self {
        Self {
            settings,
            piece_start_s: 0.0,
            heading: Line::default(),
            depth: Line::default(),
            speed: Line::default(),
        }
    }

    /// The judgement at a time since the start of the stage, from the samples before it.
    ///
    /// ```
    /// use seatrial_core::settle::{SettleGate, SettleState};
    /// use seatrial_core::{Sample, Settle};
    ///
    /// let judged = |yaw_rate_rad_s: f64| {
    ///     let mut gate = SettleGate::new(Settle::default());
    ///     for k in 0..240 {
    ///         let elapsed_s = 0.05 * f64::from(k);
    ///         gate.add(elapsed_s, yaw_rate_rad_s * (elapsed_s - 6.0), &Sample::default());
    ///     }
    ///     gate.judge(12.0)
    /// };
    /// // Steady after 12 s, and a turn of 0.1 rad/s, of which the gate takes 0.02.
    /// assert_eq!([judged(0.0), judged(0.1)], [SettleState::Steady, SettleState::Waiting]);
    /// ```
    pub fn judge(&self, elapsed_s: f64) -> SettleState {
        let elapsed_s = elapsed_s + CLOCK_RESOLUTION_S;
        if elapsed_s >= self.settings.at_least_s
            && elapsed_s - self.piece_start_s >= self.settings.steady_for_s
            && self.is_steady()
        {
            SettleState::Steady
        } else if elapsed_s >= self.settings.at_most_s {
            SettleState::TimedOut
        } else {
            SettleState::Waiting
        }
    }

    /// Takes in a sample and its heading relative to the heading of the run.
    pub fn add(&mut self, elapsed_s: f64, heading_error_rad: T, sample: &Sample<T>) {
        if elapsed_s + CLOCK_RESOLUTION_S - self.piece_start_s >= self.settings.steady_for_s {
            *self = Self { piece_start_s: elapsed_s, ..Self::new(self.settings) };
        }
        let t = T::of(elapsed_s - self.piece_start_s);
        self.heading.add(t, Some(heading_error_rad));
        self.depth.add(t, sample.depth_m);
        self.speed.add(t, sample.surge_speed_m_s);
    }

    fn is_steady(&self) -> bool {
        let settings = &self.settings;
        let change =
            |line: &Line<T>| line.slope().map(|slope| (slope * T::of(settings.steady_for_s)).abs());
        // A heading is always measured; depth and speed only count where they are.
        self.heading.slope().is_some_and(|slope| slope.abs() <= settings.yaw_rate_tolerance_rad_s)
            && self.heading.mean().abs() <= settings.heading_tolerance_rad
            && change(&self.depth).is_none_or(|change| change <= settings.depth_tolerance_m)
            && change(&self.speed)
                .is_none_or(|change| change <= settings.speed_tolerance * self.speed.mean().abs())
    }
}

/// Least-squares line through (t, y), accumulated.
#[derive(Clone, Copy, Debug, Default)]
struct Line<T> {
    n: T,
    mean_t: T,
    mean_y: T,
    tt: T,
    ty: T,
}

impl<T: Real> Line<T> {
    fn add(&mut self, t: T, y: Option<T>) {
        let Some(y) = y.filter(|y| y.is_finite()) else {
            return;
        };
        self.n += T::ONE;
        let from_mean_t = t - self.mean_t;
        self.mean_t += from_mean_t / self.n;
        self.mean_y += (y - self.mean_y) / self.n;
        self.tt += from_mean_t * (t - self.mean_t);
        self.ty += from_mean_t * (y - self.mean_y);
    }

    fn mean(&self) -> T {
        self.mean_y
    }

    /// `None` under two instants.
    fn slope(&self) -> Option<T> {
        (self.tt > T::ZERO).then(|| self.ty / self.tt)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settle(heading: impl Fn(f64) -> f64, speed: impl Fn(f64) -> f64) -> (SettleState, f64) {
        let mut gate = SettleGate::new(Settle::default());
        for k in 0..1000 {
            let t = f64::from(k) * 0.05;
            let judged = gate.judge(t);
            if judged != SettleState::Waiting {
                return (judged, t);
            }
            let sample = Sample { surge_speed_m_s: Some(speed(t)), ..Sample::default() };
            gate.add(t, heading(t), &sample);
        }
        (SettleState::Waiting, f64::NAN)
    }

    #[test]
    fn exact_steady_vehicle_passes_at_the_end_of_a_piece() {
        // Pieces of 3 s: the first that ends after 10 s ends at 12 s.
        assert_eq!(settle(|_| 0.05, |_| 1.5), (SettleState::Steady, 12.0));
    }

    #[test]
    fn exact_turning_or_accelerating_vehicle_does_not() {
        assert_eq!(settle(|t| 0.03 * t - 0.4, |_| 1.5), (SettleState::TimedOut, 40.0));
        assert_eq!(settle(|_| 0.2, |_| 1.5), (SettleState::TimedOut, 40.0));
        assert_eq!(settle(|_| 0.0, |t| 0.02 * t), (SettleState::TimedOut, 40.0));
    }
}
