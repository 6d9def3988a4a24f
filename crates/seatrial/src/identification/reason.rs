//! May a model be used, and why: the verdict and its reasons.

use std::fmt;

use serde::{Deserialize, Serialize};

/// May the model be used, and why.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// Yes or no.
    pub accepted: bool,
    /// At least one.
    pub reasons: Vec<Reason>,
}

impl Verdict {
    /// A verdict of one rejecting reason.
    pub fn refused(reason: Reason) -> Self {
        Self {
            accepted: false,
            reasons: vec![reason],
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
    /// A rudder lag that the log does not tell would matter.
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

impl fmt::Display for ReasonCode {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        self.serialize(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
