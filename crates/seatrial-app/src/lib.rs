#![doc = include_str!("../README.md")]

pub mod commission;
pub mod conduct;
pub mod documents;
mod error;
pub mod fleet;
pub mod identify_log;
pub mod inspect_log;
pub mod logs;
pub mod lying_log;
pub mod models;
pub mod next;
pub mod paper;
pub mod recording;
pub mod replay;
pub mod trial_run;

pub use error::Error;
pub use identify_log::{IdentifiedLog, Options, identify_log};
pub use inspect_log::Inspection;
