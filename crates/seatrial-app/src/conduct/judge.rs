//! Runs are judged beside the trial, because that takes longer than a rudder may wait.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::{self, Scope};

use seatrial_core::Plan;
use seatrial_core::progress::RunResult;

use super::open_run::OpenRun;
use seatrial::campaign::Run;

/// A thread that judges one run after the other, in their order.
pub(super) struct Judge {
    finished: Sender<Finished>,
    judged: Receiver<thread::Result<Run>>,
    waiting: usize,
}

struct Finished {
    run: OpenRun,
    time_s: f64,
    result: RunResult<f64>,
}

impl Judge {
    /// Its thread ends with it.
    pub(super) fn start<'scope>(scope: &'scope Scope<'scope, '_>, plan: Plan<f64>) -> Self {
        let (finished, to_judge) = channel::<Finished>();
        let (tell, judged) = channel();
        scope.spawn(move || {
            for Finished {
                run,
                time_s,
                result,
            } in to_judge
            {
                let judge = AssertUnwindSafe(|| run.judged(time_s, &result, &plan));
                if tell.send(catch_unwind(judge)).is_err() {
                    break;
                }
            }
        });
        Self {
            finished,
            judged,
            waiting: 0,
        }
    }

    /// Takes a run that was validated at this time.
    pub(super) fn take(&mut self, run: OpenRun, time_s: f64, result: RunResult<f64>) {
        let finished = Finished {
            run,
            time_s,
            result,
        };
        if self.finished.send(finished).is_ok() {
            self.waiting += 1;
        }
    }

    /// The next run that has been judged, if there is one yet.
    pub(super) fn verdict(&mut self) -> Option<Run> {
        let run = self.judged.try_recv().ok()?;
        Some(self.taken(run))
    }

    /// The next run, waited for. `None`: every run has been judged.
    pub(super) fn awaited(&mut self) -> Option<Run> {
        if self.waiting == 0 {
            return None;
        }
        let run = self.judged.recv().ok()?;
        Some(self.taken(run))
    }

    /// A panic goes on where the vehicle is handed back for it.
    fn taken(&mut self, run: thread::Result<Run>) -> Run {
        self.waiting -= 1;
        run.unwrap_or_else(|panic| resume_unwind(panic))
    }
}
