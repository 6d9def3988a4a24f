//! The old spellings `seatrial study` and `seatrial sim field`: they run the program `seatrial-lab`, which lies beside this one.

use std::ffi::{OsStr, OsString};
use std::process::Command;

use crate::output::{Exit, Failure, Output};

/// Verbs of seatrial-lab that were verbs below `seatrial study`, which was itself the study of estimators.
const STUDIES: [&str; 6] = [
    "faults",
    "lies",
    "commission",
    "manoeuvres",
    "surge",
    "world",
];

/// The old spelling of `seatrial-lab`.
#[derive(clap::Args, Debug)]
#[command(disable_help_flag = true)]
pub struct Args {
    /// Verb and options of seatrial-lab.
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    arguments: Vec<OsString>,
}

/// `seatrial study`.
pub fn study(args: &Args, output: &Output) -> Result<Exit, Failure> {
    let first = args.arguments.first().and_then(|word| word.to_str());
    match first.is_some_and(|word| STUDIES.contains(&word)) {
        true => run(&args.arguments, output),
        false => verb("estimators", args, output),
    }
}

/// A verb of seatrial-lab with these options.
pub fn verb(name: &str, args: &Args, output: &Output) -> Result<Exit, Failure> {
    run(&[&[name.into()], &args.arguments[..]].concat(), output)
}

/// Runs the program and ends with its exit code.
fn run(arguments: &[OsString], output: &Output) -> Result<Exit, Failure> {
    let name = format!("seatrial-lab{}", std::env::consts::EXE_SUFFIX);
    let beside = std::env::current_exe().map(|own| own.with_file_name(name));
    let program = beside.map_err(Failure::internal)?;
    if !program.is_file() {
        let words: Vec<_> = arguments.iter().map(|word| word.to_string_lossy()).collect();
        return Err(Failure::usage(format!(
            "studies are in a program of their own, seatrial-lab, which is not beside this one; in a clone of the project: cargo run --release -p seatrial-lab -- {}",
            words.join(" ")
        )));
    }
    let json = output.json.then_some(OsStr::new("--json"));
    let status = Command::new(program).args(arguments).args(json).status();
    let status = status.map_err(Failure::internal)?;
    std::process::exit(status.code().unwrap_or(Exit::Internal as i32))
}
