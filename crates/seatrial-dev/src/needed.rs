//! Data and tools that not every machine has.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::process::target;

/// A file or folder of the recorded data: below the folder that `SEATRIAL_DATA` names, or below `../shared/data` from the project's root.
///
/// Where it is absent, says that the test is skipped and returns `None`; so it does for everything where `SEATRIAL_DATA=none`.
///
/// # Panics
///
/// Where it is absent, `CI=true` and `SEATRIAL_DATA` is not `none`.
pub fn data(path: &str) -> Option<PathBuf> {
    let folder = match std::env::var_os("SEATRIAL_DATA") {
        Some(none) if none == "none" => {
            say_skipped(&format!("{path}, as SEATRIAL_DATA=none"));
            return None;
        }
        Some(named) => PathBuf::from(named),
        None => root().join("../shared/data"),
    };
    let path = folder.join(path);
    if path.exists() {
        return Some(path);
    }
    skip(&format!("no {} (set SEATRIAL_DATA)", path.display()));
    None
}

/// A Python that can import `packages`, named with commas between: the one that `SEATRIAL_PYTHON` names, or else the one that
/// `cargo xtask test --all` has made where cargo builds, or else `python3`.
///
/// Where there is none, says that the test is skipped and returns `None`.
///
/// # Panics
///
/// Where there is none and `CI=true`.
pub fn python_with(packages: &str) -> Option<PathBuf> {
    let candidates = match std::env::var_os("SEATRIAL_PYTHON") {
        Some(named) => vec![PathBuf::from(named)],
        None => vec![target().join("python/bin/python"), "python3".into()],
    };
    let program = format!("import {packages}");
    let found = candidates.into_iter().find(|python| {
        let import = Command::new(python).args(["-c", &program]).output();
        import.is_ok_and(|output| output.status.success())
    });
    if found.is_none() {
        skip(&format!("no Python with {packages} (set SEATRIAL_PYTHON)"));
    }
    found
}

/// Says on standard error which test is skipped and what it lacks, and keeps a line of it in the file that `SEATRIAL_SKIPPED` names.
///
/// # Panics
///
/// With `CI=true`, where nothing may be missing.
pub fn skip(missing: &str) {
    let is_ci = std::env::var("CI").is_ok_and(|value| value == "true");
    assert!(!is_ci, "{missing}");
    say_skipped(missing);
}

fn say_skipped(missing: &str) {
    let thread = std::thread::current();
    let line = format!("skipped {}: {missing}\n", thread.name().unwrap_or("a test"));
    eprint!("{line}");
    if let Some(list) = std::env::var_os("SEATRIAL_SKIPPED") {
        let file = std::fs::OpenOptions::new().create(true).append(true).open(list);
        // One write, as tests run side by side.
        let written = file.and_then(|mut file| file.write_all(line.as_bytes()));
        written.expect("SEATRIAL_SKIPPED names a file that can be written");
    }
}

fn root() -> &'static Path {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).parent();
    crates.and_then(Path::parent).expect("crates/seatrial-dev")
}
