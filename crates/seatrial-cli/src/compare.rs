//! `seatrial compare`: every method on the identical record.

use std::fmt::Write;
use std::time::Instant;

use seatrial::compare::{Comparison, MethodResult, compare, split};
use seatrial::figures::{r2_text, three_figures};
use seatrial::identify::{IdentifySettings, ValidationData};
use seatrial::{Record, Window};
use seatrial_app::documents::Source;
use seatrial_app::identify_log::{Logs, SpeedModel, foremost, identify_speeds, no_model};
use serde::Serialize;

use crate::log::{LogArgs, Reporter};
use crate::model_text::{source_text, span_text};
use crate::output::{Exit, Failure, Output};
use crate::screen::{width, wrapped};
use crate::table::Table;
use crate::windows::WindowArgs;

/// Every method on the identical record, side by side, with time and disagreement.
#[derive(clap::Args, Debug)]
#[command(after_help = "\
Without a validation window what follows the training window validates. Without any the windows are those of
`seatrial identify`: of the manoeuvres of its surest model the best excited one trains and another one validates.
A log without such manoeuvres but with several strokes of the rudder is split in its middle.

Example:
  seatrial sim log --seed 1 --out run.csv && seatrial compare run.csv")]
pub struct Args {
    #[command(flatten)]
    log: LogArgs,
    #[command(flatten)]
    windows: WindowArgs,
    /// Pole of the state variable filter of every method but the paper's, rad/s
    /// [default: derived from the data].
    #[arg(long, value_name = "RAD_S")]
    lambda: Option<f64>,
}

/// `compare --json`.
#[derive(Serialize)]
struct Document {
    schema: &'static str,
    source: Source,
    validation_source: Option<Source>,
    /// Which data validate, and why these.
    windows_because: String,
    #[serde(flatten)]
    comparison: Comparison,
}

/// Compares the methods on a log.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    let windows = args.windows.windows().validated_on_the_rest();
    let settings = args.log.channels.read_settings()?;
    let logs = windows.open(&args.log.log, &settings, &mut Reporter::default())?;
    let chosen = Chosen::of(args, &logs)?;
    let begun = Instant::now();
    let clock_ms = || begun.elapsed().as_secs_f64() * 1e3;
    let record = &logs.log.record;
    let comparison = compare(
        record,
        chosen.training,
        chosen.validation,
        args.lambda,
        &clock_ms,
    )
    .map_err(|error| no_model(&logs.log, error))?;
    let document = Document {
        schema: "seatrial.comparison.v1",
        source: logs.log.source(),
        validation_source: logs.validation_log.as_ref().map(|log| log.source()),
        windows_because: chosen.because,
        comparison,
    };
    output.print(&document, || page(&logs, &document))?;
    Ok(Exit::Done)
}

struct Chosen<'a> {
    training: Window,
    validation: ValidationData<'a>,
    because: String,
}

impl<'a> Chosen<'a> {
    fn of(args: &Args, logs: &'a Logs) -> Result<Self, Failure> {
        let record: &Record = &logs.log.record;
        let training = logs.training;
        let on_this_log = |training, window, because: &str| Self {
            training,
            validation: ValidationData { record, window },
            because: because.into(),
        };
        if let Some(validation) = logs.validation_data() {
            return Ok(Self {
                training,
                validation,
                because: "as given; without, what follows the training window".into(),
            });
        }
        if !args.windows.windows().are_given()
            && let settings = IdentifySettings::default()
            && let Some(models) = identify_speeds(&logs.log, &settings, &mut Reporter::default())?
            && let Some(SpeedModel { windows, .. }) = foremost(&models)
            && let (Some(training), Some(validation)) =
                (windows.training.first(), windows.validation)
        {
            return Ok(on_this_log(*training, validation, &windows.because));
        }
        Ok(match split(record).filter(|_| training == Window::ALL) {
            Some((training, validation)) => on_this_log(
                training,
                validation,
                "the log was split in the middle of its strokes",
            ),
            None => on_this_log(
                training,
                training,
                "NOT HELD OUT: nothing is left of the log, so the models are judged by the data that they were made from",
            ),
        })
    }
}

fn page(logs: &Logs, document: &Document) -> String {
    let comparison = &document.comparison;
    let mut table = Table::new(&[
        ("method", ""),
        ("a22", "1/s"),
        ("b2", "1/s^2"),
        ("C0", "rad/s^2"),
        ("R^2", "heading"),
        ("R^2", "refitted"),
        ("R^2", "rate"),
        ("iterations", ""),
        ("time", "ms"),
    ]);
    for method in &comparison.methods {
        table.row(row(method));
    }
    let mut text = source_text("Log", &logs.log);
    if let Some(other) = &logs.validation_log {
        text += &source_text("Validated on", other);
    }
    let validation = comparison.methods.iter().find_map(|m| m.validation);
    let _ = writeln!(text, "Training    {}", span_text(comparison.training));
    let _ = writeln!(
        text,
        "Validation  {} ({})",
        validation.map_or_else(String::new, |v| span_text(v.window)),
        document.windows_because
    );
    let _ = writeln!(
        text,
        "Filter      lambda {} rad/s: {}; the paper's is 1\n",
        three_figures(comparison.lambda_rad_s),
        comparison.lambda_because
    );
    let _ = writeln!(text, "{}", table.fitted(width(), &["iterations", "time"]));
    for method in &comparison.methods {
        if let Some(failure) = &method.failure {
            let _ = writeln!(text, "{}: {failure}", method.method.words());
        }
    }
    let percent = |share: Option<f64>| {
        share.map_or_else(
            || "unknown".into(),
            |share| format!("{:.0} %", 100.0 * share),
        )
    };
    let _ = writeln!(
        text,
        "The methods differ by {} of a22 and {} of b2.",
        percent(comparison.disagreement.a22),
        percent(comparison.disagreement.b2)
    );
    wrapped(&text, width())
}

fn row(method: &MethodResult) -> Vec<String> {
    let or_dash = |text: Option<String>| text.unwrap_or_else(|| "-".into());
    let parameter = |index: usize| or_dash(method.model.map(|m| three_figures(m.theta()[index])));
    let validation = method.validation.as_ref();
    let r2 = |value: Option<f64>| or_dash(value.map(|r2| r2_text(Some(r2))));
    vec![
        method.method.words(),
        parameter(0),
        parameter(1),
        parameter(2),
        r2(validation.and_then(|v| v.r2_heading)),
        r2(validation.and_then(|v| v.r2_heading_offset_refit)),
        r2(validation.and_then(|v| v.r2_yaw_rate)),
        or_dash(method.iterations.map(|n| n.to_string())),
        format!("{:.2}", method.time_ms),
    ]
}
