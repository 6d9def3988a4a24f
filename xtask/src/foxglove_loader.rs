//! The data loader for Foxglove, outside the workspace: tested on this machine, and built as the module that Foxglove loads.

use std::path::Path;
use std::process::Command;

use crate::cargo;
use crate::extending::TARGET;
use crate::long_log::long_log;
use crate::steps::{run, skipped};
use crate::target::in_target;

const FOLDER: &str = "examples/foxglove-loader";
const MODULE: &str = "wasm32-unknown-unknown/release/seatrial_foxglove_loader.wasm";
/// A log that is opened through the module.
const LOG_MB: &str = "4";
/// What a program in the place of Foxglove says of it: topic, encoding, messages, least and greatest.
const SAID: [&str; 2] = [
    "/heading_rad cdr 45000 0.646 1.370",
    "/rudder_fraction cdr 45000 -0.500 0.500",
];

/// Runs the tests on this machine.
pub fn check() -> Result<(), String> {
    with_cargo(&["test", "--quiet"])
}

/// Runs the tests, builds the module and opens a log through it.
pub fn check_and_build() -> Result<(), String> {
    check()?;
    let target = ["--target", "wasm32-unknown-unknown"];
    with_cargo(&[&["build", "--quiet", "--release", "--lib"][..], &target].concat())?;
    let module = in_target(TARGET).join(MODULE);
    let file = std::fs::metadata(&module);
    let bytes = file
        .map_err(|error| format!("{}: {error}", module.display()))?
        .len();
    eprintln!("== {} of {:.1} MB", module.display(), bytes as f64 / 1e6);
    opens_a_log(&module)
}

fn opens_a_log(module: &Path) -> Result<(), String> {
    let log = long_log(in_target(TARGET).join("log.bin"), LOG_MB)?;
    let mut node = Command::new("node");
    node.arg(Path::new(FOLDER).join("tests/host.mjs"))
        .args([module, &log]);
    let Ok(output) = node.output() else {
        return skipped("the module at work", "node is missing");
    };
    let said = String::from_utf8_lossy(&output.stdout);
    match SAID.iter().all(|topic| said.contains(topic)) {
        true => Ok(()),
        false => Err(format!(
            "{said}{}\nexpected {SAID:?}",
            String::from_utf8_lossy(&output.stderr)
        )),
    }
}

fn with_cargo(arguments: &[&str]) -> Result<(), String> {
    let manifest = Path::new(FOLDER).join("Cargo.toml");
    let mut command = cargo(arguments);
    command.args(["--locked", "--manifest-path"]).arg(manifest);
    command.arg("--target-dir").arg(in_target(TARGET));
    command.env("CARGO_INCREMENTAL", "0");
    run(
        &mut command,
        format!("cargo {} of {FOLDER}", arguments.join(" ")),
    )
}
