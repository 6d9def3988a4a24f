//! The documents that `--json` prints, typed both ways: what is written here is read here.

mod identification;

pub use identification::{IdentificationDocument, UsedSource};

pub use crate::logs::Source;
