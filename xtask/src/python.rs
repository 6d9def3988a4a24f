//! The Python package, built and tested in an environment of its own, and the Python of other tests.

use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};

use anyhow::{Context, Result};

use crate::ROS2;
use crate::environment::Environment;
use crate::shell::{Run, command, shell};
use crate::workspace::{binary, in_target, root};

const ENVIRONMENT: Environment = Environment {
    python: "python3",
    folder: "python-package",
    requirements: &["crates/seatrial-py/requirements.txt"],
};
/// What tests hold seatrial against: implementations of MAVLink and DDS that are not ours are vehicles, other libraries read logs,
/// and Octave, numpy, CasADi, MuJoCo and FMPy play what is exported. It brings mdbook, too. `seatrial-dev` finds it by its folder.
pub const OF_TESTS: Environment = Environment {
    python: "python3",
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
pub const OF_JAZZY: Environment = Environment {
    python: "python3.12",
    folder: "ros2-jazzy",
    requirements: &["crates/seatrial-cli/tests/ros2/requirements-jazzy.txt"],
};
const PACKAGE: &str = "crates/seatrial-py";
const SPEED: &str = "tests/test_speed.py";
/// Lets the environment find a folder of packages.
const LINK: &str = "import sys, sysconfig
path = sysconfig.get_path('purelib') + '/seatrial.pth'
open(path, 'w').write(sys.argv[1] + '\\n')";

/// Makes the environment of the tests where it is missing. What it cannot have is told by the tests that need it.
pub fn prepare_tests() -> Result<()> {
    OF_TESTS.program("python").map(drop)
}

/// Makes the environment where it is missing and puts the package into it, with the module as the workspace's tests build it: alone, of
/// other features, it would take every library once more.
pub fn build() -> Result<()> {
    let python = ENVIRONMENT.program("python")?;
    command!("cargo build --quiet --workspace --tests --lib --features {ROS2}").run()?;
    let source = root().join(PACKAGE).join("python");
    let module = in_target(format!("debug/{DLL_PREFIX}_native{DLL_SUFFIX}"));
    // At one stroke: tests may be reading it.
    let [new, place] = ["new.so", "_native.abi3.so"].map(|name| source.join("seatrial").join(name));
    shell().copy_file(module, &new)?;
    std::fs::rename(&new, &place).with_context(|| place.display().to_string())?;
    command!("{python} -c {LINK} {source}").run()
}

/// Builds the package and runs its tests but those of its speed.
pub fn check() -> Result<()> {
    build()?;
    pytest(&format!("--ignore={SPEED}"))
}

/// Runs the tests of its speed, with nothing beside them.
pub fn is_fast() -> Result<()> {
    pytest(SPEED)
}

fn pytest(which: &str) -> Result<()> {
    let pytest = ENVIRONMENT.program("pytest")?;
    let mut tests = command!("{pytest} -q -s {which}");
    tests.env("SEATRIAL", binary()).current_dir(PACKAGE).run()
}
