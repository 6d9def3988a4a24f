//! What came of a world.

use seatrial::campaign::Campaign;
use seatrial_core::Outcome;
use serde::Serialize;

use crate::faults::Why;

use super::drawn::{Depth, World};
use super::models::{Models, too_far};

/// How a world ended.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Ending {
    /// Its seed.
    pub seed: u64,
    /// How much of the program took part.
    pub depth: Depth,
    /// `finished`, why it was aborted, or `not_taken`.
    pub outcome: String,
    /// Runs with a result.
    pub runs: usize,
    /// Runs accepted.
    pub accepted: usize,
    /// Samples that the vehicle gave.
    pub samples: u64,
    /// From the condition of the abort to neutral rudder, s, where the condition is known.
    pub neutral_after_s: Option<f64>,
    /// Accepted models beside the truth.
    pub models: Models,
    /// Digest of all samples and actions, equal where a world was replayed exactly.
    pub digest: u64,
    /// The invariants that were broken.
    pub broken: Vec<String>,
}

impl Ending {
    /// The ending of a world before it has been played.
    pub fn of(world: &World) -> Self {
        Self {
            seed: world.seed,
            depth: world.depth,
            outcome: String::new(),
            runs: 0,
            accepted: 0,
            samples: 0,
            neutral_after_s: None,
            models: Models::default(),
            digest: 0,
            broken: Vec::new(),
        }
    }

    /// Notes how the trial ended.
    pub fn take(&mut self, campaign: &Campaign) {
        self.outcome = match campaign.outcome {
            Some(Outcome::Finished) => "finished".into(),
            Some(Outcome::Aborted(reason)) => Why::Aborted(reason).to_string(),
            None => "none".into(),
        };
        self.runs = campaign.runs.len();
        self.accepted = campaign.runs.iter().filter(|run| run.verdict.accepted).count();
    }

    /// Notes how far the accepted model of a run is from the truth, in half widths of its intervals.
    pub fn take_model(&mut self, run: u32, distances: [f64; 3]) {
        self.models.take(distances);
        if let Some((parameter, distance)) = too_far(distances) {
            self.broken.push(format!(
                "run {run} is accepted with {parameter} {distance:.2} half widths from the truth"
            ));
        }
    }
}

/// What the trial is of.
pub fn about(world: &World) -> Campaign {
    Campaign {
        configuration: "world".into(),
        seed: Some(world.seed),
        ..Campaign::of("sim:starfish", &world.plan)
    }
}
