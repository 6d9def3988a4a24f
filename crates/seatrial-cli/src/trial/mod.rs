//! `seatrial trial`: a whole sea trial.

mod bridge;
mod text;

use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use seatrial::campaign::Campaign;
use seatrial::preview::{Target, parse_target};
use seatrial_app::conduct::conduct;
use seatrial_core::{Outcome, Plan, Trial, Vehicle};
use seatrial_dash::Server;
use seatrial_logbook::{Logbook, NewCampaign, Recorder};
use seatrial_logs::RowWriter;
use seatrial_report as report;
use seatrial_sim::FaultyVehicle;
use serde::Serialize;

use crate::autopilot::{LinkArgs, Taken};
use crate::output::{Exit, Failure, Output, say};
use crate::pitch::{self, Axis};
use crate::record::{self, Format, Recording};
use crate::ros2;
use crate::serve::{self, AccessArgs, Yard};
use crate::vehicle::{self, Simulated};
use bridge::{Bridge, Shown};
use text::text;

/// Run a whole sea trial: settle, train and validate at each speed, then gains and turning limits.
#[derive(clap::Args, Debug)]
#[command(after_help = "\
Each speed is settled, trained with a doublet and validated with a smaller one. Everything goes into the logbook.

Exit code 0: every speed has an accepted model; 4: a speed has none; 5: the trial was aborted and the vehicle
handed back; 6: finished, but something could not be saved.

Example:
  seatrial trial --seed 1 --report trial.html")]
pub struct Args {
    /// The vehicle: sim:starfish; sim:starfish-6dof or sim:remus100 of six degrees of freedom; or sim:FILE.toml
    /// for any other; mavlink:udp:HOST:PORT, which listens there, mavlink:udpout:HOST:PORT,
    /// mavlink:tcp:HOST:PORT or mavlink:serial:DEVICE:BAUD for an autopilot; ros2:FILE.toml for a vehicle on ROS 2, which
    /// needs a seatrial built with --features ros2, or ros2-zenoh.
    #[arg(long, value_name = "VEHICLE", default_value = "sim:starfish")]
    vehicle: String,
    /// Faults that befall a simulated vehicle, and sensors and sea that it meets, a TOML file as in scenarios/.
    #[arg(long, value_name = "FILE")]
    scenario: Option<PathBuf>,
    /// The axis: yaw, or pitch with elevator doublets on a vehicle of six degrees of freedom.
    #[arg(long, value_name = "AXIS", default_value = "yaw")]
    axis: Axis,
    /// Write the log of a pitch trial, CSV, for `identify --axis pitch`.
    #[arg(long, value_name = "FILE")]
    log: Option<PathBuf>,
    /// The plan, a TOML file as `seatrial plan` writes it [default: the paper's]. With --axis pitch the fields of the plan that
    /// `--json` prints.
    #[arg(long, value_name = "FILE")]
    plan: Option<PathBuf>,
    /// End the training of a run as soon as its intervals are this narrow, as in a22:10%,b2:5% [default: the plan's].
    #[arg(long, value_name = "WIDTHS", value_parser = parse_target)]
    stop_when: Option<Target>,
    /// Where everything is kept.
    #[arg(long, value_name = "FILE", default_value = "seatrial.db")]
    logbook: PathBuf,
    /// Record what the trial sees and estimates: .mcap, which Foxglove opens, .csv or .parquet. Should the trial be
    /// killed, a .csv is complete, a .mcap up to the last second, a .parquet up to the last run.
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// Show the same live to Foxglove, which connects to this port of this machine or to HOST:PORT. Needs a seatrial
    /// built with --features foxglove.
    #[arg(long, value_name = "ADDR", num_args = 0..=1, default_missing_value = "127.0.0.1:8765")]
    foxglove: Option<String>,
    /// Serve the dashboard at this address while the trial runs: anybody there may watch, operators may abort.
    #[arg(long, value_name = "ADDR", num_args = 0..=1, default_missing_value = "127.0.0.1:8042")]
    serve: Option<String>,
    #[command(flatten)]
    access: AccessArgs,
    /// Write the report, one HTML file.
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Name of the vehicle's configuration, its payload.
    #[arg(long, value_name = "NAME", default_value = "default")]
    configuration: String,
    /// Notes on the configuration.
    #[arg(long, value_name = "TEXT")]
    notes: Option<String>,
    /// Seed of a simulated vehicle.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Run a simulated vehicle no faster than a real one.
    #[arg(long)]
    realtime: bool,
    /// Keep the estimate after every sample in the JSON document.
    #[arg(long)]
    trace: bool,
    /// Do not ask before the vehicle moves and its parameters change. A simulated vehicle never asks.
    #[arg(long)]
    yes: bool,
    #[command(flatten)]
    link: LinkArgs,
}

/// What `trial --json` prints.
#[derive(Serialize)]
struct Document {
    schema: &'static str,
    #[serde(flatten)]
    campaign: Campaign,
    plan: Plan<f64>,
}

/// Runs the trial.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    match args.axis {
        Axis::Pitch => args.pitch(output),
        Axis::Yaw if args.log.is_some() => Err(Failure::usage(
            "--log goes with --axis pitch; a yaw trial is kept in the logbook, and `seatrial sim log` writes logs",
        )),
        Axis::Yaw => yaw(args, output),
    }
}

impl Args {
    fn pitch(&self, output: &Output) -> Result<Exit, Failure> {
        for (option, given) in [
            ("--stop-when", self.stop_when.is_some()),
            ("--scenario", self.scenario.is_some()),
            ("--record", self.record.is_some()),
            ("--foxglove", self.foxglove.is_some()),
            ("--serve", self.serve.is_some()),
        ] {
            if given {
                return Err(Failure::usage(format!(
                    "{option} does not go with --axis pitch"
                )));
            }
        }
        pitch::trial(
            &self.vehicle,
            self.seed,
            self.plan.as_deref(),
            &pitch::Kept {
                logbook: &self.logbook,
                configuration: &self.configuration,
                log: self.log.as_deref(),
                page: self.report.as_deref(),
            },
            output,
        )
    }

    fn server(&self, listen: &str) -> Result<Server, Failure> {
        let yard = Yard {
            vehicles: Vec::new(),
            link: self.link.clone(),
            logbook: self.logbook.clone(),
        };
        serve::start(&self.access.settings(listen, &self.logbook)?, yard)
    }
}

/// What the trial is run on.
enum On<'a> {
    Simulator(Box<FaultyVehicle<Simulated>>),
    /// Behind this address.
    Autopilot(&'a str),
    /// Described by this file.
    Ros2(&'a Path),
}

fn yaw(args: &Args, output: &Output) -> Result<Exit, Failure> {
    let mut plan = load_plan(args.plan.as_deref())?;
    plan.stop_when = args.stop_when.or(plan.stop_when);
    let stop = Arc::new(AtomicBool::new(false));
    let handler = Arc::clone(&stop);
    ctrlc::set_handler(move || handler.store(true, Ordering::Relaxed))
        .map_err(Failure::internal)?;
    let on = match args.vehicle.split_once(':') {
        Some(("mavlink", address)) => On::Autopilot(address),
        Some(("ros2", path)) => On::Ros2(Path::new(path)),
        _ => {
            let scenario = args.scenario.as_deref();
            On::Simulator(vehicle::rehearsed(&args.vehicle, scenario, args.seed)?.into())
        }
    };
    if !matches!(on, On::Simulator(_)) {
        only_simulated(args)?;
    }
    let about = Campaign {
        software_version: env!("CARGO_PKG_VERSION").into(),
        vehicle: args.vehicle.clone(),
        configuration: args.configuration.clone(),
        seed: matches!(on, On::Simulator(_)).then_some(args.seed),
        rudder_limit_rad: plan.rudder_limit_rad,
        runs: Vec::new(),
        outcome: None,
    };
    let recording = args
        .record
        .as_deref()
        .map(|path| Recording::start(path, Format::of(path, "--record")?))
        .transpose()?;
    let viewer = args.foxglove.as_deref().map(record::show).transpose()?;
    let mut viewers: Vec<Box<dyn RowWriter>> = viewer.into_iter().collect();
    let plan_text = toml::to_string_pretty(&plan).map_err(Failure::internal)?;
    let server = args.serve.as_deref().map(|listen| args.server(listen));
    let server = server.transpose()?;
    let logbook = Logbook::open(&args.logbook).map_err(Failure::from)?;
    let recorder = Recorder::begin(
        logbook,
        &NewCampaign {
            configuration: &about.configuration,
            notes: args.notes.as_deref(),
            software_version: &about.software_version,
            vehicle: &about.vehicle,
            seed: about.seed,
            rudder_limit_rad: about.rudder_limit_rad,
            plan: &plan_text,
        },
    )
    .map_err(Failure::from)?;
    let number = recorder.campaign();
    let shown = server
        .map(|server| Shown::begin(server, number, &about, &plan, &stop))
        .transpose()?;

    let (mut campaign, mut unsaved) = match on {
        On::Simulator(mut vehicle) => {
            let mut bridge = Bridge::new(args, false, recorder, recording, viewers, shown, stop);
            let mut campaign = conducted(vehicle.as_mut(), plan, about, &mut bridge)?;
            let unsaved = bridge.end(&mut campaign);
            (campaign, unsaved)
        }
        On::Autopilot(address) => {
            let mut taken = taken(args, address, &plan, &stop)?;
            let mut bridge = Bridge::new(args, true, recorder, recording, viewers, shown, stop);
            let mut campaign = conducted(&mut taken.autopilot, plan, about, &mut bridge)?;
            // The vehicle first: what is told and saved can wait.
            let handed_back = taken.hand_back();
            let mut unsaved = bridge.end(&mut campaign);
            unsaved.extend(handed_back);
            (campaign, unsaved)
        }
        On::Ros2(path) => {
            let is_given = args.plan.is_some();
            let (mut vehicle, estimates) = ros2::take(path, &plan, is_given, args.yes, &stop)?;
            viewers.push(estimates);
            let mut bridge = Bridge::new(args, true, recorder, recording, viewers, shown, stop);
            let mut campaign = conducted(&mut vehicle, plan, about, &mut bridge)?;
            let handed_back = ros2::hand_back(&mut vehicle);
            let mut unsaved = bridge.end(&mut campaign);
            unsaved.extend(handed_back);
            (campaign, unsaved)
        }
    };
    if (args.report.is_some() || args.trace)
        && let Err(error) = Logbook::open_read_only(&args.logbook)
            .and_then(|logbook| logbook.fill(number, &mut campaign))
    {
        unsaved.push(error.to_string());
    }
    let mut report = args.report.as_deref();
    if let Some(path) = report {
        let provenance = [
            ("Plan", plan_text),
            ("Logbook", args.logbook.display().to_string()),
        ];
        if let Err(error) = std::fs::write(path, report::render(&campaign, &provenance)) {
            unsaved.push(format!("{}: report not saved: {error}", path.display()));
            report = None;
        }
    }
    unsaved.dedup();
    unsaved.iter().for_each(say);
    if !args.trace {
        for run in &mut campaign.runs {
            if let Some(identification) = &mut run.identification {
                identification.online.trace.clear();
            }
        }
    }
    let exit = exit(&campaign, &plan, !unsaved.is_empty());
    let document = Document {
        schema: "seatrial.trial.v1",
        campaign,
        plan,
    };
    output.print(&document, || {
        text(&document.campaign, &args.logbook, report)
    })?;
    Ok(exit)
}

/// The campaign of a trial on this vehicle.
fn conducted<V: Vehicle<f64>>(
    vehicle: &mut V,
    plan: Plan<f64>,
    about: Campaign,
    bridge: &mut Bridge,
) -> Result<Campaign, Failure>
where
    V::Error: Display,
{
    let conducted = conduct(vehicle, plan, about, bridge)
        .map_err(|error| Failure::input(format!("the plan: {error}")))?;
    if let Some(fault) = &conducted.fault {
        bridge.tell(&format!("the vehicle was given back: {fault}"));
    }
    Ok(conducted.campaign)
}

/// Refuses what goes with a simulated vehicle.
fn only_simulated(args: &Args) -> Result<(), Failure> {
    for (option, given) in [
        ("--scenario", args.scenario.is_some()),
        ("--realtime", args.realtime),
    ] {
        if given {
            return Err(Failure::usage(format!(
                "{option} goes with a simulated vehicle"
            )));
        }
    }
    Ok(())
}

/// The autopilot at this address, ready for the trial.
fn taken(
    args: &Args,
    address: &str,
    plan: &Plan<f64>,
    stop: &Arc<AtomicBool>,
) -> Result<Taken, Failure> {
    let backup = args.logbook.with_extension("restore.toml");
    args.link
        .take(address, plan, args.plan.is_some(), args.yes, &backup, stop)
}

/// The plan of a file, or the paper's.
pub fn load_plan(path: Option<&Path>) -> Result<Plan<f64>, Failure> {
    let Some(path) = path else {
        return Ok(Plan::paper());
    };
    let text = std::fs::read_to_string(path)
        .map_err(|error| Failure::input(format!("{}: {error}", path.display())))?;
    let plan: Plan<f64> = toml::from_str(&text)
        .map_err(|error| Failure::input(format!("{}: not a plan: {error}", path.display())))?;
    Trial::new(plan)
        .map_err(|error| Failure::input(format!("{}: {error}", path.display())))
        .map(|_| plan)
}

fn exit(campaign: &Campaign, plan: &Plan<f64>, unsaved: bool) -> Exit {
    match campaign.outcome {
        Some(Outcome::Finished) if unsaved => Exit::NotSaved,
        Some(Outcome::Finished) if campaign.accepted_runs().len() == plan.thrusts.len() => {
            Exit::Done
        }
        Some(Outcome::Finished) => Exit::Rejected,
        _ => Exit::Aborted,
    }
}
