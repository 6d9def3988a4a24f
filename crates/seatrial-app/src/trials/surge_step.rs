//! The run that `plan` adds so that a trial tells how the speed follows the thrust.

use seatrial::preview::{Prior, PriorSpeed, SurgeStep, surge_step};
use seatrial_core::List;

use crate::trials::simulator;
use crate::{Error, TrialPlan};

/// Thrusts of the runs that may be added, from and to, and their step, percent of full.
const THRUSTS_PERCENT: [u32; 3] = [20, 100, 5];
/// Time constant of the speed where nothing says otherwise, in time constants of the yaw rate at the greatest speed.
const DEFAULT_TIME_CONSTANTS: f64 = 3.0;
/// Noise of the speed where nothing says otherwise, m/s: twice that of a Doppler velocity log.
const DEFAULT_NOISE_M_S: f64 = 0.02;
/// No speed is measured better, m/s: one without noise would tell all.
const LEAST_NOISE_M_S: f64 = 1e-6;

/// What is said of a vehicle's surge. Absent: what the simulated vehicle has, or a default.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SurgeOverrides {
    /// Time constant of the speed after a change of thrust, s.
    pub time_constant_s: Option<f64>,
    /// Noise of the speed, m/s.
    pub noise_m_s: Option<f64>,
}

/// Adds the cheapest run to a plan that makes the surge identifiable, where the plan does not, and its speed to what is believed. `simulator`
/// is the simulated vehicle that is expected, where there are no models, and `speed_at` what it does at another thrust.
pub(crate) fn add_surge_step(
    plan: &mut TrialPlan,
    prior: &mut Prior,
    stated: &SurgeOverrides,
    simulator: Option<&str>,
    speed_at: &dyn Fn(f64) -> Option<PriorSpeed>,
) -> Result<SurgeStep, Error> {
    let time_constant_s = stated.time_constant_s.unwrap_or_else(|| default_time_constant_s(prior));
    if !(time_constant_s > 0.0 && time_constant_s.is_finite()) {
        return Err(Error::Setting(
            "surge: no time constant of the speed follows from the model; say it".into(),
        ));
    }
    prior.surge_time_constant_s = time_constant_s;
    let noise_m_s = match (stated.noise_m_s, simulator) {
        (Some(noise_m_s), _) => noise_m_s,
        (None, Some(name)) => simulated_noise_m_s(name)?,
        (None, None) => DEFAULT_NOISE_M_S,
    };
    let [from, to, step] = THRUSTS_PERCENT;
    let others: Vec<PriorSpeed> = (from..=to)
        .step_by(step as usize)
        .map(|percent| f64::from(percent) / 100.0)
        .filter(|thrust| {
            let is_other = |planned: &f64| (planned - thrust).abs() > 1e-9;
            plan.thrusts.iter().all(is_other)
        })
        .filter_map(|thrust| match simulator {
            Some(_) => speed_at(thrust),
            None => scaled(prior, thrust),
        })
        .collect();
    let found = surge_step(plan, prior, &others, noise_m_s.max(LEAST_NOISE_M_S))
        .map_err(|error| Error::Setting(format!("the plan: {error}")))?
        .ok_or_else(|| Error::Setting("surge: the models have no speed; say it".into()))?;
    if let Some(added) = found.added
        && let Some(other) = others.iter().find(|other| other.thrust == added.thrust)
    {
        prior.speeds.insert(added.place, *other);
        let thrusts: Vec<f64> = prior.speeds.iter().map(|speed| speed.thrust).collect();
        plan.plan.thrusts = List::from_slice(&thrusts).unwrap_or(plan.thrusts);
    }
    Ok(found)
}

fn default_time_constant_s(prior: &Prior) -> f64 {
    if prior.surge_time_constant_s > 0.0 {
        return prior.surge_time_constant_s;
    }
    let damping = prior.speeds.iter().map(|speed| -speed.model.a22_per_s);
    DEFAULT_TIME_CONSTANTS / damping.fold(0.0, f64::max)
}

/// A simulated vehicle's noise of its speed, as each of its samples has it: one reading held over several counts once.
fn simulated_noise_m_s(name: &str) -> Result<f64, Error> {
    let helm = simulator::config(name)?.helm();
    let log = helm.sensors.dvl;
    let held = (log.interval_s / helm.timing.sample_interval_s).max(1.0);
    let read = (1.0 - log.dropout_fraction) * (1.0 - helm.timing.missing_fraction);
    Ok(log.noise_m_s * (held / read).sqrt())
}

/// The speed of the nearest thrust of the plan at another one: the speed in proportion to the thrust, a22 to the speed, b2 and C0 to its
/// square, as of a hull whose forces grow with the square of the speed (Nomoto's K' and T').
fn scaled(prior: &Prior, thrust: f64) -> Option<PriorSpeed> {
    let away = |speed: &&PriorSpeed| (speed.thrust - thrust).abs();
    let nearest = prior.speeds.iter().min_by(|a, b| away(a).total_cmp(&away(b)))?;
    let ratio = thrust / nearest.thrust;
    let mut speed = PriorSpeed {
        thrust,
        surge_speed_m_s: nearest.surge_speed_m_s.map(|speed| ratio * speed),
        ..*nearest
    };
    speed.model.a22_per_s *= ratio;
    speed.model.b2_per_s2 *= ratio * ratio;
    speed.model.c0_rad_per_s2 *= ratio * ratio;
    speed.noise.disturbance_rad_s2 *= ratio * ratio;
    speed.noise.disturbance_time_s /= ratio;
    Some(speed)
}
