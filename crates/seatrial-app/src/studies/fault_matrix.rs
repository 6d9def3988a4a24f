//! Every fault in every stage of a trial: does each trial end in a correct model, or stopped or rejected for the right reason?

use std::collections::BTreeMap;

use seatrial_core::{List, Plan};
use seatrial_sim::faults::{Kind, Moment, Rehearsable};
use serde::Serialize;

use super::fault_run::{Ending, Rehearsal, Result as Became};
use super::subject::Subject;
use crate::Error;
use crate::workers::Workers;

/// Which faults are played in which stages.
#[derive(Clone, Debug)]
pub struct FaultStudy {
    /// The vehicle and its trials of each fault in each stage.
    pub subject: Subject,
    /// Kinds of faults; empty: all that the vehicle can play.
    pub kinds: Vec<Kind>,
    /// Stages; empty: all.
    pub stages: Vec<Moment>,
}

/// `study faults --json`.
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

impl FaultStudy {
    /// Plays the matrix.
    pub fn run(self, workers: &Workers) -> Result<FaultMatrix, Error> {
        let playable = self.playable()?;
        let Subject {
            vehicle,
            config,
            runs: seeds,
            seed,
        } = self.subject.clone();
        if let Some(kind) = self.kinds.iter().find(|kind| !playable.contains(kind)) {
            let kind = kind.name();
            return Err(Error::Setting(format!(
                "--kind {kind}: {vehicle} cannot play it"
            )));
        }
        let places = self.places(&playable);
        let plan = Plan {
            thrusts: List::from_slice(&[0.6, 0.8]).unwrap_or_default(),
            ..Plan::paper()
        };
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
            stages: match self.stages.is_empty() {
                true => Moment::ALL.to_vec(),
                false => self.stages,
            },
        })
    }

    /// How many trials there will be.
    pub fn trials(&self) -> Result<u64, Error> {
        Ok(self.subject.runs * self.places(&self.playable()?).len() as u64)
    }

    /// Faults that the vehicle can play.
    fn playable(&self) -> Result<Vec<Kind>, Error> {
        let vehicle = self.subject.config.vehicle(self.subject.seed);
        let vehicle = vehicle.map_err(|error| self.subject.input(error))?;
        Ok(vehicle.playable())
    }

    /// Each fault with each stage.
    fn places(&self, playable: &[Kind]) -> Vec<(Kind, Moment)> {
        let kinds = match self.kinds.is_empty() {
            true => playable,
            false => &self.kinds,
        };
        let stages = match self.stages.is_empty() {
            true => &Moment::ALL[..],
            false => &self.stages,
        };
        let with_stages = |kind: &Kind| stages.iter().map(|stage| (*kind, *stage)).collect();
        kinds
            .iter()
            .flat_map(|kind| -> Vec<_> { with_stages(kind) })
            .collect()
    }
}

impl Cell {
    fn of(kind: Kind, stage: Moment, endings: &[Ending]) -> Self {
        let count = |became| endings.iter().filter(|e| e.result == became).count();
        let largest =
            |of: fn(&Ending) -> Option<f64>| endings.iter().filter_map(of).max_by(f64::total_cmp);
        let mut reasons = BTreeMap::new();
        for reason in endings.iter().filter_map(|e| e.reason.as_ref()) {
            *reasons.entry(reason.to_string()).or_insert(0) += 1;
        }
        Self {
            kind,
            stage,
            models: count(Became::Models),
            rejected: count(Became::Rejected),
            aborted: count(Became::Aborted),
            reasons,
            farthest: largest(|e| e.farthest),
            handed_back_after_s: largest(|e| e.handed_back_after_s),
            without_fault: endings.iter().filter(|e| e.began_s.is_none()).count(),
            failed: endings
                .iter()
                .filter(|e| !e.faults.is_empty())
                .cloned()
                .collect(),
        }
    }
}
