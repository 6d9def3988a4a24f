//! Has the vehicle changed? Two sets of models compared, or mission logs watched.

use seatrial::health::{
    Change, HealthError, HealthSettings, Reference, SpeedModel, Watch, WatchReport, compare,
};
use seatrial::{Record, Window};
use seatrial_core::{RudderUnit, YawModel};
use serde::Serialize;

use crate::Error;
use crate::error::{OTHER_UNIT, other_unit};
use crate::logs::{OpenedLog, Source};
use crate::trials::campaign_models::ComparedModels;

/// Changes of a22 and b2 up to this share are none, unless asked for, where two trials are compared.
const TOLERATED_BETWEEN_TRIALS: f64 = 0.0;
/// Changes of a22 and b2 up to this share are none, unless asked for, over ordinary missions.
const TOLERATED_IN_MISSIONS: f64 = 0.05;

/// When a difference counts as a change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Criteria {
    /// How often an unchanged vehicle may be called changed, as a share of all answers.
    pub false_alarms: f64,
    /// Changes of damping and rudder up to this share are none; without, 0, and 0.05 over missions.
    pub tolerated: Option<f64>,
    /// Is an offset that moved a change? Without: between trials yes, over missions no, where wind, current and trim move it.
    pub offset_counts: Option<bool>,
}

impl Criteria {
    /// The settings for two sets of models.
    pub fn between_trials(&self) -> Result<HealthSettings, HealthError> {
        self.settings(TOLERATED_BETWEEN_TRIALS, true)
    }

    /// The settings for mission logs.
    pub fn in_missions(&self) -> Result<HealthSettings, HealthError> {
        self.settings(TOLERATED_IN_MISSIONS, false)
    }

    fn settings(&self, tolerated: f64, offset_counts: bool) -> Result<HealthSettings, HealthError> {
        HealthSettings::new(
            self.false_alarms,
            self.tolerated.unwrap_or(tolerated),
            self.offset_counts.unwrap_or(offset_counts),
        )
    }
}

/// The models that others are compared with.
pub fn reference(models: &ComparedModels) -> Result<Reference, Error> {
    if let Some(why) = &models.without_model {
        return Err(Error::Rejected(format!("{}: no model to compare with: {why}", models.origin)));
    }
    Reference::new(models.models.clone())
        .map_err(|error| Error::Input(format!("{}: {error}", models.origin)))
}

/// A trial compared with itself says nothing.
pub fn are_two(reference: &ComparedModels, now: &ComparedModels) -> Result<(), Error> {
    match (reference.campaign, now.campaign) {
        (Some(one), Some(other)) if one == other => Err(Error::Input(format!(
            "{}: both names are this trial; give the numbers of two: `seatrial logbook` shows them",
            now.origin
        ))),
        _ => Ok(()),
    }
}

/// The change from the reference to what is now.
pub fn change(
    was: &ComparedModels,
    reference: &Reference,
    now: &ComparedModels,
    settings: &HealthSettings,
) -> Change {
    let cannot_tell = |why: &str, action: &str| {
        Change::cannot_tell(settings, format!("{}: {why}", now.origin), action)
    };
    match (&now.without_model, differ(was, now)) {
        (Some(why), _) => cannot_tell(why, ""),
        (None, Some((why, action))) => cannot_tell(why, action),
        (None, None) => compare(reference, &now.models, settings),
    }
}

/// Why the rudders of two sets of models are not in one unit, or do not count to one side.
fn differ(was: &ComparedModels, now: &ComparedModels) -> Option<(&'static str, &'static str)> {
    if was.rudder_unit != now.rudder_unit {
        return Some(OTHER_UNIT);
    }
    let side = |models: &ComparedModels| {
        let mut signs = models.models.iter().map(|point| point.model.b2_per_s2.signum());
        let first = signs.next()?;
        signs.all(|sign| sign == first).then_some(first)
    };
    let is_reversed = side(was)? != side(now)?;
    is_reversed.then_some((
        "its rudder, or its heading, counts to the other side than that of the reference",
        "Turn one of the two columns: reversed = true in a [channels] file.",
    ))
}

/// Mission logs that are watched, in order of time.
pub struct Missions {
    watch: Watch,
    rudder_unit: RudderUnit,
    started: Option<(String, String)>,
    logs: Vec<Source>,
}

impl Missions {
    /// Watches for a change from the models of a reference.
    pub fn new(models: &ComparedModels, settings: HealthSettings) -> Result<Self, Error> {
        let watch = Watch::new(reference(models)?, settings)
            .map_err(|error| Error::Input(format!("{}: {error}", models.origin)))?;
        Ok(Self { watch, rudder_unit: models.rudder_unit, started: None, logs: Vec::new() })
    }

    /// Takes the next log, or a window of it. One that began before the last is refused, or whose rudder is in another unit.
    pub fn read(&mut self, name: &str, log: &OpenedLog, window: Window) -> Result<(), Error> {
        if log.rudder_unit() != self.rudder_unit {
            return Err(other_unit(name));
        }
        if let Some(start) = &log.description.start_utc {
            if let Some((earlier, earlier_start)) = &self.started
                && start < earlier_start
            {
                return Err(Error::Setting(format!(
                    "{name} begins at {start}, before {earlier}, which begins at {earlier_start}: give the logs in order of time"
                )));
            }
            self.started = Some((name.to_owned(), start.clone()));
        }
        let record = Record {
            samples: log.record.window(window).to_vec(),
            rudder_unit: log.rudder_unit(),
            units: log.record.units,
        };
        self.watch.read(name, &record);
        self.logs.push(log.source());
        Ok(())
    }

    /// What was found in them.
    pub fn report(&self) -> WatchReport {
        self.watch.report()
    }

    /// The logs.
    pub fn logs(&self) -> &[Source] {
        &self.logs
    }
}

/// Where models came from.
#[derive(Debug, Serialize)]
pub struct Origin<'a> {
    origin: &'a str,
    log: Option<&'a Source>,
    models: Vec<OriginModel>,
    notes: &'a [String],
}

#[derive(Debug, Serialize)]
struct OriginModel {
    thrust: Option<f64>,
    surge_speed_m_s: Option<f64>,
    #[serde(flatten)]
    model: YawModel<f64>,
    covariance: [[f64; 3]; 3],
}

impl<'a> Origin<'a> {
    fn of(source: &'a ComparedModels) -> Self {
        let model = |point: &SpeedModel| OriginModel {
            thrust: point.thrust,
            surge_speed_m_s: point.surge_speed_m_s,
            model: point.model,
            covariance: point.covariance,
        };
        Self {
            origin: &source.origin,
            log: source.log.as_ref(),
            models: source.models.iter().map(model).collect(),
            notes: &source.notes,
        }
    }
}

/// `health --json` of two sets of models.
#[derive(Debug, Serialize)]
pub struct Comparison<'a> {
    schema: &'static str,
    kind: &'static str,
    reference: Origin<'a>,
    now: Origin<'a>,
    #[serde(flatten)]
    change: &'a Change,
}

impl<'a> Comparison<'a> {
    /// The document of a change.
    pub fn of(reference: &'a ComparedModels, now: &'a ComparedModels, change: &'a Change) -> Self {
        Self {
            schema: "seatrial.health.v1",
            kind: "comparison",
            reference: Origin::of(reference),
            now: Origin::of(now),
            change,
        }
    }
}

/// `health --watch --json`.
#[derive(Debug, Serialize)]
pub struct WatchDocument<'a> {
    schema: &'static str,
    kind: &'static str,
    reference: Origin<'a>,
    logs: &'a [Source],
    #[serde(flatten)]
    report: &'a WatchReport,
}

impl<'a> WatchDocument<'a> {
    /// The document of what was found in missions.
    pub fn of(reference: &'a ComparedModels, logs: &'a [Source], report: &'a WatchReport) -> Self {
        Self {
            schema: "seatrial.health.v1",
            kind: "watch",
            reference: Origin::of(reference),
            logs,
            report,
        }
    }
}

impl From<HealthError> for Error {
    fn from(error: HealthError) -> Self {
        match error {
            HealthError::Setting { .. } => Self::Setting(error.to_string()),
            _ => Self::Input(error.to_string()),
        }
    }
}
