//! The trial: a state machine from samples to actions.

mod phase;
mod training;

use crate::answer::AnswerWatch;
use crate::envelope::EnvelopeWatch;
use crate::estimator::{Estimator, Intake};
use crate::excitation::CLOCK_RESOLUTION_S;
use crate::guard::RejectedCounts;
use crate::plan::{Manoeuvre, Plan};
use crate::progress::{Event, RunResult, Stage, Status};
use crate::rudder_sense::RudderSenseWatch;
use crate::setting::InvalidSetting;
use crate::settle::{NotSettled, SettleGate, SettleState};
use crate::validation::{GoodnessOfFit, Validation};
use crate::{AbortReason, Action, List, Outcome, Real, Sample, Steering};
use phase::{Due, Phase};
use training::Training;

/// Most events that wait to be taken.
pub const WAITING_EVENTS: usize = 8;

/// A sea trial: settle, train and validate at each thrust of the plan, then hand the vehicle back.
///
/// ```text
/// settle -> train -> validate -> accepted ------------------> next thrust ... -> home
///   ^                    \-----> R^2 < 0.60, tries left --\
///   \-----------------------------------------------------/
/// from everywhere: limit exceeded or abort() -> neutral rudder -> heading hold, own thrust
/// ```
///
/// Pass every sample to [`step`](Trial::step) and carry out the action it returns. All times are the samples' own; a stage begins
/// with the first sample at or after its time. The trial counts on nothing but that [`Sample::rudder_rad`] is what acts from the
/// sample's time on: an action may take effect at any later sample. A sample that the guard refuses moves neither estimate nor
/// validation, but its sound parts are still held against the envelope, and its time, if sound, still ends a deflection. Without
/// a sound heading for 0.5 s the rudder is neutral until one comes. Limits are checked before a stage may end. After an abort the first action is neutral rudder and the next, whatever the sample, holds
/// the last sound heading; both leave the thrust to the vehicle.
#[derive(Clone, Copy, Debug)]
pub struct Trial<T> {
    plan: Plan<T>,
    estimator: Estimator<T>,
    envelope: EnvelopeWatch<T>,
    answer: AnswerWatch<T>,
    /// No sound heading has come for too long to leave the rudder over.
    is_blind: bool,
    /// Index into the plan's thrusts.
    speed: usize,
    attempt: u32,
    run: u32,
    rejected_before: RejectedCounts,
    /// What became of the latest sample.
    intake: Option<Intake>,
    phase: Phase<T>,
    phase_start_s: f64,
    settled: bool,
    training: Training<T>,
    run_heading_rad: Option<T>,
    last_heading_rad: T,
    /// The latest sound time, s.
    clock_s: Option<f64>,
    /// How long the sound time has stood still while samples came, s.
    stood_still_s: f64,
    /// Time of the latest good sample, s.
    usable_s: Option<f64>,
    unusable_in_a_row: u32,
    neutral_given: bool,
    events: List<Option<Event<T>>, WAITING_EVENTS>,
}

impl<T: Real> Trial<T> {
    /// A trial that waits for its first sample; else the first setting of the plan that is out of its range.
    pub fn new(plan: Plan<T>) -> Result<Self, InvalidSetting> {
        plan.check()?;
        Ok(Self {
            plan,
            estimator: Estimator::new(plan.estimator_settings())?,
            envelope: EnvelopeWatch::new(plan.envelope),
            answer: AnswerWatch::default(),
            is_blind: false,
            speed: 0,
            attempt: 1,
            run: 0,
            rejected_before: RejectedCounts::default(),
            intake: None,
            phase: Phase::Waiting,
            phase_start_s: 0.0,
            settled: false,
            training: Training::default(),
            run_heading_rad: None,
            last_heading_rad: T::ZERO,
            clock_s: None,
            stood_still_s: 0.0,
            usable_s: None,
            unusable_in_a_row: 0,
            neutral_given: false,
            events: List::default(),
        })
    }

    /// Takes in the next sample; the action holds until the next one.
    pub fn step(&mut self, sample: &Sample<T>) -> Action<T> {
        if self.outcome().is_none() {
            self.proceed(sample);
        }
        self.action()
    }

    /// The estimate is good enough: training ends with the next sample, or with the manoeuvre if that is not over yet.
    /// Nothing happens in other stages.
    pub fn finish_training(&mut self) {
        if matches!(self.phase, Phase::Train(_)) {
            self.training.enough = true;
        }
    }

    /// Ends the trial for a reason that the samples do not show; the next action hands the vehicle back.
    pub fn abort(&mut self, reason: AbortReason) {
        self.end(Outcome::Aborted(reason));
    }

    /// The oldest event not yet taken. Take all of them after every step: beyond [`WAITING_EVENTS`] the newest are lost.
    pub fn take_event(&mut self) -> Option<Event<T>> {
        self.events.pop_front().flatten()
    }

    /// How the trial ended.
    pub fn outcome(&self) -> Option<Outcome> {
        match self.phase {
            Phase::Over(outcome) => Some(outcome),
            _ => None,
        }
    }

    /// The plan.
    pub fn plan(&self) -> &Plan<T> {
        &self.plan
    }

    /// The estimator.
    pub fn estimator(&self) -> &Estimator<T> {
        &self.estimator
    }

    /// What became of the latest sample; `None` before the first.
    ///
    /// ```
    /// use seatrial_core::{Cause, Intake, Plan, Sample, Trial};
    ///
    /// let mut trial = Trial::new(Plan::<f64>::paper())?;
    /// let _ = trial.step(&Sample { heading_rad: f64::NAN, ..Sample::default() });
    /// assert_eq!(trial.intake(), Some(Intake::Rejected(Cause::NonFinite)));
    /// # Ok::<(), seatrial_core::InvalidSetting>(())
    /// ```
    pub fn intake(&self) -> Option<Intake> {
        self.intake
    }

    /// Where the trial is.
    pub fn status(&self) -> Status<T> {
        let (stage, duration_s) = match self.phase {
            Phase::Waiting | Phase::Over(_) => (None, 0.0),
            Phase::Settle(_) => (Some(Stage::Settle), self.plan.settle.at_most_s),
            Phase::Train(_) => (Some(Stage::Train), self.plan.training.duration_s()),
            Phase::Validate(_) => (Some(Stage::Validate), self.plan.validation.duration_s()),
        };
        let elapsed_s = stage.map_or(0.0, |_| self.elapsed_s());
        Status {
            run: self.run,
            speed: self.speed + 1,
            speeds: self.plan.thrusts.len(),
            thrust: self.thrust(),
            attempt: self.attempt,
            stage,
            elapsed_s,
            remaining_s: (duration_s - elapsed_s).max(0.0),
            model: self.estimator.model(),
            step_norm: self.estimator.step_norm(),
            envelope: *self.envelope.usage(),
            outcome: self.outcome(),
        }
    }

    fn proceed(&mut self, sample: &Sample<T>) {
        let time_is_sound =
            sample.time_s.is_finite() && self.clock_s.is_none_or(|clock_s| sample.time_s > clock_s);
        if time_is_sound {
            self.clock_s = Some(sample.time_s);
        } else {
            self.stood_still_s += self.plan.sample_interval_s;
        }
        let due = if time_is_sound { self.due() } else { Due::Same };
        let usable = self.learn(sample, time_is_sound, &due);
        if let Some(reason) = self.danger(sample, usable) {
            self.end(Outcome::Aborted(reason));
            return;
        }
        if usable || !matches!(self.phase, Phase::Waiting) {
            self.enter(due);
        }
        if usable {
            self.record(sample);
        }
    }

    /// The phase that a sample at the current time belongs to.
    fn due(&self) -> Due<T> {
        let is_over = |manoeuvre: &Manoeuvre<T>| {
            self.elapsed_s() + CLOCK_RESOLUTION_S >= manoeuvre.duration_s()
        };
        match &self.phase {
            Phase::Waiting => Due::Settle,
            Phase::Settle(gate) => match gate.judge(self.elapsed_s()) {
                SettleState::Waiting => Due::Same,
                SettleState::Steady => Due::Train { settled: true },
                SettleState::TimedOut => match self.plan.settle.not_settled {
                    NotSettled::GoOn => Due::Train { settled: false },
                    NotSettled::Abort => Due::Abort(AbortReason::NotSettled),
                },
            },
            Phase::Train(_) => {
                let converged =
                    self.plan.stop_on_convergence && self.estimator.converged_s().is_some();
                let training = &self.plan.training;
                let enough = self.training.enough
                    && self.elapsed_s() + CLOCK_RESOLUTION_S >= training.excitation_end_s();
                if converged || enough || is_over(training) { Due::Validate } else { Due::Same }
            }
            Phase::Validate(validation) if is_over(&self.plan.validation) => {
                Due::NextRun(self.result(self.plan.axis.goodness_of_fit(validation)))
            }
            Phase::Validate(_) | Phase::Over(_) => Due::Same,
        }
    }

    /// Passes the sample to the estimator. `true`: it is good.
    fn learn(&mut self, sample: &Sample<T>, time_is_sound: bool, due: &Due<T>) -> bool {
        let is_training = match due {
            Due::Same => matches!(self.phase, Phase::Train(_)),
            Due::Train { .. } => true,
            _ => false,
        };
        let (time_s, heading_rad, rudder_rad) =
            (sample.time_s, sample.heading_rad, sample.rudder_rad);
        let converged_before = self.estimator.converged_s().is_some();
        let intake = if is_training {
            let excitation_end_s = self.plan.training.excitation_end_s();
            if matches!(due, Due::Same) && self.elapsed_s() + CLOCK_RESOLUTION_S >= excitation_end_s
            {
                self.estimator.excitation_ended();
            }
            self.estimator.update(time_s, heading_rad, rudder_rad)
        } else {
            self.estimator.warm(time_s, heading_rad, rudder_rad)
        };
        self.intake = Some(intake);
        if let (false, Some(elapsed_s)) = (converged_before, self.estimator.converged_s()) {
            self.tell(Event::Converged { elapsed_s });
        }
        if intake == Intake::Used {
            self.training.samples_used = self.training.samples_used.saturating_add(1);
        }
        // The guard takes a lasting jump of the clock as the new time; the stages cannot.
        time_is_sound && !matches!(intake, Intake::Rejected(_))
    }

    /// Why the trial must not go on.
    fn danger(&mut self, sample: &Sample<T>, usable: bool) -> Option<AbortReason> {
        let clock_s = self.clock_s.unwrap_or(0.0);
        let silence_s = clock_s - self.usable_s.unwrap_or(clock_s);
        self.unusable_in_a_row = if usable { 0 } else { self.unusable_in_a_row.saturating_add(1) };
        let refused_s = f64::from(self.unusable_in_a_row) * self.plan.sample_interval_s;
        let watched_s = clock_s + self.stood_still_s;
        self.envelope.look(sample, watched_s);
        let (silence_s, usual_s) = (silence_s.max(refused_s), self.plan.sample_interval_s);
        self.envelope.listen(silence_s, watched_s);
        self.is_blind = self.envelope.is_blind(silence_s, watched_s, usual_s);
        let mut against = None;
        if usable {
            self.usable_s = Some(clock_s);
            self.last_heading_rad = sample.heading_rad;
            let run_heading_rad = *self.run_heading_rad.get_or_insert(sample.heading_rad);
            let error_rad = (sample.heading_rad - run_heading_rad).wrapped();
            self.envelope.heading(error_rad);
            let elapsed_s = self.elapsed_s() + CLOCK_RESOLUTION_S;
            match &mut self.phase {
                Phase::Train(watch) => {
                    let elapsed_s = elapsed_s - self.plan.training.lead_in_s;
                    let missing = self.answer.is_missing(elapsed_s, error_rad, sample.rudder_rad);
                    against = missing.then_some(AbortReason::NoAnswer);
                    let is_reversed = watch.as_mut().is_some_and(|watch| {
                        watch.is_reversed(elapsed_s, error_rad, sample.rudder_rad)
                    });
                    against = against.or(is_reversed.then_some(AbortReason::ReversedRudder));
                    self.envelope.speed(sample, elapsed_s < 0.0);
                }
                Phase::Validate(_) => {
                    let elapsed_s = elapsed_s - self.plan.validation.lead_in_s;
                    let missing = self.answer.is_missing(elapsed_s, error_rad, sample.rudder_rad);
                    against = missing.then_some(AbortReason::NoAnswer);
                    self.envelope.speed(sample, elapsed_s < 0.0);
                }
                _ => {}
            }
        }
        if !matches!(self.phase, Phase::Waiting) {
            self.envelope.clock(self.elapsed_s());
        }
        self.envelope.usage().exceeded().or(against)
    }

    fn enter(&mut self, due: Due<T>) {
        match due {
            Due::Same => {}
            Due::Settle => self.start_run(),
            Due::Train { settled } => {
                self.settled = settled;
                let watch = RudderSenseWatch::new(
                    self.plan.envelope.rudder_sense,
                    &self.plan.training.excitation,
                );
                self.answer = AnswerWatch::new(&self.plan.training.excitation);
                self.start_phase(Phase::Train(watch), Stage::Train);
            }
            Due::Validate => {
                let validation =
                    Validation::new(self.estimator.model(), self.plan.validation.lead_in_s)
                        .righted_by(self.estimator.restoring_per_s2());
                self.answer = AnswerWatch::new(&self.plan.validation.excitation);
                self.start_phase(Phase::Validate(validation), Stage::Validate);
            }
            Due::NextRun(result) => {
                let time_s = self.clock_s.unwrap_or(0.0);
                self.tell(Event::RunFinished { time_s, result });
                if !result.accepted && self.attempt <= self.plan.max_repeats {
                    self.attempt += 1;
                } else {
                    self.attempt = 1;
                    self.speed += 1;
                }
                if self.speed < self.plan.thrusts.len() {
                    self.start_run();
                } else {
                    self.end(Outcome::Finished);
                }
            }
            Due::Abort(reason) => self.end(Outcome::Aborted(reason)),
        }
    }

    /// A good sample in the phase that it belongs to.
    fn record(&mut self, sample: &Sample<T>) {
        let elapsed_s = self.elapsed_s();
        let run_heading_rad = self.run_heading_rad.unwrap_or(sample.heading_rad);
        match &mut self.phase {
            Phase::Settle(gate) => {
                let error_rad = (sample.heading_rad - run_heading_rad).wrapped();
                gate.add(elapsed_s, error_rad, sample);
            }
            Phase::Train(_) => self.training.add_speed(sample),
            Phase::Validate(validation) => validation.compare(sample),
            Phase::Waiting | Phase::Over(_) => {}
        }
    }

    fn start_run(&mut self) {
        self.run = self.run.saturating_add(1);
        self.estimator.restart();
        self.rejected_before = self.estimator.rejected();
        self.training = Training::default();
        self.tell(Event::RunStarted {
            number: self.run,
            thrust: self.thrust(),
            attempt: self.attempt,
        });
        let gate = SettleGate::new(self.plan.settle);
        self.start_phase(Phase::Settle(gate), Stage::Settle);
    }

    fn start_phase(&mut self, phase: Phase<T>, stage: Stage) {
        let time_s = self.clock_s.unwrap_or(0.0);
        self.phase = phase;
        self.phase_start_s = time_s;
        self.envelope.stage_started();
        self.tell(Event::StageStarted { stage, time_s });
    }

    fn end(&mut self, outcome: Outcome) {
        if self.outcome().is_none() {
            self.phase = Phase::Over(outcome);
            self.tell(Event::Ended { time_s: self.clock_s.unwrap_or(0.0), outcome });
        }
    }

    fn tell(&mut self, event: Event<T>) {
        let _ = self.events.push(Some(event));
    }

    fn result(&self, validation: GoodnessOfFit<T>) -> RunResult<T> {
        RunResult {
            number: self.run,
            thrust: self.thrust(),
            attempt: self.attempt,
            settled: self.settled,
            model: self.estimator.model(),
            restoring_per_s2: self.estimator.restoring_per_s2(),
            least_squares_model: self.estimator.least_squares_model(),
            covariance: self.estimator.covariance(),
            converged_s: self.estimator.converged_s(),
            validation,
            surge_speed_m_s: self.training.surge_speed_m_s(),
            samples_used: self.training.samples_used,
            rejected: self.estimator.rejected().since(&self.rejected_before),
            accepted: self.plan.axis.is_reached(&validation, self.plan.accept_from_r2),
        }
    }

    fn action(&mut self) -> Action<T> {
        let hold = Steering::HoldHeading(self.run_heading_rad.unwrap_or(self.last_heading_rad));
        let (steering, thrust, outcome) = match &self.phase {
            // Before the first good sample no heading is known that could be held.
            Phase::Waiting => (Steering::Rudder(T::ZERO), None, None),
            Phase::Settle(_) | Phase::Train(_) | Phase::Validate(_) if self.is_blind => {
                (Steering::Rudder(T::ZERO), Some(self.thrust()), None)
            }
            Phase::Settle(_) => (hold, Some(self.thrust()), None),
            Phase::Train(_) => {
                (self.manoeuvre(&self.plan.training, hold), Some(self.thrust()), None)
            }
            Phase::Validate(_) => {
                (self.manoeuvre(&self.plan.validation, hold), Some(self.thrust()), None)
            }
            Phase::Over(Outcome::Aborted(_)) if !self.neutral_given => {
                self.neutral_given = true;
                (Steering::Rudder(T::ZERO), None, None)
            }
            Phase::Over(outcome @ Outcome::Aborted(_)) => {
                let steering = match self.run_heading_rad {
                    Some(_) => Steering::HoldHeading(self.last_heading_rad),
                    // Not one good sample: no heading is known.
                    None => Steering::Rudder(T::ZERO),
                };
                (steering, None, Some(*outcome))
            }
            Phase::Over(outcome @ Outcome::Finished) => (hold, None, Some(*outcome)),
        };
        Action { steering, thrust, outcome }
    }

    fn manoeuvre(&self, manoeuvre: &Manoeuvre<T>, hold: Steering<T>) -> Steering<T> {
        manoeuvre
            .excitation
            .rudder_rad(self.elapsed_s() - manoeuvre.lead_in_s)
            .map_or(hold, |rudder_rad| {
                Steering::Rudder(rudder_rad.limited_to(self.plan.rudder_limit_rad))
            })
    }

    fn thrust(&self) -> T {
        let last = self.plan.thrusts.last();
        *self.plan.thrusts.get(self.speed).or(last).unwrap_or(&T::ZERO)
    }

    fn elapsed_s(&self) -> f64 {
        self.clock_s.map_or(0.0, |clock_s| clock_s - self.phase_start_s)
    }
}
