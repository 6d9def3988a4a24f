//! Logs of DUNE (`Data.lsf`), which the LAUV and other vehicles of the LSTS write: packets of IMC 5.4, one behind the other.
//!
//! A packet is 0xFE54, number and size of its message, time of sending (s since 1970), system and entity that sent it, those that it is
//! for, the fields of the message, and a CRC-16. The first two bytes tell the order of the others. Messages are those of IMC.xml.

use std::cmp::Reverse;
use std::collections::BTreeMap;

use crate::Quantity::*;
use crate::Unit::*;
use crate::bytes::{Bytes, Found};
use crate::error::Fault;
use crate::input::Input;
use crate::message_table::{Kind, Message, Messages, names};
use crate::number::Primitive::{self, F32, F64, I16, U8, U16};
use crate::table::{Known, KnownField};

const HEADER: usize = 20;
const FOOTER: usize = 2;
/// The longest packet, whose size is of two bytes, and the first bytes of the next.
const LONGEST: usize = HEADER + 0xffff + FOOTER + 2;
/// Kinds of messages, each by each of its senders, that are told apart.
const MOST_SENDERS: usize = 256;
/// Servos of a vehicle; the first and the last move the vertical fins of an LAUV, the first the rudder of a boat.
const SERVOS: usize = 4;

/// Number and name of a message, kinds and names of its fields.
type Layout = (u16, &'static str, &'static [(Primitive, &'static str)]);

const SERVO: &[(Primitive, &str)] = &[(U8, "id"), (F32, "value")];
#[rustfmt::skip]
const LAYOUTS: [Layout; 6] = [
    (250, "Rpm", &[(I16, "value")]),
    (254, "EulerAngles", &[(F64, "time phi theta psi psi_magnetic")]),
    (256, "AngularVelocity", &[(F64, "time x y z")]),
    (281, "ServoPosition", SERVO),
    (302, "SetServoPosition", SERVO),
    (350, "EstimatedState", &[(F64, "lat lon"), (F32, "height x y z phi theta psi u v w vx vy vz p q r depth alt")]),
];

/// Fields that feed a quantity, the preferred one first.
const CHANNELS: [KnownField; 10] = [
    (Heading, "EulerAngles", "psi", Some(Radian)),
    (Heading, "EstimatedState", "psi", Some(Radian)),
    (Speed, "EstimatedState", "u", Some(MetrePerSecond)),
    (Depth, "EstimatedState", "depth", Some(Metre)),
    (Altitude, "EstimatedState", "alt", Some(Metre)),
    (Roll, "EulerAngles", "phi", Some(Radian)),
    (Pitch, "EulerAngles", "theta", Some(Radian)),
    (Pitch, "EstimatedState", "theta", Some(Radian)),
    (YawRate, "AngularVelocity", "z", Some(RadianPerSecond)),
    (YawRate, "EstimatedState", "r", Some(RadianPerSecond)),
];

/// The number of a message, system and entity that sent it.
type Sender = (u16, u16, u8);

/// The header of a packet.
struct Packet {
    sender: Sender,
    time_s: f64,
    length: usize,
    is_little_endian: bool,
}

/// A log of DUNE.
pub(super) struct Lsf {
    bytes: Bytes,
    /// Of each kind.
    senders: Vec<Sender>,
    kinds: Vec<Kind>,
    /// Where each servo is, of each kind.
    servos: Vec<[f64; SERVOS]>,
}

/// Does a packet begin here?
pub(super) fn is_start(start: &[u8]) -> bool {
    start.starts_with(b"\x54\xfe") || start.starts_with(b"\xfe\x54")
}

/// Name, kinds and names of the fields of a message.
fn layout(id: u16) -> Option<(&'static str, impl Iterator<Item = (Primitive, &'static str)>)> {
    let (_, name, fields) = LAYOUTS.into_iter().find(|(of, ..)| *of == id)?;
    let named = |(kind, names): &'static (Primitive, &'static str)| {
        names.split(' ').map(move |name| (*kind, name))
    };
    Some((name, fields.iter().flat_map(named)))
}

fn number(kind: Primitive, bytes: &[u8], at: usize, is_little_endian: bool) -> Option<f64> {
    let mut number = [f64::NAN];
    kind.read_all(bytes.get(at..at + kind.width())?, is_little_endian, &mut number);
    Some(number[0])
}

/// CRC-16-IBM, polynomial 0x8005, the lowest bit first.
fn check_sum(bytes: &[u8]) -> f64 {
    let bit = |sum: u16, _| (sum >> 1) ^ (0xa001 * (sum & 1));
    let byte = |sum, byte: &u8| (0..8).fold(sum ^ u16::from(*byte), bit);
    bytes.iter().fold(0, byte).into()
}

impl Packet {
    /// From the first bytes of one; `None` also where a message has not its size.
    fn of(head: &[u8]) -> Option<Self> {
        let is_little_endian = head.starts_with(b"\x54");
        let read = |kind, at| number(kind, head, at, is_little_endian).filter(|_| is_start(head));
        let word = |at| read(U16, at).map(|word| word as u16);
        let (id, size) = (word(2)?, usize::from(word(4)?));
        let is_of_size = match layout(id) {
            Some((_, fields)) => fields.map(|(kind, _)| kind.width()).sum::<usize>() == size,
            None => true,
        };
        is_of_size.then_some(Self {
            sender: (id, word(14)?, *head.get(16)?),
            time_s: read(F64, 6).filter(|time_s| time_s.is_finite())?,
            length: HEADER + size + FOOTER,
            is_little_endian,
        })
    }

    /// The sound packet that these bytes begin with. A cut one is the last only where no sound one is behind it.
    fn at(seen: &[u8]) -> Found<Self> {
        let sound_at = |at| Self::of(&seen[at..]).filter(|packet| packet.is_sound(&seen[at..]));
        let is_cut = match Self::of(seen) {
            Some(packet) => packet.length > seen.len(),
            None => seen.len() < HEADER && (is_start(seen) || matches!(seen, [0x54 | 0xfe])),
        };
        match sound_at(0) {
            Some(packet) => Found::Packet(packet),
            None if is_cut => {
                let behind = (1..seen.len()).find(|at| sound_at(*at).is_some());
                behind.map_or(Found::Cut, Found::Nothing)
            }
            None => Found::Nothing(1),
        }
    }

    /// Is it whole? Of a message that is read its sum tells, of another what is behind it: a packet or the end.
    fn is_sound(&self, seen: &[u8]) -> bool {
        let Some((packet, behind)) = seen.split_at_checked(self.length) else {
            return false;
        };
        let at = self.length - FOOTER;
        match layout(self.sender.0) {
            Some(_) => {
                number(U16, packet, at, self.is_little_endian) == Some(check_sum(&packet[..at]))
            }
            None => behind.len() < 2 || is_start(behind),
        }
    }
}

impl Lsf {
    /// Reads the file once for its messages and who sent them.
    pub fn open(file: Input) -> Result<Self, Fault> {
        let mut log = Self {
            bytes: Bytes::new(file)?,
            senders: Vec::new(),
            kinds: Vec::new(),
            servos: Vec::new(),
        };
        let mut counts: BTreeMap<Sender, u64> = BTreeMap::new();
        while let Some(packet) = log.bytes.find_packet(LONGEST, Packet::at)? {
            let Packet { sender, length, .. } = packet;
            let is_read = layout(sender.0).is_some();
            if is_read && (counts.len() < MOST_SENDERS || counts.contains_key(&sender)) {
                *counts.entry(sender).or_default() += 1;
            }
            log.bytes.skip(length);
        }
        let mut counts: Vec<_> = counts.into_iter().collect();
        counts.sort_by_key(|((id, ..), count)| (*id, Reverse(*count)));
        for (sender, _) in counts {
            let is_first = log.senders.last().is_none_or(|(id, ..)| *id != sender.0);
            log.kinds.extend(kind(sender, is_first));
            log.senders.push(sender);
        }
        if log.kinds.is_empty() {
            return Err(Fault::NothingToRead {
                format: "DUNE",
                what: "there are no messages of attitude, motion or servos".into(),
            });
        }
        log.servos = vec![[f64::NAN; SERVOS]; log.kinds.len()];
        log.bytes.begin_again()?;
        Ok(log)
    }

    /// Makes the message of a packet of this kind; none of a servo that no vehicle has.
    fn give(&mut self, kind: usize, packet: &Packet, message: &mut Message) -> Option<()> {
        let (name, fields) = layout(packet.sender.0)?;
        let payload = self.bytes.seen().get(HEADER..packet.length)?;
        let mut at = 0;
        let numbers = fields.map(|(kind, name)| {
            let value = number(kind, payload, at, packet.is_little_endian);
            at += kind.width();
            // So says IMC that it is not known.
            let is_known = |value: &f64| *value >= 0.0 || !["depth", "alt"].contains(&name);
            value.filter(is_known).unwrap_or(f64::NAN)
        });
        message.set(kind, packet.time_s, numbers);
        if name.ends_with("ServoPosition") {
            let servos = &mut self.servos[kind];
            *servos.get_mut(*message.values.first()? as usize)? = *message.values.get(1)?;
            let fins = [servos[0], servos[SERVOS - 1]].into_iter();
            let fins = fins.filter(|angle| !angle.is_nan());
            let rudder = fins.clone().sum::<f64>() / fins.count() as f64;
            message.set(kind, packet.time_s, servos.iter().copied().chain([rudder]));
        }
        Some(())
    }
}

/// The kind of the messages of a sender: by their name alone where none sends more of them.
fn kind((id, system, entity): Sender, is_first: bool) -> Option<Kind> {
    let (name, fields) = layout(id)?;
    let servos = (0..SERVOS).map(|servo| format!("servo_{servo}"));
    Some(Kind {
        name: match is_first {
            true => name.into(),
            false => format!("{name}.{system}.{entity}"),
        },
        fields: match name.ends_with("ServoPosition") {
            false => fields.map(|(_, name)| name.into()).collect(),
            true => servos.chain(["rudder".into()]).collect(),
        },
    })
}

impl Messages for Lsf {
    fn kinds(&self) -> &[Kind] {
        &self.kinds
    }

    fn known(&self) -> Known {
        let mut known = Known::default();
        known.add_fields(&self.kinds, CHANNELS);
        for name in ["ServoPosition", "SetServoPosition"] {
            if self.kinds.iter().any(|kind| kind.name == name) {
                let because = "the mean of servos 0 and 3, the vertical fins of an LAUV; a boat has its rudder on servo 0";
                known.add(Rudder, format!("{name}.rudder"), Some(Radian), because);
            }
        }
        let found = names(&self.kinds);
        known.expects(Heading, "EulerAngles or EstimatedState", &found);
        known.expects(Rudder, "ServoPosition or SetServoPosition", &found);
        known
    }

    fn next(&mut self, wanted: &[bool], message: &mut Message) -> Result<bool, Fault> {
        while let Some(packet) = self.bytes.find_packet(LONGEST, Packet::at)? {
            let kind = self.senders.iter().position(|of| *of == packet.sender);
            let kind = kind.filter(|kind| wanted[*kind]);
            let given = kind.and_then(|kind| self.give(kind, &packet, message));
            self.bytes.skip(packet.length);
            if given.is_some() {
                return Ok(true);
            }
        }
        Ok(false)
    }

    fn bytes(&mut self) -> &mut Bytes {
        &mut self.bytes
    }

    fn is_damaged(&self) -> bool {
        self.bytes.damage.bytes > 0
    }
}
