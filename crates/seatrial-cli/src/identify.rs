//! `seatrial identify`: a model from a log.

#[cfg(test)]
mod agreement;

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use seatrial::Identification;
use seatrial::identification::{Outcome, ReasonCode, Subject, Verdict};
use seatrial::identify::IdentifySettings;
use seatrial::words::{sentence, three_figures};
use seatrial_app::identify_log::{IdentifiedLog, Logs, Options, identify_log_observed};
use seatrial_app::log_page::speed_rows;
use seatrial_app::next;
use seatrial_core::Axis;
use seatrial_core::estimator::Method;

use crate::choice::{AXES, one_of};
use crate::log::{LogArgs, Reporter};
use crate::model_text::{model_text, source_text, training_text, validation_text, verdict_text};
use crate::output::{Exit, Failure, Output, OutputPath};
use crate::screen::{command, labelled, width, wrapped};
use crate::speed_table::{promise_text, speed_table};
use crate::speeds;
use crate::windows::WindowArgs;

/// Identify a yaw model from a log, validate it on validation data and judge it.
#[derive(clap::Args, Debug)]
#[command(after_help = "\
Without windows the manoeuvres of the log are looked for: for each speed (thrust, where the log has it) the best excited \
one trains, joined with others, and another one validates. A log without manoeuvres, or with one alone, is used for training \
as a whole. Where its rudder was deflected four times or more, its own legs validate it: a model of the first legs \
must predict the others. A log of ordinary steering, by an autopilot or by hand, needs no manoeuvre: the whole of it is \
fitted, without stops and gaps, and checked on its last two fifths. For the estimator the excitation ends when the rudder has been deflected to both sides and comes \
back from the second.

The first line is the outcome: USE, USE WITH CARE, NOT VALIDATED or DO NOT USE. Exit code 0: the model, or one of several, \
may be used; 4: none may, and the verdict says why.

Example:
  seatrial sim log --seed 1 --out run.csv && seatrial identify run.csv")]
pub struct Args {
    /// The axis: yaw, or pitch from the columns pitch_rad and elevator_rad, or those of --heading and --rudder.
    #[arg(long, value_name = "AXIS", default_value = "yaw", value_parser = one_of(AXES))]
    axis: Axis,
    /// Write the accepted models of a log with manoeuvres at several speeds as a schedule for `gains` and `turn`.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["WindowArgs", "as_paper"])]
    schedule: Option<OutputPath>,
    /// Keep the estimate after every sample in the JSON document.
    #[arg(long)]
    trace: bool,
    /// Print what the method did: windows, filter, estimates, and what was measured for each reason.
    #[arg(long)]
    verbose: bool,
    /// Exit with 0 also where the model fits its training record and nothing was held out to check it.
    #[arg(long)]
    accept_unvalidated: bool,
    #[command(flatten)]
    log: LogArgs,
    /// Further logs of the same vehicle and load: one model a speed of all, and one log validates it.
    #[arg(value_name = "LOG")]
    more_logs: Vec<PathBuf>,
    #[command(flatten)]
    windows: WindowArgs,
    #[command(flatten)]
    estimator: EstimatorArgs,
}

/// How to estimate.
#[derive(clap::Args, Debug)]
#[command(next_help_heading = "Estimation")]
pub struct EstimatorArgs {
    /// Pole of the state variable filter, rad/s, or `auto` to derive it from the data (the paper's 1
    /// with --as-paper).
    #[arg(long, value_name = "auto|RAD_S", default_value = "auto", value_parser = lambda, allow_negative_numbers = true)]
    lambda: Lambda,
    /// Equations (16)-(31) and the recursion to the letter, without refinement.
    #[arg(long)]
    as_paper: bool,
    /// The estimator that runs along [default: instrumental-variable, with --as-paper least-squares].
    #[arg(long, value_name = "METHOD", value_parser = one_of(METHODS))]
    online: Option<Method>,
}

#[derive(Clone, Copy, Debug)]
enum Lambda {
    Auto,
    RadS(f64),
}

fn lambda(text: &str) -> Result<Lambda, String> {
    match (text, text.parse()) {
        ("auto", _) => Ok(Lambda::Auto),
        (_, Ok(value)) if value > 0.0 && f64::is_finite(value) => Ok(Lambda::RadS(value)),
        _ => Err("expected `auto` or a positive number of rad/s".into()),
    }
}

/// The values of `--online`.
const METHODS: [(Method, &str, &str); 2] = [
    (Method::LeastSquares, "least-squares", "Recursive least squares throughout"),
    (
        Method::InstrumentalVariable,
        "instrumental-variable",
        "Recursive least squares during the excitation, the instrumental variable after it",
    ),
];

/// Identifies a model from a log.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    let found = args.estimator.identify(
        args.axis,
        (&args.log, &args.more_logs),
        &args.windows,
        args.trace,
        args.verbose,
    )?;
    // Saved first, because the text names what was kept.
    let saved = match (&args.schedule, &found.models) {
        (None, _) => Ok(()),
        (Some(path), Some(models)) => {
            speeds::save_schedule(path, models, &found.logs.log.source(), output)
        }
        (Some(_), None) => Err(Failure::rejected(format!(
            "{}: --schedule: its models are not of several speeds: save the document of --json, which gains and turn read with --model",
            found.logs.log.path.display()
        ))),
    };
    let schedule = args.schedule.as_deref().filter(|_| saved.is_ok());
    output.print(&found.document(), || match args.verbose {
        true => wrapped(&verbose_text(&found), width()),
        false => text(&found, &call(), schedule, width()),
    })?;
    saved?;
    Ok(match found.verdict().outcome() {
        Outcome::NotValidated if args.accept_unvalidated => Exit::Done,
        _ => Exit::of(found.verdict()),
    })
}

/// The command as it was typed, for the commands that go on from it.
pub fn call() -> String {
    let typed = std::env::args_os().skip(1).map(|typed| quoted(&typed));
    let words: Vec<String> = std::iter::once("seatrial".into()).chain(typed).collect();
    words.join(" ")
}

/// An argument as a shell takes it; its bytes where it is no text.
fn quoted(argument: &OsStr) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./=:,+".contains(c);
    match argument.to_str() {
        Some(text) if text.chars().all(is_plain) && !text.is_empty() => text.to_owned(),
        Some(text) => format!("'{}'", text.replace('\'', r"'\''")),
        None => format!("$'{}'", argument.as_encoded_bytes().escape_ascii()),
    }
}

/// The outcome, a table of one line a speed, the cause of the outcome and the next command.
pub fn text(found: &IdentifiedLog, call: &str, schedule: Option<&Path>, width: usize) -> String {
    let verdict = found.verdict();
    let log = &found.logs.log;
    let mut text = labelled("", &verdict.outcome().name().to_uppercase(), width);
    let rows = speed_rows(found);
    text += &promise_text(&rows, width);
    text += &speed_table(&rows, log.rudder_unit(), width).unwrap_or_default();
    if let Some(law) = found.law_text() {
        text += &labelled("Law    ", &law, width);
    }
    text += &cause_text(verdict, "--verbose", width);
    for part in &found.logs.parts {
        let begins_s = three_figures(part.window.from_s);
        text += &labelled("Log    ", &format!("{begins_s} s on: {}", part.source.path), width);
    }
    let mut reasons = verdict.reasons.iter();
    if let Some(sign) =
        reasons.find(|reason| reason.kind() == ReasonCode::SignReversed.of(Subject::Rudder))
    {
        text += &labelled("Sign   ", &sign.text, width);
    }
    text + &command("Next   ", &next::after_log(found, call, schedule), width)
}

/// What decides the outcome, what to do about it, and how many more there are.
/// `more` says what shows these.
pub fn cause_text(verdict: &Verdict, more: &str, width: usize) -> String {
    let Some(cause) = verdict.cause() else {
        return String::new();
    };
    let mut text = labelled("Cause  ", &sentence(&cause.text), width);
    if !cause.action.is_empty() {
        text += &labelled("Do     ", &cause.action, width);
    }
    if let Some(remarks) = verdict.more_remarks() {
        text += &labelled("Also   ", &format!("{remarks}, shown by {more}"), width);
    }
    text
}

fn verbose_text(found: &IdentifiedLog) -> String {
    let log = &found.logs.log;
    let source = || source_text("Log", log);
    match (&found.models, found.identification()) {
        (Some(models), _) => speeds::text(models, log.rudder_unit()) + &source(),
        (None, Some(identification)) => page(&found.logs, identification),
        (None, None) => verdict_text(found.verdict()) + &source(),
    }
}

impl EstimatorArgs {
    /// Identifies a log with these options.
    pub fn identify(
        &self,
        axis: Axis,
        (log, more_logs): (&LogArgs, &[PathBuf]),
        windows: &WindowArgs,
        trace: bool,
        is_verbose: bool,
    ) -> Result<IdentifiedLog, Failure> {
        let mut options = Options::default();
        options.axis = axis;
        options.reading = log.channels.read_settings()?;
        options.windows = windows.windows();
        options.more_logs = more_logs.to_vec();
        options.settings = self.settings(trace);
        let mut reporter = Reporter::windows(is_verbose);
        Ok(identify_log_observed(&log.log, &options, &mut reporter)?)
    }

    /// The settings that these options stand for.
    fn settings(&self, trace: bool) -> IdentifySettings {
        let mut settings =
            if self.as_paper { IdentifySettings::paper() } else { IdentifySettings::default() };
        settings.method = self.online.unwrap_or(settings.method);
        settings.lambda_rad_s = match self.lambda {
            Lambda::Auto => None,
            Lambda::RadS(value) => Some(value),
        };
        settings.trace = trace;
        settings
    }
}

/// The page for people: the verdict first.
fn page(logs: &Logs, identification: &Identification) -> String {
    let mut text = verdict_text(&identification.verdict);
    text += &model_text(identification, logs.log.rudder_unit());
    text += &validation_text(identification);
    text += "\n";
    text += &source_text("Log", &logs.log);
    if let Some(other) = &logs.validation_log {
        text += &source_text("Validated on", other);
    }
    text += &training_text(identification);
    text
}
