#![doc = include_str!("../README.md")]

pub mod ardupilot_json;
pub mod autopilot;
pub mod handover;
pub mod link;
pub mod ros2_vehicle;
