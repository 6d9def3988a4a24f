//! Validates a manoeuvre on its own legs where no other data do it.
//!
//! The model that is handed over comes from the whole manoeuvre. A second one, from its first legs alone, is simulated
//! over the remaining legs, which it has not seen. What that one fails at counts against both.

use super::{IdentifySettings, ValidationData, identify};
use crate::figures::r2_text;
use crate::identification::{Identification, Outcome, Reason, ReasonCode};
use crate::legs::{LegSplit, split_by_legs};
use crate::record::{Record, Window};

/// The identification of a window that nothing validated, validated by its own legs; as it was where the window holds too
/// few legs, or where its first legs alone give no model to judge by.
pub(super) fn validated_by_legs(
    whole: Identification,
    record: &Record,
    window: Window,
    settings: &IdentifySettings,
) -> Identification {
    let Some(split) = split_by_legs(&record.usable(window)) else {
        return whole;
    };
    let held_out = ValidationData {
        record,
        window: Window {
            to_s: window.to_s,
            ..split.validation
        },
    };
    match identify(record, split.training, Some(held_out), settings) {
        Ok(first_legs) => judged_by(first_legs, whole, &split),
        Err(_) => whole,
    }
}

/// The whole manoeuvre's identification with the validation of its first legs, and the verdict that follows.
fn judged_by(
    first_legs: Identification,
    mut whole: Identification,
    split: &LegSplit,
) -> Identification {
    let fails =
        |reason: &&Reason| matches!(reason.code, ReasonCode::LowR2 | ReasonCode::Contradicted);
    let failure = first_legs.verdict.reasons.iter().find(fails).cloned();
    let is_sound = first_legs.verdict.accepted;
    if failure.is_none() && !is_sound {
        return whole;
    }
    let was_refused = whole.verdict.outcome() == Outcome::DoNotUse;
    whole.validation = first_legs.validation;
    whole
        .verdict
        .reasons
        .retain(|reason| reason.code != ReasonCode::NotValidated);
    let found = failure.unwrap_or_else(|| {
        let r2 = first_legs.validation.and_then(|v| v.r2_heading_offset_refit);
        Reason::new(
            ReasonCode::Ok,
            format!(
                "a model of the first {} legs predicts the other {}: R^2 of heading with the offset estimated again {}",
                split.training_legs,
                split.validation_legs,
                r2_text(r2)
            ),
        )
    });
    let is_ok = found.code == ReasonCode::Ok;
    whole.verdict.accepted = is_ok && !was_refused;
    if !(is_ok && was_refused) {
        whole.verdict.reasons.insert(0, found);
    }
    whole
}
