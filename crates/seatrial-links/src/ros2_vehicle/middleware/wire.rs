//! Messages of ROS 2 as they are on the wire, field by field.

use std::time::{SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};

use crate::ros2_vehicle::{
    Command, CommandType, Diagnosis, FeedbackType, Heard, Motion, TimedEstimate,
};

/// Package and name of a type.
pub type Kind = [&'static str; 2];

pub const IMU: Kind = ["sensor_msgs", "Imu"];
pub const ODOMETRY: Kind = ["nav_msgs", "Odometry"];
pub const DIAGNOSTIC_ARRAY: Kind = ["diagnostic_msgs", "DiagnosticArray"];
pub const FLOAT64_MULTI_ARRAY: Kind = ["std_msgs", "Float64MultiArray"];
pub const TRIGGER: Kind = ["std_srvs", "Trigger"];
pub const SET_BOOL: Kind = ["std_srvs", "SetBool"];

/// The type of a command.
pub fn kind_of_command(kind: CommandType) -> Kind {
    match kind {
        CommandType::Float64 => ["std_msgs", "Float64"],
        CommandType::Float32 => ["std_msgs", "Float32"],
        CommandType::Float64MultiArray => FLOAT64_MULTI_ARRAY,
        CommandType::Twist => ["geometry_msgs", "Twist"],
        CommandType::TwistStamped => ["geometry_msgs", "TwistStamped"],
    }
}

/// The type of feedback.
pub fn kind_of_feedback(kind: FeedbackType) -> Kind {
    match kind {
        FeedbackType::JointState => ["sensor_msgs", "JointState"],
        FeedbackType::Float64 => ["std_msgs", "Float64"],
        FeedbackType::Float32 => ["std_msgs", "Float32"],
    }
}

/// `builtin_interfaces/Time`.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Stamp {
    pub sec: i32,
    pub nanosec: u32,
}

impl Stamp {
    fn now() -> Self {
        let now = SystemTime::now().duration_since(UNIX_EPOCH);
        let now = now.unwrap_or_default();
        Self { sec: i32::try_from(now.as_secs()).unwrap_or(i32::MAX), nanosec: now.subsec_nanos() }
    }

    fn time_s(self) -> f64 {
        f64::from(self.sec) + 1e-9 * f64::from(self.nanosec)
    }
}

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Header {
    pub stamp: Stamp,
    pub frame_id: String,
}

impl Header {
    fn now() -> Self {
        Self { stamp: Stamp::now(), frame_id: String::new() }
    }
}

#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Vector3 {
    pub x: f64,
    pub y: f64,
    pub z: f64,
}

#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Quaternion {
    pub x: f64,
    pub y: f64,
    pub z: f64,
    pub w: f64,
}

#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Twist {
    pub linear: Vector3,
    pub angular: Vector3,
}

impl Twist {
    fn of(numbers: &[f64]) -> Self {
        let vector = |from: usize| Vector3 {
            x: numbers.get(from).copied().unwrap_or(0.0),
            y: numbers.get(from + 1).copied().unwrap_or(0.0),
            z: numbers.get(from + 2).copied().unwrap_or(0.0),
        };
        Self { linear: vector(0), angular: vector(3) }
    }
}

#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct TwistStamped {
    pub header: Header,
    pub twist: Twist,
}

/// `sensor_msgs/Imu`.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Imu {
    pub header: Header,
    pub orientation: Quaternion,
    pub orientation_covariance: [f64; 9],
    pub angular_velocity: Vector3,
    pub angular_velocity_covariance: [f64; 9],
    pub linear_acceleration: Vector3,
    pub linear_acceleration_covariance: [f64; 9],
}

impl Imu {
    pub fn motion(&self) -> Motion {
        let q = self.orientation;
        Motion {
            stamp_s: self.header.stamp.time_s(),
            // A covariance that begins with -1 says that there is no orientation.
            quaternion: match self.orientation_covariance[0] {
                -1.0 => [0.0; 4],
                _ => [q.w, q.x, q.y, q.z],
            },
            turn_rate_rad_s: self.angular_velocity.z,
            position_m: None,
            speed_m_s: None,
        }
    }
}

/// `nav_msgs/Odometry`.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Odometry {
    pub header: Header,
    pub child_frame_id: String,
    pub position: Vector3,
    pub orientation: Quaternion,
    pub pose_covariance: [[f64; 6]; 6],
    pub twist: Twist,
    pub twist_covariance: [[f64; 6]; 6],
}

impl Odometry {
    pub fn motion(&self) -> Motion {
        let (p, q) = (self.position, self.orientation);
        Motion {
            stamp_s: self.header.stamp.time_s(),
            quaternion: [q.w, q.x, q.y, q.z],
            turn_rate_rad_s: self.twist.angular.z,
            position_m: Some([p.x, p.y, p.z]),
            speed_m_s: Some(self.twist.linear.x),
        }
    }
}

/// `sensor_msgs/JointState`.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct JointState {
    pub header: Header,
    pub name: Vec<String>,
    pub position: Vec<f64>,
    pub velocity: Vec<f64>,
    pub effort: Vec<f64>,
}

impl JointState {
    /// The position of a joint.
    pub fn rudder(&self, joint: &str) -> Option<Heard> {
        let index = self.name.iter().position(|name| name == joint)?;
        Some(Heard::Rudder {
            stamp_s: Some(self.header.stamp.time_s()),
            units: *self.position.get(index)?,
        })
    }
}

#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Float64 {
    pub data: f64,
}

impl Float64 {
    pub fn rudder(self) -> Heard {
        Heard::Rudder { stamp_s: None, units: self.data }
    }
}

#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Float32 {
    pub data: f32,
}

impl Float32 {
    pub fn rudder(self) -> Heard {
        let data = self.data.into();
        Float64 { data }.rudder()
    }
}

#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Dimension {
    pub label: String,
    pub size: u32,
    pub stride: u32,
}

/// `std_msgs/Float64MultiArray`, its layout's fields in line.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Float64MultiArray {
    pub dim: Vec<Dimension>,
    pub data_offset: u32,
    pub data: Vec<f64>,
}

impl Float64MultiArray {
    pub fn of(label: &str, data: Vec<f64>) -> Self {
        let size = u32::try_from(data.len()).unwrap_or(u32::MAX);
        Self {
            dim: vec![Dimension { label: label.into(), size, stride: size }],
            data_offset: 0,
            data,
        }
    }
}

/// Names of the numbers of an estimate, in their order.
const ESTIMATE_LABEL: &str = "time_s,a22_per_s,b2_per_s2,c0_rad_per_s2,half_width_a22_per_s,half_width_b2_per_s2,half_width_c0_rad_per_s2,step_norm";

impl From<&TimedEstimate> for Float64MultiArray {
    fn from(estimate: &TimedEstimate) -> Self {
        let mut data = vec![estimate.time_s];
        data.extend(estimate.model.theta());
        data.extend(estimate.half_widths.unwrap_or([f64::NAN; 3]));
        data.push(estimate.step_norm);
        Self::of(ESTIMATE_LABEL, data)
    }
}

/// A command, which has its type's fields and nothing else.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub enum CommandMessage {
    Float64(Float64),
    Float32(Float32),
    Float64MultiArray(Float64MultiArray),
    Twist(Twist),
    TwistStamped(TwistStamped),
}

impl From<Command> for CommandMessage {
    fn from(command: Command) -> Self {
        let numbers = command.numbers;
        let first = numbers.first().copied().unwrap_or(0.0);
        match command.kind {
            CommandType::Float64 => Self::Float64(Float64 { data: first }),
            CommandType::Float32 => Self::Float32(Float32 { data: first as f32 }),
            CommandType::Float64MultiArray => {
                Self::Float64MultiArray(Float64MultiArray::of("", numbers))
            }
            CommandType::Twist => Self::Twist(Twist::of(&numbers)),
            CommandType::TwistStamped => Self::TwistStamped(TwistStamped {
                header: Header::now(),
                twist: Twist::of(&numbers),
            }),
        }
    }
}

#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct KeyValue {
    pub key: String,
    pub value: String,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct DiagnosticStatus {
    pub level: u8,
    pub name: String,
    pub message: String,
    pub hardware_id: String,
    pub values: Vec<KeyValue>,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct DiagnosticArray {
    pub header: Header,
    pub status: Vec<DiagnosticStatus>,
}

impl From<&Diagnosis> for DiagnosticArray {
    fn from(diagnosis: &Diagnosis) -> Self {
        let values = diagnosis
            .values
            .iter()
            .map(|(key, value)| KeyValue { key: (*key).into(), value: value.clone() });
        Self {
            header: Header::now(),
            status: vec![DiagnosticStatus {
                level: if diagnosis.is_error { 2 } else { 0 },
                name: "seatrial".into(),
                message: diagnosis.message.clone(),
                hardware_id: String::new(),
                values: values.collect(),
            }],
        }
    }
}

/// `std_srvs/Trigger`: a structure without members has one byte.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct TriggerRequest {
    pub structure_needs_at_least_one_member: u8,
}

#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct SetBoolRequest {
    pub data: bool,
}

/// The answer of `std_srvs/Trigger` and `std_srvs/SetBool`.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Answer {
    pub success: bool,
    pub message: String,
}

/// What a call of one of our services is for us, and its answer.
pub trait Request {
    fn obeyed(&self) -> (Heard, Answer);
}

impl Request for TriggerRequest {
    fn obeyed(&self) -> (Heard, Answer) {
        (Heard::Abort, Answer::done("the trial ends"))
    }
}

impl Request for SetBoolRequest {
    fn obeyed(&self) -> (Heard, Answer) {
        let text = match self.data {
            true => "the trial may take the vehicle",
            false => "the trial gives the vehicle back",
        };
        (Heard::Enable(self.data), Answer::done(text))
    }
}

impl Answer {
    fn done(text: &str) -> Self {
        Self { success: true, message: text.into() }
    }
}
