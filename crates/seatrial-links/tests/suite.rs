//! Every test of the crate in one program: it links once. `cargo nextest run --workspace -E 'test(/^any_number::/)'` runs one file.

mod any_number;
mod autopilot;
mod autopilot_thread;
mod commission;
mod examples;
mod mavlink_frames;
mod ros2_vehicle;
mod transport;
