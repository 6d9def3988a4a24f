//! MAVLink frames behind their time of arrival, and the few messages that are read.
//!
//! The messages stand in [`MESSAGES`]; of all others only the length counts.

use std::ops::Range;

use crate::message::Field;

/// Bytes of the time of arrival, us since 1970, big endian.
pub const STAMP: usize = 8;
/// The longest frame: MAVLink 2, 255 bytes of payload, signed.
pub const LONGEST_FRAME: usize = 10 + 255 + 2 + 13;
/// Payload of a message with all its bytes; zeros at its end are not sent.
pub const PAYLOAD: usize = 255;
/// A message that is read: fields in the order of the wire.
pub struct Definition {
    /// Number of the message.
    pub id: u32,
    /// Name in the MAVLink definitions.
    pub name: &'static str,
    /// Seed of the checksum.
    crc_extra: u8,
    /// The time it carries.
    pub clock: MessageClock,
    fields: &'static [(Type, &'static str)],
}

/// The time in a message.
#[derive(Clone, Copy, PartialEq)]
pub enum MessageClock {
    /// Milliseconds since boot.
    BootMilliseconds,
    /// 32 bits, which start again after 71 minutes.
    BootMicroseconds,
    /// It has no time.
    None,
}

#[derive(Clone, Copy)]
enum Type {
    U8,
    U16,
    I16,
    U32,
    I32,
    U64,
    F32,
    Text16,
}

impl Type {
    const fn width(self) -> usize {
        match self {
            Self::U8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::U64 => 8,
            Self::Text16 => 16,
        }
    }

    fn number(self, payload: &[u8], at: usize) -> Option<f64> {
        Some(match self {
            Self::U8 => u8::read(payload.get(at..)?).into(),
            Self::U16 => u16::read(payload.get(at..)?).into(),
            Self::I16 => i16::read(payload.get(at..)?).into(),
            Self::U32 => u32::read(payload.get(at..)?).into(),
            Self::I32 => i32::read(payload.get(at..)?).into(),
            Self::U64 => u64::read(payload.get(at..)?) as f64,
            Self::F32 => f32::read(payload.get(at..)?).into(),
            Self::Text16 => return None,
        })
    }
}

/// Number of HEARTBEAT.
pub const HEARTBEAT: u32 = 0;
/// Number of PARAM_VALUE.
pub const PARAM_VALUE: u32 = 22;
/// Number of ATTITUDE.
pub const ATTITUDE: u32 = 30;
/// Number of RC_CHANNELS_SCALED.
pub const RC_CHANNELS_SCALED: u32 = 34;
/// Number of SERVO_OUTPUT_RAW.
pub const SERVO_OUTPUT_RAW: u32 = 36;
/// Number of RC_CHANNELS.
pub const RC_CHANNELS: u32 = 65;

/// From the message definitions of MAVLink, common.xml.
pub const MESSAGES: &[Definition] = {
    use MessageClock::{BootMicroseconds, BootMilliseconds, None};
    use Type::{F32, I16, I32, Text16, U8, U16, U32, U64};
    &[
        Definition {
            id: HEARTBEAT,
            name: "HEARTBEAT",
            crc_extra: 50,
            clock: None,
            fields: &[
                (U32, "custom_mode"),
                (U8, "type"),
                (U8, "autopilot"),
                (U8, "base_mode"),
                (U8, "system_status"),
                (U8, "mavlink_version"),
            ],
        },
        Definition {
            id: 2,
            name: "SYSTEM_TIME",
            crc_extra: 137,
            clock: BootMilliseconds,
            fields: &[(U64, "time_unix_usec"), (U32, "time_boot_ms")],
        },
        Definition {
            id: PARAM_VALUE,
            name: "PARAM_VALUE",
            crc_extra: 220,
            clock: None,
            fields: &[
                (F32, "param_value"),
                (U16, "param_count"),
                (U16, "param_index"),
                (Text16, "param_id"),
                (U8, "param_type"),
            ],
        },
        Definition {
            id: ATTITUDE,
            name: "ATTITUDE",
            crc_extra: 39,
            clock: BootMilliseconds,
            fields: &[
                (U32, "time_boot_ms"),
                (F32, "roll"),
                (F32, "pitch"),
                (F32, "yaw"),
                (F32, "rollspeed"),
                (F32, "pitchspeed"),
                (F32, "yawspeed"),
            ],
        },
        Definition {
            id: 32,
            name: "LOCAL_POSITION_NED",
            crc_extra: 185,
            clock: BootMilliseconds,
            fields: &[
                (U32, "time_boot_ms"),
                (F32, "x"),
                (F32, "y"),
                (F32, "z"),
                (F32, "vx"),
                (F32, "vy"),
                (F32, "vz"),
            ],
        },
        Definition {
            id: 33,
            name: "GLOBAL_POSITION_INT",
            crc_extra: 104,
            clock: BootMilliseconds,
            fields: &[
                (U32, "time_boot_ms"),
                (I32, "lat"),
                (I32, "lon"),
                (I32, "alt"),
                (I32, "relative_alt"),
                (I16, "vx"),
                (I16, "vy"),
                (I16, "vz"),
                (U16, "hdg"),
            ],
        },
        Definition {
            id: RC_CHANNELS_SCALED,
            name: "RC_CHANNELS_SCALED",
            crc_extra: 237,
            clock: BootMilliseconds,
            fields: &[
                (U32, "time_boot_ms"),
                (I16, "chan1_scaled"),
                (I16, "chan2_scaled"),
                (I16, "chan3_scaled"),
                (I16, "chan4_scaled"),
                (I16, "chan5_scaled"),
                (I16, "chan6_scaled"),
                (I16, "chan7_scaled"),
                (I16, "chan8_scaled"),
                (U8, "port"),
                (U8, "rssi"),
            ],
        },
        Definition {
            id: SERVO_OUTPUT_RAW,
            name: "SERVO_OUTPUT_RAW",
            crc_extra: 222,
            clock: BootMicroseconds,
            fields: &[
                (U32, "time_usec"),
                (U16, "servo1_raw"),
                (U16, "servo2_raw"),
                (U16, "servo3_raw"),
                (U16, "servo4_raw"),
                (U16, "servo5_raw"),
                (U16, "servo6_raw"),
                (U16, "servo7_raw"),
                (U16, "servo8_raw"),
                (U8, "port"),
                (U16, "servo9_raw"),
                (U16, "servo10_raw"),
                (U16, "servo11_raw"),
                (U16, "servo12_raw"),
                (U16, "servo13_raw"),
                (U16, "servo14_raw"),
                (U16, "servo15_raw"),
                (U16, "servo16_raw"),
            ],
        },
        Definition {
            id: RC_CHANNELS,
            name: "RC_CHANNELS",
            crc_extra: 118,
            clock: BootMilliseconds,
            fields: &[
                (U32, "time_boot_ms"),
                (U16, "chan1_raw"),
                (U16, "chan2_raw"),
                (U16, "chan3_raw"),
                (U16, "chan4_raw"),
                (U16, "chan5_raw"),
                (U16, "chan6_raw"),
                (U16, "chan7_raw"),
                (U16, "chan8_raw"),
                (U16, "chan9_raw"),
                (U16, "chan10_raw"),
                (U16, "chan11_raw"),
                (U16, "chan12_raw"),
                (U16, "chan13_raw"),
                (U16, "chan14_raw"),
                (U16, "chan15_raw"),
                (U16, "chan16_raw"),
                (U16, "chan17_raw"),
                (U16, "chan18_raw"),
                (U8, "chancount"),
                (U8, "rssi"),
            ],
        },
        Definition {
            id: 74,
            name: "VFR_HUD",
            crc_extra: 20,
            clock: None,
            fields: &[
                (F32, "airspeed"),
                (F32, "groundspeed"),
                (F32, "alt"),
                (F32, "climb"),
                (I16, "heading"),
                (U16, "throttle"),
            ],
        },
    ]
};

/// Where the first 256 messages stand in [`MESSAGES`].
static INDICES: [Option<usize>; 256] = {
    let mut indices = [None; 256];
    let mut index = 0;
    while index < MESSAGES.len() {
        indices[MESSAGES[index].id as usize] = Some(index);
        index += 1;
    }
    indices
};

fn index_of(id: u32) -> Option<usize> {
    *INDICES.get(usize::try_from(id).ok()?)?
}

impl Definition {
    /// The number in a field of a payload.
    pub fn field(&self, payload: &[u8], name: &str) -> Option<f64> {
        let mut at = 0;
        for (kind, field) in self.fields {
            if *field == name {
                return kind.number(payload, at);
            }
            at += kind.width();
        }
        None
    }

    /// Every number of a payload, in the order of the wire.
    pub fn numbers<'a>(&'a self, payload: &'a [u8]) -> impl Iterator<Item = f64> + 'a {
        let mut at = 0;
        self.fields.iter().filter_map(move |(kind, _)| {
            let number = kind.number(payload, at);
            at += kind.width();
            number
        })
    }

    /// Names of the numbers, in the order of the wire.
    pub fn number_names(&self) -> impl Iterator<Item = &'static str> {
        self.fields
            .iter()
            .filter(|(kind, _)| !matches!(kind, Type::Text16))
            .map(|(_, name)| *name)
    }
}

/// Who sent a message: system and component.
pub type Sender = (u8, u8);

/// A frame in the log.
#[derive(Clone)]
pub struct Frame {
    /// Index in [`MESSAGES`].
    pub message: Option<usize>,
    /// Who sent it.
    pub sender: Sender,
    /// Of the stamp and the frame.
    pub length: usize,
    /// Time of arrival, us since 1970.
    pub arrival_us: f64,
    /// Where it stands in the bytes that the frame was found in.
    payload: Range<usize>,
}

/// What comes next in the log.
pub enum Next {
    /// A sound frame.
    Frame(Frame),
    /// No frame begins here.
    NoFrame,
    /// The bytes end before the frame does.
    Cut,
}

impl Frame {
    /// The frame at the start of these bytes.
    pub fn at(seen: &[u8]) -> Next {
        let (Some(stamp), Some(frame)) = (seen.first_chunk::<STAMP>(), seen.get(STAMP..)) else {
            return Next::Cut;
        };
        // Version 1: FE length sequence system component id; 2: FD length flags flags sequence system
        // component id id id, and a signature behind the checksum where the first flag says so.
        let (header, sender_at) = match frame.first() {
            Some(0xfd) => (10, 5),
            Some(0xfe) => (6, 3),
            Some(_) => return Next::NoFrame,
            None => return Next::Cut,
        };
        let Some(head) = frame.get(..header) else {
            return Next::Cut;
        };
        let is_signed = header == 10 && head[2] & 1 == 1;
        let id = match header {
            10 => u32::from(head[7]) | u32::from(head[8]) << 8 | u32::from(head[9]) << 16,
            _ => u32::from(head[5]),
        };
        let payload_length = usize::from(head[1]);
        let checked = header + payload_length;
        let length = checked + 2 + if is_signed { 13 } else { 0 };
        let Some(whole) = frame.get(..length) else {
            return Next::Cut;
        };
        let message = index_of(id);
        let is_sound = match message {
            Some(message) => {
                let sum = checksum(&whole[1..checked], MESSAGES[message].crc_extra);
                whole[checked..checked + 2] == sum.to_le_bytes()
            }
            // Without its seed the checksum says nothing; what follows must be a frame too.
            None => matches!(frame.get(length + STAMP), Some(0xfd | 0xfe) | None),
        };
        if !is_sound {
            return Next::NoFrame;
        }
        Next::Frame(Self {
            message,
            sender: (head[sender_at], head[sender_at + 1]),
            length: STAMP + length,
            arrival_us: u64::from_be_bytes(*stamp) as f64,
            payload: STAMP + header..STAMP + checked,
        })
    }

    /// The payload, from the bytes that the frame was found in, with the zeros that were not sent.
    pub fn payload(&self, seen: &[u8]) -> [u8; PAYLOAD] {
        let mut payload = [0; PAYLOAD];
        let sent = seen.get(self.payload.clone()).unwrap_or_default();
        payload[..sent.len()].copy_from_slice(sent);
        payload
    }
}

/// CRC-16/MCRF4XX over the frame without its mark, then over the message's seed.
pub fn checksum(bytes: &[u8], crc_extra: u8) -> u16 {
    let next = |crc: u16, byte: u8| (crc >> 8) ^ REMAINDERS[0][usize::from(byte ^ crc as u8)];
    let (eights, rest) = bytes.as_chunks::<8>();
    let crc = eights.iter().fold(0xffff_u16, |crc, eight| {
        let [low, high] = crc.to_le_bytes();
        let mut mixed = *eight;
        mixed[0] ^= low;
        mixed[1] ^= high;
        mixed
            .iter()
            .zip(REMAINDERS.iter().rev())
            .fold(0, |crc, (byte, remainders)| {
                crc ^ remainders[usize::from(*byte)]
            })
    });
    let crc = rest.iter().fold(crc, |crc, byte| next(crc, *byte));
    next(crc, crc_extra)
}

/// What each byte leaves of the checksum's polynomial, 0x1021 with its bits reversed, behind up to seven zeros.
static REMAINDERS: [[u16; 256]; 8] = {
    let mut remainders = [[0; 256]; 8];
    let mut byte = 0;
    while byte < 256 {
        let mut remainder = byte as u16;
        let mut zeros = 0;
        while zeros < 8 {
            let mut bit = 0;
            while bit < 8 {
                remainder = (remainder >> 1) ^ (0x8408 * (remainder & 1));
                bit += 1;
            }
            remainders[zeros][byte] = remainder;
            zeros += 1;
        }
        byte += 1;
    }
    remainders
};

#[cfg(test)]
mod tests {
    use super::*;

    /// The check value of CRC-16/MCRF4XX.
    #[test]
    fn exact_checksum() {
        assert_eq!(checksum(b"12345678", b'9'), 0x6f91);
    }
}
