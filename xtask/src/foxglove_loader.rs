//! The data loader for Foxglove, outside the workspace: tested on this machine, and built as the module that Foxglove loads.

use std::path::{Path, PathBuf};

use crate::{cargo, succeeds};

const FOLDER: &str = "examples/foxglove-loader";
/// A build of its own: the module has a workspace of its own.
const TARGET: &str = "target/foxglove-loader";
const MODULE: &str = "wasm32-unknown-unknown/release/seatrial_foxglove_loader.wasm";
/// What Foxglove calls first.
const ENTRY: &[u8] = b"foxglove:loader/loader@0.1.0#[constructor]data-loader";

/// Runs the tests on this machine.
pub fn check() -> Result<(), String> {
    run(&["test", "--quiet"])
}

/// Runs the tests, then builds the module.
pub fn check_and_build() -> Result<(), String> {
    check()?;
    let target = ["--target", "wasm32-unknown-unknown"];
    run(&[&["build", "--quiet", "--release", "--lib"][..], &target].concat())?;
    let module = target_folder()?.join(MODULE);
    let bytes = std::fs::read(&module).map_err(|error| format!("{}: {error}", module.display()))?;
    eprintln!(
        "== {} of {:.1} MB",
        module.display(),
        bytes.len() as f64 / 1e6
    );
    match bytes.windows(ENTRY.len()).any(|part| part == ENTRY) {
        true => Ok(()),
        false => Err(format!("{}: not a data loader", module.display())),
    }
}

fn run(arguments: &[&str]) -> Result<(), String> {
    let manifest = Path::new(FOLDER).join("Cargo.toml");
    let mut command = cargo(arguments);
    command.args(["--locked", "--manifest-path"]).arg(manifest);
    command.arg("--target-dir").arg(target_folder()?);
    command.env("CARGO_INCREMENTAL", "0");
    match succeeds(&mut command) {
        true => Ok(()),
        false => Err(format!("cargo {} of {FOLDER}", arguments.join(" "))),
    }
}

fn target_folder() -> Result<PathBuf, String> {
    std::path::absolute(TARGET).map_err(|error| format!("{TARGET}: {error}"))
}
