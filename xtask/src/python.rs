//! The Python package, built and tested in an environment of its own.

use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};

use crate::environment::{Environment, NO_PYTHON, skipped};
use crate::{ROS2, cargo, succeeds};

const ENVIRONMENT: Environment = Environment {
    folder: "target/python-package",
    requirements: "crates/seatrial-py/requirements.txt",
};
const PACKAGE: &str = "crates/seatrial-py";
const SPEED: &str = "tests/test_speed.py";
const SOURCE: &str = "crates/seatrial-py/python";
/// Lets the environment find a folder of packages.
const LINK: &str = "import sys, sysconfig
path = sysconfig.get_path('purelib') + '/seatrial.pth'
open(path, 'w').write(sys.argv[1] + '\\n')";

/// Makes the environment where it is missing.
pub fn prepare() {
    ENVIRONMENT.is_ready();
}

/// Makes the environment where it is missing and puts the package into it, with the module as the workspace's tests build it: alone, of
/// other features, it would take every library once more. Where there is no Python that can, nothing is built.
pub fn build() -> Result<(), String> {
    if !ENVIRONMENT.is_ready() {
        return Ok(());
    }
    let all = ["build", "--quiet", "--workspace", "--tests", "--lib"];
    if !succeeds(cargo(&all).args(["--features", ROS2])) {
        return Err(format!("cargo {}", all.join(" ")));
    }
    let source = std::path::absolute(SOURCE).map_err(|error| format!("{SOURCE}: {error}"))?;
    let module = format!("target/debug/{DLL_PREFIX}_native{DLL_SUFFIX}");
    // At one stroke: tests may be reading it.
    let [new, place] = ["new.so", "_native.abi3.so"].map(|name| source.join("seatrial").join(name));
    std::fs::copy(&module, &new)
        .and_then(|_| std::fs::rename(&new, &place))
        .map_err(|error| format!("{module} to {}: {error}", place.display()))?;
    let mut link = ENVIRONMENT.program("python", &["-c", LINK]);
    match succeeds(link.arg(&source)) {
        true => Ok(()),
        false => Err(format!("{} cannot be written to", ENVIRONMENT.folder)),
    }
}

/// Builds the package and runs its tests but those of its speed. Where there is no Python that can, this is said and skipped; with
/// `CI=true` it is a failure.
pub fn check() -> Result<(), String> {
    if !ENVIRONMENT.is_ready() {
        return skipped("Python", NO_PYTHON);
    }
    build()?;
    pytest(&[&format!("--ignore={SPEED}")])
}

/// Runs the tests of its speed, with nothing beside them.
pub fn is_fast() -> Result<(), String> {
    match ENVIRONMENT.is_ready() {
        true => pytest(&[SPEED]),
        false => skipped("Python beside scipy", NO_PYTHON),
    }
}

fn pytest(which: &[&str]) -> Result<(), String> {
    let mut tests = ENVIRONMENT.program("pytest", &["-q", "-s"]);
    let binary = std::path::absolute("target/debug/seatrial").map_err(|e| e.to_string())?;
    tests.args(which).env("SEATRIAL", binary);
    match succeeds(tests.current_dir(PACKAGE)) {
        true => Ok(()),
        false => Err(format!("pytest {}", which.join(" "))),
    }
}
