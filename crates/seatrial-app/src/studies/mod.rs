//! Studies on simulated vehicles, whose truth is known: how good are estimates, and what becomes of faults and of logs that lie?

pub mod commission;
pub mod estimators;
pub mod fault_matrix;
pub mod fault_run;
pub mod lies;
pub mod lying_log;
mod observer;
pub mod subject;
pub mod surge;
pub mod world;
