//! ArduSub's way from a heading that is wanted to a yaw rate: a heading of its own that moves towards it, and the vehicle's error
//! from that.
//!
//! ```text
//! psi_t = psi_t + r_t h
//! r_t   = r_t + limit(q(psi_d - psi_t, 1/T_i, a_max) - r_t, a_max h)     within r_max and r_b
//! e     = limit(psi_t - psi, e_max),   psi_t = psi + e
//! r_d   = limit(q(e, A, a_c), r_b) + r_t                                 a_c = a_max/2, from 10 to 120 deg/s^2
//! q(e, p, a) = p e where |e| < a/p^2,   +-sqrt(2 a (|e| - a/(2 p^2))) beyond,   within |e|/h
//! e_max: q(e_max, A, a_c) = 1/P, at most 45 degrees
//! ```
//!
//! | symbol | identifier | unit | positive sense |
//! |---|---|---|---|
//! | psi_d, psi | `wanted_rad`, `heading_rad` | rad | as the compass counts |
//! | psi_t, r_t | `heading_rad`, `rate_rad_s` of `HeadingTarget` | rad, rad/s | as the compass counts |
//! | r_d | the result | rad/s | heading increasing |
//! | T_i, r_b | `time_constant_s`, `rate_limit_rad_s` of [`TargetShaping`] | s, rad/s | r_b = 0: no limit |
//! | A, P, r_max, a_max | those of `TargetSettings` | | |
//!
//! Source: what ArduPilot 4.7 does in AC_AttitudeControl.cpp (`input_euler_angle_roll_pitch_yaw_rad`, `input_shaping_angle`,
//! `thrust_heading_rotation_angles`, `update_ang_vel_target_from_att_error`) and control.cpp (`sqrt_controller`, `inv_sqrt_controller`), level
//! and about the yaw axis alone, with ATC_RATE_FF_ENAB 1.

use crate::Real;

/// How the heading that is held moves towards the one that is wanted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TargetShaping<T> {
    /// T_i, s.
    pub time_constant_s: T,
    /// r_b, rad/s.
    pub rate_limit_rad_s: T,
}

/// What of an autopilot's settings the target goes by.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct TargetSettings<T> {
    /// A, 1/s.
    pub angle_gain_per_s: T,
    /// P, s/rad.
    pub rate_gain_s: T,
    /// r_max, rad/s.
    pub rate_limit_rad_s: T,
    /// a_max, rad/s^2.
    pub acceleration_limit_rad_s2: T,
    /// T_i and r_b.
    pub shaping: TargetShaping<T>,
}

/// The heading that is held.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HeadingTarget<T> {
    heading_rad: T,
    rate_rad_s: T,
}

impl<T: Real> HeadingTarget<T> {
    /// Where the vehicle is.
    pub(crate) fn at(heading_rad: T) -> Self {
        Self { heading_rad, rate_rad_s: T::ZERO }
    }

    /// r_d, rad/s.
    pub(crate) fn wanted_rate(
        &mut self,
        settings: &TargetSettings<T>,
        [wanted_rad, heading_rad]: [T; 2],
        interval_s: T,
    ) -> T {
        let within = |rate: T, limit: T| match limit > T::ZERO {
            true => rate.limited_to(limit),
            false => rate,
        };
        let shaping = &settings.shaping;
        let body_limit = shaping.rate_limit_rad_s;
        self.heading_rad += self.rate_rad_s * interval_s;
        let acceleration = settings.acceleration_limit_rad_s2;
        let to_go = (wanted_rad - self.heading_rad).wrapped();
        let pace = T::ONE / shaping.time_constant_s.max(T::of(0.01));
        let rate = approach(to_go, pace, acceleration, interval_s);
        let change = within(rate - self.rate_rad_s, acceleration * interval_s);
        let rate = within(self.rate_rad_s + change, settings.rate_limit_rad_s);
        self.rate_rad_s = within(rate, body_limit);

        let stopping = stopping(acceleration);
        let largest = settings.largest_error_rad(stopping);
        let error = (self.heading_rad - heading_rad).wrapped();
        if error.abs() > largest {
            self.heading_rad = heading_rad + error.limited_to(largest);
        }
        let error = error.limited_to(largest);
        let correction = approach(error, settings.angle_gain_per_s, stopping, interval_s);
        within(correction, body_limit) + self.rate_rad_s
    }
}

impl<T: Real> TargetSettings<T> {
    /// e_max, rad.
    fn largest_error_rad(&self, stopping: T) -> T {
        let most = T::PI / T::of(4.0);
        let (gain, rate_gain) = (self.angle_gain_per_s, self.rate_gain_s);
        if rate_gain <= T::ZERO || gain <= T::ZERO {
            return most;
        }
        let rate = T::ONE / rate_gain;
        let error = match stopping > T::ZERO && rate > stopping / gain {
            true => {
                let linear = stopping / (gain * gain);
                T::of(0.5) * linear + rate * rate / (T::of(2.0) * stopping)
            }
            false => rate / gain,
        };
        error.min(most)
    }
}

/// a_c, rad/s^2; 0: without a limit.
fn stopping<T: Real>(acceleration: T) -> T {
    if acceleration <= T::ZERO {
        return T::ZERO;
    }
    let degree = T::PI / T::of(180.0);
    let [least, most] = [10.0, 120.0].map(|degrees| degree * T::of(degrees));
    (T::of(0.5) * acceleration).max(least).min(most)
}

/// q
fn approach<T: Real>(error: T, pace: T, acceleration: T, interval_s: T) -> T {
    let linear = acceleration / (pace * pace);
    let rate = match acceleration > T::ZERO && error.abs() > linear {
        true => {
            let size = (T::of(2.0) * acceleration * (error.abs() - T::of(0.5) * linear)).sqrt();
            match error > T::ZERO {
                true => size,
                false => -size,
            }
        }
        false => pace * error,
    };
    rate.limited_to(error.abs() / interval_s)
}

#[cfg(test)]
mod tests {
    use super::*;

    const H: f64 = 0.0025;

    fn settings() -> TargetSettings<f64> {
        TargetSettings {
            angle_gain_per_s: 2.0,
            rate_gain_s: 1.0,
            rate_limit_rad_s: 0.5,
            acceleration_limit_rad_s2: 1.0,
            shaping: TargetShaping { time_constant_s: 0.02, rate_limit_rad_s: 0.0 },
        }
    }

    /// From rest by 1 rad/s^2 up to 0.5 rad/s, and to a stop at 1 rad: 0.5 s, 1.5 s and, at half a unit from the end, down again.
    #[test]
    fn exact_a_vehicle_that_follows_is_led_by_a_ramp() {
        let mut target = HeadingTarget::at(0.0);
        let (mut heading_rad, mut fastest) = (0.0, 0.0_f64);
        let mut at = |time_s: f64, from_s: f64| {
            for _ in 0..((time_s - from_s) / H).round() as usize {
                let rate = target.wanted_rate(&settings(), [1.0, heading_rad], H);
                heading_rad += rate * H;
                fastest = fastest.max(rate);
            }
            heading_rad
        };
        // Half of 1 rad/s^2 for 0.5 s, squared; then 0.5 rad/s. Each within two intervals at the highest rate.
        for (time_s, from_s, expected) in [(0.5, 0.0, 0.125), (2.0, 0.5, 0.875), (3.0, 2.0, 1.0)] {
            let found = at(time_s, from_s);
            assert!((found - expected).abs() < 4e-3, "{time_s}: {found}");
        }
        assert!((fastest - 0.5).abs() < 4e-3, "{fastest}");
    }

    /// q is p e near, continuous at a/p^2 in value and slope, and never goes past the end in one interval.
    #[test]
    fn exact_the_approach_is_straight_near_and_a_root_beyond() {
        assert_eq!(approach(0.1, 2.0, 1.0, H), 0.2);
        let [below, above] = [0.25 - 1e-9, 0.25 + 1e-9].map(|e| approach(e, 2.0, 1.0, H));
        assert!((above - below).abs() < 1e-8);
        // sqrt(2 (1 - 1/8))
        assert!((approach(-1.0, 2.0, 1.0, H) + 1.75_f64.sqrt()).abs() < 1e-12);
        assert_eq!(approach(0.1, 1e4, 0.0, H), 0.1 / H);
    }

    /// A vehicle that does not turn holds the target back: the error stays where the steering is full.
    #[test]
    fn exact_the_target_does_not_run_away() {
        let mut target = HeadingTarget::at(0.0);
        for _ in 0..10_000 {
            target.wanted_rate(&settings(), [3.0, 0.0], H);
        }
        // 1/P = 1 rad/s, a_c = 0.5 rad/s^2: 0.5/4/2 + 1/(2 0.5) rad, more than 45 degrees.
        assert!((target.heading_rad - core::f64::consts::FRAC_PI_4).abs() < 1e-12);
        let quick = TargetSettings { rate_gain_s: 5.0, ..settings() };
        // 1/P = 0.2 rad/s, below 0.25: 0.2/2 rad.
        assert!((quick.largest_error_rad(stopping(1.0)) - 0.1).abs() < 1e-12);
    }
}
