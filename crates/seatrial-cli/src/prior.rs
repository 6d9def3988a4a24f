//! What `plan` believes of the vehicle: a simulated one, or models with noise from the command line.

use seatrial_app::trials::expectation::PriorOverrides;
use seatrial_app::trials::plan::ExpectedVehicle;

use crate::model_source::{SourceArgs, warn};
use crate::output::Failure;

/// The options that say what vehicle to expect.
#[derive(clap::Args, Debug)]
pub struct PriorArgs {
    /// Expect this simulated vehicle, with its models, noise, disturbance and heading controller
    /// [default: sim:starfish, in the time of --time-constant, unless a model is given].
    #[arg(long, value_name = "VEHICLE", conflicts_with_all = ["a22", "model", "schedule", "logbook"])]
    vehicle: Option<String>,
    #[command(flatten)]
    pub source: SourceArgs,
    /// Standard deviation of the compass, deg [default: the simulated vehicle's, or what was found on the model's
    /// record, or 0.5].
    #[arg(long, value_name = "DEG", value_parser = positive, allow_hyphen_values = true)]
    noise_deg: Option<f64>,
    /// Standard deviation and time constant of the yaw acceleration that waves cause [default: as for the noise,
    /// or 1 % of what the full rudder does, over 2 time constants of the vehicle].
    #[arg(long, value_name = "RAD_S2,S", value_parser = disturbance, allow_hyphen_values = true)]
    disturbance: Option<[f64; 2]>,
    /// Gain of the vehicle's own heading controller, rudder per heading error [default: the simulated vehicle's, or
    /// the gain that damps the model with a ratio of 0.7071].
    #[arg(long, value_name = "GAIN", allow_negative_numbers = true)]
    hold_gain: Option<f64>,
    /// Heading of the trial, deg.
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    heading_deg: Option<f64>,
}

/// A number above 0.
pub fn positive(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|value: &f64| *value > 0.0 && value.is_finite())
        .ok_or_else(|| "expected a positive number".into())
}

fn disturbance(text: &str) -> Result<[f64; 2], String> {
    let numbers = text.split_once(',').and_then(|(strength, time)| {
        Some([strength.trim().parse().ok()?, time.trim().parse().ok()?])
    });
    numbers
        .filter(|[strength, time]: &[f64; 2]| {
            *strength >= 0.0 && strength.is_finite() && *time > 0.0 && time.is_finite()
        })
        .ok_or_else(|| {
            "expected a standard deviation in rad/s^2, not below 0, a comma and a time constant in s, above 0, as in 0.005,2".into()
        })
}

impl PriorArgs {
    /// The vehicle that is expected, as the options say.
    pub fn expected(&self) -> Result<ExpectedVehicle, Failure> {
        let is_given = self.source.is_given();
        let models = is_given.then(|| self.source.read()).transpose()?;
        models.iter().for_each(warn);
        Ok(ExpectedVehicle {
            vehicle: self.vehicle.clone(),
            models,
            stated: PriorOverrides {
                noise_rad: self.noise_deg.map(f64::to_radians),
                disturbance: self.disturbance,
                hold_gain: self.hold_gain,
                heading_rad: self.heading_deg.map(f64::to_radians),
            },
        })
    }
}
