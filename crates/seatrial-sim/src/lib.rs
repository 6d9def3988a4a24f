//! Simulated vehicles with known true parameters.
//!
//! No estimator depends on this crate: truth cannot leak into estimation.
//!
//! ```
//! use seatrial_core::{Plan, Trial, Vehicle};
//! use seatrial_sim::{FirstOrderVehicle, VehicleConfig};
//!
//! let mut vehicle = FirstOrderVehicle::new(VehicleConfig::starfish(), 1)?;
//! let mut trial = Trial::new(Plan::paper())?;
//! while let Some(sample) = vehicle.next_sample()? {
//!     let action = trial.step(&sample);
//!     vehicle.act(&action)?;
//!     if action.outcome.is_some() {
//!         break;
//!     }
//! }
//! assert_eq!(trial.outcome(), Some(seatrial_core::Outcome::Finished));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

mod body;
pub mod config;
mod config_error;
pub mod faults;
pub mod file;
mod helm;
mod instruments;
pub mod lies;
pub mod plant;
mod range;
pub mod sensors;
mod simulated;
pub mod six_dof;
pub mod vehicle;

pub use config::VehicleConfig;
pub use config_error::ConfigError;
pub use faults::{FaultyVehicle, Scenario, ScenarioError};
pub use file::VehicleFile;
pub use plant::Truth;
pub use simulated::{SimulatedConfig, SimulatedVehicle};
pub use six_dof::{SixDofConfig, SixDofVehicle};
pub use vehicle::FirstOrderVehicle;
