//! Every test of the crate in one program: it links once. `cargo nextest run --workspace -E 'test(/^any_number::/)'` runs one file.

mod any_number;
mod damaged_text;
mod faults;
mod sensors;
mod six_dof;
mod trial;
