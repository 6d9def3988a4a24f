//! The recursive instrumental variable.

use crate::model::{Discretisation, YawModel};
use crate::{Real, RecursiveLeastSquares};

/// Smallest denominator 1 + Phi^T P zeta with which a sample is still learnt from; least squares never goes below 1.
const SMALLEST_DENOMINATOR: f64 = 0.1;

/// Recursive instrumental variable for psi''_f = a22 psi'_f + b2 delta_f + C0.
///
/// ```text
/// z' = a22 z + b2 delta_f + C0           auxiliary model, a22, b2, C0 frozen
/// zeta = [z, delta_f, 1]^T               instrument
/// e = psi''_f - Phi^T Theta,  Phi = [psi'_f, delta_f, 1]^T
/// K = P zeta / (1 + Phi^T P zeta)
/// Theta <- Theta + K e
/// P <- P - K Phi^T P
/// ```
///
/// | symbol | identifier | unit |
/// |---|---|---|
/// | psi'_f, psi''_f | `yaw_rate_rad_s`, `yaw_acceleration_rad_s2` | rad/s, rad/s^2 |
/// | delta_f | `rudder_rad` | rad |
/// | z | noise-free yaw rate, filtered | rad/s |
/// | P | [`covariance`](Self::covariance) | - |
///
/// Compass noise is in psi'_f as well as in psi''_f, which biases least squares; z follows the rudder
/// alone and is free of it. Takes over Theta and P from least squares when the excitation is over.
/// P is **not symmetric** from then on, and no covariance of anything.
///
/// Valid for a stable auxiliary model (a22 < 0): [`start`](Self::start) gives `None` for another.
/// A sample whose denominator falls below 0.1 is not learnt from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecursiveInstrument<T> {
    theta: [T; 3],
    covariance: [[T; 3]; 3],
    auxiliary: YawModel<T>,
    step: Discretisation<T>,
    interval_s: T,
    instrument_rate_rad_s: T,
    last_rudder_rad: T,
}

impl<T: Real> RecursiveInstrument<T> {
    /// Takes over from least squares at a sample with this filtered yaw rate and rudder.
    pub fn start(
        least_squares: &RecursiveLeastSquares<T, 3>,
        yaw_rate_rad_s: T,
        rudder_rad: T,
    ) -> Option<Self> {
        let theta = least_squares.theta();
        let auxiliary = YawModel::from_theta(theta);
        let stable = auxiliary.a22_per_s < T::ZERO && theta.iter().all(|value| value.is_finite());
        stable.then(|| Self {
            theta,
            covariance: least_squares.covariance(),
            auxiliary,
            step: Discretisation::new(auxiliary.a22_per_s, T::ZERO),
            interval_s: T::ZERO,
            instrument_rate_rad_s: yaw_rate_rad_s,
            last_rudder_rad: rudder_rad,
        })
    }

    /// The parameter vector [a22, b2, C0].
    pub fn theta(&self) -> [T; 3] {
        self.theta
    }

    /// P, not symmetric.
    pub fn covariance(&self) -> [[T; 3]; 3] {
        self.covariance
    }

    /// Moves the auxiliary model on to the present filtered rudder.
    pub fn advance(&mut self, rudder_rad: T, interval_s: T) {
        if interval_s != self.interval_s {
            self.step = Discretisation::new(self.auxiliary.a22_per_s, interval_s);
            self.interval_s = interval_s;
        }
        let model = &self.auxiliary;
        let input = model.b2_per_s2 * self.last_rudder_rad + model.c0_rad_per_s2;
        self.instrument_rate_rad_s =
            self.step.decay * self.instrument_rate_rad_s + self.step.rate_gain_s * input;
        self.last_rudder_rad = rudder_rad;
    }

    /// Learns from the present sample; returns whether it could.
    pub fn update(&mut self, yaw_rate_rad_s: T, rudder_rad: T, yaw_acceleration_rad_s2: T) -> bool {
        let regressor = [yaw_rate_rad_s, rudder_rad, T::ONE];
        let instrument = [self.instrument_rate_rad_s, rudder_rad, T::ONE];
        let p_zeta = self.covariance.map(|row| dot(&row, &instrument));
        let mut phi_p = [T::ZERO; 3];
        for (phi, row) in regressor.iter().zip(&self.covariance) {
            for (sum, p) in phi_p.iter_mut().zip(row) {
                *sum += *phi * *p;
            }
        }
        let denominator = T::ONE + dot(&regressor, &p_zeta);
        let step = (yaw_acceleration_rad_s2 - dot(&regressor, &self.theta)) / denominator;
        let usable = denominator >= T::of(SMALLEST_DENOMINATOR) && denominator.is_finite();
        if !(usable && step.is_finite()) {
            return false;
        }
        for ((theta, row), p_zeta) in self.theta.iter_mut().zip(&mut self.covariance).zip(&p_zeta) {
            *theta += *p_zeta * step;
            let gain = *p_zeta / denominator;
            for (p, phi_p) in row.iter_mut().zip(&phi_p) {
                *p -= gain * *phi_p;
            }
        }
        true
    }
}

fn dot<T: Real>(a: &[T; 3], b: &[T; 3]) -> T {
    a.iter().zip(b).map(|(a, b)| *a * *b).sum()
}
