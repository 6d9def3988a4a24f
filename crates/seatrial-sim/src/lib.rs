//! Simulated vehicles with known true parameters.
//!
//! No estimator depends on this crate: truth cannot leak into estimation.
