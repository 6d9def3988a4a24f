//! What a record of a training stage can determine.

use nalgebra::Matrix3;
use seatrial_core::{Sample, Side, Turn, YawModel};
use serde::Serialize;

use super::PriorSpeed;
use crate::gain_allowance::{DAMPING_RATIO, GainAllowance, sampled};
use crate::identify::cramer_rao::cramer_rao_bound;
use crate::propagation::{NORMAL_95, interval_95};
use crate::record::median_interval_s;
use crate::verdict::{WIDEST_A22, WIDEST_B2};

/// What a training stage will determine of a22, b2 and C0, in this order, and of what follows from them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ExpectedAccuracy {
    /// Standard deviations, 1/s, 1/s^2, rad/s^2.
    pub standard_deviation: [f64; 3],
    /// Half widths of the 95 % intervals, 1/s, 1/s^2, rad/s^2.
    pub half_width_95: [f64; 3],
    /// The half widths as fractions of the parameters; `None` of a parameter that is 0.
    pub relative_half_width_95: [Option<f64>; 3],
    /// K_p for a damping ratio of 1/sqrt(2), with what it will have to allow for.
    pub proportional_gain: Option<PredictedQuantity>,
    /// Radius of the steady circle under the full rudder to starboard and to port, m.
    pub steady_turning_radius_m: [Option<PredictedQuantity>; 2],
}

/// A quantity of the model believed in and how well it will be uncertainty.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PredictedQuantity {
    /// The quantity.
    pub value: f64,
    /// Half width of its 95 % interval.
    pub half_width_95: f64,
}

impl ExpectedAccuracy {
    /// What these samples determine at best. `None` where they do not excite the model.
    pub fn of(samples: &[Sample<f64>], speed: &PriorSpeed, rudder_limit_rad: f64) -> Option<Self> {
        let model = speed.model;
        let covariance = cramer_rao_bound(samples, model, speed.noise)?;
        let standard_deviation = core::array::from_fn(|i| covariance[(i, i)].sqrt());
        let half_width_95 = standard_deviation.map(|deviation| NORMAL_95 * deviation);
        let theta = model.theta();
        let least_damped_per_s = model.a22_per_s + half_width_95[0];
        let allowance = GainAllowance {
            damping_per_s: GainAllowance::damping_per_s(model.a22_per_s, least_damped_per_s),
            timing: sampled(median_interval_s(samples)?, 0.0),
        };
        let predicted = |quantity: &dyn Fn(&YawModel<f64>) -> Option<f64>| {
            predicted(&model, &covariance, quantity)
        };
        Some(Self {
            standard_deviation,
            half_width_95,
            relative_half_width_95: core::array::from_fn(|i| {
                let relative = half_width_95[i] / theta[i].abs();
                relative.is_finite().then_some(relative)
            }),
            proportional_gain: predicted(&|model| {
                let gain = allowance.design(model, DAMPING_RATIO);
                Some(gain.ok()?.proportional_gain)
            }),
            steady_turning_radius_m: [Side::Starboard, Side::Port].map(|side| {
                predicted(&|model| {
                    let turn = Turn::new(model, rudder_limit_rad, side).ok()?;
                    Some(turn.steady_turning_radius_m(speed.surge_speed_m_s?))
                })
            }),
        })
    }

    /// Will the intervals be narrow enough for the model to be accepted?
    pub fn is_enough(&self) -> bool {
        let [a22, b2, _] = self.relative_half_width_95;
        a22.is_some_and(|width| width <= WIDEST_A22) && b2.is_some_and(|width| width <= WIDEST_B2)
    }
}

fn predicted(
    model: &YawModel<f64>,
    covariance: &Matrix3<f64>,
    quantity: &dyn Fn(&YawModel<f64>) -> Option<f64>,
) -> Option<PredictedQuantity> {
    let [low, high] = interval_95(model, &(*covariance).into(), quantity)?;
    Some(PredictedQuantity { value: quantity(model)?, half_width_95: 0.5 * (high - low) })
}

/// Half widths of the 95 % intervals of a22 and b2 as fractions of them; infinite where nothing is determined.
pub(super) fn relative_half_widths(samples: &[Sample<f64>], speed: &PriorSpeed) -> [f64; 2] {
    let theta = speed.model.theta();
    cramer_rao_bound(samples, speed.model, speed.noise).map_or([f64::INFINITY; 2], |covariance| {
        core::array::from_fn(|i| NORMAL_95 * covariance[(i, i)].sqrt() / theta[i].abs())
    })
}
