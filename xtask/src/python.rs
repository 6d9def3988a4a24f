//! The Python package, built and tested in an environment of its own.

use crate::environment::{Environment, NO_PYTHON, skipped};
use crate::succeeds;

const ENVIRONMENT: Environment = Environment {
    folder: "target/python-package",
    requirements: "crates/seatrial-py/requirements.txt",
};
const PACKAGE: &str = "crates/seatrial-py";

/// Makes the environment where it is missing.
pub fn prepare() {
    ENVIRONMENT.is_ready();
}

/// Makes the environment where it is missing and builds the package into it. Where there is no Python that can, nothing is built.
pub fn build() -> Result<(), String> {
    if !ENVIRONMENT.is_ready() {
        return Ok(());
    }
    let environment = std::path::absolute(ENVIRONMENT.folder).map_err(|error| error.to_string())?;
    let mut build = ENVIRONMENT.program("maturin", &["develop", "--quiet"]);
    build.env("VIRTUAL_ENV", environment).current_dir(PACKAGE);
    match succeeds(&mut build) {
        true => Ok(()),
        false => Err("maturin develop".into()),
    }
}

/// Builds the package and runs its tests. Where there is no Python that can, this is said and skipped; with `CI=true` it is a failure.
pub fn check() -> Result<(), String> {
    if !ENVIRONMENT.is_ready() {
        return skipped("Python", NO_PYTHON);
    }
    build()?;
    let mut tests = ENVIRONMENT.program("pytest", &["-q", "-s"]);
    let binary = std::path::absolute("target/debug/seatrial").map_err(|e| e.to_string())?;
    tests.env("SEATRIAL", binary).current_dir(PACKAGE);
    if !succeeds(&mut tests) {
        return Err("pytest".into());
    }
    Ok(())
}
