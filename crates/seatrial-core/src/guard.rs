//! The sample guard: what may reach the filters, and as what.

use crate::Real;
use crate::setting::{InvalidSetting, is_positive, require};

/// What the guard lets through.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct GuardSettings<T> {
    /// A longer silence than this many filter time constants 1/lambda is a gap, over which the filters
    /// cannot be carried. `None`: no silence is a gap.
    pub gap_time_constants: Option<T>,
    /// After a gap or a discontinuity nothing is learnt for this many filter time constants:
    /// (1 + n) e^-n of the filters' wrong start is then left.
    pub warm_time_constants: T,
    /// A heading further than this from where the running yaw rate takes it, rad, plus
    /// what the largest yaw rate adds in the interval, is a spike. `None`: nothing is a spike.
    pub heading_jump_rad: Option<T>,
    /// Fastest change of heading, rad/s, against the running yaw rate.
    pub max_yaw_rate_rad_s: T,
    /// After this many samples refused in a row (spikes or times before the last) the last of them is
    /// taken as the new level or the new clock.
    pub refused_in_a_row: u32,
}

impl<T: Real> GuardSettings<T> {
    /// Names the first setting that is out of its range, as `guard.refused_in_a_row`.
    ///
    /// ```
    /// use seatrial_core::{EstimatorSettings, GuardSettings};
    ///
    /// let guard = GuardSettings { refused_in_a_row: 0, ..EstimatorSettings::<f64>::default().guard };
    /// assert_eq!(guard.check().map_err(|error| error.field), Err("guard.refused_in_a_row"));
    /// ```
    pub fn check(&self) -> Result<(), InvalidSetting> {
        require(
            self.gap_time_constants.is_none_or(is_positive),
            "guard.gap_time_constants",
            "a positive number or absent",
        )?;
        require(
            self.warm_time_constants >= T::ZERO && self.warm_time_constants.is_finite(),
            "guard.warm_time_constants",
            "a number not below 0",
        )?;
        require(
            self.heading_jump_rad.is_none_or(is_positive),
            "guard.heading_jump_rad",
            "a positive number or absent",
        )?;
        require(
            is_positive(self.max_yaw_rate_rad_s),
            "guard.max_yaw_rate_rad_s",
            "a positive number",
        )?;
        require(self.refused_in_a_row > 0, "guard.refused_in_a_row", "at least 1")
    }
}

/// Why a sample was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Cause {
    /// A time, heading or rudder that is no number, or too large to compute with.
    NonFinite,
    /// The time of the sample before.
    RepeatedTime,
    /// A time before that of the sample before.
    ReversedTime,
    /// A heading that no vehicle can have turned to.
    Spike,
}

/// Samples refused by cause, and the breaks in the record.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RejectedCounts {
    /// Refused: no number.
    pub non_finite: u32,
    /// Refused: same time again.
    pub repeated_time: u32,
    /// Refused: time ran backwards.
    pub reversed_time: u32,
    /// Refused: impossible heading.
    pub spike: u32,
    /// Silences over which the filters could not be carried; the sample that ended each was taken.
    pub gaps: u32,
    /// Lasting jumps of heading or clock; the sample that settled each was taken.
    pub discontinuities: u32,
}

impl RejectedCounts {
    /// All refused samples.
    ///
    /// ```
    /// use seatrial_core::RejectedCounts;
    ///
    /// // The sample that ends a gap is taken.
    /// let counts = RejectedCounts { spike: 2, repeated_time: 1, gaps: 3, ..RejectedCounts::default() };
    /// assert_eq!(counts.samples(), 3);
    /// ```
    pub fn samples(&self) -> u32 {
        [self.non_finite, self.repeated_time, self.reversed_time, self.spike]
            .iter()
            .fold(0, |sum, count| sum.saturating_add(*count))
    }

    /// What was counted after an earlier count.
    ///
    /// ```
    /// use seatrial_core::RejectedCounts;
    ///
    /// let after_run_1 = RejectedCounts { spike: 2, ..RejectedCounts::default() };
    /// let after_run_2 = RejectedCounts { spike: 5, gaps: 1, ..RejectedCounts::default() };
    /// assert_eq!(after_run_2.since(&after_run_1).spike, 3);
    /// ```
    pub fn since(&self, earlier: &Self) -> Self {
        Self {
            non_finite: self.non_finite.saturating_sub(earlier.non_finite),
            repeated_time: self.repeated_time.saturating_sub(earlier.repeated_time),
            reversed_time: self.reversed_time.saturating_sub(earlier.reversed_time),
            spike: self.spike.saturating_sub(earlier.spike),
            gaps: self.gaps.saturating_sub(earlier.gaps),
            discontinuities: self.discontinuities.saturating_sub(earlier.discontinuities),
        }
    }

    pub(crate) fn count(&mut self, cause: Cause) {
        let counter = match cause {
            Cause::NonFinite => &mut self.non_finite,
            Cause::RepeatedTime => &mut self.repeated_time,
            Cause::ReversedTime => &mut self.reversed_time,
            Cause::Spike => &mut self.spike,
        };
        *counter = counter.saturating_add(1);
    }
}

/// What is to be done with a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Admission<T> {
    /// The first sample of all.
    First,
    /// The sample follows on the one before.
    Next {
        /// Time since the sample before, s.
        interval_s: T,
        /// Heading turned since the sample before, rad; wraps are taken out.
        heading_increment_rad: T,
        /// The usual time between samples, s: a longer interval is one with samples lost.
        usual_interval_s: T,
    },
    /// The sample is good but does not follow on the one before: filters start again.
    Restart,
    /// The sample is not to be used.
    Rejected(Cause),
}

/// Takes samples as they come and lets through what can be used.
///
/// A heading may be wrapped to any turn or not at all: the increment is the heading's difference less the whole number
/// of turns that brings it nearest to what the running yaw rate predicts, so that it stays right when
/// samples are missing while the vehicle turns. A refused sample leaves no trace but its count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Guard<T> {
    settings: GuardSettings<T>,
    gap_s: Option<f64>,
    last: Option<(f64, T)>,
    /// Running median of the intervals, s; 0 before the first.
    usual_interval_s: T,
    refused_in_a_row: u32,
    rejected: RejectedCounts,
}

impl<T: Real> Guard<T> {
    /// A guard before filters of this lambda.
    pub fn new(settings: GuardSettings<T>, lambda_rad_s: T) -> Self {
        Self {
            settings,
            gap_s: settings.gap_time_constants.map(|constants| (constants / lambda_rad_s).to_f64()),
            last: None,
            usual_interval_s: T::ZERO,
            refused_in_a_row: 0,
            rejected: RejectedCounts::default(),
        }
    }

    /// Judges a sample, given the yaw rate that the samples before it show.
    ///
    /// ```
    /// use seatrial_core::guard::Admission;
    /// use seatrial_core::{EstimatorSettings, Guard};
    ///
    /// let settings = EstimatorSettings::<f64>::default();
    /// let mut guard = Guard::new(settings.guard, settings.lambda_rad_s);
    /// assert_eq!(guard.admit(0.0, 6.28, 0.0, 0.0), Admission::First);
    /// // A heading that wraps from 6.28 to 0.01 rad has turned by 0.013 rad.
    /// let Admission::Next { heading_increment_rad, .. } = guard.admit(0.05, 0.01, 0.0, 0.0) else {
    ///     panic!("it follows on the first");
    /// };
    /// assert!((heading_increment_rad - 0.0132).abs() < 1e-4);
    /// ```
    #[inline]
    pub fn admit(
        &mut self,
        time_s: f64,
        heading_rad: T,
        rudder_rad: T,
        yaw_rate_rad_s: T,
    ) -> Admission<T> {
        let admission = self.judge(time_s, heading_rad, rudder_rad, yaw_rate_rad_s);
        if let Admission::Rejected(cause) = admission {
            self.rejected.count(cause);
        } else {
            self.last = Some((time_s, heading_rad));
            self.refused_in_a_row = 0;
        }
        admission
    }

    /// What was refused so far.
    ///
    /// ```
    /// use seatrial_core::{EstimatorSettings, Guard};
    ///
    /// let settings = EstimatorSettings::<f64>::default();
    /// let mut guard = Guard::new(settings.guard, settings.lambda_rad_s);
    /// for time_s in [0.0, 0.05, 0.10, 0.05, 0.15] {
    ///     guard.admit(time_s, 0.0, 0.0, 0.0);
    /// }
    /// assert_eq!(guard.rejected().reversed_time, 1);
    /// ```
    pub fn rejected(&self) -> RejectedCounts {
        self.rejected
    }

    /// Counts a sample that was refused further on.
    pub(crate) fn count(&mut self, cause: Cause) {
        self.rejected.count(cause);
    }

    #[inline]
    fn judge(
        &mut self,
        time_s: f64,
        heading_rad: T,
        rudder_rad: T,
        yaw_rate_rad_s: T,
    ) -> Admission<T> {
        if !(time_s.is_finite() && heading_rad.is_finite() && rudder_rad.is_finite()) {
            return Admission::Rejected(Cause::NonFinite);
        }
        let Some((last_time_s, last_heading_rad)) = self.last else {
            return Admission::First;
        };
        let interval_s = time_s - last_time_s;
        if interval_s == 0.0 {
            return Admission::Rejected(Cause::RepeatedTime);
        }
        if interval_s < 0.0 {
            return self.refuse(Cause::ReversedTime);
        }
        if self.gap_s.is_some_and(|gap_s| interval_s > gap_s) {
            self.rejected.gaps = self.rejected.gaps.saturating_add(1);
            return Admission::Restart;
        }
        let interval_s = T::of(interval_s);
        let turned = heading_rad - last_heading_rad;
        let predicted = yaw_rate_rad_s * interval_s;
        let heading_increment_rad = turned - whole_turns(turned - predicted);
        if let Some(jump) = self.settings.heading_jump_rad
            && (heading_increment_rad - predicted).abs()
                > jump + self.settings.max_yaw_rate_rad_s * interval_s
        {
            return self.refuse(Cause::Spike);
        }
        Admission::Next {
            interval_s,
            heading_increment_rad,
            usual_interval_s: self.usual_interval_s(interval_s),
        }
    }

    /// The running median of the intervals, which each interval moves by 2 % towards itself.
    #[inline]
    fn usual_interval_s(&mut self, interval_s: T) -> T {
        if self.usual_interval_s == T::ZERO {
            self.usual_interval_s = interval_s;
        }
        let usual_s = self.usual_interval_s;
        self.usual_interval_s = usual_s * T::of(if interval_s > usual_s { 1.02 } else { 0.98 });
        usual_s
    }

    /// Refuses a sample, unless `refused_in_a_row` were refused before: then it is the new level.
    #[cold]
    fn refuse(&mut self, cause: Cause) -> Admission<T> {
        self.refused_in_a_row += 1;
        if self.refused_in_a_row < self.settings.refused_in_a_row {
            return Admission::Rejected(cause);
        }
        self.rejected.discontinuities = self.rejected.discontinuities.saturating_add(1);
        Admission::Restart
    }
}

/// The whole turns nearest to an angle, rad; a zero of the angle's sign within half a turn.
#[inline]
fn whole_turns<T: Real>(angle_rad: T) -> T {
    if angle_rad.abs() < T::PI {
        return angle_rad * T::ZERO;
    }
    let turn = T::PI + T::PI;
    turn * (angle_rad / turn).round()
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::{PI, TAU};

    fn guard() -> Guard<f64> {
        let settings = GuardSettings {
            gap_time_constants: Some(1.0),
            warm_time_constants: 8.0,
            heading_jump_rad: Some(0.2),
            max_yaw_rate_rad_s: 3.0,
            refused_in_a_row: 3,
        };
        Guard::new(settings, 1.0)
    }

    fn increment(admission: Admission<f64>) -> f64 {
        match admission {
            Admission::Next { heading_increment_rad, .. } => heading_increment_rad,
            other => panic!("{other:?}"),
        }
    }

    /// Also at half a turn, and with the sign of zero.
    fn turns_as_rounded<T: Real>() {
        let turn = T::PI + T::PI;
        let step = T::ONE + T::EPSILON;
        let near = [T::PI / step / step, T::PI / step, T::PI, T::PI * step];
        for angle in near.into_iter().chain([T::ZERO, T::of(1e-30), T::ONE, turn, T::of(1e30)]) {
            for angle in [angle, -angle] {
                let (found, expected) = (whole_turns(angle), turn * (angle / turn).round());
                assert_eq!(found, expected, "{angle}");
                assert_eq!(T::ONE / found, T::ONE / expected, "{angle}");
            }
        }
    }

    #[test]
    fn exact_whole_turns_of_f64_and_f32() {
        turns_as_rounded::<f64>();
        turns_as_rounded::<f32>();
    }

    /// A steady turn of 0.4 rad/s, in every way of counting a heading, with four of five samples lost.
    #[test]
    fn exact_unwraps_every_convention_with_samples_missing() {
        let conventions: [fn(f64) -> f64; 3] =
            [|heading| heading, |heading| heading.wrapped(), |heading| heading.rem_euclid(TAU)];
        for convention in conventions {
            for direction in [0.4, -0.4] {
                let mut guard = guard();
                let _ = guard.admit(0.0, convention(3.0), 0.0, direction);
                for k in 1..200 {
                    let time_s = 0.25 * f64::from(k);
                    let heading = convention(3.0 + direction * time_s);
                    let turned = increment(guard.admit(time_s, heading, 0.0, direction));
                    // Roundings of headings that reach 23 rad.
                    assert!((turned - 0.25 * direction).abs() < 1e-13);
                }
                assert_eq!(guard.rejected(), RejectedCounts::default());
            }
        }
    }

    /// More than half a turn between two samples, resolved by the running yaw rate.
    #[test]
    fn exact_unwraps_across_a_long_silence_in_a_turn() {
        let mut guard = guard();
        let _ = guard.admit(0.0, 0.0, 0.0, 0.0);
        let turned = increment(guard.admit(0.9, (4.5_f64).wrapped(), 0.0, 5.0));
        assert!((turned - 4.5).abs() < 1e-14);
    }

    #[test]
    fn exact_counts_each_cause_and_forgets_the_sample() {
        let mut guard = guard();
        assert_eq!(guard.admit(0.0, 0.0, 0.0, 0.0), Admission::First);
        let refused = [
            (f64::NAN, 0.0, 0.0, Cause::NonFinite),
            (0.1, f64::INFINITY, 0.0, Cause::NonFinite),
            (0.1, 0.0, f64::NAN, Cause::NonFinite),
            (0.0, 0.0, 0.0, Cause::RepeatedTime),
            (-1.0, 0.0, 0.0, Cause::ReversedTime),
            (0.1, 1.5, 0.0, Cause::Spike),
        ];
        for (time_s, heading_rad, rudder_rad, cause) in refused {
            let admission = guard.admit(time_s, heading_rad, rudder_rad, 0.0);
            assert_eq!(admission, Admission::Rejected(cause));
        }
        assert_eq!(increment(guard.admit(0.1, 0.02, 0.0, 0.0)), 0.02);
        let expected = RejectedCounts {
            non_finite: 3,
            repeated_time: 1,
            reversed_time: 1,
            spike: 1,
            gaps: 0,
            discontinuities: 0,
        };
        assert_eq!(guard.rejected(), expected);
        assert_eq!(guard.rejected().samples(), 6);
    }

    #[test]
    fn exact_a_lasting_step_becomes_the_new_level() {
        let mut guard = guard();
        let _ = guard.admit(0.0, 0.0, 0.0, 0.0);
        let mut admissions = [Admission::First; 4];
        for (k, admission) in (1_u32..).zip(&mut admissions) {
            *admission = guard.admit(0.05 * f64::from(k), 1.0, 0.0, 0.0);
        }
        let [first, second, third, fourth] = admissions;
        assert_eq!(first, Admission::Rejected(Cause::Spike));
        assert_eq!(second, first);
        assert_eq!(third, Admission::Restart);
        assert_eq!(increment(fourth), 0.0);
        assert_eq!((guard.rejected().spike, guard.rejected().discontinuities), (2, 1));
    }

    /// One time stamp far ahead must not make every later sample a reversed one.
    #[test]
    fn exact_a_wrong_clock_is_left_again() {
        let mut guard = guard();
        let _ = guard.admit(0.0, PI, 0.0, 0.0);
        assert_eq!(guard.admit(1e9, PI, 0.0, 0.0), Admission::Restart);
        for k in 1..3 {
            let admission = guard.admit(0.05 * f64::from(k), PI, 0.0, 0.0);
            assert_eq!(admission, Admission::Rejected(Cause::ReversedTime));
        }
        assert_eq!(guard.admit(0.15, PI, 0.0, 0.0), Admission::Restart);
        assert_eq!(increment(guard.admit(0.2, PI, 0.0, 0.0)), 0.0);
        assert_eq!(guard.rejected().gaps, 1);
    }
}
