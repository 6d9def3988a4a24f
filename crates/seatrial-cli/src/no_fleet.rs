//! `seatrial fleet` of a seatrial that writes no Parquet.

use std::ffi::OsString;

use crate::output::{Exit, Failure, Output};

/// Many logs at once: needs a seatrial built with --features parquet.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// What is asked of it.
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
    asked: Vec<OsString>,
}

/// Refuses.
pub fn run(args: &Args, _: &Output) -> Result<Exit, Failure> {
    Err(Failure::usage(format!(
        "fleet ({} arguments): its table is a Parquet file, which this seatrial was built without; build it with `--features parquet`",
        args.asked.len()
    )))
}
