//! `seatrial-lab faults`: every fault in every stage of a trial. Does each trial end in a correct model, or stopped or rejected for the
//! right reason?

mod rehearsal;

use std::collections::BTreeMap;
use std::fmt::Write as _;

use seatrial_app::Error;
use seatrial_app::trials::estimator_study::Subject;
use seatrial_app::workers::Workers;
use seatrial_cli::output::{Failure, Output, OutputPath};
use seatrial_cli::table::number;
use seatrial_core::{List, Plan};
use seatrial_sim::faults::{Kind, Moment, Rehearsable};
use serde::Serialize;

use crate::runner::{Found, Study, counted, listed, named};
use rehearsal::Result as Became;
pub use rehearsal::{Ending, HALF_WIDTHS, PARAMETERS, Rehearsal, Why};

/// Every fault in every stage: does each trial end in a correct model, or stopped or rejected for the right reason?
#[derive(clap::Args, Debug)]
#[command(after_help = "\
Each trial has two speeds and one fault, of a size, length and instant that the seed chooses. It must end in a \
model within 3 of its 95 % intervals of the truth, or be aborted or rejected for a reason that belongs to the fault; \
after an abort the rudder must be neutral and the heading held within 0.5 s. Exit code 4 where a trial does not.

Example:
  seatrial-lab faults --seeds 2 --kind compass_freeze")]
pub struct FaultStudy {
    /// The vehicle: sim:starfish, sim:starfish-6dof, sim:remus100 or sim:FILE.toml.
    #[arg(long, default_value = "sim:starfish")]
    vehicle: String,
    /// Trials of each fault in each stage.
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    seeds: u64,
    /// Kinds of faults; repeatable [default: all that the vehicle can play].
    #[arg(long, value_parser = named(&Kind::ALL, Kind::name))]
    kind: Vec<Kind>,
    /// Stages: settle, training, decay, validation, between; repeatable [default: all].
    #[arg(long, value_parser = named(&Moment::ALL, Moment::name))]
    stage: Vec<Moment>,
    /// Write the table as Markdown too.
    #[arg(long, value_name = "FILE")]
    markdown: Option<OutputPath>,
}

/// `faults --json`.
#[derive(Clone, Debug, Serialize)]
pub struct FaultMatrix {
    /// `seatrial.fault_matrix.v1`
    pub schema: &'static str,
    /// The vehicle by its name.
    pub vehicle: String,
    /// The first seed.
    pub seed: u64,
    /// Trials of each fault in each stage.
    pub seeds: u64,
    /// Trials of all.
    pub trials: usize,
    /// Trials that did not end as they must.
    pub failed: usize,
    /// Each fault in each stage, the stages of a fault one after the other.
    pub cells: Vec<Cell>,
    /// The stages.
    #[serde(skip)]
    pub stages: Vec<Moment>,
}

/// One fault in one stage.
#[derive(Clone, Debug, Serialize)]
pub struct Cell {
    /// The fault.
    pub kind: Kind,
    /// The stage in which it begins.
    pub stage: Moment,
    /// Trials with a model at every speed.
    pub models: usize,
    /// Trials with a speed without an accepted model.
    pub rejected: usize,
    /// Aborted trials.
    pub aborted: usize,
    /// Abort and rejection reasons, each with how often.
    pub reasons: BTreeMap<String, usize>,
    /// Largest distance of an accepted model from the truth, in half widths of its interval.
    pub farthest: Option<f64>,
    /// Longest from the condition of an abort to neutral rudder and heading hold, s.
    pub handed_back_after_s: Option<f64>,
    /// Trials in which the fault did not come about, because the trial never got there.
    pub without_fault: usize,
    /// Trials that did not end as they must.
    pub failed: Vec<Ending>,
}

impl Study for FaultStudy {
    type Found = FaultMatrix;

    fn runs(&self) -> Result<u64, Failure> {
        let playable = playable(&self.subject(0)?)?;
        Ok(self.seeds * self.places(&playable).len() as u64)
    }

    fn run(&self, seed: u64, workers: &Workers) -> Result<FaultMatrix, Failure> {
        let subject = self.subject(seed)?;
        let playable = playable(&subject)?;
        let Subject { vehicle, config, runs: seeds, seed } = subject;
        if let Some(kind) = self.kind.iter().find(|kind| !playable.contains(kind)) {
            let kind = kind.name();
            return Err(Failure::usage(format!("--kind {kind}: {vehicle} cannot play it")));
        }
        let places = self.places(&playable);
        let plan =
            Plan { thrusts: List::from_slice(&[0.6, 0.8]).unwrap_or_default(), ..Plan::paper() };
        let rehearsal = Rehearsal::new(config, plan);
        let runs = seeds * places.len() as u64;
        let endings = workers.each(runs, |run| {
            let (kind, stage) = places[(run / seeds) as usize];
            rehearsal.play(kind, stage, seed.wrapping_add(run % seeds))
        });
        let cells: Vec<Cell> = places
            .iter()
            .zip(endings.chunks(seeds as usize))
            .map(|(&(kind, stage), endings)| Cell::of(kind, stage, endings))
            .collect();
        Ok(FaultMatrix {
            schema: "seatrial.fault_matrix.v1",
            vehicle,
            seed,
            seeds,
            trials: endings.len(),
            failed: cells.iter().map(|cell| cell.failed.len()).sum(),
            cells,
            stages: self.stages().to_vec(),
        })
    }

    fn save(&self, found: &FaultMatrix, output: &Output) -> Result<(), Failure> {
        match &self.markdown {
            Some(path) => output.save(path, markdown(found)),
            None => Ok(()),
        }
    }
}

/// Faults that the vehicle can play.
fn playable(subject: &Subject) -> Result<Vec<Kind>, Error> {
    let vehicle = subject.config.vehicle(subject.seed);
    let vehicle = vehicle.map_err(|error| subject.input(error))?;
    Ok(vehicle.playable())
}

impl FaultStudy {
    fn subject(&self, seed: u64) -> Result<Subject, Failure> {
        Ok(Subject::new(&self.vehicle, self.seeds, seed)?)
    }

    fn stages(&self) -> &[Moment] {
        match self.stage.is_empty() {
            true => &Moment::ALL,
            false => &self.stage,
        }
    }

    /// Each fault with each stage.
    fn places(&self, playable: &[Kind]) -> Vec<(Kind, Moment)> {
        let kinds = match self.kind.is_empty() {
            true => playable,
            false => &self.kind,
        };
        let with_stages = |kind: &Kind| self.stages().iter().map(|stage| (*kind, *stage)).collect();
        kinds.iter().flat_map(|kind| -> Vec<_> { with_stages(kind) }).collect()
    }
}

impl Cell {
    fn of(kind: Kind, stage: Moment, endings: &[Ending]) -> Self {
        let count = |became| endings.iter().filter(|e| e.result == became).count();
        let largest =
            |of: fn(&Ending) -> Option<f64>| endings.iter().filter_map(of).max_by(f64::total_cmp);
        let reasons = endings.iter().filter_map(|e| e.reason.as_ref());
        Self {
            kind,
            stage,
            models: count(Became::Models),
            rejected: count(Became::Rejected),
            aborted: count(Became::Aborted),
            reasons: counted(reasons.map(Why::to_string)),
            farthest: largest(|e| e.farthest),
            handed_back_after_s: largest(|e| e.handed_back_after_s),
            without_fault: endings.iter().filter(|e| e.began_s.is_none()).count(),
            failed: endings.iter().filter(|e| !e.faults.is_empty()).cloned().collect(),
        }
    }
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
            let mut reasons = BTreeMap::<String, usize>::new();
            for (reason, count) in cells.iter().flat_map(|cell| &cell.reasons) {
                *reasons.entry(reason.clone()).or_default() += count;
            }
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
                    listed(&reasons),
                ])
                .collect()
        })
        .collect()
}

fn headings(stages: &[Moment]) -> Vec<String> {
    let names = stages.iter().map(|stage| stage.name());
    let all = std::iter::once("fault").chain(names);
    let all = all.chain(["farthest", "back, s", "reasons"]);
    all.map(String::from).collect()
}

impl Found for FaultMatrix {
    fn text(&self) -> String {
        let mut text = summary(self);
        text += "Trials with models at every speed / rejected / aborted, the farthest accepted model, the longest to hand back, and why:\n\n";
        let widths = [18].into_iter().chain(vec![10; self.stages.len()]).chain([8, 7, 0]);
        let widths: Vec<usize> = widths.collect();
        for row in std::iter::once(headings(&self.stages)).chain(rows(self)) {
            for (cell, width) in row.iter().zip(&widths) {
                let _ = write!(text, "{cell:width$}  ");
            }
            text.truncate(text.trim_end().len());
            text.push('\n');
        }
        for (cell, ending) in
            self.cells.iter().flat_map(|cell| cell.failed.iter().map(move |ending| (cell, ending)))
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

    fn is_good(&self) -> bool {
        self.failed == 0
    }
}

/// The matrix as a page of Markdown.
fn markdown(document: &FaultMatrix) -> String {
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    let headings = headings(&document.stages);
    let mark = "<!-- Fault matrix by seatrial -->\n";
    let mut text = mark.to_owned() + &summary(document) + "\n" + &line(&headings);
    text += &line(&vec!["---".into(); headings.len()]);
    for row in rows(document) {
        text += &line(&row);
    }
    text
}
