//! Parameter groups that are read, and what their fields are.

use crate::Quantity::{self, *};
use crate::Unit::{self, *};
use crate::number::Primitive::{self, I8, I16, I32, I64, U16, U32};

/// Parameter groups: number, name, and does the first byte number instruments of one source?
pub(super) const GROUPS: [(u32, &str, bool); 13] = [
    (127_245, "rudder", true),
    (127_250, "vessel_heading", false),
    (127_251, "rate_of_turn", false),
    (127_252, "heave", false),
    (127_488, "engine", true),
    (127_489, "engine_dynamic", true),
    (127_257, "attitude", false),
    (128_259, "speed", false),
    (128_267, "water_depth", false),
    (129_026, "cog_sog", false),
    (127_237, "heading_control", false),
    (129_025, "position", false),
    (129_029, "gnss_position", false),
];

/// Fields of the groups: group, name, first byte, type and resolution.
const FIELDS: [(&str, &str, usize, Primitive, f64); 21] = [
    ("rudder", "angle_order_rad", 2, I16, 1e-4),
    ("rudder", "position_rad", 4, I16, 1e-4),
    ("vessel_heading", "heading_rad", 1, U16, 1e-4),
    ("rate_of_turn", "rate_rad_s", 1, I32, 1e-6 / 32.0),
    ("heave", "heave_m", 1, I16, 0.01),
    ("engine", "speed_rpm", 1, U16, 0.25),
    ("engine_dynamic", "load_percent", 24, I8, 1.0),
    ("engine_dynamic", "torque_percent", 25, I8, 1.0),
    ("attitude", "yaw_rad", 1, I16, 1e-4),
    ("attitude", "pitch_rad", 3, I16, 1e-4),
    ("attitude", "roll_rad", 5, I16, 1e-4),
    ("speed", "speed_water_m_s", 1, U16, 0.01),
    ("speed", "speed_ground_m_s", 3, U16, 0.01),
    ("water_depth", "depth_m", 1, U32, 0.01),
    ("cog_sog", "sog_m_s", 4, U16, 0.01),
    ("heading_control", "rudder_order_rad", 3, I16, 1e-4),
    ("heading_control", "heading_rad", 19, U16, 1e-4),
    ("position", "latitude_deg", 0, I32, 1e-7),
    ("position", "longitude_deg", 4, I32, 1e-7),
    ("gnss_position", "latitude_deg", 7, I64, 1e-16),
    ("gnss_position", "longitude_deg", 15, I64, 1e-16),
];

/// Fields of a group: name, first byte, type and resolution.
pub(super) fn fields(group: usize) -> impl Iterator<Item = (&'static str, usize, Primitive, f64)> {
    let of_group = FIELDS.iter().filter(move |(of, ..)| *of == GROUPS[group].1);
    of_group.map(|(_, name, at, kind, resolution)| (*name, *at, *kind, *resolution))
}

/// Which fields feed a quantity, the preferred one first.
pub(super) const CHANNELS: [(Quantity, &str, &str, Unit); 13] = [
    (Heading, "vessel_heading", "heading_rad", Radian),
    (Heading, "attitude", "yaw_rad", Radian),
    (Heading, "heading_control", "heading_rad", Radian),
    (Rudder, "rudder", "position_rad", Radian),
    (Rudder, "rudder", "angle_order_rad", Radian),
    (Rudder, "heading_control", "rudder_order_rad", Radian),
    (YawRate, "rate_of_turn", "rate_rad_s", RadianPerSecond),
    (Speed, "speed", "speed_water_m_s", MetrePerSecond),
    (Speed, "cog_sog", "sog_m_s", MetrePerSecond),
    (Speed, "speed", "speed_ground_m_s", MetrePerSecond),
    (Altitude, "water_depth", "depth_m", Metre),
    (Roll, "attitude", "roll_rad", Radian),
    (Pitch, "attitude", "pitch_rad", Radian),
];
