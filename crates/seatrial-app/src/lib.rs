#![doc = include_str!("../README.md")]

pub mod assist;
pub mod commission;
pub mod compare_log;
pub mod conduct;
pub mod documents;
mod error;
pub mod expected;
#[cfg(feature = "parquet")]
pub mod fleet;
pub mod gains;
pub mod gains_export;
pub mod health;
pub mod identify_log;
pub mod inspect_log;
pub mod logs;
pub mod models;
pub mod next;
pub mod paper;
pub mod planned;
pub mod recording;
pub mod replay;
pub mod report;
pub mod set_up;
pub mod ship_trials;
pub mod simulated;
pub mod simulated_log;
pub mod studies;
mod trial_plan;
pub mod trial_run;
pub mod turning;
pub mod validate_log;
pub mod vehicle_export;
pub mod vehicle_file;
pub mod vehicles;
pub mod workers;

pub use error::Error;
pub use identify_log::{IdentifiedLog, Options, identify_log};
pub use inspect_log::Inspection;
pub use trial_plan::{TrialPlan, load_plan};
