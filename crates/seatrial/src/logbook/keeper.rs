//! Keeps a trial in the logbook while it is conducted.

use seatrial_core::{Outcome, Trial};

use super::{Error, Recorder, Step};
use crate::campaign::Run;
use crate::conduct::Watch;

/// Writes what it watches into the logbook. What cannot be kept is noted and does not stop the trial.
#[derive(Debug)]
pub struct Keeper {
    recorder: Recorder,
    unsaved: Vec<String>,
    /// Number of the run kept last.
    kept: Option<u32>,
}

impl Keeper {
    /// Keeps with this recorder.
    pub fn new(recorder: Recorder) -> Self {
        Self {
            recorder,
            unsaved: Vec::new(),
            kept: None,
        }
    }

    /// Takes record and trace out of the run that was kept last, so that memory does not grow with a trial's runs;
    /// [`Logbook::fill`](super::Logbook::fill) puts them back. A run that the logbook does not have is left whole.
    pub fn release(&self, run: &mut Run) {
        if self.kept == Some(run.number) {
            run.record.samples = Vec::new();
            if let Some(identification) = &mut run.identification {
                identification.online.trace = Vec::new();
            }
        }
    }

    /// Enters how the campaign ended; what could not be kept.
    pub fn end(self, outcome: Option<Outcome>) -> Vec<String> {
        let Self {
            recorder,
            mut unsaved,
            ..
        } = self;
        if let Some(outcome) = outcome
            && let Err(error) = recorder.finish(outcome)
        {
            unsaved.push(error.to_string());
        }
        unsaved
    }

    /// `true`: it is kept.
    fn keep(&mut self, keep: impl FnOnce(&mut Recorder) -> Result<(), Error>) -> bool {
        let kept = keep(&mut self.recorder);
        if let Err(error) = &kept {
            let unsaved = error.to_string();
            if !self.unsaved.contains(&unsaved) {
                self.unsaved.push(unsaved);
            }
        }
        kept.is_ok()
    }
}

impl Watch for Keeper {
    fn run_started(&mut self, number: u32, thrust: f64, attempt: u32) {
        self.keep(|recorder| recorder.begin_run(number, thrust, attempt));
    }

    fn step(&mut self, step: &Step, _trial: &Trial<f64>) {
        self.keep(|recorder| recorder.step(*step));
    }

    fn run_ended(&mut self, run: &mut Run) {
        if self.keep(|recorder| recorder.finish_run(run)) {
            self.kept = Some(run.number);
        }
    }
}
