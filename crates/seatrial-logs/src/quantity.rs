//! The quantities of a sample and the names that columns give them.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::unit::{Dimension, Unit};

/// A quantity of a [`Sample`](seatrial_core::Sample).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// Time of the sample.
    Time,
    /// Heading psi.
    Heading,
    /// Rudder angle delta, or the command to its servo.
    Rudder,
    /// Forward speed.
    Speed,
    /// Depth below the surface.
    Depth,
    /// Height above the bottom.
    Altitude,
    /// Roll phi.
    Roll,
    /// Pitch theta.
    Pitch,
    /// Measured yaw rate r.
    YawRate,
    /// Position north of the origin.
    North,
    /// Position east of the origin.
    East,
    /// Thrust that is asked for.
    Thrust,
}

impl Quantity {
    /// Every quantity, the needed ones first.
    pub const ALL: [Self; 12] = [
        Self::Time,
        Self::Heading,
        Self::Rudder,
        Self::Speed,
        Self::Depth,
        Self::Altitude,
        Self::Roll,
        Self::Pitch,
        Self::YawRate,
        Self::North,
        Self::East,
        Self::Thrust,
    ];

    /// `yaw_rate`
    pub fn name(self) -> &'static str {
        match self {
            Self::Time => "time",
            Self::Heading => "heading",
            Self::Rudder => "rudder",
            Self::Speed => "speed",
            Self::Depth => "depth",
            Self::Altitude => "altitude",
            Self::Roll => "roll",
            Self::Pitch => "pitch",
            Self::YawRate => "yaw_rate",
            Self::North => "north",
            Self::East => "east",
            Self::Thrust => "thrust",
        }
    }

    /// What a log cannot do without it, as the end of a sentence.
    pub(crate) fn without(self) -> &'static str {
        match self {
            Self::Rudder => {
                "; if none holds the rudder, this log cannot tell how the boat steers: record the rudder beside the heading"
            }
            _ => "",
        }
    }

    /// `--yaw-rate`, the option that chooses its column.
    pub fn option(self) -> String {
        format!("--{}", self.name().replace('_', "-"))
    }

    /// A row without it is no sample.
    pub fn is_required(self) -> bool {
        matches!(self, Self::Time | Self::Heading | Self::Rudder)
    }

    /// The units that its column may have.
    pub fn units(self) -> Vec<Unit> {
        Unit::that_measure(self.dimension())
    }

    pub(crate) fn dimension(self) -> Dimension {
        match self {
            Self::Time => Dimension::Time,
            Self::Heading | Self::Roll | Self::Pitch => Dimension::Angle,
            Self::Rudder => Dimension::Steering,
            Self::YawRate => Dimension::AngularRate,
            Self::Speed => Dimension::Speed,
            Self::Thrust => Dimension::Share,
            Self::Depth | Self::Altitude | Self::North | Self::East => Dimension::Length,
        }
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A text that is no quantity.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is no quantity of a log; expected one of {expected}", expected = Quantity::ALL.map(Quantity::name).join(", "))]
pub struct UnknownQuantity(pub String);

impl FromStr for Quantity {
    type Err = UnknownQuantity;

    fn from_str(text: &str) -> Result<Self, UnknownQuantity> {
        Self::ALL
            .into_iter()
            .find(|quantity| quantity.name() == text.replace('-', "_"))
            .ok_or_else(|| UnknownQuantity(text.into()))
    }
}
