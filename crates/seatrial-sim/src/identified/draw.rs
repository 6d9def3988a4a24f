//! Vehicles drawn from what is known of one, for Monte Carlo and domain randomisation.

use seatrial_core::YawModel;

use super::IdentifiedVehicle;
use crate::sensors::Chance;

impl IdentifiedVehicle {
    /// A vehicle drawn from what is known of this one: at every speed `[a22, b2, C0]` from the normal distribution of its covariance,
    /// the speeds independent of each other, all else as it is. A speed without a covariance keeps its model. A draw in which a22 or b2
    /// has the other sign is drawn again, a hundred times at most. One seed gives one vehicle.
    pub fn drawn(&self, seed: u64) -> Self {
        let [mut chance] = Chance::sources(seed);
        let mut vehicle = self.clone();
        for speed in &mut vehicle.speeds {
            if let Some(covariance) = speed.covariance {
                *speed = speed.with_model(&drawn(&speed.model(), &covariance, &mut chance));
            }
        }
        vehicle
    }
}

/// A model from a normal distribution: the estimate and L times normal deviates, where L L^T is the covariance.
fn drawn(model: &YawModel<f64>, covariance: &[[f64; 3]; 3], chance: &mut Chance) -> YawModel<f64> {
    let factor = factor(covariance);
    let theta = model.theta();
    for _ in 0..100 {
        let normal: [f64; 3] = std::array::from_fn(|_| chance.normal());
        let drawn: [f64; 3] = std::array::from_fn(|i| {
            theta[i] + (0..=i).map(|j| factor[i][j] * normal[j]).sum::<f64>()
        });
        if drawn[0] * theta[0] > 0.0 && drawn[1] * theta[1] > 0.0 {
            return YawModel::from_theta(drawn);
        }
    }
    *model
}

/// The lower triangle L of a covariance L L^T; a direction without variance has none in it either.
fn factor(covariance: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let mut factor = [[0.0; 3]; 3];
    for i in 0..3 {
        for j in 0..=i {
            let known: f64 = (0..j).map(|k| factor[i][k] * factor[j][k]).sum();
            let left = covariance[i][j] - known;
            factor[i][j] = if i == j {
                left.max(0.0).sqrt()
            } else if factor[j][j] > 0.0 {
                left / factor[j][j]
            } else {
                0.0
            };
        }
    }
    factor
}
