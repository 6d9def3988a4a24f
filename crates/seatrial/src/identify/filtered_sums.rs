//! Filtering and batch least squares in one pass over evenly sampled arrays.

use nalgebra::{Matrix3, Vector3};
use seatrial_core::YawModel;
use seatrial_core::estimator::InvalidSetting;
use seatrial_core::state_variable_filter::{FilterStart, FilterStep, Hold, StateVariableFilter};

/// The least squares solution (34) of a long, evenly sampled record.
///
/// ```text
/// Theta = (sum phi phi^T)^-1 sum phi psi''_f,   phi = [psi'_f, delta_f, 1]       (32)-(34)
/// ```
///
/// | symbol | identifier | unit |
/// |---|---|---|
/// | psi | `heading_rad`, unwrapped | rad |
/// | delta | `rudder_rad` | rad |
/// | h | `interval_s` | s |
/// | lambda | `lambda_rad_s` | rad/s |
///
/// Source: (16)-(34) with filters from zero state and both signals held between samples, as `--as-paper` has them, on
/// increments from the first heading. For records of a million samples, of which it keeps nine sums: no guard, no rejected samples, no
/// interval, no verdict. The sums square the condition number, which is 10 to 1000 for a vehicle that was excited:
/// half of the digits of f64 are left. `None` where nothing excites the vehicle or a number is not finite.
pub fn filtered_least_squares(
    interval_s: f64,
    heading_rad: &[f64],
    rudder_rad: &[f64],
    lambda_rad_s: f64,
) -> Result<Option<YawModel<f64>>, InvalidSetting> {
    for (field, value) in [("interval_s", interval_s), ("lambda_rad_s", lambda_rad_s)] {
        if !(value > 0.0 && value.is_finite()) {
            return Err(InvalidSetting {
                field,
                requirement: "a positive number",
            });
        }
    }
    let mut step = FilterStep::new(lambda_rad_s);
    step.set_interval(interval_s);
    let mut samples = heading_rad.iter().zip(rudder_rad);
    let Some((&heading, &rudder)) = samples.next() else {
        return Ok(None);
    };
    let mut yaw = StateVariableFilter::new(heading, FilterStart::Zero);
    let mut helm = StateVariableFilter::new(rudder, FilterStart::Zero);
    let mut sums = Sums::default();
    sums.add(&yaw, &helm, &step);
    for (&heading, &rudder) in samples {
        yaw.advance(heading, Hold::ZeroOrder, &step);
        helm.advance(rudder, Hold::ZeroOrder, &step);
        sums.add(&yaw, &helm, &step);
    }
    Ok(sums.solve())
}

/// The entries of sum phi phi^T and sum phi psi''_f that differ.
#[derive(Default)]
struct Sums {
    count: f64,
    rate: f64,
    rudder: f64,
    acceleration: f64,
    rate_rate: f64,
    rate_rudder: f64,
    rudder_rudder: f64,
    rate_acceleration: f64,
    rudder_acceleration: f64,
}

impl Sums {
    #[inline]
    fn add(
        &mut self,
        yaw: &StateVariableFilter<f64>,
        helm: &StateVariableFilter<f64>,
        step: &FilterStep<f64>,
    ) {
        let acceleration = yaw.second_derivative(step);
        let rate = yaw.first_derivative(step);
        let rudder = helm.smoothed();
        self.count += 1.0;
        self.rate += rate;
        self.rudder += rudder;
        self.acceleration += acceleration;
        self.rate_rate += rate * rate;
        self.rate_rudder += rate * rudder;
        self.rudder_rudder += rudder * rudder;
        self.rate_acceleration += rate * acceleration;
        self.rudder_acceleration += rudder * acceleration;
    }

    fn solve(&self) -> Option<YawModel<f64>> {
        let information = Matrix3::new(
            self.rate_rate,
            self.rate_rudder,
            self.rate,
            self.rate_rudder,
            self.rudder_rudder,
            self.rudder,
            self.rate,
            self.rudder,
            self.count,
        );
        let right = Vector3::new(
            self.rate_acceleration,
            self.rudder_acceleration,
            self.acceleration,
        );
        let theta = information.cholesky()?.solve(&right);
        let is_finite = theta.iter().all(|parameter| parameter.is_finite());
        is_finite.then(|| YawModel::from_theta(theta.into()))
    }
}
