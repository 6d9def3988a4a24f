//! Turning limits: yaw rate, radii and times under the full rudder, to either side.

use core::fmt;

use crate::authority::AuthorityFit;
use crate::model::{Discretisation, phi};
use crate::{Real, YawModel};

/// Which way the vehicle turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Side {
    /// Heading increases as the compass counts.
    Starboard,
    /// Heading decreases.
    Port,
}

/// Why there is no steady turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum NoTurn {
    /// a22 is 0 or positive: the yaw rate has no steady value.
    CourseUnstable,
    /// The full rudder does not overcome the offset delta0 to this side.
    NoAuthority,
    /// The rudder limit is not a positive number.
    RudderLimit,
    /// A parameter is NaN or infinite.
    NonFinite,
}

impl fmt::Display for NoTurn {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::CourseUnstable => {
                "a22 is not negative: under constant rudder the yaw rate grows without a steady value"
            }
            Self::NoAuthority => "the full rudder does not turn the vehicle to this side",
            Self::RudderLimit => "the rudder limit must be a positive number",
            Self::NonFinite => "a parameter is not finite",
        })
    }
}

impl core::error::Error for NoTurn {}

/// A turn under the full rudder to one side.
///
/// ```text
/// psi_dot_max = |b2| (delta_max +- delta0 sign b2) / -a22            (47)
/// t1          = 4 / -a22                                             (48)
/// T_pi        = pi / psi_dot_max + t1                                (49)
/// R           = V T_pi / pi                                          (50)
/// R_steady    = V / psi_dot_max
/// ```
///
/// | symbol | identifier | unit |
/// |---|---|---|
/// | psi_dot_max | `yaw_rate_rad_s` | rad/s, magnitude |
/// | t1 | [`rise_time_s`](Turn::rise_time_s) | s |
/// | T_pi | [`u_turn_time_s`](Turn::u_turn_time_s) | s |
/// | R | [`u_turn_mean_radius_m`](Turn::u_turn_mean_radius_m) | m |
/// | R_steady | [`steady_turning_radius_m`](Turn::steady_turning_radius_m) | m |
///
/// Source: (40)-(50) with the sign of delta0 from (6): + to starboard, - to port; the paper prints
/// only delta_max - delta0. t1 is the 2 % settling time and belongs to the paper's trapezoid of yaw
/// rate, so R is the mean radius of a U-turn with its ends and not the radius of the circle that a
/// long turn draws. The rudder is taken to move at once and the speed to stay the same.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Turn<T> {
    /// To which side.
    #[cfg_attr(feature = "serde", serde(rename = "hand"))]
    pub side: Side,
    /// The full rudder to that side with its sign, rad.
    pub rudder_rad: T,
    /// Magnitude of the steady yaw rate, rad/s.
    pub yaw_rate_rad_s: T,
    /// T = -1/a22, s.
    pub time_constant_s: T,
}

impl<T: Real> Turn<T> {
    /// The turn of a model under its full rudder.
    ///
    /// ```
    /// use seatrial_core::turning::NoTurn;
    /// use seatrial_core::{Side, Turn, YawModel};
    ///
    /// // delta0 = 0.05 rad helps to starboard and hinders to port.
    /// let model = YawModel::from_theta([-1.0, 2.0, 0.1]);
    /// let rate = |side| Turn::new(&model, 0.25, side).map(|turn| turn.yaw_rate_rad_s);
    /// assert_eq!([rate(Side::Starboard), rate(Side::Port)], [Ok(0.6), Ok(0.4)]);
    /// assert_eq!(Turn::new(&model, 0.04, Side::Port).map(|_| ()), Err(NoTurn::NoAuthority));
    /// ```
    pub fn new(model: &YawModel<T>, rudder_limit_rad: T, side: Side) -> Result<Self, NoTurn> {
        let [a22, b2, c0] = model.theta();
        if !model.theta().iter().all(|p| p.is_finite()) {
            return Err(NoTurn::NonFinite);
        }
        if !rudder_limit_rad.is_finite() || rudder_limit_rad <= T::ZERO {
            return Err(NoTurn::RudderLimit);
        }
        if a22 >= T::ZERO {
            return Err(NoTurn::CourseUnstable);
        }
        let towards = match side {
            Side::Starboard => T::ONE,
            Side::Port => -T::ONE,
        };
        let yaw_acceleration = b2.abs() * rudder_limit_rad + towards * c0;
        let yaw_rate_rad_s = yaw_acceleration / -a22;
        if b2 == T::ZERO || yaw_rate_rad_s <= T::ZERO {
            return Err(NoTurn::NoAuthority);
        }
        if !yaw_rate_rad_s.is_finite() {
            return Err(NoTurn::NonFinite);
        }
        Ok(Self {
            side,
            rudder_rad: towards * rudder_limit_rad * if b2 < T::ZERO { -T::ONE } else { T::ONE },
            yaw_rate_rad_s,
            time_constant_s: -T::ONE / a22,
        })
    }

    /// t1 (48), s: within 2 % of the steady yaw rate.
    ///
    /// ```
    /// use seatrial_core::{Side, Turn, YawModel};
    ///
    /// let turn = Turn::new(&YawModel::from_theta([-0.5, 1.0, 0.0]), 0.25, Side::Port)?;
    /// // Four time constants of 2 s.
    /// assert_eq!(turn.rise_time_s(), 8.0);
    /// # Ok::<(), seatrial_core::turning::NoTurn>(())
    /// ```
    pub fn rise_time_s(&self) -> T {
        T::of(4.0) * self.time_constant_s
    }

    /// T_pi (49), s.
    ///
    /// ```
    /// use seatrial_core::{Side, Turn, YawModel};
    ///
    /// let turn = Turn::new(&YawModel::from_theta([-0.5, 1.0, 0.0]), 0.25, Side::Port)?;
    /// // pi over 0.5 rad/s, and the 8 s of the rise.
    /// assert!((turn.u_turn_time_s() - (core::f64::consts::PI / 0.5 + 8.0)).abs() < 1e-12);
    /// # Ok::<(), seatrial_core::turning::NoTurn>(())
    /// ```
    pub fn u_turn_time_s(&self) -> T {
        T::PI / self.yaw_rate_rad_s + self.rise_time_s()
    }

    /// R (50), m: path length of the paper's U-turn over pi.
    ///
    /// ```
    /// use seatrial_core::{Side, Turn, YawModel};
    ///
    /// let turn = Turn::new(&YawModel::from_theta([-1.0, 1.0, 0.0]), 0.26, Side::Starboard)?;
    /// // (50): V T_pi/pi = V (1/0.26 + 4/pi).
    /// assert!(
    ///     (turn.u_turn_mean_radius_m(1.5) - 1.5 * (1.0 / 0.26 + 4.0 / core::f64::consts::PI)).abs()
    ///         < 1e-9
    /// );
    /// # Ok::<(), seatrial_core::turning::NoTurn>(())
    /// ```
    pub fn u_turn_mean_radius_m(&self, surge_speed_m_s: T) -> T {
        surge_speed_m_s * self.u_turn_time_s() / T::PI
    }

    /// Radius of the circle after the yaw rate has settled, m.
    ///
    /// ```
    /// use seatrial_core::{Side, Turn, YawModel};
    ///
    /// let turn = Turn::new(&YawModel::from_theta([-0.5, 1.0, 0.0]), 0.25, Side::Starboard)?;
    /// // 1.5 m/s at 0.5 rad/s; the U-turn of the paper, ends and all, is wider.
    /// assert_eq!(turn.steady_turning_radius_m(1.5), 3.0);
    /// assert!(turn.u_turn_mean_radius_m(1.5) > 3.0);
    /// # Ok::<(), seatrial_core::turning::NoTurn>(())
    /// ```
    pub fn steady_turning_radius_m(&self, surge_speed_m_s: T) -> T {
        surge_speed_m_s / self.yaw_rate_rad_s
    }

    /// Time of a heading change by the paper's profile, from rest to rest, s: yaw rate rises and
    /// falls along straight lines of t1 each. A change too small to reach the full rate is a triangle
    /// with the same slopes.
    ///
    /// ```
    /// use seatrial_core::{Side, Turn, YawModel};
    ///
    /// let turn = Turn::new(&YawModel::from_theta([-1.0, 1.0, 0.0]), 0.5, Side::Starboard)?;
    /// // Half a turn takes T_pi; a quarter the time less of its constant part.
    /// let half = turn.trapezoid_time_s(core::f64::consts::PI);
    /// assert!((half - turn.u_turn_time_s()).abs() < 1e-9);
    /// assert!(turn.trapezoid_time_s(0.1) < half);
    /// # Ok::<(), seatrial_core::turning::NoTurn>(())
    /// ```
    pub fn trapezoid_time_s(&self, heading_change_rad: T) -> T {
        let change = heading_change_rad.abs();
        let rise = self.rise_time_s();
        if change >= self.yaw_rate_rad_s * rise {
            change / self.yaw_rate_rad_s + rise
        } else {
            T::of(2.0) * (change * rise / self.yaw_rate_rad_s).sqrt()
        }
    }

    /// Time of a heading change by the model itself, s: from straight ahead, full rudder from the
    /// first instant, until the heading is reached (the vehicle is still turning then).
    ///
    /// ```text
    /// psi(t) = psi_dot_max (t - T (1 - e^{-t/T}))
    /// ```
    ///
    /// Newton's method from above, where it converges monotonically.
    ///
    /// ```
    /// use seatrial_core::{Side, Turn, YawModel};
    ///
    /// let turn = Turn::new(&YawModel::from_theta([-1.0, 1.0, 0.0]), 0.5, Side::Starboard)?;
    /// let time_s: f64 = turn.full_rudder_time_s(1.0);
    /// // psi(t) = 0.5 (t - 1 + e^-t)
    /// assert!((0.5 * (time_s - 1.0 + (-time_s).exp()) - 1.0).abs() < 1e-9);
    /// # Ok::<(), seatrial_core::turning::NoTurn>(())
    /// ```
    pub fn full_rudder_time_s(&self, heading_change_rad: T) -> T {
        let change = heading_change_rad.abs();
        let a22 = -T::ONE / self.time_constant_s;
        let acceleration = self.yaw_rate_rad_s / self.time_constant_s;
        let mut time = change / self.yaw_rate_rad_s
            + self.time_constant_s.min((T::of(2.0) * change / acceleration).sqrt());
        loop {
            let step = Discretisation::new(a22, time);
            let excess = acceleration * step.heading_gain_s2 - change;
            let next = time - excess / (acceleration * time * phi(a22 * time).0);
            if !next.is_finite() || next >= time {
                return time;
            }
            time = next;
        }
    }
}

/// The paper's turning limits over speed: constant damping, fitted authority, no offset.
///
/// ```text
/// R(V) = -V (a22 / (b2(V) delta_max) + 4 / (a22 pi))                 (52)
/// ```
///
/// and so with (53), (54). The offset shrinks with speed and has its own value at every identified
/// speed; it is left out here as in the paper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TurningOverSpeed<T> {
    /// a22 at every speed, 1/s.
    pub a22_per_s: T,
    /// b2 over speed.
    pub authority: AuthorityFit<T>,
    /// delta_max, rad.
    pub rudder_limit_rad: T,
}

/// A speed and the U-turn mean radius there.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RadiusMinimum<T> {
    /// Forward speed, m/s.
    pub surge_speed_m_s: T,
    /// U-turn mean radius, m.
    pub u_turn_mean_radius_m: T,
    /// The speed was not covered by the fit.
    pub extrapolated: bool,
}

impl<T: Real> TurningOverSpeed<T> {
    /// The turn at a speed.
    ///
    /// ```
    /// use seatrial_core::turning::{NoTurn, TurningOverSpeed};
    /// use seatrial_core::{AuthorityFit, AuthorityForm};
    ///
    /// let authority = AuthorityFit {
    ///     form: AuthorityForm::ThroughZero,
    ///     per_speed_squared_per_m2: 0.5,
    ///     constant_per_s2: 0.0,
    ///     rms_residual_per_s2: 0.0,
    ///     speed_range_m_s: [0.5, 3.0],
    /// };
    /// let vehicle = TurningOverSpeed { a22_per_s: -1.0, authority, rudder_limit_rad: 0.26 };
    /// // 0.5 V^2 delta_max over 1 1/s.
    /// assert!((vehicle.turn_at(2.0)?.yaw_rate_rad_s - 0.52_f64).abs() < 1e-12);
    /// # Ok::<(), NoTurn>(())
    /// ```
    pub fn turn_at(&self, surge_speed_m_s: T) -> Result<Turn<T>, NoTurn> {
        let model = YawModel {
            a22_per_s: self.a22_per_s,
            b2_per_s2: *self.authority.b2_per_s2(surge_speed_m_s).value(),
            c0_rad_per_s2: T::ZERO,
        };
        Turn::new(&model, self.rudder_limit_rad, Side::Starboard)
    }

    /// The speed between two bounds that gives the least U-turn mean radius away from rest.
    ///
    /// R(V) of (52) rises from 0, has at most one local maximum and, beyond it, one minimum. With
    /// y = |b2(V)| = k V^2 + c, p = -a22/delta_max and q = 4/(-a22 pi),
    ///
    /// ```text
    /// dR/dV = p (2c - y)/y^2 + q = 0    =>    y = (p + sqrt(p^2 - 8 p q c)) / (2 q)
    /// ```
    ///
    /// is that minimum. `None` where it is absent (R then only rises) or outside the bounds.
    ///
    /// ```
    /// use seatrial_core::turning::{NoTurn, TurningOverSpeed};
    /// use seatrial_core::{AuthorityFit, AuthorityForm};
    ///
    /// let authority = AuthorityFit {
    ///     form: AuthorityForm::ThroughZero,
    ///     per_speed_squared_per_m2: 0.5,
    ///     constant_per_s2: 0.0,
    ///     rms_residual_per_s2: 0.0,
    ///     speed_range_m_s: [0.5, 3.0],
    /// };
    /// let vehicle = TurningOverSpeed { a22_per_s: -1.0, authority, rudder_limit_rad: 0.26 };
    /// // y = p/q with p = 1/0.26 and q = 4/pi, and V = sqrt(y/k).
    /// let best = vehicle.minimum_radius(0.5, 3.0)?;
    /// assert!(best.is_some_and(|best| (best.surge_speed_m_s - 2.458_f64).abs() < 1e-3));
    /// # Ok::<(), NoTurn>(())
    /// ```
    pub fn minimum_radius(
        &self,
        from_m_s: T,
        to_m_s: T,
    ) -> Result<Option<RadiusMinimum<T>>, NoTurn> {
        self.turn_at(to_m_s)?;
        let sign = if self.authority.per_speed_squared_per_m2 < T::ZERO { -T::ONE } else { T::ONE };
        let k = sign * self.authority.per_speed_squared_per_m2;
        let c = sign * self.authority.constant_per_s2;
        let p = -self.a22_per_s / self.rudder_limit_rad;
        let q = T::of(-4.0) / (self.a22_per_s * T::PI);
        let discriminant = p * p - T::of(8.0) * p * q * c;
        let y = (p + discriminant.sqrt()) / (T::of(2.0) * q);
        let speed = ((y - c) / k).sqrt();
        // A negative discriminant gives NaN, which lies within no bounds.
        if !(from_m_s <= speed && speed <= to_m_s) {
            return Ok(None);
        }
        Ok(Some(RadiusMinimum {
            surge_speed_m_s: speed,
            u_turn_mean_radius_m: self.turn_at(speed)?.u_turn_mean_radius_m(speed),
            extrapolated: self.authority.b2_per_s2(speed).is_extrapolated(),
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::authority::AuthorityForm;
    use crate::model::YawState;
    use crate::schedule::SchedulePoint;

    const RUDDER_LIMIT: f64 = 0.26;

    fn turn(theta: [f64; 3], side: Side) -> Turn<f64> {
        Turn::new(&YawModel::from_theta(theta), RUDDER_LIMIT, side).unwrap()
    }

    /// The printed row needs delta0 = 0.036 at 1.4 m/s; the printed 0.04 gives 9.73 deg/s, 20.98 s, 9.35 m.
    #[test]
    fn val_paper_table_iv() {
        for (delta0, rate_deg_s, time_s, radius_m) in
            [(0.036, 9.90, 20.65, 9.20), (0.04, 9.73, 20.98, 9.35)]
        {
            let turn = turn([-1.62, 1.25, 1.25 * delta0], Side::Port);
            // Half a unit of the last digit printed.
            assert!((turn.yaw_rate_rad_s.to_degrees() - rate_deg_s).abs() < 0.005);
            assert!((turn.u_turn_time_s() - time_s).abs() < 0.005);
            assert!((turn.u_turn_mean_radius_m(1.4) - radius_m).abs() < 0.005);
        }
        let turn = turn([-1.62, 1.25, 1.25 * 0.036], Side::Port);
        assert!((turn.steady_turning_radius_m(1.4) - 8.10).abs() < 0.005);
    }

    #[test]
    fn val_paper_table_v_radius_of_both_80_percent_runs() {
        for (theta, radius_m, delta0) in
            [([-1.70, 1.41, 0.0], 9.20, 0.019), ([-1.54, 1.30, 0.0], 9.25, 0.021)]
        {
            let [a22, b2, _] = theta;
            let turn = turn([a22, b2, b2 * delta0], Side::Port);
            // Half a unit of the last digit printed.
            assert!((turn.u_turn_mean_radius_m(1.60) - radius_m).abs() < 0.005);
        }
    }

    fn figure_14() -> TurningOverSpeed<f64> {
        TurningOverSpeed {
            a22_per_s: -1.1,
            authority: AuthorityFit {
                form: AuthorityForm::WithConstant,
                per_speed_squared_per_m2: 0.31,
                constant_per_s2: 0.26,
                rms_residual_per_s2: 0.0,
                speed_range_m_s: [1.07, 2.19],
            },
            rudder_limit_rad: RUDDER_LIMIT,
        }
    }

    /// 4 m is printed and right, 48 s is printed and is the first term of (54) alone.
    #[test]
    fn val_paper_figure_14_at_a_quarter_metre_per_second() {
        let turn = figure_14().turn_at(0.25).unwrap();
        assert!((turn.u_turn_mean_radius_m(0.25) - 4.08).abs() < 0.005);
        assert!((turn.u_turn_time_s() - 51.2).abs() < 0.05);
        assert!((turn.u_turn_time_s() - turn.rise_time_s() - 48.0).abs() < 0.5);
    }

    /// NOTES: 7.63 m at 2.99 m/s; the printed 5.9 m at 4.2 m/s does not follow from (52).
    #[test]
    fn val_paper_figure_14_minimum() {
        let minimum = figure_14().minimum_radius(1.0, 5.0).unwrap().unwrap();
        assert!((minimum.u_turn_mean_radius_m - 7.63).abs() < 0.005);
        assert!((minimum.surge_speed_m_s - 2.99).abs() < 0.005);
        assert!(minimum.extrapolated);
        assert_eq!(figure_14().minimum_radius(1.0, 2.2), Ok(None));
    }

    #[test]
    fn prop_no_speed_near_the_minimum_turns_tighter() {
        for (k, c) in [(0.31, 0.26), (0.387, 0.0), (-0.31, -0.26), (0.31, -0.2)] {
            let mut over_speed = figure_14();
            over_speed.authority.per_speed_squared_per_m2 = k;
            over_speed.authority.constant_per_s2 = c;
            let minimum = over_speed.minimum_radius(1.0, 9.0).unwrap().unwrap();
            for step in 0..=1000 {
                let speed = 2.0 + 0.004 * f64::from(step);
                let radius = over_speed.turn_at(speed).unwrap().u_turn_mean_radius_m(speed);
                assert!(radius >= minimum.u_turn_mean_radius_m - 1e-12);
            }
        }
    }

    /// No minimum where the constant dominates: 8 q c > p.
    #[test]
    fn exact_no_minimum_where_the_radius_only_rises() {
        let mut over_speed = figure_14();
        over_speed.authority.constant_per_s2 = 1.0;
        assert_eq!(over_speed.minimum_radius(0.0, 100.0), Ok(None));
    }

    #[test]
    fn exact_hands_differ_by_the_offset_and_follow_the_sign_of_b2() {
        for b2 in [1.25, -1.25] {
            let theta = [-1.62, b2, 0.045];
            for (side, towards) in [(Side::Starboard, 1.0), (Side::Port, -1.0)] {
                let turn = turn(theta, side);
                let model = YawModel::from_theta(theta);
                let far = model.advance(YawState::default(), turn.rudder_rad, 100.0);
                // The steady rate of the model itself; e^-162 is left of the transient.
                assert!((far.yaw_rate_rad_s - towards * turn.yaw_rate_rad_s).abs() < 1e-15);
            }
            let faster = turn(theta, Side::Starboard).yaw_rate_rad_s;
            assert!(faster > turn(theta, Side::Port).yaw_rate_rad_s);
        }
    }

    #[test]
    fn exact_full_rudder_time_reaches_the_heading() {
        for theta in [[-1.62, 1.25, 0.0], [-1e-4, 2.0, 0.01], [-30.0, 0.3, 0.0]] {
            for change in [1e-6, 0.35, 3.0, 100.0] {
                let turn = turn(theta, Side::Starboard);
                let time = turn.full_rudder_time_s(-change);
                let model = YawModel::from_theta(theta);
                let reached = model.advance(YawState::default(), turn.rudder_rad, time);
                // Rounding of the exponential, relative.
                assert!((reached.heading_rad / change - 1.0).abs() < 1e-12);
            }
        }
        assert_eq!(turn([-1.0, 1.0, 0.0], Side::Port).full_rudder_time_s(0.0), 0.0);
    }

    #[test]
    fn exact_trapezoid_time_is_49_for_a_u_turn_and_continuous() {
        let turn = turn([-1.62, 1.25, 0.0], Side::Starboard);
        assert_eq!(turn.trapezoid_time_s(core::f64::consts::PI), turn.u_turn_time_s());
        let edge = turn.yaw_rate_rad_s * turn.rise_time_s();
        let above = turn.trapezoid_time_s(edge);
        let below = turn.trapezoid_time_s(edge * (1.0 - 1e-9));
        // The slope there is 1/psi_dot_max = 5 s/rad, times 1e-9 of half a radian.
        assert!((above - below).abs() < 1e-8);
        assert_eq!(turn.trapezoid_time_s(0.0), 0.0);
    }

    #[test]
    fn exact_refusals_are_values() {
        let new = |theta, limit| Turn::new(&YawModel::from_theta(theta), limit, Side::Port);
        assert_eq!(new([0.0, 1.0, 0.0], 0.26), Err(NoTurn::CourseUnstable));
        assert_eq!(new([-1.0, 0.0, 0.0], 0.26), Err(NoTurn::NoAuthority));
        assert_eq!(new([-1.0, 0.0, -0.1], 0.26), Err(NoTurn::NoAuthority));
        assert_eq!(new([-1.0, 1.0, 0.3], 0.26), Err(NoTurn::NoAuthority));
        assert_eq!(new([-1.0, 1.0, f64::NAN], 0.26), Err(NoTurn::NonFinite));
        assert_eq!(new([-1.0, 1.0, 0.0], 0.0), Err(NoTurn::RudderLimit));
    }

    #[test]
    fn parity_f32_turn() {
        let model = YawModel::from_theta([-1.62_f32, 1.25, 0.045]);
        let single = Turn::new(&model, 0.26, Side::Port).unwrap();
        let double = turn([-1.62, 1.25, 0.045], Side::Port);
        // A few roundings of f32, relative.
        let near = |a: f32, b: f64| (f64::from(a) / b - 1.0).abs() < 1e-6;
        assert!(near(single.u_turn_time_s(), double.u_turn_time_s()));
        assert!(near(single.full_rudder_time_s(1.0), double.full_rudder_time_s(1.0)));
        let points = [0.5_f32, 1.0].map(|speed| SchedulePoint {
            thrust: None,
            surge_speed_m_s: Some(speed),
            model: YawModel::from_theta([-1.0, 0.4 * speed * speed, 0.0]),
        });
        let fit = AuthorityFit::new(&points, AuthorityForm::ThroughZero).unwrap();
        assert!(near(fit.per_speed_squared_per_m2, 0.4));
    }
}
