//! `seatrial logbook`: the results database.

mod list;

use std::fmt::Write;
use std::path::PathBuf;

use clap::Subcommand;
use seatrial::Step;
use seatrial::campaign::speeds::{Difference, ThrustDifference};
use seatrial::campaign::{Campaign, Run};
use seatrial::identification::Verdict;
use seatrial::words::{sentence, with_decimals};
use seatrial_app::trials::campaign_models::{campaign_named, campaign_numbered};
use seatrial_app::trials::next;
use seatrial_core::{Axis, Outcome, RudderUnit};
use seatrial_logbook::{CampaignEntry, Logbook, State, Verification};
use seatrial_logs::{DAMAGE_MARK, TrackFormat};
use serde::Serialize;

use crate::damage;
use crate::output::{Exit, Failure, Output};
use crate::screen::{command, labelled, width};
use crate::speed_table::{SpeedRow, promise_text, run_row, speed_table};
use crate::table::decimals;
use crate::track;

/// Results of earlier trials: all in a list, one campaign, or two side by side.
///
/// --verify finds every value that was changed, added or taken out by itself, in samples, results, reviews and commands,
/// and every change of the schema. Not found is what somebody does who may write the file and computes all hashes
/// anew, for they have no key, or who takes away the newest campaigns whole. Keep a copy elsewhere.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  seatrial trial --logbook seatrial.db
  seatrial logbook
  seatrial logbook 1 --logbook seatrial.db
  seatrial logbook 1 1
  seatrial logbook --verify")]
pub struct Args {
    #[command(subcommand)]
    action: Option<LogbookAction>,
    /// Number of a campaign, or name of a configuration (its last campaign): every run with its model, its intervals and its verdict.
    campaign: Option<String>,
    /// The other one, to be compared thrust by thrust.
    other: Option<String>,
    /// Proves that nothing is damaged or altered; otherwise says what and where, exit 3.
    #[arg(long, conflicts_with = "campaign")]
    verify: bool,
    /// The logbook.
    #[arg(long, global = true, default_value = "seatrial.db", value_name = "FILE")]
    logbook: PathBuf,
}

#[derive(Subcommand)]
enum LogbookAction {
    /// The old spelling of `seatrial logbook`.
    #[command(hide = true)]
    List,
    /// The old spelling of `seatrial logbook A B`; without a campaign, the last one.
    #[command(hide = true)]
    Show { campaign: Option<String>, other: Option<String> },
    /// The old spelling of `seatrial logbook A B`.
    #[command(hide = true)]
    Diff { a: String, b: String },
    /// Samples and actions as CSV, or the track as GPX or KML; with --json the results.
    #[command(
        after_help = "Example:\n  seatrial trial && seatrial logbook export 1 --out samples.csv\n  seatrial trial && seatrial logbook export 1 --out a.gpx --origin 54.3,10.1"
    )]
    Export(ExportArgs),
    /// The old spelling of `seatrial logbook --verify`.
    #[command(hide = true)]
    Verify,
}

/// What is exported, and where.
#[derive(clap::Args)]
struct ExportArgs {
    /// Number of the campaign; the last one where it is left out.
    campaign: Option<i64>,
    /// Only this run.
    #[arg(long, value_name = "NUMBER")]
    run: Option<u32>,
    /// Write to this file instead of standard output; one that ends in .gpx or .kml gets the track.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Latitude and longitude of the trial's position 0, 0, deg: a track needs them.
    #[arg(long, value_name = "LAT,LON", allow_hyphen_values = true, requires = "out", value_parser = track::origin)]
    origin: Option<[f64; 2]>,
    /// Export a campaign that is damaged all the same; what is written says so.
    #[arg(long)]
    accept: bool,
}

/// Runs the verb.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    let logbook = Logbook::open_read_only(&args.logbook)?;
    if args.verify || matches!(args.action, Some(LogbookAction::Verify)) {
        return verify(&logbook, output);
    }
    damage::warn_of_missing(&logbook);
    let (campaign, other) = match &args.action {
        Some(LogbookAction::Export(asked)) => return export(&logbook, asked, output),
        Some(LogbookAction::Diff { a, b }) => (Some(a), Some(b)),
        Some(LogbookAction::Show { campaign, other }) => (campaign.as_ref(), other.as_ref()),
        _ => (args.campaign.as_ref(), args.other.as_ref()),
    };
    match (campaign, other) {
        (Some(a), Some(b)) => diff(&logbook, a, b, output),
        (None, _) if !matches!(args.action, Some(LogbookAction::Show { .. })) => {
            list::list(&logbook, output)
        }
        (campaign, _) => show(&logbook, campaign.map(String::as_str), output),
    }
}

#[derive(Serialize)]
struct Results<'a> {
    schema: &'static str,
    campaign: &'a CampaignEntry,
    runs: &'a [Run],
}

fn show(logbook: &Logbook, name: Option<&str>, output: &Output) -> Result<Exit, Failure> {
    let entry = match name {
        Some(name) => campaign_named(logbook, name)?,
        None => campaign_numbered(logbook, None)?,
    };
    let entry = damage::warn(logbook, entry.id)?;
    let mut campaign = logbook.campaign(entry.id)?;
    for identification in campaign.runs.iter_mut().filter_map(|run| run.identification.as_mut()) {
        identification.online.trace.clear();
    }
    let verdict = campaign.verdict();
    let firmware = logbook.circumstances(entry.id)?.firmware;
    let next = next::after_trial(&campaign, entry.id, logbook.path(), firmware.as_deref());
    let results =
        Results { schema: "seatrial.logbook_campaign.v1", campaign: &entry, runs: &campaign.runs };
    output.print(&results, || {
        let width = width();
        let runs = campaign.runs.iter();
        let rows: Vec<SpeedRow> = runs.map(|run| run_row(&campaign, run, &verdict)).collect();
        let mut text = labelled("", &verdict.outcome().name().to_uppercase(), width);
        text += &promise_text(&rows, width);
        text += &speed_table(&rows, RudderUnit::Rad, width).unwrap_or_default();
        text += &every_cause(&verdict, width);
        text += &labelled("About  ", &heading(&entry), width);
        text + &command("Next   ", &next, width)
    })?;
    Ok(Exit::Done)
}

/// The causes of the outcome, the deciding one first, each with what to do about it.
fn every_cause(verdict: &Verdict, width: usize) -> String {
    let Some(first) = verdict.cause() else {
        return String::new();
    };
    let others = verdict.causes().filter(|cause| *cause != first);
    let (mut text, mut label) = (String::new(), "Cause  ");
    for cause in std::iter::once(first).chain(others) {
        text += &labelled(label, &sentence(&cause.text), width);
        if !cause.action.is_empty() {
            text += &labelled("Do     ", &cause.action, width);
        }
        label = "Also   ";
    }
    text
}

fn heading(entry: &CampaignEntry) -> String {
    let seed = entry.seed.map_or(String::new(), |seed| format!(", seed {seed}"));
    let notes = entry.notes.as_ref().map_or(String::new(), |notes| format!("; {notes}"));
    format!(
        "campaign {}, {}, {}{seed}, configuration {}{}, seatrial {}: {}{notes}",
        entry.id.0,
        entry.started,
        entry.vehicle,
        entry.configuration,
        axis_text(entry),
        entry.software_version,
        state_text(entry.state),
    )
}

/// The axis of a campaign where it is not yaw.
fn axis_text(entry: &CampaignEntry) -> &'static str {
    match entry.axis() {
        Axis::Yaw => "",
        Axis::Pitch => ", pitch",
    }
}

/// What a logbook holds: `2 campaigns, 10 runs, 9002 samples`.
fn holdings(found: &Verification) -> String {
    let counted = |number: u32, one: &str| match number {
        1 => format!("1 {one}"),
        many => format!("{many} {one}s"),
    };
    let mut parts =
        vec![counted(found.campaigns, "campaign"), counted(found.runs_finished, "finished run")];
    let others = [
        (found.campaigns_unfinished, "unfinished campaign"),
        (found.runs_unfinished, "unfinished run"),
    ];
    let others = others.into_iter().filter(|(number, _)| *number > 0);
    parts.extend(others.map(|(number, one)| counted(number, one)));
    parts.push(format!("{} samples", found.samples));
    parts.join(", ")
}

fn digits(value: Option<f64>, places: usize) -> String {
    value.map_or("-".into(), |value| with_decimals(value, decimals(value, places)))
}

fn state_name(state: State) -> &'static str {
    match state {
        State::Ended { outcome: Outcome::Finished } => "finished",
        State::Ended { outcome: Outcome::Aborted(_) } => "aborted",
        State::Unfinished => "not finished",
        State::Interrupted => "interrupted",
    }
}

/// How a campaign ended, and why where it was aborted.
fn state_text(state: State) -> String {
    match state {
        State::Ended { outcome: Outcome::Aborted(reason) } => format!("aborted: {reason}"),
        state => state_name(state).into(),
    }
}

/// As the table of samples has it.
fn state_word(state: State) -> String {
    match state {
        State::Ended { outcome: Outcome::Aborted(reason) } => format!("aborted: {reason:?}"),
        state => state_name(state).into(),
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
    let [a, b] = [campaign_named(logbook, a)?, campaign_named(logbook, b)?];
    let (a, b) = (damage::warn(logbook, a.id)?, damage::warn(logbook, b.id)?);
    let campaigns: [Campaign; 2] = [logbook.campaign(a.id)?, logbook.campaign(b.id)?];
    let diff = Diff {
        schema: "seatrial.logbook_diff.v1",
        a: &a,
        b: &b,
        difference: Difference::between(&campaigns[0], &campaigns[1]),
    };
    output.print(&diff, || {
        let width = width();
        let mut text = labelled("A  ", &heading(&a), width) + &labelled("B  ", &heading(&b), width);
        text += "                  A         B       B-A\n";
        diff.difference.thrusts.iter().for_each(|at| write_difference(&mut text, at, width));
        for (thrusts, name) in
            [(&diff.difference.only_in_a, "A"), (&diff.difference.only_in_b, "B")]
        {
            for thrust in thrusts {
                let _ = writeln!(text, "{:.0} %: only {name} has an accepted run", thrust * 100.0);
            }
        }
        if diff.difference.thrusts.is_empty() {
            text += "no thrust at which both have an accepted run\n";
            return text;
        }
        let names =
            format!("seatrial health {} {} --logbook {}", a.id.0, b.id.0, logbook.path().display());
        text + &command("Next   ", &names, width) + "       says whether the vehicle has changed\n"
    })?;
    Ok(Exit::Done)
}

fn write_difference(text: &mut String, at: &ThrustDifference, width: usize) {
    let [a, b] = at.surge_speed_m_s.map(|speed| digits(speed, 2));
    let _ = writeln!(text, "{:.0} %, {a} and {b} m/s", at.thrust * 100.0);
    for (name, parameter) in at.parameters() {
        let words = match parameter.ratio {
            Some(ratio) if ratio.abs() > 1.0 => format!(
                "B is {}, by {:.1} times the combined interval",
                if ratio > 0.0 { "higher" } else { "lower" },
                ratio.abs()
            ),
            Some(_) => "the same within the intervals".into(),
            None => "an interval is missing".into(),
        };
        let numbers = format!(
            "  {name:<7} {:>9} {:>9} {:>9}  ",
            digits(Some(parameter.a), 3),
            digits(Some(parameter.b), 3),
            digits(Some(parameter.difference), 3)
        );
        *text += &labelled(&numbers, &words, width);
    }
}

fn export(logbook: &Logbook, asked: &ExportArgs, output: &Output) -> Result<Exit, Failure> {
    let (run, out) = (asked.run, asked.out.as_ref());
    let entry = campaign_numbered(logbook, asked.campaign)?;
    let runs = logbook.runs(entry.id)?;
    if let Some(run) = run
        && runs.iter().all(|entry| entry.number != run)
    {
        let (path, id, count) = (logbook.path().display(), entry.id.0, runs.len());
        let why = format!("{path}: campaign {id} has no run {run}; it has {count}");
        return Err(Failure::input(why));
    }
    let entry = damage::warn(logbook, entry.id)?;
    if entry.damage.is_some() && !asked.accept {
        let (path, id) = (logbook.path().display(), entry.id.0);
        return Err(Failure::input(format!(
            "{path}: campaign {id} is damaged, and is not exported; --accept exports it all the same"
        )));
    }
    let mut runs = logbook.campaign(entry.id)?.runs;
    runs.retain(|found| run.is_none_or(|run| found.number == run));
    let track = out.and_then(|out| Some((out, TrackFormat::of(out)?)));
    if let Some((out, format)) = track {
        let track = track::of_campaign(&entry, &runs, format, asked.origin)?;
        output.save(out, track)?;
        return Ok(Exit::Done);
    }
    let results = Results { schema: "seatrial.logbook_results.v1", campaign: &entry, runs: &runs };
    let columns = Step::columns(entry.axis()).join(",");
    let mark = entry
        .damage
        .as_ref()
        .map(|damage| format!("{DAMAGE_MARK}{}: {}\n", damage.place, damage.found));
    let mut csv = mark.unwrap_or_default() + &format!("run,stage,{columns},action_outcome\n");
    for (number, step) in logbook.steps(entry.id)? {
        if run.is_none() || number == run {
            write_csv_row(&mut csv, number, &step);
        }
    }
    let Some(out) = out else {
        output.print(&results, || csv)?;
        return Ok(Exit::Done);
    };
    let written = match output.json {
        true => serde_json::to_string_pretty(&results).map_err(Failure::internal)?,
        false => csv,
    };
    output.save(out, written)?;
    Ok(Exit::Done)
}

/// Numbers as the shortest text that reads back to the same bits.
fn write_csv_row(csv: &mut String, run: Option<u32>, step: &Step) {
    let stage = step.stage.map_or(String::new(), |stage| format!("{stage:?}").to_lowercase());
    let run = run.map_or(String::new(), |run| run.to_string());
    let _ = write!(csv, "{run},{stage}");
    for number in step.numbers() {
        let _ = match number {
            Some(number) => write!(csv, ",{number:?}"),
            None => write!(csv, ","),
        };
    }
    let outcome =
        step.action.outcome.map_or(String::new(), |outcome| state_word(State::Ended { outcome }));
    let _ = writeln!(csv, ",{outcome}");
}

#[derive(Serialize)]
struct VerificationDocument {
    schema: &'static str,
    whole: bool,
    #[serde(flatten)]
    verification: Verification,
}

fn verify(logbook: &Logbook, output: &Output) -> Result<Exit, Failure> {
    let verification = logbook.verify()?;
    let verified = VerificationDocument {
        schema: "seatrial.logbook_verification.v1",
        whole: verification.is_whole(),
        verification,
    };
    output.print(&verified, || {
        let found = &verified.verification;
        let width = width();
        let state = match (verified.whole, found.damage.is_empty()) {
            (true, _) => "whole",
            (false, true) => "INCOMPLETE",
            (false, false) => "DAMAGED",
        };
        let mut text = labelled("", &format!("{}: {state}", logbook.path().display()), width);
        for damage in &found.damage {
            let finding = format!("{}: {}", damage.place, damage.found);
            text += &labelled("  ", &finding, width);
        }
        text += &labelled("Holds  ", &holdings(found), width);
        if let Some(missing) = &found.missing {
            text += &labelled("Lacks  ", missing, width);
        }
        if !found.damage.is_empty() {
            text += &labelled("Whole  ", &damage::whole_campaigns(logbook), width);
            let copy = "Keep this file, and use a copy from before the damage: no gains are made of this one. What is whole of it can be shown and exported.";
            text += &labelled("Do     ", copy, width);
        }
        text
    })?;
    Ok(if verified.whole { Exit::Done } else { Exit::Input })
}
