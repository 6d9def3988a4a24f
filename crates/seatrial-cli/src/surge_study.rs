//! `seatrial study surge`: do the intervals of a trial's surge hold the truth?

use seatrial_app::studies::subject::Subject;
use seatrial_app::studies::surge::{SurgeCoverage, SurgeStudy};

use crate::output::{Exit, Failure, Output};
use crate::progress::RunsOf;
use crate::table::{Table, number};

/// Trials of a simulated vehicle, the surge of each, and how often its intervals hold what a trial without noise finds.
#[derive(clap::Args, Debug)]
#[command(after_help = "Example:
  seatrial study surge --vehicle sim:remus100 --runs 4")]
pub struct Args {
    /// The vehicle: sim:starfish-6dof, sim:remus100, sim:starfish or sim:FILE.toml.
    #[arg(long, default_value = "sim:starfish-6dof")]
    vehicle: String,
    /// A thrust of the trial, as a fraction of full; repeatable [default: 0.6 to 1 by tenths].
    #[arg(long, value_name = "FRACTION")]
    thrust: Vec<f64>,
    /// Trials.
    #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u64).range(2..=1_000_000))]
    runs: u64,
    #[command(flatten)]
    runs_of: RunsOf,
}

/// Runs the study.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    let study = SurgeStudy {
        subject: Subject::new(&args.vehicle, args.runs, args.runs_of.seed)?,
        thrusts: match args.thrust.is_empty() {
            true => vec![0.6, 0.7, 0.8, 0.9, 1.0],
            false => args.thrust.clone(),
        },
    };
    let document = args.runs_of.all(args.runs, |workers| study.run(workers))?;
    output.print(&document, || text(&document))?;
    Ok(Exit::Done)
}

fn text(document: &SurgeCoverage) -> String {
    let mut table = Table::under(
        "coefficient | truth | unit | identified [of all] | bias | rms error | coverage [of 95 %]",
    );
    for found in &document.coefficients {
        table.row(vec![
            found.name.clone(),
            number(found.truth, 4),
            found.unit.into(),
            format!("{:.3}", found.identified as f64 / document.trials as f64),
            found
                .accuracy
                .bias
                .map_or("-".to_owned(), |x| format!("{x:+.4}")),
            number(found.accuracy.rms_error, 4),
            number(found.accuracy.coverage, 3),
        ]);
    }
    let time = match (document.time_constant_s, document.time_constant_errors) {
        (Some(truth_s), Some([rms, largest])) => format!(
            "Time constant: {truth_s:.2} s, estimated with an error of {:.1} % rms, at most {:.1} %.\n",
            100.0 * rms,
            100.0 * largest
        ),
        _ => "No time constant.\n".to_owned(),
    };
    format!(
        "{}: {} trials\n{table}\n{time}Speed at the greatest thrust: error at most {:.2} %.\n",
        document.vehicle,
        document.trials,
        100.0 * document.largest_top_speed_error
    )
}
