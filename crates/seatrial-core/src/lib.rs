//! The part of seatrial that runs on the vehicle.
//!
//! No standard library, no heap, no I/O, no clock and no logging: the caller passes
//! [`Sample`]s in and carries [`Action`]s out, so the same code runs a simulator, a link to an
//! autopilot, a replayed log and a microcontroller. Everything is generic over `f32` and `f64`
//! through [`Real`]; elementary functions come from `libm` on every platform, so that the same
//! samples give the same bits everywhere.
//!
//! Start with [`model`] for the equations, then the estimator, then the trial.
#![no_std]
#![forbid(unsafe_code)]

pub mod authority;
pub mod heading_control;
pub mod heading_loop;
pub mod model;
pub mod real;
pub mod sample;
pub mod schedule;
pub mod turning;

pub use authority::{AuthorityFit, AuthorityForm};
pub use heading_control::{GainSchedule, HeadingController, HeadingGain};
pub use heading_loop::HeadingLoop;
pub use model::{Nomoto, YawModel};
pub use real::Real;
pub use sample::{AbortReason, Action, Outcome, Sample, Steering, Vehicle};
pub use schedule::{SchedulePoint, SpeedSchedule};
pub use turning::{Hand, Turn};
