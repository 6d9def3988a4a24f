//! The recursive instrumental variable.

use crate::model::{Discretisation, YawModel};
use crate::{PitchModel, PitchState, Real, RecursiveLeastSquares};

/// Smallest denominator 1 + Phi^T P zeta with which a sample is still learnt from; least squares never goes below 1.
const SMALLEST_DENOMINATOR: f64 = 0.1;

/// Limits of a22 for filters of 0.5 to 4 rad/s.
const SLOWEST_PER_S: f64 = -0.05;
const FASTEST_PER_S: f64 = -10.0;

/// The yaw rate that the rudder alone explains: free of compass noise, and so an instrument.
///
/// ```text
/// z' = a22 z + b2 delta_f + C0
/// z+ = e^{a22 h} z + h phi1(a22 h) (b2 (delta_f + delta_f+)/2 + C0)
/// ```
///
/// | symbol | identifier | unit |
/// |---|---|---|
/// | z | [`yaw_rate_rad_s`](Self::yaw_rate_rad_s), filtered as the measured one is | rad/s |
/// | delta_f | `rudder_rad`, filtered | rad |
/// | a22, b2, C0 | `model`, the latest estimate | 1/s, 1/s^2, rad/s^2 |
///
/// A rough early estimate must not throw z away, so a22 is taken to the nearest value between -10 and
/// -0.05 1/s; limits made for filters of 0.5 to 4 rad/s, in proportion to lambda beyond.
///
/// In pitch, the angle that the elevator alone explains is an instrument, too: [`advance_righted`](Self::advance_righted).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AuxiliaryModel<T> {
    yaw_rate_rad_s: T,
    rudder_rad: T,
    heading_rad: T,
}

impl<T: Real> AuxiliaryModel<T> {
    /// At rest, with this filtered rudder.
    pub fn new(rudder_rad: T) -> Self {
        Self::from(T::ZERO, T::ZERO, rudder_rad)
    }

    /// From this filtered angle, rad, its rate, rad/s, and this filtered rudder, rad.
    pub fn from(heading_rad: T, yaw_rate_rad_s: T, rudder_rad: T) -> Self {
        Self { yaw_rate_rad_s, rudder_rad, heading_rad }
    }

    /// The angle that the rudder alone explains, rad; moved by [`advance_righted`](Self::advance_righted) only.
    pub fn heading_rad(&self) -> T {
        self.heading_rad
    }

    /// z, rad/s.
    pub fn yaw_rate_rad_s(&self) -> T {
        self.yaw_rate_rad_s
    }

    /// Moves on by an interval, at whose end the filtered rudder is `rudder_rad`.
    ///
    /// ```
    /// use seatrial_core::{AuxiliaryModel, YawModel};
    ///
    /// let model = YawModel::from_theta([-1.0, 1.0, 0.0]);
    /// let mut auxiliary = AuxiliaryModel::new(0.2);
    /// for _ in 0..400 {
    ///     auxiliary.advance(&model, 0.2, 0.05, 1.5);
    /// }
    /// // After 20 s the yaw rate is that of the steady turn, -b2 delta/a22.
    /// assert!((auxiliary.yaw_rate_rad_s() - 0.2_f64).abs() < 1e-6);
    /// ```
    #[inline]
    pub fn advance(&mut self, model: &YawModel<T>, rudder_rad: T, interval_s: T, lambda_rad_s: T) {
        let a22_per_s = match model.a22_per_s {
            // Within the limits of every lambda.
            usual if usual > T::of(FASTEST_PER_S) && usual < T::of(SLOWEST_PER_S) => usual,
            other => {
                let slowest = T::of(SLOWEST_PER_S) * (lambda_rad_s / T::of(0.5)).min(T::ONE);
                let fastest = T::of(FASTEST_PER_S) * (lambda_rad_s / T::of(4.0)).max(T::ONE);
                other.min(slowest).max(fastest)
            }
        };
        let step = Discretisation::new(a22_per_s, interval_s);
        let mean_rudder_rad = T::of(0.5) * (self.rudder_rad + rudder_rad);
        let input = model.b2_per_s2 * mean_rudder_rad + model.c0_rad_per_s2;
        self.yaw_rate_rad_s = step.decay * self.yaw_rate_rad_s + step.rate_gain_s * input;
        self.rudder_rad = rudder_rad;
    }

    /// Moves pitch on by an interval with the filtered elevator at its end.
    ///
    /// ```
    /// use seatrial_core::{AuxiliaryModel, PitchModel};
    ///
    /// let model = PitchModel::from_theta([-1.2, -0.4, 0.8, 0.0]);
    /// let mut auxiliary = AuxiliaryModel::new(0.1);
    /// auxiliary.advance_righted(&model, 0.1, 60.0);
    /// // The angle that the elevator alone explains: -b delta/m.
    /// assert!((auxiliary.heading_rad() - 0.2_f64).abs() < 1e-6);
    /// ```
    pub fn advance_righted(&mut self, model: &PitchModel<T>, elevator_rad: T, interval_s: T) {
        let state =
            PitchState { pitch_rad: self.heading_rad, pitch_rate_rad_s: self.yaw_rate_rad_s };
        let after = model.advance(state, elevator_rad, interval_s);
        self.heading_rad = after.pitch_rad;
        self.yaw_rate_rad_s = after.pitch_rate_rad_s;
        self.rudder_rad = elevator_rad;
    }
}

/// Recursive instrumental variable for y = Phi^T Theta.
///
/// ```text
/// Phi = [p_f, psi'_f, delta_f, 1]^T,  zeta = [p_f, z, delta_f, 1]^T,  Theta = [beta, a22, b2, C0]^T
/// e = psi''_f - Phi^T Theta
/// K = P zeta / (1 + Phi^T P zeta)
/// Theta <- Theta + K e
/// P <- P - K Phi^T P
/// ```
///
/// | symbol | identifier | unit |
/// |---|---|---|
/// | p_f, beta | the pulse of a lost rudder edge and its parameter, [`UnseenRudder`](crate::UnseenRudder) | rad, 1/s^2 |
/// | Phi | `regressor` | rad, rad/s, rad, 1 |
/// | zeta | `instrument`, z from [`AuxiliaryModel`] | rad, rad/s, rad, 1 |
/// | psi''_f | `observation` | rad/s^2 |
/// | P | [`covariance`](Self::covariance) | - |
///
/// Compass noise is in psi'_f as well as in psi''_f, which biases least squares; z is free of it. The
/// recursion goes on from Theta and P of least squares when the excitation is over. P is **not
/// symmetric** from then on, and is the covariance of nothing.
///
/// A sample whose denominator falls below 0.1 is not learnt from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecursiveInstrument<T, const N: usize> {
    theta: [T; N],
    covariance: [[T; N]; N],
}

impl<T: Real, const N: usize> RecursiveInstrument<T, N> {
    /// Goes on where least squares stands.
    ///
    /// ```
    /// use seatrial_core::{Forgetting, RecursiveInstrument, RecursiveLeastSquares};
    ///
    /// let mut least_squares = RecursiveLeastSquares::<f64, 2>::new(1e6);
    /// least_squares.update([1.0, 2.0], 5.0, Forgetting { factor: 1.0, trace_limit: 1e9 });
    /// let instrument = RecursiveInstrument::take_over(&least_squares);
    /// assert_eq!(instrument.theta(), least_squares.theta());
    /// ```
    pub fn take_over(least_squares: &RecursiveLeastSquares<T, N>) -> Self {
        Self { theta: least_squares.theta(), covariance: least_squares.covariance() }
    }

    /// Theta, in the order of the regressor: [beta, a22, b2, C0] in an [`Estimator`](crate::Estimator), [m, a, b, c] where
    /// it estimates a restoring moment.
    pub fn theta(&self) -> [T; N] {
        self.theta
    }

    /// P, not symmetric.
    pub fn covariance(&self) -> [[T; N]; N] {
        self.covariance
    }

    /// Forgets the first parameter, as if nothing but its variance were known of it.
    ///
    /// ```
    /// use seatrial_core::{RecursiveInstrument, RecursiveLeastSquares};
    ///
    /// let mut instrument = RecursiveInstrument::take_over(&RecursiveLeastSquares::<f64, 2>::new(100.0));
    /// instrument.reset_first(4.0);
    /// assert_eq!(instrument.covariance(), [[4.0, 0.0], [0.0, 100.0]]);
    /// ```
    pub fn reset_first(&mut self, variance: T) {
        for row in &mut self.covariance {
            row[0] = T::ZERO;
        }
        if let (Some(theta), Some(row)) = (self.theta.first_mut(), self.covariance.first_mut()) {
            *theta = T::ZERO;
            *row = [T::ZERO; N];
            row[0] = variance;
        }
    }

    /// Learns from one sample; returns whether it could.
    ///
    /// ```
    /// use seatrial_core::{RecursiveInstrument, RecursiveLeastSquares};
    ///
    /// // y = 2 p, with noise in the measured regressor and none in the instrument.
    /// let mut estimate = RecursiveInstrument::take_over(&RecursiveLeastSquares::<f64, 1>::new(100.0));
    /// for k in 0..400 {
    ///     let (p, noise) = ([1.0, -1.0][k % 2], [0.5, 0.5, -0.5, -0.5][k % 4]);
    ///     estimate.update([p + noise], [p], 2.0 * p);
    /// }
    /// // Least squares would give 2/(1 + 0.5^2) = 1.6.
    /// assert!((estimate.theta()[0] - 2.0).abs() < 0.02);
    /// ```
    pub fn update(&mut self, regressor: [T; N], instrument: [T; N], observation: T) -> bool {
        let Some(update) = self.judged(0, &regressor, &instrument, observation) else {
            return false;
        };
        self.learn(0, &update);
        true
    }

    /// [`update`](Self::update), bit for bit, while row and column of the first parameter are 0 ([`reset_first`](Self::reset_first) with
    /// variance 0), and so are the first regressor and the first instrument.
    #[inline]
    pub(crate) fn update_without_first(
        &mut self,
        regressor: &[T; N],
        instrument: &[T; N],
        observation: T,
    ) -> bool {
        let Some(update) = self.judged(1, regressor, instrument, observation) else {
            return false;
        };
        // Row and column of the first parameter lose products with 0, which are 0 while the other factor is finite.
        match update.is_finite() {
            true => self.learn(1, &update),
            false => self.learn(0, &update),
        }
        true
    }

    /// What the sample changes, of the parameters from `first` on. `None` where it cannot be learnt from.
    #[expect(clippy::needless_range_loop, reason = "iterators that skip take a quarter more time")]
    #[inline]
    fn judged(
        &self,
        first: usize,
        regressor: &[T; N],
        instrument: &[T; N],
        observation: T,
    ) -> Option<Update<T, N>> {
        let mut p_zeta = [T::ZERO; N];
        let mut phi_p = [T::ZERO; N];
        for i in first..N {
            p_zeta[i] = dot(first, &self.covariance[i], instrument);
            for j in first..N {
                phi_p[j] += regressor[i] * self.covariance[i][j];
            }
        }
        let denominator = T::ONE + dot(first, regressor, &p_zeta);
        let step = (observation - dot(first, regressor, &self.theta)) / denominator;
        let usable = denominator >= T::of(SMALLEST_DENOMINATOR) && denominator.is_finite();
        (usable && step.is_finite()).then(|| Update {
            step,
            p_zeta,
            gain: p_zeta.map(|p_zeta| p_zeta / denominator),
            phi_p,
        })
    }

    #[inline]
    fn learn(&mut self, first: usize, update: &Update<T, N>) {
        for i in first..N {
            self.theta[i] += update.p_zeta[i] * update.step;
            for j in first..N {
                self.covariance[i][j] -= update.gain[i] * update.phi_p[j];
            }
        }
    }
}

/// What a sample changes.
struct Update<T, const N: usize> {
    /// e over the denominator.
    step: T,
    /// P zeta
    p_zeta: [T; N],
    /// K
    gain: [T; N],
    /// Phi^T P
    phi_p: [T; N],
}

impl<T: Real, const N: usize> Update<T, N> {
    /// Are K and Phi^T P numbers? Where one is just below overflow the answer may be no.
    #[inline]
    fn is_finite(&self) -> bool {
        let mut largest = T::ZERO;
        for i in 0..N {
            largest += self.gain[i].abs() + self.phi_p[i].abs();
        }
        largest.is_finite()
    }
}

/// The scalar product of the elements from `first` on, to the sum of those before, which are products of 0.
#[inline]
fn dot<T: Real, const N: usize>(first: usize, a: &[T; N], b: &[T; N]) -> T {
    let mut sum = if first == 0 { -T::ZERO } else { T::ZERO };
    for i in first..N {
        sum += a[i] * b[i];
    }
    sum
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;

    /// Regressors and observations of all sizes, up to what overflows.
    fn without_first<T: Real>(largest: f64) {
        let mut least_squares = RecursiveLeastSquares::<T, 4>::new(T::of(1e6));
        least_squares.reset_first(T::ZERO);
        for factor in [1.0, 0.9] {
            let forgetting = crate::Forgetting { factor: T::of(factor), trace_limit: T::of(3e6) };
            let (mut all, mut rest) = (least_squares, least_squares);
            let mut instruments = None;
            for k in 0..4000 {
                let t = f64::from(k);
                let size = if k % 50 == 49 { largest } else { 1.0 };
                let phi = [0.0, size * libm::sin(t), libm::sin(0.37 * t), 1.0].map(T::of);
                let zeta = [0.0, libm::sin(t + 0.2), libm::sin(0.37 * t), 1.0].map(T::of);
                let y = T::of(libm::cos(1.3 * t) * size);
                let learnt = all.update(phi, y, forgetting);
                assert_eq!(learnt, rest.update_without_first(&phi, y, forgetting));
                assert_eq!(format(&all), format(&rest));
                if k == 100 {
                    let taken_over = RecursiveInstrument::take_over(&all);
                    instruments = Some((taken_over, taken_over));
                }
                if let Some((all, rest)) = &mut instruments {
                    let learnt = all.update(phi, zeta, y);
                    assert_eq!(learnt, rest.update_without_first(&phi, &zeta, y));
                    assert_eq!(format(all), format(rest));
                }
            }
        }
    }

    /// Every digit and the signs of zeros; what is no number equals itself.
    fn format(value: &impl core::fmt::Debug) -> std::string::String {
        std::format!("{value:?}")
    }

    #[test]
    fn exact_what_is_left_out_changes_no_bit() {
        for largest in [1.0, 1e-30, 1e18, 1e30, 1e150, 1e300] {
            without_first::<f64>(largest);
            without_first::<f32>(largest);
        }
    }
}
