//! Does a model tell what the boat did with its old gains?
//!
//! ```text
//! psi(t) = a + b t + k psi_m(t),   psi_m the model's heading under the steering that was recorded
//! ```
//!
//! by least squares over all steps, a and b for each. The model is this boat's where k is about 1: half of it for one that
//! turns twice as well as the boat, negative for a reversed one.

use serde::Serialize;

use super::StepInstant;
use super::boat::Boat;

/// What k may be.
const LEAST_SCALE: f64 = 0.7;
const MOST_SCALE: f64 = 1.4;
/// The share of the heading's variance that the model must explain.
const LEAST_EXPLAINED: f64 = 0.8;
/// Less heading than this tells nothing, rad: standard deviation of what the model makes of the steering.
const TELLING_RAD: f64 = 0.03;

/// What the record of the old gains says of the model.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "found")]
pub enum ModelCheck {
    /// It is this boat's.
    Holds {
        /// k.
        scale: f64,
        /// Share of the heading's variance.
        explained: f64,
    },
    /// It is not.
    Fails {
        /// k.
        scale: f64,
        /// Share of the heading's variance.
        explained: f64,
    },
    /// The boat was steered too little to tell.
    Undecided,
}

/// Holds a model against the record of steps.
///
/// ```
/// use seatrial::gains::commission::{Boat, ModelCheck, StepTest, check_model};
/// use seatrial_core::{CascadeSettings, YawModel};
///
/// let boat = |b2| Boat { model: YawModel::from_theta([-1.0, b2, 0.0]), ..Boat::default() };
/// let settings =
///     CascadeSettings { angle_gain_per_s: 0.4, feed_forward_s: 1.0, ..CascadeSettings::default() };
/// let test = StepTest {
///     step_rad: 0.5,
///     settle_s: 5.0,
///     hold_s: 20.0,
///     sample_interval_s: 0.1,
///     loop_interval_s: 0.02,
/// };
/// let legs = test.simulate(&boat(1.0), &settings, 1);
/// assert!(matches!(check_model(&boat(1.0), &legs), ModelCheck::Holds { .. }));
/// // A model that turns the other way is not this boat's.
/// assert!(matches!(check_model(&boat(-1.0), &legs), ModelCheck::Fails { .. }));
/// ```
pub fn check_model(boat: &Boat, legs: &[Vec<StepInstant>]) -> ModelCheck {
    let mut sums = [0.0; 3];
    let mut count = 0.0;
    for (k, leg) in legs.iter().enumerate() {
        let way = if k % 2 == 0 { 1.0 } else { -1.0 };
        let predicted = without_line(&headings(boat, leg, way));
        let found = without_line(&leg.iter().map(|i| i.turned_rad).collect::<Vec<_>>());
        for (model, heading) in predicted.iter().zip(&found) {
            sums[0] += model * model;
            sums[1] += model * heading;
            sums[2] += heading * heading;
            count += 1.0;
        }
    }
    let [model_square, product, heading_square] = sums;
    let deviation_rad = (model_square / f64::max(count, 1.0)).sqrt();
    let heading_rad = (heading_square / f64::max(count, 1.0)).sqrt();
    if !deviation_rad.is_finite() || deviation_rad.max(heading_rad) < TELLING_RAD {
        return ModelCheck::Undecided;
    }
    let scale = product / model_square.max(f64::MIN_POSITIVE);
    let explained = product * product / (model_square * heading_square).max(f64::MIN_POSITIVE);
    match (LEAST_SCALE..=MOST_SCALE).contains(&scale) && explained >= LEAST_EXPLAINED {
        true => ModelCheck::Holds { scale, explained },
        false => ModelCheck::Fails { scale, explained },
    }
}

/// The model's heading under the steering of a leg, from the yaw rate at its start, rad.
fn headings(boat: &Boat, leg: &[StepInstant], way: f64) -> Vec<f64> {
    let mut state = seatrial_core::model::YawState {
        heading_rad: 0.0,
        yaw_rate_rad_s: leg.first().map_or(0.0, |first| first.yaw_rate_rad_s),
    };
    let model =
        seatrial_core::YawModel { c0_rad_per_s2: way * boat.model.c0_rad_per_s2, ..boat.model };
    let mut rudder = leg.first().map_or(0.0, |first| first.steering);
    let mut headings = Vec::with_capacity(leg.len());
    for (k, instant) in leg.iter().enumerate() {
        headings.push(state.heading_rad);
        let Some(next) = leg.get(k + 1) else {
            break;
        };
        let interval_s = next.time_s - instant.time_s;
        let asked = late(leg, k, boat.delay_s);
        let left = match boat.lag_s > 0.0 {
            true => libm::exp(-interval_s / boat.lag_s),
            false => 0.0,
        };
        let after = asked + (rudder - asked) * left;
        let held = if left > 0.0 { 0.5 * (rudder + after) } else { asked };
        state = model.advance(state, held, interval_s);
        rudder = after;
    }
    headings
}

/// The steering that was asked for this long before a sample.
fn late(leg: &[StepInstant], k: usize, delay_s: f64) -> f64 {
    let due_s = leg[k].time_s - delay_s;
    let asked = leg[..=k].iter().rev().find(|i| i.time_s <= due_s + 1e-9);
    asked.unwrap_or(&leg[0]).steering
}

/// A series less its straight line.
fn without_line(series: &[f64]) -> Vec<f64> {
    let count = series.len() as f64;
    let middle = 0.5 * (count - 1.0);
    let mean = series.iter().sum::<f64>() / count.max(1.0);
    let (mut product, mut square) = (0.0, 0.0);
    for (k, value) in series.iter().enumerate() {
        let from_middle = k as f64 - middle;
        product += from_middle * value;
        square += from_middle * from_middle;
    }
    let slope = if square > 0.0 { product / square } else { 0.0 };
    let line = |k: usize| mean + slope * (k as f64 - middle);
    let values = series.iter().enumerate();
    values.map(|(k, value)| value - line(k)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gains::commission::StepTest;
    use seatrial_core::{CascadeSettings, YawModel};

    fn steps(boat: &Boat) -> [Vec<StepInstant>; 2] {
        let settings = CascadeSettings {
            angle_gain_per_s: 0.4,
            feed_forward_s: 0.5,
            rate_gain_s: 0.1,
            ..CascadeSettings::default()
        };
        let test = StepTest {
            step_rad: 0.5,
            settle_s: 5.0,
            hold_s: 15.0,
            sample_interval_s: 0.05,
            loop_interval_s: 0.05,
        };
        test.simulate(boat, &settings, 3)
    }

    fn boat(theta: [f64; 3]) -> Boat {
        Boat {
            model: YawModel::from_theta(theta),
            lag_s: 0.1,
            heading_noise_rad: 0.009,
            rate_noise_rad_s: 0.005,
            ..Boat::default()
        }
    }

    #[test]
    fn exact_its_own_model_holds_and_others_fail() {
        let own = [-1.0, 1.0, 0.02];
        let legs = steps(&boat(own));
        let check = |theta| check_model(&boat(theta), &legs);
        assert!(matches!(check(own), ModelCheck::Holds { .. }), "{:?}", check(own));
        // Twice and half as willing to turn, reversed, and a boat of another size.
        for other in [[-1.0, 2.0, 0.02], [-1.0, 0.5, 0.01], [-1.0, -1.0, 0.0], [-0.2, 0.1, 0.0]] {
            assert!(
                matches!(check(other), ModelCheck::Fails { .. }),
                "{other:?}: {:?}",
                check(other)
            );
        }
    }

    #[test]
    fn exact_a_boat_that_was_not_steered_tells_nothing() {
        let legs = vec![vec![StepInstant::default(); 100]];
        assert_eq!(check_model(&boat([-1.0, 1.0, 0.0]), &legs), ModelCheck::Undecided);
        assert_eq!(check_model(&boat([-1.0, 1.0, 0.0]), &[]), ModelCheck::Undecided);
    }
}
