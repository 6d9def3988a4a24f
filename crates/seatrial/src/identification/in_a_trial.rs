//! What cures a reason in a trial, which has no columns, units and windows to be chosen.

use super::code::ReasonCode::*;
use super::code::ReasonKind;
use super::code::Subject::*;

/// The cure of a reason in a trial, where that of a log is of no use.
pub(super) fn cure(kind: &ReasonKind) -> Option<&'static str> {
    Some(match (&kind.code, &kind.of) {
        (TooFewSamples, None) => {
            "Plan a longer manoeuvre, or let the vehicle send its state faster."
        }
        (Damaged, Some(Samples)) => "Check the clock and the compass of the vehicle.",
        (SamplesMissing | ClockJitter, None) => {
            "Check the link to the vehicle, then repeat the run."
        }
        (SampledTooSeldom, Some(Time)) | (ClockJumped, None) | (UnitDoubtful, Some(Time)) => {
            "Check the clock of the vehicle, then repeat the run."
        }
        (SampledTooSeldom, None) => {
            "Let the vehicle send heading and rudder faster: ten samples in the time that a turn takes to die out."
        }
        (UnitDoubtful, Some(Heading)) | (CourseForHeading, None) => {
            "Check which heading the vehicle sends, and in which unit."
        }
        (UnitDoubtful | UnitUnknown, Some(Rudder)) => {
            "Check which angle the rudder has at full steering, and set it for this vehicle."
        }
        (YawRateContradicts, None) => "Check compass and gyro: one of them is wrong.",
        (SignReversed, Some(YawRate)) => {
            "Check how the gyro is mounted; the model does without it."
        }
        (LagUnknown, None) => {
            "Let the vehicle send the measured rudder angle, or put the lag of the servo into the plan."
        }
        (NotValidated, None) => "Repeat the run with a validation manoeuvre.",
        (ManoeuvresDiffer, Some(Speed)) => "Let the vehicle send its speed through the water.",
        _ => return None,
    })
}
