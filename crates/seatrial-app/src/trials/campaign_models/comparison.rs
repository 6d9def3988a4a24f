//! Models to compare for a change of the vehicle: of a campaign, a document, a schedule or a log.

use std::io::Read;
use std::path::{Path, PathBuf};

use seatrial::health::{SpeedModel, degrees_of_freedom};
use seatrial::identification::{Outcome, ReasonCode};
use seatrial::identify::{IdentifyError, IdentifySettings, identify};
use seatrial::{Run, Window};
use seatrial_core::{RudderUnit, Sample};
use seatrial_logbook::CampaignId;

use super::{campaign_named, undamaged};
use crate::Error;
use crate::advice::addressed;
use crate::documents::Source;
use crate::identify_log::{identify_speeds, no_model};
use crate::logs::{Observer, OpenedLog, ReadSettings, open_inside};
use crate::models::{ModelPoint, Models, of_document_alone, of_schedule_file};

/// A log whose speed spreads more than this about its mean holds several speeds.
const LARGEST_SPEED_SPREAD: f64 = 0.15;

/// The models of one argument.
pub struct ComparedModels {
    /// For people.
    pub origin: String,
    /// In what the rudder of the models is.
    pub rudder_unit: RudderUnit,
    /// The log, where it is one.
    pub log: Option<Source>,
    /// The campaign, where they are those of all its speeds.
    pub campaign: Option<CampaignId>,
    /// None only where `without_model` says why.
    pub models: Vec<SpeedModel>,
    /// Why the data give no model to compare.
    pub without_model: Option<String>,
    /// What has to be known about them.
    pub notes: Vec<String>,
}

impl ComparedModels {
    fn new(origin: String, rudder_unit: RudderUnit, models: Vec<SpeedModel>) -> Self {
        Self {
            origin,
            rudder_unit,
            log: None,
            campaign: None,
            models,
            without_model: None,
            notes: Vec::new(),
        }
    }

    fn noting(mut self, note: impl Into<String>) -> Self {
        self.notes.push(note.into());
        self
    }
}

/// Reads the models that an argument names.
pub fn compared_models(
    name: &str,
    logbook: &Path,
    reading: &ReadSettings,
    observer: &mut dyn Observer,
) -> Result<ComparedModels, Error> {
    if split_window(name)?.0.is_file() || name == "-" {
        let mut found = from_file(name, reading, observer)?;
        for text in found.notes.iter_mut().chain(&mut found.without_model) {
            *text = addressed(text, reading.reader);
        }
        return Ok(found);
    }
    if !logbook.exists() {
        return Err(Error::Input(format!(
            "{name}: no such file, and no logbook {} that could hold a campaign of this name; give a log, a document, or --logbook FILE",
            logbook.display()
        )));
    }
    from_logbook(name, logbook)
}

fn from_file(
    name: &str,
    reading: &ReadSettings,
    observer: &mut dyn Observer,
) -> Result<ComparedModels, Error> {
    let path = Path::new(name);
    let models = |source: &Models| -> Vec<SpeedModel> {
        let model = |point: &ModelPoint| {
            SpeedModel {
                thrust: point.point.thrust,
                surge_speed_m_s: point.point.surge_speed_m_s,
                model: point.point.model,
                covariance: point.covariance.unwrap_or_default(),
                degrees_of_freedom: match point.covariance {
                    // The document does not say from how long a run: the fewest.
                    Some(_) => degrees_of_freedom(&point.point.model, 0.0),
                    None => f64::INFINITY,
                },
                rudder_lag_s: point.rudder_lag_s,
            }
        };
        source.points.iter().map(model).collect()
    };
    if path.extension().is_some_and(|suffix| suffix == "toml") {
        let source = of_schedule_file(path)?;
        return Ok(ComparedModels::new(source.origin.clone(), source.rudder_unit, models(&source)).noting(
            "a schedule file states no uncertainty: its models count as exact, which makes false alarms likelier",
        ));
    }
    if begins_with_brace(path)? {
        let source = of_document_alone(path)?;
        if source.points.iter().any(|point| point.covariance.is_none()) {
            return Err(Error::Input(format!(
                "{}: a model without refined estimate has no uncertainty, and cannot be tested; identify without --as-paper",
                source.origin
            )));
        }
        let mut found =
            ComparedModels::new(source.origin.clone(), source.rudder_unit, models(&source));
        found.notes = [source.cautions, source.rejected].concat();
        return Ok(found);
    }
    from_log(name, reading, observer)
}

/// A JSON document begins with a brace, no log does.
fn begins_with_brace(path: &Path) -> Result<bool, Error> {
    if !path.is_file() {
        return Ok(false);
    }
    let unreadable = |error: std::io::Error| Error::Input(format!("{}: {error}", path.display()));
    let mut start = Vec::new();
    std::fs::File::open(path)
        .map_err(unreadable)?
        .take(64)
        .read_to_end(&mut start)
        .map_err(unreadable)?;
    let first = start.iter().find(|byte| !byte.is_ascii_whitespace());
    Ok(first == Some(&b'{'))
}

/// `LOG` or `LOG@FROM..TO`.
fn split_window(name: &str) -> Result<(PathBuf, Window), Error> {
    let whole = (PathBuf::from(name), Window::ALL);
    if whole.0.exists() {
        return Ok(whole);
    }
    let Some((path, span)) = name.rsplit_once('@') else {
        return Ok(whole);
    };
    let Some((from, to)) = span.split_once("..") else {
        return Ok(whole);
    };
    let second = |text: &str, open: f64| {
        if text.is_empty() {
            return Ok(open);
        }
        text.parse::<f64>().map_err(|_| {
            Error::Setting(format!(
                "{name}: `{text}` is not a number of seconds; expected LOG@FROM..TO, such as run.csv@40..56.5"
            ))
        })
    };
    let window =
        Window { from_s: second(from, f64::NEG_INFINITY)?, to_s: second(to, f64::INFINITY)? };
    if window.from_s < window.to_s {
        Ok((PathBuf::from(path), window))
    } else {
        Err(Error::Setting(format!("{name}: the window {window} is empty")))
    }
}

/// Opens a log, or a window of it.
pub fn open_named(
    name: &str,
    reading: &ReadSettings,
    observer: &mut dyn Observer,
) -> Result<(OpenedLog, Window), Error> {
    let (log, window) = split_window(name)?;
    // The estimator's filters are warmed on what comes before.
    let kept = Window { from_s: f64::NEG_INFINITY, ..window };
    let opened = open_inside(&log, reading, kept, observer)?;
    if opened.record.window(window).is_empty() {
        let span = match (opened.record.samples.first(), opened.record.samples.last()) {
            (Some(first), Some(last)) => format!("{} s to {} s", first.time_s, last.time_s),
            _ => "nothing".into(),
        };
        return Err(Error::Input(format!("{name}: no sample lies in the window; {span} was read")));
    }
    Ok((opened, window))
}

fn from_log(
    name: &str,
    reading: &ReadSettings,
    observer: &mut dyn Observer,
) -> Result<ComparedModels, Error> {
    let (log, window) = open_named(name, reading, observer)?;
    let mean = mean_speed_m_s(log.record.window(window));
    if mean.is_err()
        && window == Window::ALL
        && let Some(found) = of_several_speeds(name, &log, observer)?
    {
        return Ok(found);
    }
    let speed = mean.map_err(|spread| {
        Error::Input(format!(
            "{name}: the speed spreads by {:.0} % about its mean, one model holds at one speed; give a window of one manoeuvre, such as {}@40..56.5, or --speed none where the channel is not the speed",
            100.0 * spread,
            log.path.display()
        ))
    })?;
    let without = |why: String| ComparedModels {
        without_model: Some(why),
        log: Some(log.source()),
        ..ComparedModels::new(name.into(), log.rudder_unit(), Vec::new())
    };
    match identify(&log.record, window, None, &IdentifySettings::default()) {
        // Two records are compared by their intervals: neither needs validation data of its own.
        Ok(found) if found.verdict.outcome() == Outcome::DoNotUse => {
            let decisive = found.verdict.reasons.first();
            Ok(without(decisive.map_or_else(String::new, |reason| reason.measured().to_owned())))
        }
        Ok(found) => {
            let Some(model) = SpeedModel::of(&found, None, speed) else {
                return Ok(without(
                    "the record could not be refined, so there is no uncertainty".into(),
                ));
            };
            let mut source = ComparedModels::new(name.into(), log.rudder_unit(), vec![model]);
            source.log = Some(log.source());
            if found.verdict.has(&ReasonCode::ModelOrder) {
                source = source.noting(
                    "a first-order model does not hold: its numbers depend on the manoeuvre, compare equal ones only",
                );
            }
            if found.verdict.has(&ReasonCode::SamplesMissing) {
                source = source.noting("the rudder moved far while samples were missing");
            }
            Ok(source)
        }
        Err(IdentifyError::Refused(reason)) => Ok(without(reason.measured().to_owned())),
        Err(error) => Err(no_model(&log, error)),
    }
}

/// The models of a log that holds several speeds, from the manoeuvres that are found at each. `None` where none are found.
fn of_several_speeds(
    name: &str,
    log: &OpenedLog,
    observer: &mut dyn Observer,
) -> Result<Option<ComparedModels>, Error> {
    let Some(found) = identify_speeds(log, &IdentifySettings::default(), observer)? else {
        return Ok(None);
    };
    let mut source = ComparedModels::new(name.into(), log.rudder_unit(), Vec::new());
    source.log = Some(log.source());
    for model in &found {
        let usable = model.identification.as_ref();
        let usable = usable.filter(|_| model.verdict.outcome() != Outcome::DoNotUse);
        match usable.and_then(|i| SpeedModel::of(i, model.thrust, model.surge_speed_m_s)) {
            Some(of_speed) => source.models.push(of_speed),
            None => {
                let why = model.verdict.cause().map_or("", |cause| &cause.text);
                source = source.noting(format!("{} has no model: {why}", model.name()));
            }
        }
    }
    if source.models.is_empty() {
        source.without_model = Some("none of its manoeuvres gives a model".into());
    }
    Ok(Some(source))
}

/// The mean speed, or by which share of it the speed spreads where that is too much for one model.
fn mean_speed_m_s(samples: &[Sample<f64>]) -> Result<Option<f64>, f64> {
    let speeds: Vec<f64> = samples
        .iter()
        .filter_map(|sample| sample.surge_speed_m_s)
        .filter(|speed| speed.is_finite())
        .collect();
    if speeds.is_empty() {
        return Ok(None);
    }
    let n = speeds.len() as f64;
    let mean = speeds.iter().sum::<f64>() / n;
    if mean <= 0.0 {
        return Ok(None);
    }
    let variance = speeds.iter().map(|u| (u - mean).powi(2)).sum::<f64>() / n;
    let spread = variance.sqrt() / mean;
    if spread > LARGEST_SPEED_SPREAD { Err(spread) } else { Ok(Some(mean)) }
}

/// `CAMPAIGN` or `CAMPAIGN:RUN`.
fn from_logbook(name: &str, path: &Path) -> Result<ComparedModels, Error> {
    let logbook = undamaged(path)?;
    let with_run = name
        .rsplit_once(':')
        .and_then(|(campaign, run)| Some((campaign, run.parse::<u32>().ok()?)));
    let (campaign, run) = match with_run {
        Some((campaign, run)) => (campaign, Some(run)),
        None => (name, None),
    };
    let entry = campaign_named(&logbook, campaign)?;
    let mut origin = format!(
        "{}, campaign {} ({}, {})",
        path.display(),
        entry.id.0,
        entry.configuration,
        entry.started
    );
    let campaign = logbook.campaign(entry.id)?;
    let runs: Vec<&Run> = match run {
        Some(number) => {
            let _ = std::fmt::Write::write_fmt(&mut origin, format_args!(", run {number}"));
            let found = campaign.runs.iter().find(|run| run.number == number);
            vec![found.ok_or_else(|| {
                Error::Input(format!(
                    "{origin}: there is none; the campaign has runs 1 to {}",
                    campaign.runs.len()
                ))
            })?]
        }
        None => campaign.accepted_runs(),
    };
    let mut source = ComparedModels {
        campaign: run.is_none().then_some(entry.id),
        ..ComparedModels::new(origin, RudderUnit::Rad, Vec::new())
    };
    for run in runs {
        let model = run
            .identification
            .as_ref()
            .and_then(|found| SpeedModel::of(found, Some(run.thrust), run.surge_speed_m_s));
        match model {
            Some(model) => source.models.push(model),
            None => source = source.noting(format!("run {} has no refined model", run.number)),
        }
        if !run.verdict.accepted {
            source = source.noting(format!("run {} was not accepted", run.number));
        }
    }
    if source.models.is_empty() {
        source.without_model = Some("no accepted run with a refined model".into());
    }
    Ok(source)
}
