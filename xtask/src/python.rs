//! The Python package, built and tested in an environment of its own.

use std::path::Path;
use std::process::Command;

use crate::succeeds;

const ENVIRONMENT: &str = "target/python-package";
const REQUIREMENTS: &str = "crates/seatrial-py/requirements.txt";
const PACKAGE: &str = "crates/seatrial-py";

/// Makes the environment where it is missing, builds the package into it and runs its tests. Where there is no Python that
/// can, this is said and skipped; with `CI=true` it is a failure.
pub fn check() -> Result<(), String> {
    if !is_made() && !make() {
        let what = "python3 with venv, or what requirements.txt names, is missing";
        return match std::env::var("CI").as_deref() {
            Ok("true") => Err(what.into()),
            _ => {
                eprintln!("== Python skipped: {what}");
                Ok(())
            }
        };
    }
    let environment = std::path::absolute(ENVIRONMENT).map_err(|error| error.to_string())?;
    let mut build = in_environment("maturin", &["develop", "--quiet"]);
    build.env("VIRTUAL_ENV", environment).current_dir(PACKAGE);
    if !succeeds(&mut build) {
        return Err("maturin develop".into());
    }
    let mut tests = in_environment("pytest", &["-q", "-s"]);
    let binary = std::path::absolute("target/release/seatrial").map_err(|e| e.to_string())?;
    tests.env("SEATRIAL", binary).current_dir(PACKAGE);
    if !succeeds(&mut tests) {
        return Err("pytest".into());
    }
    Ok(())
}

fn in_environment(program: &str, arguments: &[&str]) -> Command {
    let program = std::path::absolute(Path::new(ENVIRONMENT).join("bin").join(program));
    let mut command = Command::new(program.unwrap_or_default());
    command.args(arguments);
    command
}

/// Has the environment what the requirements name today?
fn is_made() -> bool {
    let installed = std::fs::read(Path::new(ENVIRONMENT).join("installed.txt"));
    installed.is_ok_and(|installed| std::fs::read(REQUIREMENTS).is_ok_and(|now| now == installed))
}

fn make() -> bool {
    let mut venv = Command::new("python3");
    venv.args(["-m", "venv", ENVIRONMENT]);
    let arguments = ["-m", "pip", "install", "--quiet", "-r", REQUIREMENTS];
    succeeds(&mut venv)
        && succeeds(&mut in_environment("python", &arguments))
        && std::fs::copy(REQUIREMENTS, Path::new(ENVIRONMENT).join("installed.txt")).is_ok()
}
