//! What `plan` believes of the vehicle: a simulated one, or models with noise from the command line.

use seatrial::figures::three_figures;
use seatrial::preview::Prior;
use seatrial_app::expected::Stated;
use seatrial_app::simulated;
use seatrial_core::Plan;
use seatrial_core::plan::times_slower;

use crate::model_source::{SourceArgs, warn};
use crate::output::{Failure, say};

const DEFAULT_VEHICLE: &str = "sim:starfish";

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

/// A prior and where it comes from, for people.
pub struct Named {
    /// A vehicle, a file or a logbook.
    pub origin: String,
    /// What is believed.
    pub prior: Prior,
}

impl PriorArgs {
    /// The prior for this plan. Where no vehicle is given, the default one has the time constant that the plan was made for, s.
    pub fn read(&self, plan: &Plan<f64>, time_constant_s: Option<f64>) -> Result<Named, Failure> {
        let stated = Stated {
            noise_rad: self.noise_deg.map(f64::to_radians),
            disturbance: self.disturbance,
            hold_gain: self.hold_gain,
            heading_rad: self.heading_deg.map(f64::to_radians),
        };
        let (origin, mut prior) = if self.source.is_given() {
            let models = self.source.read()?;
            warn(&models);
            let (prior, warnings) = stated.of_models(&models, plan)?;
            for warning in warnings {
                say(format!("warning: {warning}"));
            }
            (models.origin, prior)
        } else if let (None, Some(time_constant_s)) = (&self.vehicle, time_constant_s) {
            let prior = simulated::prior(DEFAULT_VEHICLE, plan)?;
            (
                format!(
                    "{DEFAULT_VEHICLE} with a time constant of {} s",
                    three_figures(time_constant_s)
                ),
                prior.slowed(times_slower(time_constant_s)),
            )
        } else {
            let name = self.vehicle.as_deref().unwrap_or(DEFAULT_VEHICLE);
            (name.into(), simulated::prior(name, plan)?)
        };
        stated.apply(&mut prior)?;
        Ok(Named { origin, prior })
    }
}
