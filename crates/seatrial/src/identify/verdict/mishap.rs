//! A jump of the heading or a stuck rudder as the cause of what the model does not explain.

use super::Weighing;
use crate::figures::{degrees, with_decimals};
use crate::identification::{Reason, ReasonCode, Subject};
use crate::identify::compass::Jump;
use crate::identify::mishap::Jam;
use crate::identify::model_evidence::ModelEvidence;
use crate::plausibility::Doubt;
use crate::record::rudder_text;

impl Weighing {
    /// The cause comes before what it led to.
    pub(super) fn mishaps(&mut self, evidence: &ModelEvidence) {
        let times_are_shared = evidence.log.times_are_shared;
        if let Some(jump) = evidence.log.jump_beside.filter(|_| !times_are_shared) {
            self.nothing_held_out(jump);
        }
        let Some(at) = self.rejections.iter().position(is_led_to) else {
            return;
        };
        if self.has(&ReasonCode::CompassError)
            || self.has(ReasonCode::SampledTooSeldom.of(Subject::Time))
        {
            return;
        }
        // A heading that went on while the time stood still did not jump.
        if let Some([_, interval_s]) = evidence.log.interval_s.filter(|_| times_are_shared) {
            let effect = 0.5 * interval_s * evidence.choice.model.a22_per_s.abs();
            let doubt = Doubt::TimesShared { interval_s, effect };
            return self.rejections.insert(at, doubt.reason());
        }
        let found = &evidence.mishaps;
        let jump = found.jump.map(|(jump, place)| heading_jump(jump, place));
        let jam = || {
            // What a sea does looks like a stuck rudder, too.
            let (jam, place) = found.jam.filter(|_| !evidence.is_in_a_sea())?;
            Some(rudder_jam(jam, place, &rudder_text(evidence.log.rudder_unit, jam.rudder_rad)))
        };
        if let Some(cause) = jump.or_else(jam) {
            self.rejections.insert(at, cause);
        }
    }

    fn nothing_held_out(&mut self, jump: Jump) {
        let reasons = self.rejections.iter_mut();
        for reason in reasons.filter(|r| r.code == ReasonCode::NotValidated) {
            reason.text = nothing_held_out_text(jump);
        }
    }
}

/// Why there is nothing to validate on.
fn nothing_held_out_text(jump: Jump) -> String {
    let (size, time) = (degrees(jump.size_rad), with_decimals(jump.time_s, 1));
    format!(
        "No data were held out to check the model: at {time} s the compass jumped by {size} deg, or was disturbed."
    )
}

/// Is it what a jump or a stuck rudder leads to?
fn is_led_to(reason: &Reason) -> bool {
    matches!(
        (&reason.code, &reason.of),
        (ReasonCode::Contradicted, _)
            | (
                ReasonCode::LowR2
                    | ReasonCode::NotIdentifiable
                    | ReasonCode::UnderExcited
                    | ReasonCode::DoesNotFit
                    | ReasonCode::Unstable
                    | ReasonCode::SampledTooSeldom
                    | ReasonCode::RudderNotFollowed,
                None
            )
    )
}

fn heading_jump(jump: Jump, place: &str) -> Reason {
    let (size, time) = (degrees(jump.size_rad), with_decimals(jump.time_s, 1));
    let reason = Reason::new(
        ReasonCode::CompassError,
        format!(
            "{place} the heading changes by {size} deg from one sample to the next, at {time} s, which no vehicle does: the compass jumped, stuck or was disturbed; repeat the run, away from iron and electric currents"
        ),
    );
    Reason {
        text: format!(
            "At {time} s the compass jumped, stuck or was disturbed: the heading changed by {size} deg at once."
        ),
        ..reason
    }
}

fn rudder_jam(jam: Jam, place: &str, rudder: &str) -> Reason {
    let from = with_decimals(jam.from_s, 1);
    let until = match jam.to_s {
        Some(to_s) => format!("until about {} s", with_decimals(to_s, 1)),
        None => "until the end".to_owned(),
    };
    let reason = Reason::new(
        ReasonCode::RudderNotFollowed.of(Subject::Rudder),
        format!(
            "the model explains the heading {place} where the rudder stays at {rudder} from {from} s {until}, whatever it was told, and not as it was told; log the measured rudder angle"
        ),
    );
    Reason {
        text: format!("The rudder seems to have stuck at {rudder} from {from} s {until}."),
        ..reason
    }
}
