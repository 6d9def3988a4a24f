//! The core on microcontrollers, under QEMU: the same bits as on this machine, no panic path, and what it costs.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use anyhow::{Context, Result, bail, ensure};

use crate::shell::{Run, command, has, patiently, shell};
use crate::steps::missing;
use crate::toolchain::{CORTEX_M, needs_library};
use crate::workspace::in_target;

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
    Board { name: "Cortex-M4F", machine: "mps2-an386", rust_flags: "", limits: &M4F_LIMITS },
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

/// What QEMU lets a program do that takes no arguments: it prints, and it ends.
pub const PLAIN: &str = "enable=on,target=native";

/// Runs everything and returns this machine's parity vectors.
pub fn check() -> Result<String> {
    for tool in TOOLS {
        if !has(tool) {
            return missing(format!(
                "{tool} is missing; on Debian: apt-get install --no-install-recommends {PACKAGES}"
            ));
        }
    }
    needs_library(CORTEX_M)?;
    command!("cargo fmt --manifest-path firmware/Cargo.toml --all --check").run()?;
    firmware("clippy", &BOARDS[0]).args(["--", "-D", "warnings"]).run()?;
    let expected = command!("cargo run --quiet --release -p seatrial-parity").read()?;
    for board in &BOARDS {
        let found = run_on(board, &build(board, "parity")?, PLAIN, &[])?;
        same(board.name, &expected, &found)?;
        let lines = found.lines().count();
        eprintln!("{}: {lines} lines of parity vectors equal bit for bit", board.name);
    }
    a_panic_path_does_not_link()?;
    BOARDS.iter().try_for_each(costs)?;
    Ok(expected)
}

fn build(board: &Board, program: &str) -> Result<PathBuf> {
    firmware("build", board).args(["--bin", program]).run()?;
    let folder = in_target("firmware").join(board.machine);
    Ok(folder.join(CORTEX_M).join("release").join(program))
}

/// Cargo in the workspace of the firmware, for a board.
fn firmware(verb: &str, board: &Board) -> Command {
    let folder = in_target("firmware").join(board.machine);
    let mut cargo = command!(
        "cargo {verb} --manifest-path firmware/Cargo.toml --release --quiet --target {CORTEX_M} --target-dir {folder}"
    );
    cargo.env("RUSTFLAGS", board.rust_flags);
    cargo
}

/// What a program prints on its board.
pub fn run_on(board: &Board, image: &Path, semihosting: &str, options: &[&str]) -> Result<String> {
    let printed = image.with_extension("stdout");
    let machine = board.machine;
    let mut emulation = command!("qemu-system-arm -machine {machine} -display none -serial none -monitor none -semihosting-config {semihosting} {options...} -kernel {image}")
        .stdin(Stdio::null())
        .stdout(std::fs::File::create(&printed)?)
        .begin()?;
    let what = format!("{} ends on {}", image.display(), board.name);
    let status = patiently(PATIENCE, &what, || Ok(emulation.0.try_wait()?))?;
    let text = shell().read_file(printed)?;
    ensure!(status.success(), "{what}: {status}\n{text}");
    Ok(text)
}

/// Names the first line that differs.
fn same(name: &str, expected: &str, found: &str) -> Result<()> {
    let mut lines = expected.lines().zip(found.lines()).enumerate();
    if let Some((line, (here, there))) = lines.find(|(_, (here, there))| here != there) {
        let number = line + 1;
        bail!("{name}: line {number} of the parity vectors differs\nhere  {here}\nthere {there}");
    }
    ensure!(expected.len() == found.len(), "{name}: not as many parity vectors as here");
    Ok(())
}

/// The images link only because nothing in them can panic: with one panic path the same image does not.
fn a_panic_path_does_not_link() -> Result<()> {
    let mut build = firmware("build", &BOARDS[0]);
    let output = build.args(["--bin", "parity", "--features", "panic-path"]).outcome()?;
    let message = String::from_utf8_lossy(&output.stderr);
    let is_told = message.contains("seatrial_has_a_panic_path");
    ensure!(
        !output.status.success() && is_told,
        "firmware: an image with a panic path should not link\n{message}"
    );
    eprintln!("no panic path in the images: with one they do not link");
    Ok(())
}

/// Instructions, stack, state and code of each step against the board's limits; counted twice.
fn costs(board: &Board) -> Result<()> {
    let image = build(board, "count")?;
    // 2^10 ns of emulated time an instruction, so that the 25 MHz timer resolves single ones.
    let count = || run_on(board, &image, PLAIN, &["-icount", "shift=10"]);
    let mut text = count()?;
    ensure!(text == count()?, "firmware: the counts do not repeat");
    for name in ["fixed_rate_step", "timed_step"] {
        text += &format!("{name},code_bytes,{}\n", code_size(&image, name)?);
    }
    eprintln!("{}, largest over a rehearsed trial:\n{text}", board.name);
    for &(name, quantity, limit) in board.limits {
        let value = text.lines().find_map(|line| line.strip_prefix(&format!("{name},{quantity},")));
        let value: u64 =
            value.with_context(|| format!("{name}: {quantity} not reported"))?.parse()?;
        ensure!(value <= limit, "{}, {name}: {value} {quantity}, at most {limit}", board.name);
    }
    Ok(())
}

/// Code of a lean step, which calls nothing.
fn code_size(image: &Path, name: &str) -> Result<u64> {
    let symbols = command!("arm-none-eabi-nm --print-size {image}").read()?;
    let symbol = symbols.lines().find(|line| line.ends_with(&format!(" {name}")));
    let size = symbol.and_then(|symbol| symbol.split_whitespace().nth(1));
    let listing = command!("arm-none-eabi-objdump --disassemble={name} {image}").read()?;
    let instructions = listing.lines().filter_map(|line| line.split('\t').nth(2));
    let mut calls = instructions
        .filter(|word| word.trim() == "bl" || word.starts_with("bl ") || word.starts_with("blx"));
    ensure!(calls.next().is_none(), "{name}: calls another function, its own size says nothing");
    let size = size.with_context(|| format!("{name}: no such symbol"))?;
    Ok(u64::from_str_radix(size, 16)?)
}
