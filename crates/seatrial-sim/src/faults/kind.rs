//! Which faults there are and what they take.

use serde::{Deserialize, Serialize};

/// A number that a kind of fault takes.
#[derive(Clone, Copy, Debug)]
pub struct Parameter {
    /// Its name in a file.
    pub name: &'static str,
    /// Where a file leaves it out.
    pub default: f64,
    /// The least and the greatest that can be played.
    pub range: [f64; 2],
    /// From where to where it is drawn by chance.
    pub usual: [f64; 2],
}

/// The numbers of a fault, in the order of [`Kind::parameters`].
pub(super) type Values = [f64; 2];

const fn parameter(
    name: &'static str,
    default: f64,
    range: [f64; 2],
    usual: [f64; 2],
) -> Parameter {
    Parameter { name, default, range, usual }
}

const ANGLE: [f64; 2] = [-core::f64::consts::PI, core::f64::consts::PI];
const SPEED: [f64; 2] = [-5.0, 5.0];

macro_rules! kinds {
    ($(#[$attribute:meta])* $($kind:ident $name:literal [$($parameter:expr),*];)*) => {
        $(#[$attribute])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
        #[serde(rename_all = "snake_case")]
        #[expect(missing_docs, reason = "the table above")]
        pub enum Kind { $($kind,)* }

        impl Kind {
            /// Every kind.
            pub const ALL: [Self; [$($name,)*].len()] = [$(Self::$kind,)*];

            /// Its name in a file.
            pub fn name(self) -> &'static str {
                match self { $(Self::$kind => $name,)* }
            }

            /// What it takes, at most two numbers.
            pub fn parameters(self) -> &'static [Parameter] {
                match self { $(Self::$kind => const { &[$($parameter),*] },)* }
            }
        }
    };
}

kinds! {
    /// A kind of fault.
    ///
    /// | kind | parameter | what happens while it lasts |
    /// |---|---|---|
    /// | `compass_freeze` | | the compass repeats its last reading |
    /// | `compass_spike` | `size_rad`, `every_s` | single readings are off by this, one each so many seconds |
    /// | `compass_step` | `size_rad` | the compass is off by this |
    /// | `compass_drift` | `rate_rad_s` | the compass runs away at this rate |
    /// | `compass_dropout` | | the compass gives no number |
    /// | `depth_loss` | | no depth is measured |
    /// | `rudder_jam` | | the rudder stays where it is |
    /// | `rudder_offset` | `angle_rad` | the rudder stands off its command by this |
    /// | `rudder_reversed` | | the rudder goes the other way |
    /// | `lost_fin` | `fraction` | this part of the rudders' area is gone, the first fin's first |
    /// | `thrust_loss` | `fraction` | this part of the thrust setting is lost |
    /// | `payload_change` | `inertia_factor` | the moment of inertia in yaw, water included, is times this |
    /// | `current_step` | `north_m_s`, `east_m_s` | this comes on top of the current |
    /// | `clock_jump` | `by_s` | the clock is ahead by this, or behind |
    /// | `duplicated_samples` | `every` | each n-th sample arrives twice |
    /// | `reordered_samples` | `every` | each n-th sample arrives after the one that follows it |
    /// | `link_loss` | | no sample arrives, though commands do; for ever, the link reports it |
    /// | `operator_takeover` | | the vehicle's operator steers, and commands are ignored |
    ///
    /// The vehicle's own heading controller steers by the same compass. A rudder that does not do what it is told to
    /// is not in the samples, which say what was commanded.
    CompassFreeze "compass_freeze" [];
    CompassSpike "compass_spike" [parameter("size_rad", 1.0, ANGLE, [-2.0, 2.0]), parameter("every_s", 2.0, [0.0, 1e6], [0.2, 5.0])];
    CompassStep "compass_step" [parameter("size_rad", 0.5, ANGLE, [-1.0, 1.0])];
    CompassDrift "compass_drift" [parameter("rate_rad_s", 0.02, [-1.0, 1.0], [-0.1, 0.1])];
    CompassDropout "compass_dropout" [];
    DepthLoss "depth_loss" [];
    RudderJam "rudder_jam" [];
    RudderOffset "rudder_offset" [parameter("angle_rad", 0.05, [-0.5, 0.5], [-0.15, 0.15])];
    RudderReversed "rudder_reversed" [];
    LostFin "lost_fin" [parameter("fraction", 0.5, [0.0, 1.0], [0.1, 1.0])];
    ThrustLoss "thrust_loss" [parameter("fraction", 0.5, [0.0, 1.0], [0.1, 1.0])];
    PayloadChange "payload_change" [parameter("inertia_factor", 1.3, [0.7, 10.0], [0.75, 1.6])];
    CurrentStep "current_step" [parameter("north_m_s", 0.3, SPEED, [-0.5, 0.5]), parameter("east_m_s", 0.3, SPEED, [-0.5, 0.5])];
    ClockJump "clock_jump" [parameter("by_s", 1.0, [-1e9, 1e9], [-5.0, 5.0])];
    DuplicatedSamples "duplicated_samples" [parameter("every", 5.0, [2.0, 1e6], [2.0, 20.0])];
    ReorderedSamples "reordered_samples" [parameter("every", 5.0, [2.0, 1e6], [2.0, 20.0])];
    LinkLoss "link_loss" [];
    OperatorTakeover "operator_takeover" [];
}

impl Kind {
    /// The kind of a name.
    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }
}
