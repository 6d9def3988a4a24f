//! The misfit of a first-order model: a disturbance, a lagging rudder, or a vehicle of higher order.

use seatrial_core::Sample;

use super::lag::LagTest;
use super::second_order;
use crate::identification::Refined;
use crate::sway_yaw::SecondOrder;

/// A disturbance of more than this share of the rudder's own effect may be none: the model may miss something.
const LARGE_DISTURBANCE_SHARE: f64 = 0.1;

/// The share of the rudder's effect, b2 times its amplitude, that the disturbance would have to have.
///
/// Sway or a slow servo pass for a disturbance that follows the rudder, against the assumption of the
/// interval, and the likelihood fits the next instant rather than the manoeuvre. [`second_order::fit`] distinguishes
/// them from a strong disturbance.
pub fn disturbance_share(refined: &Refined, rudder_amplitude_rad: f64) -> f64 {
    refined.disturbance_rad_s2 / (refined.model.b2_per_s2.abs() * rudder_amplitude_rad)
}

/// Is a [`disturbance_share`] so large that the model may miss something?
pub fn is_large_share(share: f64) -> bool {
    share > LARGE_DISTURBANCE_SHARE
}

/// Evidence, over what names a structure, that a lag must have which passes for a small disturbance: among many sound
/// records the price that names a structure is now and then exceeded by chance.
const PRICE_OF_A_HIDDEN_LAG: f64 = 1.5;

/// The misfit of a first-order model where it is large or looks like a lagging rudder: a strong disturbance, or a vehicle
/// that is not of first order.
pub struct Misfit {
    /// The share of the rudder's own effect.
    pub share: f64,
    /// The model of the order that the record supports.
    second_order: Option<SecondOrder>,
}

impl Misfit {
    /// The misfit of a refined model. `None` where it is small and nothing looks like a lagging rudder.
    pub fn of(
        samples: &[Sample<f64>],
        refined: &Refined,
        rudder_amplitude_rad: f64,
        lag: Option<LagTest>,
    ) -> Option<Self> {
        let share = disturbance_share(refined, rudder_amplitude_rad);
        let worth_a_look = is_large_share(share) || lag.is_some_and(|lag| lag.is_suspicious());
        worth_a_look.then(|| Self {
            share,
            second_order: second_order::fit(samples).ok(),
        })
    }

    /// May a disturbance of this share be none?
    pub fn is_large(&self) -> bool {
        is_large_share(self.share)
    }

    /// A small disturbance passes for structure only where a lag explains it beyond doubt.
    pub fn is_structural(&self) -> bool {
        match &self.second_order {
            Some(estimate) if self.is_large() => estimate.order.leans_beyond_first_order(),
            Some(estimate) => {
                estimate.is_first_order_behind_a_lag()
                    && estimate.order.evidence() > PRICE_OF_A_HIDDEN_LAG * estimate.order.threshold
            }
            None => self.is_large(),
        }
    }
    /// The model beyond the first order, where the record supports one.
    pub fn higher_order(self) -> Option<SecondOrder> {
        self.second_order
            .filter(|estimate| estimate.order.exceeds_first_order())
    }
}
