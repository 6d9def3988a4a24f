#![doc = include_str!("../README.md")]

pub mod advice;
pub mod assist;
pub mod compare_log;
pub mod compare_turn_rates;
pub mod conduct;
pub mod documents;
mod error;
pub mod file_form;
#[cfg(feature = "parquet")]
pub mod fleet;
pub mod gains;
pub mod gains_export;
pub mod identify_log;
pub mod inspect_log;
pub mod log_page;
pub mod log_reading;
pub mod logs;
pub mod model_request;
pub mod models;
pub mod next;
pub mod outputs;
pub mod series;
pub mod ship_trials;
pub mod simulated_log;
pub mod text_queue;
mod trial_plan;
#[cfg(feature = "trials")]
pub mod trials;
pub mod turning;
pub mod validate_log;
pub mod vehicle_export;
pub mod vehicle_file;
pub mod workers;

pub use error::Error;
pub use identify_log::{IdentifiedLog, Options, identify_log};
pub use inspect_log::Inspection;
pub use trial_plan::{CheckedPlan, TrialPlan, load_plan};
