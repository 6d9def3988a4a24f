//! Monte Carlo studies of seatrial on simulated vehicles and logs, whose truth is known: how near do estimates come, and what becomes of
//! faults and of logs that lie? The program `seatrial-lab` has a verb for each; [`runner::Args::conduct`] runs them all.

pub mod commission;
pub mod coverage;
pub mod estimators;
pub mod faults;
pub mod field;
pub mod lies;
pub mod lying_logs;
pub mod manoeuvres;
mod observer;
pub mod runner;
pub mod surge;
pub mod world;
