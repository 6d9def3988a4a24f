//! Least squares of the yaw model from sums over evenly sampled records: the recursion's result without the recursion.
//!
//! From Theta = 0 and P = p I the recursion of [`FixedRateEstimator`](seatrial_core::FixedRateEstimator) gives, after every sample, the ridge
//! regression
//!
//! ```text
//! Theta_k = (sum phi phi^T + I/p)^-1 sum phi psi''_f,   phi = [psi'_f, delta_f, 1]       (15), (32)-(34)
//! ```
//!
//! of which nine sums are all that is to be kept: no division a sample, no sample that waits for the one before. One
//! long record is cut into stretches, many records lie side by side, and a vector register works on eight of them (sixteen in
//! `f32`). Numbers are added up in stretches of about a hundred and those in `f64`, so that rounding does not grow with the
//! record.
//!
//! The kernels are compiled for several instruction sets and the machine's best is taken at run time. Where it has a
//! fused multiply-add, that is used: the last bits may differ from a machine that has none.
//!
//! Headings are unwrapped and every sample is taken as it is: no guard, no interval and no verdict. No path of seatrial takes
//! these kernels: they show how fast the machine can do it. `identify(..., estimate="batch")` sums in one lane.

#![warn(missing_docs)]

mod every;
mod lanes;
mod long;
mod many;
mod monte_carlo;
mod noise;

use seatrial_core::YawModel;

pub use every::every_theta;
pub use lanes::Lane;
pub use long::Accumulator;
pub use many::of_records;
pub use monte_carlo::{NoisyRuns, monte_carlo};
pub use noise::normals_of_run;

use lanes::Scales;

/// The sums of the filtered signals of a record.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sums {
    /// Samples.
    pub count: f64,
    /// sum psi'_f, rad/s
    pub rate: f64,
    /// sum delta_f, rad
    pub rudder: f64,
    /// sum psi''_f, rad/s^2
    pub acceleration: f64,
    /// sum psi'_f^2
    pub rate_rate: f64,
    /// sum psi'_f delta_f
    pub rate_rudder: f64,
    /// sum delta_f^2
    pub rudder_rudder: f64,
    /// sum psi'_f psi''_f
    pub rate_acceleration: f64,
    /// sum delta_f psi''_f
    pub rudder_acceleration: f64,
}

impl Sums {
    fn scaled(
        [rate, acceleration]: [f64; 2],
        products: [f64; 6],
        samples: usize,
        scales: &Scales,
    ) -> Self {
        let [rudder, rate2, rate_rudder, rudder2, rate_acc, rudder_acc] = products;
        Self {
            count: samples as f64,
            rate: rate * scales.rate,
            rudder: rudder * scales.rudder,
            acceleration: acceleration * scales.acceleration,
            rate_rate: rate2 * scales.rate * scales.rate,
            rate_rudder: rate_rudder * scales.rate * scales.rudder,
            rudder_rudder: rudder2 * scales.rudder * scales.rudder,
            rate_acceleration: rate_acc * scales.rate * scales.acceleration,
            rudder_acceleration: rudder_acc * scales.rudder * scales.acceleration,
        }
    }

    /// Theta of the recursion from P0 = `initial_covariance` I; infinite for plain least squares (34). `None` where nothing
    /// excites the vehicle or a sample was not finite.
    pub fn model(&self, initial_covariance: f64) -> Option<YawModel<f64>> {
        let ridge = 1.0 / initial_covariance;
        // The constant is eliminated first, which centres the sums, then the rate.
        let of_one = 1.0 / (self.count + ridge);
        let (mean_rate, mean_rudder) = (self.rate * of_one, self.rudder * of_one);
        let rate = self.rate_rate + ridge - mean_rate * self.rate;
        let mixed = self.rate_rudder - mean_rate * self.rudder;
        let slope = mixed / rate;
        let rudder = self.rudder_rudder + ridge - mean_rudder * self.rudder - slope * mixed;
        let is_excited = of_one > 0.0 && rate > 0.0 && rudder > 0.0;
        if !is_excited {
            return None;
        }
        let by_rate = self.rate_acceleration - mean_rate * self.acceleration;
        let by_rudder = self.rudder_acceleration - mean_rudder * self.acceleration;
        let b2 = (by_rudder - slope * by_rate) / rudder;
        let a22 = (by_rate - mixed * b2) / rate;
        let c0 = (self.acceleration - a22 * self.rate - b2 * self.rudder) * of_one;
        let theta = [a22, b2, c0];
        let is_finite = theta.iter().all(|parameter| parameter.is_finite());
        is_finite.then(|| YawModel::from_theta(theta))
    }
}
