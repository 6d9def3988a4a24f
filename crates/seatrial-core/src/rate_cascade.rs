//! The heading controllers of ArduPilot's Rover and Sub: heading error to yaw rate, yaw rate to steering.
//!
//! ```text
//! e   = wrap(psi_d - psi)
//! r_d = limit(A e, sqrt(2 |e| a_max))         changes by at most a_max h, stays within r_max
//! t   = t + w_T (r_d - t)                     w = h/(h + 1/(2 pi f)), 1 without a filter
//! x   = x + w_E (t - r - x)
//! d   = d + w_D (x'/h - d)
//! s   = limit(F t + P x + i + D d, s_max),   i = limit(i + I x h, i_max)
//! ```
//!
//! While the steering is at its limit, i only shrinks; where I is 0, so is i. Sub, which has a [`TargetShaping`], has r_d from
//! [`heading_target`](crate::heading_target), no F, and an i that knows no limit but i_max.
//!
//! | symbol | identifier | unit | positive sense |
//! |---|---|---|---|
//! | psi_d, psi | `wanted_rad`, `heading_rad` | rad | as the compass counts |
//! | r | `yaw_rate_rad_s` | rad/s | heading increasing |
//! | s | steering, the result | fraction of full | turns towards increasing heading |
//! | A | `angle_gain_per_s` | 1/s | |
//! | F, P | `feed_forward_s`, `rate_gain_s` | s/rad | |
//! | I | `rate_integral_gain` | 1/rad | |
//! | D | `rate_derivative_gain_s2` | s^2/rad | |
//! | i_max | `integral_limit` | fraction of full | |
//! | f_T, f_E, f_D | `target_filter_hz`, `error_filter_hz`, `derivative_filter_hz` | Hz | 0: no filter |
//! | s_max | `steering_limit` | fraction of full | 0: 1 |
//! | r_max, a_max | `rate_limit_rad_s`, `acceleration_limit_rad_s2` | rad/s, rad/s^2 | 0: no limit |
//!
//! Source: the documented behaviour of AR_AttitudeControl and AC_PID in ArduPilot 4.6. Not modelled are its limit of the slew
//! rate (`SMAX`), its notch filters and its limit of the lateral acceleration. A number that is not finite gives no steering.

use crate::Real;
use crate::heading_target::{HeadingTarget, TargetSettings, TargetShaping};

/// Gains, filters and limits of the cascade.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CascadeSettings<T> {
    /// A, 1/s.
    pub angle_gain_per_s: T,
    /// F, s/rad.
    pub feed_forward_s: T,
    /// P, s/rad.
    pub rate_gain_s: T,
    /// I, 1/rad.
    pub rate_integral_gain: T,
    /// D, s^2/rad.
    pub rate_derivative_gain_s2: T,
    /// i_max.
    pub integral_limit: T,
    /// f_T, Hz.
    pub target_filter_hz: T,
    /// f_E, Hz.
    pub error_filter_hz: T,
    /// f_D, Hz.
    pub derivative_filter_hz: T,
    /// r_max, rad/s.
    pub rate_limit_rad_s: T,
    /// a_max, rad/s^2.
    pub acceleration_limit_rad_s2: T,
    /// s_max: more than 1 where the outputs make less of the steering, as Rover's do at speed.
    pub steering_limit: T,
    /// Sub's way to the wanted heading; `None` is Rover's.
    pub shaping: Option<TargetShaping<T>>,
}

/// The cascade at work.
#[derive(Clone, Copy, Debug)]
pub struct RateCascade<T> {
    settings: CascadeSettings<T>,
    state: Option<State<T>>,
}

#[derive(Clone, Copy, Debug)]
struct State<T> {
    wanted_rate: T,
    heading: HeadingTarget<T>,
    target: T,
    error: T,
    derivative: T,
    integral: T,
    is_limited: bool,
}

impl<T: Real> RateCascade<T> {
    /// One that has not steered yet.
    pub fn new(settings: CascadeSettings<T>) -> Self {
        Self { settings, state: None }
    }

    /// Takes other settings, the steering going on.
    ///
    /// ```
    /// use seatrial_core::{CascadeSettings, RateCascade};
    ///
    /// let of = |rate_integral_gain| CascadeSettings {
    ///     angle_gain_per_s: 1.0,
    ///     rate_integral_gain,
    ///     integral_limit: 1.0,
    ///     ..CascadeSettings::default()
    /// };
    /// let mut cascade = RateCascade::new(of(0.5));
    /// let first: f64 = cascade.step(0.2, 0.0, 0.0, 0.1);
    /// // The integral goes on from where it stood: 0.5 and 1.0 times 0.2 rad/s times 0.1 s.
    /// cascade.set(of(1.0));
    /// assert!((cascade.step(0.2, 0.0, 0.0, 0.1) - first - 0.02).abs() < 1e-12);
    /// ```
    pub fn set(&mut self, settings: CascadeSettings<T>) {
        self.settings = settings;
    }

    /// The steering for the next `interval_s`, a fraction of full.
    ///
    /// ```
    /// use seatrial_core::{CascadeSettings, RateCascade};
    ///
    /// let settings =
    ///     CascadeSettings { angle_gain_per_s: 1.0, rate_gain_s: 0.5, ..CascadeSettings::default() };
    /// // 0.2 rad to go at a yaw rate of 0.1 rad/s: 0.5 (0.2 - 0.1).
    /// let steering: f64 = RateCascade::new(settings).step(0.2, 0.0, 0.1, 0.02);
    /// assert!((steering - 0.05).abs() < 1e-12);
    /// // A number that is not finite gives no steering.
    /// assert_eq!(RateCascade::new(settings).step(f64::NAN, 0.0, 0.1, 0.02), 0.0);
    /// ```
    pub fn step(&mut self, wanted_rad: T, heading_rad: T, yaw_rate_rad_s: T, interval_s: T) -> T {
        let s = &self.settings;
        let is_first = self.state.is_none();
        let mut state = self.state.unwrap_or(State {
            wanted_rate: yaw_rate_rad_s,
            heading: HeadingTarget::at(heading_rad),
            target: T::ZERO,
            error: T::ZERO,
            derivative: T::ZERO,
            integral: T::ZERO,
            is_limited: false,
        });
        state.wanted_rate = match s.leading() {
            Some(leading) => {
                let headings = [wanted_rad, heading_rad];
                state.heading.wanted_rate(&leading, headings, interval_s)
            }
            None => {
                s.wanted_rate((wanted_rad - heading_rad).wrapped(), state.wanted_rate, interval_s)
            }
        };
        let error_before = state.error;
        if is_first {
            state.target = state.wanted_rate;
            state.error = state.target - yaw_rate_rad_s;
        } else {
            let wanted = state.wanted_rate - state.target;
            state.target += weight(s.target_filter_hz, interval_s) * wanted;
            let found = state.target - yaw_rate_rad_s - state.error;
            state.error += weight(s.error_filter_hz, interval_s) * found;
            let slope = (state.error - error_before) / interval_s;
            state.derivative +=
                weight(s.derivative_filter_hz, interval_s) * (slope - state.derivative);
        }
        let grown = state.integral + s.rate_integral_gain * state.error * interval_s;
        if !state.is_limited || grown.abs() < state.integral.abs() {
            state.integral = grown.limited_to(s.integral_limit);
        }
        if s.rate_integral_gain == T::ZERO {
            state.integral = T::ZERO;
        }
        let asked = s.feed_forward_s * state.target
            + s.rate_gain_s * state.error
            + state.integral
            + s.rate_derivative_gain_s2 * state.derivative;
        if !asked.is_finite() {
            self.state = None;
            return T::ZERO;
        }
        let limit = match s.steering_limit > T::ZERO {
            true => s.steering_limit,
            false => T::ONE,
        };
        state.is_limited = asked.abs() > limit && s.shaping.is_none();
        self.state = Some(state);
        asked.limited_to(limit)
    }
}

impl<T: Real> CascadeSettings<T> {
    /// (F + P)/I: how long the integral takes to find a steady steering, while F and P hold the heading beside the wanted one, s.
    /// `None` without an integral.
    ///
    /// ```
    /// use seatrial_core::CascadeSettings;
    ///
    /// let settings = CascadeSettings {
    ///     feed_forward_s: 0.2,
    ///     rate_gain_s: 0.3,
    ///     rate_integral_gain: 0.25,
    ///     ..CascadeSettings::default()
    /// };
    /// assert_eq!(settings.integral_time_s(), Some(2.0));
    /// assert_eq!(CascadeSettings::<f64>::default().integral_time_s(), None);
    /// ```
    pub fn integral_time_s(&self) -> Option<T> {
        let time_s = (self.feed_forward_s + self.rate_gain_s) / self.rate_integral_gain;
        (self.rate_integral_gain > T::ZERO).then_some(time_s)
    }

    fn leading(&self) -> Option<TargetSettings<T>> {
        Some(TargetSettings {
            angle_gain_per_s: self.angle_gain_per_s,
            rate_gain_s: self.rate_gain_s,
            rate_limit_rad_s: self.rate_limit_rad_s,
            acceleration_limit_rad_s2: self.acceleration_limit_rad_s2,
            shaping: self.shaping?,
        })
    }

    /// r_d, rad/s.
    fn wanted_rate(&self, error_rad: T, before_rad_s: T, interval_s: T) -> T {
        let mut rate = self.angle_gain_per_s * error_rad;
        let acceleration = self.acceleration_limit_rad_s2;
        if acceleration > T::ZERO {
            rate = rate.limited_to((T::of(2.0) * error_rad.abs() * acceleration).sqrt());
            rate = before_rad_s + (rate - before_rad_s).limited_to(acceleration * interval_s);
        }
        if self.rate_limit_rad_s > T::ZERO {
            rate = rate.limited_to(self.rate_limit_rad_s);
        }
        rate
    }
}

/// w of a first-order low pass; 1 without one.
fn weight<T: Real>(frequency_hz: T, interval_s: T) -> T {
    if frequency_hz <= T::ZERO {
        return T::ONE;
    }
    interval_s / (interval_s + T::ONE / (T::of(2.0) * T::PI * frequency_hz))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings() -> CascadeSettings<f64> {
        CascadeSettings {
            angle_gain_per_s: 2.0,
            feed_forward_s: 0.2,
            rate_gain_s: 0.4,
            rate_integral_gain: 0.5,
            integral_limit: 1.0,
            ..CascadeSettings::default()
        }
    }

    /// Without filters and limits: F A e + P (A e - r) + I (A e - r) h.
    #[test]
    fn exact_the_first_steering_is_the_sum_of_its_parts() {
        let mut cascade = RateCascade::new(settings());
        let steering = cascade.step(0.1, 0.0, 0.05, 0.02);
        let expected = 0.2 * 0.2 + 0.4 * 0.15 + 0.5 * 0.15 * 0.02;
        assert!((steering - expected).abs() < 1e-15, "{steering}");
    }

    #[test]
    fn exact_the_turn_rate_is_limited_in_size_and_change() {
        let limited = CascadeSettings {
            rate_gain_s: 0.0,
            rate_integral_gain: 0.0,
            feed_forward_s: 1.0,
            rate_limit_rad_s: 0.3,
            acceleration_limit_rad_s2: 0.5,
            ..settings()
        };
        let mut cascade = RateCascade::new(limited);
        // From rest by 0.5 rad/s^2 for 0.1 s at a time, up to 0.3 rad/s.
        let rates: [f64; 8] = core::array::from_fn(|_| cascade.step(1.0, 0.0, 0.0, 0.1));
        for (rate, expected) in rates.iter().zip([0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.3, 0.3]) {
            assert!((rate - expected).abs() < 1e-12, "{rates:?}");
        }
    }

    /// Steering at its limit does not wind the integral up: it leaves the limit as soon as the error turns.
    #[test]
    fn exact_the_integral_does_not_grow_at_the_limit() {
        let mut cascade = RateCascade::new(CascadeSettings { rate_gain_s: 10.0, ..settings() });
        for _ in 0..1000 {
            assert_eq!(cascade.step(1.0, 0.0, 0.0, 0.02), 1.0);
        }
        assert!(cascade.step(0.0, 0.0, 0.01, 0.02) < 0.0);
    }

    /// On a boat that needs steering to go straight, and turns at once as it is steered, the heading error falls by e in that time.
    #[test]
    fn exact_the_integral_learns_in_its_time() {
        let settings = settings();
        let time_s = settings.integral_time_s().unwrap();
        assert!((time_s - 1.2).abs() < 1e-12, "{time_s}");
        let (needed, interval_s) = (0.1, 1e-3);
        let mut cascade = RateCascade::new(settings);
        // Held where F and P give what is needed, the boat does not turn: that heading error shrinks as the integral grows.
        let mut error_rad = needed / (0.6 * settings.angle_gain_per_s);
        let first_rad = error_rad;
        for _ in 0..(time_s / interval_s) as usize {
            let lacking = needed - cascade.step(error_rad, 0.0, 0.0, interval_s);
            error_rad += lacking / (0.6 * settings.angle_gain_per_s);
        }
        assert!((error_rad / first_rad - (-1.0_f64).exp()).abs() < 0.01);
        let without = CascadeSettings { rate_integral_gain: 0.0, ..settings };
        assert_eq!(without.integral_time_s(), None);
    }

    /// Sub's integral goes on at the limit of the steering, and its first steering is P A e: the heading held is the vehicle's own.
    #[test]
    fn exact_with_a_target_of_its_own_nothing_stops_the_integral() {
        let mut cascade = RateCascade::new(CascadeSettings {
            rate_gain_s: 10.0,
            feed_forward_s: 0.0,
            integral_limit: 0.3,
            rate_limit_rad_s: 0.5,
            shaping: Some(TargetShaping::default()),
            ..settings()
        });
        for _ in 0..1000 {
            cascade.step(1.0, 0.0, 0.0, 0.02);
        }
        // e_max is 1/(P A) = 0.05 rad; the target still moves at 0.5 rad/s.
        let state = cascade.state.unwrap();
        assert_eq!(state.integral, 0.3);
        assert!((state.target - 0.6).abs() < 1e-9, "{state:?}");
    }

    #[test]
    fn exact_the_steering_has_the_limit_of_its_settings() {
        for (steering_limit, expected) in [(0.0, 1.0), (1.0, 1.0), (1.5, 1.5), (40.0, 6.0)] {
            let mut cascade = RateCascade::new(CascadeSettings {
                feed_forward_s: 6.0,
                rate_gain_s: 0.0,
                rate_integral_gain: 0.0,
                angle_gain_per_s: 1.0,
                steering_limit,
                ..settings()
            });
            assert_eq!(cascade.step(1.0, 0.0, 0.0, 0.02), expected);
        }
    }

    #[test]
    fn exact_what_is_not_finite_gives_no_steering() {
        let mut cascade = RateCascade::new(settings());
        assert_eq!(cascade.step(1.0, f64::NAN, 0.0, 0.02), 0.0);
        assert!(cascade.step(1.0, 0.0, 0.0, 0.02) > 0.0);
    }
}
