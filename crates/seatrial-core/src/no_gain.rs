//! Why there is no heading controller.

use core::fmt;

/// Why a model gives no gain or no analysis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum NoGain {
    /// a22 is 0 or positive: a proportional gain alone cannot damp the heading.
    CourseUnstable,
    /// b2 is 0: the rudder does nothing.
    NoAuthority,
    /// The gain turns the vehicle away from the desired heading.
    WrongSign,
    /// The damping ratio is not a positive number.
    DampingRatio,
    /// The rudder limit is not a positive number.
    RudderLimit,
    /// The delay or the sample interval is negative or not finite, or the interval is 0.
    Timing,
    /// A parameter is NaN or infinite.
    NonFinite,
}

impl fmt::Display for NoGain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::CourseUnstable => {
                "the vehicle is course unstable, or may be: a22, or the damping that a gain has to allow for, is not negative, \
                 a proportional gain alone cannot stabilise it and K_p = a22^2/(4 zeta^2 b2) does not hold; rate feedback is needed"
            }
            Self::NoAuthority => "b2 is 0: the rudder does not turn the vehicle",
            Self::WrongSign => "K_p b2 is not positive: the gain turns the vehicle away from the desired heading",
            Self::DampingRatio => "the damping ratio must be a positive number",
            Self::RudderLimit => "the rudder limit must be a positive number",
            Self::Timing => "delay and sample interval must be finite and not negative, the interval not 0",
            Self::NonFinite => "a parameter is not finite",
        })
    }
}

impl core::error::Error for NoGain {}
