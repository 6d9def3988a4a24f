//! Why a vehicle is given back before the trial is over.

use thiserror::Error;

/// Why a vehicle on ROS 2 is given back before the trial is over.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Stop {
    /// The operator asked for it, here.
    #[error("the operator asked for it")]
    Operator,
    /// Somebody called a service.
    #[error("the service {0} was called")]
    Called(String),
    /// The vehicle sends nothing.
    #[error("no sample has come from the vehicle for {0:.1} s")]
    Silence(f64),
    /// Stamps went back.
    #[error("the clock of the stamps was set back by {0:.1} s")]
    ClockSetBack(f64),
    /// The commands have no taker.
    #[error("nobody subscribes to {0} any more")]
    NotHeard(String),
    /// Both would steer.
    #[error("somebody else publishes on {0}, too")]
    SecondPublisher(String),
    /// The measured rudder does something else than asked for.
    #[error(
        "the rudder does not follow: asked for {asked_rad:.3} rad, it is at {found_rad:.3} rad"
    )]
    NotFollowed {
        /// Asked for.
        asked_rad: f64,
        /// Measured.
        found_rad: f64,
    },
}

impl Stop {
    /// Did a person ask for it?
    pub fn is_asked(&self) -> bool {
        matches!(self, Self::Operator | Self::Called(_))
    }
}
