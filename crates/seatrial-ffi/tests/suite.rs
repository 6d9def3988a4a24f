//! Every test of the crate in one program: it links once. `cargo nextest run --workspace -E 'test(/^header::/)'` runs one file.

mod header;
mod misuse;
