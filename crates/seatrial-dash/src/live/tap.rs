//! The trial's end of the stream.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Sender, channel};
use std::time::Duration;

use seatrial::campaign::Run;
use seatrial::identification::Refined;
use seatrial::{Campaign, Step};
use seatrial_app::conduct::Watch;
use seatrial_core::progress::Status;
use seatrial_core::{Plan, Sample, Trial, YawModel};

use crate::api::{CommissionState, Control, Outcome, RunSummary, TrialState, Verdict};
use crate::convert::{run_summary, verdict_with_promises};

/// At most so many steps wait for the publisher; later ones are not shown.
const MOST_WAITING: u64 = 16_384;
/// How long the beginning of a trial waits for being shown.
const SHOWN_WITHIN: Duration = Duration::from_secs(1);

/// What the trial reports.
pub enum Report {
    Started(Box<Start>),
    RunStarted {
        run: u32,
        thrust: f64,
        attempt: u32,
    },
    Step(Box<Moment>),
    Interval([[f64; 2]; 3]),
    RunEnded(Box<Run>),
    Ended {
        outcome: Option<Outcome>,
        verdict: Option<Verdict>,
        runs: Vec<RunSummary>,
        warnings: Vec<String>,
    },
    Control(Control),
    Commission(Box<CommissionState>),
}

pub struct Start {
    pub trial: TrialState,
    pub plan: Plan<f64>,
    /// Answered once it is shown.
    pub shown: Sender<()>,
}

/// A step as it is shown.
pub struct Moment {
    pub sample: Sample<f64>,
    pub status: Status<f64>,
    pub estimate: Option<YawModel<f64>>,
    pub converged_s: Option<f64>,
}

/// The trial's end of the stream. Reports go into a queue; steps that the publisher cannot keep up with are counted only.
#[derive(Clone, Debug)]
pub struct Tap {
    pub(super) publisher: Sender<Report>,
    pub(super) counts: Arc<Counts>,
}

/// Steps on their way.
#[derive(Debug, Default)]
pub struct Counts {
    /// In the queue.
    pub waiting: AtomicU64,
    /// Left out: too many waited.
    pub not_shown: AtomicU64,
}

impl Tap {
    /// A trial begins. Returns when the picture shows it, or after a second.
    pub fn started(&self, trial: TrialState, plan: &Plan<f64>) {
        let (shown, is_shown) = channel();
        self.send(Report::Started(Box::new(Start { trial, plan: *plan, shown })));
        let _ = is_shown.recv_timeout(SHOWN_WITHIN);
    }

    /// The trial is over and the vehicle handed back.
    pub fn ended(&self, campaign: &Campaign, warnings: Vec<String>) {
        // A fault of the program leaves no runs; the logbook has those that were kept.
        let whole = (!campaign.runs.is_empty()).then(|| campaign.verdict());
        let runs = campaign.runs.iter();
        self.send(Report::Ended {
            outcome: campaign.outcome.map(Outcome::from),
            verdict: whole.as_ref().map(|whole| verdict_with_promises(campaign, whole)),
            runs: runs.map(|run| run_summary(run, whole.as_ref(), None)).collect(),
            warnings,
        });
    }

    pub(crate) fn control(&self, control: Control) {
        self.send(Report::Control(control));
    }

    pub(crate) fn commission(&self, commission: CommissionState) {
        self.send(Report::Commission(Box::new(commission)));
    }

    fn send(&self, report: Report) {
        // Without a publisher there are no viewers.
        let _ = self.publisher.send(report);
    }
}

impl Watch for Tap {
    fn run_started(&mut self, run: u32, thrust: f64, attempt: u32) {
        self.send(Report::RunStarted { run, thrust, attempt });
    }

    fn step(&mut self, step: &Step, trial: &Trial<f64>) {
        if self.counts.waiting.load(Ordering::Relaxed) >= MOST_WAITING {
            self.counts.not_shown.fetch_add(1, Ordering::Relaxed);
            return;
        }
        self.counts.waiting.fetch_add(1, Ordering::Relaxed);
        self.send(Report::Step(Box::new(Moment {
            sample: step.sample,
            status: trial.status(),
            estimate: step.estimate,
            converged_s: trial.estimator().converged_s(),
        })));
    }

    fn wants_intervals(&self) -> bool {
        true
    }

    fn interval(&mut self, refined: &Refined) {
        let interval = refined.interval_95;
        self.send(Report::Interval([
            interval.a22_per_s,
            interval.b2_per_s2,
            interval.c0_rad_per_s2,
        ]));
    }

    fn run_ended(&mut self, run: &mut Run) {
        self.send(Report::RunEnded(Box::new(run.clone())));
    }
}
