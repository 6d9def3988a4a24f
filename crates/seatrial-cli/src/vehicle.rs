//! Vehicles by name: `sim:starfish`, `sim:starfish-6dof`, `sim:remus100`, `sim:FILE.toml`.

use std::convert::Infallible;
use std::path::Path;

use seatrial::identify::cramer_rao::Noise;
use seatrial_core::{Action, Sample, Vehicle, YawModel};
use seatrial_sim::config::HelmConfig;
use seatrial_sim::faults::{Damage, Kind, Rehearsable, Upset};
use seatrial_sim::plant::Disturbance;
use seatrial_sim::six_dof::{equivalent, remus100, starfish};
use seatrial_sim::{
    ConfigError, FaultyVehicle, FirstOrderVehicle, Scenario, SixDofConfig, SixDofVehicle, Truth,
    VehicleConfig, VehicleFile,
};
use serde::Serialize;

use crate::output::Failure;

/// What a simulated vehicle is made from.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub enum Config {
    /// A yaw model at every speed.
    FirstOrder(Box<VehicleConfig>),
    /// Six degrees of freedom.
    SixDof(Box<SixDofConfig>),
}

/// A simulated vehicle.
pub enum Simulated {
    /// A yaw model at every speed.
    FirstOrder(Box<FirstOrderVehicle>),
    /// Six degrees of freedom.
    SixDof(Box<SixDofVehicle>),
}

/// What a simulated vehicle of this name is made from.
pub fn config(name: &str) -> Result<Config, Failure> {
    let first_order = |config| Ok(Config::FirstOrder(Box::new(config)));
    let six_dof = |config| Ok(Config::SixDof(Box::new(config)));
    match name.strip_prefix("sim:") {
        Some("starfish") => first_order(VehicleConfig::starfish()),
        Some("starfish-6dof") => six_dof(starfish::config()),
        Some("remus100") => six_dof(remus100::config()),
        Some(file) if file.ends_with(".toml") => {
            match VehicleFile::load(Path::new(file)).map_err(Failure::input)? {
                VehicleFile::FirstOrder(config) => Ok(Config::FirstOrder(config)),
                VehicleFile::SixDof(config) => Ok(Config::SixDof(config)),
            }
        }
        _ => Err(Failure::usage(format!(
            "--vehicle {name}: expected sim:starfish, sim:starfish-6dof, sim:remus100 or sim:FILE.toml"
        ))),
    }
}

/// The simulated vehicle of this name.
pub fn simulated(name: &str, seed: u64) -> Result<Simulated, Failure> {
    config(name)?
        .vehicle(seed)
        .map_err(|error| Failure::input(format!("{name}: {error}")))
}

/// The simulated vehicle of this name with the faults of a scenario file.
pub fn rehearsed(
    name: &str,
    scenario: Option<&Path>,
    seed: u64,
) -> Result<FaultyVehicle<Simulated>, Failure> {
    let Some(path) = scenario else {
        let vehicle = simulated(name, seed)?;
        return FaultyVehicle::new(vehicle, &Scenario::default(), seed).map_err(Failure::internal);
    };
    let scenario = Scenario::load(path).map_err(Failure::input)?;
    let refused =
        |error: &dyn std::fmt::Display| Failure::input(format!("{}: {error}", path.display()));
    let vehicle = config(name)?
        .with(scenario.conditions.clone())
        .and_then(|config| config.vehicle(seed))
        .map_err(|error| refused(&error))?;
    FaultyVehicle::new(vehicle, &scenario, seed).map_err(|error| refused(&error))
}

impl Config {
    /// The same vehicle where these fields of a file take the place of its own.
    pub fn with(&self, fields: toml::Table) -> Result<Self, ConfigError> {
        Ok(match self {
            Self::FirstOrder(config) => Self::FirstOrder(Box::new(config.with(fields)?)),
            Self::SixDof(config) => Self::SixDof(Box::new(config.with(fields)?)),
        })
    }

    /// The vehicle.
    pub fn vehicle(&self, seed: u64) -> Result<Simulated, ConfigError> {
        Ok(match self {
            Self::FirstOrder(config) => Simulated::FirstOrder(Box::new(FirstOrderVehicle::new(
                config.as_ref().clone(),
                seed,
            )?)),
            Self::SixDof(config) => {
                Simulated::SixDof(Box::new(SixDofVehicle::new(config.as_ref().clone(), seed)?))
            }
        })
    }

    /// What an identification at a thrust should find; `None` where there is nothing to be found.
    pub fn truth(&self, thrust: f64) -> Result<Option<Truth>, ConfigError> {
        match self {
            Self::FirstOrder(config) => {
                FirstOrderVehicle::new(config.as_ref().clone(), 0).map(|v| Some(v.truth(thrust)))
            }
            Self::SixDof(config) => equivalent::equivalent(config, thrust),
        }
    }

    /// The same where the rudder stands off its command by an angle, rad.
    pub fn truth_with_rudder_offset(
        &self,
        thrust: f64,
        offset_rad: f64,
    ) -> Result<Option<YawModel<f64>>, ConfigError> {
        Ok(match self {
            Self::FirstOrder(_) => self.truth(thrust)?.map(|truth| {
                let upset = Upset {
                    rudder_offset_rad: offset_rad,
                    ..Upset::default()
                };
                upset.apparent(truth.model)
            }),
            Self::SixDof(config) => {
                equivalent::with_rudder_offset(config, thrust, offset_rad)?.map(|truth| truth.model)
            }
        })
    }

    /// Steering, instruments and start.
    pub fn helm(&self) -> HelmConfig {
        match self {
            Self::FirstOrder(config) => config.helm(),
            Self::SixDof(config) => config.helm,
        }
    }

    /// The same vehicle with another compass noise and disturbance.
    pub fn in_a_sea_of(&self, noise: Noise) -> Self {
        let mut config = self.clone();
        let (sensors, disturbance) = match &mut config {
            Self::FirstOrder(config) => (&mut config.sensors, &mut config.disturbance),
            Self::SixDof(config) => (&mut config.helm.sensors, &mut config.helm.disturbance),
        };
        sensors.compass.noise_rad = noise.heading_rad;
        *disturbance = Disturbance {
            standard_deviation_rad_s2: noise.disturbance_rad_s2,
            correlation_time_s: noise.disturbance_time_s,
        };
        config
    }

    /// The same vehicle after damage; one with a yaw model is as it was.
    pub fn damaged(&self, damage: &Damage) -> Self {
        match self {
            Self::FirstOrder(_) => self.clone(),
            Self::SixDof(config) => Self::SixDof(Box::new(config.damaged(damage))),
        }
    }

    /// Is the yaw model all there is?
    pub fn is_first_order(&self) -> bool {
        matches!(self, Self::FirstOrder(_))
    }

    /// Depth that it holds, m.
    pub fn depth_m(&self) -> f64 {
        match self {
            Self::FirstOrder(config) => config.depth_m,
            Self::SixDof(config) => config.depth_hold.depth_m,
        }
    }

    /// Time constant of the speed after a change of thrust, s.
    pub fn surge_time_constant_s(&self) -> Result<f64, ConfigError> {
        match self {
            Self::FirstOrder(config) => Ok(config.surge_time_constant_s),
            Self::SixDof(config) => equivalent::surge_time_constant_s(config),
        }
    }
}

impl Vehicle<f64> for Simulated {
    type Error = Infallible;

    fn next_sample(&mut self) -> Result<Option<Sample<f64>>, Infallible> {
        match self {
            Self::FirstOrder(vehicle) => vehicle.next_sample(),
            Self::SixDof(vehicle) => vehicle.next_sample(),
        }
    }

    fn act(&mut self, action: &Action<f64>) -> Result<(), Infallible> {
        match self {
            Self::FirstOrder(vehicle) => vehicle.act(action),
            Self::SixDof(vehicle) => vehicle.act(action),
        }
    }
}

impl Rehearsable for Simulated {
    fn refuses(&self, kind: Kind) -> Option<&'static str> {
        match self {
            Self::FirstOrder(vehicle) => vehicle.refuses(kind),
            Self::SixDof(vehicle) => vehicle.refuses(kind),
        }
    }

    fn upset(&mut self, upset: &Upset) {
        match self {
            Self::FirstOrder(vehicle) => vehicle.upset(upset),
            Self::SixDof(vehicle) => vehicle.upset(upset),
        }
    }

    fn yaw_model(&self) -> Option<YawModel<f64>> {
        match self {
            Self::FirstOrder(vehicle) => vehicle.yaw_model(),
            Self::SixDof(vehicle) => vehicle.yaw_model(),
        }
    }
}
