//! `seatrial trial`: a whole sea trial.

mod servo;
mod terminal;
mod text;

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use seatrial::CourseChange;
use seatrial::campaign::Campaign;
use seatrial::identification::{Reason, Verdict};
use seatrial::preview::{Target, parse_target};
use seatrial_app::trials::campaign_models::promised;
use seatrial_app::trials::campaign_page::page;
use seatrial_app::trials::next;
use seatrial_app::trials::order;
use seatrial_app::trials::order::{Order, OrderError, OrderResult, Sinks};
use seatrial_app::trials::recording::Recording;
use seatrial_app::trials::simulator::{slow_name, time_constant_of};
use seatrial_app::{CheckedPlan, TrialPlan, load_plan};
use seatrial_core::{Axis, Outcome};
use seatrial_logbook::{CampaignId, Circumstances, Logbook};
use seatrial_report::{About, render};
use serde::Serialize;

use crate::autopilot::LinkArgs;
use crate::choice::{AXES, one_of};
use crate::interrupt::{interrupted, unless_asked};
use crate::output::{Exit, Failure, Output, OutputPath, say};
use crate::record::{format_of, show};
use crate::screen::width;
use crate::serve::{self, AccessArgs};
use crate::vehicle;
pub use servo::ServoArgs;
use terminal::Terminal;
use text::text;

/// Run a whole sea trial: settle, train and validate at each speed, then gains and turning limits.
#[derive(clap::Args, Debug)]
#[command(after_help = "\
Each speed is settled, trained with a doublet and validated with a smaller one. Everything goes into the logbook.

Exit code 0: the outcome is use or use with care; 4: not validated or do not use; 5: the trial was aborted \
and the vehicle handed back; 6: finished, but something could not be saved.

Example:
  seatrial trial --seed 1 --report trial.html")]
pub struct Args {
    /// The vehicle: sim:starfish; sim:starfish-6dof or sim:remus100 of six degrees of freedom; or sim:FILE.toml
    /// for any other; mavlink:udp:HOST:PORT, which listens there, mavlink:udpout:HOST:PORT,
    /// mavlink:tcp:HOST:PORT or mavlink:serial:DEVICE:BAUD for an autopilot; ros2:FILE.toml for a vehicle on ROS 2, which
    /// needs a seatrial built with --features ros2, or ros2-zenoh.
    /// sim:slow:T is simulated, too, with a time constant of T s [default: sim:starfish, or one as slow as the plan is for].
    #[arg(long, value_name = "VEHICLE")]
    vehicle: Option<String>,
    /// Faults that befall a simulated vehicle, and sensors and sea that it meets: one that comes with the program, as bad_compass,
    /// or a TOML file as docs/faults.md describes.
    #[arg(long, value_name = "NAME|FILE")]
    scenario: Option<PathBuf>,
    /// The axis: yaw, or pitch with elevator doublets on a vehicle of six degrees of freedom [default: the plan's].
    #[arg(long, value_name = "AXIS", value_parser = one_of(AXES))]
    axis: Option<Axis>,
    /// The plan, a TOML file as `seatrial plan` writes it [default: the paper's]. Of pitch it names what differs from the plan that
    /// `trial --axis pitch --json` prints.
    #[arg(long, value_name = "FILE")]
    plan: Option<PathBuf>,
    /// End the training of a run as soon as its intervals are this narrow, as in a22:10%,b2:5% [default: the plan's].
    #[arg(long, value_name = "WIDTHS", value_parser = parse_target)]
    stop_when: Option<Target>,
    #[command(flatten)]
    servo: ServoArgs,
    /// Where everything is kept.
    #[arg(long, value_name = "FILE", default_value = "seatrial.db")]
    logbook: PathBuf,
    /// Record what the trial sees and estimates: .mcap, which Foxglove opens, .csv or .parquet. Should the trial be
    /// killed, a .csv is complete, a .mcap up to the last second, a .parquet up to the last run.
    #[arg(long, value_name = "FILE")]
    record: Option<OutputPath>,
    /// Show what is recorded live to Foxglove, which connects to this port of this machine or to HOST:PORT. Needs a seatrial
    /// built with --features foxglove.
    #[arg(long, value_name = "ADDR", num_args = 0..=1, default_missing_value = "127.0.0.1:8765")]
    foxglove: Option<String>,
    /// Serve the dashboard at this address while the trial runs: anybody there may watch, operators may abort.
    #[arg(long, value_name = "ADDR", num_args = 0..=1, default_missing_value = "127.0.0.1:8042")]
    serve: Option<String>,
    /// Write the report, one HTML file.
    #[arg(long, value_name = "FILE")]
    report: Option<OutputPath>,
    /// Name of the vehicle's configuration, its payload.
    #[arg(long, value_name = "NAME", default_value = "default")]
    configuration: String,
    /// Notes on the configuration.
    #[arg(long, value_name = "TEXT")]
    notes: Option<String>,
    /// Who conducts the trial; stands in the report and in the logbook's audit trail.
    #[arg(long, value_name = "NAME")]
    operator: Option<String>,
    /// Where the trial is; stands in the report and in the logbook's audit trail.
    #[arg(long, value_name = "TEXT")]
    place: Option<String>,
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
    access: AccessArgs,
    #[command(flatten)]
    link: LinkArgs,
}

/// What `trial --json` prints.
#[derive(Serialize)]
struct Document {
    schema: &'static str,
    /// What speaks against one vehicle having run all speeds.
    contradictions: Vec<Reason>,
    /// May the models be used, as a whole?
    verdict: Verdict,
    /// The overshoot of a course change with the gains of the accepted runs.
    #[serde(skip_serializing_if = "Option::is_none")]
    first_answer: Option<CourseChange>,
    #[serde(flatten)]
    campaign: Campaign,
    plan: TrialPlan,
}

/// Runs the trial of a simulated vehicle so many times faster than a real one.
pub fn rehearse(args: &Args, times_faster: f64, output: &Output) -> Result<Exit, Failure> {
    conduct(args, Some(times_faster), output)
}

/// Runs the trial.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    conduct(args, None, output)
}

impl Args {
    /// The plan of the file, else one for the time constant of a simulated vehicle that is named by it, changed as the options say.
    fn plan(&self) -> Result<CheckedPlan, Failure> {
        let mut plan = *load_plan(self.plan.as_deref(), self.axis)?;
        let named = self.vehicle.as_deref().filter(|_| self.plan.is_none());
        if let Some(time_constant_s) = named.and_then(time_constant_of)
            && plan.axis.is_yaw()
        {
            plan = TrialPlan::for_time_constant(time_constant_s, plan.sample_interval_s);
        }
        plan.stop_when = self.stop_when.or(plan.stop_when);
        let plan = plan.behind_servo(self.servo.rudder_delay, self.servo.rudder_lag)?;
        Ok(plan.checked().map_err(OrderError::Plan)?)
    }

    /// The vehicle that is named, else a simulated one that is as slow as the plan is for.
    fn vehicle(&self, plan: &TrialPlan) -> String {
        let as_slow = || plan.time_constant_s.map(slow_name);
        let named = self.vehicle.clone().or_else(as_slow);
        named.unwrap_or_else(|| "sim:starfish".into())
    }

    fn order(&self, plan: CheckedPlan, times_faster: Option<f64>, stop: Arc<AtomicBool>) -> Order {
        Order {
            plan,
            plan_is_given: self.plan.is_some(),
            seed: self.seed,
            configuration: self.configuration.clone(),
            notes: self.notes.clone(),
            circumstances: Circumstances {
                operator: self.operator.clone(),
                place: self.place.clone(),
                firmware: None,
            },
            realtime_factor: times_faster.or(self.realtime.then_some(1.0)),
            is_agreed: self.yes,
            stop,
        }
    }

    fn sinks(&self, vehicle: &str, output: &Output) -> Result<Sinks, Failure> {
        let recording = self.record.as_ref().map(|path| {
            let format = format_of(path, "--record")?;
            let (files, place) = (output.files().clone(), path.clone());
            let started = unless_asked(move || Recording::start(&files, &place, format));
            Ok::<_, Failure>(started.ok_or_else(|| Failure::held_up(path))??)
        });
        let viewer = self.foxglove.as_deref().map(show).transpose()?;
        Ok(Sinks {
            logbook: self.logbook.clone(),
            recording: recording.transpose()?,
            rows: viewer.into_iter().collect(),
            views: vec![Box::new(Terminal::new(vehicle))],
        })
    }
}

fn conduct(args: &Args, times_faster: Option<f64>, output: &Output) -> Result<Exit, Failure> {
    let plan = args.plan()?;
    let stop = interrupted().map_err(Failure::internal)?;
    let scenario = args.scenario.as_deref();
    let name = args.vehicle(&plan);
    let vehicle = vehicle::named(&name, scenario, &args.link, &args.logbook)?;
    if !vehicle.is_simulated() {
        only_simulated(args)?;
    }
    let mut sinks = args.sinks(&name, output)?;
    let dashboard = (args.serve.as_deref())
        .map(|listen| serve::beside(listen, &args.access, &args.logbook, &stop))
        .transpose()?;
    let server = dashboard.map(|(server, shown)| {
        sinks.views.push(shown);
        server
    });
    let ended =
        order::begin(vehicle.as_ref(), args.order(plan, times_faster, stop), sinks)?.conduct();
    if let Some(server) = server {
        server.stop();
    }
    finish(args, *plan, ended, output)
}

/// Writes the report, says what could not be saved, and prints the campaign.
fn finish(
    args: &Args,
    plan: TrialPlan,
    ended: OrderResult,
    output: &Output,
) -> Result<Exit, Failure> {
    let OrderResult { number, mut campaign, is_kept, mut unsaved, .. } = ended;
    if (args.report.is_some() || args.trace)
        && let Err(error) = Logbook::open_read_only(&args.logbook)
            .and_then(|logbook| logbook.fill(number, &mut campaign))
    {
        unsaved.push(error.to_string());
    }
    let mut report = args.report.as_deref();
    if let Some(path) = report
        && let Err(failure) = output.save(path, report_page(args, &plan, number, &campaign))
    {
        unsaved.push(failure.to_string());
        report = None;
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
    let exit = exit(&campaign, !unsaved.is_empty());
    let verdict = campaign.verdict();
    let document = Document {
        schema: "seatrial.trial.v1",
        contradictions: campaign.contradictions(),
        first_answer: promised(&campaign).filter(|_| verdict.accepted),
        verdict,
        campaign,
        plan,
    };
    output.print(&document, || {
        let logbook = is_kept.then_some(args.logbook.as_path());
        text(&document.campaign, number, logbook, report, width())
    })?;
    Ok(exit)
}

/// The report. The campaign is the one at hand: its samples need not be read again.
fn report_page(args: &Args, plan: &TrialPlan, number: CampaignId, campaign: &Campaign) -> String {
    let kept = Logbook::open_read_only(&args.logbook).and_then(|logbook| {
        let entry = logbook.entry(number)?;
        let circumstances = logbook.circumstances(number)?;
        Ok(page(&logbook, &entry, campaign, &circumstances))
    });
    // A logbook that cannot be read any more was told of already; the trial is reported all the same.
    kept.unwrap_or_else(|_| {
        let about = About { plan: Some(&plan.plan), ..About::default() };
        let command = next::after_trial(campaign, number, &args.logbook, None);
        render(campaign, &about, &command)
    })
}

/// Refuses what goes with a simulated vehicle.
fn only_simulated(args: &Args) -> Result<(), Failure> {
    let options = [("--scenario", args.scenario.is_some()), ("--realtime", args.realtime)];
    match options.iter().find(|(_, is_given)| *is_given) {
        Some((option, _)) => Err(Failure::usage(format!("{option} goes with a simulated vehicle"))),
        None => Ok(()),
    }
}

fn exit(campaign: &Campaign, unsaved: bool) -> Exit {
    match campaign.outcome {
        Some(Outcome::Finished) if unsaved => Exit::NotSaved,
        Some(Outcome::Finished) => Exit::of(&campaign.verdict()),
        _ => Exit::Aborted,
    }
}
