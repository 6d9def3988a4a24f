//! Runs are judged beside the trial, because that takes longer than a rudder may wait.

use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::{self, Scope};

use seatrial_core::progress::RunResult;

use super::Judging;
use super::open_run::OpenRun;
use seatrial::campaign::Run;

use crate::TrialPlan;

/// Judges one run after the other, in their order.
pub(super) enum Judge {
    /// On a thread of its own.
    Beside { finished: Sender<FinishedRun>, judged: Receiver<thread::Result<Run>>, waiting: usize },
    /// At once: by the trial alone nothing has to be computed.
    AtOnce(VecDeque<Run>),
}

pub(super) struct FinishedRun {
    run: OpenRun,
    time_s: f64,
    result: RunResult<f64>,
}

impl Judge {
    /// Where it has a thread, that ends with it.
    pub(super) fn start<'scope>(
        scope: &'scope Scope<'scope, '_>,
        plan: TrialPlan,
        judging: Judging,
    ) -> Self {
        if judging == Judging::ByTrial {
            return Self::AtOnce(VecDeque::new());
        }
        let (finished, to_judge) = channel::<FinishedRun>();
        let (tell, judged) = channel();
        scope.spawn(move || {
            for FinishedRun { run, time_s, result } in to_judge {
                let judge = AssertUnwindSafe(|| run.judged(time_s, &result, &plan));
                if tell.send(catch_unwind(judge)).is_err() {
                    break;
                }
            }
        });
        Self::Beside { finished, judged, waiting: 0 }
    }

    /// Takes a run that was validated at this time.
    pub(super) fn take(&mut self, run: OpenRun, time_s: f64, result: RunResult<f64>) {
        match self {
            Self::AtOnce(judged) => judged.push_back(run.judged_by_trial(time_s, &result)),
            Self::Beside { finished, waiting, .. } => {
                let run = FinishedRun { run, time_s, result };
                *waiting += usize::from(finished.send(run).is_ok());
            }
        }
    }

    /// The next run that has been judged, if there is one yet.
    pub(super) fn verdict(&mut self) -> Option<Run> {
        match self {
            Self::AtOnce(judged) => judged.pop_front(),
            Self::Beside { judged, waiting, .. } => {
                judged.try_recv().ok().map(|run| taken(run, waiting))
            }
        }
    }

    /// The next run, waited for. `None`: every run has been judged.
    pub(super) fn awaited(&mut self) -> Option<Run> {
        match self {
            Self::AtOnce(judged) => judged.pop_front(),
            Self::Beside { waiting: 0, .. } => None,
            Self::Beside { judged, waiting, .. } => Some(taken(judged.recv().ok()?, waiting)),
        }
    }
}

/// A panic goes on where the vehicle is handed back for it.
fn taken(run: thread::Result<Run>, waiting: &mut usize) -> Run {
    *waiting -= 1;
    run.unwrap_or_else(|panic| resume_unwind(panic))
}
