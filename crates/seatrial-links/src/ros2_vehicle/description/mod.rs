//! What a vehicle on ROS 2 is: its topics, types, signs, limits, as a file says them.

mod check;

use std::collections::BTreeMap;
use std::net::{IpAddr, Ipv4Addr};

use serde::Deserialize;

use super::Demand;
pub use check::InvalidDescription;

/// A vehicle on ROS 2.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Description {
    /// `ROS_DOMAIN_ID`; where it is left out, that of the environment.
    #[serde(default = "domain_of_environment")]
    pub domain: u16,
    /// What stands before the names of our node, services and topics, as in `/boat`.
    #[serde(default)]
    pub namespace: String,
    /// Addresses of this machine that are announced and on which multicast is used.
    #[serde(default = "loopback")]
    pub addresses: Vec<IpAddr>,
    /// Where there is one, the vehicle is reached over zenoh instead of DDS.
    pub zenoh: Option<Zenoh>,
    /// Agreed to: the sockets of DDS take packets on every address of this machine, whatever is announced.
    #[serde(default)]
    pub listens_on_all_addresses: bool,
    /// How the vehicle's middleware carries services.
    #[serde(default)]
    pub services: Middleware,
    /// Axes of attitude and position.
    #[serde(default)]
    pub frame: Frame,
    /// The vehicle itself lets go of its rudder so long after the last command, s.
    pub command_timeout_s: f64,
    /// Odometry.
    pub odometry: Option<Odometry>,
    /// An attitude sensor; where there is one, a sample is one of its messages.
    pub imu: Option<Source>,
    /// The command that steers.
    pub rudder: RudderCommand,
    /// The command that drives.
    pub thrust: Option<ThrustCommand>,
    /// Commands that steer and drive at once, as of two thrusters, or several that steer, as of fins; by names of their own.
    #[serde(default)]
    pub actuators: BTreeMap<String, Actuator>,
    /// The rudder as it is.
    pub feedback: Option<Feedback>,
    /// A service of the vehicle that gives its controls away and takes them back.
    pub enable: Option<Enable>,
}

/// 0 where the environment says nothing, as in ROS 2; what is no number is refused by its range.
fn domain_of_environment() -> u16 {
    std::env::var("ROS_DOMAIN_ID").map_or(0, |domain| domain.trim().parse().unwrap_or(u16::MAX))
}

fn loopback() -> Vec<IpAddr> {
    vec![Ipv4Addr::LOCALHOST.into()]
}

/// How a vehicle is reached over zenoh. Nothing here listens: all links are called.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Zenoh {
    /// The router, or a vehicle that listens.
    #[serde(default = "router")]
    pub endpoint: String,
    /// How links are used.
    #[serde(default)]
    pub mode: ZenohMode,
    /// Do names end with hashes of their types? They do since Iron, on Humble they do not.
    #[serde(default = "yes")]
    pub type_hashes: bool,
}

/// How links of zenoh are used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ZenohMode {
    /// Everything passes through the endpoint.
    #[default]
    Client,
    /// Others, of whom the endpoint tells, are called, too.
    Peer,
}

fn router() -> String {
    "tcp/127.0.0.1:7447".into()
}

fn yes() -> bool {
    true
}

/// Which middleware's naming of services a vehicle uses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Middleware {
    /// `rmw_fastrtps`, the default of most distributions.
    #[default]
    FastRtps,
    /// `rmw_cyclonedds`.
    CycloneDds,
}

/// Axes of attitude and position.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Frame {
    /// East, north, up; body forward, port, up (REP 103).
    #[default]
    Enu,
    /// North, east, down; body forward, starboard, down.
    Ned,
}

/// A topic that is listened to.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Source {
    /// Its name.
    pub topic: String,
    /// Is a lost message sent again? Needs a publisher that offers it.
    #[serde(default)]
    pub reliable: bool,
}

/// `nav_msgs/Odometry`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Odometry {
    /// Its name.
    pub topic: String,
    /// Is a lost message sent again?
    #[serde(default)]
    pub reliable: bool,
    /// Is its vertical position the depth?
    #[serde(default)]
    pub depth: bool,
}

/// Types of commands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
pub enum CommandType {
    /// A number.
    #[default]
    #[serde(rename = "std_msgs/Float64")]
    Float64,
    /// A number.
    #[serde(rename = "std_msgs/Float32")]
    Float32,
    /// Numbers, as controllers of ros2_control take them.
    #[serde(rename = "std_msgs/Float64MultiArray")]
    Float64MultiArray,
    /// Linear and angular.
    #[serde(rename = "geometry_msgs/Twist")]
    Twist,
    /// A speed and a turn rate, with a stamp.
    #[serde(rename = "geometry_msgs/TwistStamped")]
    TwistStamped,
}

impl CommandType {
    const TWIST: [&'static str; 6] =
        ["linear.x", "linear.y", "linear.z", "angular.x", "angular.y", "angular.z"];
    /// The longest array that is published.
    const MOST_NUMBERS: usize = 16;

    /// Where a field stands among the numbers of a message.
    fn index(self, field: &str) -> Option<usize> {
        match self {
            Self::Float64 | Self::Float32 => (field == "data").then_some(0),
            Self::Float64MultiArray => {
                let number = field.strip_prefix("data[")?.strip_suffix(']')?;
                let index = number.parse().ok()?;
                (index < Self::MOST_NUMBERS).then_some(index)
            }
            Self::Twist | Self::TwistStamped => Self::TWIST.iter().position(|name| *name == field),
        }
    }

    fn expected(self) -> &'static str {
        match self {
            Self::Float64 | Self::Float32 => "data",
            Self::Float64MultiArray => "data[0] to data[15]",
            Self::Twist | Self::TwistStamped => "linear.x to angular.z",
        }
    }

    fn default_field(self, of_twist: &'static str) -> &'static str {
        match self {
            Self::Float64 | Self::Float32 => "data",
            Self::Float64MultiArray => "data[0]",
            Self::Twist | Self::TwistStamped => of_twist,
        }
    }

    fn least_numbers(self) -> usize {
        match self {
            Self::Twist | Self::TwistStamped => 6,
            _ => 1,
        }
    }
}

/// The command that steers: `trim_units + units_per_rad rudder`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RudderCommand {
    /// Its topic; none where actuators steer.
    pub topic: Option<String>,
    /// Its type.
    #[serde(default, rename = "type")]
    pub kind: CommandType,
    /// The field of the type [data; data\[0\]; angular.z].
    pub field: Option<String>,
    /// Units of the command for a rudder of one radian; negative where the command counts the other way.
    #[serde(default = "one")]
    pub units_per_rad: f64,
    /// The command of a rudder amidships.
    #[serde(default)]
    pub trim_units: f64,
    /// Full rudder, rad.
    pub limit_rad: f64,
}

/// The command that drives: `neutral_units + (units_at_full - neutral_units) thrust`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ThrustCommand {
    /// Its topic.
    pub topic: String,
    /// Its type.
    #[serde(default, rename = "type")]
    pub kind: CommandType,
    /// The field of the type [data; data\[0\]; linear.x].
    pub field: Option<String>,
    /// The command of full thrust.
    #[serde(default = "one")]
    pub units_at_full: f64,
    /// The command of no thrust.
    #[serde(default)]
    pub neutral_units: f64,
}

/// A command of rudder and thrust: `neutral_units + units_per_rad rudder + (units_at_full - neutral_units) thrust`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Actuator {
    /// Its topic.
    pub topic: String,
    /// Its type.
    #[serde(default, rename = "type")]
    pub kind: CommandType,
    /// The field of the type [data; data\[0\]; angular.z].
    pub field: Option<String>,
    /// Units of the command for a rudder of one radian; 0 of one that does not steer.
    #[serde(default)]
    pub units_per_rad: f64,
    /// The command of full thrust; none of one that does not drive.
    pub units_at_full: Option<f64>,
    /// The command of no thrust and a rudder amidships.
    #[serde(default)]
    pub neutral_units: f64,
}

impl Actuator {
    fn field(&self) -> &str {
        let default = self.kind.default_field("angular.z");
        self.field.as_deref().unwrap_or(default)
    }

    fn units(&self, demand: Demand) -> f64 {
        let span = self.units_at_full.unwrap_or(self.neutral_units) - self.neutral_units;
        self.neutral_units + self.units_per_rad * demand.rudder_rad + span * demand.thrust
    }
}

/// The rudder as it is.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Feedback {
    /// Its topic.
    pub topic: String,
    /// Its type.
    #[serde(default, rename = "type")]
    pub kind: FeedbackType,
    /// The joint, in `sensor_msgs/JointState` only.
    pub joint: Option<String>,
    /// Units for a rudder of one radian.
    #[serde(default = "one")]
    pub units_per_rad: f64,
    /// What it says amidships.
    #[serde(default)]
    pub trim_units: f64,
    /// Is a lost message sent again?
    #[serde(default)]
    pub reliable: bool,
}

impl Feedback {
    /// Rudder, rad.
    pub fn rudder_rad(&self, units: f64) -> f64 {
        (units - self.trim_units) / self.units_per_rad
    }
}

/// Types of feedback.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
pub enum FeedbackType {
    /// Positions of joints, with a stamp.
    #[default]
    #[serde(rename = "sensor_msgs/JointState")]
    JointState,
    /// A number without a stamp: the time of its arrival counts.
    #[serde(rename = "std_msgs/Float64")]
    Float64,
    /// A number without a stamp: the time of its arrival counts.
    #[serde(rename = "std_msgs/Float32")]
    Float32,
}

/// A service of `std_srvs/SetBool`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Enable {
    /// Its name.
    pub service: String,
}

fn one() -> f64 {
    1.0
}

/// Numbers on their way to a topic.
#[derive(Clone, Debug, PartialEq)]
pub struct Command {
    /// The topic.
    pub topic: String,
    /// Its type.
    pub kind: CommandType,
    /// The fields of the type, one after the other.
    pub numbers: Vec<f64>,
}

impl Description {
    /// Everything that is commanded, by its section.
    fn actuators(&self) -> Vec<(String, Actuator)> {
        let rudder = self.rudder.topic.as_ref().map(|topic| {
            let actuator = Actuator {
                topic: topic.clone(),
                kind: self.rudder.kind,
                field: self.rudder.field.clone(),
                units_per_rad: self.rudder.units_per_rad,
                units_at_full: None,
                neutral_units: self.rudder.trim_units,
            };
            ("rudder".to_owned(), actuator)
        });
        let thrust = self.thrust.as_ref().map(|thrust| {
            let default = thrust.kind.default_field("linear.x");
            let actuator = Actuator {
                topic: thrust.topic.clone(),
                kind: thrust.kind,
                field: Some(thrust.field.as_deref().unwrap_or(default).to_owned()),
                units_per_rad: 0.0,
                units_at_full: Some(thrust.units_at_full),
                neutral_units: thrust.neutral_units,
            };
            ("thrust".to_owned(), actuator)
        });
        let others = self.actuators.iter();
        let others = others.map(|(name, actuator)| (format!("actuators.{name}"), actuator.clone()));
        rudder.into_iter().chain(thrust).chain(others).collect()
    }

    /// What a demand is on the wire, a message for each topic.
    pub fn commands(&self, demand: Demand) -> Vec<Command> {
        let limit_rad = self.rudder.limit_rad;
        let demand = Demand {
            rudder_rad: demand.rudder_rad.clamp(-limit_rad, limit_rad),
            thrust: demand.thrust.clamp(0.0, 1.0),
        };
        let mut commands: BTreeMap<String, Command> = BTreeMap::new();
        for (_, actuator) in self.actuators() {
            let kind = actuator.kind;
            let Some(index) = kind.index(actuator.field()) else {
                continue;
            };
            let value = actuator.units(demand);
            let topic = actuator.topic;
            let command = commands.entry(topic.clone()).or_insert_with(|| Command {
                topic,
                kind,
                numbers: vec![0.0; kind.least_numbers()],
            });
            if command.numbers.len() <= index {
                command.numbers.resize(index + 1, 0.0);
            }
            command.numbers[index] = value;
        }
        commands.into_values().collect()
    }

    /// The topics of commands, each once, and their types.
    pub fn command_topics(&self) -> Vec<(String, CommandType)> {
        let commands = self.commands(Demand::default());
        commands.into_iter().map(|command| (command.topic, command.kind)).collect()
    }

    /// A name of ours in the namespace.
    pub fn named(&self, name: &str) -> String {
        format!("{}{name}", self.namespace)
    }
}

/// Is this a whole name, as the rules of ROS 2 for topics and services have it?
fn is_absolute_name(name: &str) -> bool {
    let is_token = |token: &str| {
        token.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
            && token.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
            && !token.contains("__")
    };
    name.len() < 256 && name.strip_prefix('/').is_some_and(|rest| rest.split('/').all(is_token))
}
