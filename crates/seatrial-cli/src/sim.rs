//! `seatrial sim`: a simulated vehicle for others.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use clap::{Args as ClapArgs, Subcommand};
use seatrial_app::recording;
use seatrial_app::simulated;
use seatrial_app::simulated_log::{SimulatedRun, SimulatedTruth, play};
use seatrial_core::{List, Outcome, Plan};
use seatrial_logs::Row;
use seatrial_sim::SimulatedConfig;
use serde::Serialize;

use crate::ardupilot_json;
use crate::lab;
use crate::output::{Exit, Failure, Output, OutputPath};
use crate::record::format_of;
use crate::sim_mavlink;

/// A simulated vehicle for others.
#[derive(ClapArgs, Debug)]
pub struct Args {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    Log(SimLogArgs),
    ArdupilotJson(ardupilot_json::Args),
    #[command(hide = true)]
    Field(lab::Args),
    Mavlink(sim_mavlink::Args),
}

/// Write the log of a simulated trial: the paper's plan at one or all of its speeds.
#[derive(ClapArgs, Debug)]
#[command(
    after_help = "Example:\n  seatrial sim log --seed 1 --thrust 0.8 --out run.csv && \\\n      seatrial identify run.csv"
)]
struct SimLogArgs {
    /// The vehicle: sim:starfish, sim:starfish-6dof or sim:remus100 of six degrees of freedom, or
    /// sim:FILE.toml.
    #[arg(long, default_value = "sim:starfish")]
    vehicle: String,
    /// Seed of noise and disturbance; the same seed gives the same log.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Thrust as a fraction of full; repeatable [default: the plan's, 0.6 to 1].
    #[arg(long, value_name = "FRACTION")]
    thrust: Vec<f64>,
    /// The log: .csv, .parquet or .mcap.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// The true parameters, kept apart from the log: .json or .toml.
    #[arg(long, value_name = "FILE")]
    truth: Option<OutputPath>,
}

/// `sim log --json`: what was written, without the truth.
#[derive(Serialize)]
struct Written {
    schema: &'static str,
    vehicle: String,
    seed: u64,
    out: String,
    samples: usize,
    runs: Vec<SimulatedRun>,
    outcome: Option<Outcome>,
}

/// Plays the vehicle.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    match &args.what {
        What::Log(args) => log(args, output),
        What::ArdupilotJson(args) => ardupilot_json::run(args, output),
        What::Field(args) => lab::verb("field", args, output),
        What::Mavlink(args) => sim_mavlink::run(args, output),
    }
}

/// Writes a simulated log.
fn log(args: &SimLogArgs, output: &Output) -> Result<Exit, Failure> {
    let format = format_of(&args.out, "--out")?;
    args.truth.as_deref().map_or(Ok(()), check_truth_name)?;
    let config = simulated::config(&args.vehicle)?;
    let mut vehicle = config
        .vehicle(args.seed)
        .map_err(|error| Failure::input(format!("{}: {error}", args.vehicle)))?;
    let played = play(&mut vehicle, plan(&args.thrust)?).map_err(Failure::usage)?;
    let rows: Vec<Row> = played.samples.iter().copied().map(Row::from).collect();
    recording::write(output.files(), &args.out, format, &rows)?;
    if let Some(path) = &args.truth {
        output.save(path, truth(path, args.seed, config, &played.runs)?)?;
    }
    let written = Written {
        schema: "seatrial.simulated_log.v1",
        vehicle: args.vehicle.clone(),
        seed: args.seed,
        out: args.out.display().to_string(),
        samples: played.samples.len(),
        runs: played.runs,
        outcome: played.outcome,
    };
    output.print(&written, || text(&written))?;
    Ok(match written.outcome {
        Some(Outcome::Finished) => Exit::Done,
        Some(Outcome::Aborted(_)) | None => Exit::Aborted,
    })
}

fn check_truth_name(path: &Path) -> Result<(), Failure> {
    match suffix(path) {
        Some("json" | "toml") => Ok(()),
        _ => Err(Failure::usage(format!(
            "--truth {}: expected a name that ends in .json or .toml",
            path.display()
        ))),
    }
}

fn suffix(path: &Path) -> Option<&str> {
    path.extension()?.to_str()
}

fn plan(thrusts: &[f64]) -> Result<Plan<f64>, Failure> {
    let paper = Plan::paper();
    if thrusts.is_empty() {
        return Ok(paper);
    }
    Ok(Plan {
        thrusts: List::from_slice(thrusts)
            .ok_or_else(|| Failure::usage("--thrust: more speeds than a trial has"))?,
        ..paper
    })
}

fn truth(
    path: &Path,
    seed: u64,
    vehicle: SimulatedConfig,
    runs: &[SimulatedRun],
) -> Result<String, Failure> {
    let truth = SimulatedTruth::of(vehicle, seed, runs).map_err(Failure::internal)?;
    match suffix(path) {
        Some("toml") => toml::to_string(&truth).map_err(Failure::internal),
        _ => serde_json::to_string_pretty(&truth).map_err(Failure::internal),
    }
}

fn text(written: &Written) -> String {
    let mut text = format!(
        "{}: {} samples of {}, seed {}\n",
        written.out, written.samples, written.vehicle, written.seed
    );
    for run in &written.runs {
        let _ = write!(text, "thrust {:3.0} %", 100.0 * run.thrust);
        if let (Some(train), Some(validate)) = (run.train, run.validate) {
            let _ = write!(
                text,
                "  training {:.2} to {:.2} s, validation {:.2} to {:.2} s",
                train.from_s, train.to_s, validate.from_s, validate.to_s
            );
        }
        text.push('\n');
    }
    match written.outcome {
        Some(Outcome::Finished) => text,
        _ => text + "the trial was aborted; the log ends there\n",
    }
}
