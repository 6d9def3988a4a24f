//! Where cargo builds: `target`, or what `CARGO_TARGET_DIR` or a setting of cargo says.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use serde_json::Value;

/// The folder, from the root of the file system.
pub fn target() -> &'static Path {
    static TARGET: OnceLock<PathBuf> = OnceLock::new();
    TARGET.get_or_init(|| said_by_cargo().unwrap_or_else(|| root().join("target")))
}

/// A file or folder in it.
pub fn in_target(path: impl AsRef<Path>) -> PathBuf {
    target().join(path)
}

/// The command that the tests built.
pub fn binary() -> PathBuf {
    in_target("debug/seatrial")
}

/// The project's folder.
pub fn root() -> &'static Path {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    own.parent().unwrap_or(own)
}

fn said_by_cargo() -> Option<PathBuf> {
    let mut metadata = Command::new(env!("CARGO"));
    metadata.args([
        "metadata",
        "--no-deps",
        "--offline",
        "--format-version",
        "1",
    ]);
    let said = metadata.output().ok()?;
    let said: Value = serde_json::from_slice(&said.stdout).ok()?;
    said["target_directory"].as_str().map(PathBuf::from)
}
