//! Validates a manoeuvre on its own parts where no other data do it.
//!
//! The model that is handed over comes from the whole manoeuvre. A second one, from its first legs alone, is simulated
//! over the remaining legs, which it has not seen. Where that one may be used, the whole is validated. Else each fifth of a record of more than a
//! doublet is predicted by a model of the other four: where none is predicted badly, the whole is validated.

use super::mission::LEAST_STROKES;
use super::steering_validation::simulated;
use super::{IdentifySettings, OrderSearch, RecordSurvey, ValidationData, identify_with};
use crate::figures::r2_text;
use crate::identification::{Identification, LEAST_R2, Outcome, Reason, ReasonCode, Validation};
use crate::legs::{LegSplit, split_by_legs};
use crate::likelihood::BLOCKS;
use crate::likelihood::leg::deviation;
use crate::manoeuvre::Manoeuvre;
use crate::record::{Window, duration_s};
use crate::record_series::RecordSeries;
use seatrial_core::{Real, Sample};

/// The identification of a window that nothing validated, validated by its own legs; as it was where the window holds too
/// few legs, or where the other legs do not confirm a model of its first ones.
pub(super) fn validated_by_legs(
    whole: Identification,
    record: &RecordSurvey,
    window: Window,
    settings: &IdentifySettings,
) -> Identification {
    let samples = record.record().usable(window);
    let Some(split) = split_by_legs(&samples) else {
        return validated_by_fifths(whole, &samples);
    };
    let held_out = ValidationData {
        record: record.record(),
        window: Window { to_s: window.to_s, ..split.validation },
    };
    match identify_with(record, split.training, Some(held_out), settings, &[], OrderSearch::Skipped)
    {
        Ok((first_legs, _)) if first_legs.verdict.accepted => {
            confirmed_by(&first_legs, whole, &split)
        }
        _ => validated_by_fifths(whole, &samples),
    }
}

/// The identification validated by the fifths that the engine left out, where a model of the others predicts each.
fn validated_by_fifths(whole: Identification, samples: &[Sample<f64>]) -> Identification {
    let is_only_unvalidated = whole.verdict.outcome() == Outcome::NotValidated;
    let hull = whole.higher_order.as_ref().filter(|_| is_only_unvalidated);
    let left_out = hull.and_then(|hull| hull.least_r2_left_out);
    let Some(left_out) = left_out.filter(|r2| *r2 > LEAST_R2) else {
        return whole;
    };
    let strokes = Manoeuvre::find(samples).map_or(0, |m| m.strokes.len());
    let r2 = r2_over_fifths(&whole, samples);
    if r2.is_none_or(|r2| r2 <= LEAST_R2) || strokes < LEAST_STROKES {
        return whole;
    }
    let validation = Validation {
        window: whole.training,
        r2_heading: r2,
        r2_heading_offset_refit: r2,
        r2_yaw_rate: None,
        samples: samples.len(),
        horizon_s: Some(duration_s(samples) / BLOCKS as f64),
    };
    let how = format!(
        "each fifth of the record is predicted by a model of the others: R^2 of heading at least {}",
        r2_text(Some(left_out))
    );
    validated(whole, Some(validation), how)
}

/// R^2 of the heading of the model that is handed over, which starts again with each fifth, its offset too.
fn r2_over_fifths(found: &Identification, samples: &[Sample<f64>]) -> Option<f64> {
    let (mut left, mut all) = (0.0, 0.0);
    for fifth in samples.chunks(samples.len().div_ceil(BLOCKS).max(1)) {
        let errors = (fifth.iter().zip(simulated(found, fifth, true)))
            .map(|(sample, state)| (sample.heading_rad - state.heading_rad).wrapped());
        left += errors.map(|error| error * error).sum::<f64>();
        let headings = RecordSeries::new(fifth, 1).heading_rad;
        all += deviation(&headings).powi(2) * headings.len() as f64;
    }
    (all > 0.0).then(|| 1.0 - left / all)
}

/// The whole manoeuvre's identification with the validation of its first legs.
fn confirmed_by(
    first_legs: &Identification,
    whole: Identification,
    split: &LegSplit,
) -> Identification {
    let validation = first_legs.validation;
    let r2 = validation.and_then(|validation| validation.r2_heading_offset_refit);
    let how = format!(
        "a model of the first {} legs predicts the other {}: R^2 of heading with the offset estimated again {}",
        split.training_legs,
        split.validation_legs,
        r2_text(r2)
    );
    validated(whole, validation, how)
}

/// The identification with a validation; accepted where nothing else was missing.
fn validated(
    mut whole: Identification,
    validation: Option<Validation>,
    how: String,
) -> Identification {
    let is_only_unvalidated = whole.verdict.outcome() == Outcome::NotValidated;
    whole.validation = validation;
    let verdict = &mut whole.verdict;
    verdict.reasons.retain(|reason| reason.code != ReasonCode::NotValidated);
    if is_only_unvalidated {
        verdict.reasons.insert(0, Reason::new(ReasonCode::Ok, how));
        verdict.accepted = true;
    }
    whole
}
