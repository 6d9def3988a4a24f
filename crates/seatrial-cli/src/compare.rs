//! `seatrial compare`: every method on the identical record, or the models of several logs over the turn rate.

use std::path::{Path, PathBuf};

use seatrial::study::{Comparison, MethodResult};
use seatrial::words::{r2_text, three_figures};
use seatrial_app::compare_log::{ComparedLog, ComparisonDocument, compare_log};
use seatrial_app::compare_turn_rates::compare_turn_rates;
use seatrial_app::identify_log::Logs;

use crate::log::{ChannelArgs, Reporter};
use crate::model_text::{source_text, span_text};
use crate::output::{Exit, Failure, Output};
use crate::screen::{command, labelled, width, wrapped};
use crate::table::Table;
use crate::turn_rates;
use crate::windows::WindowArgs;

/// Every method on the identical record, side by side; of several logs, whether damping grows with the turn rate.
#[derive(clap::Args, Debug)]
#[command(after_help = "\
Without a validation window what follows the training window validates. Without any the windows are those of \
`seatrial identify`: of the manoeuvres of its surest model the best excited one trains and another one validates. \
A log without such manoeuvres but with several strokes of the rudder is split in its middle.

Of two or more logs of one hull each is identified as by `seatrial identify`. The models of a speed, within 10 %, are \
fitted over the amplitude of the yaw rate: one damping for all, or one that grows with the turn rate, with intervals.

Two trials, runs or payloads are compared by `seatrial health`.

Example:
  seatrial sim log --seed 1 --out run.csv && seatrial compare run.csv")]
pub struct Args {
    /// The log, whatever its format, or several of one hull at different rudder angles; `-` is standard input.
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
    #[command(flatten)]
    channels: ChannelArgs,
    #[command(flatten)]
    windows: WindowArgs,
    /// Pole of the state variable filter of every method but the paper's, rad/s
    /// [default: derived from the data].
    #[arg(long, value_name = "RAD_S")]
    lambda: Option<f64>,
}

/// Compares the methods on a log, or several logs.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    match &args.logs[..] {
        [log] => methods(args, log, output),
        logs => several(args, logs, output),
    }
}

fn several(args: &Args, logs: &[PathBuf], output: &Output) -> Result<Exit, Failure> {
    if args.windows.windows().are_given() || args.lambda.is_some() {
        return Err(Failure::usage(
            "windows and --lambda are for one log: of several, each is identified as `seatrial identify` does it; leave them out",
        ));
    }
    let reading = args.channels.read_settings()?;
    let document = compare_turn_rates(logs, &reading, &mut Reporter::default())?;
    output.print(&document, || turn_rates::page(&document))?;
    Ok(Exit::done_if(document.has_compared()))
}

fn methods(args: &Args, log: &Path, output: &Output) -> Result<Exit, Failure> {
    let reading = args.channels.read_settings()?;
    let mut reporter = Reporter::default();
    let ComparedLog { logs, document } =
        compare_log(log, &args.windows.windows(), &reading, args.lambda, &mut reporter)?;
    output.print(&document, || page(&logs, &document))?;
    Ok(Exit::Done)
}

/// Columns that a narrow screen does without, first those that fewest people miss.
const DISPENSABLE: [&str; 5] = ["iterations", "time", "C0", "R^2 rate", "R^2 refitted"];

fn page(logs: &Logs, document: &ComparisonDocument) -> String {
    let comparison = &document.comparison;
    let width = width();
    let mut text = wrapped(&agreement(comparison), width) + "\n";
    let mut table = Table::under(
        "method | a22 [1/s] | b2 [1/s^2] | C0 [rad/s^2] | R^2 [heading] | R^2 [refitted] | R^2 [rate] | \
            iterations | time [ms]",
    );
    for method in &comparison.methods {
        table.row(row(method));
    }
    text += &table.fitted(width, &DISPENSABLE);
    for method in &comparison.methods {
        if let Some(failure) = &method.failure {
            text += &labelled("", &format!("{}: {failure}", method.method.words()), width);
        }
    }
    text += "\n";
    let mut sources = source_text("Log", &logs.log);
    if let Some(other) = &logs.validation_log {
        sources += &source_text("Validated on", other);
    }
    text += &wrapped(&sources, width);
    text += &labelled("Training    ", &span_text(comparison.training), width);
    let validation = comparison.methods.iter().find_map(|m| m.validation);
    let span = validation.map_or_else(String::new, |v| span_text(v.window));
    let windows = format!("{span} ({})", document.windows_because);
    text += &labelled("Validation  ", &windows, width);
    let filter = format!(
        "lambda {} rad/s: {}; the paper's is 1",
        three_figures(comparison.lambda_rad_s),
        comparison.lambda_because
    );
    text += &labelled("Filter      ", &filter, width);
    let next = format!("seatrial identify {}", logs.log.path.display());
    text + &command("Next        ", &next, width)
}

/// Do the methods agree, and if not which one is alone?
fn agreement(comparison: &Comparison) -> String {
    let found: Vec<(String, [f64; 2])> = comparison
        .methods
        .iter()
        .filter_map(|method| {
            let [a22, b2, _] = method.model?.theta();
            Some((method.method.words(), [a22, b2]))
        })
        .collect();
    let middle = |of: usize| {
        let mut values: Vec<f64> = found.iter().map(|(_, values)| values[of]).collect();
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied()
    };
    let Some((a22, b2)) = middle(0).zip(middle(1)) else {
        return "NO METHOD FOUND A MODEL".into();
    };
    let is_apart = |values: &[f64; 2]| {
        let off = |value: f64, middle: f64| (value / middle - 1.0).abs() > SAME;
        off(values[0], a22) || off(values[1], b2)
    };
    let apart: Vec<&str> = found
        .iter()
        .filter(|(_, values)| is_apart(values))
        .map(|(name, _)| name.as_str())
        .collect();
    let middles = format!("a22 {} 1/s and b2 {} 1/s^2", three_figures(a22), three_figures(b2));
    match apart.is_empty() {
        true => format!("THE METHODS AGREE\nAll {} find {middles}, within 10 %.", found.len()),
        false => format!(
            "THE METHODS DIFFER\n{} of {} find {middles}, within 10 %. Not so: {}.",
            found.len() - apart.len(),
            found.len(),
            apart.join(", ")
        ),
    }
}

/// Models that differ by less than this share are called the same.
const SAME: f64 = 0.1;

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
