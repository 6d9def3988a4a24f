//! Conducts a trial on a vehicle and makes its campaign.

use std::time::{Duration, Instant};

use seatrial_core::estimator::{Estimator, InvalidSetting};
use seatrial_core::plan::Target;
use seatrial_core::progress::{Event, RunResult};
use seatrial_core::{AbortReason, Outcome, Plan, Real, Sample, Stage, Trial, Vehicle};

use crate::campaign::{Campaign, Run, StageSpan};
use crate::identification::{
    Convergence, LeastSquares, Online, Reason, Refined, Settings, TracePoint,
};
use crate::identify::online::Pass;
use crate::identify::refine::refine;
use crate::identify::{Fresh, IdentifyError, assess};
use crate::logbook::Step;
use crate::record::{Record, Window};
use crate::verdict;

/// Whoever watches or records a trial. None of it can stop the trial except [`Watch::wants_abort`].
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
    /// A run is over, with or without a model.
    fn run_ended(&mut self, _run: &Run) {}
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
    /// So many seconds of the vehicle in one of ours; 1 is real time.
    pub fn new(factor: f64) -> Self {
        Self {
            factor,
            begun: Instant::now(),
            first_s: None,
        }
    }

    /// Waits until this time of the vehicle is due.
    pub fn wait(&mut self, time_s: f64) {
        let first_s = *self.first_s.get_or_insert(time_s);
        let due = Duration::try_from_secs_f64((time_s - first_s) / self.factor);
        std::thread::sleep(due.unwrap_or_default().saturating_sub(self.begun.elapsed()));
    }
}

/// Nobody watches.
#[derive(Clone, Copy, Debug)]
pub struct Unwatched;

impl Watch for Unwatched {}

/// What came of a trial.
#[derive(Debug)]
pub struct Conducted<E> {
    /// Every run.
    pub campaign: Campaign,
    /// What the vehicle's link reported when it was lost.
    pub fault: Option<E>,
}

/// Looks at the intervals in one half period of the training's rudder.
const LOOKS_PER_DEFLECTION: f64 = 4.0;

/// Neutral rudder, then heading hold.
const HAND_BACK_ACTIONS: usize = 2;

/// Runs a trial of `plan` on `vehicle` until it is over and handed back.
///
/// `about` says what the campaign is of; its runs and outcome are filled in. The online estimate of a run is
/// the one that the trial made live; it is refined on the record of the training stage and validated
/// again with the refined model when the run is over. A vehicle that gives no more samples aborts the trial;
/// everything up to then is kept.
pub fn conduct<V: Vehicle<f64>>(
    vehicle: &mut V,
    plan: Plan<f64>,
    about: Campaign,
    watch: &mut dyn Watch,
) -> Result<Conducted<V::Error>, InvalidSetting> {
    let mut trial = Trial::new(plan)?;
    let mut campaign = about;
    let mut open: Option<OpenRun> = None;
    let mut fault = None;
    loop {
        if watch.wants_abort() || vehicle.is_taken_over() {
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
        // Before a run is judged and anybody is told: both take their time, and the rudder must not wait.
        let acted = vehicle.act(&step.action);
        while let Some(event) = trial.take_event() {
            match event {
                Event::RunStarted {
                    number,
                    thrust,
                    attempt,
                } => {
                    open = Some(OpenRun::new(number, thrust, attempt));
                    watch.run_started(number, thrust, attempt);
                }
                Event::StageStarted { stage, time_s } => {
                    if let Some(run) = &mut open {
                        run.enter(stage, time_s);
                    }
                }
                Event::Converged { .. } => {}
                Event::RunFinished { time_s, result } => {
                    if let Some(run) = open.take() {
                        end_run(run.finished(time_s, &result, &plan), &mut campaign, watch);
                    }
                }
                Event::Ended { time_s, outcome } => {
                    if let Some(run) = open.take() {
                        end_run(run.stopped(time_s, outcome), &mut campaign, watch);
                    }
                }
            }
        }
        if let Some(run) = &mut open {
            run.take(&step, trial.estimator());
        }
        watch.step(&step, &trial);
        if let Err(error) = acted {
            fault = Some(error);
            break;
        }
        if step.action.outcome.is_some() {
            break;
        }
        // After the command has gone out: a look takes longer than a step may.
        if plan.stop_when.is_some() || watch.wants_intervals() {
            let refined = open.as_mut().and_then(|run| run.look(&trial));
            if let Some(refined) = refined {
                watch.interval(&refined);
                if plan
                    .stop_when
                    .is_some_and(|target| reaches(&refined, target))
                {
                    trial.finish_training();
                }
            }
        }
    }
    if trial.outcome().is_none() {
        trial.abort(vehicle.ended_for().unwrap_or(AbortReason::LinkLost));
        // Should only the samples be lost, the vehicle still gets its rudder and heading back.
        for _ in 0..HAND_BACK_ACTIONS {
            let action = trial.step(&Sample::default());
            let _ = vehicle.act(&action);
        }
    }
    if let Some((run, outcome)) = open.take().zip(trial.outcome()) {
        let last_s = run.record.samples.last().map_or(0.0, |s| s.time_s);
        end_run(run.stopped(last_s, outcome), &mut campaign, watch);
    }
    campaign.outcome = trial.outcome();
    Ok(Conducted { campaign, fault })
}

/// Are the intervals as narrow as the target?
fn reaches(refined: &Refined, target: Target<f64>) -> bool {
    let width = |[low, high]: [f64; 2], value: f64| 0.5 * (high - low) / value.abs();
    let interval = &refined.interval_95;
    let widths = [
        width(interval.a22_per_s, refined.model.a22_per_s),
        width(interval.b2_per_s2, refined.model.b2_per_s2),
    ];
    target.share(widths) <= 1.0
}

fn end_run(run: Run, campaign: &mut Campaign, watch: &mut dyn Watch) {
    watch.run_ended(&run);
    campaign.runs.push(run);
}

/// A run that is under way.
struct OpenRun {
    number: u32,
    thrust: f64,
    attempt: u32,
    stages: Vec<StageSpan>,
    record: Record,
    /// The samples with the headings that the trial's guard let through; the others are no number.
    accepted: Record,
    /// Samples that it has refused.
    refused: Option<u32>,
    trace: Vec<TracePoint>,
    next_look_s: f64,
}

impl OpenRun {
    fn new(number: u32, thrust: f64, attempt: u32) -> Self {
        Self {
            number,
            thrust,
            attempt,
            stages: Vec::new(),
            record: Record::default(),
            accepted: Record::default(),
            refused: None,
            trace: Vec::new(),
            next_look_s: f64::NEG_INFINITY,
        }
    }

    fn enter(&mut self, stage: Stage, time_s: f64) {
        self.close_stage(time_s);
        self.stages.push(StageSpan {
            stage,
            window: Window {
                from_s: time_s,
                to_s: f64::INFINITY,
            },
        });
    }

    fn close_stage(&mut self, time_s: f64) {
        if let Some(span) = self.stages.last_mut() {
            span.window.to_s = time_s;
        }
    }

    fn take(&mut self, step: &Step, estimator: &Estimator<f64>) {
        self.record.samples.push(step.sample);
        let refused = Some(estimator.rejected().samples());
        let mut sample = step.sample;
        if self.refused.is_some_and(|before| Some(before) != refused) {
            sample.heading_rad = f64::NAN;
        }
        self.accepted.samples.push(sample);
        self.refused = refused;
        if let Some(model) = step.estimate {
            self.trace.push(TracePoint {
                time_s: step.sample.time_s,
                theta: model.theta(),
                step_norm: estimator.step_norm(),
            });
        }
    }

    /// The intervals of the training so far, if a look is due and there are any.
    fn look(&mut self, trial: &Trial<f64>) -> Option<Refined> {
        let training = self
            .stages
            .last()
            .filter(|span| span.stage == Stage::Train)?;
        let now_s = self.record.samples.last()?.time_s;
        if now_s < self.next_look_s {
            return None;
        }
        let deflection_s = trial.plan().training.excitation.longest_deflection_s();
        self.next_look_s = now_s + deflection_s / LOOKS_PER_DEFLECTION;
        let samples = self.record.usable(training.window);
        refine(&samples, Some(trial.estimator().model())).ok()
    }

    /// Trained and validated: refined and judged.
    fn finished(mut self, time_s: f64, result: &RunResult<f64>, plan: &Plan<f64>) -> Run {
        self.close_stage(time_s);
        let (number, thrust, attempt) = (self.number, self.thrust, self.attempt);
        match self.identification(result, plan) {
            Ok(identification) => Run {
                number,
                thrust,
                attempt,
                surge_speed_m_s: result.surge_speed_m_s,
                verdict: identification.verdict.clone(),
                identification: Some(identification),
                stages: self.stages,
                record: self.record,
            },
            Err(error) => Run {
                surge_speed_m_s: result.surge_speed_m_s,
                ..self.without_model(match error {
                    IdentifyError::Refused(reason) => reason,
                    error => Reason {
                        code: "not_identifiable".into(),
                        text: error.to_string(),
                    },
                })
            },
        }
    }

    /// What the guard let through. Where it refused one heading between two that it took, the rudder of that
    /// sample still acted: its heading is put on the line between the two.
    fn mended(&self) -> Record {
        let samples = &self.accepted.samples;
        let between = |k: usize| {
            let (before, after) = (samples.get(k.checked_sub(1)?)?, samples.get(k + 1)?);
            let sample = &samples[k];
            let share = (sample.time_s - before.time_s) / (after.time_s - before.time_s);
            let turned = Real::wrapped(after.heading_rad - before.heading_rad);
            (0.0..1.0).contains(&share).then_some(Sample {
                heading_rad: before.heading_rad + share * turned,
                ..*sample
            })
        };
        (0..samples.len())
            .map(|k| match samples[k] {
                refused if refused.heading_rad.is_nan() => between(k).unwrap_or(refused),
                sample => sample,
            })
            .filter(|sample| sample.heading_rad.is_finite())
            .collect()
    }

    fn identification(
        &mut self,
        result: &RunResult<f64>,
        plan: &Plan<f64>,
    ) -> Result<crate::Identification, IdentifyError> {
        let window = |wanted: Stage| {
            self.stages
                .iter()
                .find(|span| span.stage == wanted)
                .map(|span| span.window)
        };
        let (Some(training), Some(validation)) = (window(Stage::Train), window(Stage::Validate))
        else {
            return Err(IdentifyError::EmptyWindow(
                "the run has no training or no validation stage".into(),
            ));
        };
        let record = self.mended();
        let settings = plan.estimator_settings();
        let pass = Pass {
            online: Online {
                method: "instrumental_variable".into(),
                model: result.model,
                delta0_rad: result.model.delta0_rad(),
                covariance: result.covariance,
                least_squares: LeastSquares {
                    model: result.least_squares_model,
                    covariance: result.covariance,
                },
                batch: None,
                theta_at: Default::default(),
                convergence: Convergence {
                    detected_s: result.converged_s,
                    threshold: settings.convergence.threshold,
                    consecutive: settings.convergence.consecutive,
                },
                trace: std::mem::take(&mut self.trace),
            },
            samples_used: result.samples_used as usize,
            rejected: result.rejected.into(),
            accepted: record.usable(training),
        };
        let mut identification = assess(
            &record,
            training,
            Some(Fresh {
                record: &record,
                window: validation,
            }),
            pass,
            Settings {
                lambda_because: "from the plan's doublet".into(),
                ..Settings::of(&settings)
            },
        )?;
        if !result.accepted {
            identification.verdict = verdict::not_taken(
                identification.verdict,
                &result.validation,
                plan.accept_from_r2,
                result.attempt <= plan.max_repeats,
            );
        }
        Ok(identification)
    }

    /// Ended before it was validated.
    fn stopped(mut self, time_s: f64, outcome: Outcome) -> Run {
        self.close_stage(time_s);
        self.without_model(match outcome {
            Outcome::Aborted(reason) => Reason {
                code: "aborted".into(),
                text: format!("the trial was aborted during this run: {reason}"),
            },
            Outcome::Finished => Reason {
                code: "aborted".into(),
                text: "the trial ended during this run".into(),
            },
        })
    }

    fn without_model(self, reason: Reason) -> Run {
        Run {
            number: self.number,
            thrust: self.thrust,
            attempt: self.attempt,
            surge_speed_m_s: None,
            stages: self.stages,
            record: self.record,
            identification: None,
            verdict: verdict::refused(reason),
        }
    }
}
