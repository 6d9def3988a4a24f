//! The yaw model, its exact discretisation and its Nomoto form.

use crate::Real;

/// Continuous-time first-order yaw model with offset.
///
/// ```text
/// psi' = r                                  (5)
/// r'   = a22 r + b2 delta + C0,  C0 = b2 delta0      (6), (7)
/// ```
///
/// | symbol | identifier | unit | positive sense |
/// |---|---|---|---|
/// | psi | `heading_rad` | rad | as the compass counts |
/// | r | `yaw_rate_rad_s` | rad/s | heading increasing |
/// | delta | `rudder_rad` | rad | turns towards increasing heading where `b2` is positive |
/// | a22 | `a22_per_s` | 1/s | negative for a course-stable vehicle |
/// | b2 | `b2_per_s2` | 1/s^2 | rudder authority |
/// | C0 | `c0_rad_per_s2` | rad/s^2 | yaw acceleration at neutral rudder |
/// | delta0 | [`delta0_rad`](YawModel::delta0_rad) | rad | the rudder that holds a constant heading is **-delta0** |
///
/// Source: equations (5)-(10) of the paper; (9) prints the sign of delta0 the other way, (6) holds here.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct YawModel<T> {
    /// a22, rotational damping, 1/s.
    pub a22_per_s: T,
    /// b2, rudder authority, 1/s^2.
    pub b2_per_s2: T,
    /// C0 = b2 delta0, yaw acceleration at neutral rudder, rad/s^2.
    pub c0_rad_per_s2: T,
}

/// First-order Nomoto model T r' + r = K (delta + delta0).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Nomoto<T> {
    /// T = -1/a22, time constant, s; negative for a course-unstable vehicle.
    pub t_s: T,
    /// K = -b2/a22, steady yaw rate per rudder angle, 1/s.
    pub k_per_s: T,
}

/// Heading and yaw rate at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct YawState<T> {
    /// Heading, rad, unwrapped.
    pub heading_rad: T,
    /// Yaw rate, rad/s.
    pub yaw_rate_rad_s: T,
}

impl<T: Real> YawModel<T> {
    /// The model of a parameter vector Theta = [a22, b2, C0] (8).
    ///
    /// ```
    /// use seatrial_core::YawModel;
    ///
    /// // The paper's vehicle at 80 % thrust: a22 in 1/s, b2 in 1/s^2, C0 in rad/s^2.
    /// let model = YawModel::from_theta([-1.07, 1.08, 0.012]);
    /// assert_eq!((model.a22_per_s, model.theta()[1]), (-1.07, 1.08));
    /// ```
    pub fn from_theta([a22_per_s, b2_per_s2, c0_rad_per_s2]: [T; 3]) -> Self {
        Self { a22_per_s, b2_per_s2, c0_rad_per_s2 }
    }

    /// The parameter vector Theta = [a22, b2, C0] (8).
    pub fn theta(&self) -> [T; 3] {
        [self.a22_per_s, self.b2_per_s2, self.c0_rad_per_s2]
    }

    /// delta0 = C0/b2, rad. `None` without rudder authority.
    ///
    /// ```
    /// use seatrial_core::YawModel;
    ///
    /// // The rudder that holds a constant heading is -delta0.
    /// let model = YawModel::from_theta([-1.0, 2.0, 0.04]);
    /// assert_eq!(model.delta0_rad(), Some(0.02));
    /// assert_eq!(model.yaw_acceleration(0.0, -0.02), 0.0);
    /// ```
    pub fn delta0_rad(&self) -> Option<T> {
        let delta0 = self.c0_rad_per_s2 / self.b2_per_s2;
        delta0.is_finite().then_some(delta0)
    }

    /// Nomoto T and K. `None` where a22 is 0: the vehicle then integrates its rudder.
    ///
    /// ```
    /// use seatrial_core::{Nomoto, YawModel};
    ///
    /// let model = YawModel::from_theta([-0.5, 1.0, 0.0]);
    /// assert_eq!(model.nomoto(), Some(Nomoto { t_s: 2.0, k_per_s: 2.0 }));
    /// assert_eq!(YawModel::from_theta([0.0, 1.0, 0.0]).nomoto(), None);
    /// ```
    pub fn nomoto(&self) -> Option<Nomoto<T>> {
        let nomoto =
            Nomoto { t_s: -T::ONE / self.a22_per_s, k_per_s: -self.b2_per_s2 / self.a22_per_s };
        (nomoto.t_s.is_finite() && nomoto.k_per_s.is_finite()).then_some(nomoto)
    }

    /// r' = a22 r + b2 delta + C0 (7), rad/s^2.
    ///
    /// ```
    /// use seatrial_core::YawModel;
    ///
    /// // -1 * 0.2 + 2 * 0.1 + 0.05
    /// let model = YawModel::from_theta([-1.0, 2.0, 0.05]);
    /// assert!((model.yaw_acceleration(0.2, 0.1) - 0.05_f64).abs() < 1e-12);
    /// ```
    pub fn yaw_acceleration(&self, yaw_rate_rad_s: T, rudder_rad: T) -> T {
        self.a22_per_s * yaw_rate_rad_s + self.b2_per_s2 * rudder_rad + self.c0_rad_per_s2
    }

    /// The state `interval_s` later with the rudder held constant: the exact solution of (5)-(6).
    ///
    /// ```
    /// use seatrial_core::YawModel;
    /// use seatrial_core::model::YawState;
    ///
    /// let model = YawModel::from_theta([-1.0, 1.0, 0.0]);
    /// let state = model.advance(YawState::default(), 0.2, 1.0);
    /// // One time constant: 63 % of the steady yaw rate of 0.2 rad/s.
    /// assert!((state.yaw_rate_rad_s - 0.2 * (1.0 - (-1.0_f64).exp())).abs() < 1e-12);
    /// // One long step is as exact as many short ones.
    /// let many = (0..100).fold(YawState::default(), |state, _| model.advance(state, 0.2, 0.01));
    /// assert!((many.heading_rad - state.heading_rad).abs() < 1e-12);
    /// ```
    pub fn advance(&self, state: YawState<T>, rudder_rad: T, interval_s: T) -> YawState<T> {
        let step = Discretisation::new(self.a22_per_s, interval_s);
        step.advance(state, self.b2_per_s2 * rudder_rad + self.c0_rad_per_s2)
    }
}

/// Exact zero-order-hold discretisation of psi' = r, r' = a r + u over one interval.
///
/// ```text
/// r+   = e^{ah} r + h phi1(ah) u          phi1(x) = (e^x - 1)/x
/// psi+ = psi + h phi1(ah) r + h^2 phi2(ah) u      phi2(x) = (e^x - 1 - x)/x^2
/// ```
///
/// Valid for every a, also at and above 0; phi1 and phi2 are series near 0, where the closed
/// forms cancel. The eigenvalue relation r+ = r + h phi1 (a r + u) keeps the accuracy for small a h.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Discretisation<T> {
    /// e^{ah}
    pub decay: T,
    /// h phi1(ah), s
    pub rate_gain_s: T,
    /// h^2 phi2(ah), s^2
    pub heading_gain_s2: T,
}

impl<T: Real> Discretisation<T> {
    /// For damping `a22_per_s` and an interval of `interval_s`.
    ///
    /// ```
    /// use seatrial_core::model::{Discretisation, YawState};
    ///
    /// // Without damping: r' = u, h and h^2/2.
    /// let step = Discretisation::new(0.0, 0.5);
    /// assert_eq!((step.decay, step.rate_gain_s, step.heading_gain_s2), (1.0, 0.5, 0.125));
    /// let state = step.advance(YawState { heading_rad: 1.0, yaw_rate_rad_s: 0.2 }, 0.0);
    /// assert_eq!((state.heading_rad, state.yaw_rate_rad_s), (1.1, 0.2));
    /// ```
    pub fn new(a22_per_s: T, interval_s: T) -> Self {
        let x = a22_per_s * interval_s;
        let (phi1, phi2) = phi(x);
        Self {
            decay: x.exp(),
            rate_gain_s: interval_s * phi1,
            heading_gain_s2: interval_s * interval_s * phi2,
        }
    }

    /// One interval with constant yaw acceleration input u = b2 delta + C0, rad/s^2.
    pub fn advance(&self, state: YawState<T>, u: T) -> YawState<T> {
        YawState {
            heading_rad: state.heading_rad
                + self.rate_gain_s * state.yaw_rate_rad_s
                + self.heading_gain_s2 * u,
            yaw_rate_rad_s: self.decay * state.yaw_rate_rad_s + self.rate_gain_s * u,
        }
    }
}

/// phi1(x) = (e^x - 1)/x and phi2(x) = (e^x - 1 - x)/x^2.
///
/// ```
/// use seatrial_core::model::phi;
///
/// // The limits at 0, where the closed forms divide by it.
/// assert_eq!(phi(0.0), (1.0, 0.5));
/// assert!((phi(1.0_f64).0 - (core::f64::consts::E - 1.0)).abs() < 1e-15);
/// ```
pub fn phi<T: Real>(x: T) -> (T, T) {
    if x.abs() < T::of(PHI_SERIES_BELOW) {
        enclosed_phi_series(x).unwrap_or_else(|| phi_series_alone(x))
    } else {
        let phi1 = x.exp_m1() / x;
        (phi1, (phi1 - T::ONE) / x)
    }
}

/// Below this |x| [`phi`] is its series.
pub(crate) const PHI_SERIES_BELOW: f64 = 0.5;

/// [`phi`] for |x| below [`PHI_SERIES_BELOW`], where the Taylor series of phi2 to x^13 is exact to rounding in f64 (next term
/// under 1e-17), and phi1 = 1 + x phi2.
#[inline]
pub(crate) fn phi_series<T: Real>(x: T) -> (T, T) {
    let mut phi2 = T::ZERO;
    let mut k = 15.0;
    while k >= 2.0 {
        phi2 = (T::ONE + x * phi2) / T::of(k);
        k -= 1.0;
    }
    (T::ONE + x * phi2, phi2)
}

#[cold]
fn phi_series_alone<T: Real>(x: T) -> (T, T) {
    phi_series(x)
}

/// The bits of [`phi_series`] with one division instead of 14. `None`, rarely, where they are not certain.
///
/// ```text
/// p <- (1 + x p)/k,  k = 15 ... 2                                  the series
/// p5(x) = sum_{j=0..10} 4!/(5 + j)! x^j = E(x^2) + x O(x^2)         p after k = 5, without roundings
/// ```
///
/// A step of the series is monotonic in p, its roundings included. Two numbers with the series' p5 between them therefore
/// have its p between them after every further step; where both arrive at one number, that is the series'.
///
/// With u = `EPSILON`/2 and |x| < 0.5, roundings move the series' p5 by less than 3 u p5 and E + x O by less than 5 u p5. The two numbers lie 16 u p5 to
/// either side.
#[inline]
fn enclosed_phi_series<T: Real>(x: T) -> Option<(T, T)> {
    let c = |numerator: f64, denominator: f64| T::of(numerator / denominator);
    let x2 = x * x;
    let x4 = x2 * x2;
    let even = (c(1.0, 5.0) + x2 * c(1.0, 210.0))
        + x4 * ((c(1.0, 15_120.0) + x2 * c(1.0, 1_663_200.0))
            + x4 * (c(1.0, 259_459_200.0) + x2 * c(1.0, 54_486_432_000.0)));
    let odd = (c(1.0, 30.0) + x2 * c(1.0, 1680.0))
        + x4 * ((c(1.0, 151_200.0) + x2 * c(1.0, 19_958_400.0)) + x4 * c(1.0, 3_632_428_800.0));
    let p = even + x * odd;
    let margin = T::of(8.0) * T::EPSILON;
    let (half, quarter) = (T::of(0.5), T::of(0.25));
    let (x_half, x_quarter) = (half * x, quarter * x);
    let [phi2, other] = [p * (T::ONE - margin), p * (T::ONE + margin)].map(|p| {
        let p = (T::ONE + x * (quarter + x_quarter * p)) / T::of(3.0);
        half + x_half * p
    });
    (phi2 == other).then_some((T::ONE + x * phi2, phi2))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// phi of x in (-0.5, 0.5), of every size, against its series; how often that had to be evaluated.
    fn share_of_series<T: Real>(largest: f64) -> f64 {
        const COUNT: u32 = 400_000;
        let mut series = 0;
        for k in 0..COUNT {
            // Evenly spread, and with every exponent down to 2^-40.
            let even = f64::from(k) * 0.618_033_988_749_895 % 2.0 - 1.0;
            let x = T::of(
                largest * even * if k % 8 == 0 { libm::exp2(-f64::from(k / 8 % 40)) } else { 1.0 },
            );
            if x.abs() >= T::of(PHI_SERIES_BELOW) {
                continue;
            }
            assert_eq!(phi(x), phi_series(x), "{x}");
            series += u32::from(enclosed_phi_series(x).is_none());
        }
        f64::from(series) / f64::from(COUNT)
    }

    #[test]
    fn exact_phi_has_the_bits_of_its_series() {
        for largest in [0.5, 0.2, 0.1] {
            let (double, single) =
                (share_of_series::<f64>(largest), share_of_series::<f32>(largest));
            // Seldom where intervals are short beside the time constant, else the division is not saved.
            let most = if largest > 0.1 { 0.2 } else { 0.002 };
            assert!(double < most && single < most, "{largest}: {double}, {single}");
        }
    }

    #[test]
    fn exact_phi_matches_closed_form_and_limits() {
        assert_eq!(phi(0.0), (1.0, 0.5));
        for x in [-3.0_f64, -0.6, -0.4999, 0.4999, 0.6, 2.0] {
            let (phi1, phi2) = phi(x);
            // Closed forms lose at most a few bits at |x| > 0.4.
            assert!((phi1 - x.exp_m1() / x).abs() < 1e-14, "phi1({x})");
            assert!((phi2 - (x.exp_m1() - x) / (x * x)).abs() < 1e-14, "phi2({x})");
        }
    }

    /// Two half steps equal one full step: the semigroup property of the exact solution.
    #[test]
    fn exact_two_half_steps_equal_one_step() {
        for a in [-5.0, -1.07, -1e-3, -1e-9, 0.0, 1e-9, 0.02, 0.8] {
            let model = YawModel::from_theta([a, 1.08, 0.012]);
            let start = YawState { heading_rad: 0.3, yaw_rate_rad_s: -0.2 };
            let whole = model.advance(start, 0.26, 0.4);
            let half = model.advance(model.advance(start, 0.26, 0.2), 0.26, 0.2);
            // Rounding of a handful of operations on numbers of order 1.
            assert!((whole.heading_rad - half.heading_rad).abs() < 1e-15);
            assert!((whole.yaw_rate_rad_s - half.yaw_rate_rad_s).abs() < 1e-15);
        }
    }

    #[test]
    fn exact_step_response_is_equation_46() {
        let (a22, b2, delta) = (-1.07_f64, 1.08, 0.26);
        let model = YawModel::from_theta([a22, b2, 0.0]);
        let mut state = YawState::default();
        for k in 1..=200 {
            state = model.advance(state, delta, 0.05);
            let t = f64::from(k) * 0.05;
            let expected = b2 * delta / -a22 * (1.0 - (a22 * t).exp());
            // 200 accumulated roundings.
            assert!((state.yaw_rate_rad_s - expected).abs() < 1e-14);
        }
    }

    #[test]
    fn exact_nomoto_and_offset() {
        let model = YawModel::from_theta([-1.07_f64, 1.08, 0.012]);
        let nomoto = model.nomoto().unwrap();
        assert!((nomoto.t_s - 1.0 / 1.07).abs() < 1e-15);
        assert!((nomoto.k_per_s - 1.08 / 1.07).abs() < 1e-15);
        assert!((model.delta0_rad().unwrap() - 0.012 / 1.08).abs() < 1e-15);
        assert_eq!(YawModel::from_theta([0.0, 1.0, 0.0]).nomoto(), None);
        assert_eq!(YawModel::from_theta([-1.0, 0.0, 0.0]).delta0_rad(), None);
    }

    #[test]
    fn exact_wrapped_angles() {
        use core::f64::consts::PI;
        for (angle, wrapped) in [(0.0, 0.0), (PI, PI), (-PI, PI), (7.0, 7.0 - 2.0 * PI)] {
            assert!((Real::wrapped(angle) - wrapped).abs() < 1e-15);
        }
    }
}
