//! `seatrial study faults`: every fault in every stage of a trial.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use seatrial_app::studies::fault_matrix::{Cell, FaultMatrix, FaultStudy};
use seatrial_app::studies::subject::Subject;
use seatrial_sim::faults::{Kind, Moment};

use crate::output::{Exit, Failure, Output, OutputPath};
use crate::progress::RunsOf;
use crate::table::number;

/// Every fault in every stage: does each trial end in a correct model, or stopped or rejected for the right reason?
#[derive(clap::Args, Debug)]
#[command(after_help = "\
Each trial has two speeds and one fault, of a size, length and instant that the seed chooses. It must end in a \
model within 3 of its 95 % intervals of the truth, or be aborted or rejected for a reason that belongs to the fault; \
after an abort the rudder must be neutral and the heading held within 0.5 s. Exit code 4 where a trial does not.

Example:
  seatrial study faults --seeds 2 --kind compass_freeze")]
pub struct Args {
    /// The vehicle: sim:starfish, sim:starfish-6dof, sim:remus100 or sim:FILE.toml.
    #[arg(long, default_value = "sim:starfish")]
    vehicle: String,
    /// Trials of each fault in each stage.
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    seeds: u64,
    /// Kinds of faults; repeatable [default: all that the vehicle can play].
    #[arg(long, value_parser = kind)]
    kind: Vec<Kind>,
    /// Stages: settle, training, decay, validation, between; repeatable [default: all].
    #[arg(long, value_parser = moment)]
    stage: Vec<Moment>,
    /// Write the table as Markdown too.
    #[arg(long, value_name = "FILE")]
    markdown: Option<OutputPath>,
    #[command(flatten)]
    runs_of: RunsOf,
}

fn kind(name: &str) -> Result<Kind, String> {
    let names = Kind::ALL.map(Kind::name);
    Kind::of_name(name).ok_or_else(|| format!("expected one of {}", names.join(", ")))
}

fn moment(name: &str) -> Result<Moment, String> {
    let names = Moment::ALL.map(Moment::name);
    Moment::ALL
        .into_iter()
        .find(|moment| moment.name() == name)
        .ok_or_else(|| format!("expected one of {}", names.join(", ")))
}

/// Plays the matrix.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    let study = FaultStudy {
        subject: Subject::new(&args.vehicle, args.seeds, args.runs_of.seed)?,
        kinds: args.kind.clone(),
        stages: args.stage.clone(),
    };
    let document = args
        .runs_of
        .all(study.trials()?, |workers| study.run(workers))?;
    if let Some(path) = &args.markdown {
        output.save(path, markdown(&document))?;
    }
    output.print(&document, || text(&document))?;
    Ok(Exit::done_if(document.failed == 0))
}

/// Models, rejected and aborted trials.
fn counts(cell: &Cell) -> String {
    let counts = format!("{}/{}/{}", cell.models, cell.rejected, cell.aborted);
    match cell.failed.len() {
        0 => counts,
        failed => format!("{counts} ({failed} WRONG)"),
    }
}

fn summary(document: &FaultMatrix) -> String {
    let largest =
        |of: fn(&Cell) -> Option<f64>| document.cells.iter().filter_map(of).fold(0.0, f64::max);
    format!(
        "{} trials of {}, {} each, seeds from {}: {} did not end as they must. The farthest accepted model is {:.2} half widths of its \
         95 % interval from the truth; the longest from the condition of an abort to neutral rudder and heading hold {:.2} s.\n",
        document.trials,
        document.vehicle,
        document.seeds,
        document.seed,
        document.failed,
        largest(|cell| cell.farthest),
        largest(|cell| cell.handed_back_after_s),
    )
}

/// One row a fault, its stages beside each other.
fn rows(document: &FaultMatrix) -> Vec<Vec<String>> {
    document
        .cells
        .chunks(document.stages.len())
        .map(|cells| {
            let mut reasons = BTreeMap::new();
            for (reason, count) in cells.iter().flat_map(|cell| &cell.reasons) {
                *reasons.entry(reason.as_str()).or_insert(0) += count;
            }
            let reasons: Vec<String> = reasons
                .iter()
                .map(|(reason, count)| format!("{reason} {count}"))
                .collect();
            let largest = |of: fn(&Cell) -> Option<f64>, digits: usize| {
                let largest = cells.iter().filter_map(of).max_by(f64::total_cmp);
                number(largest, digits)
            };
            let name = cells.first().map_or("", |cell| cell.kind.name());
            std::iter::once(name.to_owned())
                .chain(cells.iter().map(counts))
                .chain([
                    largest(|cell| cell.farthest, 1),
                    largest(|cell| cell.handed_back_after_s, 2),
                    reasons.join(", "),
                ])
                .collect()
        })
        .collect()
}

fn headings(stages: &[Moment]) -> Vec<&'static str> {
    let names = stages.iter().map(|stage| stage.name());
    std::iter::once("fault")
        .chain(names)
        .chain(["farthest", "back, s", "reasons"])
        .collect()
}

fn text(document: &FaultMatrix) -> String {
    let mut text = summary(document);
    text += "Trials with models at every speed / rejected / aborted, the farthest accepted model, the longest to hand back, and why:\n\n";
    let widths = [18]
        .into_iter()
        .chain(vec![10; document.stages.len()])
        .chain([8, 7, 0]);
    let widths: Vec<usize> = widths.collect();
    let headings: Vec<String> = headings(&document.stages)
        .into_iter()
        .map(String::from)
        .collect();
    for row in std::iter::once(headings).chain(rows(document)) {
        for (cell, width) in row.iter().zip(&widths) {
            let _ = write!(text, "{cell:width$}  ");
        }
        text.truncate(text.trim_end().len());
        text.push('\n');
    }
    for (cell, ending) in document
        .cells
        .iter()
        .flat_map(|cell| cell.failed.iter().map(move |ending| (cell, ending)))
    {
        let _ = writeln!(
            text,
            "WRONG: {} in {}, seed {}: {}",
            cell.kind.name(),
            cell.stage.name(),
            ending.seed,
            ending.faults.join("; ")
        );
    }
    text
}

fn markdown(document: &FaultMatrix) -> String {
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    let headings: Vec<String> = headings(&document.stages)
        .into_iter()
        .map(String::from)
        .collect();
    let mark = "<!-- Fault matrix by seatrial -->\n";
    let mut text = mark.to_owned() + &summary(document) + "\n" + &line(&headings);
    text += &line(&vec!["---".into(); headings.len()]);
    for row in rows(document) {
        text += &line(&row);
    }
    text
}
