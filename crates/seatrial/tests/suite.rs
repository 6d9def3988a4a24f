//! Every test of the crate in one program: it links once. `cargo nextest run --workspace -E 'test(/^amplitude::/)'` runs one file.

mod amplitude;
mod course_change;
mod drift;
mod exact_plants;
mod examples;
mod export;
mod health;
mod identify;
mod missions;
mod robust;
mod rudder_play;
mod search_tolerance;
mod segmentation;
mod ship_manoeuvres;
mod standard_manoeuvres;
mod survey;
