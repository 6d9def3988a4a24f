//! The state variable filter: derivatives of a sampled signal without differentiating it.

use crate::Real;
use crate::model::{PHI_SERIES_BELOW, phi, phi_series};

/// How a signal is taken to run between two samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Hold {
    /// Constant until the next sample: right for a commanded rudder.
    ZeroOrder,
    /// On the straight line to the next sample: right for a heading.
    FirstOrder,
}

/// Where a filter starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum FilterStart {
    /// Zero state, as the paper does: the first signal value acts as a step.
    Zero,
    /// As if the signal had always had its first value.
    Equilibrium,
}

/// What one filter step needs to know about its interval; shared by filters of equal lambda.
///
/// Computed again only when the interval changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilterStep<T> {
    lambda_rad_s: T,
    interval_s: T,
    /// e^-x, x = lambda h
    decay: T,
    /// x e^-x
    coupling: T,
    /// (1 - e^-x)/x
    ramp_to_deviation: T,
    /// (1 - e^-x)/x - e^-x
    ramp_to_lag: T,
}

impl<T: Real> FilterStep<T> {
    /// For filters with a double pole at `-lambda_rad_s`, at an interval of 0.
    pub fn new(lambda_rad_s: T) -> Self {
        Self {
            lambda_rad_s,
            interval_s: T::ZERO,
            decay: T::ONE,
            coupling: T::ZERO,
            ramp_to_deviation: T::ONE,
            ramp_to_lag: T::ZERO,
        }
    }

    /// Makes the next step one of `interval_s`.
    ///
    /// ```
    /// use seatrial_core::{FilterStart, FilterStep, Hold, StateVariableFilter};
    ///
    /// let mut step = FilterStep::new(2.0);
    /// step.set_interval(0.5);
    /// let mut filter = StateVariableFilter::new(0.0, FilterStart::Equilibrium);
    /// filter.advance(1.0, Hold::ZeroOrder, &step);
    /// // A step of a double lag is still 0 with its slope at the instant of the step.
    /// assert_eq!((filter.smoothed(), filter.first_derivative(&step)), (0.0, 0.0));
    /// filter.advance(1.0, Hold::ZeroOrder, &step);
    /// // 1 - (1 + lambda h) e^{-lambda h}
    /// assert!((filter.smoothed() - (1.0 - 2.0 * (-1.0_f64).exp())).abs() < 1e-12);
    /// ```
    #[inline]
    pub fn set_interval(&mut self, interval_s: T) {
        if interval_s == self.interval_s {
            return;
        }
        let x = self.lambda_rad_s * interval_s;
        let (phi1, phi2) = phi(-x);
        self.interval_s = interval_s;
        self.decay = (-x).exp();
        self.coupling = x * self.decay;
        self.ramp_to_deviation = phi1;
        self.ramp_to_lag = x * (phi1 - phi2);
    }

    /// Makes the next step one of `interval_s`, by e^-x = 1 - x phi1(-x) and the series of phi1, which is less code than
    /// [`set_interval`](Self::set_interval). `false`, and no change, unless 0 < x = lambda h < 0.5.
    #[inline]
    pub(crate) fn set_short_interval(&mut self, interval_s: T) -> bool {
        let x = self.lambda_rad_s * interval_s;
        if !(interval_s > T::ZERO && x < T::of(PHI_SERIES_BELOW)) {
            return false;
        }
        let (phi1, phi2) = phi_series(-x);
        self.interval_s = interval_s;
        self.decay = T::ONE - x * phi1;
        self.coupling = x * self.decay;
        self.ramp_to_deviation = phi1;
        self.ramp_to_lag = x * (phi1 - phi2);
        true
    }

    /// lambda, rad/s.
    pub fn lambda_rad_s(&self) -> T {
        self.lambda_rad_s
    }
}

/// State variable filter of order 2: a signal w and its first two derivatives, low-pass filtered.
///
/// ```text
/// F(s) = lambda^2/(s + lambda)^2 [s^2  s  1]^T                       (16), (23)
/// x'   = A x + B w,   y = C x + D w                                  (26)-(28)
/// ```
///
/// F is two equal first-order lags, q1' = lambda (w - q1) and q0' = lambda (q1 - q0). The state kept
/// here is u = q1 - w and v = q1 - q0, so that only increments of the signal enter and neither its
/// level nor the size of h costs precision. With x = lambda h and the signal's increment dw, the
/// exact solution over one interval (29)-(31), in which A_d = e^-x [[1 - x, -lambda^2 h], [h, 1 + x]], is
///
/// ```text
/// v+ = e^-x v - x e^-x u + g2 dw        g2 = 0 (zero-order hold),  (1 - e^-x)/x - e^-x (first-order)
/// u+ = e^-x u - g1 dw                   g1 = 1 (zero-order hold),  (1 - e^-x)/x        (first-order)
/// w2 = -lambda^2 (u + v),   w1 = lambda v,   w0 = w + u - v
/// ```
///
/// | symbol | identifier | unit |
/// |---|---|---|
/// | lambda | [`FilterStep::lambda_rad_s`] | rad/s |
/// | w | `signal` | the signal's |
/// | u | `deviation` | the signal's |
/// | v | `lag` | the signal's |
/// | w2, w1, w0 | [`second_derivative`](Self::second_derivative), [`first_derivative`](Self::first_derivative), [`smoothed`](Self::smoothed) | signal/s^2, signal/s, signal |
///
/// Source: equations (16)-(31); (29) prints a dot over x that does not belong there.
/// Valid for every h >= 0; h may differ from sample to sample. An h above 1/lambda is stable, but the
/// hold then says more about the signal than the samples do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StateVariableFilter<T> {
    signal: T,
    deviation: T,
    lag: T,
}

impl<T: Real> StateVariableFilter<T> {
    /// A filter whose first sample is `signal`.
    ///
    /// ```
    /// use seatrial_core::{FilterStart, StateVariableFilter};
    ///
    /// assert_eq!(StateVariableFilter::new(0.3, FilterStart::Equilibrium).smoothed(), 0.3);
    /// assert_eq!(StateVariableFilter::new(0.3, FilterStart::Zero).smoothed(), 0.0);
    /// ```
    pub fn new(signal: T, start: FilterStart) -> Self {
        Self {
            signal,
            deviation: match start {
                FilterStart::Zero => -signal,
                FilterStart::Equilibrium => T::ZERO,
            },
            lag: T::ZERO,
        }
    }

    /// Adds another filter's state, scaled: the filter is linear in its signal.
    ///
    /// ```
    /// use seatrial_core::{FilterStart, StateVariableFilter};
    ///
    /// // A filter is linear in its signal.
    /// let mut sum = StateVariableFilter::new(0.1, FilterStart::Equilibrium);
    /// sum.add_scaled(&StateVariableFilter::new(0.4, FilterStart::Equilibrium), 0.5);
    /// assert!((sum.smoothed() - 0.3_f64).abs() < 1e-12);
    /// ```
    pub fn add_scaled(&mut self, other: &Self, factor: T) {
        self.signal += factor * other.signal;
        self.deviation += factor * other.deviation;
        self.lag += factor * other.lag;
    }

    /// Takes in the signal one interval later.
    ///
    /// ```
    /// use seatrial_core::{FilterStart, FilterStep, Hold, StateVariableFilter};
    ///
    /// let mut step = FilterStep::new(1.5);
    /// step.set_interval(0.05);
    /// let mut heading = StateVariableFilter::new(0.0, FilterStart::Equilibrium);
    /// // 20 s of a turn of 0.2 rad/s: its derivative, and no acceleration.
    /// for k in 1..=400 {
    ///     heading.advance(0.01 * f64::from(k), Hold::FirstOrder, &step);
    /// }
    /// assert!((heading.first_derivative(&step) - 0.2).abs() < 1e-9);
    /// assert!(heading.second_derivative(&step).abs() < 1e-9);
    /// ```
    pub fn advance(&mut self, signal: T, hold: Hold, step: &FilterStep<T>) {
        self.advance_by(signal - self.signal, hold, step);
        self.signal = signal;
    }

    /// Takes in the signal's increment over one interval.
    #[inline]
    pub fn advance_by(&mut self, increment: T, hold: Hold, step: &FilterStep<T>) {
        let lag = step.decay * self.lag - step.coupling * self.deviation;
        let deviation = step.decay * self.deviation;
        match hold {
            Hold::ZeroOrder => {
                self.lag = lag;
                self.deviation = deviation - increment;
            }
            Hold::FirstOrder => {
                self.lag = lag + step.ramp_to_lag * increment;
                self.deviation = deviation - step.ramp_to_deviation * increment;
            }
        }
        self.signal += increment;
    }

    /// Filtered second derivative, signal/s^2.
    #[inline]
    pub fn second_derivative(&self, step: &FilterStep<T>) -> T {
        -(step.lambda_rad_s * step.lambda_rad_s) * (self.deviation + self.lag)
    }

    /// Filtered first derivative, signal/s.
    #[inline]
    pub fn first_derivative(&self, step: &FilterStep<T>) -> T {
        step.lambda_rad_s * self.lag
    }

    /// Filtered signal.
    ///
    /// ```
    /// use seatrial_core::{FilterStart, FilterStep, Hold, StateVariableFilter};
    ///
    /// let mut step = FilterStep::new(1.5);
    /// step.set_interval(0.05);
    /// let mut filter = StateVariableFilter::new(0.0, FilterStart::Equilibrium);
    /// for k in 1..=400 {
    ///     filter.advance(0.01 * f64::from(k), Hold::FirstOrder, &step);
    /// }
    /// // A ramp of 0.2/s comes 2/lambda late.
    /// assert!((filter.signal() - filter.smoothed() - 0.2 * 2.0 / 1.5).abs() < 1e-9);
    /// ```
    #[inline]
    pub fn smoothed(&self) -> T {
        self.signal + (self.deviation - self.lag)
    }

    /// The signal's latest value.
    pub fn signal(&self) -> T {
        self.signal
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outputs(filter: &StateVariableFilter<f64>, step: &FilterStep<f64>) -> [f64; 3] {
        [filter.second_derivative(step), filter.first_derivative(step), filter.smoothed()]
    }

    /// The printed matrices (28)-(31), step by step, against the increments used here.
    #[test]
    fn exact_equals_the_printed_matrices() {
        let (lambda, h) = (1.5_f64, 0.3_f64);
        let x = lambda * h;
        let e = (-x).exp();
        let a_d = [[e * (1.0 - x), -e * lambda * lambda * h], [e * h, e * (1.0 + x)]];
        let b_d = [h * e, (1.0 - (1.0 + x) * e) / (lambda * lambda)];

        let mut step = FilterStep::new(lambda);
        step.set_interval(h);
        let mut signal = 0.7;
        let mut filter = StateVariableFilter::new(signal, FilterStart::Zero);
        let mut state = [0.0, 0.0];
        for k in 0..50 {
            let gain = lambda * lambda;
            let expected = [
                gain * (signal - 2.0 * lambda * state[0] - gain * state[1]),
                gain * state[0],
                gain * state[1],
            ];
            for (found, expected) in outputs(&filter, &step).iter().zip(expected) {
                // Some tens of roundings of numbers of order 1.
                assert!((found - expected).abs() < 1e-14, "sample {k}");
            }
            state = [
                a_d[0][0] * state[0] + a_d[0][1] * state[1] + b_d[0] * signal,
                a_d[1][0] * state[0] + a_d[1][1] * state[1] + b_d[1] * signal,
            ];
            signal = (f64::from(k) * 0.9).sin();
            filter.advance(signal, Hold::ZeroOrder, &step);
        }
    }

    /// A ramp is first-order-hold exact, so its steady state has no error at any interval. What is left of the start after 28 s is
    /// exp(-56) of it.
    #[test]
    fn exact_ramp_keeps_its_slope() {
        let mut step = FilterStep::new(2.0);
        let mut filter = StateVariableFilter::new(3.0, FilterStart::Equilibrium);
        let mut signal = 3.0;
        for k in 0..220 {
            let h = if k % 3 == 0 { 0.02 } else { 0.7 };
            step.set_interval(h);
            signal += 0.4 * h;
            filter.advance(signal, Hold::FirstOrder, &step);
            let [second, first, zeroth] = outputs(&filter, &step);
            if k < 120 {
                continue;
            }
            // Roundings of a signal that reaches 30.
            assert!(second.abs() < 1e-13 && (first - 0.4).abs() < 1e-14);
            // A double lag trails a ramp by 2/lambda.
            assert!((zeroth - (signal - 0.4)).abs() < 1e-13);
        }
    }

    /// Splitting an interval changes nothing while the signal follows its hold.
    #[test]
    fn prop_two_half_steps_equal_one_step() {
        for hold in [Hold::ZeroOrder, Hold::FirstOrder] {
            let mut step = FilterStep::new(1.3);
            let mut whole = StateVariableFilter::new(0.2, FilterStart::Zero);
            let mut halves = whole;
            step.set_interval(0.5);
            whole.advance(0.9, hold, &step);
            step.set_interval(0.25);
            let middle = match hold {
                Hold::ZeroOrder => 0.2,
                Hold::FirstOrder => 0.55,
            };
            halves.advance(middle, hold, &step);
            halves.advance(0.9, hold, &step);
            for (one, two) in outputs(&whole, &step).iter().zip(outputs(&halves, &step)) {
                assert!((one - two).abs() < 1e-15);
            }
        }
    }

    /// 3 rad at 100 Hz for 10 minutes: f32 stays within a few of its own roundings.
    #[test]
    fn exact_f32_keeps_a_constant_heading_still() {
        let mut step = FilterStep::new(1.0_f32);
        step.set_interval(0.01);
        let mut filter = StateVariableFilter::new(3.0_f32, FilterStart::Zero);
        for _ in 0..60_000 {
            filter.advance(3.0, Hold::ZeroOrder, &step);
        }
        assert!(filter.second_derivative(&step).abs() < 1e-12);
        assert_eq!(filter.smoothed(), 3.0);
    }
}
