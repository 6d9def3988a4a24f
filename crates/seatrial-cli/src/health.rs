//! `seatrial health`: is the vehicle different?

use std::fmt::Write;
use std::path::{Path, PathBuf};

use seatrial::health::{Change, Effect, Effects, Finding, HealthSettings, WatchReport};
use seatrial::words::sentence;
use seatrial_app::trials::campaign_models::{ComparedModels, compared_models, open_named};
use seatrial_app::trials::health;
use seatrial_app::trials::health::{Comparison, Criteria, Missions, WatchDocument};
use seatrial_app::trials::next;

use crate::choice::one_of;
use crate::log::{ChannelArgs, Reporter};
use crate::output::{Exit, Failure, Output};
use crate::screen::{command, labelled, width};
use crate::speeds::plural;
use crate::table::{Table, number};

/// More windows than this are not printed.
const MOST_ROWS: usize = 40;

/// Has the vehicle changed? Tests two trials or runs, or watches mission logs for the need of a re-trial.
#[derive(clap::Args, Debug)]
#[command(after_help = "\
REFERENCE and NOW are each one of
  3, payload          a campaign of the logbook by its number, or the last one of a configuration
  3:2                 the second run of campaign 3
  model.json          a document of `seatrial identify --json` or `seatrial trial --json`
  schedule.toml       a schedule; it states no uncertainty, so its models count as exact
  run.csv             a log of one manoeuvre at one speed
  run.csv@40..56.5    the seconds 40 to 56.5 of a log; either end may be left out

With --watch the logs may be ordinary missions, in order of time. Give all of them since the trial each time:
every window in which the rudder works is identified by itself, and recent windows together are tested for one \
common change. The false alarm rate is that of the whole answer.

The test assumes what the intervals of `identify` assume: white heading noise and a disturbance without memory of \
other runs. Speeds within 10 % of the reference's are scaled to it, others left out.

Exit code 0: no change was found, and the test is sharp enough to find one worth knowing; 4: the vehicle has changed, a re-trial is due, \
or the data cannot tell. The verdict says which and why.

Example:
  seatrial trial --logbook sea.db --configuration clean --seed 1
  seatrial trial --logbook sea.db --configuration payload --seed 2
  seatrial health clean payload --logbook sea.db
  seatrial sim log --seed 3 --thrust 0.8 --out mission.csv && \\
      seatrial health clean --logbook sea.db --watch mission.csv")]
pub struct Args {
    /// The vehicle as it was: campaign, model, schedule or log.
    reference: String,
    /// The vehicle as it is.
    #[arg(required_unless_present = "watch")]
    now: Option<String>,
    /// Mission logs in order of time, or windows of them.
    #[arg(long, value_name = "LOG", num_args = 1.., conflicts_with = "now")]
    watch: Vec<String>,
    /// The logbook with the campaigns.
    #[arg(long, default_value = "seatrial.db", value_name = "FILE")]
    logbook: PathBuf,
    /// How often an unchanged vehicle may be called changed, per cent of all answers.
    #[arg(long, value_name = "PERCENT", default_value_t = 5.0, allow_negative_numbers = true)]
    false_alarms: f64,
    /// Changes of damping and rudder up to this much are none [default: 0; with --watch 5].
    #[arg(long, value_name = "PERCENT", allow_negative_numbers = true)]
    tolerate: Option<f64>,
    /// Is an offset that moved a change? Wind, current and trim move it [default: count; with --watch ignore].
    #[arg(long, value_name = "WHETHER", value_parser = one_of(OFFSETS))]
    offset: Option<bool>,
    #[command(flatten)]
    channels: ChannelArgs,
}

/// The values of `--offset`.
const OFFSETS: [(bool, &str, &str); 2] =
    [(true, "count", "It is tested with the rest"), (false, "ignore", "It is left out")];

/// Compares or watches.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    let criteria = Criteria {
        false_alarms: args.false_alarms / 100.0,
        tolerated: args.tolerate.map(|percent| percent / 100.0),
        offset_counts: args.offset,
    };
    match &args.now {
        Some(now) => {
            let settings = criteria.between_trials()?;
            args.compare(&args.models(&args.reference)?, now, &settings, output)
        }
        None => {
            let settings = criteria.in_missions()?;
            args.watch(&args.models(&args.reference)?, settings, output)
        }
    }
}

impl Args {
    fn models(&self, name: &str) -> Result<ComparedModels, Failure> {
        let reading = self.channels.read_settings()?;
        let mut reporter = Reporter::default();
        Ok(compared_models(name, &self.logbook, &reading, &mut reporter)?)
    }

    fn compare(
        &self,
        source: &ComparedModels,
        now: &str,
        settings: &HealthSettings,
        output: &Output,
    ) -> Result<Exit, Failure> {
        let reference = health::reference(source)?;
        let now = self.models(now)?;
        health::are_two(source, &now)?;
        let change = health::change(source, &reference, &now, settings);
        let document = Comparison::of(source, &now, &change);
        output.print(&document, || comparison_page(source, &now, &change, &self.logbook))?;
        Ok(Exit::done_if(change.finding == Finding::Unchanged))
    }

    fn watch(
        &self,
        source: &ComparedModels,
        settings: HealthSettings,
        output: &Output,
    ) -> Result<Exit, Failure> {
        let mut missions = Missions::new(source, settings)?;
        let reading = self.channels.read_settings()?;
        for name in &self.watch {
            let (log, window) = open_named(name, &reading, &mut Reporter::default())?;
            missions.read(name, &log, window)?;
        }
        let report = missions.report();
        let document = WatchDocument::of(source, missions.logs(), &report);
        output.print(&document, || watch_page(source, &self.watch, &report))?;
        Ok(Exit::done_if(report.finding == Finding::Unchanged))
    }
}

/// How a change is called, and what to do about it and about data that cannot tell.
const BETWEEN_TRIALS: [&str; 3] = [
    "CHANGED",
    "Take the gains of the newer trial, and find out what has changed.",
    "Repeat the trial with more rudder or more speeds, then compare again.",
];
const IN_MISSIONS: [&str; 3] = [
    "RE-TRIAL DUE",
    "Run a new trial, and take its gains.",
    "Watch more logs, of missions with more turns.",
];

/// The finding, its cause and what to do.
fn head(
    finding: Finding,
    [because, action_of_cause]: [&str; 2],
    [changed, act, look]: &[&str; 3],
    width: usize,
) -> String {
    let (headline, action) = match finding {
        Finding::Unchanged => ("NO CHANGE FOUND", "Go on with the gains that are in."),
        Finding::Changed => (*changed, *act),
        Finding::CannotTell => ("CANNOT TELL", *look),
    };
    let action = match action_of_cause {
        "" => action,
        of_the_cause => of_the_cause,
    };
    format!("{headline}\n")
        + &labelled("Cause      ", &sentence(because), width)
        + &labelled("Do         ", action, width)
}

/// What the table of two trials shows.
const CHANGE_BETWEEN_TRIALS: &str = "Change from the reference to now, with 95 % bounds. Chance: how often a vehicle that has not changed shows as much.";

/// What the table of missions shows.
const CHANGE_IN_WINDOWS: &str = "Change from the reference in each window, with 95 % bounds. Chance: how often the recent windows together show as much of a vehicle that has not changed.";

fn comparison_page(
    reference: &ComparedModels,
    now: &ComparedModels,
    change: &Change,
    logbook: &Path,
) -> String {
    let width = width();
    let mut text = head(change.finding, [&change.because, &change.action], &BETWEEN_TRIALS, width);
    if let (Finding::Changed, Some(number)) = (change.finding, now.campaign) {
        text += &command("Next       ", &next::gains_of_trial(number, logbook), width);
    }
    text += &origin_text("Reference", reference);
    text += &origin_text("Now", now);
    let Some(effects) = &change.effects else {
        return text;
    };
    let mut table = effect_table(&["at"], effects.offset_rad.is_some(), &[]);
    for speed in &change.speeds {
        let mut row = vec![speed.name()];
        row.extend(effect_cells(&speed.effects));
        row.extend([probability(speed.p_value), probability(speed.level)]);
        table.row(row);
    }
    if let Some(together) = change.together {
        let mut row = vec!["all together".into()];
        row.extend(effect_cells(effects));
        row.extend([probability(together.p_value), probability(together.level)]);
        table.row(row);
    }
    text += "\n";
    text += &labelled("", CHANGE_BETWEEN_TRIALS, width);
    text += &table.fitted(width, &["alarm below", "offset"]);
    for left_out in &change.left_out {
        text += &labelled("left out: ", left_out, width);
    }
    text + &labelled("", &rate_text(&change.settings), width)
}

fn watch_page(reference: &ComparedModels, logs: &[String], report: &WatchReport) -> String {
    let width = width();
    let mut text = head(report.finding, [&report.because, ""], &IN_MISSIONS, width);
    text += &origin_text("Reference", reference);
    let watched = format!(
        "{} log{}, {:.0} s; in {} window{} the rudder excites the vehicle",
        logs.len(),
        plural(logs.len()),
        report.read_s,
        report.windows.len(),
        plural(report.windows.len()),
    );
    text += &labelled("Watched    ", &watched, width);
    for skipped in &report.skipped {
        let skipped = format!("{:>7.0} s: {}", skipped.duration_s, skipped.because);
        text += &labelled("  not watched ", &skipped, width);
    }
    if report.windows.is_empty() {
        return text;
    }
    let first = report.windows.len().saturating_sub(MOST_ROWS);
    let table = window_table(report, first);
    text += "\n";
    text += &labelled("", CHANGE_IN_WINDOWS, width);
    text += &table.fitted(width, &["alarm below", "m/s", "offset"]);
    if first > 0 {
        let _ = writeln!(text, "{first} windows before these: see --json");
    }
    text + &labelled("", &rate_text(&report.settings), width)
}

/// The windows of a watch from this one on.
fn window_table(report: &WatchReport, first: usize) -> Table {
    let has_offset = report.windows[0].effects.offset_rad.is_some();
    let mut table = effect_table(&["log", "seconds", "m/s"], has_offset, &[""]);
    for (index, window) in report.windows.iter().enumerate().skip(first) {
        let speed = window.surge_speed_m_s;
        let mut row = vec![
            window.log.clone(),
            format!("{:.0} to {:.0}", window.window.from_s, window.window.to_s),
            number(speed, 2),
        ];
        row.extend(effect_cells(&window.effects));
        row.push(window.p_value.map_or("-".into(), probability));
        row.push(report.level.map_or("-".into(), probability));
        let since = report.since == Some(index);
        row.push(match (window.alarm, since) {
            (true, true) => "alarm, changed from here".into(),
            (true, false) => "alarm".into(),
            (false, true) => "changed from here".into(),
            (false, false) => String::new(),
        });
        table.row(row);
    }
    table
}

fn origin_text(title: &str, source: &ComparedModels) -> String {
    let speeds = source.models.len();
    let mut origin = source.origin.clone();
    if speeds > 1 {
        let _ = write!(origin, ", {speeds} speeds");
    }
    let mut text = labelled(&format!("{title:<10} "), &origin, width());
    for note in &source.notes {
        text += &labelled("  note: ", note, width());
    }
    text
}

fn effect_table(first: &[&str], has_offset: bool, last: &[&str]) -> Table {
    let mut columns: Vec<(&str, &str)> = first.iter().map(|name| (*name, "")).collect();
    columns.extend([("rudder", "%"), ("damping", "%")]);
    if has_offset {
        columns.push(("offset", "deg of rudder"));
    }
    columns.extend([("chance", ""), ("alarm below", "")]);
    columns.extend(last.iter().map(|name| (*name, "")));
    Table::new(&columns)
}

/// Rudder, damping and, where it is tested, the offset.
fn effect_cells(effects: &Effects) -> Vec<String> {
    let cell = |effect: Effect, scale: f64, decimals: usize| {
        // Nothing has no sign: neither +0 nor -0.
        let number = |value: f64| match format!("{value:+.decimals$}") {
            text if text.trim_matches(['+', '-', '0', '.']).is_empty() => text[1..].to_owned(),
            text => text,
        };
        let [low, high] = effect.interval_95.map(|bound| number(scale * bound));
        format!("{} ({low} to {high})", number(scale * effect.change))
    };
    let mut cells = vec![cell(effects.rudder, 100.0, 0), cell(effects.damping, 100.0, 0)];
    cells.extend(effects.offset_rad.map(|offset| cell(offset, 1f64.to_degrees(), 2)));
    cells
}

fn probability(p: f64) -> String {
    match p {
        ..1e-4 => "<0.0001".into(),
        ..0.01 => format!("{p:.4}"),
        _ => format!("{p:.2}"),
    }
}

fn rate_text(settings: &HealthSettings) -> String {
    let mut text = format!(
        "At most {} % of such answers call an unchanged vehicle changed",
        100.0 * settings.false_alarm_rate()
    );
    if settings.tolerated_change() > 0.0 {
        let _ = write!(
            text,
            "; changes of rudder and damping up to {} % count as none",
            100.0 * settings.tolerated_change()
        );
    }
    if !settings.offset_counts() {
        text += "; the offset is not tested";
    }
    text + ".\n"
}
