//! The options that give `turn`, `gains` and `plan` their models: numbers, an identification, a trial, a logbook, a
//! schedule file.

use std::path::{Path, PathBuf};

use seatrial_app::models::{Models, of_document, of_schedule_file};
use seatrial_app::trials::campaign_models::of_campaign;
use seatrial_core::YawModel;

use crate::output::{Failure, say};

/// Where a trial is kept, unless it is said.
const USUAL_LOGBOOK: &str = "seatrial.db";

/// The options that give the numbers of a single model.
#[derive(clap::Args, Clone, Copy, Debug)]
pub struct NumbersArgs {
    /// a22 of a single model, 1/s, negative for a course-stable vehicle.
    #[arg(long, value_name = "PER_S", requires = "b2", allow_negative_numbers = true)]
    a22: Option<f64>,
    /// b2 of the single model, 1/s^2.
    #[arg(long, value_name = "PER_S2", requires = "a22", allow_negative_numbers = true)]
    b2: Option<f64>,
    /// C0 of the single model, rad/s^2; 0 without.
    #[arg(long, value_name = "RAD_PER_S2", requires = "a22", allow_negative_numbers = true)]
    c0: Option<f64>,
}

impl NumbersArgs {
    /// The model, where it is given.
    pub fn model(self) -> Option<YawModel<f64>> {
        let c0 = self.c0.unwrap_or(0.0);
        Some(YawModel::from_theta([self.a22?, self.b2?, c0]))
    }
}

/// The options that give one model or several.
#[derive(clap::Args, Debug)]
pub struct SourceArgs {
    #[command(flatten)]
    numbers: NumbersArgs,
    /// Forward speed of a single model, m/s.
    #[arg(long, value_name = "M_S", conflicts_with = "schedule")]
    speed: Option<f64>,
    /// Document of `seatrial identify --json` or `seatrial trial --json`.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["a22", "schedule"])]
    model: Option<PathBuf>,
    /// Schedule of models over speed or thrust, TOML.
    #[arg(long, value_name = "FILE", conflicts_with = "a22")]
    schedule: Option<PathBuf>,
    /// Logbook with a trial [default: seatrial.db, where nothing else gives a model]: the models of the accepted runs of
    /// its last campaign that finished with any, on a vehicle
    /// before a rehearsal.
    #[arg(
        long,
        value_name = "FILE",
        conflicts_with_all = ["a22", "model", "schedule", "speed"]
    )]
    logbook: Option<PathBuf>,
    /// Number of a campaign in the logbook, however it ended, or the name of a configuration.
    #[arg(long, value_name = "CAMPAIGN", conflicts_with_all = ["a22", "model", "schedule", "speed"])]
    campaign: Option<String>,
    /// Largest rudder angle, degrees; else the plan's or the source's, else 14.9 (0.26 rad).
    #[arg(long, value_name = "DEG")]
    rudder_limit_deg: Option<f64>,
}

impl SourceArgs {
    /// Is any model given?
    pub fn is_given(&self) -> bool {
        self.numbers.a22.is_some()
            || self.campaign.is_some()
            || [&self.model, &self.schedule, &self.logbook].into_iter().any(Option::is_some)
    }

    /// The rudder limit of the command line, rad.
    pub fn rudder_limit_rad(&self) -> Option<f64> {
        self.rudder_limit_deg.map(f64::to_radians)
    }

    /// Reads the models.
    pub fn read(&self) -> Result<Models, Failure> {
        let models = match (&self.model, &self.schedule, &self.logbook) {
            (Some(path), ..) => of_document(path, self.speed)?,
            (None, Some(path), _) => of_schedule_file(path)?,
            (None, None, Some(path)) => of_campaign(path, self.campaign.as_deref())?,
            (None, None, None) => match self.numbers.model() {
                Some(model) => Models::given(model, self.speed),
                None => self.of_usual_logbook()?,
            },
        };
        Ok(models.limited(self.rudder_limit_rad())?)
    }

    /// The models of the logbook that a trial writes where none is named.
    fn of_usual_logbook(&self) -> Result<Models, Failure> {
        let usual = Path::new(USUAL_LOGBOOK);
        if !usual.exists() {
            return Err(Failure::usage(
                "no model: give --a22 and --b2, --model FILE, --schedule FILE or --logbook FILE",
            ));
        }
        Ok(of_campaign(usual, self.campaign.as_deref())?)
    }
}

/// Prints on standard error what a source says against its models, and where they are used beyond what they were seen for.
pub fn warn(models: &Models) {
    for reason in models.warnings() {
        say(format!("warning: {}: {reason}", models.origin));
    }
}

/// Why what is made of models is not to be used, where they are not.
pub fn rejected_text(rejected: &[String]) -> String {
    let causes = rejected.iter().take(1);
    causes.map(|cause| format!("DO NOT USE: {cause}\n")).collect()
}

/// The trial of a source on a line of its own, where it is of one.
pub fn trial_line(trial: Option<&str>) -> String {
    trial.map_or(String::new(), |trial| format!("{trial}\n"))
}
