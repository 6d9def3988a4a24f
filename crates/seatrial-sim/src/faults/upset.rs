//! What is wrong with a vehicle at a moment.

use seatrial_core::YawModel;

/// What is wrong with a vehicle at a moment; [`Default`] is nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Upset {
    /// The compass repeats its last reading.
    pub compass_frozen: bool,
    /// The compass gives no number.
    pub compass_lost: bool,
    /// The compass is off by this, rad.
    pub compass_error_rad: f64,
    /// The compass runs away at this rate, rad/s.
    pub compass_drift_rad_s: f64,
    /// No depth is measured.
    pub depth_lost: bool,
    /// The rudder stays where it is.
    pub rudder_jammed: bool,
    /// The rudder goes the other way.
    pub rudder_reversed: bool,
    /// The rudder stands off its command by this, rad.
    pub rudder_offset_rad: f64,
    /// The part of the thrust setting that is left.
    pub thrust_left: f64,
    /// The vehicle's operator steers.
    pub is_taken_over: bool,
    /// What is wrong with the body or new in the water.
    pub damage: Damage,
}

/// What changed of the body and the water around it; [`Default`] is nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Damage {
    /// The part of the rudders' area that is gone.
    pub lost_rudder_area: f64,
    /// The moment of inertia in yaw, with the water's, as a multiple of what it was.
    pub yaw_inertia_factor: f64,
    /// On top of the current, towards north and east, m/s.
    pub current_m_s: [f64; 2],
}

impl Default for Upset {
    fn default() -> Self {
        Self {
            compass_frozen: false,
            compass_lost: false,
            compass_error_rad: 0.0,
            compass_drift_rad_s: 0.0,
            depth_lost: false,
            rudder_jammed: false,
            rudder_reversed: false,
            rudder_offset_rad: 0.0,
            thrust_left: 1.0,
            is_taken_over: false,
            damage: Damage::default(),
        }
    }
}

impl Upset {
    /// The yaw model of a body as its samples show it: the rudder does not do what it is told to, and the compass
    /// drifts at the rate d, psi_m'' = a22 (psi_m' - d) + b2 (+-delta + e) + C0.
    pub fn apparent(&self, body: YawModel<f64>) -> YawModel<f64> {
        let sense = if self.rudder_reversed { -1.0 } else { 1.0 };
        YawModel {
            b2_per_s2: sense * body.b2_per_s2,
            c0_rad_per_s2: body.c0_rad_per_s2 + body.b2_per_s2 * self.rudder_offset_rad
                - body.a22_per_s * self.compass_drift_rad_s,
            ..body
        }
    }
}

impl Default for Damage {
    fn default() -> Self {
        Self { lost_rudder_area: 0.0, yaw_inertia_factor: 1.0, current_m_s: [0.0; 2] }
    }
}
