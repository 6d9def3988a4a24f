//! Where the Python is that plays vehicles.

use std::path::PathBuf;
use std::process::Command;

/// The Python that has this package: SEATRIAL_PYTHON, or the one that `.ci/run` has made.
pub fn python_with(package: &str) -> Option<PathBuf> {
    let made = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../target/python/bin/python"
    );
    let path = std::env::var_os("SEATRIAL_PYTHON").map_or_else(|| made.into(), PathBuf::from);
    let import = Command::new(&path)
        .args(["-c", &format!("import {package}")])
        .output();
    if import.is_ok_and(|output| output.status.success()) {
        return Some(path);
    }
    let missing = format!("no Python with {package} at {}", path.display());
    assert!(std::env::var_os("CI").is_none(), "{missing}");
    eprintln!("SKIPPED: {missing} (set SEATRIAL_PYTHON)");
    None
}
