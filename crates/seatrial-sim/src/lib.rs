#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod body;
pub mod config;
mod config_error;
pub mod driven;
pub mod faults;
mod file;
mod helm;
pub mod identified;
mod instruments;
pub mod plant;
mod range;
pub mod sensors;
mod simulated;
pub mod six_dof;
pub mod vehicle;
mod vehicle_text;

pub use config::VehicleConfig;
pub use config_error::ConfigError;
pub use driven::Driven;
pub use faults::{FaultyVehicle, Scenario, ScenarioError};
pub use identified::IdentifiedVehicle;
pub use plant::Truth;
pub use simulated::{SimulatedConfig, SimulatedVehicle};
pub use six_dof::{SixDofConfig, SixDofVehicle};
pub use vehicle::FirstOrderVehicle;
