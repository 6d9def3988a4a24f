//! Giving a vehicle's controls to a trial and taking them back, whatever the vehicle speaks: the checks before, the proof
//! that the rudder answers and that the vehicle lets go of it by itself, and the watch over a rudder that must follow.

mod controls;
mod following;
mod heading_hold;
mod preflight;
mod proof;

pub(crate) use controls::Controls;
pub(crate) use following::{FOLLOWS, Following};
pub(crate) use heading_hold::HeadingHold;
pub use preflight::{Change, Check, Preflight};
pub(crate) use proof::{LostProcess, Wiggle, prove_rudder, prove_that_it_lets_go};

/// Longest wait for a vehicle, s.
pub(crate) const CONNECT_S: f64 = 10.0;
/// Longest wait for something to come at a time, s.
pub(crate) const WAIT_S: f64 = 0.02;
/// Samples may come this much slower than asked for.
pub(crate) const SLOWER: f64 = 1.5;
/// Silence that ends the trial, s.
pub(crate) const SILENCE_S: f64 = 0.7;
/// A rudder this near to amidships is neutral, as a fraction of full.
pub(crate) const NEUTRAL: f64 = 0.05;
