//! What the tools that move nothing answer.

use std::path::{Path, PathBuf};

use seatrial::identification::Outcome;
use seatrial_app::assist::{ReportedLog, ReportedReason, ReportedTrial, ReportedVerdict};
use seatrial_app::compare_log::compare_log;
use seatrial_app::identify_log::{Options, Windows, identify_log};
use seatrial_app::logs::{NoObserver, ReadSettings, open, servo_of};
use seatrial_app::models::of_document;
use seatrial_app::trials::campaign_models::compared_models;
use seatrial_app::trials::health::{Comparison, Criteria, change, reference};
use seatrial_app::trials::order::rehearse;
use seatrial_app::trials::plan::{Changes, ExpectedVehicle, PreviewRequest, plan_trial};
use seatrial_app::trials::simulator;
use seatrial_app::{Error, Inspection};
use seatrial_core::{List, Plan};
use seatrial_logs::{Fault, ReadError};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

/// A sentence to repeat, and what it rests on.
pub struct Content {
    /// The sentence.
    pub say: String,
    /// The document.
    pub document: Value,
}

/// What a tool found, or why it found nothing.
pub type Answer = Result<Content, String>;

/// Speeds of a simulated trial: one of all speeds takes seconds.
const MOST_SPEEDS: usize = 16;

fn answer(say: impl Into<String>, document: &impl Serialize) -> Answer {
    Ok(Content {
        say: say.into(),
        document: serde_json::to_value(document).map_err(|error| error.to_string())?,
    })
}

/// An error in words, without what stands in a file that is no log: an assistant may name any file of this machine.
fn words(error: impl Into<Error>) -> String {
    let error = error.into();
    if let Error::Log(ReadError { log, fault }) = &error
        && !matches!(fault, Fault::Io { .. } | Fault::Folder | Fault::Empty)
        && !seatrial_logs::is_log(Path::new(log))
    {
        return format!(
            "{log}: no log that is understood: expected columns or messages with a time, a heading and a rudder; a person sees with `seatrial inspect` what is there"
        );
    }
    error.to_string()
}

/// A log and how to read it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LogQuestion {
    log: PathBuf,
    channels_file: Option<PathBuf>,
    rudder_delay_s: Option<f64>,
    rudder_lag_s: Option<f64>,
    #[serde(default)]
    drop_invalid: bool,
    from_s: Option<f64>,
    to_s: Option<f64>,
    validate_from_s: Option<f64>,
    validate_to_s: Option<f64>,
    validate_on: Option<PathBuf>,
}

impl LogQuestion {
    fn reading(&self) -> Result<ReadSettings, String> {
        let servo = servo_of(self.rudder_delay_s, self.rudder_lag_s);
        let mut settings = ReadSettings::default();
        settings.channels_file = self.channels_file.clone();
        settings.channels.drop_invalid = self.drop_invalid;
        settings.servo = servo.map_err(|invalid| format!("rudder_{invalid}"))?;
        Ok(settings)
    }

    fn options(&self) -> Result<Options, String> {
        let mut options = Options::default();
        options.reading = self.reading()?;
        options.windows = self.windows();
        Ok(options)
    }

    fn windows(&self) -> Windows {
        Windows {
            from_s: self.from_s,
            to_s: self.to_s,
            validate_from_s: self.validate_from_s,
            validate_to_s: self.validate_to_s,
            validate_on: self.validate_on.clone(),
        }
    }
}

/// What is in a log.
pub fn inspect(asked: &LogQuestion) -> Answer {
    let opened = open(&asked.log, &asked.reading()?, None, &mut NoObserver).map_err(words)?;
    let found = Inspection::of(&opened);
    let outcome = found.verdict.outcome();
    let cause = found.verdict.cause().map_or("", |cause| &cause.text);
    let say = match outcome {
        Outcome::DoNotUse => format!("No model can be identified: {cause}"),
        _ => format!("A model may be identified from this log: {}.", outcome.name()),
    };
    answer(say, &found)
}

/// The model of each speed of a log.
pub fn identify(asked: &LogQuestion) -> Answer {
    let options = asked.options()?;
    let found = ReportedLog::of(&identify_log(&asked.log, &options).map_err(words)?);
    answer(found.verdict.say.clone(), &found)
}

/// Every method on a log, and the verdict that `identify` has of it.
pub fn compare(asked: &LogQuestion) -> Answer {
    let options = asked.options()?;
    let compared =
        compare_log(&asked.log, &options.windows, &options.reading, None, &mut NoObserver);
    let compared = compared.map_err(words)?;
    let identified = identify_log(&asked.log, &options).map_err(words)?;
    let verdict = ReportedVerdict::of(identified.verdict());
    let say = format!("The methods side by side; none of them is a verdict. {}", verdict.say);
    answer(say, &json!({"comparison": compared.document, "verdict": verdict}))
}

/// Two states of a vehicle.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HealthQuestion {
    reference: String,
    now: String,
    logbook: Option<PathBuf>,
}

/// Has the vehicle changed?
pub fn health(asked: &HealthQuestion) -> Answer {
    let logbook = asked.logbook.clone();
    let logbook = logbook.unwrap_or_else(|| "seatrial.db".into());
    let reading = ReadSettings::default();
    let models = |name: &str| compared_models(name, &logbook, &reading, &mut NoObserver);
    let was = models(&asked.reference).map_err(words)?;
    let now = models(&asked.now).map_err(words)?;
    let criteria = Criteria { false_alarms: 0.05, tolerated: None, offset_counts: None };
    let settings = criteria.between_trials().map_err(words)?;
    let change = change(&was, &reference(&was).map_err(words)?, &now, &settings);
    answer(change.because.clone(), &Comparison::of(&was, &now, &change))
}

/// A plan by its differences from the paper's.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanQuestion {
    file: Option<PathBuf>,
    #[serde(default)]
    thrusts: Vec<f64>,
    amplitude_deg: Option<f64>,
    period_s: Option<f64>,
    time_constant_s: Option<f64>,
    target: Option<String>,
    vehicle: Option<String>,
    model: Option<PathBuf>,
}

/// A plan and what to expect of it.
pub fn plan(asked: &PlanQuestion) -> Answer {
    if asked.time_constant_s.is_some_and(|time| !(time > 0.0 && time.is_finite())) {
        return Err("time_constant_s: expected a number above 0".into());
    }
    let target = asked.target.as_deref().map(seatrial::preview::parse_target);
    let target = target.transpose().map_err(|error| error.to_string())?;
    let models = asked.model.as_ref().map(|path| of_document(path, None));
    let expected = ExpectedVehicle {
        vehicle: asked.vehicle.clone(),
        models: models.transpose().map_err(words)?,
        ..ExpectedVehicle::default()
    };
    let changes = Changes {
        file: asked.file.clone(),
        thrusts: asked.thrusts.clone(),
        amplitude_rad: asked.amplitude_deg.map(f64::to_radians),
        period_s: asked.period_s,
        time_constant_s: asked.time_constant_s,
        ..Changes::default()
    };
    let wanted = PreviewRequest { target, ..PreviewRequest::default() };
    let found = plan_trial(&changes, &expected, wanted).map_err(words)?;
    let toml = toml::to_string_pretty(&found.plan).map_err(|error| error.to_string())?;
    let say = match found.will_do() {
        true => "On the vehicle that is expected the plan will do.",
        false => {
            "On the vehicle that is expected the plan will not do: it leaves its envelope, tells too little, or the target is out of reach."
        }
    };
    answer(say, &json!({"will_do": found.will_do(), "plan_toml": toml, "expected": found}))
}

/// A code.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExplainQuestion {
    code: String,
    of: Option<String>,
}

/// What a code means.
pub fn explain(asked: &ExplainQuestion) -> Answer {
    let reason = ReportedReason::of_code(&asked.code, asked.of.as_deref())
        .ok_or_else(|| format!("no code {:?} in any verdict", asked.code))?;
    answer(format!("{} {}", reason.cause, reason.action), &reason)
}

/// A simulated trial.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SimulateQuestion {
    vehicle: Option<String>,
    #[serde(default)]
    thrusts: Vec<f64>,
    seed: Option<u64>,
}

/// A whole trial on a simulated vehicle.
pub fn simulate(asked: &SimulateQuestion) -> Answer {
    let name = asked.vehicle.as_deref().unwrap_or("sim:starfish");
    let mut plan = Plan::paper();
    if !asked.thrusts.is_empty() {
        plan.thrusts = List::from_slice(&asked.thrusts)
            .ok_or_else(|| format!("thrusts: at most {MOST_SPEEDS}"))?;
    }
    let seed = asked.seed.unwrap_or(1);
    let mut vehicle = simulator::vehicle(name, seed).map_err(|error| error.to_string())?;
    let conducted = rehearse(&mut vehicle, name, seed, plan);
    let conducted = conducted.map_err(|error| format!("the plan: {error}"))?;
    let found = ReportedTrial::of(&conducted.campaign);
    let say = format!("A rehearsal on {name}, of no real vehicle. {}", found.verdict.say);
    answer(say, &found)
}
