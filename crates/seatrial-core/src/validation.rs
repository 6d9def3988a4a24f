//! Validation: how well a model simulates data that it was not estimated from.

use crate::excitation::CLOCK_RESOLUTION_S;
use crate::model::{Discretisation, YawModel, YawState};
use crate::{PitchModel, PitchState, Real, Sample};

/// Simulates a model with the measured rudder and compares it with the measured heading and yaw
/// rate, sample by sample and without a record.
///
/// ```text
/// R^2 = 1 - J / Var(psi_real)                                            (35)
/// J   = 1/n sum (psi_sim - psi_real)^2                                   (36)
/// Var = 1/n sum (psi_real - mean psi_real)^2                             (37)
/// psi_sim = psi_f + psi_0 + r_0 psi_r + dC psi_c
/// ```
///
/// The simulation is linear in what is known only later: with psi_f the response of the model to
/// the rudder from rest at 0, psi_r = (e^{at} - 1)/a to a unit initial rate and
/// psi_c = (e^{at} - 1 - at)/a^2 to a unit offset, all J follow from the Gram matrix of
/// [psi_real - psi_f, 1, psi_r, psi_c]. The yaw rate is fitted in the same way where it is measured.
///
/// | symbol | identifier | unit |
/// |---|---|---|
/// | psi_0 | mean measured heading over the first `lead_in_s` | rad |
/// | r_0 | mean measured yaw rate m over the lead-in times 1 - s^2/(k m^2), at least 0; 0 where it is not measured | rad/s |
/// | s^2, k | variance and number of the yaw rates of the lead-in | rad^2/s^2, 1 |
/// | dC | offset re-estimated by least squares on the compared signal | rad/s^2 |
///
/// Source: (35)-(37). One noisy sample as psi_0 costs 0.17 of R^2 at 2 deg of compass noise, asserted
/// by `recover_an_averaged_start_is_worth_its_r2` in seatrial-sim; a rate fitted to the heading of the
/// lead-in was measured to do slightly worse than r_0 = 0. A mean yaw rate is shrunk to 0 as
/// far as its gyro's noise explains it (positive-part James-Stein): a slow vehicle would carry it on for its long
/// time constant.
/// Where the window has no lead-in at rest, [`Validation::goodness_of_fit_from_any_start`] fits psi_0 and r_0 instead.
/// A sample whose time, heading or rudder is not finite, or whose time does not increase, is left
/// out; the rudder before it then acts on. Exact for any intervals between samples.
#[derive(Clone, Copy, Debug)]
pub struct Validation<T> {
    model: YawModel<T>,
    /// m of a restoring moment, 1/s^2.
    restoring_per_s2: Option<T>,
    lead_in_s: f64,
    last: Option<Last<T>>,
    start_s: f64,
    unwrapped_heading_rad: T,
    forced: YawState<T>,
    to_heading: YawState<T>,
    to_rate: YawState<T>,
    to_offset: YawState<T>,
    heading: Comparison<T>,
    yaw_rate: Comparison<T>,
}

/// What the interval to the next sample needs.
#[derive(Clone, Copy, Debug)]
struct Last<T> {
    time_s: f64,
    heading_rad: T,
    rudder_rad: T,
}

/// R^2 (35) of each signal. `None` where the signal did not vary or was not measured.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct GoodnessOfFit<T> {
    /// Heading, with the offset of the model.
    pub r2_heading: Option<T>,
    /// Heading, with the offset estimated again.
    pub r2_heading_offset_refit: Option<T>,
    /// Yaw rate, with the offset of the model.
    pub r2_yaw_rate: Option<T>,
    /// Yaw rate, with the offset estimated again.
    pub r2_yaw_rate_offset_refit: Option<T>,
    /// Samples compared.
    pub samples: u32,
}

impl<T: Real> GoodnessOfFit<T> {
    /// Is R^2 of heading at least this? Where wind, current or trim changed since training, R^2 of heading with the
    /// offset estimated again and of yaw rate stand in for it.
    ///
    /// ```
    /// use seatrial_core::GoodnessOfFit;
    ///
    /// let drifted = GoodnessOfFit {
    ///     r2_heading: Some(0.1),
    ///     r2_heading_offset_refit: Some(0.95),
    ///     ..GoodnessOfFit::default()
    /// };
    /// assert!(!drifted.reaches(0.6));
    /// // The yaw rate of the gyro stands in for the heading where the offset changed.
    /// assert!(GoodnessOfFit { r2_yaw_rate: Some(0.9), ..drifted }.reaches(0.6));
    /// ```
    pub fn reaches(&self, least_r2: T) -> bool {
        let reaches = |r2: Option<T>| r2.is_some_and(|r2| r2 >= least_r2);
        reaches(self.r2_heading)
            || (reaches(self.r2_heading_offset_refit) && reaches(self.r2_yaw_rate))
    }
}

impl<T: Real> Validation<T> {
    /// Validation of `model` with initial conditions averaged over the first `lead_in_s`.
    ///
    /// The first sample is always part of the lead-in.
    pub fn new(model: YawModel<T>, lead_in_s: f64) -> Self {
        Self {
            model,
            restoring_per_s2: None,
            lead_in_s,
            last: None,
            start_s: 0.0,
            unwrapped_heading_rad: T::ZERO,
            forced: YawState::default(),
            to_heading: YawState { heading_rad: T::ONE, yaw_rate_rad_s: T::ZERO },
            to_rate: YawState { heading_rad: T::ZERO, yaw_rate_rad_s: T::ONE },
            to_offset: YawState::default(),
            heading: Comparison::default(),
            yaw_rate: Comparison::default(),
        }
    }

    /// With a moment that rights the angle, psi'' = a22 psi' + m psi + b2 delta + C0: m, 1/s^2; `None` where there is none.
    #[inline(always)]
    pub fn righted_by(self, restoring_per_s2: Option<T>) -> Self {
        Self { restoring_per_s2, ..self }
    }

    /// Validation of `model` on a record.
    ///
    /// ```
    /// use seatrial_core::model::YawState;
    /// use seatrial_core::{Sample, Validation, YawModel};
    ///
    /// let vehicle = YawModel::from_theta([-1.0, 1.0, 0.0]);
    /// let mut state = YawState::<f64>::default();
    /// let samples: Vec<_> = (0..320)
    ///     .map(|k| {
    ///         let rudder_rad = match k {
    ///             40..80 => 0.26,
    ///             80..120 => -0.26,
    ///             _ => 0.0,
    ///         };
    ///         let sample = Sample {
    ///             time_s: 0.05 * f64::from(k),
    ///             heading_rad: state.heading_rad,
    ///             rudder_rad,
    ///             ..Sample::default()
    ///         };
    ///         state = vehicle.advance(state, rudder_rad, 0.05);
    ///         sample
    ///     })
    ///     .collect();
    /// let r2 = |b2| Validation::of(YawModel::from_theta([-1.0, b2, 0.0]), 2.0, &samples).r2_heading;
    /// // The vehicle itself, and one with half of its authority.
    /// assert!(r2(1.0).is_some_and(|r2| r2 > 0.9999));
    /// assert!(r2(0.5).is_some_and(|r2| r2 < 0.9));
    /// ```
    pub fn of<'a>(
        model: YawModel<T>,
        lead_in_s: f64,
        samples: impl IntoIterator<Item = &'a Sample<T>>,
    ) -> GoodnessOfFit<T> {
        let mut validation = Self::new(model, lead_in_s);
        for sample in samples {
            validation.compare(sample);
        }
        validation.goodness_of_fit()
    }

    /// Takes the next sample in.
    pub fn compare(&mut self, sample: &Sample<T>) {
        let usable = sample.time_s.is_finite()
            && sample.heading_rad.is_finite()
            && sample.rudder_rad.is_finite()
            && self.last.is_none_or(|last| sample.time_s > last.time_s);
        if !usable {
            return;
        }
        match self.last {
            None => self.start_s = sample.time_s,
            Some(last) => {
                self.advance(last.rudder_rad, T::of(sample.time_s - last.time_s));
                // Relative to the first sample: a small number keeps its digits in f32.
                self.unwrapped_heading_rad += (sample.heading_rad - last.heading_rad).wrapped();
            }
        }
        self.last = Some(Last {
            time_s: sample.time_s,
            heading_rad: sample.heading_rad,
            rudder_rad: sample.rudder_rad,
        });
        let is_lead_in = self.heading.samples == 0
            || sample.time_s - self.start_s + CLOCK_RESOLUTION_S < self.lead_in_s;
        self.heading.add(
            self.unwrapped_heading_rad,
            self.forced.heading_rad,
            [self.to_heading.heading_rad, self.to_rate.heading_rad, self.to_offset.heading_rad],
            is_lead_in,
        );
        if let Some(rate) = sample.yaw_rate_rad_s.filter(|rate| rate.is_finite()) {
            self.yaw_rate.add(
                rate,
                self.forced.yaw_rate_rad_s,
                [
                    self.to_heading.yaw_rate_rad_s,
                    self.to_rate.yaw_rate_rad_s,
                    self.to_offset.yaw_rate_rad_s,
                ],
                is_lead_in,
            );
        }
    }

    /// R^2 of the samples so far.
    pub fn goodness_of_fit(&self) -> GoodnessOfFit<T> {
        let initial = self.initial();
        let of = |signal: &Comparison<T>| {
            let refit = signal.refit_offset(initial).and_then(|offset| signal.r2(initial, offset));
            (signal.r2(initial, T::ZERO), refit)
        };
        self.fit_of(of)
    }

    /// R^2 of the samples so far from any start: psi_0 and r_0 are fitted to each signal by least squares, with the offset
    /// where that is estimated again. For a window that begins in a turn, where no lead-in tells them.
    ///
    /// ```
    /// use seatrial_core::{Sample, Validation, YawModel};
    ///
    /// // In a turn of 0.2 rad/s from the first sample on, which no lead-in at rest tells.
    /// let mut validation = Validation::new(YawModel::from_theta([-1.0, 1.0, 0.0]), 0.0);
    /// for k in 0..200 {
    ///     let time_s = 0.05 * f64::from(k);
    ///     validation.compare(&Sample {
    ///         time_s,
    ///         heading_rad: 0.2 * time_s,
    ///         rudder_rad: 0.2,
    ///         ..Sample::default()
    ///     });
    /// }
    /// let r2 = [validation.goodness_of_fit(), validation.goodness_of_fit_from_any_start()]
    ///     .map(|fit| fit.r2_heading);
    /// assert!(r2[0] < Some(0.999) && r2[1] > Some(0.999_999));
    /// ```
    pub fn goodness_of_fit_from_any_start(&self) -> GoodnessOfFit<T> {
        let of = |signal: &Comparison<T>| {
            let r2 = |[heading, rate, offset]: [T; 3]| signal.r2([heading, rate], offset);
            (r2(signal.least_squares([true, true, false])), r2(signal.least_squares([true; 3])))
        };
        self.fit_of(of)
    }

    /// psi_0, rad, from the first measured heading, r_0, rad/s, and dC, rad/s^2, of the simulated heading that is compared: from the lead-in,
    /// or `from_any_start`; dC is 0 without `offset_again`.
    pub fn heading_start(&self, from_any_start: bool, offset_again: bool) -> [T; 3] {
        if from_any_start {
            return self.heading.least_squares([true, true, offset_again]);
        }
        let [heading, rate] = self.initial();
        let offset = self.heading.refit_offset([heading, rate]);
        let offset = offset.filter(|_| offset_again).unwrap_or(T::ZERO);
        [heading, rate, offset]
    }

    /// psi_0 and r_0 of the lead-in.
    #[inline]
    fn initial(&self) -> [T; 2] {
        let rate = self.yaw_rate.lead_in_mean_above_its_noise();
        [self.heading.lead_in_mean().unwrap_or(T::ZERO), rate.unwrap_or(T::ZERO)]
    }

    /// R^2 of both signals, each without and with the offset estimated again.
    #[inline]
    fn fit_of(&self, r2: impl Fn(&Comparison<T>) -> (Option<T>, Option<T>)) -> GoodnessOfFit<T> {
        let (r2_heading, r2_heading_offset_refit) = r2(&self.heading);
        let (r2_yaw_rate, r2_yaw_rate_offset_refit) = r2(&self.yaw_rate);
        GoodnessOfFit {
            r2_heading,
            r2_heading_offset_refit,
            r2_yaw_rate,
            r2_yaw_rate_offset_refit,
            samples: self.heading.samples,
        }
    }

    fn advance(&mut self, rudder_rad: T, interval_s: T) {
        let input = self.model.b2_per_s2 * rudder_rad + self.model.c0_rad_per_s2;
        if let Some(m) = self.restoring_per_s2 {
            let righted = |state, input| righted(self.model.a22_per_s, m, state, input, interval_s);
            self.forced = righted(self.forced, input);
            self.to_heading = righted(self.to_heading, T::ZERO);
            self.to_rate = righted(self.to_rate, T::ZERO);
            self.to_offset = righted(self.to_offset, T::ONE);
            return;
        }
        let step = Discretisation::new(self.model.a22_per_s, interval_s);
        self.forced = step.advance(self.forced, input);
        self.to_rate = step.advance(self.to_rate, T::ZERO);
        self.to_offset = step.advance(self.to_offset, T::ONE);
    }
}

/// The state `interval_s` later of psi'' = a psi' + m psi + `input`, rad/s^2.
fn righted<T: Real>(a: T, m: T, state: YawState<T>, input: T, interval_s: T) -> YawState<T> {
    let model = PitchModel::from_theta([a, m, T::ZERO, input]);
    let start = PitchState { pitch_rad: state.heading_rad, pitch_rate_rad_s: state.yaw_rate_rad_s };
    let after = model.advance(start, T::ZERO, interval_s);
    YawState { heading_rad: after.pitch_rad, yaw_rate_rad_s: after.pitch_rate_rad_s }
}

/// A parameter of which this share or less is its own, beside the others', is not told from them.
const PIVOT: f64 = 1e-9;

/// Sums over one measured signal and its simulation.
///
/// `gram` is the Gram matrix of [measured - forced, response to psi_0, to r_0, to C].
#[derive(Clone, Copy, Debug, Default)]
struct Comparison<T> {
    samples: u32,
    gram: [[T; 4]; 4],
    mean: T,
    sum_of_squares: T,
    lead_in_samples: u32,
    lead_in_sum: T,
    /// About the mean of the lead-in.
    lead_in_squares: T,
}

impl<T: Real> Comparison<T> {
    fn add(
        &mut self,
        measured: T,
        forced: T,
        [to_heading, to_rate, to_offset]: [T; 3],
        is_lead_in: bool,
    ) {
        let terms = [measured - forced, to_heading, to_rate, to_offset];
        for (row, left) in self.gram.iter_mut().zip(terms) {
            for (entry, right) in row.iter_mut().zip(terms) {
                *entry += left * right;
            }
        }
        self.samples += 1;
        // Welford's recursion: exactly 0 for a constant signal.
        let deviation = measured - self.mean;
        self.mean += deviation / T::of(f64::from(self.samples));
        self.sum_of_squares += deviation * (measured - self.mean);
        if is_lead_in {
            let before = self.lead_in_mean().unwrap_or(measured);
            self.lead_in_samples += 1;
            self.lead_in_sum += measured;
            let after = self.lead_in_mean().unwrap_or(measured);
            self.lead_in_squares += (measured - before) * (measured - after);
        }
    }

    fn lead_in_mean(&self) -> Option<T> {
        (self.lead_in_samples > 0)
            .then(|| self.lead_in_sum / T::of(f64::from(self.lead_in_samples)))
    }

    /// m (1 - s^2/(k m^2)), at least 0 of m.
    fn lead_in_mean_above_its_noise(&self) -> Option<T> {
        let mean = self.lead_in_mean()?;
        let count = T::of(f64::from(self.lead_in_samples));
        if self.lead_in_samples < 2 || mean == T::ZERO {
            return Some(mean);
        }
        let variance_of_mean = self.lead_in_squares / (count * (count - T::ONE));
        let noise = variance_of_mean / (mean * mean);
        Some(mean * (T::ONE - noise).max(T::ZERO))
    }

    /// The offset that makes the squared error least: <e, psi_c> / <psi_c, psi_c>.
    fn refit_offset(&self, [heading, rate]: [T; 2]) -> Option<T> {
        let [_, _, _, [e, to_heading, to_rate, to_offset]] = self.gram;
        let offset = (e - heading * to_heading - rate * to_rate) / to_offset;
        offset.is_finite().then_some(offset)
    }

    /// psi_0, r_0 and dC that make the squared error least; 0 for what is not `free` or does not act on this signal.
    fn least_squares(&self, free: [bool; 3]) -> [T; 3] {
        let [[_, error @ ..], rows @ ..] = self.gram;
        let mut normal = [[T::ZERO; 3]; 3];
        for ((to, [_, row @ ..]), row_is_free) in normal.iter_mut().zip(rows).zip(free) {
            for ((to, entry), is_free) in to.iter_mut().zip(row).zip(free) {
                if row_is_free && is_free {
                    *to = entry;
                }
            }
        }
        eliminated(normal, error)
    }

    /// 1 - J / Var (35): both are 1/n of their sums.
    fn r2(&self, [heading, rate]: [T; 2], offset: T) -> Option<T> {
        let weights = [T::ONE, -heading, -rate, -offset];
        let squared_error: T = self
            .gram
            .iter()
            .zip(weights)
            .map(|(row, left)| {
                left * row.iter().zip(weights).map(|(g, right)| *g * right).sum::<T>()
            })
            .sum();
        let r2 = T::ONE - squared_error / self.sum_of_squares;
        // A square below 0 is what rounding leaves of a simulation that went far away.
        (self.sum_of_squares > T::ZERO && r2.is_finite() && r2 <= T::of(1.001)).then_some(r2)
    }
}

/// Solves the normal equations of three parameters, row by row, by Gauss and Jordan; 0 for a parameter without a pivot.
fn eliminated<T: Real>(mut normal: [[T; 3]; 3], mut right: [T; 3]) -> [T; 3] {
    let least = [normal[0][0], normal[1][1], normal[2][2]].map(|entry| entry * T::of(PIVOT));
    let is_solved = [
        pivoted::<T, 0>(&mut normal, &mut right, least[0]),
        pivoted::<T, 1>(&mut normal, &mut right, least[1]),
        pivoted::<T, 2>(&mut normal, &mut right, least[2]),
    ];
    let of = |is_solved: bool, value: T| if is_solved { value } else { T::ZERO };
    [of(is_solved[0], right[0]), of(is_solved[1], right[1]), of(is_solved[2], right[2])]
}

/// Solves row P for its own parameter and takes that out of the other rows; `false` where its pivot is not above `least`.
///
/// Rows are told by a constant and walked by iterators: an index that could be out of range is a panic path.
fn pivoted<T: Real, const P: usize>(
    normal: &mut [[T; 3]; 3],
    right: &mut [T; 3],
    least: T,
) -> bool {
    let of_pivot = normal[P][P];
    let is_large = of_pivot > least;
    if !is_large {
        return false;
    }
    let row = normal[P].map(|entry| entry / of_pivot);
    let of_right = right[P] / of_pivot;
    normal[P] = row;
    right[P] = of_right;
    let others = normal.iter_mut().zip(right).enumerate();
    for (_, (other, right)) in others.filter(|(i, _)| *i != P) {
        let factor = other[P];
        for (entry, of_row) in other.iter_mut().zip(row) {
            *entry -= factor * of_row;
        }
        *right -= factor * of_right;
    }
    true
}

#[cfg(test)]
mod tests {
    extern crate std;
    use std::vec::Vec;

    use super::*;

    const TRUTH: [f64; 3] = [-1.07, 1.08, 0.012];

    /// A run from rest at `heading_rad`: 2 s lead-in, a doublet, the rest neutral.
    fn run(heading_rad: f64, intervals_s: impl Fn(u32) -> f64) -> Vec<Sample<f64>> {
        let model = YawModel::from_theta(TRUTH);
        let neutral = -model.delta0_rad().unwrap();
        let mut state = YawState { heading_rad, yaw_rate_rad_s: 0.0 };
        let mut time_s = 0.0;
        (0..330)
            .map(|k| {
                let rudder_rad = neutral
                    + match time_s {
                        t if (2.0..4.0).contains(&t) => 0.15,
                        t if (4.0..6.0).contains(&t) => -0.15,
                        _ => 0.0,
                    };
                let sample = Sample {
                    time_s,
                    heading_rad: Real::wrapped(state.heading_rad),
                    rudder_rad,
                    yaw_rate_rad_s: Some(state.yaw_rate_rad_s),
                    ..Sample::default()
                };
                state = model.advance(state, rudder_rad, intervals_s(k));
                time_s += intervals_s(k);
                sample
            })
            .collect()
    }

    #[test]
    fn exact_the_simulation_from_the_start_that_is_found_has_the_r2_that_is_stated() {
        let samples = run(3.0, |_| 0.05);
        // It begins in the turn of the doublet, and the model is not the truth.
        let samples = &samples[90..];
        let model = YawModel::from_theta([-0.8, 1.2, 0.03]);
        let mut validation = Validation::new(model, 0.5);
        samples.iter().for_each(|sample| validation.compare(sample));
        for (from_any_start, fit) in [
            (false, validation.goodness_of_fit()),
            (true, validation.goodness_of_fit_from_any_start()),
        ] {
            for (again, stated) in [(false, fit.r2_heading), (true, fit.r2_heading_offset_refit)] {
                let [heading, rate, offset] = validation.heading_start(from_any_start, again);
                let mut state = YawState { heading_rad: heading, yaw_rate_rad_s: rate };
                let model = YawModel::from_theta([-0.8, 1.2, 0.03 + offset]);
                let (mut error, mut turned, mut squares, mut sum) = (0.0, 0.0, 0.0, 0.0);
                for (k, sample) in samples.iter().enumerate() {
                    if let Some(last) = k.checked_sub(1).map(|last| &samples[last]) {
                        state = model.advance(state, last.rudder_rad, 0.05);
                        turned += Real::wrapped(sample.heading_rad - last.heading_rad);
                    }
                    error += (state.heading_rad - turned).powi(2);
                    squares += turned * turned;
                    sum += turned;
                }
                let variation = squares - sum * sum / samples.len() as f64;
                let r2 = 1.0 - error / variation;
                // Sums of 240 products, rounded.
                assert!((r2 - stated.unwrap()).abs() < 1e-9, "{r2} {stated:?}");
            }
        }
    }

    #[test]
    fn exact_truth_scores_one_across_a_wrap_and_with_jitter() {
        for heading_rad in [0.0, 3.1, -3.1] {
            let samples = run(heading_rad, |k| if k % 3 == 0 { 0.02 } else { 0.065 });
            let fit = Validation::of(YawModel::from_theta(TRUTH), 2.0, &samples);
            assert_eq!(fit.samples, 330);
            // Exact simulation: what is left is rounding.
            for r2 in [fit.r2_heading, fit.r2_heading_offset_refit, fit.r2_yaw_rate] {
                assert!((r2.unwrap() - 1.0).abs() < 1e-12, "{fit:?}");
            }
        }
    }

    #[test]
    fn exact_offset_is_found_again() {
        let samples = run(0.3, |_| 0.05);
        let mut model = YawModel::from_theta(TRUTH);
        model.c0_rad_per_s2 += 0.01;
        let fit = Validation::of(model, 2.0, &samples);
        assert!(fit.r2_heading.unwrap() < 0.9, "{fit:?}");
        // Only the offset was wrong: refitted, the truth is back to rounding.
        for r2 in [fit.r2_heading_offset_refit, fit.r2_yaw_rate_offset_refit] {
            assert!((r2.unwrap() - 1.0).abs() < 1e-12, "{fit:?}");
        }
    }

    #[test]
    fn exact_a_start_in_a_turn_is_fitted() {
        let samples = run(0.3, |_| 0.05);
        let mut model = YawModel::from_theta(TRUTH);
        let fit = |model, samples: &[Sample<f64>]| {
            let mut validation = Validation::new(model, 0.0);
            samples.iter().for_each(|sample| validation.compare(sample));
            validation
        };
        // From the middle of a stroke, where it turns.
        let turning: Vec<_> =
            samples[60..].iter().map(|sample| Sample { yaw_rate_rad_s: None, ..*sample }).collect();
        let from_rest = fit(model, &turning).goodness_of_fit();
        assert!(from_rest.r2_heading.unwrap() < 0.9, "{from_rest:?}");
        let found = fit(model, &turning).goodness_of_fit_from_any_start();
        assert!((found.r2_heading.unwrap() - 1.0).abs() < 1e-12, "{found:?}");
        assert_eq!(found.r2_yaw_rate, None);
        // With the offset estimated again, too, and for the yaw rate.
        model.c0_rad_per_s2 += 0.01;
        let found = fit(model, &samples[60..]).goodness_of_fit_from_any_start();
        for r2 in [found.r2_heading_offset_refit, found.r2_yaw_rate_offset_refit] {
            assert!((r2.unwrap() - 1.0).abs() < 1e-9, "{found:?}");
        }
        assert!(found.r2_heading < found.r2_heading_offset_refit);
    }

    #[test]
    fn exact_what_cannot_be_judged_is_none() {
        let constant: Vec<_> = (0..50)
            .map(|k| Sample {
                time_s: f64::from(k) * 0.1,
                heading_rad: 0.1,
                yaw_rate_rad_s: Some(0.1),
                ..Sample::default()
            })
            .collect();
        let fit = Validation::of(YawModel::from_theta(TRUTH), 2.0, &constant);
        assert_eq!(fit, GoodnessOfFit { samples: 50, ..GoodnessOfFit::default() });
        let nothing = Validation::of(YawModel::from_theta(TRUTH), 2.0, &[]);
        assert_eq!(nothing, GoodnessOfFit::default());
        let unknown = Validation::of(YawModel::from_theta([f64::NAN; 3]), 2.0, &run(0.0, |_| 0.05));
        assert_eq!(unknown.r2_heading, None);
    }

    #[test]
    fn exact_unusable_samples_are_left_out() {
        let mut samples = run(0.0, |_| 0.05);
        samples[100].heading_rad = f64::NAN;
        samples[150].time_s = samples[149].time_s;
        samples[200].yaw_rate_rad_s = Some(f64::INFINITY);
        let fit = Validation::of(YawModel::from_theta(TRUTH), 2.0, &samples);
        assert_eq!(fit.samples, 328);
        // The rudder is constant around the samples left out, so the simulation stays exact.
        assert!((fit.r2_yaw_rate.unwrap() - 1.0).abs() < 1e-12, "{fit:?}");
    }

    #[test]
    fn parity_f32_agrees_with_f64() {
        let samples = run(3.0, |_| 0.05);
        let singles: Vec<_> = samples
            .iter()
            .map(|s| Sample {
                time_s: s.time_s,
                heading_rad: s.heading_rad as f32,
                rudder_rad: s.rudder_rad as f32,
                ..Sample::default()
            })
            .collect();
        let theta = [-0.9, 1.0, 0.01];
        let double = Validation::of(YawModel::from_theta(theta), 2.0, &samples);
        let single = Validation::of(YawModel::from_theta(theta.map(|p| p as f32)), 2.0, &singles);
        let difference = double.r2_heading.unwrap() - f64::from(single.r2_heading.unwrap());
        // 330 sums of f32 rounding (6e-8) on terms of the size of the variance.
        assert!(difference.abs() < 1e-4, "{difference}");
    }
}
