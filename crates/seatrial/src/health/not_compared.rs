//! Why a model or a window cannot be compared with the reference.

use seatrial_core::schedule::ScheduleError;

/// Why a model or a window cannot be compared with the reference.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub(super) enum NotCompared {
    #[error("its speed is not known, and the reference has several")]
    SpeedUnknown,
    #[error("the reference has several thrusts, but knows the speed of none")]
    ReferenceWithoutSpeed,
    #[error("{0}")]
    OutsideSchedule(ScheduleError),
    #[error("the speed is not within {:.0} % of the reference's, {speeds}", 100.0 * .share)]
    TooFarInSpeed { share: f64, speeds: Speeds },
    #[error("its numbers are not finite")]
    NotFinite,
    #[error("too few samples in a window")]
    TooFewSamples,
    #[error("samples are missing")]
    SamplesMissing,
    /// Why most windows show nothing.
    #[error("the rudder hardly moves")]
    NotExcited,
    #[error("the speed is not steady")]
    SpeedNotSteady,
    #[error("waves, current or thrusters turn the vehicle too much beside the rudder")]
    Disturbed,
}

/// The speeds of a reference, m/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Speeds {
    pub(super) slowest: f64,
    /// `None` where there is only one.
    pub(super) fastest: Option<f64>,
}

impl std::fmt::Display for Speeds {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let slowest = self.slowest;
        match self.fastest {
            None => write!(f, "{slowest:.2} m/s"),
            Some(fastest) => write!(f, "{slowest:.2} to {fastest:.2} m/s"),
        }
    }
}
