//! The workspace as cargo knows it, and where it builds: `target`, or what `CARGO_TARGET_DIR` or a setting of cargo says.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use anyhow::{Context, Result};
use serde_json::Value;

/// What cargo knows of the workspace's crates.
pub fn metadata() -> Result<&'static Value> {
    static METADATA: OnceLock<Option<Value>> = OnceLock::new();
    let said_by_cargo = || {
        let words = ["metadata", "--no-deps", "--offline", "--format-version=1"];
        let said = Command::new(env!("CARGO")).args(words).output().ok()?;
        serde_json::from_slice(&said.stdout).ok()
    };
    let metadata = METADATA.get_or_init(said_by_cargo).as_ref();
    metadata.context("cargo metadata says nothing of the workspace")
}

/// The crates of the workspace in cargo's metadata.
pub fn packages(metadata: &Value) -> &[Value] {
    metadata["packages"].as_array().map_or(&[], Vec::as_slice)
}

/// A text in a JSON object; empty where it is not there.
pub fn text<'a>(object: &'a Value, field: &str) -> &'a str {
    object[field].as_str().unwrap_or_default()
}

/// The folder, from the root of the file system.
pub fn target() -> PathBuf {
    let said = metadata().ok().map(|known| text(known, "target_directory"));
    said.map_or_else(|| root().join("target"), PathBuf::from)
}

/// A file or folder in it.
pub fn in_target(path: impl AsRef<Path>) -> PathBuf {
    target().join(path)
}

/// The command that the tests built.
pub fn binary() -> PathBuf {
    in_target("debug/seatrial")
}

/// The project's folder, which is the working folder of every step.
pub fn root() -> &'static Path {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    own.parent().unwrap_or(own)
}

/// The folder of the recorded data.
pub fn data() -> PathBuf {
    std::env::var_os("SEATRIAL_DATA").map_or_else(|| root().join("../shared/data"), PathBuf::from)
}
