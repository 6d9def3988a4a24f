//! `seatrial study manoeuvres`: do the predicted intervals of manoeuvres hold the truth?

use seatrial_app::ship_trials::{ManoeuvreCoverage, ManoeuvreStudy};
use seatrial_app::studies::subject::Subject;

use crate::output::{Exit, Failure, Output};
use crate::progress::RunsOf;
use crate::table::{Table, number};

/// Trials of a simulated vehicle, the manoeuvres predicted from each, and how often their intervals hold those of the truth.
#[derive(clap::Args, Debug)]
#[command(after_help = "Example:
  seatrial study manoeuvres --runs 4")]
pub struct Args {
    /// The vehicle, of first order: sim:starfish or sim:FILE.toml.
    #[arg(long, default_value = "sim:starfish")]
    vehicle: String,
    /// Thrust as a fraction of full.
    #[arg(long, value_name = "FRACTION", default_value_t = 0.8)]
    thrust: f64,
    /// Trials.
    #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u64).range(2..=1_000_000))]
    runs: u64,
    #[command(flatten)]
    runs_of: RunsOf,
}

/// Runs the study.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    let study = ManoeuvreStudy {
        subject: Subject::new(&args.vehicle, args.runs, args.runs_of.seed)?,
        thrust: args.thrust,
    };
    let document = args.runs_of.all(args.runs, |workers| study.run(workers))?;
    output.print(&document, || text(&document))?;
    Ok(Exit::Done)
}

fn text(document: &ManoeuvreCoverage) -> String {
    let mut table =
        Table::under("manoeuvre | figure | truth | bias | rms error | unit | coverage [of 95 %]");
    for index in &document.indices {
        table.row(vec![
            index.manoeuvre.clone(),
            index.name.into(),
            format!("{:.3}", index.truth),
            index
                .accuracy
                .bias
                .map_or("-".into(), |bias| format!("{bias:+.3}")),
            number(index.accuracy.rms_error, 3),
            index.unit.into(),
            number(index.accuracy.coverage, 3),
        ]);
    }
    format!(
        "{} at {:.0} % thrust: {} models, {} trials without one\n{table}",
        document.vehicle,
        100.0 * document.thrust,
        document.models,
        document.without_model
    )
}
