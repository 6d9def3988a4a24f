//! `seatrial validate`: a given model against a log.

use std::path::PathBuf;

use seatrial::Window;
use seatrial::identification::{Validation, Verdict};
use seatrial::identify::{valid_range, validation, validation_estimate};
use seatrial::verdict::judge_validation;
use seatrial_app::documents::Source;
use seatrial_app::identify_log::no_model;
use seatrial_core::YawModel;
use serde::Serialize;

use crate::identify::cause_text;
use crate::log::{LogArgs, open_inside};
use crate::model_source::warn;
use crate::model_text::r2_sentence;
use crate::output::{Exit, Failure, Output, say};
use crate::screen::{labelled, width};
use seatrial_app::models::{Models, of_document};

/// Simulate a stored or given model over a log and compare.
#[derive(clap::Args, Debug)]
#[command(after_help = "\
Exit code 0: R^2 of heading on these data is at least 0.60, or 0.60 of heading with the offset estimated again and \
of yaw rate, and the data by themselves give no other a22 or b2 (by a fifth and with 99 % certainty); 4: otherwise.

Example:
  seatrial sim log --seed 1 --out run.csv && seatrial validate run.csv \\
      --a22 -1.07 --b2 1.08 --c0 0.012")]
pub struct Args {
    #[command(flatten)]
    log: LogArgs,
    /// Start of the window, s [default: the log's start].
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    from: Option<f64>,
    /// End of the window, s [default: the log's end].
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    to: Option<f64>,
    /// Document of `seatrial identify --json`.
    #[arg(
        long,
        value_name = "FILE",
        required_unless_present = "a22",
        conflicts_with = "a22"
    )]
    model: Option<PathBuf>,
    /// a22 of the model, 1/s, negative for a course-stable vehicle.
    #[arg(
        long,
        value_name = "PER_S",
        requires = "b2",
        allow_negative_numbers = true
    )]
    a22: Option<f64>,
    /// b2 of the model, 1/s^2.
    #[arg(
        long,
        value_name = "PER_S2",
        requires = "a22",
        allow_negative_numbers = true
    )]
    b2: Option<f64>,
    /// C0 of the model, rad/s^2; 0 without.
    #[arg(
        long,
        value_name = "RAD_PER_S2",
        requires = "a22",
        allow_negative_numbers = true
    )]
    c0: Option<f64>,
}

/// `validate --json`.
#[derive(Serialize)]
struct Document {
    schema: &'static str,
    source: Source,
    model: YawModel<f64>,
    validation: Validation,
    verdict: Verdict,
}

/// What is validated.
enum Given {
    Numbers(YawModel<f64>),
    Models(Box<Models>),
}

/// Validates a model on a log.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    let window = Window {
        from_s: args.from.unwrap_or(f64::NEG_INFINITY),
        to_s: args.to.unwrap_or(f64::INFINITY),
    };
    // What is wrong with the model is said before a long log is read.
    let given = args.read_models()?;
    let log = open_inside(&args.log, window)?;
    let (model, seen) = match given {
        Given::Numbers(model) => (model, None),
        Given::Models(models) => {
            let point = models.of_record(&log.record.usable(window))?;
            if models.points.len() > 1 {
                say(format_args!(
                    "the model of {} is taken: its speed is nearest to the log's",
                    point.name()
                ));
            }
            (point.point.model, point.valid_range)
        }
    };
    let validation =
        validation::validate(model, &log.record, window).map_err(|error| no_model(&log, error))?;
    let samples = log.record.usable(window);
    let own = validation_estimate(&samples);
    let beyond = seen.and_then(|seen| {
        let noise_rad = own.as_ref().map_or(0.0, |own| own.heading_noise_rad);
        let here = valid_range(&[&samples], &model, noise_rad)?;
        Some(seen.left_by(&here, log.record.rudder_unit))
    });
    let document = Document {
        schema: "seatrial.validation.v1",
        source: log.source(),
        model,
        validation,
        verdict: judge_validation(&model, validation, own.as_ref(), beyond.unwrap_or_default()),
    };
    output.print(&document, || {
        let width = width();
        let outcome = document.verdict.outcome().name().to_uppercase();
        labelled("", &outcome, width)
            + &cause_text(&document.verdict, "--json", width)
            + &labelled("R^2    ", &r2_sentence(&validation), width)
    })?;
    Ok(Exit::of(&document.verdict))
}

impl Args {
    /// The models of the file, or the one given in numbers.
    fn read_models(&self) -> Result<Given, Failure> {
        if let Some(path) = &self.model {
            let source = of_document(path, None)?;
            warn(&source);
            return Ok(Given::Models(Box::new(source)));
        }
        match (self.a22, self.b2) {
            (Some(a22), Some(b2)) if a22.is_finite() && b2.is_finite() => {
                let model = YawModel::from_theta([a22, b2, self.c0.unwrap_or(0.0)]);
                Ok(Given::Numbers(model))
            }
            _ => Err(Failure::usage(
                "no model: give --model FILE, or --a22 and --b2 as finite numbers",
            )),
        }
    }
}
