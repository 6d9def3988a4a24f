//! What follows from a model for who steers: gains with what they allow for, a course change with them, parameters of autopilots, and
//! their commissioning on the vehicle.

pub mod commission;
pub mod export;
mod fall;

pub use crate::course_change::{COURSE_CHANGE_RAD, CourseChange, GOOD_OVERSHOOT_RAD};
pub use crate::gain_allowance::{
    DAMPING_RATIO, GainAllowance, least_damped_schedule, longest, sampled,
};
pub use fall::{SpeedGain, falls};
