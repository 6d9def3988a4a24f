//! The wheel of the Python package with the command in it, and what it is to install it.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use crate::environment::{Environment, NO_PYTHON, PYTHON};
use crate::steps::{run, skipped, succeeds};
use crate::target::{in_target, target};

const TOOLS: Environment = Environment {
    python: PYTHON,
    folder: "packaging",
    requirements: &["xtask/packaging.txt"],
};
const PACKAGE: &str = "crates/seatrial-py";
const OUT: &str = "wheels";
/// glibc 2.28: Debian 10, Ubuntu 20.04, RHEL 8 and what is newer.
const GLIBC: &str = "2.28";
/// From the wheel to a model, s.
const GOAL_S: f64 = 30.0;

/// Where a wheel is built for: the target of the compiler, and the tag of the wheel.
#[derive(Clone, Copy)]
struct Platform {
    target: &'static str,
    compatibility: &'static str,
}

/// The first is the one of this machine. The compiler needs the standard library of each: `rustup target add`.
const PLATFORMS: [Platform; 4] = [
    Platform {
        target: "x86_64-unknown-linux-gnu",
        compatibility: "manylinux_2_28",
    },
    Platform {
        target: "aarch64-unknown-linux-gnu",
        compatibility: "manylinux_2_28",
    },
    Platform {
        target: "x86_64-unknown-linux-musl",
        compatibility: "musllinux_1_2",
    },
    Platform {
        target: "aarch64-unknown-linux-musl",
        compatibility: "musllinux_1_2",
    },
];

impl Platform {
    fn named(target: &str) -> Result<Self, String> {
        let known = PLATFORMS.into_iter().find(|known| known.target == target);
        known.ok_or_else(|| {
            let names = PLATFORMS.map(|known| known.target).join(", ");
            format!("no wheel for {target}; there are {names}")
        })
    }

    fn has_glibc(self) -> bool {
        self.target.ends_with("gnu")
    }

    /// The target as zig's linker takes it.
    fn of_linker(self) -> String {
        match self.has_glibc() {
            true => format!("{}.{GLIBC}", self.target),
            false => self.target.to_owned(),
        }
    }
}

/// Builds the wheel of a target, installs it into a fresh environment without a compiler, and times it to a first model. That of
/// another machine or C library is only built.
pub fn check(target: Option<&str>) -> Result<(), String> {
    let platform = Platform::named(target.unwrap_or(PLATFORMS[0].target))?;
    if !TOOLS.is_ready() {
        return skipped("the wheel", NO_PYTHON);
    }
    let begun = Instant::now();
    let wheel = build(platform)?;
    let size = std::fs::metadata(&wheel).map_or(0, |file| file.len());
    eprintln!(
        "== {} of {:.1} MB, built in {:.0} s",
        wheel.display(),
        size as f64 / 1e6,
        begun.elapsed().as_secs_f64()
    );
    if platform.target != PLATFORMS[0].target {
        eprintln!("== {}: built, not tried", platform.target);
        return Ok(());
    }
    let seconds = install_and_identify(&wheel)?;
    eprintln!("== from the wheel to a model in {seconds:.1} s");
    match seconds < GOAL_S {
        true => Ok(()),
        false => Err(format!(
            "a first model took {seconds:.1} s, more than {GOAL_S} s"
        )),
    }
}

/// A program of the environment, which finds the others there, too.
pub fn tool(name: &str, arguments: &[&str]) -> Command {
    let mut command = TOOLS.program(name, arguments);
    let own = in_target(TOOLS.folder).join("bin");
    let path = std::env::var("PATH").unwrap_or_default();
    command.env("PATH", format!("{}:{path}", own.display()));
    command.env("CARGO_TARGET_DIR", target());
    command
}

/// Makes the tools where they are missing.
pub fn has_tools() -> bool {
    TOOLS.is_ready()
}

/// The command for a target; for an old glibc, where it needs one.
pub fn command_for(target: &str) -> Result<PathBuf, String> {
    let platform = Platform::named(target)?;
    let linker = platform.of_linker();
    let words = format!("zigbuild --release -p seatrial-cli --target {linker}");
    let arguments: Vec<&str> = words.split(' ').collect();
    run(
        &mut tool("cargo-zigbuild", &arguments),
        format!("cargo {words}"),
    )?;
    Ok(in_target(target).join("release/seatrial"))
}

fn build(platform: Platform) -> Result<PathBuf, String> {
    let binary = command_for(platform.target)?;
    // maturin takes what is in the folder of this name along.
    let data = Path::new(PACKAGE).join("seatrial._native.data");
    let failed = |error: std::io::Error| format!("{}: {error}", data.display());
    std::fs::create_dir_all(data.join("scripts")).map_err(failed)?;
    std::fs::copy(&binary, data.join("scripts/seatrial")).map_err(failed)?;
    let folder = in_target(OUT);
    let out = folder.display().to_string();
    let words = format!(
        "build --release --strip --zig --compatibility {} --target {} --out",
        platform.compatibility, platform.target
    );
    let arguments: Vec<&str> = words.split(' ').chain([out.as_str()]).collect();
    let built = succeeds(tool("maturin", &arguments).current_dir(PACKAGE));
    std::fs::remove_dir_all(&data).map_err(failed)?;
    if !built {
        return Err("maturin build".into());
    }
    let architecture = platform.target.split('-').next().unwrap_or_default();
    let entries = std::fs::read_dir(&folder).map_err(|error| format!("{out}: {error}"))?;
    let mut wheels = entries.filter_map(|entry| Some(entry.ok()?.path()));
    let is_tagged = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        ["cp310-abi3", platform.compatibility, architecture]
            .iter()
            .all(|tag| name.contains(tag))
    };
    wheels
        .find(is_tagged)
        .ok_or_else(|| format!("{out}: no wheel for abi3 and {}", platform.compatibility))
}

/// Installs the wheel where no compiler is to be found, and identifies a log with the command and with Python, s.
fn install_and_identify(wheel: &Path) -> Result<f64, String> {
    let folder = in_target("wheel-check");
    let _ = std::fs::remove_dir_all(&folder);
    let wheel = std::path::absolute(wheel).map_err(|error| error.to_string())?;
    let bin = folder.join("bin");
    let within = |program: &Path, arguments: &[&str]| {
        let mut command = Command::new(program);
        command
            .args(arguments)
            .current_dir(&folder)
            .env("PATH", &bin);
        run(
            &mut command,
            format!("{} {}", program.display(), arguments.join(" ")),
        )
    };
    let mut venv = Command::new("python3");
    venv.args(["-m", "venv"]).arg(&folder);
    run(&mut venv, "python3 -m venv")?;
    let begun = Instant::now();
    let wheel = wheel.display().to_string();
    let python = bin.join("python");
    within(
        &python,
        &[
            "-m",
            "pip",
            "install",
            "--quiet",
            "--only-binary",
            ":all:",
            &wheel,
        ],
    )?;
    within(
        &bin.join("seatrial"),
        &["sim", "log", "--seed", "1", "--out", "run.csv"],
    )?;
    within(&bin.join("seatrial"), &["identify", "run.csv"])?;
    within(&python, &["-c", FIRST_MODEL])?;
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
