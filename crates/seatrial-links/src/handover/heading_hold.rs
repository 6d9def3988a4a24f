//! Holding a heading while the trial has the rudder.

use seatrial_core::Real;

/// ```text
/// delta = -s (K (psi - psi_d) + D r), limited to +-delta_max
/// ```
///
/// | symbol | identifier | unit |
/// |---|---|---|
/// | K | `gain` | 1 |
/// | D | `yaw_rate_gain_s` | s |
/// | delta_max | `largest_rad` | rad |
/// | s | `is_reversed` | -1 where a positive rudder turns to port, else 1 |
#[derive(Clone, Copy, Debug)]
pub(crate) struct HeadingHold {
    /// Rudder per heading error.
    pub gain: f64,
    /// Rudder per yaw rate, s.
    pub yaw_rate_gain_s: f64,
    /// Largest rudder, rad.
    pub largest_rad: f64,
    /// A positive rudder turns to port.
    pub is_reversed: bool,
}

impl HeadingHold {
    /// The rudder at a heading and yaw rate, rad; 0 where they are not known.
    pub fn rudder_rad(&self, heading_rad: f64, yaw_rate_rad_s: f64, wanted_rad: f64) -> f64 {
        let error_rad = Real::wrapped(heading_rad - wanted_rad);
        let sense = if self.is_reversed { -1.0 } else { 1.0 };
        let rudder_rad = -sense * (self.gain * error_rad + self.yaw_rate_gain_s * yaw_rate_rad_s);
        if rudder_rad.is_finite() {
            rudder_rad.clamp(-self.largest_rad, self.largest_rad)
        } else {
            0.0
        }
    }
}
