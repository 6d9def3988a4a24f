//! Every test of the crate in one program: it links once. `cargo nextest run --workspace -E 'test(/^advice::/)'` runs one file.

mod advice;
mod conduct;
mod examples;
mod false_acceptance;
mod field;
mod fleet;
mod live;
mod own_format;
mod pitch;
mod preview;
mod recorded_manoeuvres;
mod several_speeds;
mod ship_manoeuvres;
mod six_dof;
mod surge;
mod surge_estimate;
mod time_scale;
