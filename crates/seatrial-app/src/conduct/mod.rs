//! Conducts a trial on a vehicle and makes its campaign.
//!
//! ```
//! use seatrial::Campaign;
//! use seatrial_app::conduct::{NoWatch, conduct};
//! use seatrial_core::{List, Plan};
//! use seatrial_sim::{FirstOrderVehicle, VehicleConfig};
//!
//! // Or a value of a type of your own that implements `seatrial_core::Vehicle`.
//! let mut vehicle = FirstOrderVehicle::new(VehicleConfig::starfish(), 1)?;
//! let plan = Plan {
//!     thrusts: List::from_slice(&[0.6, 0.8]).expect("two of at most 16 speeds"),
//!     ..Plan::paper()
//! };
//! let about = Campaign::of("my boat", &plan);
//! let campaign = conduct(&mut vehicle, plan, about, &mut NoWatch)?.campaign;
//! for run in campaign.accepted_runs() {
//!     println!("{}: {:?}", run.thrust, run.identification.as_ref().map(|found| found.model()));
//! }
//! assert_eq!(campaign.accepted_runs().len(), 2);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The campaign is in memory only; `trials::order` keeps a trial in a logbook as it goes on.

mod judge;
mod open_run;

use std::time::{Duration, Instant};

use seatrial_core::InvalidSetting;
use seatrial_core::progress::Event;
use seatrial_core::{AbortReason, Sample, Trial, Vehicle};

use judge::Judge;
use open_run::OpenRun;
use seatrial::Step;
use seatrial::campaign::{Campaign, Run};
use seatrial::identification::Refined;
use seatrial::preview::Target;

use crate::{CheckedPlan, TrialPlan};

/// Observes or records a trial. Only [`Watch::wants_abort`] can end it.
pub trait Watch {
    /// A run begins.
    fn run_started(&mut self, _number: u32, _thrust: f64, _attempt: u32) {}
    /// The trial took one sample. It belongs to the run begun last, unless that has ended.
    fn step(&mut self, _step: &Step, _trial: &Trial<f64>) {}
    /// Shall intervals be looked at while a run trains? It takes some 10 ms once in a while.
    fn wants_intervals(&self) -> bool {
        false
    }
    /// The estimate and intervals of the training so far.
    fn interval(&mut self, _refined: &Refined) {}
    /// A run has ended, with or without a model: before the next one begins or, on a vehicle that is
    /// [live](Vehicle::is_live), when it has been judged, before the next one has. What is taken out of it is missing in
    /// the campaign.
    fn run_ended(&mut self, _run: &mut Run) {}
    /// Does the operator want the vehicle back?
    fn wants_abort(&mut self) -> bool {
        false
    }
}

/// Holds a simulated vehicle to a multiple of real time.
#[derive(Debug)]
pub struct Pace {
    factor: f64,
    begun: Instant,
    first_s: Option<f64>,
}

impl Pace {
    /// Seconds of the vehicle in a second of real time.
    pub fn new(factor: f64) -> Self {
        Self { factor, begun: Instant::now(), first_s: None }
    }

    /// Waits until this time of the vehicle is due.
    pub fn wait(&mut self, time_s: f64) {
        let first_s = *self.first_s.get_or_insert(time_s);
        let due = Duration::try_from_secs_f64((time_s - first_s) / self.factor);
        std::thread::sleep(due.unwrap_or_default().saturating_sub(self.begun.elapsed()));
    }
}

/// An observer that ignores everything.
#[derive(Clone, Copy, Debug)]
pub struct NoWatch;

impl Watch for NoWatch {}

/// What came of a trial.
#[derive(Debug)]
pub struct TrialResult<E> {
    /// Every run.
    pub campaign: Campaign,
    /// What the vehicle's link reported when it was lost.
    pub fault: Option<E>,
}

/// Neutral rudder, then heading hold.
const HAND_BACK_ACTIONS: usize = 2;

/// By what the runs of a trial are judged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Judging {
    /// By the refined estimate on their records, validated again: some 0.1 s a run.
    #[default]
    Whole,
    /// By the trial's own R^2 alone. Runs have no model: for studies of very many trials.
    ByTrial,
}

/// Runs a trial of `plan` on `vehicle` until it is over and handed back.
///
/// `about` says what the campaign is of; its runs and outcome are filled in. The online estimate of a run is
/// the one that the trial made live; it is refined on the record of the training stage and validated
/// again with the refined model when the run is over, on a thread of its own: a vehicle that is
/// [live](Vehicle::is_live) goes on meanwhile, any other waits. Verdicts decide nothing of the trial, so both do the same.
/// A vehicle that gives no more samples aborts the trial; everything up to then is kept.
///
/// # Errors
/// The first setting of the plan that is out of its range. Whatever happens to the vehicle is a value:
/// [`Campaign::outcome`] and [`TrialResult::fault`].
pub fn conduct<V: Vehicle<f64> + ?Sized>(
    vehicle: &mut V,
    plan: impl Into<TrialPlan>,
    about: Campaign,
    watch: &mut dyn Watch,
) -> Result<TrialResult<V::Error>, InvalidSetting> {
    let plan = plan.into().checked()?;
    Ok(conduct_judging(vehicle, &plan, about, watch, Judging::Whole))
}

/// Conducts a trial as [`conduct`] does, of a plan that was checked, with its runs judged as `judging` says.
pub fn conduct_judging<V: Vehicle<f64> + ?Sized>(
    vehicle: &mut V,
    plan: &CheckedPlan,
    about: Campaign,
    watch: &mut dyn Watch,
    judging: Judging,
) -> TrialResult<V::Error> {
    std::thread::scope(|scope| {
        let runs = Runs {
            campaign: about,
            open: None,
            judge: Judge::start(scope, **plan, judging),
            plan: **plan,
            watch,
        };
        runs.conduct(plan.trial(), vehicle)
    })
}

/// Ends a trial whose vehicle sends no more samples, unless it was aborted before. Should only the samples be lost, the vehicle
/// still gets its rudder and heading back.
fn hand_back<V: Vehicle<f64> + ?Sized>(trial: &mut Trial<f64>, vehicle: &mut V) {
    trial.abort(vehicle.ended_for().unwrap_or(AbortReason::LinkLost));
    for _ in 0..HAND_BACK_ACTIONS {
        let action = trial.step(&Sample::default());
        let _ = vehicle.act(&action);
    }
}

/// The runs of a trial: one is open, some are being judged, the others are in the campaign.
struct Runs<'a> {
    campaign: Campaign,
    open: Option<OpenRun>,
    judge: Judge,
    plan: TrialPlan,
    watch: &'a mut dyn Watch,
}

impl Runs<'_> {
    fn conduct<V: Vehicle<f64> + ?Sized>(
        mut self,
        mut trial: Trial<f64>,
        vehicle: &mut V,
    ) -> TrialResult<V::Error> {
        let mut fault = None;
        let mut is_handed_back = false;
        loop {
            if self.watch.wants_abort() || vehicle.is_taken_over() {
                trial.abort(AbortReason::Operator);
            }
            let sample = match vehicle.next_sample() {
                Ok(Some(sample)) => sample,
                Ok(None) => break,
                Err(error) => {
                    fault = Some(error);
                    break;
                }
            };
            let step = Step::take(&mut trial, sample);
            // Before anything is shown or kept: the rudder must not wait for that.
            let acted = vehicle.act(&step.action);
            while let Some(event) = trial.take_event() {
                self.heed(event, vehicle.is_live());
            }
            while let Some(run) = self.judge.verdict() {
                self.end(run);
            }
            if let Some(run) = &mut self.open {
                run.take(&step, &trial);
            }
            self.watch.step(&step, &trial);
            if let Err(error) = acted {
                fault = Some(error);
                break;
            }
            if step.action.outcome.is_some() {
                is_handed_back = true;
                break;
            }
            // After the command has gone out: a look takes longer than a step may.
            self.look(&mut trial);
        }
        if !is_handed_back {
            hand_back(&mut trial, vehicle);
        }
        self.await_verdicts();
        if let Some((run, outcome)) = self.open.take().zip(trial.outcome()) {
            let last_s = run.last_s().unwrap_or(0.0);
            self.end(run.stopped(last_s, outcome));
        }
        self.campaign.outcome = trial.outcome();
        TrialResult { campaign: self.campaign, fault }
    }

    /// Shows the intervals of the open run, and ends its training where they are narrow enough.
    fn look(&mut self, trial: &mut Trial<f64>) {
        let stop_when = self.plan.stop_when;
        if stop_when.is_none() && !self.watch.wants_intervals() {
            return;
        }
        let Some(run) = &mut self.open else {
            return;
        };
        if let Some(refined) = run.look(trial, self.plan.servo()) {
            self.watch.interval(&refined);
            let is_narrow = stop_when.is_some_and(|target| reaches(&refined, target));
            if is_narrow && run.is_excited(trial) {
                trial.finish_training();
            }
        }
    }

    fn heed(&mut self, event: Event<f64>, is_live: bool) {
        match event {
            Event::RunStarted { number, thrust, attempt } => {
                self.open = Some(OpenRun::new(number, thrust, attempt));
                self.watch.run_started(number, thrust, attempt);
            }
            Event::StageStarted { stage, time_s } => {
                if let Some(run) = &mut self.open {
                    run.enter(stage, time_s);
                }
            }
            Event::Converged { .. } => {}
            Event::RunFinished { time_s, result } => {
                if let Some(run) = self.open.take() {
                    self.judge.take(run, time_s, result);
                }
                if !is_live {
                    self.await_verdicts();
                }
            }
            Event::Ended { time_s, outcome } => {
                self.await_verdicts();
                if let Some(run) = self.open.take() {
                    self.end(run.stopped(time_s, outcome));
                }
            }
        }
    }

    fn await_verdicts(&mut self) {
        while let Some(run) = self.judge.awaited() {
            self.end(run);
        }
    }

    fn end(&mut self, mut run: Run) {
        self.watch.run_ended(&mut run);
        self.campaign.runs.push(run);
    }
}

/// Are the intervals as narrow as the target?
fn reaches(refined: &Refined, target: Target) -> bool {
    let width = |[low, high]: [f64; 2], value: f64| 0.5 * (high - low) / value.abs();
    let (range, model) = (&refined.interval_95, &refined.model);
    let widths = [width(range.a22_per_s, model.a22_per_s), width(range.b2_per_s2, model.b2_per_s2)];
    target.share(widths) <= 1.0
}
