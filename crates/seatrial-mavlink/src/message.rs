//! The messages that are exchanged with an autopilot, from the definitions of MAVLink (common.xml, ardupilotmega.xml).

use crate::definition::{Definition, LoggedField, MessageClock};
use crate::field::Field;
pub use crate::field::Text;
use crate::seeds::seed;

/// Payload of a message with all its bytes; zeros at its end are not sent.
pub type Payload = [u8; 255];

/// The fields of a message, in the order of the wire.
trait Fields {
    const FIELDS: &'static [LoggedField];
}

/// Names of the numbers of a field: its own unless others are given.
macro_rules! names {
    ($field:ident) => {
        &[stringify!($field)]
    };
    ($field:ident $($number:literal)+) => {
        &[$($number),+]
    };
}

macro_rules! messages {
    ($(
        $(#[$about:meta])*
        $name:ident = $id:literal $(logged as $log_name:literal with $clock:ident)? {
            $($field:ident $(as $($number:literal)+)?: $kind:ty,)*
        }
    )*) => {
        $(
            $(#[$about])*
            #[derive(Clone, Copy, Debug, PartialEq)]
            pub struct $name {
                $(#[doc = concat!("`", stringify!($field), "`.")] pub $field: $kind,)*
            }

            impl $name {
                /// Number of the message.
                pub const ID: u32 = $id;
            }

            impl Fields for $name {
                const FIELDS: &'static [LoggedField] = &[$(
                    LoggedField {
                        names: names!($field $($($number)+)?),
                        width: <$kind as Field>::WIDTH,
                        numbers: <$kind as Field>::NUMBERS,
                    },
                )*];
            }

            impl From<$name> for Message {
                fn from(message: $name) -> Self {
                    Self::$name(message)
                }
            }
        )*

        /// The messages that are read from telemetry logs.
        pub static LOGGED: &[Definition] = &[
            $($(Definition {
                id: $id,
                name: $log_name,
                crc_extra: match seed($id) {
                    Some(seed) => seed,
                    None => panic!("every message has a seed"),
                },
                clock: MessageClock::$clock,
                fields: <$name as Fields>::FIELDS,
            },)?)*
        ];

        /// A message, fields in the order of the wire.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum Message {
            $($(#[$about])* $name($name),)*
        }

        impl Message {
            /// Number of the message.
            pub fn id(&self) -> u32 {
                match self {
                    $(Self::$name(_) => $id,)*
                }
            }

            /// Its payload and how many bytes of it belong to the message.
            pub fn payload(&self) -> (Payload, usize) {
                let mut payload = [0; 255];
                let mut at = 0;
                match self {
                    $(Self::$name(message) => {
                        $(
                            message.$field.write(&mut payload[at..]);
                            at += <$kind as Field>::WIDTH;
                        )*
                    })*
                }
                (payload, at)
            }

            /// The message of this number; `None` where it is none of these.
            pub fn read(id: u32, payload: &Payload) -> Option<Self> {
                let mut at = 0;
                let mut next = |width: usize| {
                    at += width;
                    &payload[at - width..]
                };
                Some(match id {
                    $($id => Self::$name($name {
                        $($field: <$kind as Field>::read(next(<$kind as Field>::WIDTH)),)*
                    }),)*
                    _ => return None,
                })
            }
        }
    };
}

messages! {
    /// Somebody is there.
    Heartbeat = 0 logged as "HEARTBEAT" with None {
        custom_mode: u32,
        kind as "type": u8,
        autopilot: u8,
        base_mode: u8,
        system_status: u8,
        mavlink_version: u8,
    }
    /// Health of sensors and battery.
    SysStatus = 1 {
        present: u32,
        enabled: u32,
        health: u32,
        load: u16,
        voltage_mv: u16,
        current_ca: i16,
        drop_rate: u16,
        errors: u16,
        error_counts: [u16; 4],
        battery_percent: i8,
    }
    /// Time since 1970.
    SystemTime = 2 logged as "SYSTEM_TIME" with BootMilliseconds {
        time_unix_us as "time_unix_usec": u64,
        time_boot_ms: u32,
    }
    /// Asks for a parameter.
    ParamRequestRead = 20 {
        index: i16,
        target_system: u8,
        target_component: u8,
        name: Text<16>,
    }
    /// Asks for all parameters.
    ParamRequestList = 21 {
        target_system: u8,
        target_component: u8,
    }
    /// A parameter.
    ParamValue = 22 logged as "PARAM_VALUE" with None {
        value as "param_value": f32,
        count as "param_count": u16,
        index as "param_index": u16,
        name: Text<16>,
        kind as "param_type": u8,
    }
    /// Changes a parameter.
    ParamSet = 23 {
        value: f32,
        target_system: u8,
        target_component: u8,
        name: Text<16>,
        kind: u8,
    }
    /// Satellite fix.
    GpsRawInt = 24 {
        time_us: u64,
        latitude: i32,
        longitude: i32,
        altitude_mm: i32,
        eph: u16,
        epv: u16,
        speed_cm_s: u16,
        course_cdeg: u16,
        fix_type: u8,
        satellites: u8,
    }
    /// Attitude and turn rates.
    Attitude = 30 logged as "ATTITUDE" with BootMilliseconds {
        time_boot_ms: u32,
        roll_rad as "roll": f32,
        pitch_rad as "pitch": f32,
        yaw_rad as "yaw": f32,
        roll_rate_rad_s as "rollspeed": f32,
        pitch_rate_rad_s as "pitchspeed": f32,
        yaw_rate_rad_s as "yawspeed": f32,
    }
    /// Position from the origin and speed.
    LocalPositionNed = 32 logged as "LOCAL_POSITION_NED" with BootMilliseconds {
        time_boot_ms: u32,
        north_m as "x": f32,
        east_m as "y": f32,
        down_m as "z": f32,
        north_m_s as "vx": f32,
        east_m_s as "vy": f32,
        down_m_s as "vz": f32,
    }
    /// Position on the globe and speed.
    GlobalPositionInt = 33 logged as "GLOBAL_POSITION_INT" with BootMilliseconds {
        time_boot_ms: u32,
        latitude as "lat": i32,
        longitude as "lon": i32,
        altitude_mm as "alt": i32,
        relative_altitude_mm as "relative_alt": i32,
        north_cm_s as "vx": i16,
        east_cm_s as "vy": i16,
        down_cm_s as "vz": i16,
        heading_cdeg as "hdg": u16,
    }
    /// Channels of the remote control, or of ArduPilot's normalised outputs, in 1/10000 of full.
    RcChannelsScaled = 34 logged as "RC_CHANNELS_SCALED" with BootMilliseconds {
        time_boot_ms: u32,
        scaled_1 as "chan1_scaled": i16,
        scaled_2 as "chan2_scaled": i16,
        scaled_3 as "chan3_scaled": i16,
        scaled_4 as "chan4_scaled": i16,
        scaled_5 as "chan5_scaled": i16,
        scaled_6 as "chan6_scaled": i16,
        scaled_7 as "chan7_scaled": i16,
        scaled_8 as "chan8_scaled": i16,
        port: u8,
        rssi: u8,
    }
    /// Pulses of the outputs, us.
    ServoOutputRaw = 36 logged as "SERVO_OUTPUT_RAW" with BootMicroseconds {
        time_us as "time_usec": u32,
        pulses as "servo1_raw" "servo2_raw" "servo3_raw" "servo4_raw" "servo5_raw" "servo6_raw" "servo7_raw" "servo8_raw": [u16; 8],
        port: u8,
        more_pulses as "servo9_raw" "servo10_raw" "servo11_raw" "servo12_raw" "servo13_raw" "servo14_raw" "servo15_raw" "servo16_raw": [u16; 8],
    }
    /// Pulses of the remote control, us.
    RcChannels = 65 logged as "RC_CHANNELS" with BootMilliseconds {
        time_boot_ms: u32,
        pulses as "chan1_raw" "chan2_raw" "chan3_raw" "chan4_raw" "chan5_raw" "chan6_raw" "chan7_raw" "chan8_raw" "chan9_raw" "chan10_raw" "chan11_raw" "chan12_raw" "chan13_raw" "chan14_raw" "chan15_raw" "chan16_raw" "chan17_raw" "chan18_raw": [u16; 18],
        count as "chancount": u8,
        rssi: u8,
    }
    /// A joystick.
    ManualControl = 69 {
        x: i16,
        y: i16,
        z: i16,
        r: i16,
        buttons: u16,
        target_system: u8,
    }
    /// Pulses in the place of the remote control's, us: 0 releases a channel, 65535 leaves it alone.
    RcChannelsOverride = 70 {
        pulses: [u16; 8],
        target_system: u8,
        target_component: u8,
    }
    /// Speed and throttle for a pilot.
    VfrHud = 74 logged as "VFR_HUD" with None {
        air_speed_m_s as "airspeed": f32,
        ground_speed_m_s as "groundspeed": f32,
        altitude_m as "alt": f32,
        climb_m_s as "climb": f32,
        heading_deg as "heading": i16,
        throttle_percent as "throttle": u16,
    }
    /// A command.
    CommandLong = 76 {
        param1: f32,
        param2: f32,
        param3: f32,
        param4: f32,
        param5: f32,
        param6: f32,
        param7: f32,
        command: u16,
        target_system: u8,
        target_component: u8,
        confirmation: u8,
    }
    /// What became of a command.
    CommandAck = 77 {
        command: u16,
        result: u8,
    }
    /// Attitude or turn rate to keep, and thrust.
    SetAttitudeTarget = 82 {
        time_boot_ms: u32,
        quaternion: [f32; 4],
        roll_rate_rad_s: f32,
        pitch_rate_rad_s: f32,
        yaw_rate_rad_s: f32,
        thrust: f32,
        target_system: u8,
        target_component: u8,
        type_mask: u8,
    }
    /// Two clocks: `there_ns` is 0 in a question.
    Timesync = 111 {
        there_ns: i64,
        here_ns: i64,
    }
    /// Health of ArduPilot's estimator.
    EkfStatusReport = 193 {
        velocity_variance: f32,
        horizontal_variance: f32,
        vertical_variance: f32,
        compass_variance: f32,
        terrain_variance: f32,
        flags: u16,
    }
    /// Health of another autopilot's estimator.
    EstimatorStatus = 230 {
        time_us: u64,
        velocity_ratio: f32,
        horizontal_ratio: f32,
        vertical_ratio: f32,
        compass_ratio: f32,
        terrain_ratio: f32,
        air_speed_ratio: f32,
        horizontal_accuracy_m: f32,
        vertical_accuracy_m: f32,
        flags: u16,
    }
    /// A number with a name.
    NamedValueFloat = 251 {
        time_boot_ms: u32,
        value: f32,
        name: Text<10>,
    }
    /// A text for the operator.
    Statustext = 253 {
        severity: u8,
        text: Text<50>,
    }
}

impl Heartbeat {
    /// The heartbeat of a ground station, which has no autopilot.
    pub const GROUND_STATION: Self = Self {
        custom_mode: 0,
        kind: 6,
        autopilot: 8,
        base_mode: 0,
        system_status: 4,
        mavlink_version: 3,
    };
}
