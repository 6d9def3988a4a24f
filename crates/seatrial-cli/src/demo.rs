//! `seatrial demo`: a rehearsal at reading speed.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use clap::Parser;

use crate::output::{Exit, Failure, Output, say};
use crate::trial;

/// Play a whole trial on a simulated vehicle at reading speed, with a picture in the terminal, and open its report.
#[derive(clap::Args, Debug)]
#[command(after_help = "\
The 225 s of the trial take half a minute. Nothing but the logbook and the report is written.

Example:
  seatrial demo --speed 100")]
pub struct Args {
    /// How many times faster than a real vehicle.
    #[arg(long, value_name = "TIMES", default_value_t = 8.0, value_parser = times)]
    speed: f64,
    /// The logbook and, ending in .html, the report.
    #[arg(long, value_name = "FILE", default_value = "demo.db")]
    logbook: PathBuf,
    /// Do not open the report in a browser.
    #[arg(long)]
    no_open: bool,
}

fn times(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(times) if times >= 1.0 && f64::is_finite(times) => Ok(times),
        _ => Err("expected a number from 1".into()),
    }
}

/// The options of `trial`, as the demonstration gives them.
#[derive(Parser)]
struct Trial {
    #[command(flatten)]
    args: trial::Args,
}

/// Runs the verb.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    let report = args.logbook.with_extension("html");
    let options = [
        "trial".as_ref(),
        "--logbook".as_ref(),
        args.logbook.as_os_str(),
        "--report".as_ref(),
        report.as_os_str(),
    ];
    let trial = Trial::try_parse_from(options).map_err(Failure::internal)?;
    let exit = trial::rehearse(&trial.args, args.speed, output)?;
    if !args.no_open && std::io::stdout().is_terminal() && report.exists() {
        open(&report);
    }
    Ok(exit)
}

/// Opens a page in the browser of this desktop, or says where it lies.
fn open(page: &Path) {
    let opener = match std::env::consts::OS {
        "macos" => "open",
        "windows" => "explorer",
        _ => "xdg-open",
    };
    let started =
        Command::new(opener).arg(page).stdout(Stdio::null()).stderr(Stdio::null()).spawn();
    if started.is_err() {
        say(format_args!("open {} in a browser", page.display()));
    }
}
