//! Parameter groups that are read, and what their fields are.

use crate::Quantity::{self, *};
use crate::Unit::{self, *};
use crate::number::Primitive::{self, I8, I16, I32, I64, U16, U32};

/// A parameter group: fields with their first byte, type and resolution.
pub(super) struct Group {
    pub number: u32,
    pub name: &'static str,
    /// Does the first byte number instruments of one source?
    pub has_instance: bool,
    pub fields: &'static [(&'static str, usize, Primitive, f64)],
}

pub(super) const GROUPS: [Group; 13] = [
    Group {
        number: 127_245,
        name: "rudder",
        has_instance: true,
        fields: &[
            ("angle_order_rad", 2, I16, 1e-4),
            ("position_rad", 4, I16, 1e-4),
        ],
    },
    Group {
        number: 127_250,
        name: "vessel_heading",
        has_instance: false,
        fields: &[("heading_rad", 1, U16, 1e-4)],
    },
    Group {
        number: 127_251,
        name: "rate_of_turn",
        has_instance: false,
        fields: &[("rate_rad_s", 1, I32, 1e-6 / 32.0)],
    },
    Group {
        number: 127_252,
        name: "heave",
        has_instance: false,
        fields: &[("heave_m", 1, I16, 0.01)],
    },
    Group {
        number: 127_488,
        name: "engine",
        has_instance: true,
        fields: &[("speed_rpm", 1, U16, 0.25)],
    },
    Group {
        number: 127_489,
        name: "engine_dynamic",
        has_instance: true,
        fields: &[
            ("load_percent", 24, I8, 1.0),
            ("torque_percent", 25, I8, 1.0),
        ],
    },
    Group {
        number: 127_257,
        name: "attitude",
        has_instance: false,
        fields: &[
            ("yaw_rad", 1, I16, 1e-4),
            ("pitch_rad", 3, I16, 1e-4),
            ("roll_rad", 5, I16, 1e-4),
        ],
    },
    Group {
        number: 128_259,
        name: "speed",
        has_instance: false,
        fields: &[
            ("speed_water_m_s", 1, U16, 0.01),
            ("speed_ground_m_s", 3, U16, 0.01),
        ],
    },
    Group {
        number: 128_267,
        name: "water_depth",
        has_instance: false,
        fields: &[("depth_m", 1, U32, 0.01)],
    },
    Group {
        number: 129_026,
        name: "cog_sog",
        has_instance: false,
        fields: &[("sog_m_s", 4, U16, 0.01)],
    },
    Group {
        number: 127_237,
        name: "heading_control",
        has_instance: false,
        fields: &[
            ("rudder_order_rad", 3, I16, 1e-4),
            ("heading_rad", 19, U16, 1e-4),
        ],
    },
    Group {
        number: 129_025,
        name: "position",
        has_instance: false,
        fields: &[
            ("latitude_deg", 0, I32, 1e-7),
            ("longitude_deg", 4, I32, 1e-7),
        ],
    },
    Group {
        number: 129_029,
        name: "gnss_position",
        has_instance: false,
        fields: &[
            ("latitude_deg", 7, I64, 1e-16),
            ("longitude_deg", 15, I64, 1e-16),
        ],
    },
];

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
