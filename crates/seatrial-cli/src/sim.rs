//! `seatrial sim`: a simulated vehicle for others.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use clap::{Args as ClapArgs, Subcommand};
use seatrial_app::simulated_log::{SimulatedRun, SimulatedTruth, play};
use seatrial_app::trials::recording;
use seatrial_app::trials::simulator;
use seatrial_core::{List, Outcome, Plan};
use seatrial_logs::Row;
use seatrial_sim::SimulatedConfig;
use serde::Serialize;

use crate::ardupilot_json;
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
    Serve(ServeArgs),
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

/// Serve a vehicle: to a ground station over MAVLink as ArduPilot's Rover, ArduSub or PX4 do, which hold their heading until somebody
/// takes them, or with --ardupilot-json to an autopilot's own firmware as the sea under it.
#[derive(ClapArgs, Debug)]
#[command(after_help = "\
With --ardupilot-json time goes on by one frame for every new frame of ArduPilot, however long that takes. A channel is written as \
NUMBER[:MIN:TRIM:MAX] in us; MIN above MAX reverses it. A pulse of 0 is the trim. Several, with commas between them, are \
thrusters that share it: it is their mean. Without --elevator, and where it has none, the vehicle holds its depth itself. Ends \
with Ctrl-C.

ArduPilot sends to port 9002 of the address after JSON:, here as a rover that steers with channel 1 and drives with 3:
  sim_vehicle.py -v Rover --model JSON:127.0.0.1
and as ArduSub's vectored frame, with the options
  --rudder 1:1100:1500:1900,2:1900:1500:1100,3:1900:1500:1100,4:1100:1500:1900
  --throttle 1:1900:1500:1100,2:1900:1500:1100,3:1100:1500:1900,4:1100:1500:1900

Examples, those over MAVLink in two terminals:
  seatrial sim serve
  seatrial plan --thrust 0.8 --out plan.toml
  seatrial trial --vehicle mavlink:udp:127.0.0.1:14550 \\
      --full-rudder-deg 14.9 --plan plan.toml
  seatrial sim serve --ardupilot-json --vehicle sim:remus100 --rudder 4 \\
      --elevator 2 --throttle 3:1000:1000:2000 --frames 0")]
struct ServeArgs {
    /// The vehicle: sim:starfish, sim:starfish-6dof, sim:remus100 or sim:FILE.toml [default: sim:starfish; with --ardupilot-json
    /// sim:starfish-6dof].
    #[arg(long, value_name = "VEHICLE")]
    vehicle: Option<String>,
    /// Seed of noise, disturbance and waves.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    autopilot: sim_mavlink::Args,
    #[command(flatten)]
    physics: Option<ardupilot_json::Args>,
}

/// `sim log --json`: what was written, without the truth.
#[derive(Serialize)]
struct LogDocument {
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
        What::Serve(args) => serve(args, output),
    }
}

fn serve(args: &ServeArgs, output: &Output) -> Result<Exit, Failure> {
    let vehicle = |own: &'static str| args.vehicle.as_deref().unwrap_or(own);
    match &args.physics {
        Some(physics) => {
            ardupilot_json::run(vehicle("sim:starfish-6dof"), args.seed, physics, output)
        }
        None => sim_mavlink::run(vehicle("sim:starfish"), args.seed, &args.autopilot, output),
    }
}

/// Writes a simulated log.
fn log(args: &SimLogArgs, output: &Output) -> Result<Exit, Failure> {
    let format = format_of(&args.out, "--out")?;
    args.truth.as_deref().map_or(Ok(()), check_truth_name)?;
    let config = simulator::config(&args.vehicle)?;
    let mut vehicle = config
        .vehicle(args.seed)
        .map_err(|error| Failure::input(format!("{}: {error}", args.vehicle)))?;
    let played = play(&mut vehicle, plan(&args.thrust)?).map_err(Failure::usage)?;
    let rows: Vec<Row> = played.samples.iter().copied().map(Row::from).collect();
    recording::write(output.files(), &args.out, format, &rows)?;
    if let Some(path) = &args.truth {
        output.save(path, truth(path, args.seed, config, &played.runs)?)?;
    }
    let written = LogDocument {
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
    if let Some("json" | "toml") = suffix(path) {
        return Ok(());
    }
    let path = path.display();
    Err(Failure::usage(format!("--truth {path}: expected a name that ends in .json or .toml")))
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

fn text(written: &LogDocument) -> String {
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
