//! The core on microcontrollers, under QEMU: the same bits as on this machine, no panic path, and what it costs.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::cargo;
use crate::steps::{skipped, succeeds};
use crate::target::{in_target, root};
use crate::toolchain::{CORTEX_M, has_library, no_library};

/// What the step needs beyond a Rust toolchain, and the Debian packages that bring it.
const TOOLS: [&str; 3] = ["qemu-system-arm", "arm-none-eabi-gcc", "gcc"];
const PACKAGES: &str = "qemu-system-arm gcc-arm-none-eabi libnewlib-arm-none-eabi gcc libc6-dev";

/// A processor and the machine that has it.
pub struct Board {
    pub name: &'static str,
    machine: &'static str,
    rust_flags: &'static str,
    limits: &'static [(&'static str, &'static str, u64)],
}

/// The M7's image uses its double-precision unit; on the M4F `f64` is software.
pub const BOARDS: [Board; 2] = [
    Board {
        name: "Cortex-M4F",
        machine: "mps2-an386",
        rust_flags: "",
        limits: &M4F_LIMITS,
    },
    Board {
        name: "Cortex-M7",
        machine: "mps2-an500",
        rust_flags: "-C target-cpu=cortex-m7",
        limits: &M7_LIMITS,
    },
];

/// An emulation takes a few seconds; one that hangs is ended after this.
const PATIENCE: Duration = Duration::from_secs(120);

/// What a step may cost: the goals for the lean estimator, for the rest what was measured and 10 %, which is what
/// another release of the compiler may do.
const M4F_LIMITS: [(&str, &str, u64); 20] = [
    ("fixed_rate_step", "instructions", 130),
    ("fixed_rate_step", "stack_bytes", 64),
    ("fixed_rate_step", "state_bytes", 96),
    ("fixed_rate_step", "code_bytes", 600),
    ("timed_step", "instructions", 220),
    ("timed_step", "stack_bytes", 64),
    ("timed_step", "state_bytes", 96),
    ("timed_step", "code_bytes", 1000),
    ("fixed_rate_step_f64", "instructions", 9000),
    ("fixed_rate_step_f64", "state_bytes", 192),
    ("estimator_step_f32", "instructions", 1900),
    ("estimator_step_f32", "state_bytes", 528),
    ("estimator_step_f64", "instructions", 48_000),
    ("estimator_step_f64", "state_bytes", 912),
    ("trial_step_f32", "instructions", 7400),
    ("trial_step_f32", "stack_bytes", 1210),
    ("trial_step_f32", "state_bytes", 3600),
    ("trial_step_f64", "instructions", 64_500),
    ("trial_step_f64", "stack_bytes", 2300),
    ("trial_step_f64", "state_bytes", 5800),
];

const M7_LIMITS: [(&str, &str, u64); 9] = [
    ("fixed_rate_step", "instructions", 130),
    ("fixed_rate_step", "stack_bytes", 64),
    ("fixed_rate_step", "state_bytes", 96),
    ("fixed_rate_step", "code_bytes", 600),
    ("timed_step", "code_bytes", 1000),
    ("fixed_rate_step_f64", "instructions", 145),
    ("estimator_step_f64", "instructions", 1420),
    ("trial_step_f32", "instructions", 2370),
    ("trial_step_f64", "instructions", 2780),
];

pub type Checked = Result<(), String>;

/// Runs everything and returns this machine's parity vectors; `None` where the tools are missing, which fails if CI is set.
pub fn check() -> Result<Option<String>, String> {
    let missing: Vec<&str> = TOOLS
        .into_iter()
        .filter(|tool| {
            let version = Command::new(tool).arg("--version").output();
            !version.is_ok_and(|output| output.status.success())
        })
        .collect();
    if !missing.is_empty() {
        let message = format!(
            "{} not found; on Debian: apt-get install --no-install-recommends {PACKAGES}",
            missing.join(", ")
        );
        return skipped("microcontrollers", &message).map(|()| None);
    }
    if !has_library(CORTEX_M) {
        return skipped("microcontrollers", &no_library(CORTEX_M)).map(|()| None);
    }
    sources_are_clean()?;
    let expected = parity_vectors()?;
    for board in &BOARDS {
        let found = run(board, &build(board, "parity")?, &[])?;
        same(board.name, &expected, &found)?;
        eprintln!(
            "{}: {} lines of parity vectors equal bit for bit",
            board.name,
            found.lines().count()
        );
    }
    a_panic_path_does_not_link()?;
    for board in &BOARDS {
        costs(board)?;
    }
    Ok(Some(expected))
}

fn sources_are_clean() -> Checked {
    let formatted = succeeds(firmware(&["fmt", "--check"]).arg("--all"));
    let mut lints = firmware(&["clippy", "--release", "--quiet"]);
    lints.args(["--target", CORTEX_M, "--target-dir"]);
    lints.arg(target_dir(&BOARDS[0]));
    lints.args(["--", "-D", "warnings"]);
    if formatted && succeeds(&mut lints) {
        Ok(())
    } else {
        Err("firmware: format or lints".into())
    }
}

/// What this machine computes.
fn parity_vectors() -> Result<String, String> {
    let output = cargo(&["run", "--quiet", "--release", "-p", "seatrial-parity"])
        .stderr(Stdio::inherit())
        .output()
        .map_err(|error| format!("cargo run -p seatrial-parity: {error}"))?;
    if !output.status.success() {
        return Err("cargo run -p seatrial-parity failed".into());
    }
    String::from_utf8(output.stdout).map_err(|error| error.to_string())
}

fn build(board: &Board, program: &str) -> Result<PathBuf, String> {
    let folder = target_dir(board);
    let mut command = firmware(&["build", "--release", "--quiet", "--bin", program]);
    command
        .args(["--target", CORTEX_M, "--target-dir"])
        .arg(&folder);
    command.env("RUSTFLAGS", board.rust_flags);
    if succeeds(&mut command) {
        Ok(folder.join(CORTEX_M).join("release").join(program))
    } else {
        Err(format!(
            "firmware: {program} does not build for {}",
            board.name
        ))
    }
}

/// What a program without arguments prints on its board.
fn run(board: &Board, image: &Path, options: &[&str]) -> Result<String, String> {
    let semihosting = ["-semihosting-config", "enable=on,target=native"];
    run_on(board, image, &[&semihosting, options].concat())
}

/// What a program prints on its board.
pub fn run_on(board: &Board, image: &Path, options: &[&str]) -> Result<String, String> {
    let printed = image.with_extension("stdout");
    let output =
        File::create(&printed).map_err(|error| format!("{}: {error}", printed.display()))?;
    let mut emulation = Command::new("qemu-system-arm")
        .args(["-machine", board.machine, "-display", "none"])
        .args(["-serial", "none", "-monitor", "none"])
        .args(options)
        .arg("-kernel")
        .arg(image)
        .stdin(Stdio::null())
        .stdout(output)
        .spawn()
        .map_err(|error| format!("qemu-system-arm: {error}"))?;
    let start = Instant::now();
    let status = loop {
        match emulation.try_wait() {
            Ok(Some(status)) => break status,
            Ok(None) if start.elapsed() < PATIENCE => std::thread::sleep(Duration::from_millis(20)),
            _ => {
                let _ = emulation.kill();
                return Err(format!(
                    "{} on {} does not end",
                    image.display(),
                    board.name
                ));
            }
        }
    };
    let text = fs::read_to_string(&printed).map_err(|error| error.to_string())?;
    if status.success() {
        Ok(text)
    } else {
        Err(format!(
            "{} on {}: {status}\n{text}",
            image.display(),
            board.name
        ))
    }
}

/// Names the first line that differs.
fn same(name: &str, expected: &str, found: &str) -> Checked {
    let differs = expected
        .lines()
        .zip(found.lines())
        .enumerate()
        .find(|(_, (expected, found))| expected != found);
    match differs {
        Some((line, (expected, found))) => Err(format!(
            "{name}: line {} of the parity vectors differs\nhere  {expected}\nthere {found}",
            line + 1
        )),
        None if expected.len() == found.len() => Ok(()),
        None => Err(format!("{name}: not as many parity vectors as here")),
    }
}

/// The images link only because nothing in them can panic: with one panic path the same image does not.
fn a_panic_path_does_not_link() -> Checked {
    let mut command = firmware(&["build", "--release", "--quiet", "--bin", "parity"]);
    command.args([
        "--features",
        "panic-path",
        "--target",
        CORTEX_M,
        "--target-dir",
    ]);
    let output = command
        .arg(target_dir(&BOARDS[0]))
        .env("RUSTFLAGS", "")
        .output()
        .map_err(|error| error.to_string())?;
    let message = String::from_utf8_lossy(&output.stderr);
    if !output.status.success() && message.contains("seatrial_has_a_panic_path") {
        eprintln!("no panic path in the images: with one they do not link");
        Ok(())
    } else {
        Err(format!(
            "firmware: an image with a panic path should not link\n{message}"
        ))
    }
}

/// Instructions, stack, state and code of each step against the board's limits; counted twice.
fn costs(board: &Board) -> Checked {
    let image = build(board, "count")?;
    // 2^10 ns of emulated time an instruction, so that the 25 MHz timer resolves single ones.
    let count = || run(board, &image, &["-icount", "shift=10"]);
    let mut text = count()?;
    if text != count()? {
        return Err("firmware: the counts do not repeat".into());
    }
    for (name, bytes) in code_sizes(&image)? {
        text += &format!("{name},code_bytes,{bytes}\n");
    }
    eprintln!("{}, largest over a rehearsed trial:\n{text}", board.name);
    let value = |wanted: [&str; 2]| {
        text.lines().find_map(|line| {
            let (key, value) = line.rsplit_once(',')?;
            (key == wanted.join(",")).then(|| value.parse::<u64>().ok())?
        })
    };
    for &(name, quantity, limit) in board.limits {
        match value([name, quantity]) {
            Some(value) if value <= limit => {}
            Some(value) => {
                let board = board.name;
                return Err(format!(
                    "{board}, {name}: {value} {quantity}, at most {limit}"
                ));
            }
            None => return Err(format!("{name}: {quantity} not reported")),
        }
    }
    Ok(())
}

/// Code of the lean steps, which call nothing.
fn code_sizes(image: &Path) -> Result<Vec<(&'static str, u64)>, String> {
    let tool = |name: &str, option: &str| {
        let output = Command::new(name).arg(option).arg(image).output();
        let output = output.map_err(|error| format!("{name}: {error}"))?;
        Ok::<_, String>(String::from_utf8_lossy(&output.stdout).into_owned())
    };
    let symbols = tool("arm-none-eabi-nm", "--print-size")?;
    let listing = tool("arm-none-eabi-objdump", "--disassemble")?;
    let mut sizes = Vec::new();
    for name in ["fixed_rate_step", "timed_step"] {
        let size = symbols
            .lines()
            .map(|line| line.split_whitespace().collect::<Vec<_>>())
            .find(|fields| fields.last() == Some(&name))
            .and_then(|fields| u64::from_str_radix(fields.get(1)?, 16).ok())
            .ok_or_else(|| format!("{name}: no such symbol"))?;
        let calls = listing
            .lines()
            .skip_while(|line| !line.contains(&format!("<{name}>:")))
            .take_while(|line| !line.is_empty())
            .any(|line| {
                line.split('\t').nth(2).is_some_and(|word| {
                    word.starts_with("bl ") || word.starts_with("blx") || word == "bl"
                })
            });
        if calls {
            return Err(format!(
                "{name}: calls another function, its own size says nothing"
            ));
        }
        sizes.push((name, size));
    }
    Ok(sizes)
}

fn firmware(arguments: &[&str]) -> Command {
    let (verb, options) = arguments.split_at(1);
    let mut command = cargo(verb);
    command.arg("--manifest-path");
    command.arg(root().join("firmware/Cargo.toml"));
    command.args(options);
    command
}

fn target_dir(board: &Board) -> PathBuf {
    in_target("firmware").join(board.machine)
}
