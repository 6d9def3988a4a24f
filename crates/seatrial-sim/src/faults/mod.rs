//! Faults to rehearse with.

mod built_in;
mod invalid;
mod kind;
mod scenario;
mod stages;
mod upset;
mod vehicle;

pub use invalid::{InvalidFault, InvalidRandom};
pub use kind::{Kind, Parameter};
pub use scenario::{Fault, Onset, Random, Scenario, ScenarioError};
pub use stages::Moment;
pub use upset::{Damage, Upset};
pub use vehicle::{FaultyVehicle, LinkLost, Rehearsable};
