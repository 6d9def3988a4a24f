#![doc = include_str!("../README.md")]
//!
//! # Where to begin
//!
//! [`model`] has the equations, [`Estimator`] estimates them sample by sample, [`Trial`] runs the manoeuvres. Everything is generic
//! over `f32` and `f64` through [`Real`], whose elementary functions come from `libm` on every platform.
#![no_std]
#![forbid(unsafe_code)]

pub mod answer;
pub mod attitude;
pub mod authority;
pub mod axis;
pub mod convergence;
pub mod envelope;
pub mod estimator;
mod estimator_settings;
pub mod excitation;
pub mod fixed_rate;
pub mod guard;
pub mod heading_control;
pub mod heading_loop;
pub mod heading_target;
pub mod instrument;
pub mod least_squares;
pub mod list;
pub mod lost_rudder;
pub mod model;
pub mod no_gain;
pub mod pitch;
pub mod plan;
pub mod progress;
pub mod rate_cascade;
pub mod real;
pub mod refine;
pub mod rudder_sense;
pub mod rudder_unit;
pub mod sample;
pub mod schedule;
pub mod setting;
pub mod settle;
pub mod state_variable_filter;
pub mod trial;
pub mod turning;
pub mod validation;
pub mod whitening;

pub use authority::{AuthorityFit, AuthorityForm};
pub use axis::Axis;
pub use convergence::{Convergence, ConvergenceSettings};
pub use envelope::{Envelope, EnvelopeUse, RudderSense};
pub use estimator::{Estimator, EstimatorSettings, FilteredSignals, Intake, Method};
pub use excitation::Excitation;
pub use fixed_rate::{FixedRateEstimator, FixedRateSettings};
pub use guard::{Cause, Guard, GuardSettings, RejectedCounts};
pub use heading_control::{GainSchedule, HeadingController, HeadingGain};
pub use heading_loop::HeadingLoop;
pub use heading_target::TargetShaping;
pub use instrument::{AuxiliaryModel, RecursiveInstrument};
pub use least_squares::{Forgetting, RecursiveLeastSquares};
pub use list::List;
pub use lost_rudder::{LostRudder, UnseenRudder};
pub use model::{Nomoto, YawModel};
pub use no_gain::NoGain;
pub use pitch::{PitchModel, PitchState};
pub use plan::{Manoeuvre, Plan};
pub use progress::{Event, RunResult, Stage, Status};
pub use rate_cascade::{CascadeSettings, RateCascade};
pub use real::Real;
pub use rudder_unit::RudderUnit;
pub use sample::{AbortReason, Action, Outcome, Sample, Steering, Vehicle};
pub use schedule::{SchedulePoint, SpeedSchedule};
pub use setting::InvalidSetting;
pub use settle::{NotSettled, Settle};
pub use state_variable_filter::{FilterStart, FilterStep, Hold, StateVariableFilter};
pub use trial::Trial;
pub use turning::{Side, Turn};
pub use validation::{GoodnessOfFit, Validation};
