//! `seatrial validate`: a given model against a log.

use std::path::PathBuf;

use seatrial::Window;
use seatrial_app::models::of_document;
use seatrial_app::validate_log::{ModelInput, validate_log};

use crate::identify::cause_text;
use crate::log::{LogArgs, Reporter};
use crate::model_source::{NumbersArgs, warn};
use crate::model_text::r2_sentence;
use crate::output::{Exit, Failure, Output, say};
use crate::screen::{labelled, width};

/// Simulate a stored or given model over a log and compare.
#[derive(clap::Args, Debug)]
#[command(after_help = "\
Exit code 0: R^2 of heading on these data is at least 0.60, or 0.60 of heading with the offset estimated again and \
of yaw rate, and the data by themselves give no other a22 or b2 (by a fifth and with 99 % certainty); 4: otherwise.

Example:
  seatrial sim log --seed 1 --thrust 0.8 --out run.csv && \\
      seatrial validate run.csv --a22 -1.07 --b2 1.08 --c0 0.012")]
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
    #[arg(long, value_name = "FILE", required_unless_present = "a22", conflicts_with = "a22")]
    model: Option<PathBuf>,
    #[command(flatten)]
    numbers: NumbersArgs,
}

/// Validates a model on a log.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    let window = Window {
        from_s: args.from.unwrap_or(f64::NEG_INFINITY),
        to_s: args.to.unwrap_or(f64::INFINITY),
    };
    // What is wrong with the model is said before a long log is read.
    let given = args.read_models()?;
    let reading = args.log.channels.read_settings()?;
    let mut reporter = Reporter::default();
    let document = validate_log(&args.log.log, &given, window, &reading, &mut reporter)?;
    if let Some(taken) = &document.taken {
        say(format_args!("the model of {taken} is taken: its speed is nearest to the log's"));
    }
    output.print(&document, || {
        let width = width();
        let outcome = document.verdict.outcome().name().to_uppercase();
        labelled("", &outcome, width)
            + &cause_text(&document.verdict, "--json", width)
            + &labelled("R^2    ", &r2_sentence(&document.validation), width)
    })?;
    Ok(Exit::of(&document.verdict))
}

impl Args {
    /// The models of the file, or the one given in numbers.
    fn read_models(&self) -> Result<ModelInput, Failure> {
        if let Some(path) = &self.model {
            let source = of_document(path, None)?;
            warn(&source);
            return Ok(ModelInput::Models(Box::new(source)));
        }
        let given = self.numbers.model();
        let finite = given.filter(|model| model.theta().iter().all(|x| x.is_finite()));
        finite.map(ModelInput::Numbers).ok_or_else(|| {
            Failure::usage("no model: give --model FILE, or --a22 and --b2 as finite numbers")
        })
    }
}
