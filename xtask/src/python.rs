//! The Python package, built and tested in an environment of its own.

use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};

use std::path::PathBuf;

use crate::environment::{Environment, NO_PYTHON, PYTHON};
use crate::steps::{run, skipped};
use crate::target::{binary, in_target};
use crate::{ROS2, cargo};

const ENVIRONMENT: Environment = Environment {
    python: PYTHON,
    folder: "python-package",
    requirements: &["crates/seatrial-py/requirements.txt"],
};
/// What tests hold seatrial against: implementations of MAVLink and DDS that are not ours are vehicles, other libraries read logs,
/// and Octave, numpy, CasADi, MuJoCo and FMPy play what is exported. It brings mdbook, too. `seatrial-dev` finds it by its folder.
const OF_TESTS: Environment = Environment {
    python: PYTHON,
    folder: "python",
    requirements: &[
        "crates/seatrial-links/tests/vehicle/requirements.txt",
        "crates/seatrial-cli/tests/objects/requirements.txt",
        "crates/seatrial-cli/tests/ros2/requirements.txt",
        "crates/seatrial-cli/tests/simulators/requirements.txt",
        "crates/seatrial-logs/tests/agreement/requirements.txt",
        "docs/requirements.txt",
    ],
};
/// ROS 2 Jazzy, which is built for this Python alone.
const OF_JAZZY: Environment = Environment {
    python: "python3.12",
    folder: "ros2-jazzy",
    requirements: &["crates/seatrial-cli/tests/ros2/requirements-jazzy.txt"],
};
const PACKAGE: &str = "crates/seatrial-py";
const SPEED: &str = "tests/test_speed.py";
const SOURCE: &str = "crates/seatrial-py/python";
/// Lets the environment find a folder of packages.
const LINK: &str = "import sys, sysconfig
path = sysconfig.get_path('purelib') + '/seatrial.pth'
open(path, 'w').write(sys.argv[1] + '\\n')";

/// Makes the environment of the tests where it is missing. What it cannot have is told by the tests that need it.
pub fn prepare_tests() -> Result<(), String> {
    match OF_TESTS.is_ready() {
        true => Ok(()),
        false => skipped("Python for the tests", NO_PYTHON),
    }
}

/// A program in the environment of the tests.
pub fn of_tests(name: &str) -> PathBuf {
    OF_TESTS.path(name)
}

/// The Python of ROS 2 Jazzy; the environment is made where it is missing. `None`: it cannot be.
pub fn of_jazzy() -> Option<PathBuf> {
    OF_JAZZY.is_ready().then(|| OF_JAZZY.path("python"))
}

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
    run(
        cargo(&all).args(["--features", ROS2]),
        format!("cargo {}", all.join(" ")),
    )?;
    let source = std::path::absolute(SOURCE).map_err(|error| format!("{SOURCE}: {error}"))?;
    let module = in_target(format!("debug/{DLL_PREFIX}_native{DLL_SUFFIX}"));
    // At one stroke: tests may be reading it.
    let [new, place] = ["new.so", "_native.abi3.so"].map(|name| source.join("seatrial").join(name));
    std::fs::copy(&module, &new)
        .and_then(|_| std::fs::rename(&new, &place))
        .map_err(|error| format!("{} to {}: {error}", module.display(), place.display()))?;
    let mut link = ENVIRONMENT.program("python", &["-c", LINK]);
    run(
        link.arg(&source),
        format!("{} cannot be written to", ENVIRONMENT.folder),
    )
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
    tests.args(which).env("SEATRIAL", binary());
    run(
        tests.current_dir(PACKAGE),
        format!("pytest {}", which.join(" ")),
    )
}
