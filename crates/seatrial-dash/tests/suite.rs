//! Every test of the crate in one program: it links once. `cargo nextest run --workspace -E 'test(/^abort_under_load::/)'` runs one file.

mod abort_under_load;
mod contract;
mod typed;
mod urgent;
mod viewers;
