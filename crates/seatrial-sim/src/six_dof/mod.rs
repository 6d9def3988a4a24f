//! Vehicles of six degrees of freedom: physics, from which a yaw model has to be identified.
//!
//! Axes are Fossen's: x forward, y starboard, z down on the vehicle; north, east and down over ground.

pub mod actuator;
pub mod commands;
pub mod config;
pub mod depth_hold;
pub mod dynamics;
pub mod equivalent;
pub mod fins;
pub mod foil;
pub mod hydrodynamics;
pub mod propeller;
pub mod remus100;
pub mod rigid_body;
pub mod sea;
pub mod starfish;
pub mod vehicle;
pub mod waves;

pub use config::SixDofConfig;
pub use vehicle::SixDofVehicle;
