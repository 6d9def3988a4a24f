//! Validates a manoeuvre on its own legs where no other data do it.
//!
//! The model that is handed over comes from the whole manoeuvre. A second one, from its first legs alone, is simulated
//! over the remaining legs, which it has not seen. Where that one may be used, the whole is validated.

use super::{ExaminedRecord, IdentifySettings, OrderSearch, ValidationData, identify_with};
use crate::figures::r2_text;
use crate::identification::{Identification, Outcome, Reason, ReasonCode};
use crate::legs::{LegSplit, split_by_legs};
use crate::record::Window;

/// The identification of a window that nothing validated, validated by its own legs; as it was where the window holds too
/// few legs, or where the other legs do not confirm a model of its first ones.
pub(super) fn validated_by_legs(
    whole: Identification,
    record: &ExaminedRecord,
    window: Window,
    settings: &IdentifySettings,
) -> Identification {
    let Some(split) = split_by_legs(&record.record().usable(window)) else {
        return whole;
    };
    let held_out = ValidationData {
        record: record.record(),
        window: Window {
            to_s: window.to_s,
            ..split.validation
        },
    };
    match identify_with(
        record,
        split.training,
        Some(held_out),
        settings,
        &[],
        OrderSearch::Skipped,
    ) {
        Ok((first_legs, _)) if first_legs.verdict.accepted => {
            confirmed_by(&first_legs, whole, &split)
        }
        _ => whole,
    }
}

/// The whole manoeuvre's identification with the validation of its first legs.
fn confirmed_by(
    first_legs: &Identification,
    mut whole: Identification,
    split: &LegSplit,
) -> Identification {
    let is_only_unvalidated = whole.verdict.outcome() == Outcome::NotValidated;
    whole.validation = first_legs.validation;
    let verdict = &mut whole.verdict;
    verdict
        .reasons
        .retain(|reason| reason.code != ReasonCode::NotValidated);
    if is_only_unvalidated {
        let r2 = first_legs
            .validation
            .and_then(|validation| validation.r2_heading_offset_refit);
        let confirmed = Reason::new(
            ReasonCode::Ok,
            format!(
                "a model of the first {} legs predicts the other {}: R^2 of heading with the offset estimated again {}",
                split.training_legs,
                split.validation_legs,
                r2_text(r2)
            ),
        );
        verdict.reasons.insert(0, confirmed);
        verdict.accepted = true;
    }
    whole
}
