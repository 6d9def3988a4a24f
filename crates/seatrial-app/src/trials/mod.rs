//! What needs a vehicle or a logbook: threads, SQLite and serial ports, which a page without a server has not.

pub mod campaign_models;
pub mod campaign_page;
pub mod commission;
pub mod estimator_study;
pub mod expectation;
pub mod health;
pub mod next;
pub mod order;
pub mod paper;
pub mod plan;
pub mod recording;
pub mod replay;
pub mod set_up;
pub mod simulator;
pub mod surge_step;
pub mod vehicles;
