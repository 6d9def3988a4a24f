//! Codes of the reasons of a verdict.

use std::fmt;

use serde::{Deserialize, Serialize};

/// What was decided about a model or a run. In documents its name is in snake case: `too_few_samples`.
///
/// Causes are added: a program that answers to some has an answer to the others.
///
/// ```
/// use seatrial::identification::ReasonCode;
///
/// let next = |code| match code {
///     ReasonCode::RudderConstant => "move the rudder",
///     _ => "read the verdict",
/// };
/// assert_eq!(next(ReasonCode::RudderConstant), "move the rudder");
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
    /// The rudder did not move, or hardly.
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
    /// The speed changed within the training, or from there to the validation.
    SpeedDrifted,
    /// A channel is logged too seldom for this vehicle.
    SampledTooSeldom,
    /// Intervals between samples are uneven.
    ClockJitter,
    /// Rows that differ share a time.
    TimesShared,
    /// The clock jumped.
    ClockJumped,
    /// The rudder stopped short of the angle that was asked for.
    RudderSaturated,
    /// The rudder stayed where it was, whatever it was told.
    RudderJammed,
    /// The rudder seems to have play.
    RudderPlay,
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
    /// The elevator did not move.
    ElevatorConstant,
    /// The pitch is not damped: a is not negative.
    PitchUndamped,
    /// The elevator does not explain the pitch.
    PitchNotExplained,
    /// Manoeuvres of one speed differ by more than chance explains.
    ManoeuvresDiffer,
    /// Manoeuvres differ, and the log does not tell at which speed each was made.
    SpeedUnknown,
    /// A speed that was tried has no model.
    SpeedMissing,
    /// A fault of the vehicle spoiled a run that was then repeated.
    RunRepeated,
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
    /// The yaw rate is later than the heading.
    YawRateLate,
    /// The column of the heading names a course over ground.
    CourseForHeading,
    /// The heading is refreshed more slowly than rows are written.
    HeadingHeld,
    /// The rudder is refreshed more slowly than rows are written.
    RudderHeld,
    /// There is no yaw rate to compare the heading with.
    HeadingUnchecked,
    /// Nothing shows whether the rudder goes where its column says.
    RudderUnchecked,
    /// Nothing shows whether a row takes a second, as the column of the time says.
    TimeUnchecked,
    /// A part of the log or of the logbook is damaged.
    Damaged,
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
    /// Does it name a fault of compass, clock or rudder, of which a low R^2 is a consequence?
    pub(crate) fn is_fault(&self) -> bool {
        matches!(
            self,
            Self::CompassError
                | Self::CompassDeviation
                | Self::CompassLate
                | Self::ClockJumped
                | Self::RudderJammed
        )
    }

    /// Does it say that the vehicle, or what measures it, did not do what a sound one does?
    pub(crate) fn is_of_the_vehicle(&self) -> bool {
        self.is_fault()
            || matches!(
                self,
                Self::LowR2 | Self::Contradicted | Self::DoesNotFit | Self::Disagreement
            )
    }

    /// Does it limit what an accepted model may be used for?
    pub(crate) fn limits(&self) -> bool {
        !matches!(
            self,
            Self::Ok
                | Self::SignReversed
                | Self::RejectedSamples
                | Self::Quantised
                | Self::YawRateReversed
                | Self::YawRateLate
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
