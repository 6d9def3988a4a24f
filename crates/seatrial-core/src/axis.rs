//! Which motion a trial identifies.

use crate::{GoodnessOfFit, Validation, real::Real};

/// The motion that a trial identifies. What the core calls heading and rudder are the angle and the control surface of
/// this axis.
///
/// | axis | `heading_rad` | `rudder_rad` | between manoeuvres the vehicle holds | model |
/// |---|---|---|---|---|
/// | yaw | heading, rad | rudder, rad | the heading of the action | psi'' = a22 psi' + b2 delta + C0 |
/// | pitch | pitch, rad, bow up | elevator, rad | its depth, whatever the heading of the action | theta'' = a theta' + m theta + b delta + c |
///
/// A vehicle on the axis of pitch holds its heading by itself. Its samples carry the pitch in
/// [`pitch_rad`](crate::Sample::pitch_rad), too, so that the envelope watches it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Axis {
    /// Heading under the rudder.
    #[default]
    Yaw,
    /// Pitch under the elevator.
    Pitch,
}

impl Axis {
    /// Is it yaw? A plan or a campaign of yaw does not write its axis.
    ///
    /// ```
    /// use seatrial_core::Axis;
    ///
    /// assert!(Axis::default().is_yaw() && !Axis::Pitch.is_yaw());
    /// ```
    pub fn is_yaw(&self) -> bool {
        *self == Self::Yaw
    }

    /// The angle in the words of people: `heading`, `pitch`.
    ///
    /// ```
    /// use seatrial_core::Axis;
    ///
    /// assert_eq!([Axis::Yaw.angle(), Axis::Pitch.angle()], ["heading", "pitch"]);
    /// ```
    pub fn angle(self) -> &'static str {
        match self {
            Self::Yaw => "heading",
            Self::Pitch => "pitch",
        }
    }

    /// The control surface in the words of people: `rudder`, `elevator`.
    ///
    /// ```
    /// use seatrial_core::Axis;
    ///
    /// assert_eq!([Axis::Yaw.surface(), Axis::Pitch.surface()], ["rudder", "elevator"]);
    /// ```
    pub fn surface(self) -> &'static str {
        match self {
            Self::Yaw => "rudder",
            Self::Pitch => "elevator",
        }
    }

    /// R^2 of a simulation of validation data. Pitch starts from any start: its trim depends on depth and speed.
    pub fn goodness_of_fit<T: Real>(self, validation: &Validation<T>) -> GoodnessOfFit<T> {
        match self {
            Self::Yaw => validation.goodness_of_fit(),
            Self::Pitch => validation.goodness_of_fit_from_any_start(),
        }
    }

    /// Does a model that simulates validation data this well hold? Pitch is judged with the offset estimated again.
    ///
    /// ```
    /// use seatrial_core::{Axis, GoodnessOfFit};
    ///
    /// // The trim of the validation differs from that of the training.
    /// let fit = GoodnessOfFit {
    ///     r2_heading: Some(0.2),
    ///     r2_heading_offset_refit: Some(0.9),
    ///     ..GoodnessOfFit::default()
    /// };
    /// assert!(Axis::Pitch.is_reached(&fit, 0.6));
    /// // Yaw wants the yaw rate beside it.
    /// assert!(!Axis::Yaw.is_reached(&fit, 0.6));
    /// ```
    pub fn is_reached<T: Real>(self, fit: &GoodnessOfFit<T>, least_r2: T) -> bool {
        match self {
            Self::Yaw => fit.reaches(least_r2),
            Self::Pitch => fit.r2_heading_offset_refit.is_some_and(|r2| r2 >= least_r2),
        }
    }
}
