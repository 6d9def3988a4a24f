//! From one log, or one run of it, to rows.

use seatrial::identification::Verdict;
use seatrial::identify::mission::is_ordinary_steering;
use seatrial::identify::{IdentifyError, IdentifySettings, RecordSurvey, ValidationData};
use seatrial::identify::{Single, singles};
use seatrial::log::segmentation::{Segment, find};
use seatrial::log::{Manoeuvre, leave_out_unsound};
use seatrial::{Record, Window};
use seatrial_core::RudderUnit;
use seatrial_logs::{ChannelChoice, Fault, LogReader, Quantity, ReadError, Run, open_in};
use serde::{Deserialize, Serialize};

use super::{Row, Source, objects};
use crate::logs::stated_units;

/// A longer log is read in segments of this many samples (84 MB), each of which repeats the last fifth of the one before,
/// so that a manoeuvre lies whole in one of them.
const STRETCH_SAMPLES: usize = 500_000;
const NEW_SAMPLES: usize = STRETCH_SAMPLES / 5 * 4;

/// Which estimate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Estimate {
    /// What `identify` reports: from the whole manoeuvre, with 95 % intervals.
    #[default]
    Refined,
    /// The estimator that runs on the vehicle: without intervals, many times faster. Its verdict knows no intervals.
    Online,
}

/// How every log is read and identified.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Options {
    /// Which estimate.
    pub estimate: Estimate,
    /// Columns and units.
    pub channels: ChannelChoice,
    /// The column that tells the runs of a file apart.
    pub run_column: Option<String>,
}

impl Options {
    /// The columns that a row has no use for are not read.
    pub(super) fn choice(&self) -> ChannelChoice {
        let mut choice = self.channels.clone();
        for quantity in [
            Quantity::Depth,
            Quantity::Altitude,
            Quantity::Roll,
            Quantity::Pitch,
            Quantity::North,
            Quantity::East,
        ] {
            choice.columns.insert(quantity, "none".into());
        }
        choice
    }

    fn settings(&self) -> IdentifySettings {
        let mut settings = IdentifySettings::default();
        settings.refine = self.estimate == Estimate::Refined;
        settings
    }
}

/// The rows of a log.
pub(super) fn rows_of_log(source: &Source, options: &Options) -> Vec<Row> {
    let blank = blank(source);
    match read_log(source, &blank, options) {
        Ok(rows) => rows,
        Err(error) => vec![failed(blank, &error)],
    }
}

/// The rows of a run.
pub(super) fn rows_of_run(source: &Source, run: Run, options: &Options) -> Vec<Row> {
    let blank = Row { run: Some(run.id.clone()), ..blank(source) };
    let read = run.open().and_then(|log| rows(log, &blank, options));
    let mut rows = read.unwrap_or_else(|error| vec![failed(blank, &error)]);
    rows.iter_mut().for_each(|row| row.sha256 = None);
    rows
}

fn read_log(source: &Source, blank: &Row, options: &Options) -> Result<Vec<Row>, ReadError> {
    let held = objects::held(source)?;
    let log = open_in(&source.path, &held, &options.choice())?;
    rows(log, blank, options)
}

/// What every row of a source begins with.
pub(super) fn blank(source: &Source) -> Row {
    Row {
        source: source.path.display().to_string(),
        bytes: source.bytes,
        modified: source.modified(),
        etag: source.etag.clone(),
        ..Row::default()
    }
}

/// The error row of a log.
pub(super) fn failed(blank: Row, error: &ReadError) -> Row {
    let mut row = blank;
    row.failed(code(&error.fault), error.to_string());
    row
}

fn code(fault: &Fault) -> &'static str {
    match fault {
        Fault::Io { .. } | Fault::Folder => "unreadable",
        Fault::Empty
        | Fault::HeaderOnly
        | Fault::NoSamples { .. }
        | Fault::NothingToRead { .. } => "no_samples",
        Fault::Damaged { .. } => "damaged",
        Fault::MissingColumn { .. }
        | Fault::NotLogged { .. }
        | Fault::NoSuchColumn { .. }
        | Fault::NoRunColumn { .. } => "missing_channel",
        Fault::AmbiguousColumn { .. } => "ambiguous_channel",
        Fault::UnknownUnit { .. }
        | Fault::ImplausibleValues { .. }
        | Fault::UnitContradicted { .. } => "unit",
        Fault::NotANumber { .. } | Fault::NotFinite { .. } | Fault::Ragged { .. } => "invalid_row",
        Fault::TimeReversed { .. } | Fault::TimeCollapsed { .. } => "time",
        Fault::ScatteredRun { .. } | Fault::LongRun { .. } => "run",
        _ => "not_understood",
    }
}

/// Reads a log to its end, segment by segment.
fn rows(mut log: LogReader, blank: &Row, options: &Options) -> Result<Vec<Row>, ReadError> {
    let description = log.description().clone();
    let start = (log.start_unix_s()).map(|start_s| (start_s * 1e6).round() as i64);
    let mut rows = Vec::new();
    let mut record = Record { rudder_unit: description.rudder_unit, ..Record::default() };
    let mut done_until_s = f64::NEG_INFINITY;
    while let Some(sample) = log.next() {
        record.samples.push(sample?);
        if record.samples.len() == STRETCH_SAMPLES {
            let from_s = record.samples[NEW_SAMPLES].time_s;
            let new = Window { from_s: done_until_s, to_s: from_s };
            judge_units(&mut record, &log);
            rows.extend(manoeuvres(&record, new, options));
            record.samples.drain(..NEW_SAMPLES);
            done_until_s = from_s;
        }
    }
    let rest = Window { from_s: done_until_s, to_s: f64::INFINITY };
    judge_units(&mut record, &log);
    rows.extend(manoeuvres(&record, rest, options));
    if rows.is_empty() {
        rows.push(without_manoeuvre(blank, log.counts().samples));
    }
    let sha256 = log.sha256()?;
    let counts = log.counts();
    let warnings = [description.warnings.clone(), log.warnings()].concat();
    let rudder_unit = match description.rudder_unit {
        RudderUnit::Rad => "rad",
        RudderUnit::FullRudder => "full_rudder",
    };
    Ok(rows
        .into_iter()
        .map(|row| Row {
            source: blank.source.clone(),
            run: blank.run.clone(),
            bytes: blank.bytes,
            modified: blank.modified,
            etag: blank.etag.clone(),
            format: Some(description.format.to_string()),
            sha256: Some(sha256.clone()),
            start,
            samples_read: Some(counts.samples),
            rows_left_out: Some(counts.dropped()),
            rudder_unit: Some(rudder_unit.into()),
            warnings: (!warnings.is_empty()).then(|| warnings.clone()),
            ..row
        })
        .collect())
}

/// The row of a log in which no manoeuvre was found.
fn without_manoeuvre(blank: &Row, samples: u64) -> Row {
    let mut row = Row::default();
    row.failed(
        "not_identified",
        format!("{}: no manoeuvre with rudder to both sides in {samples} samples", blank.source),
    );
    row
}

/// What the log says of its columns, and what was found wrong with it so far, as `identify` takes it.
fn judge_units(record: &mut Record, log: &LogReader) {
    record.units = stated_units(log.description(), &log.counts());
    leave_out_unsound(record);
}

/// A row for each manoeuvre that begins inside a window; where there is none in a record that is no more than that
/// window, or where it is ordinary steering, a row for the whole.
fn manoeuvres(record: &Record, new: Window, options: &Options) -> Vec<Row> {
    let segments = find(&record.samples);
    let found = singles(record, &segments);
    let is_whole = new == Window::ALL;
    if is_whole && (found.is_empty() || is_ordinary_steering(&record.samples)) {
        return vec![whole(record, &segments, options)];
    }
    let survey = RecordSurvey::of(record);
    found
        .iter()
        .filter(|single| new.contains(single.segment.window.from_s))
        .map(|single| one(&survey, single, options))
        .collect()
}

fn whole(record: &Record, segments: &[Segment], options: &Options) -> Row {
    let speeds = || record.samples.iter().filter_map(|s| s.surge_speed_m_s);
    let thrusts = || record.samples.iter().filter_map(|s| s.thrust);
    let mean = |values: &mut dyn Iterator<Item = f64>| {
        let (sum, count) =
            values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
        (count > 0.0).then_some(sum / count)
    };
    let mut row = Row {
        manoeuvre: Some("record".into()),
        thrust: mean(&mut thrusts()),
        surge_speed_m_s: mean(&mut speeds()),
        rudder_amplitude_rad: Manoeuvre::find(&record.samples).map(|m| m.amplitude_rad),
        ..Row::default()
    };
    if let [segment] = segments {
        row.manoeuvre = Some(segment.kind.to_string());
    }
    estimate(&mut row, &RecordSurvey::of(record), Window::ALL, None, options);
    row
}

fn one(survey: &RecordSurvey, single: &Single, options: &Options) -> Row {
    let mut row = Row {
        manoeuvre: Some(single.segment.kind.to_string()),
        thrust: single.segment.thrust,
        surge_speed_m_s: single.segment.surge_speed_m_s,
        rudder_amplitude_rad: Some(single.segment.amplitude_rad),
        ..Row::default()
    };
    let held_out =
        single.validation.map(|window| ValidationData { record: survey.record(), window });
    estimate(&mut row, survey, single.training, held_out, options);
    row
}

fn estimate(
    row: &mut Row,
    survey: &RecordSurvey,
    training: Window,
    held_out: Option<ValidationData>,
    options: &Options,
) {
    match survey.identify(training, held_out, &options.settings()) {
        Ok(found) => row.identified(&found),
        Err(error) => {
            row.window(training);
            match error {
                IdentifyError::Refused(reason) => row.judged(&Verdict::refused(reason)),
                other => row.failed("not_identified", other.to_string()),
            }
        }
    }
}
