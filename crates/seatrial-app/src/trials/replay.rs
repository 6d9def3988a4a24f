//! Proof that a recorded trial would happen again, bit for bit.

use std::convert::Infallible;
use std::fmt::Debug;

use seatrial_core::InvalidSetting;
use seatrial_core::{AbortReason, Action, Outcome, Sample, Trial, Vehicle};
use serde::Serialize;
use serde_json::Value;

use crate::TrialPlan;
use crate::conduct::{Watch, conduct};
use seatrial::Step;
use seatrial::campaign::{Campaign, Run};
use seatrial::identification::ReasonCode;
use seatrial_logbook::Recording;

/// What came of conducting a recorded trial again on its samples.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Replay {
    /// Samples taken, each with the action that answered it.
    pub samples: usize,
    /// Live estimates among them.
    pub estimates: usize,
    /// Runs whose result, refined estimate and verdict included, was made again.
    pub results: usize,
    /// Runs that were stopped by something after the last sample kept: the process was killed before it kept that, so the
    /// reason cannot be made again. Their samples, actions and estimates are compared.
    pub runs_without_their_end: Vec<u32>,
    /// `None` where every action, estimate and result had the bits recorded.
    pub first_difference: Option<FirstDifference>,
}

/// The first thing that did not happen again.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FirstDifference {
    /// Place of the sample in the record, from 0.
    pub sample: usize,
    /// Number of the run.
    pub run: Option<u32>,
    /// What was recorded and what came now, by name.
    pub found: String,
}

impl Replay {
    /// Conducts the trial again, with this plan, until something differs.
    pub fn of(plan: impl Into<TrialPlan>, recording: &Recording) -> Result<Self, InvalidSetting> {
        let about = Campaign { runs: Vec::new(), outcome: None, ..recording.campaign.clone() };
        let mut vehicle = RecordedVehicle {
            steps: recording.steps.iter(),
            sample_after: sample_after_last_result(recording),
            outcome: recording.campaign.outcome,
        };
        let mut comparison = Comparison { recording, replay: Self::default() };
        conduct(&mut vehicle, plan, about, &mut comparison)?;
        Ok(comparison.replay)
    }
}

/// Measures what was measured, whatever it is told to do.
struct RecordedVehicle<'a> {
    steps: std::slice::Iter<'a, (Option<u32>, Step)>,
    /// Comes after the recorded ones.
    sample_after: Option<Sample<f64>>,
    outcome: Option<Outcome>,
}

/// The sample that ended the last run, where the process was killed after it kept the run's result and before it kept that
/// sample. Nothing of the result depends on it but its time, which is the end of the run's last stage.
fn sample_after_last_result(recording: &Recording) -> Option<Sample<f64>> {
    let (last_number, last) = recording.steps.last()?;
    let mut runs = recording.campaign.runs.iter();
    let run = runs.find(|run| Some(run.number) == *last_number && !is_stopped(run))?;
    let ended_s = run.stages.last()?.window.to_s;
    let is_missing = ended_s.is_finite() && ended_s > last.sample.time_s;
    let mut steps = recording.steps.iter().rev().map(|(_, step)| step.sample);
    let sample = steps.find(|sample| sample.heading_rad.is_finite())?;
    is_missing.then_some(Sample { time_s: ended_s, ..sample })
}

/// Was the run stopped by something that the record does not hold, because the process was killed?
fn is_without_its_end(recording: &Recording, run: &Run) -> bool {
    let is_last = (recording.steps.last()).is_some_and(|(number, _)| *number == Some(run.number));
    is_last && is_stopped(run) && recording.campaign.outcome.is_none()
}

/// Did something end the run before its last stage was over?
fn is_stopped(run: &Run) -> bool {
    let mut reasons = run.verdict.reasons.iter();
    reasons.any(|reason| reason.code == ReasonCode::Aborted)
}

impl Vehicle<f64> for RecordedVehicle<'_> {
    type Error = Infallible;

    fn next_sample(&mut self) -> Result<Option<Sample<f64>>, Infallible> {
        let recorded = self.steps.next().map(|(_, step)| step.sample);
        Ok(recorded.or_else(|| self.sample_after.take()))
    }

    fn act(&mut self, _: &Action<f64>) -> Result<(), Infallible> {
        Ok(())
    }

    fn ended_for(&self) -> Option<AbortReason> {
        match self.outcome {
            Some(Outcome::Aborted(reason)) => Some(reason),
            _ => None,
        }
    }
}

/// Holds what happens against the record.
struct Comparison<'a> {
    recording: &'a Recording,
    replay: Replay,
}

impl Comparison<'_> {
    fn differs(&mut self, run: Option<u32>, found: String) {
        let sample = self.replay.samples;
        self.replay.first_difference.get_or_insert(FirstDifference { sample, run, found });
    }
}

impl Watch for Comparison<'_> {
    fn step(&mut self, step: &Step, _: &Trial<f64>) {
        let Some((run, recorded)) = self.recording.steps.get(self.replay.samples) else {
            return;
        };
        if !step.same_bits(recorded) {
            self.differs(*run, step_difference(recorded, step));
        }
        if self.replay.first_difference.is_none() {
            self.replay.samples += 1;
            self.replay.estimates += usize::from(recorded.estimate.is_some());
        }
    }

    fn run_ended(&mut self, run: &mut Run) {
        let mut recorded = self.recording.campaign.runs.iter();
        let Some(recorded) = recorded.find(|recorded| recorded.number == run.number) else {
            return;
        };
        if is_without_its_end(self.recording, recorded) {
            self.replay.runs_without_their_end.push(run.number);
            return;
        }
        match result_difference(recorded, run) {
            Some(found) => self.differs(Some(run.number), found),
            None => self.replay.results += 1,
        }
    }

    /// The operator's abort is in no sample. It came before the last but one: that was answered with
    /// neutral rudder, and the last with the hand back.
    fn wants_abort(&mut self) -> bool {
        let last = self.recording.steps.last();
        let by_operator = last.and_then(|(_, step)| step.action.outcome)
            == Some(Outcome::Aborted(AbortReason::Operator));
        let is_last_but_one = self.replay.samples + 2 == self.recording.steps.len();
        self.replay.first_difference.is_some() || (by_operator && is_last_but_one)
    }
}

fn step_difference(recorded: &Step, now: &Step) -> String {
    let bits = |number: Option<f64>| number.map(f64::to_bits);
    let numbers = Step::COLUMNS
        .into_iter()
        .zip(recorded.numbers().into_iter().zip(now.numbers()))
        .filter(|(_, (recorded, now))| bits(*recorded) != bits(*now))
        .map(|(name, (recorded, now))| difference(name, recorded, now));
    let stage =
        (recorded.stage != now.stage).then(|| difference("stage", recorded.stage, now.stage));
    let (was, is) = (recorded.action.outcome, now.action.outcome);
    let outcome = (was != is).then(|| difference("outcome", was, is));
    let all: Vec<String> = numbers.chain(stage).chain(outcome).collect();
    all.join("; ")
}

fn difference<T: Debug>(name: &str, recorded: Option<T>, now: Option<T>) -> String {
    let words = |value: Option<T>| value.map_or("none".into(), |value| format!("{value:?}"));
    format!("{name}: recorded {}, now {}", words(recorded), words(now))
}

/// The text of a number in JSON is its bits: the shortest that reads back to them.
fn result_difference(recorded: &Run, now: &Run) -> Option<String> {
    let json = |run: &Run| serde_json::to_value(run).unwrap_or_default();
    value_difference("result", &json(recorded), &json(now))
}

fn value_difference(name: &str, recorded: &Value, now: &Value) -> Option<String> {
    match (recorded, now) {
        (Value::Object(was), Value::Object(is)) if was.len() == is.len() => {
            was.iter().find_map(|(key, was)| {
                let is = is.get(key).unwrap_or(&Value::Null);
                value_difference(&format!("{name}.{key}"), was, is)
            })
        }
        (Value::Array(was), Value::Array(is)) if was.len() == is.len() => was
            .iter()
            .zip(is)
            .enumerate()
            .find_map(|(k, (was, is))| value_difference(&format!("{name}[{k}]"), was, is)),
        _ => {
            // The text of -0 is not that of 0.
            let (was, is) = (recorded.to_string(), now.to_string());
            (was != is).then(|| {
                let (was, is) = (in_a_few_words(recorded), in_a_few_words(now));
                format!("{name}: recorded {was}, now {is}")
            })
        }
    }
}

/// Longest text of a value in a difference, characters.
const MOST_CHARACTERS: usize = 120;

/// A number or a short text as it is; of anything larger only how large it is.
fn in_a_few_words(value: &Value) -> String {
    match value {
        Value::Object(fields) => format!("a table of {} fields", fields.len()),
        Value::Array(values) => format!("a list of {} values", values.len()),
        value => {
            let text = value.to_string();
            match text.char_indices().nth(MOST_CHARACTERS) {
                Some((end, _)) => format!("{}... ({} bytes)", &text[..end], text.len()),
                None => text,
            }
        }
    }
}
