//! A long ArduPilot log of a made-up boat.

use std::path::PathBuf;
use std::process::Command;

use crate::steps::run;

const MAKER: &str = "bench/waits/make.py";

/// Writes a log of about this many megabytes, of 4 at least.
pub fn long_log(path: PathBuf, megabytes: &str) -> Result<PathBuf, String> {
    let mut make = Command::new("python3");
    make.args([MAKER, "bin"]).arg(&path).arg(megabytes);
    run(&mut make, MAKER).map(|()| path)
}
