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
            state = self.step(state, mean.angle_rad, interval_s).state;
            states.push(state);
        }
        states
    }

    /// One interval with a constant rudder, by Runge and Kutta's fourth-order formula in steps of a third
    /// of the fastest time constant, 1e-5 of a step's change.
    pub(crate) fn step(&self, from: SwayYawState, rudder_rad: f64, interval_s: f64) -> Step {
        const LARGEST_STEP: f64 = 0.35;
        const MOST_STEPS: f64 = 1000.0;
        let fastest_per_s = self.a22_per_s.abs()
            + self.a11_per_s.abs()
            + self.a21_per_s2.abs().sqrt()
            + (self.cross_flow_per_rad_s * from.drift_rad).abs();
        let steps = (interval_s * fastest_per_s / LARGEST_STEP)
            .ceil()
            .clamp(1.0, MOST_STEPS);
        let h = interval_s / steps;
        let input = self.b2_per_s2 * rudder_rad + self.c0_rad_per_s2;
        let mut x = [from.heading_rad, from.yaw_rate_rad_s, from.drift_rad];
        let mut m = UNCHANGED;
        for _ in 0..steps as u32 {
            let (x1, m1) = self.derivative(&x, &m, input);
            let (x2, m2) = self.derivative(
                &ahead(&x, 0.5 * h, &x1),
                &tangent_ahead(&m, 0.5 * h, &m1),
                input,
            );
            let (x3, m3) = self.derivative(
                &ahead(&x, 0.5 * h, &x2),
                &tangent_ahead(&m, 0.5 * h, &m2),
                input,
            );
            let (x4, m4) = self.derivative(&ahead(&x, h, &x3), &tangent_ahead(&m, h, &m3), input);
            move_on(&mut x, h, [&x1, &x2, &x3, &x4]);
            for (i, row) in m.iter_mut().enumerate() {
                move_on(row, h, [&m1[i], &m2[i], &m3[i], &m4[i]]);
            }
        }
        Step {
            state: SwayYawState {
                heading_rad: x[0],
                yaw_rate_rad_s: x[1],
                drift_rad: x[2],
            },
            tangent: m,
        }
    }

    /// x' = f(x) and M' = df/dx M + df/d(parameters).
    #[inline(always)]
    fn derivative(&self, x: &[f64; 3], m: &Tangent, input: f64) -> ([f64; 3], Tangent) {
        let [_, r, w] = *x;
        let damping = self.a22_per_s + self.cross_flow_per_rad_s * w.abs();
        let coupling = self.a21_per_s2 + self.cross_flow_per_rad_s * r * w.signum();
        let rate = [
            r,
            damping * r + self.a21_per_s2 * w + input,
            self.a11_per_s * w - r,
        ];
        let [_, to_r, to_w] = m;
        let mut tangent = [*to_r, [0.0; 8], [0.0; 8]];
        for i in 0..8 {
            tangent[1][i] = damping * to_r[i] + coupling * to_w[i];
            tangent[2][i] = self.a11_per_s * to_w[i] - to_r[i];
        }
        tangent[1][TO_INPUT] += 1.0;
        tangent[1][TO_A22] += r;
        tangent[1][TO_A21] += w;
        tangent[2][TO_A11] += w;
        tangent[1][TO_CROSS_FLOW] += w.abs() * r;
        (rate, tangent)
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

#[inline(always)]
fn tangent_ahead(m: &Tangent, h: f64, slope: &Tangent) -> Tangent {
    let [psi, r, w] = m;
    [
        ahead(psi, h, &slope[0]),
        ahead(r, h, &slope[1]),
        ahead(w, h, &slope[2]),
    ]
}

/// Moves on by Runge and Kutta's mean of four slopes.
#[inline(always)]
fn move_on<const N: usize>(x: &mut [f64; N], h: f64, slopes: [&[f64; N]; 4]) {
    let [a, b, c, d] = slopes;
    for i in 0..N {
        x[i] += (a[i] + 2.0 * (b[i] + c[i]) + d[i]) * (h / 6.0);
    }
}

/// Derivatives of heading, yaw rate and drift after an interval, a row each: to the state before (three columns), the yaw
/// acceleration b2 delta + C0, a22, a21, a11 and k.
type Tangent = [[f64; 8]; 3];
const TO_INPUT: usize = 3;
const TO_A22: usize = 4;
const TO_A21: usize = 5;
const TO_A11: usize = 6;
const TO_CROSS_FLOW: usize = 7;

/// The tangent of no time.
const UNCHANGED: Tangent = {
    let mut unchanged = [[0.0; 8]; 3];
    unchanged[0][0] = 1.0;
    unchanged[1][1] = 1.0;
    unchanged[2][2] = 1.0;
    unchanged
};

/// The state after an interval, and what it depends on.
#[derive(Clone, Copy)]
pub(crate) struct Step {
    pub(crate) state: SwayYawState,
    tangent: Tangent,
}

impl Step {
    /// Derivative of the state after the interval to the state before.
    pub(crate) fn to_state(self) -> [[f64; 3]; 3] {
        let [psi, r, w] = &self.tangent;
        [
            [psi[0], psi[1], psi[2]],
            [r[0], r[1], r[2]],
            [w[0], w[1], w[2]],
        ]
    }

    /// To a yaw acceleration that is constant over the interval.
    pub(crate) fn to_input(self) -> [f64; 3] {
        self.to(TO_INPUT)
    }

    /// To a22, a21, a11 and k.
    pub(crate) fn to_dynamics(self) -> [[f64; 3]; 4] {
        [
            self.to(TO_A22),
            self.to(TO_A21),
            self.to(TO_A11),
            self.to(TO_CROSS_FLOW),
        ]
    }

    fn to(self, column: usize) -> [f64; 3] {
        let [psi, r, w] = &self.tangent;
        [psi[column], r[column], w[column]]
    }
}

/// Steps of a model, quickly: one without cross-flow damping is linear, so that the steps from a yaw rate, a drift and a yaw
/// acceleration of one give all others of the same interval. Derivatives to k are then left at 0.
pub(crate) struct Steps {
    model: SwayYawModel,
    is_linear: bool,
    interval_s: f64,
    of_one: [Step; 3],
}

impl Steps {
    /// `is_linear`: k is 0 and its derivatives are not asked for.
    pub(crate) fn new(model: SwayYawModel, is_linear: bool) -> Self {
        let none = Step {
            state: SwayYawState::default(),
            tangent: UNCHANGED,
        };
        Self {
            model,
            is_linear,
            interval_s: f64::NAN,
            of_one: [none; 3],
        }
    }

    /// [`SwayYawModel::step`].
    pub(crate) fn step(&mut self, from: SwayYawState, rudder_rad: f64, interval_s: f64) -> Step {
        if !self.is_linear {
            return self.model.step(from, rudder_rad, interval_s);
        }
        // Intervals of an even clock differ by its rounding.
        if (interval_s - self.interval_s).abs() > 1e-9 * interval_s || self.interval_s.is_nan() {
            self.interval_s = interval_s;
            self.of_one = self.model.steps_of_one(interval_s);
        }
        let input = self.model.b2_per_s2 * rudder_rad + self.model.c0_rad_per_s2;
        let [of_rate, of_drift, of_input] = &self.of_one;
        let (r, w) = (from.yaw_rate_rad_s, from.drift_rad);
        let mut tangent = of_input.tangent;
        for (i, row) in tangent.iter_mut().enumerate() {
            for column in [TO_A22, TO_A21, TO_A11] {
                row[column] = r * of_rate.tangent[i][column]
                    + w * of_drift.tangent[i][column]
                    + input * of_input.tangent[i][column];
            }
        }
        let after = tangent.map(|row| row[1] * r + row[2] * w + row[TO_INPUT] * input);
        Step {
            state: SwayYawState {
                heading_rad: from.heading_rad + after[0],
                yaw_rate_rad_s: after[1],
                drift_rad: after[2],
            },
            tangent,
        }
    }
}

impl SwayYawModel {
    /// The steps of the linear part from a yaw rate, a drift, and a yaw acceleration of one.
    fn steps_of_one(&self, interval_s: f64) -> [Step; 3] {
        let linear = Self {
            b2_per_s2: 1.0,
            c0_rad_per_s2: 0.0,
            cross_flow_per_rad_s: 0.0,
            ..*self
        };
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(
            |[yaw_rate_rad_s, drift_rad, input]| {
                let from = SwayYawState {
                    heading_rad: 0.0,
                    yaw_rate_rad_s,
                    drift_rad,
                };
                linear.step(from, input, interval_s)
            },
        )
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

    /// The mean over an interval with the rudder deflected to `command_rad`:
    /// delta + (delta_a - delta) g, g = (T/h)(1 - e), e = exp(-h/T).
    pub(crate) fn advance(&mut self, command_rad: f64, h: f64, lag_s: f64) -> MeanRudder {
        let e = (-h / lag_s.max(f64::MIN_POSITIVE)).exp();
        let e_to_lag = if e > 0.0 {
            e * h / (lag_s * lag_s)
        } else {
            0.0
        };
        let g = lag_s / h * (1.0 - e);
        let g_to_lag = (1.0 - e) / h - lag_s * e_to_lag / h;
        let behind = self.angle_rad - command_rad;
        let mean = MeanRudder {
            angle_rad: command_rad + behind * g,
            to_lag: behind * g_to_lag + self.to_lag * g,
        };
        self.to_lag = behind * e_to_lag + self.to_lag * e;
        self.angle_rad = command_rad + behind * e;
        mean
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
            let step = model.step(SwayYawState::default(), 0.26, interval_s);
            let exact = first.advance(YawState::default(), 0.26, interval_s);
            // The integration's own tolerance.
            let error = step.state.yaw_rate_rad_s - exact.yaw_rate_rad_s;
            assert!(error.abs() < 1e-5 * exact.yaw_rate_rad_s, "{error}");
            let error = step.state.heading_rad - exact.heading_rad;
            assert!(error.abs() < 1e-5 * exact.heading_rad, "{error}");
        }
    }

    #[test]
    fn exact_steps_of_a_linear_model_are_its_own() {
        let linear = SwayYawModel {
            cross_flow_per_rad_s: 0.0,
            ..model()
        };
        let from = SwayYawState {
            heading_rad: 1.2,
            yaw_rate_rad_s: -0.3,
            drift_rad: 0.2,
        };
        let mut steps = Steps::new(linear, true);
        for interval_s in [0.05, 0.05, 2.0] {
            let (found, expected) = (
                steps.step(from, 0.2, interval_s),
                linear.step(from, 0.2, interval_s),
            );
            let pairs = (found.tangent.iter().flatten()).zip(expected.tangent.iter().flatten());
            for (i, (found, expected)) in pairs.enumerate() {
                // Rounding; the derivative to k is left out.
                assert!(i % 8 == TO_CROSS_FLOW || (found - expected).abs() < 1e-13);
            }
            assert!((found.state.heading_rad - expected.state.heading_rad).abs() < 1e-14);
            assert!((found.state.drift_rad - expected.state.drift_rad).abs() < 1e-14);
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
        let settled = linear.step(start, 0.1, 60.0).state;
        // e^-21 of the transient is left, and the integration's tolerance.
        assert!((settled.yaw_rate_rad_s - 0.1 * nomoto.k_per_s).abs() < 1e-7);
        // At once after a step of the rudder r' = K T3/(T1 T2) delta.
        let instant_s = 1e-6;
        let soon = linear.step(start, 0.1, instant_s).state;
        let expected = 0.1 * nomoto.k_per_s * nomoto.t3_s / (nomoto.t1_s * nomoto.t2_s);
        assert!((soon.yaw_rate_rad_s / instant_s - expected).abs() < 1e-5 * expected);
        let poles = [-1.0 / nomoto.t1_s, -1.0 / nomoto.t2_s];
        assert!((poles[0] + poles[1] - (linear.a11_per_s + linear.a22_per_s)).abs() < 1e-12);
    }

    /// Central differences of the simulation itself.
    #[test]
    fn exact_sensitivities_are_those_of_the_simulation() {
        let from = SwayYawState {
            heading_rad: 0.1,
            yaw_rate_rad_s: 0.1,
            drift_rad: -0.08,
        };
        let step = model().step(from, 0.2, 0.05);
        let spread = 1e-5;
        let difference = |change: fn(&mut SwayYawModel, f64)| {
            let at = |amount: f64| {
                let mut changed = model();
                change(&mut changed, amount);
                changed.step(from, 0.2, 0.05).state.yaw_rate_rad_s
            };
            (at(spread) - at(-spread)) / (2.0 * spread)
        };
        let [a22, a21, a11, cross_flow] = step.to_dynamics().map(|column| column[1]);
        for (found, expected) in [
            (a22, difference(|m, d| m.a22_per_s += d)),
            (a21, difference(|m, d| m.a21_per_s2 += d)),
            (a11, difference(|m, d| m.a11_per_s += d)),
            (cross_flow, difference(|m, d| m.cross_flow_per_rad_s += d)),
            (step.to_input()[1], difference(|m, d| m.c0_rad_per_s2 += d)),
        ] {
            // Differences of numbers of size 0.1 over 1e-5 keep ten digits.
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        }
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
