//! Simulated vehicles by their names, as every verb and function takes them.

use std::fmt::Display;
use std::path::{Path, PathBuf};

use seatrial::FullRudder;
use seatrial::identify::cramer_rao::Noise;
use seatrial::preview::{Budget, Prior, PriorSpeed};
use seatrial_core::plan::times_slower;
use seatrial_core::{Axis, Plan};
pub use seatrial_sim::Scenario;
use seatrial_sim::config::HelmConfig;
use seatrial_sim::{FaultyVehicle, SimulatedConfig, SimulatedVehicle, VehicleConfig};

use crate::trials::order::{Preflight, Terms, TrialVehicle, VehicleError, VehicleLease, taken};

/// The simulators that need no file.
pub const BUILT_IN: [(&str, &str); 3] = [
    ("sim:starfish", "the paper's vehicle, first order in yaw"),
    ("sim:starfish-6dof", "the paper's vehicle in six degrees of freedom"),
    ("sim:remus100", "REMUS 100 in six degrees of freedom"),
];

/// A simulated vehicle for trials, and the file of the faults that it meets.
pub struct Simulator {
    name: String,
    scenario: Option<PathBuf>,
}

impl Simulator {
    /// Refuses a vehicle that cannot be made or cannot play the faults.
    pub fn new(name: &str, scenario: Option<&Path>) -> Result<Self, VehicleError> {
        rehearsed(name, scenario, 1, Axis::Yaw)?;
        Ok(Self { name: name.into(), scenario: scenario.map(PathBuf::from) })
    }
}

impl TrialVehicle for Simulator {
    fn name(&self) -> &str {
        &self.name
    }

    fn description(&self) -> &str {
        let known = BUILT_IN.iter().find(|(name, _)| *name == self.name);
        known.map_or("a vehicle file", |(_, description)| description)
    }

    fn is_simulated(&self) -> bool {
        true
    }

    fn full_rudder(&self) -> Option<FullRudder> {
        let helm = config(&self.name).ok()?.helm();
        Some(FullRudder { angle_rad: helm.rudder_limit_rad, is_assumed: false })
    }

    fn rudder_lag_s(&self) -> f64 {
        config(&self.name).map_or(0.0, |config| config.rudder_lag_s())
    }

    fn scenario(&self) -> Option<String> {
        let scenario = self.scenario.as_ref()?;
        Some(scenario.display().to_string())
    }

    fn prior(&self, plan: &Plan<f64>, budget: &Budget) -> Result<Prior, VehicleError> {
        prior(&self.name, plan, budget)
    }

    fn has_axis(&self, axis: Axis) -> bool {
        config(&self.name).is_ok_and(|config| config.has_axis(axis))
    }

    fn inspect(&self, _: &Plan<f64>) -> Result<Preflight, VehicleError> {
        let found = vehicle(&self.name, 1).map(|_| "simulated".to_owned());
        let passed = found.is_ok();
        let mut preflight = Preflight { vehicle: self.name.clone(), ..Preflight::default() };
        let text = found.unwrap_or_else(|error| error.to_string());
        preflight.check("vehicle", passed, text);
        Ok(preflight)
    }

    fn take(&self, terms: &Terms) -> Result<Box<dyn VehicleLease>, VehicleError> {
        let axis = terms.plan.axis;
        let vehicle = rehearsed(&self.name, self.scenario.as_deref(), terms.seed, axis)?;
        Ok(taken(vehicle, |_| None, None, None))
    }
}

/// What stands before the time constant of a slow vehicle, in its name.
const SLOW: &str = "slow:";

/// Time constants of vehicles that are simulated by their name, s.
const TIME_CONSTANTS_S: std::ops::RangeInclusive<f64> = 0.1..=1000.0;

/// The name of the simulated vehicle whose yaw rate follows the rudder with this time constant, s: the paper's vehicle in more time.
pub fn slow_name(time_constant_s: f64) -> String {
    format!("sim:{SLOW}{time_constant_s}")
}

/// The time constant, s, in the name of a simulated vehicle that [`slow_name`] makes.
pub fn time_constant_of(name: &str) -> Option<f64> {
    let time_constant = name.strip_prefix("sim:")?.strip_prefix(SLOW)?;
    let time_constant_s = time_constant.parse().ok();
    time_constant_s.filter(|t| TIME_CONSTANTS_S.contains(t))
}

fn slow(name: &str) -> Result<SimulatedConfig, VehicleError> {
    let time_constant_s = time_constant_of(name).ok_or_else(|| {
        VehicleError::setting(format!(
            "vehicle {name}: expected a time constant from 0.1 to 1000 s, as in sim:{SLOW}30"
        ))
    })?;
    let slowed = VehicleConfig::starfish().slowed(times_slower(time_constant_s));
    Ok(SimulatedConfig::FirstOrder(Box::new(slowed)))
}

/// What a simulated vehicle of this name is made from.
pub fn config(name: &str) -> Result<SimulatedConfig, VehicleError> {
    let name_of_it = name.strip_prefix("sim:").unwrap_or_default();
    if name_of_it.ends_with(".toml") || name_of_it.ends_with(".json") {
        return SimulatedConfig::load(Path::new(name_of_it)).map_err(VehicleError::unreachable);
    }
    if name_of_it.starts_with(SLOW) {
        return slow(name);
    }
    SimulatedConfig::built_in(name_of_it).ok_or_else(|| {
        VehicleError::setting(format!(
            "vehicle {name}: expected sim:starfish, sim:starfish-6dof, sim:remus100 or sim:FILE.toml"
        ))
    })
}

/// The simulated vehicle of this name: one of [`BUILT_IN`], or `sim:` before the path of a vehicle file. A seed gives equal samples,
/// bit for bit.
///
/// # Errors
/// A name that is no simulator's, or a file that cannot be read or has a number out of its range.
pub fn vehicle(name: &str, seed: u64) -> Result<SimulatedVehicle, VehicleError> {
    config(name)?
        .vehicle(seed)
        .map_err(|error| VehicleError::unreachable(format!("{name}: {error}")))
}

/// The simulated vehicle of this name with the faults of a scenario file.
fn rehearsed(
    name: &str,
    scenario: Option<&Path>,
    seed: u64,
    axis: Axis,
) -> Result<FaultyVehicle<SimulatedVehicle>, VehicleError> {
    let Some(path) = scenario else {
        let vehicle = vehicle(name, seed)?.on_axis(axis);
        let faulty = FaultyVehicle::new(vehicle, &Scenario::default(), seed);
        return faulty.map_err(VehicleError::internal);
    };
    let scenario = Scenario::load(path).map_err(VehicleError::unreachable)?;
    let refused =
        |error: &dyn Display| VehicleError::unreachable(format!("{}: {error}", path.display()));
    let config = config(name)?;
    if scenario.conditions.contains_key("sea") && matches!(config, SimulatedConfig::FirstOrder(_)) {
        return Err(VehicleError::unreachable(format!(
            "{}: it has a sea, which {name} does not meet; take --vehicle sim:starfish-6dof or sim:remus100",
            path.display()
        )));
    }
    let vehicle = config
        .with(scenario.conditions.clone())
        .and_then(|config| config.vehicle(seed))
        .map_err(|error| refused(&error))?;
    FaultyVehicle::new(vehicle.on_axis(axis), &scenario, seed).map_err(|error| refused(&error))
}

/// The prior of a simulated vehicle: what it is made from. Each thrust of a vehicle in six degrees of freedom is simulated.
pub fn prior(name: &str, plan: &Plan<f64>, budget: &Budget) -> Result<Prior, VehicleError> {
    let config = config(name)?;
    let helm = config.helm();
    let truth = |thrust: f64| {
        budget.look().map_err(VehicleError::setting)?;
        let truth = config.truth(thrust).map_err(VehicleError::unreachable)?;
        truth.ok_or_else(|| {
            VehicleError::unreachable(format!(
                "{name}: has no yaw model at {:.0} % thrust",
                100.0 * thrust
            ))
        })
    };
    let noise = noise_of(&helm);
    let speeds = plan.thrusts.iter().map(|thrust| {
        let truth = truth(*thrust)?;
        Ok(PriorSpeed {
            thrust: *thrust,
            surge_speed_m_s: Some(truth.surge_speed_m_s),
            model: truth.model,
            hold_gain: helm.heading_hold.gain,
            noise,
        })
    });
    Ok(Prior {
        speeds: speeds.collect::<Result<_, VehicleError>>()?,
        speed_before_m_s: Some(truth(helm.initial_thrust)?.surge_speed_m_s),
        surge_time_constant_s: config.surge_time_constant_s().map_err(VehicleError::unreachable)?,
        heading_rad: helm.initial_heading_rad,
        depth_m: Some(config.depth_m()),
        rudder_limit_rad: helm.rudder_limit_rad,
        hold_limit_rad: helm.heading_hold.rudder_limit_rad,
        sample_interval_s: helm.timing.sample_interval_s,
    })
}

/// Steps of a compass count as noise spread evenly over one step. Fewer samples count as more noise on all of them.
fn noise_of(helm: &HelmConfig) -> Noise {
    let sensors = helm.sensors;
    let step_rad2 = sensors.compass.resolution_rad.powi(2) / 12.0;
    let variance_rad2 = sensors.compass.noise_rad.powi(2) + step_rad2;
    Noise {
        heading_rad: (variance_rad2 / (1.0 - helm.timing.missing_fraction)).sqrt(),
        disturbance_rad_s2: helm.disturbance.standard_deviation_rad_s2,
        disturbance_time_s: helm.disturbance.correlation_time_s,
    }
}
