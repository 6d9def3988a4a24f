//! `seatrial vehicle`: looks at a vehicle before a trial, restores an autopilot after one that was cut short.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use clap::Subcommand;
use seatrial::words::three_figures;
use seatrial_app::load_plan;
use seatrial_app::trials::vehicles::{
    compared, hand_back_text, inspect_ros2, read_backup, restored,
};
use seatrial_links::autopilot::{Autopilot, Backup, HandBack};
use seatrial_links::handover::Preflight;
use seatrial_links::link::Transport;
use serde::Serialize;

use crate::autopilot::{LinkArgs, address, agrees, change_line, check_line};
use crate::identify::call;
use crate::output::{Exit, Failure, Output, say};
use crate::screen::{command, labelled, width};
use crate::table::Table;

/// Look at an autopilot before a trial, or put it back after a trial that was cut short.
///
/// Says whether a trial would be refused, without touching the controls. Exit 0: ready; 4: not, with the reasons.
#[derive(clap::Args, Debug)]
#[command(
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    after_help = "Example, on a boat that `seatrial sim serve` plays in another terminal:
  seatrial plan --thrust 0.8 --out plan.toml
  seatrial vehicle --vehicle mavlink:udp:127.0.0.1:14550 \\
      --full-rudder-deg 14.9 --plan plan.toml"
)]
pub struct Args {
    #[command(subcommand)]
    what: Option<What>,
    #[command(flatten)]
    check: CheckArgs,
}

#[derive(Debug, Subcommand)]
enum What {
    /// Put back the parameters and the mode that a trial has changed: shows each as it is and as it will be, and asks. Exit 0: done and
    /// read back; 4: not all of it; 5: not agreed to.
    #[command(after_help = "Example:
  seatrial vehicle restore seatrial.old-gains.toml \\
      --vehicle mavlink:udp:127.0.0.1:14550")]
    Restore(RestoreArgs),
}

#[derive(clap::Args, Debug)]
struct CheckArgs {
    /// The vehicle: mavlink:udp:HOST:PORT, mavlink:udpout:HOST:PORT, mavlink:tcp:HOST:PORT, mavlink:serial:DEVICE:BAUD
    /// or ros2:FILE.toml.
    #[arg(long, value_name = "VEHICLE", required = true)]
    vehicle: Option<String>,
    /// The plan, a TOML file as `seatrial plan` writes it.
    #[arg(long, value_name = "FILE")]
    plan: Option<PathBuf>,
    #[command(flatten)]
    link: LinkArgs,
}

#[derive(clap::Args, Debug)]
struct RestoreArgs {
    /// What a trial has left: LOGBOOK.restore.toml.
    #[arg(value_name = "FILE")]
    backup: PathBuf,
    /// The vehicle.
    #[arg(long, value_name = "VEHICLE")]
    vehicle: String,
    /// Do not ask before the parameters are written.
    #[arg(long)]
    yes: bool,
    #[command(flatten)]
    link: LinkArgs,
}

#[derive(Serialize)]
struct CheckDocument {
    schema: &'static str,
    ready: bool,
    #[serde(flatten)]
    preflight: Preflight,
}

#[derive(Serialize)]
struct RestoreDocument {
    schema: &'static str,
    complete: bool,
    #[serde(flatten)]
    done: HandBack,
}

/// Runs the verb.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    match &args.what {
        Some(What::Restore(args)) => restore(args, output),
        None => check(&args.check, output),
    }
}

fn check(args: &CheckArgs, output: &Output) -> Result<Exit, Failure> {
    let no_vehicle = || Failure::usage("say which vehicle with --vehicle VEHICLE");
    let vehicle = args.vehicle.as_deref().ok_or_else(no_vehicle)?;
    let plan = load_plan(args.plan.as_deref(), None)?;
    let abort = Arc::new(AtomicBool::new(false));
    let is_given = args.plan.is_some();
    let preflight = match vehicle.strip_prefix("ros2:") {
        Some(path) => inspect_ros2(Path::new(path), &plan, is_given)?,
        None => {
            args.link.options()?.open(address(vehicle)?, Some(&plan), is_given, &abort)?.inspect()
        }
    };
    let checked =
        CheckDocument { schema: "seatrial.preflight.v1", ready: preflight.is_passed(), preflight };
    output
        .print(&checked, || text(&checked.preflight) + "\n" + &verdict(&checked.preflight, args))?;
    Ok(Exit::done_if(checked.ready))
}

/// A preflight for people.
fn text(preflight: &Preflight) -> String {
    let checks = preflight.checks.iter();
    let checks = checks.map(|check| check_line(check.passed, &check.name, &check.text));
    let changes = preflight.changes.iter().map(change_line);
    checks.chain(changes).collect::<Vec<_>>().join("\n")
}

/// May a trial be run, and what is to be done next?
fn verdict(preflight: &Preflight, args: &CheckArgs) -> String {
    let failed: Vec<&str> = preflight
        .checks
        .iter()
        .filter(|check| !check.passed)
        .map(|check| check.name.as_str())
        .collect();
    let width = width();
    match (failed.is_empty(), &args.plan) {
        (true, Some(_)) => {
            let next =
                call().replacen("vehicle check", "vehicle", 1).replacen("vehicle", "trial", 1);
            "READY\n".to_owned() + &command("Next   ", &next, width)
        }
        _ => {
            let cause = format!("A trial would be refused for: {}.", failed.join(", "));
            "NOT READY\n".to_owned()
                + &labelled("Cause  ", &cause, width)
                + &labelled("Do     ", "Do what these lines say, then check again.", width)
        }
    }
}

fn restore(args: &RestoreArgs, output: &Output) -> Result<Exit, Failure> {
    if !args.backup.exists() {
        return Err(Failure::input(format!(
            "{}: no such file: nothing of a trial is left to put back, or it was put back already; a trial that is cut short leaves the file beside its logbook",
            args.backup.display()
        )));
    }
    let backup = read_backup(&args.backup)?;
    let abort = Arc::new(AtomicBool::new(false));
    let mut autopilot = args.link.options()?.open(address(&args.vehicle)?, None, false, &abort)?;
    if !args.yes {
        agree(args, &mut autopilot, &backup)?;
    }
    let done = restored(&mut autopilot, &backup, &args.backup).map_err(Failure::not_saved)?;
    let restored =
        RestoreDocument { schema: "seatrial.restored.v1", complete: done.is_complete(), done };
    output.print(&restored, || restored_text(&restored.done))?;
    Ok(Exit::done_if(restored.complete))
}

/// Shows what would be written, and asks.
fn agree(
    args: &RestoreArgs,
    autopilot: &mut Autopilot<Transport>,
    backup: &Backup,
) -> Result<(), Failure> {
    let values = compared(autopilot, backup, &args.vehicle)?;
    for value in &values {
        let from = value.from.map_or_else(|| "not answered".into(), figures);
        say(format!("{:17} {from} -> {}", value.name, figures(value.to)));
    }
    if let Some(mode) = backup.mode {
        say(format!("mode              back to {mode}, unless somebody has chosen another since"));
    }
    match agrees("Write these? [y/N] ")? {
        true => Ok(()),
        false => Err(Failure::aborted("not agreed to; nothing was written")),
    }
}

/// What was put back: each parameter as it was and as it is now.
fn restored_text(done: &HandBack) -> String {
    let mut table = Table::under("parameter | was | is now");
    for value in &done.values {
        table.row(vec![
            value.name.clone(),
            value.from.map_or_else(|| "-".into(), figures),
            figures(value.to),
        ]);
    }
    let text = labelled("", &hand_back_text(done), width());
    match done.values.is_empty() {
        true => text,
        false => format!("{table}{text}"),
    }
}

/// A whole number as it is, another with three figures.
fn figures(value: f64) -> String {
    match value.fract() == 0.0 && value.abs() < 1e6 {
        true => value.to_string(),
        false => three_figures(value),
    }
}
