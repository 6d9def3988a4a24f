//! When the estimate has stopped moving.

use crate::Real;
use crate::setting::{InvalidSetting, is_positive, require};

/// The filter pole and the sampling interval for which the paper states threshold and count: rad/s, s.
const PAPER_LAMBDA_RAD_S: f64 = 1.5;
const PAPER_INTERVAL_S: f64 = 0.05;

/// At least this many samples in a row must agree, however long the intervals are.
const LEAST_IN_A_ROW: u32 = 3;

/// When an estimate counts as converged.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ConvergenceSettings<T> {
    /// Largest step of Theta, Euclidean norm over a22 (1/s), b2 (1/s^2) and C0 (rad/s^2).
    pub threshold: T,
    /// Samples in a row that must stay under it.
    pub consecutive: u32,
    /// Both hold in the vehicle's own time, [`Pace`], rather than in seconds and samples.
    #[cfg_attr(feature = "serde", serde(default))]
    pub in_own_time: bool,
}

impl<T: Real> ConvergenceSettings<T> {
    /// Names the first setting that is out of its range, as `convergence.threshold`.
    ///
    /// ```
    /// use seatrial_core::ConvergenceSettings;
    ///
    /// let settings = ConvergenceSettings { threshold: 0.001, consecutive: 0, in_own_time: false };
    /// let error = settings.check().expect_err("no sample in a row is none");
    /// assert_eq!(error.to_string(), "convergence.consecutive must be at least 1");
    /// ```
    pub fn check(&self) -> Result<(), InvalidSetting> {
        require(is_positive(self.threshold), "convergence.threshold", "a positive number")?;
        require(self.consecutive > 0, "convergence.consecutive", "at least 1")
    }
}

/// How a vehicle's time compares with that of the paper's, for which the numbers of (39) are meant.
///
/// ```text
/// tau = (1.5 rad/s) / lambda                                       the vehicle's second
/// n   = h / (0.05 tau)                                             an interval in the paper's samples
/// |Theta(t_k) - Theta(t_k-1)| -> |[da22 tau, db2 tau^2, dC0 tau^2]| / n
/// ```
///
/// | symbol | identifier | unit |
/// |---|---|---|
/// | tau | `second_s` | s |
/// | n | `samples` | - |
/// | h | `interval_s` | s |
///
/// A vehicle that is a hundred times slower and sampled a hundred times slower converges at the same sample. At
/// the paper's 20 Hz and lambda = 1.5 rad/s, and wherever `in_own_time` is off, tau = 1 s and n = 1: (39) as printed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace<T> {
    second_s: T,
    samples: T,
}

impl<T: Real> Pace<T> {
    /// The pace of a sample `interval_s` (s) after the one before, with filters of this lambda (rad/s). A first sample,
    /// `interval_s` = 0, counts as one at the paper's rate.
    ///
    /// ```
    /// use seatrial_core::ConvergenceSettings;
    /// use seatrial_core::convergence::Pace;
    ///
    /// let settings = ConvergenceSettings { threshold: 0.001, consecutive: 10, in_own_time: true };
    /// // A vehicle a hundred times slower, sampled a hundred times slower: the same step in its own time.
    /// let paper = Pace::new(&settings, 1.5, 0.05).step_norm([0.0; 3], [0.1_f64, 0.0, 0.0]);
    /// let slow = Pace::new(&settings, 0.015, 5.0).step_norm([0.0; 3], [0.001, 0.0, 0.0]);
    /// assert!((paper - slow).abs() < 1e-12);
    /// ```
    #[inline]
    pub fn new(settings: &ConvergenceSettings<T>, lambda_rad_s: T, interval_s: T) -> Self {
        if !settings.in_own_time {
            return Self { second_s: T::ONE, samples: T::ONE };
        }
        let second_s = T::of(PAPER_LAMBDA_RAD_S) / lambda_rad_s;
        let samples = interval_s / (T::of(PAPER_INTERVAL_S) * second_s);
        Self { second_s, samples: if samples > T::ZERO { samples } else { T::ONE } }
    }

    /// The step from one Theta to the next.
    ///
    /// ```
    /// use seatrial_core::ConvergenceSettings;
    /// use seatrial_core::convergence::Pace;
    ///
    /// let settings = ConvergenceSettings { threshold: 0.001, consecutive: 10, in_own_time: false };
    /// let pace = Pace::new(&settings, 1.5, 0.05);
    /// // 3, 4 and 12 thousandths of a22, b2 and C0.
    /// assert!((pace.step_norm([-1.0, 1.0, 0.0], [-1.003, 1.004, 0.012]) - 0.013_f64).abs() < 1e-12);
    /// ```
    pub fn step_norm(&self, before: [T; 3], after: [T; 3]) -> T {
        self.step(before, after).norm()
    }

    /// The step from one Theta to the next, its norm not yet taken.
    #[inline]
    pub(crate) fn step(&self, before: [T; 3], after: [T; 3]) -> ThetaStep<T> {
        let second_s = self.second_s;
        let units = [second_s, second_s * second_s, second_s * second_s];
        let squares: T = before
            .iter()
            .zip(&after)
            .zip(&units)
            .map(|((before, after), unit)| {
                let step = (*after - *before) * *unit;
                step * step
            })
            .sum();
        ThetaStep { squares, samples: self.samples }
    }
}

/// A step of Theta. A root and a division are saved where nobody asks for its norm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ThetaStep<T> {
    squares: T,
    samples: T,
}

impl<T: Real> ThetaStep<T> {
    pub(crate) fn none() -> Self {
        Self { squares: T::ZERO, samples: T::ONE }
    }

    pub(crate) fn norm(&self) -> T {
        self.squares.sqrt() / self.samples
    }
}

/// Criterion (39), met several times in a row.
///
/// ```text
/// |Theta(t_k) - Theta(t_k-1)|_2 < threshold          (39)
/// ```
///
/// An estimate that nothing excites does not move either: (39) alone fires before the doublet
/// begins. [`arm`](Self::arm) it when the excitation ends.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Convergence<T> {
    armed: bool,
    in_a_row: u32,
    /// `in_a_row` in samples of the paper's interval.
    lasted: T,
    detected_s: Option<f64>,
}

impl<T: Real> Convergence<T> {
    /// Counts from the next sample on.
    ///
    /// ```
    /// use seatrial_core::convergence::Pace;
    /// use seatrial_core::{Convergence, ConvergenceSettings};
    ///
    /// let settings = ConvergenceSettings { threshold: 0.001, consecutive: 3, in_own_time: false };
    /// let pace = Pace::new(&settings, 1.5, 0.05);
    /// let mut convergence = Convergence::default();
    /// // Still, but nothing has excited it yet.
    /// convergence.observe(0.0, &pace, 0.0, &settings);
    /// convergence.arm();
    /// for k in 0..5 {
    ///     convergence.observe(0.0005, &pace, 6.0 + 0.05 * f64::from(k), &settings);
    /// }
    /// // With the third small step after the doublet.
    /// assert_eq!(convergence.detected_s(), Some(6.1));
    /// ```
    pub fn arm(&mut self) {
        self.armed = true;
    }

    /// Does [`observe`](Self::observe) anything?
    #[inline]
    pub(crate) fn is_open(&self) -> bool {
        self.armed && self.detected_s.is_none()
    }

    /// Takes in one step of the estimate, `elapsed_s` after the start of the training.
    ///
    /// ```
    /// use seatrial_core::convergence::Pace;
    /// use seatrial_core::{Convergence, ConvergenceSettings};
    ///
    /// let settings = ConvergenceSettings { threshold: 0.001, consecutive: 3, in_own_time: false };
    /// let pace = Pace::new(&settings, 1.5, 0.05);
    /// let mut convergence = Convergence::default();
    /// convergence.arm();
    /// // A large step among the small ones: the count begins again.
    /// for (k, step) in [0.0005, 0.0005, 0.02, 0.0005, 0.0005].into_iter().enumerate() {
    ///     convergence.observe(step, &pace, 0.05 * k as f64, &settings);
    /// }
    /// assert_eq!(convergence.detected_s(), None);
    /// ```
    pub fn observe(
        &mut self,
        step_norm: T,
        pace: &Pace<T>,
        elapsed_s: f64,
        settings: &ConvergenceSettings<T>,
    ) {
        if !self.is_open() {
            return;
        }
        if step_norm < settings.threshold {
            self.in_a_row += 1;
            self.lasted += pace.samples;
        } else {
            self.in_a_row = 0;
            self.lasted = T::ZERO;
        }
        let wanted = T::of(f64::from(settings.consecutive) - 0.5);
        if self.lasted >= wanted && self.in_a_row >= LEAST_IN_A_ROW.min(settings.consecutive) {
            self.detected_s = Some(elapsed_s);
        }
    }

    /// Seconds from the start of the training to the detection.
    pub fn detected_s(&self) -> Option<f64> {
        self.detected_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_only_a_full_row_after_arming_counts() {
        let settings = ConvergenceSettings { threshold: 0.001, consecutive: 3, in_own_time: false };
        let pace = Pace::new(&settings, 0.1, 7.0);
        let mut convergence = Convergence::default();
        let steps = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.5];
        for (k, step) in (0_u32..).zip(steps) {
            if k == 4 {
                assert_eq!(convergence.detected_s(), None);
                convergence.arm();
            }
            convergence.observe(step, &pace, f64::from(k), &settings);
        }
        assert_eq!(convergence.detected_s(), Some(9.0));
    }

    #[test]
    fn exact_the_papers_vehicle_keeps_the_papers_time() {
        let settings = ConvergenceSettings { threshold: 0.001, consecutive: 10, in_own_time: true };
        let pace = Pace::new(&settings, 1.5, 0.05);
        assert_eq!(pace.step_norm([0.0; 3], [0.3, 0.4, 1.2]), 1.3);
        let mut convergence = Convergence::default();
        convergence.arm();
        for k in 1..=10_u32 {
            assert_eq!(convergence.detected_s(), None);
            convergence.observe(0.0, &pace, f64::from(k), &settings);
        }
        assert_eq!(convergence.detected_s(), Some(10.0));
    }

    #[test]
    fn exact_a_slower_vehicle_is_given_its_time() {
        let settings = ConvergenceSettings { threshold: 0.001, consecutive: 10, in_own_time: true };
        // A hundred times slower, sampled only twenty times slower: five times as many samples, each a fifth of the step.
        let pace = Pace::new(&settings, 0.015, 1.0);
        let step = pace.step_norm([0.0; 3], [0.003, 0.0, 0.0]);
        // 0.003 1/s in units of 1/(100 s), a fifth of the paper's interval.
        assert!((step - 0.003 * 100.0 * 5.0_f64).abs() < 1e-12);
        let mut convergence = Convergence::default();
        convergence.arm();
        let mut samples = 0_u32;
        while convergence.detected_s().is_none() {
            samples += 1;
            convergence.observe(0.0, &pace, f64::from(samples), &settings);
        }
        // 9.5 of the paper's samples, five to each.
        assert_eq!(samples, 48);
    }
}
