//! Links to vehicles: MAVLink autopilots and ROS 2.

pub mod ardupilot_json;
pub mod autopilot;
pub mod link;
pub mod ros2_vehicle;
mod wiggle;
