//! A simulated vehicle of either kind, first order in yaw or of six degrees of freedom.

use std::convert::Infallible;

use seatrial_core::{Action, Axis, Sample, Vehicle, YawModel};
use serde::Serialize;

use crate::config::{HelmConfig, VehicleConfig};
use crate::config_error::ConfigError;
use crate::faults::{Damage, Kind, Rehearsable, Upset};
use crate::plant::{Disturbance, Truth};
use crate::six_dof::{SixDofConfig, SixDofVehicle, equivalent, remus100, starfish};
use crate::vehicle::FirstOrderVehicle;

/// What a simulated vehicle is made from.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum SimulatedConfig {
    /// A yaw model at every speed.
    FirstOrder(Box<VehicleConfig>),
    /// Six degrees of freedom.
    SixDof(Box<SixDofConfig>),
}

/// A simulated vehicle.
pub enum SimulatedVehicle {
    /// A yaw model at every speed.
    FirstOrder(Box<FirstOrderVehicle>),
    /// Six degrees of freedom.
    SixDof(Box<SixDofVehicle>),
}

impl SimulatedConfig {
    /// The vehicle of this name that needs no file: `starfish`, `starfish-6dof` or `remus100`.
    pub fn built_in(name: &str) -> Option<Self> {
        match name {
            "starfish" => Some(Self::FirstOrder(Box::new(VehicleConfig::starfish()))),
            "starfish-6dof" => Some(Self::SixDof(Box::new(starfish::config()))),
            "remus100" => Some(Self::SixDof(Box::new(remus100::config()))),
            _ => None,
        }
    }

    /// This vehicle with its own fields replaced by those of a file.
    pub fn with(&self, fields: toml::Table) -> Result<Self, ConfigError> {
        Ok(match self {
            Self::FirstOrder(config) => Self::FirstOrder(Box::new(config.with(fields)?)),
            Self::SixDof(config) => Self::SixDof(Box::new(config.with(fields)?)),
        })
    }

    /// The vehicle.
    pub fn vehicle(&self, seed: u64) -> Result<SimulatedVehicle, ConfigError> {
        Ok(match self {
            Self::FirstOrder(config) => SimulatedVehicle::FirstOrder(Box::new(
                FirstOrderVehicle::new(config.as_ref().clone(), seed)?,
            )),
            Self::SixDof(config) => SimulatedVehicle::SixDof(Box::new(SixDofVehicle::new(
                config.as_ref().clone(),
                seed,
            )?)),
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

    /// What an identification at a thrust should find where the rudder is off its command by an angle, rad.
    pub fn truth_with_rudder_offset(
        &self,
        thrust: f64,
        offset_rad: f64,
    ) -> Result<Option<YawModel<f64>>, ConfigError> {
        Ok(match self {
            Self::FirstOrder(_) => self.truth(thrust)?.map(|truth| {
                let upset = Upset { rudder_offset_rad: offset_rad, ..Upset::default() };
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

    /// Time constant with which the rudder follows its command, s.
    pub fn rudder_lag_s(&self) -> f64 {
        match self {
            Self::FirstOrder(config) => config.servo.time_constant_s,
            Self::SixDof(config) => config.rudder.servo.time_constant_s,
        }
    }

    /// This vehicle in still water with exact sensors.
    pub fn noise_free(&self) -> Self {
        match self {
            Self::FirstOrder(config) => {
                Self::FirstOrder(Box::new(config.as_ref().clone().noise_free()))
            }
            Self::SixDof(config) => Self::SixDof(Box::new(config.as_ref().clone().noise_free())),
        }
    }

    /// This vehicle with another noise of the compass, rad, and another disturbance.
    pub fn disturbed(&self, compass_noise_rad: f64, sea: Disturbance) -> Self {
        let mut config = self.clone();
        let (sensors, disturbance) = match &mut config {
            Self::FirstOrder(config) => (&mut config.sensors, &mut config.disturbance),
            Self::SixDof(config) => (&mut config.helm.sensors, &mut config.helm.disturbance),
        };
        sensors.compass.noise_rad = compass_noise_rad;
        *disturbance = sea;
        config
    }

    /// This vehicle after damage; one with a yaw model stays as it was.
    pub fn damaged(&self, damage: &Damage) -> Self {
        match self {
            Self::FirstOrder(_) => self.clone(),
            Self::SixDof(config) => Self::SixDof(Box::new(config.damaged(damage))),
        }
    }

    /// Can it be steered on this axis? A yaw model only turns.
    pub fn has_axis(&self, axis: Axis) -> bool {
        axis.is_yaw() || !self.is_first_order()
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

impl SimulatedVehicle {
    /// Steered on this axis where the vehicle [has](SimulatedConfig::has_axis) it, else on that of yaw.
    pub fn on_axis(self, axis: Axis) -> Self {
        match self {
            Self::SixDof(vehicle) => Self::SixDof(Box::new(vehicle.on_axis(axis))),
            only_turns @ Self::FirstOrder(_) => only_turns,
        }
    }
}

impl Vehicle<f64> for SimulatedVehicle {
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

impl Rehearsable for SimulatedVehicle {
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
