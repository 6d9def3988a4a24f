//! MAVLink telemetry logs (`.tlog`): frames, each behind the time of its arrival.
//!
//! The times of the samples are those that the autopilot wrote into its messages, s since its boot; the
//! ground station's time of arrival is the column `arrival_us` of every kind. The few messages that are
//! read stand in [`MESSAGES`]; of all others only the length counts.

use std::collections::BTreeMap;
use std::fs::File;

use crate::ardupilot::{Parameters, Pulse, Steering};
use crate::bytes::{Bytes, Damage, number, text_of};
use crate::error::Fault;
use crate::joined::{Kind, Message, Messages};
use crate::reader::Format;
use crate::table::{Known, KnownChannel};
use crate::{Quantity, Unit};

/// Bytes of the time of arrival, us since 1970, big endian.
const STAMP: usize = 8;
/// The longest frame: MAVLink 2, 255 bytes of payload, signed.
const LONGEST_FRAME: usize = 10 + 255 + 2 + 13;
/// Payload of a message with all its bytes; zeros at its end are not sent.
const PAYLOAD: usize = 255;
/// Pairs of normalised and real steering that are compared.
const MOST_PAIRS: usize = 4096;
/// Steering under this share of full is too little to compare, 1/10000.
const LEAST_SCALED: f64 = 1000.0;

/// A message that is read: fields in the order of the wire.
struct Definition {
    id: u32,
    name: &'static str,
    /// Seed of the checksum.
    crc_extra: u8,
    clock: MessageClock,
    fields: &'static [(Type, &'static str)],
}

/// The time in a message.
#[derive(Clone, Copy, PartialEq)]
enum MessageClock {
    BootMilliseconds,
    /// 32 bits, which start again after 71 minutes.
    BootMicroseconds,
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
            Self::U8 => number::<u8>(payload, at)?.into(),
            Self::U16 => number::<u16>(payload, at)?.into(),
            Self::I16 => number::<i16>(payload, at)?.into(),
            Self::U32 => number::<u32>(payload, at)?.into(),
            Self::I32 => number::<i32>(payload, at)?.into(),
            Self::U64 => number::<u64>(payload, at)? as f64,
            Self::F32 => number::<f32>(payload, at)?.into(),
            Self::Text16 => return None,
        })
    }
}

const HEARTBEAT: u32 = 0;
const PARAM_VALUE: u32 = 22;
const ATTITUDE: u32 = 30;
const RC_CHANNELS_SCALED: u32 = 34;
const SERVO_OUTPUT_RAW: u32 = 36;
const RC_CHANNELS: u32 = 65;

/// `MAV_AUTOPILOT` and `MAV_TYPE` of a heartbeat.
const ARDUPILOT: u8 = 3;
const GROUND_ROVER: u8 = 10;
const SURFACE_BOAT: u8 = 11;
const SUBMARINE: u8 = 12;

/// From the message definitions of MAVLink, common.xml.
const MESSAGES: &[Definition] = {
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

impl Definition {
    fn field(&self, payload: &[u8], name: &str) -> Option<f64> {
        let mut at = 0;
        for (kind, field) in self.fields {
            if *field == name {
                return kind.number(payload, at);
            }
            at += kind.width();
        }
        None
    }

    fn numbers<'a>(&'a self, payload: &'a [u8]) -> impl Iterator<Item = f64> + 'a {
        let mut at = 0;
        self.fields.iter().filter_map(move |(kind, _)| {
            let number = kind.number(payload, at);
            at += kind.width();
            number
        })
    }

    fn number_names(&self) -> impl Iterator<Item = &'static str> {
        self.fields
            .iter()
            .filter(|(kind, _)| !matches!(kind, Type::Text16))
            .map(|(_, name)| *name)
    }
}

/// Who sent a message: system and component.
type Sender = (u8, u8);

/// A frame in the log.
struct Frame {
    /// Index in [`MESSAGES`].
    message: Option<usize>,
    sender: Sender,
    /// Of the stamp and the frame.
    length: usize,
    arrival_us: f64,
    payload: [u8; PAYLOAD],
}

/// What comes next in the log.
enum Next {
    Frame(Box<Frame>),
    NoFrame,
    Cut,
}

/// The output or input that steers, and the message that holds it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct SteeringField {
    message: u32,
    steering: Steering,
}

/// The field that [`Telemetry`] adds to the message that steers.
const STEERING: &str = "steering_fraction";

/// A telemetry log.
pub(crate) struct Telemetry {
    bytes: Bytes,
    kinds: Vec<Kind>,
    /// Kind of every message in [`MESSAGES`].
    kind_of: Vec<Option<usize>>,
    vehicle: Sender,
    steering: Option<SteeringField>,
    is_submarine: bool,
    because: String,
    doubt: Option<String>,
    boot_s: f64,
    damage: Damage,
}

/// What the first pass collects of one sender.
#[derive(Default)]
struct Learnt {
    messages: Vec<u64>,
    parameters: Parameters,
    /// Kind of vehicle and autopilot.
    heartbeat: Option<(u8, u8)>,
    /// Pulse of output 1 and the steering it stands for, 1/10000.
    pairs: Vec<(f64, f64)>,
    pulse_us: Option<f64>,
}

impl Telemetry {
    /// Reads the file once for who sends what and for the parameters.
    pub fn open(file: File) -> Result<Self, Fault> {
        let mut log = Self {
            bytes: Bytes::new(file)?,
            kinds: Vec::new(),
            kind_of: vec![None; MESSAGES.len()],
            vehicle: (0, 0),
            steering: None,
            is_submarine: false,
            because: String::new(),
            doubt: None,
            boot_s: 0.0,
            damage: Damage::default(),
        };
        let mut senders: BTreeMap<Sender, Learnt> = BTreeMap::new();
        while let Some(frame) = log.next_frame()? {
            if let Some(message) = frame.message {
                let learnt = senders.entry(frame.sender).or_default();
                learnt.take(message, &frame.payload);
            }
        }
        let attitude = MESSAGES.iter().position(|m| m.id == ATTITUDE);
        let attitudes = |learnt: &Learnt| attitude.and_then(|i| learnt.messages.get(i).copied());
        let Some((vehicle, learnt)) = senders
            .into_iter()
            .max_by_key(|(_, learnt)| attitudes(learnt))
        else {
            return Err(Fault::Damaged {
                format: "MAVLink telemetry",
                what: "no message in it is of a kind that is read".into(),
            });
        };
        log.vehicle = vehicle;
        log.is_submarine = learnt
            .heartbeat
            .is_some_and(|(vehicle, _)| vehicle == SUBMARINE);
        log.choose_steering(&learnt);
        for (message, definition) in MESSAGES.iter().enumerate() {
            if learnt.count(definition.id) == 0 {
                continue;
            }
            log.kind_of[message] = Some(log.kinds.len());
            let mut fields: Vec<String> = definition.number_names().map(String::from).collect();
            fields.push("arrival_us".into());
            if log.steering.is_some_and(|s| s.message == definition.id) {
                fields.push(STEERING.into());
            }
            log.kinds.push(Kind {
                name: definition.name.into(),
                fields,
            });
        }
        log.bytes.go_to(0)?;
        log.damage = Damage::default();
        Ok(log)
    }

    fn choose_steering(&mut self, learnt: &Learnt) {
        let from_parameters = Steering::find(&learnt.parameters);
        let has_outputs = learnt.count(SERVO_OUTPUT_RAW) > 0;
        if let Some(steering) = from_parameters.filter(|_| has_outputs) {
            self.because = steering.text();
            self.steering = Some(SteeringField {
                message: SERVO_OUTPUT_RAW,
                steering,
            });
            return;
        }
        let (vehicle, autopilot) = learnt.heartbeat.unwrap_or_default();
        let knows_functions = learnt.parameters.get("SERVO1_FUNCTION").is_some();
        match vehicle {
            GROUND_ROVER | SURFACE_BOAT
                if autopilot == ARDUPILOT && has_outputs && !knows_functions =>
            {
                let (pulse, why) = match learnt.observed_pulse() {
                    Some(pulse) => (pulse, "from RC_CHANNELS_SCALED"),
                    None => (Pulse::of(&learnt.parameters, "SERVO1"), "the default"),
                };
                let steering = Steering::Output { number: 1, pulse };
                self.because = steering.text();
                self.doubt = Some(format!(
                    "no SERVOn_FUNCTION in the log: output 1 is taken to steer, as ArduPilot's boats and rovers have it, with {} ({why}); choose another with --rudder NAME",
                    pulse.text()
                ));
                self.steering = Some(SteeringField {
                    message: SERVO_OUTPUT_RAW,
                    steering,
                });
            }
            SUBMARINE if learnt.count(RC_CHANNELS) > 0 => {
                let number = match learnt.parameters.get("RCMAP_YAW") {
                    Some(channel) if (1.0..=18.0).contains(&channel) => channel as usize,
                    _ => 4,
                };
                let pulse = Pulse::of(&learnt.parameters, &format!("RC{number}"));
                self.because = format!("the yaw command, channel {number}, {}", pulse.text());
                self.doubt = Some(format!(
                    "no output is a rudder: the yaw command of the pilot, channel {number}, is taken to steer; it does so only in manual modes"
                ));
                self.steering = Some(SteeringField {
                    message: RC_CHANNELS,
                    steering: Steering::Output { number, pulse },
                });
            }
            _ => self.because = learnt.parameters.functions(),
        }
    }

    /// The next frame; bytes that are none are passed over.
    fn next_frame(&mut self) -> Result<Option<Box<Frame>>, Fault> {
        loop {
            let position = self.bytes.position();
            // One frame and the first bytes of the next.
            let seen = self.bytes.peek(2 * STAMP + LONGEST_FRAME + 1)?;
            if seen.is_empty() {
                return Ok(None);
            }
            match Frame::at(seen) {
                Next::Frame(frame) => {
                    self.bytes.skip(frame.length);
                    return Ok(Some(frame));
                }
                Next::Cut => {
                    self.damage.cut_at = Some(position);
                    let rest = seen.len();
                    self.bytes.skip(rest);
                    return Ok(None);
                }
                Next::NoFrame => {
                    self.damage.skipped(position, 1);
                    self.bytes.skip(1);
                }
            }
        }
    }

    /// Seconds since boot, from the message's own clock, else that of the message before.
    fn time_s(&mut self, definition: &Definition, payload: &[u8]) -> f64 {
        let first = definition.field(payload, "time_boot_ms");
        match definition.clock {
            MessageClock::BootMilliseconds => {
                self.boot_s = first.unwrap_or(0.0) / 1e3;
                self.boot_s
            }
            MessageClock::BootMicroseconds => {
                let turn_us = 2_f64.powi(32);
                let us = definition.field(payload, "time_usec").unwrap_or(0.0);
                let turns = ((self.boot_s * 1e6 - us) / turn_us).round().max(0.0);
                (us + turns * turn_us) / 1e6
            }
            MessageClock::None => self.boot_s,
        }
    }
}

impl Frame {
    /// The frame at the start of these bytes.
    fn at(seen: &[u8]) -> Next {
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
        let message = MESSAGES.iter().position(|message| message.id == id);
        let is_sound = match message {
            Some(message) => {
                let sum = checksum(&whole[1..checked], MESSAGES[message].crc_extra);
                number(whole, checked) == Some(sum)
            }
            // Without its seed the checksum says nothing; what follows must be a frame too.
            None => matches!(frame.get(length + STAMP), Some(0xfd | 0xfe) | None),
        };
        if !is_sound {
            return Next::NoFrame;
        }
        let mut payload = [0; PAYLOAD];
        payload[..payload_length].copy_from_slice(&whole[header..checked]);
        Next::Frame(Box::new(Self {
            message,
            sender: (head[sender_at], head[sender_at + 1]),
            length: STAMP + length,
            arrival_us: u64::from_be_bytes(*stamp) as f64,
            payload,
        }))
    }
}

/// CRC-16/MCRF4XX over the frame without its mark, then over the message's seed.
fn checksum(bytes: &[u8], crc_extra: u8) -> u16 {
    let mut crc = 0xffff_u16;
    for byte in bytes.iter().chain([&crc_extra]) {
        let mut bits = byte ^ (crc & 0xff) as u8;
        bits ^= bits << 4;
        let wide = u16::from(bits);
        crc = (crc >> 8) ^ (wide << 8) ^ (wide << 3) ^ (wide >> 4);
    }
    crc
}

impl Learnt {
    fn take(&mut self, message: usize, payload: &[u8]) {
        self.messages.resize(MESSAGES.len(), 0);
        self.messages[message] += 1;
        let definition = &MESSAGES[message];
        let field = |name: &str| definition.field(payload, name).unwrap_or(f64::NAN);
        match definition.id {
            HEARTBEAT => self.heartbeat = Some((field("type") as u8, field("autopilot") as u8)),
            PARAM_VALUE => {
                let name = text_of(&payload[8..24]);
                self.parameters.insert(name, field("param_value"));
            }
            SERVO_OUTPUT_RAW if field("port") == 0.0 => self.pulse_us = Some(field("servo1_raw")),
            RC_CHANNELS_SCALED if self.pairs.len() < MOST_PAIRS => {
                if let Some(pulse_us) = self.pulse_us {
                    self.pairs.push((pulse_us, field("chan1_scaled")));
                }
            }
            _ => {}
        }
    }

    fn count(&self, id: u32) -> u64 {
        MESSAGES
            .iter()
            .zip(&self.messages)
            .find(|(message, _)| message.id == id)
            .map_or(0, |(_, count)| *count)
    }

    /// The pulses of output 1, from the normalised steering that ArduPilot's rovers send beside it.
    fn observed_pulse(&self) -> Option<Pulse> {
        let trim_us = median(
            self.pairs
                .iter()
                .filter(|(_, scaled)| *scaled == 0.0)
                .map(|(pulse_us, _)| *pulse_us),
        )?;
        let full_us = median(
            self.pairs
                .iter()
                .filter(|(_, scaled)| scaled.abs() >= LEAST_SCALED)
                .map(|(pulse_us, scaled)| (pulse_us - trim_us) / scaled * 1e4),
        )?;
        (full_us != 0.0).then_some(Pulse {
            lowest_us: trim_us - full_us.abs(),
            trim_us,
            highest_us: trim_us + full_us.abs(),
            is_reversed: full_us < 0.0,
        })
    }
}

fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

impl Messages for Telemetry {
    fn format(&self) -> Format {
        Format::Tlog
    }

    fn kinds(&self) -> &[Kind] {
        &self.kinds
    }

    fn known(&self) -> Known {
        let mut known = Known::default();
        let name_of = |id: u32| MESSAGES.iter().find(|m| m.id == id).map_or("", |m| m.name);
        match self.steering {
            Some(steering) => {
                known.channels.push(KnownChannel {
                    quantity: Quantity::Rudder,
                    column: format!("{}.{STEERING}", name_of(steering.message)),
                    unit: Unit::Fraction,
                    because: Some(self.because.clone()),
                    doubt: self.doubt.clone(),
                });
            }
            None => known.lacks(
                Quantity::Rudder,
                format!(
                    "expected SERVO_OUTPUT_RAW messages and an output with SERVOn_FUNCTION 21 (rudder), 26 (ground steering) or 73 and 74 (throttle left and right); found {}",
                    self.because
                ),
            ),
        }
        for (quantity, name, field, unit) in [
            (Quantity::Heading, "ATTITUDE", "yaw", Unit::Radian),
            (Quantity::Roll, "ATTITUDE", "roll", Unit::Radian),
            (Quantity::Pitch, "ATTITUDE", "pitch", Unit::Radian),
            (
                Quantity::YawRate,
                "ATTITUDE",
                "yawspeed",
                Unit::RadianPerSecond,
            ),
            (
                Quantity::Speed,
                "VFR_HUD",
                "groundspeed",
                Unit::MetrePerSecond,
            ),
            (Quantity::Depth, "LOCAL_POSITION_NED", "z", Unit::Metre),
            (Quantity::North, "LOCAL_POSITION_NED", "x", Unit::Metre),
            (Quantity::East, "LOCAL_POSITION_NED", "y", Unit::Metre),
        ] {
            let is_afloat = quantity == Quantity::Depth && !self.is_submarine;
            if self.kinds.iter().any(|kind| kind.name == name) && !is_afloat {
                known.add(quantity, format!("{name}.{field}"), unit, "");
            }
        }
        let names: Vec<&str> = self.kinds.iter().map(|kind| kind.name.as_str()).collect();
        known.lacks(
            Quantity::Heading,
            format!("expected ATTITUDE messages; found {}", names.join(", ")),
        );
        known
    }

    fn next(&mut self, wanted: &[bool], message: &mut Message) -> Result<bool, Fault> {
        while let Some(frame) = self.next_frame()? {
            let Some(index) = frame.message.filter(|_| frame.sender == self.vehicle) else {
                continue;
            };
            let definition = &MESSAGES[index];
            let payload = &frame.payload;
            let time_s = self.time_s(definition, payload);
            let is_second_port = definition.field(payload, "port").is_some_and(|p| p != 0.0);
            let Some(kind) = self.kind_of[index].filter(|kind| wanted[*kind] && !is_second_port)
            else {
                continue;
            };
            message.kind = kind;
            message.time_s = time_s;
            message.values.clear();
            message.values.extend(definition.numbers(payload));
            message.values.push(frame.arrival_us);
            if let Some(field) = self.steering.filter(|s| s.message == definition.id) {
                let prefix = match definition.id {
                    RC_CHANNELS => "chan",
                    _ => "servo",
                };
                let pulse_us = |number: usize| {
                    let name = format!("{prefix}{number}_raw");
                    definition.field(payload, &name).unwrap_or(f64::NAN)
                };
                message.values.push(field.steering.fraction(pulse_us));
            }
            return Ok(true);
        }
        Ok(false)
    }

    fn bytes(&mut self) -> &mut Bytes {
        &mut self.bytes
    }

    fn position(&self) -> u64 {
        self.bytes.position()
    }

    fn warnings(&self) -> Vec<String> {
        self.damage.warnings()
    }
}
