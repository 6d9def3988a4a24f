//! The sway-yaw model, one interval at a time, with its sensitivities.

use seatrial_core::Sample;
use serde::{Deserialize, Serialize};

/// Sway and yaw with cross-flow damping and a rudder that lags behind its command.
///
/// ```text
/// psi'   = r
/// r'     = (a22 + k |w|) r + a21 w + b2 delta_a + C0
/// w'     = a11 w - r
/// T_d delta_a' = delta - delta_a
/// ```
///
/// | symbol | identifier | unit | positive sense |
/// |---|---|---|---|
/// | psi, r | `heading_rad`, `yaw_rate_rad_s` | rad, rad/s | heading increasing |
/// | w | `drift_rad` | rad | sway speed v over -a12 of (1): the turning that sway remembers |
/// | delta, delta_a | | rad | rudder of the record, and as it acts |
/// | a22, b2, C0 | | 1/s, 1/s^2, rad/s^2 | as in [`seatrial_core::YawModel`] |
/// | a21 | `a21_per_s2` | 1/s^2 | -a12 a21 of (1): what sway does to yaw |
/// | a11 | `a11_per_s` | 1/s | decay of sway, not positive |
/// | k | `cross_flow_per_rad_s` | 1/(rad s) | damping per drift, not positive: a hull that drifts turns against its cross flow |
/// | T_d | `rudder_lag_s` | s | not negative |
///
/// Source: (1)-(2) of the paper. b1 does not appear: heading and rudder alone cannot distinguish it from a11, a12 and
/// a21. Without k this is the second-order Nomoto model in full, see [`SwayYawModel::nomoto`]. The term in k is the
/// moment of the cross-flow drag of a slender hull, integral of -x |v + x r| (v + x r) dx, where the sway
/// outweighs the swing: -|v| r L^3/6. With a21 = k = 0 it is the first-order model (5)-(7).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SwayYawModel {
    /// a22, rotational damping, 1/s.
    pub a22_per_s: f64,
    /// b2, rudder authority, 1/s^2.
    pub b2_per_s2: f64,
    /// C0, yaw acceleration at neutral rudder, rad/s^2.
    pub c0_rad_per_s2: f64,
    /// a21, effect of the drift on the yaw acceleration, 1/s^2.
    pub a21_per_s2: f64,
    /// a11, decay of the drift, 1/s.
    pub a11_per_s: f64,
    /// k, damping per drift, 1/(rad s).
    pub cross_flow_per_rad_s: f64,
    /// T_d, time constant of the rudder, s.
    pub rudder_lag_s: f64,
}

/// Heading, yaw rate and drift at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SwayYawState {
    /// Heading, rad, unwrapped.
    pub heading_rad: f64,
    /// Yaw rate, rad/s.
    pub yaw_rate_rad_s: f64,
    /// Drift w, rad.
    pub drift_rad: f64,
}

/// Second-order Nomoto model T1 T2 r'' + (T1 + T2) r' + r = K (delta + delta0 + T3 delta').
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SecondOrderNomoto {
    /// T1, the larger in size, s.
    pub t1_s: f64,
    /// T2, s.
    pub t2_s: f64,
    /// T3, s.
    pub t3_s: f64,
    /// K, steady yaw rate per rudder angle, 1/s.
    pub k_per_s: f64,
}

impl SwayYawModel {
    /// Nomoto form of the linear part, which holds for small rudder:
    ///
    /// ```text
    /// T1 T2 = 1/D,  T1 + T2 = -(a11 + a22)/D,  T3 = -1/a11,  K = -a11 b2/D,  D = a11 a22 + a21
    /// ```
    ///
    /// `None` where the time constants are complex or infinite.
    pub fn nomoto(&self) -> Option<SecondOrderNomoto> {
        let stiffness = self.a11_per_s * self.a22_per_s + self.a21_per_s2;
        let half_sum_s = -0.5 * (self.a11_per_s + self.a22_per_s) / stiffness;
        let half_difference_s = (half_sum_s * half_sum_s - 1.0 / stiffness).sqrt();
        let t1_s = half_sum_s + half_difference_s.copysign(half_sum_s);
        let nomoto = SecondOrderNomoto {
            t1_s,
            t2_s: 2.0 * half_sum_s - t1_s,
            t3_s: -1.0 / self.a11_per_s,
            k_per_s: -self.a11_per_s * self.b2_per_s2 / stiffness,
        };
        let is_finite = t1_s.is_finite() && nomoto.t3_s.is_finite();
        is_finite.then_some(nomoto)
    }

    /// The free-running simulation at each sample, from `start` and a rudder at rest. `samples` are finite and
    /// increase in time.
    pub fn simulate(&self, samples: &[Sample<f64>], start: SwayYawState) -> Vec<SwayYawState> {
        let mut rudder = Rudder::at_rest(samples);
        let mut state = start;
        let mut states = Vec::with_capacity(samples.len());
        states.extend((!samples.is_empty()).then_some(state));
        for pair in samples.windows(2) {
            let interval_s = pair[1].time_s - pair[0].time_s;
            let mean = rudder.advance(pair[0].rudder_rad, interval_s, self.rudder_lag_s);
            state = self.after(state, mean.angle_rad, interval_s);
            states.push(state);
        }
        states
    }

    /// The state after one interval with a constant rudder, by Runge and Kutta's fourth-order formula in steps of a third
    /// of the fastest time constant, 1e-5 of a step's change.
    pub(crate) fn after(
        &self,
        from: SwayYawState,
        rudder_rad: f64,
        interval_s: f64,
    ) -> SwayYawState {
        let steps = self.steps(&from, interval_s);
        let h = interval_s / steps;
        let input = self.b2_per_s2 * rudder_rad + self.c0_rad_per_s2;
        let mut x = [from.heading_rad, from.yaw_rate_rad_s, from.drift_rad];
        for _ in 0..steps as u32 {
            let x1 = self.rates(&x, input);
            let x2 = self.rates(&ahead(&x, 0.5 * h, &x1), input);
            let x3 = self.rates(&ahead(&x, 0.5 * h, &x2), input);
            let x4 = self.rates(&ahead(&x, h, &x3), input);
            move_on(&mut x, h, [&x1, &x2, &x3, &x4]);
        }
        SwayYawState {
            heading_rad: x[0],
            yaw_rate_rad_s: x[1],
            drift_rad: x[2],
        }
    }

    /// Runge and Kutta's steps of an interval: each of a third of the fastest time constant.
    fn steps(&self, from: &SwayYawState, interval_s: f64) -> f64 {
        const LARGEST_STEP: f64 = 0.35;
        const MOST_STEPS: f64 = 1000.0;
        let fastest_per_s = self.a22_per_s.abs()
            + self.a11_per_s.abs()
            + self.a21_per_s2.abs().sqrt()
            + (self.cross_flow_per_rad_s * from.drift_rad).abs();
        (interval_s * fastest_per_s / LARGEST_STEP)
            .ceil()
            .clamp(1.0, MOST_STEPS)
    }

    /// x' = f(x).
    #[inline(always)]
    fn rates(&self, x: &[f64; 3], input: f64) -> [f64; 3] {
        let [_, r, w] = *x;
        let damping = self.a22_per_s + self.cross_flow_per_rad_s * w.abs();
        [
            r,
            damping * r + self.a21_per_s2 * w + input,
            self.a11_per_s * w - r,
        ]
    }

    /// The state a small time later or, of a negative time, before.
    pub(crate) fn soon(&self, from: &SwayYawState, rudder_rad: f64, time_s: f64) -> SwayYawState {
        let input = self.b2_per_s2 * rudder_rad + self.c0_rad_per_s2;
        let now = [from.heading_rad, from.yaw_rate_rad_s, from.drift_rad];
        let slope = self.rates(&now, input);
        let slope = self.rates(&ahead(&now, 0.5 * time_s, &slope), input);
        let [heading_rad, yaw_rate_rad_s, drift_rad] = ahead(&now, time_s, &slope);
        SwayYawState {
            heading_rad,
            yaw_rate_rad_s,
            drift_rad,
        }
    }

    /// The state in the middle of an interval with a constant rudder, by Hermite's cubic through begin and end.
    pub(crate) fn middle(
        &self,
        rudder_rad: f64,
        interval_s: f64,
        ends: [&SwayYawState; 2],
    ) -> SwayYawState {
        let input = self.b2_per_s2 * rudder_rad + self.c0_rad_per_s2;
        let [begin, end] =
            ends.map(|state| [state.heading_rad, state.yaw_rate_rad_s, state.drift_rad]);
        let slopes = [self.rates(&begin, input), self.rates(&end, input)];
        let [heading_rad, yaw_rate_rad_s, drift_rad] = core::array::from_fn(|i| {
            0.5 * (begin[i] + end[i]) + 0.125 * interval_s * (slopes[0][i] - slopes[1][i])
        });
        SwayYawState {
            heading_rad,
            yaw_rate_rad_s,
            drift_rad,
        }
    }

    /// J of (r, w)' = J (r, w) + input without cross-flow damping, 1/s.
    pub(crate) fn linear_part(&self) -> [[f64; 2]; 2] {
        [[self.a22_per_s, self.a21_per_s2], [-1.0, self.a11_per_s]]
    }

    /// J of a small deviation from a state, 1/s, while the drift has this sign.
    pub(crate) fn jacobian(&self, state: &SwayYawState, side: f64) -> [[f64; 2]; 2] {
        let k = self.cross_flow_per_rad_s * side;
        [
            [
                self.a22_per_s + k * state.drift_rad,
                self.a21_per_s2 + k * state.yaw_rate_rad_s,
            ],
            [-1.0, self.a11_per_s],
        ]
    }
}

/// x + h x'.
#[inline(always)]
fn ahead<const N: usize>(x: &[f64; N], h: f64, slope: &[f64; N]) -> [f64; N] {
    let mut next = *x;
    for (next, slope) in next.iter_mut().zip(slope) {
        *next += h * slope;
    }
    next
}

/// Moves on by Runge and Kutta's mean of four slopes.
#[inline(always)]
fn move_on<const N: usize>(x: &mut [f64; N], h: f64, slopes: [&[f64; N]; 4]) {
    let [a, b, c, d] = slopes;
    for i in 0..N {
        x[i] += (a[i] + 2.0 * (b[i] + c[i]) + d[i]) * (h / 6.0);
    }
}

/// The rudder as it acts: delta_a' = (delta - delta_a)/T_d.
#[derive(Clone, Copy)]
pub(crate) struct Rudder {
    angle_rad: f64,
    /// d delta_a/d T_d, rad/s.
    to_lag: f64,
}

/// The mean of delta_a over an interval.
pub(crate) struct MeanRudder {
    pub(crate) angle_rad: f64,
    /// Its derivative to T_d, rad/s.
    pub(crate) to_lag: f64,
}

impl Rudder {
    /// At the first angle of a record.
    pub(crate) fn at_rest(samples: &[Sample<f64>]) -> Self {
        Self::at(samples.first().map_or(0.0, |sample| sample.rudder_rad))
    }

    pub(crate) fn at(angle_rad: f64) -> Self {
        Self {
            angle_rad,
            to_lag: 0.0,
        }
    }

    /// The mean over an interval with the rudder deflected to `command_rad`.
    pub(crate) fn advance(&mut self, command_rad: f64, h: f64, lag_s: f64) -> MeanRudder {
        self.advance_by(command_rad, &LagStep::over(h, lag_s))
    }

    /// [`Rudder::advance`] over an interval that was made ready.
    pub(crate) fn advance_by(&mut self, command_rad: f64, step: &LagStep) -> MeanRudder {
        let behind = self.angle_rad - command_rad;
        let mean = MeanRudder {
            angle_rad: command_rad + behind * step.g,
            to_lag: behind * step.g_to_lag + self.to_lag * step.g,
        };
        self.to_lag = behind * step.e_to_lag + self.to_lag * step.e;
        self.angle_rad = command_rad + behind * step.e;
        mean
    }
}

/// What an interval of h does to a rudder with the lag T: of its distance from the command e = exp(-h/T) is left, and its
/// mean is g = (T/h)(1 - e).
pub(crate) struct LagStep {
    /// h, s.
    pub(crate) interval_s: f64,
    e: f64,
    e_to_lag: f64,
    g: f64,
    g_to_lag: f64,
}

impl LagStep {
    pub(crate) fn over(h: f64, lag_s: f64) -> Self {
        let e = libm::exp(-h / lag_s.max(f64::MIN_POSITIVE));
        let e_to_lag = if e > 0.0 {
            e * h / (lag_s * lag_s)
        } else {
            0.0
        };
        Self {
            interval_s: h,
            e,
            e_to_lag,
            g: lag_s / h * (1.0 - e),
            g_to_lag: (1.0 - e) / h - lag_s * e_to_lag / h,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use seatrial_core::YawModel;
    use seatrial_core::model::YawState;

    fn model() -> SwayYawModel {
        SwayYawModel {
            a22_per_s: -0.9,
            b2_per_s2: 1.1,
            c0_rad_per_s2: 0.01,
            a21_per_s2: 0.2,
            a11_per_s: -0.6,
            cross_flow_per_rad_s: -8.0,
            rudder_lag_s: 0.1,
        }
    }

    #[test]
    fn exact_without_sway_it_is_the_first_order_model() {
        let first = YawModel::from_theta([-1.07, 1.08, 0.012]);
        let model = SwayYawModel {
            a22_per_s: -1.07,
            b2_per_s2: 1.08,
            c0_rad_per_s2: 0.012,
            a11_per_s: -0.5,
            ..SwayYawModel::default()
        };
        for interval_s in [0.05, 3.0] {
            let after = model.after(SwayYawState::default(), 0.26, interval_s);
            let exact = first.advance(YawState::default(), 0.26, interval_s);
            // The integration's own tolerance.
            let error = after.yaw_rate_rad_s - exact.yaw_rate_rad_s;
            assert!(error.abs() < 1e-5 * exact.yaw_rate_rad_s, "{error}");
            let error = after.heading_rad - exact.heading_rad;
            assert!(error.abs() < 1e-5 * exact.heading_rad, "{error}");
        }
    }

    /// The characteristic polynomial and the numerator of the Nomoto form are those of the linear part.
    #[test]
    fn exact_nomoto_form_has_the_same_response() {
        let linear = SwayYawModel {
            cross_flow_per_rad_s: 0.0,
            c0_rad_per_s2: 0.0,
            a21_per_s2: -0.1,
            rudder_lag_s: 0.0,
            ..model()
        };
        let nomoto = linear.nomoto().unwrap();
        let start = SwayYawState::default();
        let settled = linear.after(start, 0.1, 60.0);
        // e^-21 of the transient is left, and the integration's tolerance.
        assert!((settled.yaw_rate_rad_s - 0.1 * nomoto.k_per_s).abs() < 1e-7);
        // At once after a step of the rudder r' = K T3/(T1 T2) delta.
        let instant_s = 1e-6;
        let soon = linear.after(start, 0.1, instant_s);
        let expected = 0.1 * nomoto.k_per_s * nomoto.t3_s / (nomoto.t1_s * nomoto.t2_s);
        assert!((soon.yaw_rate_rad_s / instant_s - expected).abs() < 1e-5 * expected);
        let poles = [-1.0 / nomoto.t1_s, -1.0 / nomoto.t2_s];
        assert!((poles[0] + poles[1] - (linear.a11_per_s + linear.a22_per_s)).abs() < 1e-12);
    }

    /// Central differences of the rudder itself.
    #[test]
    fn exact_derivative_to_the_lag_is_that_of_the_rudder() {
        let spread = 1e-5;
        let mut rudder = Rudder::at(0.0);
        let mut above = Rudder::at(0.0);
        let mut below = Rudder::at(0.0);
        for command in [0.2, 0.2, -0.1] {
            let mean = rudder.advance(command, 0.05, 0.1);
            let expected = (above.advance(command, 0.05, 0.1 + spread).angle_rad
                - below.advance(command, 0.05, 0.1 - spread).angle_rad)
                / (2.0 * spread);
            // Second differences leave 1e-10/T^2.
            assert!((mean.to_lag - expected).abs() < 1e-6, "{expected}");
        }
    }
}
