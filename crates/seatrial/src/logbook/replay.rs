//! Proof that a recorded trial would happen again, bit for bit.

use seatrial_core::estimator::InvalidSetting;
use seatrial_core::{Outcome, Plan, Trial};
use serde::Serialize;

use super::Step;

/// What came of taking recorded samples through the trial again.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Replay {
    /// Samples taken, each with the action that answered it.
    pub samples: usize,
    /// Estimates among them.
    pub estimates: usize,
    /// `None` where every action and every estimate had the bits recorded.
    pub first_difference: Option<FirstDifference>,
}

/// The first step that did not happen again.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FirstDifference {
    /// Its place in the record, from 0.
    pub sample: usize,
    /// Number of its run.
    pub run: Option<u32>,
    /// Its time, s.
    pub time_s: f64,
    /// What was recorded and what came now, by name.
    pub found: String,
}

impl Replay {
    /// Takes the steps of a campaign through a trial of its plan, until one differs.
    ///
    /// An abort from outside (operator, lost link) is in no sample: it is given where the record
    /// shows it.
    pub fn of(
        plan: Plan<f64>,
        steps: &[(Option<u32>, Step)],
        outcome: Option<Outcome>,
    ) -> Result<Self, InvalidSetting> {
        let mut trial = Trial::new(plan)?;
        let mut replay = Self::default();
        for (run, recorded) in steps {
            let before = trial;
            let mut replayed = Step::take(&mut trial, recorded.sample);
            if let Some(Outcome::Aborted(reason)) = outcome
                && before.outcome().is_none()
                && !replayed.same_bits(recorded)
            {
                let mut aborted = before;
                aborted.abort(reason);
                let handed_back = Step::take(&mut aborted, recorded.sample);
                if handed_back.same_bits(recorded) {
                    (trial, replayed) = (aborted, handed_back);
                }
            }
            if !replayed.same_bits(recorded) {
                replay.first_difference = Some(FirstDifference {
                    sample: replay.samples,
                    run: *run,
                    time_s: recorded.sample.time_s,
                    found: difference(recorded, &replayed),
                });
                break;
            }
            replay.samples += 1;
            replay.estimates += usize::from(recorded.estimate.is_some());
        }
        Ok(replay)
    }
}

fn difference(recorded: &Step, replayed: &Step) -> String {
    let bits = |number: Option<f64>| number.map(f64::to_bits);
    let numbers = Step::COLUMNS
        .into_iter()
        .zip(recorded.numbers().into_iter().zip(replayed.numbers()))
        .filter(|(_, (recorded, replayed))| bits(*recorded) != bits(*replayed))
        .map(|(name, (recorded, replayed))| told(name, recorded, replayed));
    let stage =
        (recorded.stage != replayed.stage).then(|| told("stage", recorded.stage, replayed.stage));
    let (was, is) = (recorded.action.outcome, replayed.action.outcome);
    let outcome = (was != is).then(|| told("outcome", was, is));
    let all: Vec<String> = numbers.chain(stage).chain(outcome).collect();
    all.join("; ")
}

fn told<T: std::fmt::Debug>(name: &str, recorded: Option<T>, replayed: Option<T>) -> String {
    let words = |value: Option<T>| value.map_or("none".into(), |value| format!("{value:?}"));
    format!(
        "{name}: recorded {}, now {}",
        words(recorded),
        words(replayed)
    )
}
