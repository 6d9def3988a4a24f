//! Did the compass and the gyro see the same turn?

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use seatrial_core::{Real, Sample};

use crate::record::{between_gaps, median};

/// Length of the means before and after an instant, s.
pub(super) const MEAN_OVER_S: f64 = 0.5;
/// Jumps up to this, rad, are left to lag, deviation and drift.
pub(super) const LEAST_ERROR_RAD: f64 = 0.03;
/// Standard deviations of their difference that are noise.
const SIGNIFICANCE: f64 = 6.0;
/// alpha, beta, kappa and tau.
const TERMS: usize = 4;
/// The largest shift between heading and yaw rate that is tried, s, and the change of it that ends the search.
const LARGEST_SHIFT_S: f64 = 0.6;
/// Where the heading seems to jump: shifts and time constants of a low-pass filter, s, that may explain it.
const LATE_S: [f64; 9] = [0.7, 1.0, 1.4, 2.0, 2.8, 4.0, 5.6, 8.0, 11.0];
const SMOOTHED_S: [f64; 10] = [0.1, 0.2, 0.35, 0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0];
/// Of the squared error, what a late or smoothed heading that seemed to jump leaves.
const LEFT_OF_A_JUMP: f64 = 0.25;
const LEAST_SHIFT_S: f64 = 1e-4;
/// Each is linearised about the last: three are enough of a smooth turn.
const SHIFTS: usize = 12;
/// A gyro whose scale fits the compass so far, jumps included, is in the right unit and sense.
const SCALE: [f64; 2] = [0.5, 2.0];

/// How the compass parts from the gyro: each `None` where it is no more than noise, or where there is no gyro in the
/// right unit and sense to compare with.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CompassError {
    /// The largest jump of the heading from where the measured yaw rate takes it.
    pub largest_jump: Option<Jump>,
    /// Heading changes are larger by this share than the yaw rate says.
    pub scale_error: Option<f64>,
    /// The heading is this much later than the yaw rate, s; negative where it is earlier.
    pub late_s: Option<f64>,
    /// Could a late heading be found: nothing jumped, and no half second is missing?
    pub shows_late: bool,
}

/// A jump of the heading within a second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jump {
    /// By how much, rad, without sign.
    pub size_rad: f64,
    /// When, s on the log's clock.
    pub time_s: f64,
}

impl CompassError {
    /// The time by which the yaw rate is later than the heading, s: a filter of the gyro's.
    pub fn yaw_rate_late_s(&self) -> Option<f64> {
        self.late_s.filter(|late_s| *late_s < 0.0).map(|late_s| -late_s)
    }

    /// Compares heading and yaw rate over a record.
    ///
    /// ```text
    /// psi(t) = alpha + beta t + kappa P(t + s) + tau r(t + s) + e,   P = int r dt
    /// ```
    ///
    /// | symbol | meaning |
    /// |---|---|
    /// | psi, r | measured heading and yaw rate |
    /// | alpha, beta | first heading; bias of the gyro and drift of the compass |
    /// | kappa | 1 and the slope of the compass's deviation at its headings, over the scale of the gyro |
    /// | s | the time by which the gyro is later than the compass, moved by tau / kappa until tau is 0 |
    /// | e | what is left: a jump from its mean over 0.5 s to that of the next 0.5 s counts beyond 0.03 rad, six deviations of its noise and a step of the compass |
    ///
    /// Least squares over the record. Noise of the compass is white, that of the gyro walks in its integral, most in long records of slow
    /// vehicles. kappa and tau count beyond six standard errors of both, and where nothing jumped and no
    /// half second is missing: a jump, and a turn that nobody saw, pass in part for both. A jump or a short standstill of the compass that is too small for the guard is found
    /// here, and what validation data through the same compass cannot show: that it turns too far or too late. Of a record with gaps only
    /// jumps are looked for, in each part by itself: a gyro tells nothing of a turn that it did not see.
    pub fn of(samples: &[Sample<f64>]) -> Self {
        let mut parts = between_gaps(samples).map(|part| Self::compare(part).unwrap_or_default());
        let whole = parts.next().unwrap_or_default();
        parts.fold(whole, |all, part| Self {
            largest_jump: [all.largest_jump, part.largest_jump]
                .into_iter()
                .flatten()
                .max_by(|a, b| a.size_rad.total_cmp(&b.size_rad)),
            ..Self::default()
        })
    }

    fn compare(samples: &[Sample<f64>]) -> Option<Self> {
        let (first, last) = (samples.first()?, samples.last()?);
        let path = Path::of(samples)?;
        let heading = DVector::from_column_slice(&path.heading_rad);
        let interval_s = (last.time_s - first.time_s) / (samples.len() - 1) as f64;
        let count = ((MEAN_OVER_S / interval_s).ceil() as usize).max(1);
        let jump = |aligned: &Alignment| {
            largest_jump(aligned.error(&heading).as_slice(), count, path.step_rad)
        };
        let at_once = Alignment::of(&path, &heading, 0.0)?.shifted(&path, &heading);
        let explains = |late: &Alignment| jump(late).is_none();
        let is_sound = at_once.is_in_scale() && at_once.is_settled() && explains(&at_once);
        let late = match is_sound {
            true => None,
            false => at_once.late(&path, &heading).filter(explains),
        };
        let aligned = late.unwrap_or(at_once);
        if !aligned.is_in_scale() {
            return None;
        }
        let largest_jump = jump(&aligned).map(|(at, size_rad)| {
            let time_s = samples[at].time_s;
            Jump { size_rad, time_s }
        });
        let error = aligned.error(&heading);
        let Alignment { shift_s, smoothed_s, terms, normal, found } = aligned;
        let variance = error.norm_squared() / samples.len().checked_sub(TERMS)? as f64;
        let walk_rad = noise(&path.rates_rad_s) * interval_s;
        let steps = sums_from_here(terms);
        let inverse = normal.inverse();
        let covariance = variance * &inverse
            + walk_rad * walk_rad * &inverse * (steps.transpose() * &steps) * &inverse;
        let is_whole = largest_jump.is_none() && path.longest_interval_s < MEAN_OVER_S;
        let significant = |value: f64, term: usize| {
            let limit = SIGNIFICANCE * covariance[(term, term)].sqrt();
            (is_whole && value.abs() > limit).then_some(value)
        };
        Some(Self {
            largest_jump,
            scale_error: significant(found[2] - 1.0, 2),
            late_s: significant(found[3] + found[2] * (shift_s - smoothed_s), 3)
                .map(|early| -early / found[2]),
            shows_late: is_whole,
        })
    }
}

/// The least squares fit of the heading for one shift.
struct Alignment {
    /// The yaw rate is read so much later, s.
    shift_s: f64,
    /// It goes through a low-pass filter of this time constant before, s.
    smoothed_s: f64,
    terms: DMatrix<f64>,
    normal: Cholesky<f64, Dyn>,
    /// alpha, beta, kappa and tau.
    found: DVector<f64>,
}

impl Alignment {
    fn of(path: &Path, heading: &DVector<f64>, shift_s: f64) -> Option<Self> {
        let turns: Vec<[f64; 2]> = path.times_s.iter().map(|t| path.at(t + shift_s)).collect();
        let terms = DMatrix::from_fn(turns.len(), TERMS, |row, column| match column {
            0 => 1.0,
            1 => path.times_s[row],
            2 => turns[row][0],
            _ => turns[row][1],
        });
        let normal = (terms.transpose() * &terms).cholesky()?;
        Some(Self {
            shift_s,
            smoothed_s: 0.0,
            found: normal.solve(&(terms.transpose() * heading)),
            terms,
            normal,
        })
    }

    fn error(&self, heading: &DVector<f64>) -> DVector<f64> {
        heading - &self.terms * &self.found
    }

    fn is_in_scale(&self) -> bool {
        (SCALE[0]..=SCALE[1]).contains(&self.found[2])
    }

    /// Did the search for its shift end?
    fn is_settled(&self) -> bool {
        (self.found[3] / self.found[2]).abs() < LEAST_SHIFT_S
    }

    /// The best of a heading that is later than that, or smoothed; `None` where that explains little more.
    fn late(&self, path: &Path, heading: &DVector<f64>) -> Option<Self> {
        let later = LATE_S.iter().filter_map(|late_s| {
            Some(Self::of(path, heading, -late_s)?.shifted_within(path, heading, *late_s))
        });
        let smoothed = SMOOTHED_S.iter().filter_map(|smoothed_s| {
            let path = path.smoothed(*smoothed_s);
            Some(Self {
                smoothed_s: *smoothed_s,
                ..Self::of(&path, heading, 0.0)?.shifted(&path, heading)
            })
        });
        let left = |aligned: &Self| aligned.error(heading).norm_squared();
        let best = later
            .chain(smoothed)
            .filter(Self::is_in_scale)
            .min_by(|a, b| left(a).total_cmp(&left(b)))?;
        (left(&best) < LEFT_OF_A_JUMP * left(self)).then_some(best)
    }

    /// Gauss and Newton's steps to the shift that leaves no tau; as it is where they lead nowhere.
    fn shifted(self, path: &Path, heading: &DVector<f64>) -> Self {
        self.shifted_within(path, heading, LARGEST_SHIFT_S)
    }

    /// Those that end within so much of its own shift, s.
    fn shifted_within(self, path: &Path, heading: &DVector<f64>, most_s: f64) -> Self {
        let from_s = self.shift_s;
        let mut shift_s = from_s;
        let mut step_s = self.found[3] / self.found[2];
        for _ in 0..SHIFTS {
            shift_s += step_s;
            if shift_s.is_nan() || (shift_s - from_s).abs() > most_s {
                break;
            }
            let Some(next) = Self::of(path, heading, shift_s) else {
                break;
            };
            step_s = next.found[3] / next.found[2];
            if next.is_settled() {
                return next;
            }
        }
        self
    }
}

/// Heading and integral of the yaw rate over a record.
pub(super) struct Path {
    /// From the first sample, s.
    pub times_s: Vec<f64>,
    /// Yaw rate of the gyro, rad/s.
    pub rates_rad_s: Vec<f64>,
    /// From the first sample, rad, unwrapped.
    pub heading_rad: Vec<f64>,
    /// The integral of the yaw rate, rad.
    pub turned_rad: Vec<f64>,
    /// The smallest change of heading, rad.
    step_rad: f64,
    longest_interval_s: f64,
}

impl Path {
    /// `None` where no yaw rate is in every row.
    pub fn of(samples: &[Sample<f64>]) -> Option<Self> {
        let first_s = samples.first()?.time_s;
        let rates: Vec<f64> = samples
            .iter()
            .map(|s| s.yaw_rate_rad_s.filter(|r| r.is_finite()))
            .collect::<Option<_>>()?;
        let mut path = Self {
            times_s: samples.iter().map(|s| s.time_s - first_s).collect(),
            rates_rad_s: rates,
            heading_rad: vec![0.0],
            turned_rad: vec![0.0],
            step_rad: f64::INFINITY,
            longest_interval_s: 0.0,
        };
        let (mut heading, mut turned) = (0.0, 0.0);
        for (k, pair) in samples.windows(2).enumerate() {
            let interval_s = pair[1].time_s - pair[0].time_s;
            path.longest_interval_s = path.longest_interval_s.max(interval_s);
            let increment = Real::wrapped(pair[1].heading_rad - pair[0].heading_rad);
            if increment != 0.0 {
                path.step_rad = path.step_rad.min(increment.abs());
            }
            heading += increment;
            turned += 0.5 * (path.rates_rad_s[k] + path.rates_rad_s[k + 1]) * interval_s;
            path.heading_rad.push(heading);
            path.turned_rad.push(turned);
        }
        Some(path)
    }

    /// With the yaw rate behind a low-pass filter of this time constant.
    fn smoothed(&self, time_constant_s: f64) -> Self {
        let (mut turned, mut turned_rad) = (0.0, vec![0.0]);
        for (times_s, to) in self.times_s.windows(2).zip(self.turned_rad.windows(2)) {
            let interval_s = times_s[1] - times_s[0];
            let slope = (to[1] - to[0]) / interval_s;
            let left = libm::exp(-interval_s / time_constant_s);
            // The filter of a straight line.
            turned =
                to[1] - slope * time_constant_s + (turned - to[0] + slope * time_constant_s) * left;
            turned_rad.push(turned);
        }
        let rates_rad_s = self
            .turned_rad
            .iter()
            .zip(&turned_rad)
            .map(|(to, turned)| (to - turned) / time_constant_s)
            .collect();
        Self {
            times_s: self.times_s.clone(),
            heading_rad: self.heading_rad.clone(),
            rates_rad_s,
            turned_rad,
            ..*self
        }
    }

    /// The integral of the yaw rate at an instant and the yaw rate, rad and rad/s: the yaw rate is straight between samples, and constant
    /// before the first and after the last.
    fn at(&self, time_s: f64) -> [f64; 2] {
        let after = self.times_s.partition_point(|t| *t <= time_s);
        let nearest = after.clamp(1, self.times_s.len()) - 1;
        let (t_0, p_0, r_0) = self.node(nearest);
        if after == 0 || after == self.times_s.len() {
            return [p_0 + r_0 * (time_s - t_0), r_0];
        }
        let (t_1, _, r_1) = self.node(after);
        let passed_s = time_s - t_0;
        let slope = (r_1 - r_0) / (t_1 - t_0);
        [p_0 + passed_s * (r_0 + 0.5 * slope * passed_s), r_0 + slope * passed_s]
    }

    fn node(&self, index: usize) -> (f64, f64, f64) {
        (self.times_s[index], self.turned_rad[index], self.rates_rad_s[index])
    }
}

/// The largest jump from the mean of `count` errors to that of the next: the row behind it and its size, rad, where it is beyond
/// noise, drift and the step in which the compass reads.
fn largest_jump(errors: &[f64], count: usize, step_rad: f64) -> Option<(usize, f64)> {
    let limit = LEAST_ERROR_RAD
        .max(SIGNIFICANCE * noise(errors) * (2.0 / count as f64).sqrt())
        .max(step_rad);
    let mean = |part: &[f64]| part.iter().sum::<f64>() / count as f64;
    errors
        .windows(2 * count)
        .map(|window| (mean(&window[count..]) - mean(&window[..count])).abs())
        .enumerate()
        .max_by(|(_, a), (_, b)| a.total_cmp(b))
        .filter(|(_, largest)| *largest > limit)
        .map(|(first, largest)| (first + count, largest))
}

/// What a step of the heading at each row adds to the products of the heading with the terms.
fn sums_from_here(mut terms: DMatrix<f64>) -> DMatrix<f64> {
    for row in (1..terms.nrows()).rev() {
        let sum = terms.row(row - 1) + terms.row(row);
        terms.set_row(row - 1, &sum);
    }
    terms
}

/// The standard deviation of white noise from the median of its differences.
fn noise(errors: &[f64]) -> f64 {
    let differences = errors.windows(2).map(|w| (w[1] - w[0]).abs());
    // The median of |N(0, 2 sigma^2)|.
    median(differences.collect()).unwrap_or(0.0) / (0.674_489_75 * core::f64::consts::SQRT_2)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 16 s of a doublet's turn at 20 Hz, its compass and gyro through the given errors.
    fn record(compass: impl Fn(f64, f64) -> f64, gyro: impl Fn(f64) -> f64) -> Vec<Sample<f64>> {
        (0..320)
            .map(|k| {
                let time_s = f64::from(k) * 0.05;
                let phase = (time_s - 4.0).clamp(0.0, 4.0) * core::f64::consts::FRAC_PI_2;
                let rate = 0.3 * phase.sin();
                let heading = 0.3 * (1.0 - phase.cos()) / core::f64::consts::FRAC_PI_2;
                Sample {
                    time_s,
                    heading_rad: compass(time_s, heading).wrapped(),
                    yaw_rate_rad_s: Some(gyro(rate)),
                    ..Sample::default()
                }
            })
            .collect()
    }

    fn largest_jump_rad(samples: &[Sample<f64>]) -> Option<f64> {
        let jump = CompassError::of(samples).largest_jump;
        jump.map(|jump| jump.size_rad)
    }

    #[test]
    fn exact_deviation_and_lateness_are_measured() {
        let deviating = |_: f64, psi: f64| psi + 0.087 * psi.sin();
        let found = CompassError::of(&record(deviating, |r| r + 0.01));
        // The slope of the deviation about 0.4 rad of turn, 0.087 and a little less.
        assert!((found.scale_error.unwrap() - 0.085).abs() < 0.003, "{found:?}");
        assert_eq!(found.largest_jump, None);
        let turn = |t: f64| {
            let phase = (t - 4.0).clamp(0.0, 4.0) * core::f64::consts::FRAC_PI_2;
            0.3 * (1.0 - phase.cos()) / core::f64::consts::FRAC_PI_2
        };
        let found = CompassError::of(&record(|t, _| turn(t - 0.2), |r| r));
        assert!((found.late_s.unwrap() - 0.2).abs() < 0.001, "{found:?}");
        let mut torn = record(deviating, |r| r);
        torn.retain(|s| !(5.0..6.0).contains(&s.time_s));
        assert_eq!(CompassError::of(&torn).scale_error, None);
        assert_eq!(CompassError::of(&record(|_, psi| psi, |_| f64::NAN)), CompassError::default());
    }

    /// The vehicle turned while nothing was recorded, by more than a straight yaw rate over the gap.
    #[test]
    fn regress_a_turn_over_a_gap_is_no_jump() {
        let mut torn = record(|_, psi| psi, |r| r);
        torn.retain(|s| !(4.2..6.5).contains(&s.time_s));
        assert_eq!(CompassError::of(&torn), CompassError::default());
        assert_eq!(crate::identify::heading_jump(&torn), None);
    }

    /// Yaw rate through a filter of two equal poles, as an autopilot's at 4 Hz: late by 2 / (2 pi 4 Hz) = 0.08 s.
    #[test]
    fn exact_a_late_yaw_rate_is_no_jump_of_the_compass() {
        let pole_s = 1.0 / (8.0 * core::f64::consts::PI);
        let (mut heading, mut rate, mut once, mut twice) = (0.0, 0.0, 0.0, 0.0);
        let fine_s = 0.001;
        let samples: Vec<Sample<f64>> = (0..16_000)
            .filter_map(|k| {
                let time_s = f64::from(k) * fine_s;
                let rudder = match time_s {
                    t if (4.0..6.0).contains(&t) => 0.4,
                    t if (6.0..8.0).contains(&t) => -0.4,
                    _ => 0.0,
                };
                rate += fine_s * (10.0 * rudder - 3.0 * rate);
                heading += fine_s * rate;
                once += fine_s / pole_s * (rate - once);
                twice += fine_s / pole_s * (once - twice);
                (k % 50 == 0).then(|| Sample {
                    time_s,
                    heading_rad: Real::wrapped(heading),
                    yaw_rate_rad_s: Some(twice),
                    ..Sample::default()
                })
            })
            .collect();
        let found = CompassError::of(&samples);
        assert_eq!(found.largest_jump, None);
        assert!((found.late_s.unwrap() + 0.08).abs() < 0.01, "{found:?}");
    }

    /// Late by more than its search goes from 0, or behind a low-pass filter.
    #[test]
    fn exact_a_heading_that_is_late_or_smoothed_did_not_jump() {
        let turn = |t: f64| {
            let phase = (t - 4.0).clamp(0.0, 4.0) * core::f64::consts::FRAC_PI_2;
            0.3 * (1.0 - phase.cos()) / core::f64::consts::FRAC_PI_2
        };
        for late_s in [0.8, 1.0, 2.0, 3.0] {
            let found = CompassError::of(&record(|t, _| turn(t - late_s), |r| r));
            assert_eq!(found.largest_jump, None);
            assert!((found.late_s.unwrap() - late_s).abs() < 0.02, "{found:?}");
        }
        for time_constant_s in [1.0, 2.0] {
            let mut smoothed = record(|_, psi| psi, |r| r);
            let mut state = 0.0;
            for sample in &mut smoothed {
                state += 0.05 / time_constant_s * (sample.heading_rad - state);
                sample.heading_rad = state;
            }
            let found = CompassError::of(&smoothed);
            assert_eq!(found.largest_jump, None);
            let late_s = found.late_s.unwrap();
            assert!((late_s - time_constant_s).abs() < 0.1, "{found:?}");
        }
    }

    #[test]
    fn exact_what_instruments_do_is_left_alone() {
        // Drift, a wrap, deviation, and a gyro with bias and scale.
        let drift = |t: f64, psi: f64| 3.1 + psi + 0.02 * t + 0.03 * psi.sin();
        assert_eq!(largest_jump_rad(&record(drift, |r| 1.1 * r + 0.01)), None);
        // Steps of 2 degrees.
        let coarse = |_: f64, psi: f64| (psi / 0.035).round() * 0.035;
        assert_eq!(largest_jump_rad(&record(coarse, |r| r)), None);
        // Nothing can be compared with a gyro in degrees, or with none.
        let jump = |t: f64, psi: f64| psi + if t > 6.0 { 0.1 } else { 0.0 };
        assert_eq!(largest_jump_rad(&record(jump, |r| r.to_degrees())), None);
        assert_eq!(largest_jump_rad(&record(jump, |_| f64::NAN)), None);
    }

    #[test]
    fn exact_a_small_jump_and_a_short_standstill_are_found() {
        let jump = |t: f64, psi: f64| psi + if t > 6.0 { 0.12 } else { 0.0 };
        // Part of the jump passes for scale, drift and lag.
        let found = largest_jump_rad(&record(jump, |r| r)).unwrap();
        assert!((0.05..0.12).contains(&found), "{found}");
        let when = CompassError::of(&record(jump, |r| r)).largest_jump.unwrap();
        // A sample of the record.
        assert!((when.time_s - 6.0).abs() < 0.06, "{when:?}");
        let still = |t: f64, psi: f64| if (5.5..6.4).contains(&t) { 0.28 } else { psi };
        assert!(largest_jump_rad(&record(still, |r| r)).is_some());
    }
}
