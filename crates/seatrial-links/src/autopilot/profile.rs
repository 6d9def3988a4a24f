//! Kinds of autopilots: how each is steered, which mode that takes, which outputs are its rudder.

use seatrial_mavlink::ardupilot::{Parameters, Pulse, Steering};
use serde::{Deserialize, Serialize};

use crate::link::Message;
use crate::link::message::{Heartbeat, ManualControl, RcChannelsOverride};

/// `MAV_AUTOPILOT` and `MAV_TYPE` of a heartbeat.
const ARDUPILOT: u8 = 3;
const PX4: u8 = 12;
const GROUND_ROVER: u8 = 10;
const SURFACE_BOAT: u8 = 11;
const SUBMARINE: u8 = 12;
/// A channel that an override leaves alone.
const IGNORE: u16 = u16::MAX;
/// Outputs of SERVO_OUTPUT_RAW.
const OUTPUTS: usize = 16;
/// `SERVOn_FUNCTION` of ArduSub's first motor.
const MOTOR_1: f64 = 33.0;
/// What the four horizontal motors of ArduSub's vectored frames do about the yaw axis.
pub(super) const SUB_YAW: [f64; 4] = [1.0, -1.0, -1.0, 1.0];

/// A kind of autopilot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Profile {
    /// ArduPilot Rover, a boat: RC_CHANNELS_OVERRIDE in MANUAL.
    Rover,
    /// ArduSub: MANUAL_CONTROL in MANUAL.
    Sub,
    /// PX4: MANUAL_CONTROL in Manual.
    Px4,
    /// Any other: MANUAL_CONTROL in the mode that it is in.
    Generic,
}

/// What the vehicle is asked for, as fractions of full.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Demand {
    /// Positive to starboard.
    pub steer: f64,
    pub thrust: f64,
}

impl Profile {
    /// By what a vehicle says of itself.
    pub fn of(heartbeat: &Heartbeat) -> Self {
        match (heartbeat.autopilot, heartbeat.kind) {
            (ARDUPILOT, GROUND_ROVER | SURFACE_BOAT) => Self::Rover,
            (ARDUPILOT, SUBMARINE) => Self::Sub,
            (PX4, _) => Self::Px4,
            _ => Self::Generic,
        }
    }

    /// For people.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rover => "ArduPilot Rover",
            Self::Sub => "ArduSub",
            Self::Px4 => "PX4",
            Self::Generic => "an autopilot of another kind",
        }
    }

    /// `custom_mode` in which the rudder follows us directly.
    pub(super) fn steering_mode(self) -> Option<u32> {
        match self {
            Self::Rover => Some(0),
            Self::Sub => Some(19),
            Self::Px4 => Some(1 << 16),
            Self::Generic => None,
        }
    }

    /// A `custom_mode` by the name that its ground stations give it, with its number.
    pub(super) fn mode_text(self, mode: u32) -> String {
        let names: &[(u32, &str)] = match self {
            Self::Rover => &[
                (0, "Manual"),
                (1, "Acro"),
                (3, "Steering"),
                (4, "Hold"),
                (5, "Loiter"),
                (6, "Follow"),
                (7, "Simple"),
                (10, "Auto"),
                (11, "RTL"),
                (12, "Smart RTL"),
                (15, "Guided"),
            ],
            Self::Sub => &[
                (0, "Stabilize"),
                (1, "Acro"),
                (2, "Depth Hold"),
                (3, "Auto"),
                (4, "Guided"),
                (7, "Circle"),
                (9, "Surface"),
                (16, "Position Hold"),
                (19, "Manual"),
            ],
            Self::Px4 => &[(1 << 16, "Manual")],
            Self::Generic => &[],
        };
        let known = names.iter().find(|(number, _)| *number == mode);
        match known {
            Some((_, name)) => format!("{name} ({mode})"),
            None => format!("number {mode}"),
        }
    }

    /// `custom_mode` in which the autopilot steers to headings that are sent to it.
    pub(super) fn heading_mode(self) -> Option<u32> {
        match self {
            Self::Rover => Some(15),
            Self::Sub => Some(2),
            Self::Px4 | Self::Generic => None,
        }
    }

    /// `custom_mode` in which it follows no heading of ours any more: Rover does nothing, Sub holds the heading that it has.
    pub(super) fn idle_mode(self) -> Option<u32> {
        match self {
            Self::Rover => Some(4),
            Self::Sub => Some(0),
            Self::Px4 | Self::Generic => None,
        }
    }

    /// Does a vehicle of this kind float, and need satellites for its speed?
    pub(super) fn is_boat(self) -> bool {
        self == Self::Rover
    }

    /// Parameters that are read, and whether it is ArduPilot that must have them.
    pub(super) fn parameters(self) -> &'static [&'static str] {
        match self {
            Self::Rover => &[
                "RC1_MIN",
                "RC1_TRIM",
                "RC1_MAX",
                "RC1_DZ",
                "RC1_REVERSED",
                "RC3_MIN",
                "RC3_TRIM",
                "RC3_MAX",
                "RC3_DZ",
                "RC3_REVERSED",
                "RC_OVERRIDE_TIME",
                "FS_GCS_ENABLE",
                "FS_ACTION",
                "SCHED_LOOP_RATE",
            ],
            Self::Sub => {
                &["RC_OVERRIDE_TIME", "FS_GCS_ENABLE", "FS_PILOT_INPUT", "SCHED_LOOP_RATE"]
            }
            Self::Px4 => &["COM_RC_LOSS_T"],
            Self::Generic => &[],
        }
    }

    /// Is it ArduPilot?
    pub(super) fn is_ardupilot(self) -> bool {
        matches!(self, Self::Rover | Self::Sub)
    }

    /// The message that asks for this.
    pub(super) fn demand(self, demand: Demand, parameters: &Parameters, system: u8) -> Message {
        let full = |fraction: f64| (1000.0 * fraction.clamp(-1.0, 1.0)).round() as i16;
        let (steer, thrust) = (full(demand.steer), full(demand.thrust));
        let stick = |x, y, z, r| {
            Message::from(ManualControl { x, y, z, r, buttons: 0, target_system: system })
        };
        match self {
            Self::Rover => {
                let pulse = |prefix, fraction| Stick::of(parameters, prefix).pulse_us(fraction);
                override_of(pulse("RC1", demand.steer), pulse("RC3", demand.thrust), system)
            }
            Self::Sub => stick(thrust, 0, 500, steer),
            Self::Px4 => stick(0, steer, 500 + thrust / 2, steer),
            Self::Generic => stick(0, steer, thrust, 0),
        }
    }

    /// The message that gives the controls back to a remote control; `None` where nothing but silence does.
    pub(super) fn release(self, system: u8) -> Option<Message> {
        match self {
            Self::Rover => Some(override_of(0, 0, system)),
            // ArduSub makes overrides of the first eight out of MANUAL_CONTROL.
            Self::Sub => Some(override_with([0; 8], system)),
            Self::Px4 | Self::Generic => None,
        }
    }

    /// Channels of the remote control that we hold, from 0.
    pub(super) fn is_ours(self, channel: usize) -> bool {
        match self {
            Self::Rover => matches!(channel, 0 | 2),
            // It reports the remote control itself, whatever MANUAL_CONTROL asks for.
            Self::Px4 => false,
            // MANUAL_CONTROL fills the first eight.
            Self::Sub | Self::Generic => channel < 8,
        }
    }
}

fn override_of(steer_us: u16, throttle_us: u16, system: u8) -> Message {
    let mut pulses = [IGNORE; 8];
    (pulses[0], pulses[2]) = (steer_us, throttle_us);
    override_with(pulses, system)
}

fn override_with(pulses: [u16; 8], system: u8) -> Message {
    Message::from(RcChannelsOverride { pulses, target_system: system, target_component: 0 })
}

/// A stick of the remote control, with its dead zone.
struct Stick {
    pulse: Pulse,
    dead_us: f64,
}

impl Stick {
    fn of(parameters: &Parameters, prefix: &str) -> Self {
        Self {
            pulse: Pulse::of(parameters, prefix),
            dead_us: parameters.get(&format!("{prefix}_DZ")).unwrap_or(0.0),
        }
    }

    /// ```text
    /// trim + dead + f (max - trim - dead)  above,  trim - dead + f (trim - dead - min)  below
    /// ```
    /// so that the autopilot, which takes the dead zone out, finds the fraction f.
    fn pulse_us(&self, fraction: f64) -> u16 {
        let Pulse { lowest_us, trim_us, highest_us, is_reversed } = self.pulse;
        let fraction = fraction.clamp(-1.0, 1.0) * if is_reversed { -1.0 } else { 1.0 };
        let dead_us = self.dead_us * fraction.signum() * f64::from(fraction != 0.0);
        let full_us = if fraction >= 0.0 {
            highest_us - trim_us - dead_us
        } else {
            trim_us + dead_us - lowest_us
        };
        (trim_us + dead_us + fraction * full_us).round() as u16
    }
}

/// What of the outputs is the rudder.
#[derive(Clone, Debug)]
pub(super) enum Rudder {
    /// As the autopilot's parameters say.
    Known(Steering),
    /// A sum of outputs: number from 1, pulse, share.
    Sum(Vec<(usize, Pulse, f64)>),
}

/// Outputs that steer, as the operator says: numbers from 1, negative where more pulse is less rudder.
#[derive(Clone, Debug, PartialEq)]
pub struct SteeringOutputs {
    /// The outputs; several share the rudder evenly.
    pub outputs: Vec<i8>,
    /// Shortest, neutral and longest pulse, us.
    pub pulses_us: [f64; 3],
}

impl Rudder {
    /// As the operator says, or else as the parameters do.
    pub fn find(
        profile: Profile,
        parameters: &Parameters,
        given: Option<&SteeringOutputs>,
    ) -> Option<Self> {
        if let Some(given) = given {
            let [lowest_us, trim_us, highest_us] = given.pulses_us;
            let share = 1.0 / given.outputs.len().max(1) as f64;
            let outputs = given.outputs.iter().map(|output| {
                let pulse = Pulse { lowest_us, trim_us, highest_us, is_reversed: false };
                let number = usize::from(output.unsigned_abs());
                (number, pulse, share * f64::from(output.signum()))
            });
            return Some(Self::Sum(outputs.collect()));
        }
        if profile == Profile::Sub {
            let motors = SUB_YAW.iter().enumerate().map(|(motor, yaw)| {
                let number = parameters.output_with(MOTOR_1 + motor as f64, OUTPUTS)?;
                let direction = parameters.get(&format!("MOT_{}_DIRECTION", motor + 1));
                let pulse = Pulse::of(parameters, &format!("SERVO{number}"));
                Some((number, pulse, yaw * direction.unwrap_or(1.0) / 4.0))
            });
            return motors.collect::<Option<Vec<_>>>().map(Self::Sum);
        }
        Steering::find(parameters, OUTPUTS).map(Self::Known)
    }

    /// As a fraction of full, positive to starboard.
    pub fn fraction(&self, pulse_us: impl Fn(usize) -> f64) -> f64 {
        match self {
            Self::Known(steering) => steering.fraction(pulse_us),
            Self::Sum(outputs) => outputs
                .iter()
                .map(|(number, pulse, share)| share * pulse.fraction(pulse_us(*number)))
                .sum(),
        }
    }

    /// For people.
    pub fn text(&self) -> String {
        match self {
            Self::Known(steering) => steering.text(),
            Self::Sum(outputs) => outputs
                .iter()
                .map(|(number, pulse, share)| format!("{share:+} SERVO{number} ({})", pulse.text()))
                .collect::<Vec<_>>()
                .join(" "),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_the_dead_zone_is_stepped_over() {
        let stick = Stick {
            pulse: Pulse {
                lowest_us: 1000.0,
                trim_us: 1500.0,
                highest_us: 1900.0,
                is_reversed: false,
            },
            dead_us: 30.0,
        };
        let pulses = [-1.0, -0.5, 0.0, 0.5, 1.0].map(|f| stick.pulse_us(f));
        assert_eq!(pulses, [1000, 1235, 1500, 1715, 1900]);
    }

    #[test]
    fn exact_a_release_leaves_all_but_two_channels_alone() {
        let Some(Message::RcChannelsOverride(release)) = Profile::Rover.release(1) else {
            panic!("no release");
        };
        let ignore = u16::MAX;
        assert_eq!(release.pulses, [0, ignore, 0, ignore, ignore, ignore, ignore, ignore]);
    }
}
