//! Messages of ROS 2 as they are on the wire, field by field.

use ros2_client::Message;
use serde::{Deserialize, Serialize};

use crate::ros2_vehicle::Motion;

/// `builtin_interfaces/Time`.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Stamp {
    pub sec: i32,
    pub nanosec: u32,
}

impl Stamp {
    fn time_s(self) -> f64 {
        f64::from(self.sec) + 1e-9 * f64::from(self.nanosec)
    }
}

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Header {
    pub stamp: Stamp,
    pub frame_id: String,
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
    pub fn of(numbers: &[f64]) -> Self {
        let vector = |from: usize| Vector3 {
            x: numbers.get(from).copied().unwrap_or(0.0),
            y: numbers.get(from + 1).copied().unwrap_or(0.0),
            z: numbers.get(from + 2).copied().unwrap_or(0.0),
        };
        Self {
            linear: vector(0),
            angular: vector(3),
        }
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
    /// The stamp, s, and the position of a joint.
    pub fn position(&self, joint: &str) -> Option<(f64, f64)> {
        let index = self.name.iter().position(|name| name == joint)?;
        Some((self.header.stamp.time_s(), *self.position.get(index)?))
    }
}

#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Float64 {
    pub data: f64,
}

#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Float32 {
    pub data: f32,
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

impl Message for TriggerRequest {}
impl Message for SetBoolRequest {}
impl Message for Answer {}
