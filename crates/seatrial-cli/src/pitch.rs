//! The pitch axis of `seatrial trial` and `seatrial identify`.

use std::fmt::Write as _;
use std::path::Path;

use seatrial::pitch::{PitchIdentification, PitchPlan, PitchRun, PitchTrial};
use seatrial::record::Window;
use seatrial::verdict::three_figures;
use seatrial_app::pitch::{self, PitchReplay, PitchTrialDocument, PitchTrialError};
use seatrial_logbook::Logbook;
use seatrial_report as report;

use crate::log::LogArgs;
use crate::output::{Exit, Failure, Output, save_page};
use crate::table::Table;
use crate::windows::WindowArgs;

/// Which motion is identified.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Axis {
    /// Heading under the rudder.
    Yaw,
    /// Pitch under the elevator.
    Pitch,
}

/// The number of a pitch trial on the command line.
pub fn number(given: Option<&str>) -> Result<Option<i64>, Failure> {
    let parse = |text: &str| {
        text.parse().map_err(|_| {
            Failure::usage(format!(
                "--campaign {text}: expected the number of a pitch trial"
            ))
        })
    };
    given.map(parse).transpose()
}

/// `logbook show --axis pitch`.
pub fn show(logbook: &Logbook, number: Option<i64>, output: &Output) -> Result<Exit, Failure> {
    let (entry, trial) = pitch::chosen(logbook, number)?;
    output.print(&entry, || {
        let document = PitchTrialDocument::of(&entry.vehicle, entry.seed, &trial);
        format!(
            "pitch trial {}, {}, configuration {}, seatrial {}\n{}",
            entry.number,
            entry.entered,
            entry.configuration,
            entry.software_version,
            trial_text(&document)
        )
    })?;
    Ok(Exit::Done)
}

/// `logbook export --axis pitch`: the log, which `identify --axis pitch` reads.
pub fn export(
    logbook: &Logbook,
    number: Option<i64>,
    out: Option<&Path>,
    output: &Output,
) -> Result<Exit, Failure> {
    let (entry, trial) = pitch::chosen(logbook, number)?;
    match out {
        Some(path) => save_log(path, &trial)?,
        None => output.print(&entry, || pitch::csv(&trial.samples))?,
    }
    Ok(Exit::Done)
}

fn save_log(path: &Path, trial: &PitchTrial) -> Result<(), Failure> {
    std::fs::write(path, pitch::csv(&trial.samples))
        .map_err(|error| Failure::not_saved(format!("{}: {error}", path.display())))
}

/// `report --axis pitch`.
pub fn page(logbook: &Logbook, number: Option<i64>) -> Result<String, Failure> {
    let (entry, _) = pitch::chosen(logbook, number)?;
    page_of(logbook, entry.number)
}

fn page_of(logbook: &Logbook, number: i64) -> Result<String, Failure> {
    let (entry, trial) = logbook.pitch_trial(number)?;
    let plan = toml::to_string_pretty(&trial.plan).map_err(Failure::internal)?;
    let place = format!("{}, pitch trial {number}", logbook.path().display());
    let mut provenance = vec![
        ("Logbook", place),
        ("Entered (UTC)", entry.entered),
        ("SHA-256 of the trial", entry.sha256),
        ("Plan", plan),
    ];
    provenance.extend(entry.seed.map(|seed| ("Seed", seed.to_string())));
    Ok(report::render_pitch(&entry.vehicle, &trial, &provenance))
}

/// `replay --axis pitch`.
pub fn replay(logbook: &Logbook, number: Option<i64>, output: &Output) -> Result<Exit, Failure> {
    let (entry, trial) = pitch::chosen(logbook, number)?;
    let replay = PitchReplay::of(&entry, &trial);
    output.print(&replay, || {
        format!(
            "pitch trial {}: {} results of {} samples {}",
            replay.pitch_trial,
            replay.results,
            replay.samples,
            if replay.identical {
                "replayed, every one the same bit for bit".into()
            } else {
                format!(
                    "differ; recorded by seatrial {}, replayed by {}",
                    replay.recorded_by, replay.replayed_by
                )
            }
        )
    })?;
    Ok(if replay.identical {
        Exit::Done
    } else {
        Exit::Rejected
    })
}

/// Where a pitch trial goes.
pub struct Kept<'a> {
    pub logbook: &'a Path,
    pub configuration: &'a str,
    pub log: Option<&'a Path>,
    pub page: Option<&'a Path>,
}

/// A pitch trial on a simulated vehicle.
pub fn trial(
    name: &str,
    seed: u64,
    plan: Option<&Path>,
    kept: &Kept,
    output: &Output,
) -> Result<Exit, Failure> {
    let plan = plan.map_or(Ok(PitchPlan::default()), pitch::load_plan)?;
    let mut logbook = Logbook::open(kept.logbook)?;
    let (number, trial) = pitch::trial(name, seed, plan, kept.configuration, &mut logbook)?;
    if let Some(path) = kept.log {
        save_log(path, &trial)?;
    }
    if let Some(path) = kept.page {
        save_page(path, &page_of(&logbook, number)?)?;
    }
    let document = PitchTrialDocument::of(name, Some(seed), &trial);
    output.print(&document, || {
        format!(
            "{}\nlogbook  {}, pitch trial {number}",
            trial_text(&document),
            kept.logbook.display()
        )
    })?;
    Ok(if trial.aborted.is_some() {
        Exit::Aborted
    } else if trial.runs.iter().all(PitchRun::is_accepted) {
        Exit::Done
    } else {
        Exit::Rejected
    })
}

fn trial_text(document: &PitchTrialDocument) -> String {
    let mut table = Table::new(&[
        ("thrust", "%"),
        ("speed", "m/s"),
        ("a", "1/s"),
        ("m", "1/s^2"),
        ("b", "1/s^2"),
        ("c", "rad/s^2"),
        ("trim", "deg"),
        ("R^2", ""),
        ("depth", "m"),
        ("train", "s"),
        ("validate", "s"),
    ]);
    let mut notes = String::new();
    for run in document.runs {
        let thrust = format!("{:.0}", 100.0 * run.thrust);
        let Some(found) = &run.identification else {
            let reason = run.refused.as_deref().unwrap_or("no model");
            let _ = writeln!(notes, "{thrust} %: {reason}");
            continue;
        };
        if !found.accepted {
            let _ = writeln!(notes, "{thrust} %: rejected, {}", found.reason);
        }
        let optional = |value: Option<f64>, digits: usize| {
            value.map_or("-".into(), |value| format!("{value:.digits$}"))
        };
        let model = found.refined.model;
        let [a, m, b, c] = model.theta();
        let with_width = |i: usize, value: f64, digits: usize| {
            let [low, high] = found.refined.interval_95[i];
            format!("{value:.digits$} ±{:.digits$}", 0.5 * (high - low))
        };
        let window = |window: Window| format!("{:.2}-{:.2}", window.from_s, window.to_s);
        table.row(vec![
            thrust,
            optional(run.surge_speed_m_s, 2),
            with_width(0, a, 2),
            with_width(1, m, 2),
            with_width(2, b, 2),
            with_width(3, c, 4),
            format!("{:.2}", (-c / b).to_degrees()),
            optional(found.validation.map(|found| found.r2_pitch), 3),
            optional(run.depth_excursion_m, 2),
            window(found.training),
            found
                .validation
                .map_or("-".into(), |found| window(found.window)),
        ]);
    }
    let ended = document.aborted.map_or(String::new(), |reason| {
        format!("ABORTED: {reason}. The vehicle holds its depth.\n\n")
    });
    format!(
        "{ended}Pitch of {}: q' = a q + m theta + b elevator + c, with 95 % half widths\n\n{table}\n{notes}\
         Trim is the elevator that holds the vehicle level, -c/b; depth the greatest excursion.",
        document.vehicle
    )
}

/// A pitch model from a log.
pub fn identify(log: &LogArgs, windows: &WindowArgs, output: &Output) -> Result<Exit, Failure> {
    let mut channels = log.channels.clone();
    channels.heading.get_or_insert("pitch_rad".into());
    channels.rudder.get_or_insert("elevator_rad".into());
    // The pitch column is the heading here.
    channels.pitch.get_or_insert("none".into());
    let logs = windows.open(&LogArgs {
        log: log.log.clone(),
        channels,
    })?;
    let document = pitch::identify(&logs)?;
    let found = &document.identification;
    output.print(&document, || identification_text(found))?;
    Ok(if found.accepted {
        Exit::Done
    } else {
        Exit::Rejected
    })
}

impl From<PitchTrialError> for Failure {
    fn from(error: PitchTrialError) -> Self {
        match error {
            PitchTrialError::NoPitch(_) => Self::usage(error),
            PitchTrialError::Vehicle(error) => error.into(),
            PitchTrialError::Logbook(error) => error.into(),
        }
    }
}

fn identification_text(found: &PitchIdentification) -> String {
    let verdict = if found.accepted { "USE" } else { "DO NOT USE" };
    let mut text = format!(
        "{verdict}\n  {}\n\nModel       theta' = q, q' = a q + m theta + b elevator + c\n",
        found.reason
    );
    let units = ["1/s", "1/s^2", "1/s^2", "rad/s^2"];
    let parameters = ["a", "m", "b", "c"]
        .into_iter()
        .zip(units)
        .zip(found.refined.model.theta())
        .zip(found.refined.interval_95);
    for (((name, unit), value), [low, high]) in parameters {
        let _ = writeln!(
            text,
            "  {name:<8}  {:>9} {unit:<8}  95 % {} to {}",
            three_figures(value),
            three_figures(low),
            three_figures(high)
        );
    }
    let online: Vec<String> = found
        .online
        .theta()
        .into_iter()
        .map(three_figures)
        .collect();
    let _ = writeln!(
        text,
        "Online      a {}, m {}, b {}, c {}; {} samples",
        online[0], online[1], online[2], online[3], found.samples_used
    );
    text
}
