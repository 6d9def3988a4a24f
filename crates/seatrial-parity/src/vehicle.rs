//! The vehicle of the rehearsal: a first-order plant behind noisy sensors and a link that spoils samples.

use seatrial_core::model::YawState;
use seatrial_core::{Action, Real, Sample, Steering, YawModel};

/// Time between samples, s.
pub const INTERVAL_S: f64 = 0.05;
/// Half width of the compass noise, rad.
const COMPASS_NOISE_RAD: f64 = 0.002;
/// Rudder per heading error of the vehicle's own controller, and its limit, rad.
const HOLD_GAIN: f64 = 0.3;
const RUDDER_LIMIT_RAD: f64 = 0.2;

/// A vehicle of the paper's damping whose rudder authority and speed follow the thrust.
pub struct Vehicle<T> {
    state: YawState<T>,
    time_s: f64,
    steering: Steering<T>,
    thrust: T,
    noise: u32,
    number: u32,
}

impl<T: Real> Vehicle<T> {
    /// On its way, heading nearly south, so that the compass wraps.
    pub fn new() -> Self {
        Self {
            state: YawState { heading_rad: T::of(3.1), yaw_rate_rad_s: T::ZERO },
            time_s: 1000.0,
            steering: Steering::Rudder(T::ZERO),
            thrust: T::of(0.7),
            noise: 1,
            number: 0,
        }
    }

    /// Carries out an action from the next sample on.
    pub fn carry_out(&mut self, action: &Action<T>) {
        self.steering = action.steering;
        if let Some(thrust) = action.thrust {
            self.thrust = thrust;
        }
    }

    /// The next sample as the link delivers it.
    pub fn sample(&mut self) -> Sample<T> {
        let mut sample = self.true_sample();
        match self.number % 101 {
            // A row is lost.
            31 => sample = self.true_sample(),
            53 => sample.heading_rad = T::of(f64::NAN),
            71 => sample.heading_rad = (sample.heading_rad + T::of(2.0)).wrapped(),
            89 => sample.time_s -= INTERVAL_S,
            _ => {}
        }
        sample
    }

    fn true_sample(&mut self) -> Sample<T> {
        let surge_speed_m_s = T::of(2.0) * self.thrust;
        let b2_per_s2 = T::of(0.42) * surge_speed_m_s * surge_speed_m_s;
        let model = YawModel::from_theta([T::of(-1.07), b2_per_s2, T::of(0.012)]);
        let rudder_rad = match self.steering {
            Steering::Rudder(rudder_rad) => rudder_rad,
            Steering::HoldHeading(heading_rad) => {
                let error_rad = (heading_rad - self.state.heading_rad).wrapped();
                (T::of(HOLD_GAIN) * error_rad).limited_to(T::of(RUDDER_LIMIT_RAD))
            }
        };
        let sample = Sample {
            time_s: self.time_s,
            heading_rad: (self.state.heading_rad + self.compass_noise_rad()).wrapped(),
            rudder_rad,
            surge_speed_m_s: Some(surge_speed_m_s),
            depth_m: Some(T::of(2.0)),
            altitude_m: Some(T::of(8.0)),
            roll_rad: Some(T::ZERO),
            pitch_rad: Some(T::ZERO),
            yaw_rate_rad_s: Some(self.state.yaw_rate_rad_s),
            ..Sample::default()
        };
        self.state = model.advance(self.state, rudder_rad, T::of(INTERVAL_S));
        self.time_s += INTERVAL_S;
        self.number += 1;
        sample
    }

    /// Uniform noise by the linear congruential generator of Numerical Recipes.
    fn compass_noise_rad(&mut self) -> T {
        self.noise = self.noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let signed = f64::from(self.noise) / f64::from(1_u32 << 31) - 1.0;
        T::of(COMPASS_NOISE_RAD * signed)
    }
}
