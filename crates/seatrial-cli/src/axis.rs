//! The option `--axis`.

use seatrial_core::Axis;

/// Which motion is identified.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum AxisOption {
    /// Heading under the rudder.
    Yaw,
    /// Pitch under the elevator.
    Pitch,
}

impl From<AxisOption> for Axis {
    fn from(option: AxisOption) -> Self {
        match option {
            AxisOption::Yaw => Self::Yaw,
            AxisOption::Pitch => Self::Pitch,
        }
    }
}
