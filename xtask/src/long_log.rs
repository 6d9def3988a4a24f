//! A long ArduPilot log of a made-up boat.

use std::path::PathBuf;

use anyhow::Result;

use crate::shell::{Run, command};
use crate::workspace::in_target;

/// Writes a log of about this many megabytes, of 4 at least, where cargo builds.
pub fn long_log(name: &str, megabytes: &str) -> Result<PathBuf> {
    let path = in_target(name);
    command!("python3 bench/waits/make.py bin {path} {megabytes}").run()?;
    Ok(path)
}
