//! Codes of the reasons of a verdict.

use std::fmt;

use serde::{Deserialize, Serialize};

/// What was decided about a model or a run; [of what](super::Subject) a reason says beside it. In documents its name is in snake case:
/// `too_few_samples`.
///
/// Causes are added: a program that answers to some has an answer to the others.
///
/// ```
/// use seatrial::identification::ReasonCode;
///
/// let next = |code| match code {
///     ReasonCode::TooFewSamples => "log faster",
///     _ => "read the verdict",
/// };
/// assert_eq!(next(ReasonCode::TooFewSamples), "log faster");
/// ```
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum ReasonCode {
    /// The model may be used.
    Ok,
    /// The log is of an aircraft.
    NotAVessel,
    /// The training window holds too few usable samples.
    TooFewSamples,
    /// Rudder, heading or elevator did not move, or hardly.
    Constant,
    /// The record does not determine the model.
    NotIdentifiable,
    /// The manoeuvre was too small: the intervals are too wide, or validation data are too uncertain to show a wrong model.
    UnderExcited,
    /// The model does not describe its own training record.
    DoesNotFit,
    /// The motion is not damped: a22, or a of pitch, is not negative.
    Unstable,
    /// A rudder lag that the log does not contain would matter.
    LagUnknown,
    /// The rudder moved far while samples were missing.
    SamplesMissing,
    /// A first-order model does not explain the record, or its prediction errors are not white.
    ModelOrder,
    /// Something other than the rudder turned the vehicle.
    Disturbed,
    /// The rudder (b2 is negative) or the yaw rate has the opposite sense of the heading.
    SignReversed,
    /// Speed or offset changed within the training, or from there to the validation.
    Drifted,
    /// A channel is logged too seldom for this vehicle, or refreshed more slowly than rows are written.
    SampledTooSeldom,
    /// Intervals between samples are uneven.
    ClockJitter,
    /// The clock jumped.
    ClockJumped,
    /// The rudder stopped short of the angle that was asked for, stuck, or follows through a linkage with play.
    RudderNotFollowed,
    /// The heading comes in coarse steps.
    Quantised,
    /// The heading parts from where the yaw rate takes it.
    CompassError,
    /// Heading or yaw rate is later than the other.
    Late,
    /// R^2 on validation data is too low.
    LowR2,
    /// There were no validation data.
    NotValidated,
    /// Other data, or another way to estimate, give another model.
    Contradicted,
    /// Validation data use more rudder than the training.
    Extrapolating,
    /// Manoeuvres of one speed, or of speeds that the log does not tell, differ by more than chance explains.
    ManoeuvresDiffer,
    /// A speed that was tried has no model.
    SpeedMissing,
    /// A fault of the vehicle spoiled a run that was then repeated.
    RunRepeated,
    /// Speed, b2 or a22 changes over the thrust in a way that one vehicle's does not.
    SpeedsDiffer,
    /// The numbers of a channel are not in the unit that its column says.
    UnitDoubtful,
    /// Nothing tells in which unit a channel is.
    UnitUnknown,
    /// The yaw rate contradicts heading and time.
    YawRateContradicts,
    /// The column of the heading names a course over ground.
    CourseForHeading,
    /// Nothing in the log shows whether a channel is right.
    Unchecked,
    /// Samples of the log, or a part of log or logbook, are damaged.
    Damaged,
    /// The trial was aborted.
    Aborted,
    /// The run was not finished.
    Interrupted,
    /// An operator accepted the run.
    AcceptedByOperator,
    /// An operator rejected the run.
    RejectedByOperator,
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
