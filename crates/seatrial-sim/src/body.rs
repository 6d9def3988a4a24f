//! A simulated body as the helm and the instruments see it.

use seatrial_core::Sample;

use crate::faults::Damage;

/// A body that moves.
pub(crate) trait Body {
    /// Where it is and how it moves.
    fn motion(&self) -> Motion;
    /// The body `interval_s` later with constant commands and yaw disturbance.
    fn advance(
        &mut self,
        rudder_command_rad: f64,
        thrust: f64,
        yaw_disturbance_rad_s2: f64,
        interval_s: f64,
    );
    /// What changed of it and of the water around it.
    fn suffer(&mut self, damage: &Damage);
    /// What the vehicle measured: its own controllers go by it.
    fn measured(&mut self, _sample: &Sample<f64>) {}
}

/// The true motion that instruments read.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Motion {
    pub heading_rad: f64,
    pub roll_rad: f64,
    pub pitch_rad: f64,
    pub yaw_rate_rad_s: f64,
    pub surge_speed_m_s: f64,
    pub north_m: f64,
    pub east_m: f64,
    pub depth_m: f64,
    pub altitude_m: Option<f64>,
}
