//! The messages that are exchanged with an autopilot, from the definitions of MAVLink (common.xml, ardupilotmega.xml).

/// Payload of a message with all its bytes; zeros at its end are not sent.
pub type Payload = [u8; 255];

/// A field as it stands in a payload, little endian.
pub(crate) trait Field: Sized {
    const WIDTH: usize;
    fn read(bytes: &[u8]) -> Self;
    fn write(&self, bytes: &mut [u8]);
}

macro_rules! numbers {
    ($($number:ty)*) => { $(
        impl Field for $number {
            const WIDTH: usize = size_of::<$number>();
            fn read(bytes: &[u8]) -> Self {
                bytes.first_chunk().map_or_else(Self::default, |bytes| Self::from_le_bytes(*bytes))
            }
            fn write(&self, bytes: &mut [u8]) {
                bytes[..Self::WIDTH].copy_from_slice(&self.to_le_bytes());
            }
        }
    )* };
}

numbers! { u8 i8 u16 i16 u32 i32 u64 i64 f32 }

impl<const N: usize> Field for [u16; N] {
    const WIDTH: usize = 2 * N;
    fn read(bytes: &[u8]) -> Self {
        std::array::from_fn(|k| u16::read(&bytes[2 * k..]))
    }
    fn write(&self, bytes: &mut [u8]) {
        for (number, bytes) in self.iter().zip(bytes.chunks_exact_mut(2)) {
            number.write(bytes);
        }
    }
}

/// A text of at most N bytes, filled up with zeros.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Text<const N: usize>([u8; N]);

impl<const N: usize> Text<N> {
    /// The text up to the first zero.
    pub fn text(&self) -> String {
        let end = self.0.iter().position(|byte| *byte == 0).unwrap_or(N);
        String::from_utf8_lossy(&self.0[..end]).into_owned()
    }
}

impl<const N: usize> From<&str> for Text<N> {
    /// What goes beyond N bytes is cut off.
    fn from(text: &str) -> Self {
        let mut bytes = [0; N];
        for (to, from) in bytes.iter_mut().zip(text.bytes()) {
            *to = from;
        }
        Self(bytes)
    }
}

impl<const N: usize> std::fmt::Debug for Text<N> {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "{:?}", self.text())
    }
}

impl<const N: usize> Field for Text<N> {
    const WIDTH: usize = N;
    fn read(bytes: &[u8]) -> Self {
        Self(bytes.first_chunk().copied().unwrap_or([0; N]))
    }
    fn write(&self, bytes: &mut [u8]) {
        bytes[..N].copy_from_slice(&self.0);
    }
}

macro_rules! messages {
    ($($(#[$about:meta])* $name:ident = $id:literal { $($field:ident: $kind:ty,)* })*) => {
        $(
            $(#[$about])*
            #[derive(Clone, Copy, Debug, PartialEq)]
            pub struct $name {
                $(#[doc = concat!("`", stringify!($field), "`.")] pub $field: $kind,)*
            }

            impl From<$name> for Message {
                fn from(message: $name) -> Self {
                    Self::$name(message)
                }
            }
        )*

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
    Heartbeat = 0 {
        custom_mode: u32,
        kind: u8,
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
    ParamValue = 22 {
        value: f32,
        count: u16,
        index: u16,
        name: Text<16>,
        kind: u8,
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
    Attitude = 30 {
        time_boot_ms: u32,
        roll_rad: f32,
        pitch_rad: f32,
        yaw_rad: f32,
        roll_rate_rad_s: f32,
        pitch_rate_rad_s: f32,
        yaw_rate_rad_s: f32,
    }
    /// Position from the origin and speed.
    LocalPositionNed = 32 {
        time_boot_ms: u32,
        north_m: f32,
        east_m: f32,
        down_m: f32,
        north_m_s: f32,
        east_m_s: f32,
        down_m_s: f32,
    }
    /// Position on the globe and speed.
    GlobalPositionInt = 33 {
        time_boot_ms: u32,
        latitude: i32,
        longitude: i32,
        altitude_mm: i32,
        relative_altitude_mm: i32,
        north_cm_s: i16,
        east_cm_s: i16,
        down_cm_s: i16,
        heading_cdeg: u16,
    }
    /// Pulses of the outputs, us.
    ServoOutputRaw = 36 {
        time_us: u32,
        pulses: [u16; 8],
        port: u8,
        more_pulses: [u16; 8],
    }
    /// Pulses of the remote control, us.
    RcChannels = 65 {
        time_boot_ms: u32,
        pulses: [u16; 18],
        count: u8,
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
    VfrHud = 74 {
        air_speed_m_s: f32,
        ground_speed_m_s: f32,
        altitude_m: f32,
        climb_m_s: f32,
        heading_deg: i16,
        throttle_percent: u16,
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
    /// Of a ground station, which has no autopilot.
    pub const GROUND_STATION: Self = Self {
        custom_mode: 0,
        kind: 6,
        autopilot: 8,
        base_mode: 0,
        system_status: 4,
        mavlink_version: 3,
    };
}
