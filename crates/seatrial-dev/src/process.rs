//! The `seatrial` program, as it was built beside the tests of `seatrial-cli`, and `seatrial-lab` beside its own.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};

use serde_json::Value;

/// Where the program is.
///
/// # Panics
///
/// Where it has not been built. Cargo builds it for the tests in `crates/seatrial-cli/tests`, which are therefore where it can be used.
pub fn program_path() -> PathBuf {
    built("seatrial")
}

/// The program `seatrial-lab`, as it was built for the tests in `crates/seatrial-lab/tests`, to be given arguments.
pub fn lab() -> Command {
    let mut command = Command::new(built("seatrial-lab"));
    command.stdin(Stdio::null());
    command
}

fn built(name: &str) -> PathBuf {
    let program = profile().join(format!("{name}{}", std::env::consts::EXE_SUFFIX));
    assert!(program.exists(), "{} is not built", program.display());
    program
}

/// Where cargo builds.
pub(crate) fn target() -> PathBuf {
    let profile = profile();
    profile.parent().unwrap_or(&profile).to_path_buf()
}

fn profile() -> PathBuf {
    let test = std::env::current_exe().expect("a test knows where it is");
    let folder = test.ancestors().nth(2).expect("target/PROFILE/deps/TEST");
    folder.to_path_buf()
}

/// The program, to be given arguments; its standard input is empty.
pub fn program() -> Command {
    let mut command = Command::new(program_path());
    command.stdin(Stdio::null());
    command
}

/// Runs the program to its end.
pub fn run(arguments: &[&str]) -> Output {
    program().args(arguments).output().expect("seatrial starts")
}

/// Runs the program to its end in a folder.
pub fn run_in(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = program();
    command.args(arguments).current_dir(folder);
    command.output().expect("seatrial starts")
}

/// Runs the program to its end in a folder: exit code, standard output, standard error.
///
/// # Panics
///
/// Where a signal ended it, or it wrote something other than UTF-8.
pub fn run_to_text(folder: &Path, arguments: &[&str]) -> (i32, String, String) {
    let output = run_in(folder, arguments);
    let exit = output.status.code().expect("an exit code");
    (exit, text(&output.stdout), text(&output.stderr))
}

/// Starts the program in a folder, with standard output and standard error to be read.
pub fn start_in(folder: &Path, arguments: &[&str]) -> Child {
    program()
        .args(arguments)
        .current_dir(folder)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("seatrial starts")
}

/// The JSON document on standard output.
///
/// # Panics
///
/// Where there is no such document, with what was said on standard error.
pub fn document(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| {
        let stderr = String::from_utf8_lossy(&output.stderr);
        panic!("no JSON document on standard output: {error}\n{stderr}")
    })
}

/// What the program wrote, as text.
///
/// # Panics
///
/// Where it is not UTF-8.
pub fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("UTF-8")
}

/// A text on one line, its words a blank apart: lines are broken where the terminal ends.
pub fn unwrapped(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
