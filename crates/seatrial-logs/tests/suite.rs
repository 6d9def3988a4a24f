//! Every test of the crate in one program: it links once. `cargo nextest run --workspace -E 'test(/^bombs::/)'` runs one file.

mod bombs;
mod channels;
mod container_bombs;
mod damage;
mod examples;
mod foxglove;
mod fuzzed;
mod layouts;
mod memory;
mod native_damage;
mod native_logs;
mod random;
mod real_logs;
mod recorders;
mod ros_logs;
mod round_trip;
mod seeds;
mod spreadsheets;
mod text_logs;
mod viewers;
