//! May a model be used, and why: the verdict and its reasons.

use std::fmt;

use serde::ser::SerializeStruct;
use serde::{Deserialize, Serialize, Serializer};

/// What a person may do with a model. In documents its name is in snake case: `use_with_care`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// Use it.
    Use,
    /// Use it inside the stated range; a reason names what limits it.
    UseWithCare,
    /// It fits its training record, and nothing was held out to check it.
    NotValidated,
    /// Do not use it.
    DoNotUse,
}

impl Outcome {
    /// The outcome as people read it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Use => "use",
            Self::UseWithCare => "use with care",
            Self::NotValidated => "not validated",
            Self::DoNotUse => "do not use",
        }
    }
}

/// May the model be used, and why. In documents it carries its [`outcome`](Verdict::outcome), too.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Verdict {
    /// Yes or no.
    pub accepted: bool,
    /// At least one. Where the model is not accepted, what rejects it comes first, and that it was not validated after
    /// all else that does.
    pub reasons: Vec<Reason>,
}

impl Serialize for Verdict {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut fields = serializer.serialize_struct("Verdict", 3)?;
        fields.serialize_field("accepted", &self.accepted)?;
        fields.serialize_field("outcome", &self.outcome())?;
        fields.serialize_field("reasons", &self.reasons)?;
        fields.end()
    }
}

impl Verdict {
    /// A verdict of one rejecting reason.
    pub fn refused(reason: Reason) -> Self {
        Self {
            accepted: false,
            reasons: vec![reason],
        }
    }

    /// What a person may do with the model.
    pub fn outcome(&self) -> Outcome {
        let first = self.reasons.first().map(|reason| &reason.code);
        match (self.accepted, first) {
            (false, Some(ReasonCode::NotValidated)) => Outcome::NotValidated,
            (false, _) => Outcome::DoNotUse,
            (true, _) if self.reasons.iter().any(|reason| reason.code.limits()) => {
                Outcome::UseWithCare
            }
            (true, _) => Outcome::Use,
        }
    }

    /// Is this among its reasons?
    pub fn has(&self, code: &ReasonCode) -> bool {
        self.reasons.iter().any(|reason| reason.code == *code)
    }
}

/// One reason of a verdict.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reason {
    /// Short and stable, for programs.
    pub code: ReasonCode,
    /// For people: what was measured and what to do.
    pub text: String,
}

impl Reason {
    /// A reason with its text.
    pub fn new(code: ReasonCode, text: impl Into<String>) -> Self {
        let text = text.into();
        Self { code, text }
    }
}

/// What was decided about a model or a run. In documents its name is in snake case: `too_few_samples`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ReasonCode {
    /// The model may be used.
    Ok,
    /// The training window holds too few usable samples.
    TooFewSamples,
    /// The rudder did not move.
    RudderConstant,
    /// The heading did not move.
    HeadingConstant,
    /// The record does not determine the model.
    NotIdentifiable,
    /// The intervals are too wide.
    UnderExcited,
    /// The model does not describe its own training record.
    DoesNotFit,
    /// a22 is not negative.
    Unstable,
    /// Online and refined estimates are far apart.
    Disagreement,
    /// A rudder lag that the log does not contain would matter.
    LagUnknown,
    /// The prediction errors of the first-order model are not white.
    ResidualNotWhite,
    /// The rudder moved far while samples were missing.
    SamplesMissing,
    /// A first-order model does not explain the record.
    ModelOrder,
    /// Something other than the rudder turned the vehicle.
    Disturbed,
    /// b2 is negative.
    SignReversed,
    /// Samples were rejected.
    RejectedSamples,
    /// The speed changed within the training.
    SpeedDrifted,
    /// A channel is logged too seldom for this vehicle.
    SampledTooSeldom,
    /// Intervals between samples are uneven.
    ClockJitter,
    /// The rudder stopped short of the angle that was asked for.
    RudderSaturated,
    /// The heading comes in coarse steps.
    Quantised,
    /// The heading parts from where the yaw rate takes it.
    CompassError,
    /// The heading changes by more or less than the yaw rate says.
    CompassDeviation,
    /// The heading is later than the yaw rate.
    CompassLate,
    /// R^2 on validation data is too low.
    LowR2,
    /// There were no validation data.
    NotValidated,
    /// The offset changed between training and validation.
    OffsetDrifted,
    /// Validation data by themselves give another model.
    Contradicted,
    /// Validation data are too uncertain to show a wrong model.
    WeaklyValidated,
    /// Validation data use more rudder than the training.
    Extrapolating,
    /// Manoeuvres of one speed differ by more than chance explains.
    ManoeuvresDiffer,
    /// The speed falls although thrust rises.
    SpeedFalls,
    /// b2 changes over speed in a way that one vehicle's does not.
    AuthorityChanged,
    /// a22 changes over speed in a way that one vehicle's does not.
    DampingChanged,
    /// The heading's numbers are not in the unit that its column says.
    HeadingUnitDoubtful,
    /// The rudder's numbers are not in the unit that its column says.
    RudderUnitDoubtful,
    /// Nothing tells in which unit the rudder is.
    RudderScaleUnknown,
    /// The time is not in the unit that its column says.
    TimeUnitDoubtful,
    /// The yaw rate contradicts heading and time.
    YawRateContradicts,
    /// The yaw rate has the opposite sense of the heading.
    YawRateReversed,
    /// Samples are too far apart for the vehicle.
    LoggedTooSlowly,
    /// The heading is refreshed more slowly than rows are written.
    HeadingHeld,
    /// The rudder is refreshed more slowly than rows are written.
    RudderHeld,
    /// There is no yaw rate to compare the heading with.
    HeadingUnchecked,
    /// Nothing shows whether the rudder goes where its column says.
    RudderUnchecked,
    /// The trial was aborted.
    Aborted,
    /// The run was not finished.
    Interrupted,
    /// An operator accepted the run.
    AcceptedByOperator,
    /// An operator rejected the run.
    RejectedByOperator,
    /// The vehicle is as it was.
    Unchanged,
    /// The vehicle is different.
    Changed,
    /// The data would not show a change worth knowing.
    CannotTell,
    /// A code that this version does not know, from a document that another version wrote.
    #[serde(untagged)]
    Other(String),
}

impl ReasonCode {
    /// Does it limit what an accepted model may be used for?
    fn limits(&self) -> bool {
        !matches!(
            self,
            Self::Ok
                | Self::SignReversed
                | Self::RejectedSamples
                | Self::Quantised
                | Self::YawRateReversed
                | Self::HeadingUnchecked
                | Self::RudderUnchecked
                | Self::AcceptedByOperator
                | Self::Unchanged
        )
    }
}

impl fmt::Display for ReasonCode {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        self.serialize(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_the_outcome_follows_from_the_reasons() {
        let verdict = |accepted, codes: &[ReasonCode]| Verdict {
            accepted,
            reasons: codes
                .iter()
                .map(|code| Reason::new(code.clone(), ""))
                .collect(),
        };
        use ReasonCode::{LowR2, ModelOrder, NotValidated, Ok, SignReversed};
        for (verdict, outcome) in [
            (verdict(true, &[Ok, SignReversed]), Outcome::Use),
            (verdict(true, &[Ok, ModelOrder]), Outcome::UseWithCare),
            (
                verdict(false, &[NotValidated, ModelOrder]),
                Outcome::NotValidated,
            ),
            (verdict(false, &[LowR2, NotValidated]), Outcome::DoNotUse),
        ] {
            assert_eq!(verdict.outcome(), outcome, "{verdict:?}");
            let json = serde_json::to_value(&verdict).unwrap();
            assert_eq!(json["outcome"], serde_json::to_value(outcome).unwrap());
            assert_eq!(serde_json::from_value::<Verdict>(json).unwrap(), verdict);
        }
    }

    #[test]
    fn io_codes_are_in_snake_case_and_unknown_ones_are_kept() {
        for (code, name) in [
            (ReasonCode::LowR2, "low_r2"),
            (ReasonCode::ClockJitter, "clock_jitter"),
            (ReasonCode::Other("of_tomorrow".into()), "of_tomorrow"),
        ] {
            assert_eq!(code.to_string(), name);
            let json = serde_json::to_string(&code).unwrap();
            assert_eq!(json, format!("\"{name}\""));
            assert_eq!(serde_json::from_str::<ReasonCode>(&json).unwrap(), code);
        }
    }
}
