//! `seatrial logbook`: the results database.

use std::fmt::Write;
use std::path::PathBuf;

use clap::Subcommand;
use seatrial::Step;
use seatrial::campaign::{Campaign, Run};
use seatrial::difference::{Difference, ThrustDifference};
use seatrial::figures::{r2_text, with_decimals, within};
use seatrial::identification::Identification;
use seatrial_app::models::{campaign_named, campaign_numbered};
use seatrial_core::Outcome;
use seatrial_logbook::{CampaignEntry, Error, Logbook, PitchEntry, State, Verification};
use serde::Serialize;

use crate::output::{Exit, Failure, Output};
use crate::pitch::{self, Axis};
use crate::table::decimals;

/// Results of earlier trials: list, show, compare, export, verify.
#[derive(clap::Args)]
#[command(after_help = "Example:
  seatrial trial --yes --logbook seatrial.db
  seatrial logbook show --logbook seatrial.db")]
pub struct Args {
    #[command(subcommand)]
    action: LogbookAction,
    /// The logbook.
    #[arg(
        long,
        global = true,
        default_value = "seatrial.db",
        value_name = "FILE"
    )]
    logbook: PathBuf,
}

#[derive(Subcommand)]
enum LogbookAction {
    /// Every campaign and pitch trial: when, on what, how many runs were accepted.
    List,
    /// One campaign: every run with its model, its intervals and its verdict.
    Show {
        /// Number of the campaign, or of the pitch trial; the last one where it is left out.
        campaign: Option<i64>,
        /// A campaign, or a trial of the pitch axis.
        #[arg(long, value_name = "AXIS", default_value = "yaw")]
        axis: Axis,
    },
    /// Two campaigns side by side, thrust by thrust: has the vehicle changed?
    Diff {
        /// Number of a campaign, or name of a configuration (its last campaign).
        a: String,
        /// The other one.
        b: String,
    },
    /// Samples and actions as CSV; with --json the results.
    Export {
        /// Number of the campaign, or of the pitch trial; the last one where it is left out.
        campaign: Option<i64>,
        /// Only this run.
        #[arg(long, value_name = "NUMBER")]
        run: Option<u32>,
        /// A campaign, or the log of a trial of the pitch axis.
        #[arg(
            long,
            value_name = "AXIS",
            default_value = "yaw",
            conflicts_with = "run"
        )]
        axis: Axis,
        /// Write to this file instead of standard output.
        #[arg(long, value_name = "FILE")]
        out: Option<PathBuf>,
    },
    /// Proves that nothing is damaged or altered; otherwise says what and where, exit 3.
    Verify,
}

/// Runs the verb.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    let logbook = Logbook::open_read_only(&args.logbook)?;
    match &args.action {
        LogbookAction::List => list(&logbook, output),
        LogbookAction::Show { campaign, axis } => match axis {
            Axis::Yaw => show(&logbook, *campaign, output),
            Axis::Pitch => pitch::show(&logbook, *campaign, output),
        },
        LogbookAction::Diff { a, b } => diff(&logbook, a, b, output),
        LogbookAction::Export {
            campaign,
            run,
            axis,
            out,
        } => match axis {
            Axis::Yaw => export(&logbook, *campaign, *run, out.as_ref(), output),
            Axis::Pitch => pitch::export(&logbook, *campaign, out.as_deref(), output),
        },
        LogbookAction::Verify => verify(&logbook, output),
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        if error.is_not_saved() {
            Self::not_saved(error)
        } else {
            Self::input(error)
        }
    }
}

#[derive(Serialize)]
struct List {
    schema: &'static str,
    campaigns: Vec<CampaignEntry>,
    pitch_trials: Vec<PitchEntry>,
}

fn list(logbook: &Logbook, output: &Output) -> Result<Exit, Failure> {
    let list = List {
        schema: "seatrial.logbook_list.v1",
        campaigns: logbook.campaigns()?,
        pitch_trials: logbook.pitch_trials()?,
    };
    output.print(&list, || {
        if list.campaigns.is_empty() && list.pitch_trials.is_empty() {
            return "no campaign yet".into();
        }
        let mut text = String::from(
            "campaign  started (UTC)         accepted  state          vehicle, configuration\n",
        );
        for entry in &list.campaigns {
            let _ = writeln!(
                text,
                "{:>8}  {}  {:>3} of {:<2} {:<14} {}, {}",
                entry.id.0,
                entry.started,
                entry.runs_accepted,
                entry.runs,
                state_word(entry.state),
                entry.vehicle,
                entry.configuration,
            );
        }
        for entry in &list.pitch_trials {
            let accepted = entry.runs.iter().filter(|run| run.is_accepted());
            let state = match entry.aborted {
                Some(_) => "aborted",
                None => "finished",
            };
            let _ = writeln!(
                text,
                "{:>8}  {}  {:>3} of {:<2} {state:<14} {}, {}",
                format!("pitch {}", entry.number),
                entry.entered,
                accepted.count(),
                entry.runs.len(),
                entry.vehicle,
                entry.configuration,
            );
        }
        text
    })?;
    Ok(Exit::Done)
}

#[derive(Serialize)]
struct Results<'a> {
    schema: &'static str,
    campaign: &'a CampaignEntry,
    runs: Vec<Run>,
}

fn show(logbook: &Logbook, number: Option<i64>, output: &Output) -> Result<Exit, Failure> {
    let entry = campaign_numbered(logbook, number)?;
    let mut campaign = logbook.campaign(entry.id)?;
    for identification in campaign
        .runs
        .iter_mut()
        .filter_map(|run| run.identification.as_mut())
    {
        identification.online.trace.clear();
    }
    let results = Results {
        schema: "seatrial.logbook_campaign.v1",
        campaign: &entry,
        runs: campaign.runs,
    };
    output.print(&results, || {
        let mut text = heading(&entry);
        let _ = writeln!(
            text,
            "run  thrust    m/s  {:^18}{:^18}{:^20}{:^20}   T s  K 1/s    R^2  verdict",
            "a22 1/s", "b2 1/s^2", "C0 rad/s^2", "delta0 rad"
        );
        results
            .runs
            .iter()
            .for_each(|run| write_run(&mut text, run));
        text
    })?;
    Ok(Exit::Done)
}

fn heading(entry: &CampaignEntry) -> String {
    let seed = entry
        .seed
        .map_or(String::new(), |seed| format!(", seed {seed}"));
    let notes = entry
        .notes
        .as_ref()
        .map_or(String::new(), |notes| format!("\n{notes}"));
    format!(
        "campaign {}, {}, {}{seed}, configuration {}, seatrial {}: {}{notes}\n",
        entry.id.0,
        entry.started,
        entry.vehicle,
        entry.configuration,
        entry.software_version,
        state_word(entry.state),
    )
}

/// Two lines: the model, and under it the 95 % intervals.
fn write_run(text: &mut String, run: &Run) {
    let verdict = &run.verdict;
    let outcome = verdict.outcome().name();
    let verdict = match verdict.cause() {
        Some(cause) if verdict.outcome() != seatrial::identification::Outcome::Use => {
            format!("{outcome}: {}", cause.text)
        }
        _ => outcome.into(),
    };
    let model = run.identification.as_ref().map(Identification::model);
    let nomoto = model.and_then(|model| model.nomoto());
    let r2 = run
        .identification
        .as_ref()
        .and_then(|i| i.validation.as_ref()?.judged_r2_heading());
    let _ = writeln!(
        text,
        "{:>3}  {:>4.0} %  {:>5}  {:^18}{:^18}{:^20}{:^20} {:>5}  {:>5}  {:>5}  {verdict}",
        run.number,
        run.thrust * 100.0,
        digits(run.surge_speed_m_s, 2),
        digits(model.map(|model| model.a22_per_s), 3),
        digits(model.map(|model| model.b2_per_s2), 3),
        digits(model.map(|model| model.c0_rad_per_s2), 5),
        digits(model.and_then(|model| model.delta0_rad()), 5),
        digits(nomoto.map(|nomoto| nomoto.t_s), 2),
        digits(nomoto.map(|nomoto| nomoto.k_per_s), 2),
        r2_text(r2),
    );
    if let Some(refined) = run.identification.as_ref().and_then(|i| i.refined.as_ref()) {
        let intervals = &refined.interval_95;
        let _ = writeln!(
            text,
            "{:20}{:^18}{:^18}{:^20}{:^20}",
            "",
            interval(Some(intervals.a22_per_s)),
            interval(Some(intervals.b2_per_s2)),
            interval(Some(intervals.c0_rad_per_s2)),
            interval(intervals.delta0_rad),
        );
    }
}

fn digits(value: Option<f64>, places: usize) -> String {
    value.map_or("-".into(), |value| {
        with_decimals(value, decimals(value, places))
    })
}

fn interval(interval: Option<[f64; 2]>) -> String {
    interval.map_or("-".into(), |interval| {
        let [low, high] = interval.map(|bound| within(bound, Some(interval)));
        format!("[{low} {high}]")
    })
}

fn state_word(state: State) -> String {
    match state {
        State::Ended {
            outcome: Outcome::Finished,
        } => "finished".into(),
        State::Ended {
            outcome: Outcome::Aborted(reason),
        } => format!("aborted: {reason:?}"),
        State::Unfinished => "not finished".into(),
        State::Interrupted => "interrupted".into(),
    }
}

#[derive(Serialize)]
struct Diff<'a> {
    schema: &'static str,
    a: &'a CampaignEntry,
    b: &'a CampaignEntry,
    #[serde(flatten)]
    difference: Difference,
}

fn diff(logbook: &Logbook, a: &str, b: &str, output: &Output) -> Result<Exit, Failure> {
    let (a, b) = (campaign_named(logbook, a)?, campaign_named(logbook, b)?);
    let campaigns: [Campaign; 2] = [logbook.campaign(a.id)?, logbook.campaign(b.id)?];
    let diff = Diff {
        schema: "seatrial.logbook_diff.v1",
        a: &a,
        b: &b,
        difference: Difference::between(&campaigns[0], &campaigns[1]),
    };
    output.print(&diff, || {
        let mut text = format!("A: {}B: {}", heading(&a), heading(&b));
        diff.difference
            .thrusts
            .iter()
            .for_each(|at| write_difference(&mut text, at));
        for (thrusts, name) in [
            (&diff.difference.only_in_a, "A"),
            (&diff.difference.only_in_b, "B"),
        ] {
            for thrust in thrusts {
                let _ = writeln!(
                    text,
                    "{:.0} %: only {name} has an accepted run",
                    thrust * 100.0
                );
            }
        }
        if diff.difference.thrusts.is_empty() {
            text += "no thrust at which both have an accepted run\n";
        }
        text
    })?;
    Ok(Exit::Done)
}

fn write_difference(text: &mut String, at: &ThrustDifference) {
    let [a, b] = at.surge_speed_m_s.map(|speed| digits(speed, 2));
    let _ = writeln!(text, "{:.0} %, {a} and {b} m/s", at.thrust * 100.0);
    for (name, parameter) in at.parameters() {
        let words = match parameter.ratio {
            Some(ratio) if ratio.abs() > 1.0 => format!(
                "B is {}, by {:.1} times the combined interval",
                if ratio > 0.0 { "higher" } else { "lower" },
                ratio.abs()
            ),
            Some(ratio) => format!("the same within the intervals ({ratio:+.1} of it)"),
            None => "an interval is missing".into(),
        };
        let _ = writeln!(
            text,
            "  {name:<7} {:>9.5} {:>9.5} {:>+9.5}  {words}",
            parameter.a, parameter.b, parameter.difference
        );
    }
}

fn export(
    logbook: &Logbook,
    number: Option<i64>,
    run: Option<u32>,
    out: Option<&PathBuf>,
    output: &Output,
) -> Result<Exit, Failure> {
    let entry = campaign_numbered(logbook, number)?;
    let runs = logbook.runs(entry.id)?;
    if let Some(run) = run
        && runs.iter().all(|entry| entry.number != run)
    {
        return Err(Failure::input(format!(
            "{}: campaign {} has no run {run}; it has {}",
            logbook.path().display(),
            entry.id.0,
            runs.len()
        )));
    }
    let chosen = || {
        runs.iter()
            .filter(|entry| run.is_none_or(|run| entry.number == run))
    };
    let results = Results {
        schema: "seatrial.logbook_results.v1",
        campaign: &entry,
        runs: chosen()
            .map(|run| logbook.run(run.id))
            .collect::<Result<_, _>>()?,
    };
    let mut csv = format!("run,stage,{},action_outcome\n", Step::COLUMNS.join(","));
    for (number, step) in logbook.steps(entry.id)? {
        if run.is_none() || number == run {
            write_csv_row(&mut csv, number, &step);
        }
    }
    let Some(out) = out else {
        output.print(&results, || csv)?;
        return Ok(Exit::Done);
    };
    let written = if output.json {
        serde_json::to_string_pretty(&results).map_err(Failure::internal)?
    } else {
        csv
    };
    std::fs::write(out, written)
        .map_err(|error| Failure::not_saved(format!("{}: {error}", out.display())))?;
    Ok(Exit::Done)
}

/// Numbers as the shortest text that reads back to the same bits.
fn write_csv_row(csv: &mut String, run: Option<u32>, step: &Step) {
    let stage = step
        .stage
        .map_or(String::new(), |stage| format!("{stage:?}").to_lowercase());
    let run = run.map_or(String::new(), |run| run.to_string());
    let _ = write!(csv, "{run},{stage}");
    for number in step.numbers() {
        let _ = match number {
            Some(number) => write!(csv, ",{number:?}"),
            None => write!(csv, ","),
        };
    }
    let outcome = step.action.outcome.map_or(String::new(), |outcome| {
        state_word(State::Ended { outcome })
    });
    let _ = writeln!(csv, ",{outcome}");
}

#[derive(Serialize)]
struct Verified {
    schema: &'static str,
    whole: bool,
    #[serde(flatten)]
    verification: Verification,
}

fn verify(logbook: &Logbook, output: &Output) -> Result<Exit, Failure> {
    let verification = logbook.verify()?;
    let verified = Verified {
        schema: "seatrial.logbook_verification.v1",
        whole: verification.damage.is_empty(),
        verification,
    };
    output.print(&verified, || {
        let found = &verified.verification;
        let mut text = format!(
            "{}: {} campaigns ({} not finished), {} finished runs, {} unfinished, {} pitch trials, {} samples: {}\n",
            logbook.path().display(),
            found.campaigns,
            found.campaigns_unfinished,
            found.runs_finished,
            found.runs_unfinished,
            found.pitch_trials,
            found.samples,
            if verified.whole { "whole" } else { "DAMAGED" },
        );
        for damage in &found.damage {
            let _ = writeln!(text, "{}: {}", damage.place, damage.found);
        }
        text
    })?;
    Ok(if verified.whole {
        Exit::Done
    } else {
        Exit::Input
    })
}
