//! What messages of ROS mean, whatever file they come from.

mod schema;

use std::collections::BTreeMap;

pub(crate) use schema::{Schema, Wire, plain};

use crate::error::{Fault, clipped};
use crate::message_table::{Kind, Message};
use crate::name::{ColumnName, Fit, StatedUnit};
use crate::table::{Known, KnownChannel};
use crate::{Quantity, Unit};

/// Fields of all topics that are read: a file can give one definition to any number of topics.
const MOST_FIELDS: usize = 1 << 16;

/// Topics that are read.
#[derive(Default)]
pub(crate) struct Topics {
    pub kinds: Vec<Kind>,
    /// By the number that the file gives its topics.
    by_number: BTreeMap<u64, Topic>,
    /// Fields of all topics.
    fields: usize,
    wire: Wire,
    /// Types that were not understood.
    pub unknown: Vec<String>,
    pub undecoded: u64,
}

struct Topic {
    kind: usize,
    type_name: String,
    schema: Schema,
}

/// Types and fields that tell a quantity, the preferred one first. Signs and frames are those of REP 103.
fn fields_of(quantity: Quantity) -> &'static [&'static str] {
    match quantity {
        Quantity::Heading => &[
            "nav_msgs/Odometry:pose.pose.orientation.heading_rad",
            "sensor_msgs/Imu:orientation.heading_rad",
            "geometry_msgs/PoseStamped:pose.orientation.heading_rad",
            "geometry_msgs/PoseWithCovarianceStamped:pose.pose.orientation.heading_rad",
        ],
        Quantity::Rudder => &[
            "ackermann_msgs/AckermannDriveStamped:drive.steering_angle",
            "ackermann_msgs/AckermannDrive:steering_angle",
        ],
        Quantity::Roll => &[
            "nav_msgs/Odometry:pose.pose.orientation.roll_rad",
            "sensor_msgs/Imu:orientation.roll_rad",
            "geometry_msgs/PoseStamped:pose.orientation.roll_rad",
        ],
        Quantity::Pitch => &[
            "nav_msgs/Odometry:pose.pose.orientation.pitch_rad",
            "sensor_msgs/Imu:orientation.pitch_rad",
            "geometry_msgs/PoseStamped:pose.orientation.pitch_rad",
        ],
        Quantity::YawRate => &[
            "sensor_msgs/Imu:angular_velocity.yaw_rate_rad_s",
            "nav_msgs/Odometry:twist.twist.angular.yaw_rate_rad_s",
        ],
        Quantity::Speed => {
            &["nav_msgs/Odometry:twist.twist.linear.x", "geometry_msgs/TwistStamped:twist.linear.x"]
        }
        Quantity::North => {
            &["nav_msgs/Odometry:pose.pose.position.y", "geometry_msgs/PoseStamped:pose.position.y"]
        }
        Quantity::East => {
            &["nav_msgs/Odometry:pose.pose.position.x", "geometry_msgs/PoseStamped:pose.position.x"]
        }
        Quantity::Depth => &["marine_sensor_msgs/Depth:depth"],
        _ => &[],
    }
}

/// What ROS counts a quantity in.
fn unit_of(quantity: Quantity) -> Unit {
    match quantity {
        Quantity::Heading | Quantity::Rudder | Quantity::Roll | Quantity::Pitch => Unit::Radian,
        Quantity::YawRate => Unit::RadianPerSecond,
        Quantity::Speed => Unit::MetrePerSecond,
        _ => Unit::Metre,
    }
}

/// A header's time that is further from the recorder's is of another clock, s.
const MOST_LATENCY_S: f64 = 1.0;

/// Why a file without a topic that is read is refused, with the topics that it has, or else with what there is.
pub(crate) fn nothing_in(
    format: &'static str,
    expected: &str,
    others: &[String],
    nothing: &str,
) -> Fault {
    let found = match others {
        [] => nothing.to_owned(),
        others => others.join(", "),
    };
    Fault::NothingToRead { format, what: format!("expected {expected}, found {}", clipped(&found)) }
}

/// Types of one number, whose meaning is in the topic's name.
const PLAIN_NUMBERS: [&str; 2] = ["std_msgs/Float64", "std_msgs/Float32"];

impl Topics {
    /// None yet, of messages that are written so.
    #[cfg(feature = "containers")]
    pub fn of_wire(wire: Wire) -> Self {
        Self { wire, ..Self::default() }
    }

    /// Takes up a topic that has messages.
    pub fn add(&mut self, number: u64, topic: &str, type_name: &str, definition: &str) {
        let schema = Schema::parse(type_name, definition, self.wire);
        let Some(schema) =
            schema.filter(|schema| self.fields + schema.names().len() <= MOST_FIELDS)
        else {
            self.unknown.push(format!("{} ({})", clipped(topic), clipped(type_name)));
            return;
        };
        self.fields += schema.names().len();
        let name = topic.trim_start_matches('/').to_string();
        // A bag may give one topic several numbers.
        let existing = self.kinds.iter().position(|kind| kind.name == name);
        let kind = existing.unwrap_or(self.kinds.len());
        if existing.is_none() {
            self.kinds.push(Kind { name, fields: schema.names() });
        }
        let type_name = plain(type_name);
        let topic = Topic { kind, type_name, schema };
        self.by_number.insert(number, topic);
    }

    /// Decodes a message of a wanted topic. The time is that of its header, where this is of the recorder's
    /// clock, else of its recording.
    pub fn take(
        &mut self,
        number: u64,
        recorded_s: f64,
        body: &[u8],
        wanted: &[bool],
        message: &mut Message,
    ) -> bool {
        let Some(topic) = self.by_number.get(&number).filter(|topic| wanted[topic.kind]) else {
            return false;
        };
        match topic.schema.decode(body, &mut message.values) {
            Some(stamp_s) => {
                message.kind = topic.kind;
                let latency_s = |stamp_s: &f64| recorded_s - stamp_s;
                message.time_s = stamp_s
                    .filter(|stamp_s| latency_s(stamp_s).abs() < MOST_LATENCY_S)
                    .unwrap_or(recorded_s);
                true
            }
            None => {
                self.undecoded += 1;
                false
            }
        }
    }

    /// Topics that feed quantities by their types, and topics of one number by their names.
    pub fn known(&self) -> Known {
        let mut known = Known::default();
        for quantity in Quantity::ALL {
            let fields = fields_of(quantity).iter();
            for (type_name, field) in fields.filter_map(|field| field.split_once(':')) {
                for topic in self.topics().filter(|topic| topic.type_name == type_name) {
                    let column = format!("{}.{field}", self.kinds[topic.kind].name);
                    known.add(quantity, column, Some(unit_of(quantity)), "");
                }
            }
        }
        for quantity in Quantity::ALL.into_iter().filter(|q| *q != Quantity::Time) {
            self.add_plain_numbers(quantity, &mut known);
        }
        self.add_yaw_commands(&mut known);
        self.say_what_lacks(&mut known);
        known
    }

    fn topics(&self) -> impl Iterator<Item = &Topic> {
        self.by_number.values()
    }

    /// Topics of one number whose names fit a quantity.
    fn add_plain_numbers(&self, quantity: Quantity, known: &mut Known) {
        let plain = self.topics().filter(|topic| PLAIN_NUMBERS.contains(&topic.type_name.as_str()));
        let mut named: Vec<(Fit, String)> = plain
            .filter_map(|topic| {
                let name = &self.kinds[topic.kind].name;
                let fit = ColumnName::new(name).fit(quantity)?;
                Some((fit, format!("{name}.data")))
            })
            .collect();
        named.sort_by_key(|(fit, _)| fit.rank);
        let unit = match quantity {
            Quantity::Thrust => None,
            other => Some(unit_of(other)).filter(|unit| *unit != Unit::Radian),
        };
        for (fit, column) in named {
            let stated = match fit.unit {
                StatedUnit::Known(unit) => Some(unit),
                _ => unit,
            };
            known.add(quantity, column, stated, "");
        }
    }

    /// Yaw commands, which steer where no controller follows them.
    fn add_yaw_commands(&self, known: &mut Known) {
        let is_twist = |topic: &&Topic| topic.type_name.starts_with("geometry_msgs/Twist");
        for topic in self.topics().filter(is_twist) {
            let kind = &self.kinds[topic.kind];
            let command = kind.fields.iter().find(|field| field.ends_with("angular.z"));
            if let Some(field) = command.filter(|_| kind.name.contains("cmd")) {
                known.channels.push(KnownChannel {
                    quantity: Quantity::Rudder,
                    column: format!("{}.{field}", kind.name),
                    unit: Some(Unit::Fraction),
                    because: Some("a yaw command".into()),
                    doubt: Some(
                        "no topic is a rudder: the yaw command is taken to steer; it does so only where no controller follows it".into(),
                    ),
                });
            }
        }
    }

    /// What was expected of a heading and a rudder, and which topics there are instead.
    fn say_what_lacks(&self, known: &mut Known) {
        let found: Vec<String> = self
            .topics()
            .map(|topic| format!("{} ({})", self.kinds[topic.kind].name, topic.type_name))
            .collect();
        let found = found.join(", ");
        let pulses = self.topics().find(|topic| topic.type_name == "mavros_msgs/RCOut");
        let pulses = pulses.map_or(String::new(), |topic| {
            let name = &self.kinds[topic.kind].name;
            format!("; {name} has the pulses of all outputs: say which one steers, as in --rudder {name}.channels[0] --unit rudder=pwm, or which two with --channels FILE")
        });
        known.lacks(
            Quantity::Heading,
            format!("expected nav_msgs/Odometry, sensor_msgs/Imu, geometry_msgs/PoseStamped or a number on a topic named heading; found {found}"),
        );
        known.lacks(
            Quantity::Rudder,
            format!("expected a number on a topic named rudder, fin or steering, ackermann_msgs/AckermannDrive or a yaw command; found {found}{pulses}"),
        );
    }

    /// For people.
    pub fn warnings(&self) -> Vec<String> {
        let undecoded = (self.undecoded > 0).then(|| {
            format!("{} messages do not fit their definitions and are left out", self.undecoded)
        });
        let unknown = (!self.unknown.is_empty()).then(|| {
            format!(
                "topics whose definitions are not understood are left out: {}",
                self.unknown.join(", ")
            )
        });
        undecoded.into_iter().chain(unknown).collect()
    }
}
