//! Which faults there are and what they take.

use serde::{Deserialize, Serialize};

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
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[expect(missing_docs, reason = "the table above")]
pub enum Kind {
    CompassFreeze,
    CompassSpike,
    CompassStep,
    CompassDrift,
    CompassDropout,
    DepthLoss,
    RudderJam,
    RudderOffset,
    RudderReversed,
    LostFin,
    ThrustLoss,
    PayloadChange,
    CurrentStep,
    ClockJump,
    DuplicatedSamples,
    ReorderedSamples,
    LinkLoss,
    OperatorTakeover,
}

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
    Parameter {
        name,
        default,
        range,
        usual,
    }
}

impl Kind {
    /// Every kind.
    pub const ALL: [Self; 18] = [
        Self::CompassFreeze,
        Self::CompassSpike,
        Self::CompassStep,
        Self::CompassDrift,
        Self::CompassDropout,
        Self::DepthLoss,
        Self::RudderJam,
        Self::RudderOffset,
        Self::RudderReversed,
        Self::LostFin,
        Self::ThrustLoss,
        Self::PayloadChange,
        Self::CurrentStep,
        Self::ClockJump,
        Self::DuplicatedSamples,
        Self::ReorderedSamples,
        Self::LinkLoss,
        Self::OperatorTakeover,
    ];

    /// Its name in a file.
    pub fn name(self) -> &'static str {
        match self {
            Self::CompassFreeze => "compass_freeze",
            Self::CompassSpike => "compass_spike",
            Self::CompassStep => "compass_step",
            Self::CompassDrift => "compass_drift",
            Self::CompassDropout => "compass_dropout",
            Self::DepthLoss => "depth_loss",
            Self::RudderJam => "rudder_jam",
            Self::RudderOffset => "rudder_offset",
            Self::RudderReversed => "rudder_reversed",
            Self::LostFin => "lost_fin",
            Self::ThrustLoss => "thrust_loss",
            Self::PayloadChange => "payload_change",
            Self::CurrentStep => "current_step",
            Self::ClockJump => "clock_jump",
            Self::DuplicatedSamples => "duplicated_samples",
            Self::ReorderedSamples => "reordered_samples",
            Self::LinkLoss => "link_loss",
            Self::OperatorTakeover => "operator_takeover",
        }
    }

    /// The kind of a name.
    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// What it takes, at most two numbers.
    pub fn parameters(self) -> &'static [Parameter] {
        const ANGLE: [f64; 2] = [-core::f64::consts::PI, core::f64::consts::PI];
        const SPEED: [f64; 2] = [-5.0, 5.0];
        const EVERY: [Parameter; 1] = [parameter("every", 5.0, [2.0, 1e6], [2.0, 20.0])];
        match self {
            Self::CompassSpike => {
                const {
                    &[
                        parameter("size_rad", 1.0, ANGLE, [-2.0, 2.0]),
                        parameter("every_s", 2.0, [0.0, 1e6], [0.2, 5.0]),
                    ]
                }
            }
            Self::CompassStep => const { &[parameter("size_rad", 0.5, ANGLE, [-1.0, 1.0])] },
            Self::CompassDrift => {
                const { &[parameter("rate_rad_s", 0.02, [-1.0, 1.0], [-0.1, 0.1])] }
            }
            Self::RudderOffset => {
                const { &[parameter("angle_rad", 0.05, [-0.5, 0.5], [-0.15, 0.15])] }
            }
            Self::LostFin => const { &[parameter("fraction", 0.5, [0.0, 1.0], [0.1, 1.0])] },
            Self::ThrustLoss => const { &[parameter("fraction", 0.5, [0.0, 1.0], [0.1, 1.0])] },
            Self::PayloadChange => {
                const { &[parameter("inertia_factor", 1.3, [0.7, 10.0], [0.75, 1.6])] }
            }
            Self::CurrentStep => {
                const {
                    &[
                        parameter("north_m_s", 0.3, SPEED, [-0.5, 0.5]),
                        parameter("east_m_s", 0.3, SPEED, [-0.5, 0.5]),
                    ]
                }
            }
            Self::ClockJump => const { &[parameter("by_s", 1.0, [-1e9, 1e9], [-5.0, 5.0])] },
            Self::DuplicatedSamples | Self::ReorderedSamples => &EVERY,
            Self::CompassFreeze
            | Self::CompassDropout
            | Self::DepthLoss
            | Self::RudderJam
            | Self::RudderReversed
            | Self::LinkLoss
            | Self::OperatorTakeover => &[],
        }
    }
}
