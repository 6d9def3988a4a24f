//! A speaking Rover in GUIDED: it steers to the heading and keeps the speed that are sent to it. A speaking Sub in ALT_HOLD: it steers to
//! the heading while a stick gives the thrust.

use seatrial_core::{CascadeSettings, RateCascade, Sample, Vehicle};

use super::defaults::SUB_GAIN;
use super::{Profile, Speaker};
use crate::autopilot::cascade;
use crate::autopilot::heading::{RATES_IGNORED, THRUST_IGNORED};
use crate::link::message::SetAttitudeTarget;

/// Gains of the speed: throttle per m/s, and per m.
const SPEED_GAIN: f64 = 0.2;
const SPEED_INTEGRAL_GAIN: f64 = 0.2;
/// A target is forgotten after this long, s: by Rover, and by Sub.
const TARGET_S: f64 = 3.0;
const SUB_TARGET_S: f64 = 5.0;

/// What a speaking vehicle is asked for in GUIDED, and how it does it.
#[derive(Debug, Default)]
pub(super) struct Guided {
    /// When it was asked for, s, the heading, rad, and the speed as a fraction of its default.
    target: Option<(f64, f64, f64)>,
    cascade: Option<RateCascade<f64>>,
    throttle: f64,
    /// Steering and thrust that it asks its outputs for.
    pub asked: Option<[f64; 2]>,
}

impl<V: Vehicle<f64>> Speaker<V> {
    pub(super) fn take_target(&mut self, target: &SetAttitudeTarget) {
        let is_taken = match self.profile {
            Profile::Rover => target.type_mask == RATES_IGNORED,
            Profile::Sub => target.type_mask & THRUST_IGNORED != 0,
            Profile::Px4 | Profile::Generic => false,
        };
        if is_taken {
            let [w, x, y, z] = target.quaternion.map(f64::from);
            let heading_rad = (2.0 * (w * z + x * y)).atan2(1.0 - 2.0 * (y * y + z * z));
            self.guided.target = Some((self.clock_s, heading_rad, target.thrust.into()));
        }
    }

    /// Asks for steering and thrust towards the target, and for none in another mode, without a target or with an old one.
    pub(super) fn guide(&mut self, sample: &Sample<f64>) {
        let is_guided = self.is_armed && self.profile.heading_mode() == Some(self.mode);
        let target = self.guided.target.filter(|_| is_guided);
        let longest_s = match self.profile {
            Profile::Sub => SUB_TARGET_S,
            _ => TARGET_S,
        };
        let recent = target.filter(|(given_s, ..)| self.clock_s - given_s <= longest_s);
        let settings = cascade::settings(self.profile, |name| self.parameter(name).map(f64::from));
        let (Some((_, heading_rad, share)), Ok(settings)) = (recent, settings) else {
            // Sub keeps a target in other modes, too.
            let target = self.guided.target.filter(|_| self.profile == Profile::Sub);
            self.guided = Guided { target, ..Guided::default() };
            return;
        };
        let speed_m_s = sample.surge_speed_m_s.unwrap_or(0.0);
        let base_m_s = self.number("MOT_SPD_SCA_BASE");
        let scale = match base_m_s > 0.0 && speed_m_s > base_m_s {
            true => base_m_s / speed_m_s,
            false => 1.0,
        };
        let settings = CascadeSettings { steering_limit: 1.0 / scale, ..settings };
        let helm = self.guided.cascade.get_or_insert_with(|| RateCascade::new(settings));
        helm.set(settings);
        let rate_rad_s = sample.yaw_rate_rad_s.unwrap_or(0.0);
        let steering = helm.step(heading_rad, sample.heading_rad, rate_rad_s, self.interval_s);
        let asked = match self.profile {
            Profile::Sub => {
                let ahead = self.fraction(2);
                [mixed(steering, SUB_GAIN * ahead) / SUB_GAIN, ahead]
            }
            _ => [scale * steering, self.throttle(share, speed_m_s)],
        };
        self.guided.asked = Some(asked);
    }

    fn throttle(&mut self, share: f64, speed_m_s: f64) -> f64 {
        let cruise_m_s = self.number("CRUISE_SPEED");
        let default_m_s = match self.number("WP_SPEED") {
            speed if speed > 0.0 => speed,
            _ => cruise_m_s,
        };
        let wanted_m_s = share * default_m_s;
        let error_m_s = wanted_m_s - speed_m_s;
        let grown = self.guided.throttle + SPEED_INTEGRAL_GAIN * error_m_s * self.interval_s;
        self.guided.throttle = grown.clamp(-1.0, 1.0);
        let base = 0.01 * self.number("CRUISE_THROTTLE") * wanted_m_s / cruise_m_s.max(0.1);
        (base + SPEED_GAIN * error_m_s + self.guided.throttle).clamp(0.0, 1.0)
    }
}

/// The steering that is left of what thrusters are asked for that drive, too: each gives its full and no more, as in ArduPilot's
/// AP_Motors6DOF.cpp, `output_armed_stabilizing_vectored`.
fn mixed(steering: f64, ahead: f64) -> f64 {
    let side = |way: f64| (ahead + way * steering).clamp(-1.0, 1.0);
    0.5 * (side(1.0) - side(-1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Beyond what the way ahead leaves, one side is full and the other goes on by half.
    #[test]
    fn exact_thrusters_that_drive_steer_less() {
        for (steering, expected) in [(0.3, 0.3), (0.6, 0.6), (1.0, 0.8), (-1.0, -0.8)] {
            let found = mixed(steering, 0.4);
            // The last bit of a sum.
            assert!((found - expected).abs() < 1e-15, "{found}");
        }
    }
}
