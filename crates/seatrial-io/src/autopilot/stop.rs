//! Why a vehicle is given back before the trial is over.

use thiserror::Error;

/// Why a vehicle is given back before the trial is over.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Stop {
    /// The operator asked for it.
    #[error("the operator asked for it")]
    Operator,
    /// Nothing comes from it.
    #[error("nothing has come from the vehicle for {0:.1} s")]
    Silence(f64),
    /// Its clock has started again.
    #[error("the autopilot has started again")]
    Rebooted,
    /// Somebody chose another mode.
    #[error("the pilot has changed the mode to {0}")]
    PilotMode(u32),
    /// Somebody moved a stick.
    #[error("the pilot has moved channel {0}")]
    PilotStick(usize),
    /// It was disarmed.
    #[error("the vehicle has been disarmed")]
    Disarmed,
    /// The battery is low.
    #[error("the battery is down to {0} %")]
    Battery(i8),
    /// A failsafe, in the autopilot's words.
    #[error("the autopilot reports: {0}")]
    Failsafe(String),
    /// Another ground station has our system id: both would steer.
    #[error("another ground station has our system id {0}")]
    SecondStation(u8),
    /// The output does something else than we ask for.
    #[error("the rudder output does not follow: asked for {asked:.2} of full, it is at {found:.2}")]
    NotFollowed {
        /// Asked for, as a fraction of full.
        asked: f64,
        /// Found.
        found: f64,
    },
}

impl Stop {
    /// Is it the pilot, who now has the vehicle and chose its mode?
    pub fn is_pilot(&self) -> bool {
        matches!(
            self,
            Self::PilotMode(_) | Self::PilotStick(_) | Self::Disarmed
        )
    }
}
