//! Why a vehicle is given back before the trial is over.

use seatrial_core::AbortReason;
use thiserror::Error;

/// Why a vehicle is given back before the trial is over.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Stop {
    /// The operator asked for it.
    #[error("the operator asked for it")]
    Operator,
    /// The autopilot sends nothing.
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
    /// The vehicle was disarmed.
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
    /// This program was busy with something else for so long, s, while it had the rudder.
    #[error("the trial was held up for {0:.1} s")]
    NotAttended(f64),
    /// Outputs come this far apart, s, so that nobody knows when the rudder moved.
    #[error(
        "SERVO_OUTPUT_RAW comes every {:.0} ms, less than half as often as before the trial: when the rudder moves is not known",
        1e3 * .0
    )]
    RareOutputs(f64),
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
    /// As the trial knows it.
    pub fn reason(&self) -> AbortReason {
        match self {
            Self::Operator => AbortReason::Operator,
            Self::Silence(_) => AbortReason::LinkLost,
            Self::Rebooted => AbortReason::Restarted,
            Self::PilotMode(_) => AbortReason::ModeChanged,
            Self::PilotStick(_) => AbortReason::StickMoved,
            Self::Disarmed => AbortReason::Disarmed,
            Self::Battery(_) => AbortReason::LowBattery,
            Self::Failsafe(_) => AbortReason::Failsafe,
            Self::SecondStation(_) => AbortReason::SecondStation,
            Self::NotAttended(_) => AbortReason::NotAttended,
            Self::RareOutputs(_) => AbortReason::StaleSamples,
            Self::NotFollowed { .. } => AbortReason::RudderNotFollowed,
        }
    }

    /// Is it the pilot, who now has the vehicle and chose its mode?
    pub fn is_pilot(&self) -> bool {
        matches!(self, Self::PilotMode(_) | Self::PilotStick(_) | Self::Disarmed)
    }
}
