//! Trials and logs of the pitch axis: elevator doublets, the model that they give, and how they are kept.

use std::fmt::Write as _;
use std::path::Path;

use seatrial::pitch::{self, PitchIdentification, PitchPlan, PitchRun, PitchTrial};
use seatrial_core::DivingSample;
use seatrial_logbook::{Logbook, NewPitchTrial, PitchEntry};
use seatrial_sim::SimulatedVehicle;
use serde::Serialize;

use crate::Error;
use crate::identify_log::Logs;
use crate::logs::Source;
use crate::simulated;
use crate::trial_run::VehicleError;

/// Columns of a pitch log.
const COLUMNS: [&str; 5] = [
    "time_s",
    "pitch_rad",
    "elevator_rad",
    "depth_m",
    "surge_speed_m_s",
];

/// `trial --axis pitch --json`.
#[derive(Debug, Serialize)]
pub struct PitchTrialDocument<'a> {
    schema: &'static str,
    /// The vehicle by its name.
    pub vehicle: &'a str,
    seed: Option<u64>,
    plan: &'a PitchPlan,
    /// One entry a thrust.
    pub runs: &'a [PitchRun],
    /// Why it ended early, where it did.
    pub aborted: Option<&'a str>,
}

impl<'a> PitchTrialDocument<'a> {
    /// The document of a trial.
    pub fn of(vehicle: &'a str, seed: Option<u64>, trial: &'a PitchTrial) -> Self {
        Self {
            schema: "seatrial.pitch_trial.v1",
            vehicle,
            seed,
            plan: &trial.plan,
            runs: &trial.runs,
            aborted: trial.aborted.as_deref(),
        }
    }
}

/// The pitch trial of that number, or the last one.
pub fn chosen(logbook: &Logbook, number: Option<i64>) -> Result<(PitchEntry, PitchTrial), Error> {
    let number = match number {
        Some(number) => Some(number),
        None => logbook.pitch_trials()?.last().map(|entry| entry.number),
    };
    let number = number.ok_or_else(|| {
        Error::Input(format!(
            "{}: the logbook holds no pitch trial yet; `seatrial trial --axis pitch` runs one",
            logbook.path().display()
        ))
    })?;
    Ok(logbook.pitch_trial(number)?)
}

/// `replay --axis pitch --json`.
#[derive(Debug, Serialize)]
pub struct PitchReplay {
    schema: &'static str,
    /// Number of the trial in its logbook.
    pub pitch_trial: i64,
    /// The version of seatrial that ran it.
    pub recorded_by: String,
    /// The version that ran it again.
    pub replayed_by: &'static str,
    /// Is every number and every decision equal, bit for bit? The words of reasons may be those of another version.
    pub identical: bool,
    /// Samples taken.
    pub samples: usize,
    /// Results made again.
    #[serde(skip)]
    pub results: usize,
}

impl PitchReplay {
    /// Runs a trial again on the samples that it took.
    pub fn of(entry: &PitchEntry, trial: &PitchTrial) -> Self {
        Self {
            schema: "seatrial.pitch_replay.v1",
            pitch_trial: entry.number,
            recorded_by: entry.software_version.clone(),
            replayed_by: env!("CARGO_PKG_VERSION"),
            identical: without_words(trial.again()) == without_words(trial.clone()),
            samples: trial.samples.len(),
            results: trial.runs.len(),
        }
    }
}

fn without_words(mut trial: PitchTrial) -> PitchTrial {
    let found = trial
        .runs
        .iter_mut()
        .filter_map(|run| run.identification.as_mut());
    found.for_each(|found| found.reason.clear());
    trial
}

/// Runs a pitch trial on a simulated vehicle and enters it in the logbook; its number there.
pub fn trial(
    vehicle: &str,
    seed: u64,
    plan: PitchPlan,
    configuration: &str,
    logbook: &mut Logbook,
) -> Result<(i64, PitchTrial), PitchTrialError> {
    let SimulatedVehicle::SixDof(mut simulated) = simulated::vehicle(vehicle, seed)? else {
        return Err(PitchTrialError::NoPitch(vehicle.into()));
    };
    let trial = pitch::trial(simulated.as_mut(), plan);
    let about = NewPitchTrial {
        configuration,
        software_version: env!("CARGO_PKG_VERSION"),
        vehicle,
        seed: Some(seed),
    };
    Ok((logbook.enter_pitch_trial(&about, &trial)?, trial))
}

/// Why there was no pitch trial, or it is not in the logbook.
#[derive(Debug, thiserror::Error)]
pub enum PitchTrialError {
    /// The vehicle only turns.
    #[error(
        "--axis pitch: {0} has no pitch, it only turns; take sim:starfish-6dof or sim:remus100"
    )]
    NoPitch(String),
    /// The vehicle cannot be used.
    #[error(transparent)]
    Vehicle(#[from] VehicleError),
    /// It cannot be entered.
    #[error(transparent)]
    Logbook(#[from] seatrial_logbook::Error),
}

/// The plan of a file; what it leaves out is the default's.
pub fn load_plan(path: &Path) -> Result<PitchPlan, Error> {
    let failure = |problem: &str| Error::Input(format!("{}: {problem}", path.display()));
    let text = std::fs::read_to_string(path).map_err(|error| failure(&error.to_string()))?;
    let plan: PitchPlan = toml::from_str(&text)
        .map_err(|error| failure(&format!("not a plan of a pitch trial: {error}")))?;
    plan.check()
        .map_err(|(field, requirement)| failure(&format!("{field} must be {requirement}")))?;
    Ok(plan)
}

/// The log of a trial, which [`identify`] reads.
pub fn csv(samples: &[DivingSample<f64>]) -> String {
    let mut text = COLUMNS.join(",") + "\n";
    let optional = |value: Option<f64>| value.map_or_else(String::new, |value| value.to_string());
    for sample in samples {
        let _ = writeln!(
            text,
            "{},{},{},{},{}",
            sample.time_s,
            sample.pitch_rad,
            sample.elevator_rad,
            optional(sample.depth_m),
            optional(sample.surge_speed_m_s)
        );
    }
    text
}

/// `identify --axis pitch --json`.
#[derive(Debug, Serialize)]
pub struct PitchLogDocument {
    schema: &'static str,
    source: Source,
    /// The model and how it does on validation data.
    #[serde(flatten)]
    pub identification: PitchIdentification,
}

/// Identifies pitch in a log whose heading is the pitch and whose rudder is the elevator.
pub fn identify(logs: &Logs) -> Result<PitchLogDocument, Error> {
    if logs.validation_log.is_some() {
        return Err(Error::Setting(
            "--validate-on does not go with --axis pitch".into(),
        ));
    }
    let samples: Vec<DivingSample<f64>> = logs
        .log
        .record
        .samples
        .iter()
        .map(|sample| DivingSample {
            time_s: sample.time_s,
            pitch_rad: sample.heading_rad,
            elevator_rad: sample.rudder_rad,
            depth_m: sample.depth_m,
            surge_speed_m_s: sample.surge_speed_m_s,
        })
        .collect();
    let identification = pitch::identify(&samples, logs.training, logs.validation)
        .map_err(|error| Error::Rejected(format!("{}: {error}", logs.log.path.display())))?;
    Ok(PitchLogDocument {
        schema: "seatrial.pitch_identification.v1",
        source: logs.log.source(),
        identification,
    })
}
