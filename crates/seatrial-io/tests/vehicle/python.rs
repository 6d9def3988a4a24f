//! Where the Python with pymavlink is.

use std::path::PathBuf;

/// The Python that has pymavlink: SEATRIAL_PYTHON, or the one that `.ci/run` has made.
pub fn python() -> Option<PathBuf> {
    let path = std::env::var_os("SEATRIAL_PYTHON").map_or_else(
        || {
            PathBuf::from(concat!(
                env!("CARGO_MANIFEST_DIR"),
                "/../../target/python/bin/python"
            ))
        },
        PathBuf::from,
    );
    if path.exists() {
        return Some(path);
    }
    assert!(std::env::var_os("CI").is_none(), "no {}", path.display());
    eprintln!(
        "SKIPPED: no Python with pymavlink at {} (set SEATRIAL_PYTHON)",
        path.display()
    );
    None
}
