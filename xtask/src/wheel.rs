//! The wheel of the Python package with the command in it, and what it is to install it.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use anyhow::{Context, Result};

use crate::environment::Environment;
use crate::shell::{Run, command, empty_folder, files, in_time, put, shell, tell_size};
use crate::toolchain::needs_library;
use crate::workspace::{in_target, target};

const TOOLS: Environment =
    Environment { python: "python3", folder: "packaging", requirements: &["xtask/packaging.txt"] };
const PACKAGE: &str = "crates/seatrial-py";
/// glibc 2.28: Debian 10, Ubuntu 20.04, RHEL 8 and what is newer.
const GLIBC: &str = "2.28";
/// From the wheel to a model, s.
const GOAL_S: f64 = 30.0;

/// The target of this machine. The compiler needs the standard library of others: `rustup target add`.
const OWN: &str = "x86_64-unknown-linux-gnu";

/// Builds the wheel of a target, installs it into a fresh environment without a compiler, and times it to a first model. That of
/// another machine or C library is only built.
pub fn check(target: Option<&str>) -> Result<()> {
    let target = target.unwrap_or(OWN);
    let wheel = build(target)?;
    tell_size(&wheel)?;
    if target != OWN {
        eprintln!("== {target}: built, not tried");
        return Ok(());
    }
    in_time("from the wheel to a model", install_and_identify(&wheel)?, GOAL_S)
}

/// A program of the environment, which finds the others there, too.
fn tool(name: &str, words: &str) -> Result<Command> {
    let (program, words) = (TOOLS.program(name)?, words.split(' '));
    let path = std::env::var("PATH").unwrap_or_default();
    let mut command = command!("{program} {words...}");
    command.env("PATH", format!("{}:{path}", TOOLS.path("").display()));
    Ok(command)
}

/// The command for a target; for an old glibc, where it needs one.
pub fn command_for(target: &str) -> Result<PathBuf> {
    needs_library(target)?;
    let oldest = target.replace("-gnu", &format!("-gnu.{GLIBC}"));
    let words = format!("zigbuild --release -p seatrial-cli --target {oldest}");
    tool("cargo-zigbuild", &words)?.run()?;
    Ok(in_target(target).join("release/seatrial"))
}

fn build(platform: &str) -> Result<PathBuf> {
    let is_for_glibc = platform.ends_with("gnu");
    let tag = if is_for_glibc { "manylinux_2_28" } else { "musllinux_1_2" };
    // maturin takes what is in the folder of this name along.
    let data = Path::new(PACKAGE).join("seatrial._native.data");
    put(command_for(platform)?, data.join("scripts/seatrial"))?;
    let out = target().join("wheels");
    let words =
        format!("build --release --strip --zig --compatibility {tag} --target {platform} --out");
    let built = tool("maturin", &words)?.arg(&out).current_dir(PACKAGE).run();
    shell().remove_path(&data)?;
    built?;
    let architecture = platform.split('-').next().unwrap_or_default();
    let is_tagged = |wheel: &PathBuf| {
        let name = wheel.to_string_lossy();
        ["cp310-abi3", tag, architecture].iter().all(|tag| name.contains(tag))
    };
    let wheel = files(&out, "whl")?.into_iter().find(is_tagged);
    wheel.with_context(|| format!("{}: no wheel for abi3 and {tag}", out.display()))
}

/// Installs the wheel where no compiler is to be found, and identifies a log with the command and with Python, s.
fn install_and_identify(wheel: &Path) -> Result<f64> {
    let folder = in_target("wheel-check");
    empty_folder(&folder)?;
    command!("python3 -m venv {folder}").run()?;
    let bin = folder.join("bin");
    let (python, seatrial) = (bin.join("python"), bin.join("seatrial"));
    let begun = Instant::now();
    for mut command in [
        command!("{python} -m pip install --quiet --only-binary :all: {wheel}"),
        command!("{seatrial} sim log --seed 1 --out run.csv"),
        command!("{seatrial} identify run.csv"),
        command!("{python} -c {FIRST_MODEL}"),
    ] {
        command.current_dir(&folder).env("PATH", &bin).run()?;
    }
    Ok(begun.elapsed().as_secs_f64())
}

const FIRST_MODEL: &str = "
import seatrial
found = seatrial.identify_log('run.csv')
said = seatrial.command('identify', 'run.csv')
assert found.outcome == said['verdict']['outcome'].replace('_', ' ') == 'use', found
assert found.document['refined'] == said['refined']
print(found.model)
";
