//! Motions besides yaw: pitch on its restoring moment, and surge over thrust.

pub mod pitch;
pub mod surge;
