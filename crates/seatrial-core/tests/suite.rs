//! Every test of the crate in one program: it links once. `cargo nextest run --workspace -E 'test(/^estimator_properties::/)'` runs one file.

mod estimator_bits;
mod estimator_properties;
mod estimator_recovery;
mod estimator_reference;
mod examples;
mod fixed_rate;
mod refine;
mod refine_recorded;
mod trial;
mod validation_reference;
