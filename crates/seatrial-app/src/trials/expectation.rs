//! What is believed of a vehicle before its trial: a simulated one, or models that are known of it.

use seatrial::gains::DAMPING_RATIO;
use seatrial::identify::cramer_rao::Noise;
use seatrial::preview::{Prior, PriorSpeed};
use seatrial_core::schedule::{Beyond, ScheduleKey};
use seatrial_core::{HeadingGain, Plan, SchedulePoint, YawModel};

use crate::Error;
use crate::models::Models;

/// Heading noise where nothing says otherwise, rad.
const DEFAULT_NOISE_RAD: f64 = 0.5 / 180.0 * std::f64::consts::PI;
/// Disturbance where nothing says otherwise, as a part of what the full rudder does.
const DEFAULT_DISTURBANCE_SHARE: f64 = 0.01;
/// Its time constant, in time constants of the vehicle.
const DEFAULT_DISTURBANCE_TIME: f64 = 2.0;
/// No compass is better than this, rad: the bound of a perfect one is 0.
const LEAST_NOISE_RAD: f64 = 1e-6;

/// What is said of a vehicle besides its models. Absent: what the source knows, or a default.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PriorOverrides {
    /// Standard deviation of the compass, rad.
    pub noise_rad: Option<f64>,
    /// Yaw acceleration that is not the rudder's: standard deviation, rad/s^2, and time constant, s.
    pub disturbance: Option<[f64; 2]>,
    /// Gain of the vehicle's own heading controller, rudder per heading error.
    pub hold_gain: Option<f64>,
    /// Heading of the trial, rad.
    pub heading_rad: Option<f64>,
}

impl PriorOverrides {
    /// Puts what is said in place of what is believed.
    pub fn apply(&self, prior: &mut Prior) -> Result<(), Error> {
        prior.heading_rad = self.heading_rad.unwrap_or(prior.heading_rad);
        if !prior.heading_rad.is_finite() {
            return Err(Error::Setting("--heading-deg: expected a number".into()));
        }
        if self.hold_gain.is_some_and(|gain| !gain.is_finite()) {
            return Err(Error::Setting("--hold-gain: expected a number".into()));
        }
        for speed in &mut prior.speeds {
            let noise = &mut speed.noise;
            noise.heading_rad = self.noise_rad.unwrap_or(noise.heading_rad);
            if let Some([strength, time]) = self.disturbance {
                noise.disturbance_rad_s2 = strength;
                noise.disturbance_time_s = time;
            }
            noise.heading_rad = noise.heading_rad.max(LEAST_NOISE_RAD);
            speed.hold_gain = self.hold_gain.unwrap_or(speed.hold_gain);
        }
        Ok(())
    }

    /// What to expect of a vehicle of these models at the speeds of a plan, and what to know about it.
    pub fn of_models(
        &self,
        models: &Models,
        plan: &Plan<f64>,
    ) -> Result<(Prior, Vec<String>), Error> {
        let mut warnings = Vec::new();
        let speeds = plan
            .thrusts
            .iter()
            .map(|thrust| self.speed_of(models, *thrust, plan, &mut warnings))
            .collect::<Result<_, _>>()?;
        let prior = Prior {
            speeds,
            speed_before_m_s: None,
            surge_time_constant_s: 0.0,
            heading_rad: 0.0,
            depth_m: None,
            rudder_limit_rad: plan.rudder_limit_rad,
            hold_limit_rad: plan.rudder_limit_rad,
            sample_interval_s: plan.sample_interval_s,
        };
        Ok((prior, warnings))
    }

    fn speed_of(
        &self,
        models: &Models,
        thrust: f64,
        plan: &Plan<f64>,
        warnings: &mut Vec<String>,
    ) -> Result<PriorSpeed, Error> {
        let SchedulePoint { surge_speed_m_s, model, .. } = point_at(models, thrust, warnings)?;
        let designed = HeadingGain::design(&model, DAMPING_RATIO);
        let hold_gain = match (self.hold_gain, designed) {
            (Some(gain), _) => gain,
            (None, Ok(designed)) => designed.proportional_gain,
            (None, Err(reason)) => {
                return Err(Error::Setting(format!(
                    "{}: no heading controller follows from the model at {:.0} % thrust: {reason}; give the vehicle's own with --hold-gain",
                    models.origin,
                    100.0 * thrust
                )));
            }
        };
        Ok(PriorSpeed {
            thrust,
            surge_speed_m_s,
            model,
            hold_gain,
            noise: noise_near(models, thrust, &model, plan.rudder_limit_rad),
        })
    }
}

/// The noise that was found at the nearest thrust, or what is usual.
fn noise_near(models: &Models, thrust: f64, model: &YawModel<f64>, rudder_limit_rad: f64) -> Noise {
    let away = |point: &SchedulePoint<f64>| (point.thrust.unwrap_or(thrust) - thrust).abs();
    let nearest = models.points.iter().min_by(|a, b| away(&a.point).total_cmp(&away(&b.point)));
    let full_rudder_rad_s2 = model.b2_per_s2.abs() * rudder_limit_rad;
    let [heading_rad, disturbance_rad_s2] = nearest
        .and_then(|point| point.noise)
        .unwrap_or([DEFAULT_NOISE_RAD, DEFAULT_DISTURBANCE_SHARE * full_rudder_rad_s2]);
    let time_s = DEFAULT_DISTURBANCE_TIME / model.a22_per_s.abs();
    Noise {
        heading_rad,
        disturbance_rad_s2,
        disturbance_time_s: if time_s.is_finite() { time_s } else { 1.0 },
    }
}

/// The model at a thrust: a single one without a thrust holds for all.
fn point_at(
    models: &Models,
    thrust: f64,
    warnings: &mut Vec<String>,
) -> Result<SchedulePoint<f64>, Error> {
    if let [only] = models.points.as_slice() {
        return match only.point.thrust {
            Some(known) if known != thrust => Err(Error::Setting(format!(
                "{}: it has {} only, and the plan runs {:.0} % too: choose with --thrust {known}",
                models.origin,
                only.name(),
                100.0 * thrust
            ))),
            _ => Ok(only.point),
        };
    }
    let found = models
        .schedule(ScheduleKey::Thrust)?
        .lookup(thrust, Beyond::Extrapolate)
        .map_err(|error| Error::Setting(format!("{}: {error}", models.origin)))?;
    if found.is_extrapolated() {
        warnings.push(format!(
            "{}: the model at {:.0} % thrust is extrapolated",
            models.origin,
            100.0 * thrust
        ));
    }
    Ok(*found.value())
}
