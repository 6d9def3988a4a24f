//! A run from its first sample to its verdict.

use seatrial_core::estimator::{EstimatorSettings, Intake};
use seatrial_core::progress::RunResult;
use seatrial_core::{Axis, Outcome, Real, Sample, Stage, Trial};

use seatrial::campaign::{Run, StageSpan};
use seatrial::identification::{
    Convergence, LeastSquares, Online, Reason, ReasonCode, Refined, Settings, TracePoint, Verdict,
};
use seatrial::identify::online::{self, Pass, Segment};
use seatrial::identify::{IdentifyError, ValidationData, assess, validation_estimate};
use seatrial::log::{LambdaReason, Servo};
use seatrial::motions::pitch;
use seatrial::{Record, Step, Window, verdict};

use crate::TrialPlan;

/// Looks at the intervals in one half period of the training's rudder.
const LOOKS_PER_DEFLECTION: f64 = 4.0;

/// A run that is under way.
pub(super) struct OpenRun {
    number: u32,
    thrust: f64,
    attempt: u32,
    stages: Vec<StageSpan>,
    record: Record,
    /// For each sample of the record, whether the trial's guard refused it.
    is_refused: Vec<bool>,
    trace: Vec<TracePoint>,
    next_look_s: f64,
}

impl OpenRun {
    pub(super) fn new(number: u32, thrust: f64, attempt: u32) -> Self {
        Self {
            number,
            thrust,
            attempt,
            stages: Vec::new(),
            record: Record::default(),
            is_refused: Vec::new(),
            trace: Vec::new(),
            next_look_s: f64::NEG_INFINITY,
        }
    }

    pub(super) fn enter(&mut self, stage: Stage, time_s: f64) {
        self.close_stage(time_s);
        self.stages
            .push(StageSpan { stage, window: Window { from_s: time_s, to_s: f64::INFINITY } });
    }

    fn close_stage(&mut self, time_s: f64) {
        if let Some(span) = self.stages.last_mut() {
            span.window.to_s = time_s;
        }
    }

    pub(super) fn take(&mut self, step: &Step, trial: &Trial<f64>) {
        self.record.samples.push(step.sample);
        let is_refused = matches!(trial.intake(), Some(Intake::Rejected(_)));
        self.is_refused.push(is_refused);
        if let Some(model) = step.estimate {
            self.trace.push(TracePoint {
                time_s: step.sample.time_s,
                theta: model.theta(),
                step_norm: trial.estimator().step_norm(),
            });
        }
    }

    /// Time of the last sample, s.
    pub(super) fn last_s(&self) -> Option<f64> {
        self.record.samples.last().map(|sample| sample.time_s)
    }

    /// Were training over now: the estimate that the run would be judged by, if a look is due and there is one. That of pitch is
    /// found when the run is over.
    pub(super) fn look(&mut self, trial: &Trial<f64>, servo: Option<Servo>) -> Option<Refined> {
        if trial.plan().axis == Axis::Pitch {
            return None;
        }
        let training = self.stages.last().filter(|span| span.stage == Stage::Train)?;
        let now_s = self.last_s()?;
        if now_s < self.next_look_s {
            return None;
        }
        let deflection_s = trial.plan().training.excitation.longest_deflection_s();
        self.next_look_s = now_s + deflection_s / LOOKS_PER_DEFLECTION;
        validation_estimate(&self.behind(servo).usable(training.window))
    }

    /// Is the manoeuvre of the training over? No sooner can the training end.
    pub(super) fn is_excited(&self, trial: &Trial<f64>) -> bool {
        let excitation_end_s = trial.plan().training.excitation_end_s();
        let training = self.stages.last().zip(self.last_s());
        training.is_some_and(|(span, now_s)| {
            span.stage == Stage::Train && now_s - span.window.from_s >= excitation_end_s
        })
    }

    /// What runs are identified from: the samples that the guard let through, with the rudder that acts behind the servo.
    fn behind(&self, servo: Option<Servo>) -> Record {
        let commanded = &self.record.samples;
        match servo {
            Some(servo) => mended(&servo.acting(commanded), &self.is_refused),
            None => mended(commanded, &self.is_refused),
        }
    }

    /// Trained and validated: refined and judged.
    pub(super) fn judged(mut self, time_s: f64, result: &RunResult<f64>, plan: &TrialPlan) -> Run {
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
                    error => Reason::new(ReasonCode::NotIdentifiable, error.to_string()),
                })
            },
        }
    }

    /// Trained and validated: judged by the trial's own result alone.
    pub(super) fn judged_by_trial(mut self, time_s: f64, result: &RunResult<f64>) -> Run {
        self.close_stage(time_s);
        let reason = match result.accepted {
            true => Reason::new(ReasonCode::Ok, "the trial accepted the run"),
            false => Reason::new(ReasonCode::LowR2, "the trial did not accept the run"),
        };
        let verdict = Verdict { accepted: result.accepted, reasons: vec![reason.clone()] };
        Run { surge_speed_m_s: result.surge_speed_m_s, verdict, ..self.without_model(reason) }
    }

    fn identification(
        &mut self,
        result: &RunResult<f64>,
        plan: &TrialPlan,
    ) -> Result<seatrial::Identification, IdentifyError> {
        let window = |wanted: Stage| {
            self.stages.iter().find(|span| span.stage == wanted).map(|span| span.window)
        };
        let (Some(training), Some(validation)) = (window(Stage::Train), window(Stage::Validate))
        else {
            return Err(IdentifyError::MissingStage);
        };
        let servo = plan.servo();
        let record = self.behind(servo);
        let settings = plan.estimator_settings();
        let pass = match servo {
            Some(_) => pass_behind_servo(&record, training, result, plan)?,
            None => self.live_pass(&record, training, result, &settings),
        };
        let used = Settings {
            lambda_because: LambdaReason::PlansDoublet,
            servo,
            ..Settings::of(&settings)
        };
        let data = Some(ValidationData { record: &record, window: validation });
        let mut identification = match plan.axis {
            Axis::Yaw => assess(&record, training, data, pass, used)?,
            Axis::Pitch => pitch::assess(&record, training, data, pass, used)?,
        };
        if let Some(servo) = servo {
            identification.behind(servo);
        }
        if !result.accepted {
            identification.verdict = verdict::not_taken(
                identification.verdict,
                plan.axis,
                &result.validation,
                plan.accept_from_r2,
                result.attempt <= plan.max_repeats,
            );
        }
        identification.verdict = identification.verdict.of_a_trial();
        Ok(identification)
    }

    /// The estimate that the trial made.
    fn live_pass(
        &mut self,
        record: &Record,
        training: Window,
        result: &RunResult<f64>,
        settings: &EstimatorSettings<f64>,
    ) -> Pass {
        Pass {
            online: Online {
                method: settings.method.into(),
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
            restoring_per_s2: result.restoring_per_s2,
            accepted: record.usable(training),
        }
    }

    /// Ended before it was validated.
    pub(super) fn stopped(mut self, time_s: f64, outcome: Outcome) -> Run {
        self.close_stage(time_s);
        self.without_model(match outcome {
            Outcome::Aborted(reason) => Reason::new(
                ReasonCode::Aborted,
                format!("the trial was aborted during this run: {reason}"),
            ),
            Outcome::Finished => {
                Reason::new(ReasonCode::Aborted, "the trial ended during this run")
            }
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
            verdict: Verdict::refused(reason).of_a_trial(),
        }
    }
}

/// What the guard let through. Where it refused one heading between two that it took, the rudder of that
/// sample still acted: its heading is put on the line between the two.
fn mended(samples: &[Sample<f64>], is_refused: &[bool]) -> Record {
    let taken = |k: usize| samples.get(k).filter(|_| !is_refused[k]);
    let between = |k: usize| {
        let (before, after) = (taken(k.checked_sub(1)?)?, taken(k + 1)?);
        let sample = &samples[k];
        let share = (sample.time_s - before.time_s) / (after.time_s - before.time_s);
        let turned = Real::wrapped(after.heading_rad - before.heading_rad);
        (0.0..1.0)
            .contains(&share)
            .then_some(Sample { heading_rad: before.heading_rad + share * turned, ..*sample })
    };
    (0..samples.len())
        .filter_map(|k| taken(k).copied().or_else(|| between(k)))
        .filter(|sample| sample.heading_rad.is_finite())
        .collect()
}

/// The online estimate from a record whose rudder acts behind a servo; that of the trial knew the command only.
fn pass_behind_servo(
    record: &Record,
    training: Window,
    result: &RunResult<f64>,
    plan: &TrialPlan,
) -> Result<Pass, IdentifyError> {
    let before = Window { from_s: f64::NEG_INFINITY, to_s: training.from_s };
    let segment = Segment {
        settling: record.window(before),
        training: record.window(training),
        learns_from_s: training.from_s,
        excited_by_s: Some(training.from_s + plan.training.excitation_end_s()),
    };
    let pass = online::estimate(&segment, plan.estimator_settings(), true)
        .map_err(IdentifyError::Setting)?;
    Ok(Pass { rejected: result.rejected.into(), ..pass })
}
