//! The misfit of a first-order model: a disturbance, a lagging rudder, or a vehicle of higher order.

use crate::identification::Refined;

/// A disturbance of more than this share of the rudder's own effect may be none: the model may miss something.
const LARGE_DISTURBANCE_SHARE: f64 = 0.1;

/// The share of the rudder's effect, b2 times its amplitude, that the disturbance would have to have.
pub fn disturbance_share(refined: &Refined, rudder_amplitude_rad: f64) -> f64 {
    refined.disturbance_rad_s2 / (refined.model.b2_per_s2.abs() * rudder_amplitude_rad)
}

/// Is a [`disturbance_share`] so large that the model may miss something?
pub fn is_large_share(share: f64) -> bool {
    share > LARGE_DISTURBANCE_SHARE
}
