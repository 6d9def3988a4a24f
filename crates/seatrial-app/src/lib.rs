#![doc = include_str!("../README.md")]

pub mod advice;
#[cfg(feature = "trials")]
pub mod assist;
#[cfg(feature = "trials")]
pub mod commission;
#[cfg(feature = "trials")]
pub mod compare_log;
pub mod compare_turn_rates;
#[cfg(feature = "trials")]
pub mod conduct;
pub mod documents;
mod error;
pub mod expected;
#[cfg(feature = "parquet")]
pub mod fleet;
pub mod gains;
pub mod gains_export;
#[cfg(feature = "trials")]
pub mod health;
pub mod identify_log;
pub mod inspect_log;
pub mod log_page;
pub mod log_reading;
pub mod logs;
pub mod models;
pub mod next;
#[cfg(feature = "trials")]
pub mod paper;
#[cfg(feature = "trials")]
pub mod planned;
#[cfg(feature = "trials")]
pub mod recording;
#[cfg(feature = "trials")]
pub mod replay;
#[cfg(feature = "trials")]
pub mod report;
pub mod series;
#[cfg(feature = "trials")]
pub mod set_up;
#[cfg(feature = "trials")]
pub mod ship_trials;
#[cfg(feature = "trials")]
pub mod simulated;
pub mod simulated_log;
#[cfg(feature = "trials")]
pub mod studies;
#[cfg(feature = "trials")]
pub mod surge_step;
#[cfg(feature = "trials")]
mod trial_plan;
#[cfg(feature = "trials")]
pub mod trial_run;
pub mod turning;
#[cfg(feature = "trials")]
pub mod validate_log;
pub mod vehicle_export;
pub mod vehicle_file;
#[cfg(feature = "trials")]
pub mod vehicles;
pub mod workers;

pub use error::Error;
pub use identify_log::{IdentifiedLog, Options, identify_log};
pub use inspect_log::Inspection;
#[cfg(feature = "trials")]
pub use trial_plan::{TrialPlan, load_plan};
