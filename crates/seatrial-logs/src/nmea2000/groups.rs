//! Parameter groups that are read, and what their fields are.

use crate::number::number;
use crate::{Quantity, Unit};

/// A parameter group: fields with their first byte, type and resolution.
pub(super) struct Group {
    pub number: u32,
    pub name: &'static str,
    /// Does the first byte number instruments of one source?
    pub has_instance: bool,
    /// Is a message of several frames?
    pub is_fast: bool,
    pub fields: &'static [(&'static str, usize, Type, f64)],
}

#[derive(Clone, Copy)]
pub(super) enum Type {
    I8,
    U16,
    I16,
    U32,
    I32,
    I64,
}

impl Type {
    /// The three largest values mean that there is none.
    pub fn number(self, bytes: &[u8], at: usize) -> Option<f64> {
        match self {
            Self::I8 => number::<i8>(bytes, at)
                .filter(|n| *n < i8::MAX - 2)
                .map(f64::from),
            Self::U16 => number::<u16>(bytes, at)
                .filter(|n| *n < u16::MAX - 2)
                .map(f64::from),
            Self::I16 => number::<i16>(bytes, at)
                .filter(|n| *n < i16::MAX - 2)
                .map(f64::from),
            Self::U32 => number::<u32>(bytes, at)
                .filter(|n| *n < u32::MAX - 2)
                .map(f64::from),
            Self::I32 => number::<i32>(bytes, at)
                .filter(|n| *n < i32::MAX - 2)
                .map(f64::from),
            Self::I64 => number::<i64>(bytes, at)
                .filter(|n| *n < i64::MAX - 2)
                .map(|n| n as f64),
        }
    }
}

pub(super) const GROUPS: [Group; 13] = [
    Group {
        number: 127_245,
        name: "rudder",
        has_instance: true,
        is_fast: false,
        fields: &[
            ("angle_order_rad", 2, Type::I16, 1e-4),
            ("position_rad", 4, Type::I16, 1e-4),
        ],
    },
    Group {
        number: 127_250,
        name: "vessel_heading",
        has_instance: false,
        is_fast: false,
        fields: &[("heading_rad", 1, Type::U16, 1e-4)],
    },
    Group {
        number: 127_251,
        name: "rate_of_turn",
        has_instance: false,
        is_fast: false,
        fields: &[("rate_rad_s", 1, Type::I32, 1e-6 / 32.0)],
    },
    Group {
        number: 127_252,
        name: "heave",
        has_instance: false,
        is_fast: false,
        fields: &[("heave_m", 1, Type::I16, 0.01)],
    },
    Group {
        number: 127_488,
        name: "engine",
        has_instance: true,
        is_fast: false,
        fields: &[("speed_rpm", 1, Type::U16, 0.25)],
    },
    Group {
        number: 127_489,
        name: "engine_dynamic",
        has_instance: true,
        is_fast: true,
        fields: &[
            ("load_percent", 24, Type::I8, 1.0),
            ("torque_percent", 25, Type::I8, 1.0),
        ],
    },
    Group {
        number: 127_257,
        name: "attitude",
        has_instance: false,
        is_fast: false,
        fields: &[
            ("yaw_rad", 1, Type::I16, 1e-4),
            ("pitch_rad", 3, Type::I16, 1e-4),
            ("roll_rad", 5, Type::I16, 1e-4),
        ],
    },
    Group {
        number: 128_259,
        name: "speed",
        has_instance: false,
        is_fast: false,
        fields: &[
            ("speed_water_m_s", 1, Type::U16, 0.01),
            ("speed_ground_m_s", 3, Type::U16, 0.01),
        ],
    },
    Group {
        number: 128_267,
        name: "water_depth",
        has_instance: false,
        is_fast: false,
        fields: &[("depth_m", 1, Type::U32, 0.01)],
    },
    Group {
        number: 129_026,
        name: "cog_sog",
        has_instance: false,
        is_fast: false,
        fields: &[("sog_m_s", 4, Type::U16, 0.01)],
    },
    Group {
        number: 127_237,
        name: "heading_control",
        has_instance: false,
        is_fast: true,
        fields: &[
            ("rudder_order_rad", 3, Type::I16, 1e-4),
            ("heading_rad", 19, Type::U16, 1e-4),
        ],
    },
    Group {
        number: 129_025,
        name: "position",
        has_instance: false,
        is_fast: false,
        fields: &[
            ("latitude_deg", 0, Type::I32, 1e-7),
            ("longitude_deg", 4, Type::I32, 1e-7),
        ],
    },
    Group {
        number: 129_029,
        name: "gnss_position",
        has_instance: false,
        is_fast: true,
        fields: &[
            ("latitude_deg", 7, Type::I64, 1e-16),
            ("longitude_deg", 15, Type::I64, 1e-16),
        ],
    },
];

/// Which fields feed a quantity, the preferred one first.
pub(super) const CHANNELS: [(Quantity, &str, &str, Unit); 13] = [
    (
        Quantity::Heading,
        "vessel_heading",
        "heading_rad",
        Unit::Radian,
    ),
    (Quantity::Heading, "attitude", "yaw_rad", Unit::Radian),
    (
        Quantity::Heading,
        "heading_control",
        "heading_rad",
        Unit::Radian,
    ),
    (Quantity::Rudder, "rudder", "position_rad", Unit::Radian),
    (Quantity::Rudder, "rudder", "angle_order_rad", Unit::Radian),
    (
        Quantity::Rudder,
        "heading_control",
        "rudder_order_rad",
        Unit::Radian,
    ),
    (
        Quantity::YawRate,
        "rate_of_turn",
        "rate_rad_s",
        Unit::RadianPerSecond,
    ),
    (
        Quantity::Speed,
        "speed",
        "speed_water_m_s",
        Unit::MetrePerSecond,
    ),
    (Quantity::Speed, "cog_sog", "sog_m_s", Unit::MetrePerSecond),
    (
        Quantity::Speed,
        "speed",
        "speed_ground_m_s",
        Unit::MetrePerSecond,
    ),
    (Quantity::Altitude, "water_depth", "depth_m", Unit::Metre),
    (Quantity::Roll, "attitude", "roll_rad", Unit::Radian),
    (Quantity::Pitch, "attitude", "pitch_rad", Unit::Radian),
];
