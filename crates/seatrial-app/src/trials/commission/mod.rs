//! Gains put into an autopilot, proven by heading steps, kept or put back.
//!
//! ```text
//! propose  a model, the autopilot's own gains        -> other gains, what both are foreseen to do
//! conduct  steps with the old gains                  -> does the model tell what the boat did? if not, nothing is written
//!          write, a small step, full steps           -> kept, or the old gains back
//! ```
//!
//! The vehicle is always handed back with the gains that it was found with, unless the new ones were proven.

mod conduct;
mod contact;
mod own_loop;
mod proposal;
mod step_run;

use seatrial::gains::commission::{Against, Foreseen, ModelCheck, Response};
use seatrial_core::{AbortReason, CascadeSettings, Sample, SchedulePoint};
use serde::Serialize;

pub use conduct::{Order, Progress, conduct};
pub use contact::{
    AutopilotContact, GainsVehicle, Request, RestoreFile, RestoreResult, check_step, models_for,
};
pub use own_loop::{OwnLoop, OwnProposal, OwnSpeed, propose_own};
pub use proposal::{Control, Proposal, model_at, propose};
pub use seatrial_links::autopilot::PutBack;
pub use step_run::{Patience, StepDemand, StepRecord, StepRun};

/// A vehicle whose autopilot steers to headings by itself, taken for a commission.
pub trait GainsLease {
    /// The next sample; its rudder is the steering output in fractions of full.
    fn next_sample(&mut self) -> Result<Sample<f64>, ControlLoss>;

    /// Asks for a heading at the speed or the thrust of a model.
    fn steer_to(&mut self, heading_rad: f64, model: &SchedulePoint<f64>);

    /// Writes settings and reads them back.
    fn write(&mut self, settings: &CascadeSettings<f64>) -> Result<(), ControlLoss>;

    /// The settings that are in stay when the vehicle is handed back. How to undo that.
    fn keep(&mut self) -> Result<String, ControlLoss>;

    /// Hands the vehicle back; what could not be put back, and what to do.
    fn hand_back(&mut self) -> Option<String>;
}

/// Why a vehicle is ours no longer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{why}")]
pub struct ControlLoss {
    /// As a trial knows it, where it does.
    pub reason: Option<AbortReason>,
    /// In words.
    pub why: String,
}

/// What became of the gains.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "state")]
pub enum Ending {
    /// The new gains are proven and stay.
    Kept {
        /// How to undo that.
        undo: String,
    },
    /// The old gains are back: the new ones did worse than they may.
    PutBack {
        /// At the first small step already?
        at_small_step: bool,
        /// What spoke against the new ones.
        against: Vec<Against>,
    },
    /// Nothing was written: the model does not tell what the boat did with its old gains.
    Refused,
    /// It was stopped; the old gains are back.
    Aborted {
        /// Why, as a trial knows it, where it does.
        reason: Option<AbortReason>,
        /// In words.
        why: String,
    },
}

/// Everything that a commission found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CommissionResult {
    /// What became of the gains.
    pub ending: Ending,
    /// What could not be put back, and what to do.
    pub not_put_back: Option<String>,
    /// Does the model tell what the boat did with its old gains?
    pub model_check: Option<ModelCheck>,
    /// Steps with the old gains.
    pub old: Option<Response>,
    /// What they were foreseen to be.
    pub old_foreseen: Option<Foreseen>,
    /// The small step with the new gains.
    pub small: Option<Response>,
    /// Steps with the new gains.
    pub new: Option<Response>,
    /// What they were foreseen to be.
    pub new_foreseen: Option<Foreseen>,
}

impl CommissionResult {
    /// Which gains are in, why, and how to undo it, in one line.
    pub fn line(&self) -> String {
        match self.undo() {
            Some(undo) => format!("{}. To undo: {undo}", self.summary()),
            None => self.summary(),
        }
    }

    /// The command that brings the old gains back, where the new ones stay.
    pub fn undo(&self) -> Option<&str> {
        match &self.ending {
            Ending::Kept { undo } => Some(undo),
            _ => None,
        }
    }

    /// What to do where the new gains are not in. What could not be put back says so by itself.
    pub fn advice(&self) -> Option<&'static str> {
        match &self.ending {
            Ending::Kept { .. } => None,
            Ending::PutBack { at_small_step: true, .. } => Some(
                "The boat steers as before. Try again in calmer water and with nothing else at work on the computer; if it ends so again, run a new trial at this load and speed.",
            ),
            Ending::PutBack { .. } => Some(
                "The boat steers as before, with the better gains of the two. Try again in calmer water; if it ends so again, keep the old gains or run a new trial.",
            ),
            Ending::Refused => Some(
                "Run a trial on this boat as it is now loaded, and commission from that campaign.",
            ),
            Ending::Aborted { .. } => {
                Some("Remove the cause, then commission again: the boat steers as before.")
            }
        }
    }

    /// Which gains are in, and why.
    pub fn summary(&self) -> String {
        let line = match &self.ending {
            Ending::Kept { .. } => format!(
                "KEPT the new gains: {}",
                self.new.as_ref().map_or("proven".into(), response_text)
            ),
            Ending::PutBack { at_small_step, against } => {
                let reasons: Vec<String> = against.iter().map(ToString::to_string).collect();
                let at = if *at_small_step { " at the first small step" } else { "" };
                format!("PUT BACK the old gains{at}: {}", reasons.join("; "))
            }
            Ending::Refused => format!(
                "REFUSED, nothing was written: {}",
                self.model_check.as_ref().map_or("the model does not fit".into(), check_text)
            ),
            Ending::Aborted { why, .. } => {
                format!("ABORTED, the old gains are back: {why}")
            }
        };
        match &self.not_put_back {
            Some(what) => format!("{line}; {what}"),
            None => line,
        }
    }
}

/// A response for people.
pub fn response_text(response: &Response) -> String {
    let settled =
        response.settling_s.map_or("does not settle".into(), |s| format!("settles in {s:.1} s"));
    format!(
        "overshoot {:.0} %, {settled}, rudder {:.0} %/s",
        100.0 * response.overshoot,
        100.0 * response.activity_per_s
    )
}

/// What the model is found to be, for people.
pub fn check_text(check: &ModelCheck) -> String {
    match check {
        ModelCheck::Holds { scale, explained } => format!(
            "the boat turned {scale:.2} times as far as the model says, which explains {:.0} % of the heading",
            100.0 * explained
        ),
        ModelCheck::Fails { scale, explained } => format!(
            "the model is not this boat's: with the old gains the boat turned {scale:.2} times as far as the model says, which explains {:.0} % of the heading; run a trial on this boat and take its campaign",
            100.0 * explained
        ),
        ModelCheck::Undecided => "the boat was steered too little to tell".into(),
    }
}
