//! What `plan` believes of the vehicle: a simulated one, or models with noise from the command line.

use seatrial::identify::cramer_rao::Noise;
use seatrial::preview::{Prior, PriorSpeed};
use seatrial_core::schedule::{Beyond, ScheduleKey};
use seatrial_core::{HeadingGain, Plan, SchedulePoint};

use crate::model_source::{SourceArgs, warn};
use crate::output::{Failure, say};
use crate::vehicle;
use seatrial_app::models::Models;

const DEFAULT_VEHICLE: &str = "sim:starfish";

/// Heading noise where nothing says otherwise, rad.
const DEFAULT_NOISE_RAD: f64 = 0.5 / 180.0 * std::f64::consts::PI;
/// Disturbance where nothing says otherwise, as a part of what the full rudder does.
const DEFAULT_DISTURBANCE_SHARE: f64 = 0.01;
/// Its time constant, in time constants of the vehicle.
const DEFAULT_DISTURBANCE_TIME: f64 = 2.0;
/// No compass is better than this, rad: the bound of a perfect one is 0.
const LEAST_NOISE_RAD: f64 = 1e-6;

/// The options that say what vehicle to expect.
#[derive(clap::Args, Debug)]
pub struct PriorArgs {
    /// Expect this simulated vehicle, with its models, noise, disturbance and heading controller
    /// [default: sim:starfish, unless a model is given].
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
    /// The prior for this plan.
    pub fn read(&self, plan: &Plan<f64>) -> Result<Named, Failure> {
        let mut named = if self.source.is_given() {
            self.of_models(plan)?
        } else {
            let name = self.vehicle.as_deref().unwrap_or(DEFAULT_VEHICLE);
            Named {
                origin: name.into(),
                prior: vehicle::prior(name, plan)?,
            }
        };
        let prior = &mut named.prior;
        if let Some(heading_deg) = self.heading_deg {
            prior.heading_rad = heading_deg.to_radians();
        }
        if !prior.heading_rad.is_finite() {
            return Err(Failure::usage("--heading-deg: expected a number"));
        }
        if let Some(gain) = self.hold_gain
            && !gain.is_finite()
        {
            return Err(Failure::usage("--hold-gain: expected a number"));
        }
        for speed in &mut prior.speeds {
            if let Some(noise_deg) = self.noise_deg {
                speed.noise.heading_rad = noise_deg.to_radians();
            }
            if let Some([strength, time]) = self.disturbance {
                speed.noise.disturbance_rad_s2 = strength;
                speed.noise.disturbance_time_s = time;
            }
            speed.noise.heading_rad = speed.noise.heading_rad.max(LEAST_NOISE_RAD);
            speed.hold_gain = self.hold_gain.unwrap_or(speed.hold_gain);
        }
        Ok(named)
    }

    fn of_models(&self, plan: &Plan<f64>) -> Result<Named, Failure> {
        let source = self.source.read()?;
        warn(&source);
        let speeds = plan
            .thrusts
            .iter()
            .map(|thrust| self.speed_of(&source, *thrust, plan))
            .collect::<Result<_, _>>()?;
        Ok(Named {
            origin: source.origin,
            prior: Prior {
                speeds,
                speed_before_m_s: None,
                surge_time_constant_s: 0.0,
                heading_rad: 0.0,
                depth_m: None,
                rudder_limit_rad: plan.rudder_limit_rad,
                hold_limit_rad: plan.rudder_limit_rad,
                sample_interval_s: plan.sample_interval_s,
            },
        })
    }

    fn speed_of(
        &self,
        source: &Models,
        thrust: f64,
        plan: &Plan<f64>,
    ) -> Result<PriorSpeed, Failure> {
        let SchedulePoint {
            surge_speed_m_s,
            model,
            ..
        } = point_at(source, thrust)?;
        let designed = HeadingGain::design(&model, std::f64::consts::FRAC_1_SQRT_2);
        let hold_gain = match (self.hold_gain, designed) {
            (Some(gain), _) => gain,
            (None, Ok(designed)) => designed.proportional_gain,
            (None, Err(reason)) => {
                return Err(Failure::usage(format!(
                    "{}: no heading controller follows from the model at {:.0} % thrust: {reason}; give the vehicle's own with --hold-gain",
                    source.origin,
                    100.0 * thrust
                )));
            }
        };
        let away = |point: &SchedulePoint<f64>| (point.thrust.unwrap_or(thrust) - thrust).abs();
        let nearest = source
            .points
            .iter()
            .min_by(|a, b| away(&a.point).total_cmp(&away(&b.point)));
        let full_rudder_rad_s2 = model.b2_per_s2.abs() * plan.rudder_limit_rad;
        let [heading_rad, disturbance_rad_s2] = nearest.and_then(|point| point.noise).unwrap_or([
            DEFAULT_NOISE_RAD,
            DEFAULT_DISTURBANCE_SHARE * full_rudder_rad_s2,
        ]);
        let time_s = DEFAULT_DISTURBANCE_TIME / model.a22_per_s.abs();
        Ok(PriorSpeed {
            thrust,
            surge_speed_m_s,
            model,
            hold_gain,
            noise: Noise {
                heading_rad,
                disturbance_rad_s2,
                disturbance_time_s: if time_s.is_finite() { time_s } else { 1.0 },
            },
        })
    }
}

/// The model at a thrust: a single one without a thrust holds for all.
fn point_at(source: &Models, thrust: f64) -> Result<SchedulePoint<f64>, Failure> {
    if let [only] = source.points.as_slice() {
        return match only.point.thrust {
            Some(known) if known != thrust => Err(Failure::usage(format!(
                "{}: it has {} only, and the plan runs {:.0} % too: choose with --thrust {known}",
                source.origin,
                only.name(),
                100.0 * thrust
            ))),
            _ => Ok(only.point),
        };
    }
    let found = source
        .schedule(ScheduleKey::Thrust)?
        .lookup(thrust, Beyond::Extrapolate)
        .map_err(|error| Failure::usage(format!("{}: {error}", source.origin)))?;
    if found.is_extrapolated() {
        say(format!(
            "warning: {}: the model at {:.0} % thrust is extrapolated",
            source.origin,
            100.0 * thrust
        ));
    }
    Ok(*found.value())
}
