//! What is shown of a commission.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::api::{CommissionSample, CommissionShown, CommissionState};
use crate::live::Tap;

/// Samples that are kept: 30 minutes at 10 a second.
const MOST_SAMPLES: usize = 18_000;
/// Samples in one answer.
const AT_A_TIME: usize = 5000;

/// The commission that runs, or the last one.
#[derive(Clone, Debug, Default)]
pub struct Board(Arc<Mutex<BoardState>>);

#[derive(Debug, Default)]
struct BoardState {
    state: Option<CommissionState>,
    samples: Vec<CommissionSample>,
}

impl Board {
    fn shown(&self) -> MutexGuard<'_, BoardState> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The commission with its samples from this number on.
    pub fn since(&self, after: u64) -> CommissionShown {
        let shown = self.shown();
        let from = usize::try_from(after).unwrap_or(usize::MAX);
        let from = from.min(shown.samples.len());
        let to = shown.samples.len().min(from + AT_A_TIME);
        CommissionShown {
            commission: shown.state.clone(),
            samples: shown.samples[from..to].to_vec(),
            next: to as u64,
        }
    }

    /// A commission begins.
    pub fn begin(&self, state: CommissionState) {
        *self.shown() = BoardState { state: Some(state), samples: Vec::new() };
    }

    /// A sample of its steps.
    pub fn sample(&self, sample: CommissionSample) {
        let mut shown = self.shown();
        if shown.samples.len() < MOST_SAMPLES {
            shown.samples.push(sample);
        }
    }

    /// Changes what is known of the commission, and tells the viewers.
    pub fn change(&self, tap: &Tap, change: impl FnOnce(&mut CommissionState)) {
        let mut shown = self.shown();
        let Some(state) = &mut shown.state else {
            return;
        };
        change(state);
        tap.commission(state.clone());
    }
}
