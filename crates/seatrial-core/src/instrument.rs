//! The recursive instrumental variable.

use crate::model::{Discretisation, YawModel};
use crate::{PitchModel, PitchState, Real, RecursiveLeastSquares};

/// Smallest denominator 1 + Phi^T P zeta with which a sample is still learnt from; least squares never goes below 1.
const SMALLEST_DENOMINATOR: f64 = 0.1;

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
        Self {
            yaw_rate_rad_s,
            rudder_rad,
            heading_rad,
        }
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
    pub fn advance(&mut self, model: &YawModel<T>, rudder_rad: T, interval_s: T, lambda_rad_s: T) {
        let slowest = T::of(-0.05) * (lambda_rad_s / T::of(0.5)).min(T::ONE);
        let fastest = T::of(-10.0) * (lambda_rad_s / T::of(4.0)).max(T::ONE);
        let step = Discretisation::new(model.a22_per_s.min(slowest).max(fastest), interval_s);
        let mean_rudder_rad = T::of(0.5) * (self.rudder_rad + rudder_rad);
        let input = model.b2_per_s2 * mean_rudder_rad + model.c0_rad_per_s2;
        self.yaw_rate_rad_s = step.decay * self.yaw_rate_rad_s + step.rate_gain_s * input;
        self.rudder_rad = rudder_rad;
    }

    /// Moves pitch on by an interval with the filtered elevator at its end.
    pub fn advance_righted(&mut self, model: &PitchModel<T>, elevator_rad: T, interval_s: T) {
        let state = PitchState {
            pitch_rad: self.heading_rad,
            pitch_rate_rad_s: self.yaw_rate_rad_s,
        };
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
    pub fn take_over(least_squares: &RecursiveLeastSquares<T, N>) -> Self {
        Self {
            theta: least_squares.theta(),
            covariance: least_squares.covariance(),
        }
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
    pub fn update(&mut self, regressor: [T; N], instrument: [T; N], observation: T) -> bool {
        let p_zeta = self.covariance.map(|row| dot(&row, &instrument));
        let mut phi_p = [T::ZERO; N];
        for (phi, row) in regressor.iter().zip(&self.covariance) {
            for (sum, p) in phi_p.iter_mut().zip(row) {
                *sum += *phi * *p;
            }
        }
        let denominator = T::ONE + dot(&regressor, &p_zeta);
        let step = (observation - dot(&regressor, &self.theta)) / denominator;
        let usable = denominator >= T::of(SMALLEST_DENOMINATOR) && denominator.is_finite();
        if !(usable && step.is_finite()) {
            return false;
        }
        let rows = self.theta.iter_mut().zip(&mut self.covariance);
        for ((theta, row), p_zeta) in rows.zip(&p_zeta) {
            *theta += *p_zeta * step;
            let gain = *p_zeta / denominator;
            for (p, phi_p) in row.iter_mut().zip(&phi_p) {
                *p -= gain * *phi_p;
            }
        }
        true
    }
}

fn dot<T: Real, const N: usize>(a: &[T; N], b: &[T; N]) -> T {
    a.iter().zip(b).map(|(a, b)| *a * *b).sum()
}
