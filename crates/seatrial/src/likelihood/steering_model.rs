//! The steering model beyond first order: damping that grows with the turn, sway, and a gear that is late, lags or has a largest rate.

use seatrial_core::{Sample, YawModel};
use serde::{Deserialize, Serialize};

use super::free_run::simulate;
use super::hypothesis::Vehicle;
use super::leg::Leg;
use super::motion::Start;

/// Yaw with sway, quadratic damping and a steering gear.
///
/// ```text
/// psi' = r
/// r'   = (a22 - d2 |r|) r + a21 v + b2 delta_a + C0
/// v'   = r + a11 v
/// T_l delta_a' = delta(t - tau) - delta_a,   |delta_a'| <= rho
/// ```
///
/// | symbol | identifier | unit | positive sense |
/// |---|---|---|---|
/// | psi, r | `heading_rad`, `yaw_rate_rad_s` | rad, rad/s | heading increasing |
/// | v | `drift_rad` | rad | the turning that sway remembers |
/// | delta, delta_a | | rad | rudder of the record, and as it acts |
/// | a22, b2, C0 | | 1/s, 1/s^2, rad/s^2 | as in [`seatrial_core::YawModel`] |
/// | d2 | `quadratic_per_rad` | 1/rad | damping that grows with the yaw rate, not negative |
/// | a21 | `a21_per_s2` | 1/s^2 | what sway does to yaw |
/// | a11 | `a11_per_s` | 1/s | decay of sway, not positive |
/// | tau, T_l | `rudder_shift_s`, `rudder_lag_s` | s | time by which the record of the rudder is early, lag of the gear |
/// | rho | `rate_limit_rad_s` | rad/s | largest rate of the gear |
///
/// Source: (1)-(2) of the paper with sway eliminated; quadratic damping as in Norrbin (1963). Without d2, rho and gear it is the
/// second-order Nomoto model; with a21 = d2 = 0 the first-order model (5)-(7).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SteeringModel {
    /// a22, rotational damping, 1/s.
    pub a22_per_s: f64,
    /// b2, rudder authority, 1/s^2.
    pub b2_per_s2: f64,
    /// C0, yaw acceleration at neutral rudder, rad/s^2.
    pub c0_rad_per_s2: f64,
    /// d2, damping per yaw rate, 1/rad.
    pub quadratic_per_rad: f64,
    /// a21, effect of sway on the yaw acceleration, 1/s^2.
    pub a21_per_s2: f64,
    /// a11, decay of sway, 1/s.
    pub a11_per_s: f64,
    /// tau, time by which the record of the rudder is early, s.
    pub rudder_shift_s: f64,
    /// T_l, lag of the gear, s.
    pub rudder_lag_s: f64,
    /// rho, largest rate of the gear, rad/s; `None` where it has none.
    pub rate_limit_rad_s: Option<f64>,
    /// Play of the gear from stop to stop, rad; `None` where it has none.
    pub play_rad: Option<f64>,
}

/// Heading, yaw rate and sway at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SteeringState {
    /// Heading, rad, unwrapped.
    pub heading_rad: f64,
    /// Yaw rate, rad/s.
    pub yaw_rate_rad_s: f64,
    /// Turning that sway remembers v, rad.
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

impl SteeringModel {
    /// Of first order behind a rudder that lags by so much, s.
    ///
    /// ```
    /// use seatrial::likelihood::SteeringModel;
    /// use seatrial_core::YawModel;
    ///
    /// let model = SteeringModel::first_order(&YawModel::from_theta([-1.0, 2.0, 0.1]), 0.4);
    /// assert_eq!((model.rudder_lag_s, model.a21_per_s2), (0.4, 0.0));
    /// ```
    pub fn first_order(model: &YawModel<f64>, rudder_lag_s: f64) -> Self {
        Self {
            a22_per_s: model.a22_per_s,
            b2_per_s2: model.b2_per_s2,
            c0_rad_per_s2: model.c0_rad_per_s2,
            rudder_lag_s,
            ..Self::default()
        }
    }

    /// With this offset, rad/s^2.
    pub fn new(vehicle: &Vehicle, offset_rad_s2: f64) -> Self {
        let has_sway = vehicle.coupling_per_s2 != 0.0;
        Self {
            a22_per_s: -vehicle.damping_per_s,
            b2_per_s2: vehicle.authority_per_s2,
            c0_rad_per_s2: offset_rad_s2,
            quadratic_per_rad: vehicle.quadratic_per_rad,
            a21_per_s2: vehicle.coupling_per_s2,
            a11_per_s: if has_sway { -1.0 / vehicle.sway_s } else { 0.0 },
            rudder_shift_s: vehicle.shift_s,
            rudder_lag_s: vehicle.lag_s,
            rate_limit_rad_s: vehicle
                .rate_limit_rad_s
                .is_finite()
                .then_some(vehicle.rate_limit_rad_s),
            play_rad: (vehicle.play_rad > 0.0).then_some(vehicle.play_rad),
        }
    }

    /// As the likelihood takes it.
    ///
    /// ```
    /// use seatrial::likelihood::SteeringModel;
    ///
    /// // Signs and rates become sizes and times.
    /// let model = SteeringModel { a22_per_s: -1.0, a11_per_s: -0.5, ..SteeringModel::default() };
    /// let vehicle = model.vehicle();
    /// assert_eq!((vehicle.damping_per_s, vehicle.sway_s), (1.0, 2.0));
    /// assert_eq!(vehicle.rate_limit_rad_s, f64::INFINITY);
    /// ```
    pub fn vehicle(&self) -> Vehicle {
        Vehicle {
            damping_per_s: -self.a22_per_s,
            authority_per_s2: self.b2_per_s2,
            shift_s: self.rudder_shift_s,
            lag_s: self.rudder_lag_s,
            rate_limit_rad_s: self.rate_limit_rad_s.unwrap_or(f64::INFINITY),
            play_rad: self.play_rad.unwrap_or(0.0),
            quadratic_per_rad: self.quadratic_per_rad,
            coupling_per_s2: self.a21_per_s2,
            sway_s: if self.a11_per_s < 0.0 { -1.0 / self.a11_per_s } else { 1.0 },
        }
    }

    /// Time by which the gear is late in the mean of a stroke from neutral to an amplitude, rad, s.
    ///
    /// ```
    /// use seatrial::likelihood::SteeringModel;
    ///
    /// let gear =
    ///     SteeringModel { rudder_lag_s: 0.5, rate_limit_rad_s: Some(0.1), ..SteeringModel::default() };
    /// // Half of the 3 s that 0.3 rad take at 0.1 rad/s come to the lag.
    /// assert!((gear.gear_delay_s(0.3) - 2.0).abs() < 1e-12);
    /// ```
    pub fn gear_delay_s(&self, amplitude_rad: f64) -> f64 {
        let on_the_way_s =
            self.rate_limit_rad_s.map_or(0.0, |rate| 0.5 * amplitude_rad.abs() / rate);
        self.rudder_lag_s + on_the_way_s
    }

    /// Nomoto form of the linear part, which holds for small rudder:
    ///
    /// ```text
    /// T1 T2 = 1/D,  T1 + T2 = -(a11 + a22)/D,  T3 = -1/a11,  K = -a11 b2/D,  D = a11 a22 - a21
    /// ```
    ///
    /// `None` where the time constants are complex or infinite.
    ///
    /// ```
    /// use seatrial::likelihood::SteeringModel;
    ///
    /// // Sway: T1 T2 = 1/D and K = -a11 b2/D with D = a11 a22 - a21 = 1.
    /// let model = SteeringModel {
    ///     a22_per_s: -1.0,
    ///     b2_per_s2: 0.5,
    ///     a21_per_s2: 1.0,
    ///     a11_per_s: -2.0,
    ///     ..SteeringModel::default()
    /// };
    /// let nomoto = model.nomoto().ok_or("real time constants")?;
    /// assert!((nomoto.t1_s * nomoto.t2_s - 1.0).abs() < 1e-9);
    /// assert!((nomoto.k_per_s - 1.0).abs() < 1e-9 && nomoto.t3_s == 0.5);
    /// # Ok::<(), &str>(())
    /// ```
    pub fn nomoto(&self) -> Option<SecondOrderNomoto> {
        let stiffness = self.a11_per_s * self.a22_per_s - self.a21_per_s2;
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

    /// The free-running simulation at each sample, from `start` and a gear at rest. `samples` are finite and increase in time.
    ///
    /// ```
    /// use seatrial::Sample;
    /// use seatrial::likelihood::{SteeringModel, steering_model::SteeringState};
    ///
    /// let model = SteeringModel {
    ///     a22_per_s: -1.0,
    ///     b2_per_s2: 1.0,
    ///     quadratic_per_rad: 2.0,
    ///     ..SteeringModel::default()
    /// };
    /// let samples: Vec<_> = (0..400)
    ///     .map(|k| Sample { time_s: 0.05 * f64::from(k), rudder_rad: 0.24, ..Sample::default() })
    ///     .collect();
    /// let states = model.simulate(&samples, SteeringState::default());
    /// // Damping that grows with the turn: (1 + 2 r) r = 0.24 at r = 0.177 rad/s, not 0.24.
    /// assert!((states[399].yaw_rate_rad_s - 0.1772).abs() < 1e-3);
    /// ```
    pub fn simulate(&self, samples: &[Sample<f64>], start: SteeringState) -> Vec<SteeringState> {
        let start = Start {
            heading_rad: start.heading_rad,
            yaw_rate_rad_s: start.yaw_rate_rad_s,
            sway_rad: start.drift_rad,
            offset_rad_s2: self.c0_rad_per_s2,
        };
        simulate(&Leg::new(samples, 1), &self.vehicle(), &start)
            .into_iter()
            .map(|[heading_rad, yaw_rate_rad_s, drift_rad, _]| SteeringState {
                heading_rad,
                yaw_rate_rad_s,
                drift_rad,
            })
            .collect()
    }
}

/// The first-order model [a22, b2, C0] with the vehicle's steady turn at a rudder amplitude, rad, and its slowness in turning.
///
/// ```text
/// r_s = steady rate at delta:  (d_s + d2 r_s) r_s = |b| delta,   d_s = d0 - k T_v
/// a22 = -(d_s + d2 r_s)/m,  b2 = b/m,   m = 1 + k T_v^2   (K as it is, T = T1 + T2 - T3)
/// C0 = c/m (d_s + d2 r_s)/(d_s + 2 d2 r_s)   (the steady turns to both sides as they are, to first order in c)
/// ```
///
/// Half of a rudder's play never reaches the blade: delta is less by it than the amplitude, and b2 smaller in the same ratio.
///
/// An amplitude of 0 gives the small-signal model. Not a number where no first-order model is near: m under a fifth.
///
/// ```
/// use seatrial::likelihood::SteeringModel;
/// use seatrial::likelihood::steering_model::first_order_at;
/// use seatrial_core::YawModel;
///
/// let model = SteeringModel::first_order(&YawModel::from_theta([-1.0, 1.0, 0.0]), 0.0);
/// let quadratic = SteeringModel { quadratic_per_rad: 2.0, ..model }.vehicle();
/// // Small rudder is damped by a22 alone, a larger one by more.
/// assert_eq!(first_order_at(&quadratic, 0.0, 0.0)[0], -1.0);
/// assert!(first_order_at(&quadratic, 0.0, 0.24)[0] < -1.3);
/// ```
pub fn first_order_at(vehicle: &Vehicle, offset_rad_s2: f64, amplitude_rad: f64) -> [f64; 3] {
    const LEAST_INERTIA: f64 = 0.2;
    let sway_s = sway_s(vehicle);
    let [secant, tangent, authority] = damping_at(vehicle, amplitude_rad);
    let inertia = 1.0 + vehicle.coupling_per_s2 * sway_s * sway_s;
    if inertia < LEAST_INERTIA {
        return [f64::NAN; 3];
    }
    let offset_rad_s2 = offset_rad_s2 * if tangent == secant { 1.0 } else { secant / tangent };
    [-secant / inertia, authority / inertia, offset_rad_s2 / inertia]
}

/// ln |K|, K in 1/s, of the steady turn at a rudder amplitude, rad. Where nothing ends the turn, that of a twentieth of the damping without sway.
///
/// ```
/// use seatrial::likelihood::SteeringModel;
/// use seatrial::likelihood::steering_model::log_steady_gain;
/// use seatrial_core::YawModel;
///
/// let model = SteeringModel::first_order(&YawModel::from_theta([-0.5, 1.0, 0.0]), 0.0);
/// // K = 1.0/0.5 1/s, whatever the rudder.
/// assert!((log_steady_gain(&model.vehicle(), 0.2) - 2_f64.ln()).abs() < 1e-12);
/// ```
pub fn log_steady_gain(vehicle: &Vehicle, amplitude_rad: f64) -> f64 {
    const LEAST_DAMPING: f64 = 0.05;
    let [secant, _, authority] = damping_at(vehicle, amplitude_rad);
    let gain = authority / secant.max(LEAST_DAMPING * vehicle.damping_per_s.abs());
    libm::log(gain.abs())
}

/// Damping d_s + d2 r_s of the steady turn at a rudder amplitude, rad, that of a small change of this turn, d_s + 2 d2 r_s, both 1/s, and the
/// rudder's effect on the turn, 1/s^2.
fn damping_at(vehicle: &Vehicle, amplitude_rad: f64) -> [f64; 3] {
    let damping = vehicle.damping_per_s - vehicle.coupling_per_s2 * sway_s(vehicle);
    let reaching = match amplitude_rad > 0.5 * vehicle.play_rad {
        true => 1.0 - 0.5 * vehicle.play_rad / amplitude_rad,
        false => 1.0,
    };
    let authority = reaching * vehicle.authority_per_s2;
    let push = (authority * amplitude_rad).abs();
    if vehicle.quadratic_per_rad <= 0.0 {
        return [damping, damping, authority];
    }
    // The root of the quadratic equation d2 r^2 + d_s r = b delta.
    let tangent = (damping * damping + 4.0 * vehicle.quadratic_per_rad * push).sqrt();
    [0.5 * (damping + tangent), tangent, authority]
}

/// Time constant of sway, s; 0 for a vehicle without.
fn sway_s(vehicle: &Vehicle) -> f64 {
    match vehicle.coupling_per_s2 != 0.0 {
        true => vehicle.sway_s,
        false => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(interval_s: f64, count: usize, rudder_rad: f64) -> Vec<Sample<f64>> {
        let sample =
            |k: usize| Sample { time_s: k as f64 * interval_s, rudder_rad, ..Sample::default() };
        (0..count).map(sample).collect()
    }

    /// A steady turn ends where the first-order model of its amplitude says, with sway and quadratic damping alike.
    #[test]
    fn exact_first_order_model_has_the_steady_turn() {
        let model = SteeringModel {
            a22_per_s: -0.8,
            b2_per_s2: 1.1,
            c0_rad_per_s2: 0.0,
            quadratic_per_rad: 1.5,
            a21_per_s2: 0.2,
            a11_per_s: -0.9,
            ..SteeringModel::default()
        };
        let states = model.simulate(&rows(0.05, 4000, 0.2), SteeringState::default());
        let [a22, b2, _] = first_order_at(&model.vehicle(), 0.0, 0.2);
        // The midpoint rule of quadratic damping.
        let settled = states[3999].yaw_rate_rad_s;
        assert!((settled + b2 * 0.2 / a22).abs() < 1e-4 * settled, "{settled}");
    }

    #[test]
    fn exact_nomoto_form_has_the_same_steady_turn() {
        let model = SteeringModel {
            a22_per_s: -0.9,
            b2_per_s2: 1.1,
            a21_per_s2: 0.1,
            a11_per_s: -0.6,
            ..SteeringModel::default()
        };
        let nomoto = model.nomoto().unwrap();
        let states = model.simulate(&rows(0.05, 2000, 0.1), SteeringState::default());
        // Sway follows the mean of two yaw rates: a share of (h/T)^2.
        let settled = states[1999].yaw_rate_rad_s;
        assert!((settled - 0.1 * nomoto.k_per_s).abs() < 1e-4 * settled, "{settled}");
        let poles = [-1.0 / nomoto.t1_s, -1.0 / nomoto.t2_s];
        assert!((poles[0] + poles[1] - (model.a11_per_s + model.a22_per_s)).abs() < 1e-12);
    }

    /// Documents of earlier versions have other fields.
    #[test]
    fn io_a_model_of_an_earlier_version_is_read() {
        let old = r#"{"a22_per_s":-1.0,"b2_per_s2":1.0,"c0_rad_per_s2":0.0,"a21_per_s2":0.0,"a11_per_s":0.0,"cross_flow_per_rad_s":0.0,"rudder_lag_s":0.15}"#;
        let model: SteeringModel = serde_json::from_str(old).unwrap();
        assert_eq!((model.rudder_lag_s, model.rate_limit_rad_s), (0.15, None));
    }
}
