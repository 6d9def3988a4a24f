//! PX4 logs (`.ulg`).
//!
//! Definitions (formats of topics, parameters), then data: a message is its length, its type and its body.
//! A topic's format may hold other formats and arrays; all its numbers become fields of one kind. After
//! damage reading goes on at the next message that can be recognised.

mod layout;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use seatrial_mavlink::aircraft;

use crate::Quantity::*;
use crate::Unit::*;
use crate::bytes::{Bytes, text_of};
use crate::error::Fault;
use crate::input::Input;
use crate::message_table::{Kind, Message, Messages, has, names};
use crate::number::number;
use crate::table::{Known, KnownField};
use crate::ulog::layout::Layout;

/// Magic, version and time of the start.
const FILE_HEADER: usize = 16;
/// Length and type of a message.
const HEADER: usize = 3;
/// The body of a synchronisation message.
const SYNC: [u8; 8] = [0x2f, 0x73, 0x13, 0x20, 0x25, 0x0c, 0xbb, 0x12];
/// Fields of all topics.
const MOST_FIELDS_OF_ALL: usize = 1 << 16;
const MOST_FORMATS: usize = 4096;
const MOST_PARAMETERS: usize = 8192;
/// `CA_SV_CSn_TYPE` of a rudder and of a steering wheel.
const STEERING_SURFACES: [(f64, &str); 2] = [(4.0, "rudder"), (16.0, "steering wheel")];
/// `MAV_TYPE` of a submarine.
const SUBMARINE: f64 = 12.0;

/// A PX4 log.
pub(crate) struct ULog {
    bytes: Bytes,
    formats: BTreeMap<String, String>,
    layouts: BTreeMap<String, Option<Arc<Layout>>>,
    subscriptions: BTreeMap<u16, Subscription>,
    /// Numbers of topics whose format is not understood.
    unreadable: BTreeSet<u16>,
    kinds: Vec<Kind>,
    kind_of: BTreeMap<(String, u8), usize>,
    parameters: BTreeMap<String, f64>,
    fields: usize,
    /// Where data were appended after a crash.
    appended: Vec<u64>,
    is_lost: bool,
    dropouts: u64,
    dropped_ms: u64,
}

/// A topic that data messages of one number belong to.
#[derive(Clone)]
struct Subscription {
    topic: String,
    instance: u8,
    layout: Arc<Layout>,
    kind: Option<usize>,
}

impl ULog {
    /// Reads the file once for its topics and parameters.
    pub fn open(file: Input) -> Result<Self, Fault> {
        let mut log = Self {
            bytes: Bytes::new(file)?,
            formats: BTreeMap::new(),
            layouts: BTreeMap::new(),
            subscriptions: BTreeMap::new(),
            unreadable: BTreeSet::new(),
            kinds: Vec::new(),
            kind_of: BTreeMap::new(),
            parameters: BTreeMap::new(),
            fields: 0,
            appended: Vec::new(),
            is_lost: false,
            dropouts: 0,
            dropped_ms: 0,
        };
        log.start()?;
        while let Some((kind, length)) = log.find_message()? {
            let body = log.bytes.peek(HEADER + length)?[HEADER..HEADER + length].to_vec();
            if kind == b'D' {
                log.register(&body);
            } else {
                log.define(kind, &body);
            }
            log.bytes.skip(HEADER + length);
        }
        if log.kinds.is_empty() {
            return Err(Fault::NothingToRead {
                format: "PX4 ULog",
                what: "no topic has data".into(),
            });
        }
        log.start()?;
        Ok(log)
    }

    fn start(&mut self) -> Result<(), Fault> {
        self.bytes.begin_again()?;
        self.bytes.peek(FILE_HEADER)?;
        self.bytes.skip(FILE_HEADER);
        self.subscriptions.clear();
        self.unreadable.clear();
        self.is_lost = false;
        self.dropouts = 0;
        self.dropped_ms = 0;
        Ok(())
    }

    /// Goes to the next complete message and says its type and the length of its body.
    fn find_message(&mut self) -> Result<Option<(u8, usize)>, Fault> {
        loop {
            let position = self.bytes.position();
            let seen = self.bytes.peek(HEADER)?;
            if seen.is_empty() {
                return Ok(None);
            }
            let header = number::<u16>(seen, 0).zip(number::<u8>(seen, 2));
            let Some((length, kind)) = header.map(|(length, kind)| (usize::from(length), kind))
            else {
                return self.cut(position);
            };
            let end = position + (HEADER + length) as u64;
            // What was appended after a crash goes on in the middle of a message.
            let appended = self.appended.iter().find(|at| position < **at).copied();
            if let Some(appended) = appended.filter(|appended| end > *appended) {
                self.bytes.go_to(appended)?;
                continue;
            }
            let seen = self.bytes.peek(HEADER + length)?;
            let body = seen.get(HEADER..HEADER + length);
            let is_whole = body.is_some();
            let is_sound = match body {
                Some(body) => {
                    let is_unreadable = kind == b'D'
                        && number(body, 0).is_some_and(|id| self.unreadable.contains(&id));
                    is_certain(kind, body, &self.formats, &self.subscriptions)
                        .filter(|_| !is_unreadable)
                        .unwrap_or(is_known(kind) && !self.is_lost)
                }
                None => is_known(kind) && !self.is_lost,
            };
            match is_whole {
                true if is_sound => {
                    self.is_lost = false;
                    return Ok(Some((kind, length)));
                }
                false if is_sound => return self.cut(position),
                _ => {
                    self.is_lost = true;
                    self.bytes.damage.skipped(position, 1);
                    self.bytes.skip(1);
                }
            }
        }
    }

    fn cut<T>(&mut self, position: u64) -> Result<Option<T>, Fault> {
        self.bytes.damage.cut_at = Some(position);
        let rest = self.bytes.peek(usize::from(u16::MAX))?.len();
        self.bytes.skip(rest);
        Ok(None)
    }

    /// Takes a message that is no data.
    fn define(&mut self, kind: u8, body: &[u8]) {
        match kind {
            b'B' => {
                let has_appended = body.get(8).is_some_and(|flags| flags & 1 == 1);
                self.appended = [16, 24, 32]
                    .into_iter()
                    .filter_map(|at| number(body, at))
                    .filter(|offset| has_appended && *offset > 0)
                    .collect();
                self.appended.sort_unstable();
            }
            b'F' if self.formats.len() < MOST_FORMATS => {
                if let Some((name, fields)) = text_of(body).split_once(':') {
                    self.formats.insert(name.into(), fields.into());
                }
            }
            b'P' if self.parameters.len() < MOST_PARAMETERS => self.parameter(body),
            b'A' => self.subscribe(body),
            b'O' => {
                self.dropouts += 1;
                self.dropped_ms += u64::from(number::<u16>(body, 0).unwrap_or(0));
            }
            _ => {}
        }
    }

    fn parameter(&mut self, body: &[u8]) {
        let end = 1 + usize::from(body.first().copied().unwrap_or(0));
        let key = body.get(1..end).map(text_of).unwrap_or_default();
        let value = match key.split_once(' ') {
            Some(("float", _)) => number::<f32>(body, end).map(f64::from),
            Some(("int32_t", _)) => number::<i32>(body, end).map(f64::from),
            _ => None,
        };
        if let (Some((_, name)), Some(value)) = (key.split_once(' '), value) {
            self.parameters.insert(name.into(), value);
        }
    }

    fn subscribe(&mut self, body: &[u8]) {
        let (Some(instance), Some(id), Some(name)) =
            (number::<u8>(body, 0), number::<u16>(body, 1), body.get(3..))
        else {
            return;
        };
        let topic = text_of(name);
        let layout = match self.layouts.get(&topic) {
            Some(layout) => layout.clone(),
            None if self.layouts.len() < MOST_FORMATS => {
                let layout = Layout::of(&topic, &self.formats).map(Arc::new);
                self.layouts.insert(topic.clone(), layout.clone());
                layout
            }
            None => None,
        };
        let Some(layout) = layout else {
            self.unreadable.insert(id);
            return;
        };
        let kind = self.kind_of.get(&(topic.clone(), instance)).copied();
        self.subscriptions.insert(id, Subscription { topic, instance, layout, kind });
    }

    /// Makes a kind of the topic of a data message.
    fn register(&mut self, body: &[u8]) {
        let Some(of) = number(body, 0).and_then(|id: u16| self.subscriptions.get_mut(&id)) else {
            return;
        };
        let names = of.layout.fields.len();
        if of.kind.is_some() || self.fields + names > MOST_FIELDS_OF_ALL {
            return;
        }
        self.fields += names;
        let key = (of.topic.clone(), of.instance);
        let kind = *self.kind_of.entry(key).or_insert_with(|| {
            let kind = Kind::of_instance(&of.topic, of.instance.into(), of.layout.names());
            self.kinds.push(kind);
            self.kinds.len() - 1
        });
        of.kind = Some(kind);
    }

    /// Column, and why, of the surface that the control allocation calls a rudder.
    fn rudder_surface(&self) -> Option<(String, String)> {
        (0..8).find_map(|surface| {
            let parameter = format!("CA_SV_CS{surface}_TYPE");
            let kind = self.parameters.get(&parameter)?;
            let (_, name) = STEERING_SURFACES.iter().find(|(number, _)| number == kind)?;
            let field = format!("control[{surface}]");
            has(&self.kinds, "actuator_servos", &field).then(|| {
                (format!("actuator_servos.{field}"), format!("{parameter} {kind}, {name}"))
            })
        })
    }
}

/// Is this a message, by what its body must hold? `None` where that says nothing.
fn is_certain(
    kind: u8,
    body: &[u8],
    formats: &BTreeMap<String, String>,
    subscriptions: &BTreeMap<u16, Subscription>,
) -> Option<bool> {
    let is_text = |text: &[u8]| text.iter().all(|byte| (b' '..=b'~').contains(byte));
    Some(match kind {
        b'D' => number(body, 0).and_then(|id: u16| subscriptions.get(&id)).is_some_and(|of| {
            // Padding at the end is not logged.
            let missing = (of.layout.length + 2).checked_sub(body.len());
            missing.is_some_and(|bytes| bytes < 8)
        }),
        b'S' => body == SYNC,
        b'O' => body.len() == 2,
        b'F' => is_text(body) && body.contains(&b':'),
        b'A' => body.get(3..).is_some_and(|name| formats.contains_key(&text_of(name))),
        b'P' | b'I' => body
            .split_first()
            .and_then(|(length, rest)| rest.get(..usize::from(*length)))
            .is_some_and(|key| is_text(key) && key.contains(&b' ')),
        _ => return None,
    })
}

fn is_known(kind: u8) -> bool {
    b"BFIMPQARDLCSO".contains(&kind)
}

/// Topic and field of commands that steer where no surface is a rudder, and why they are taken.
const YAW_COMMANDS: [(&str, &str, &str); 4] = [
    ("rover_steering_setpoint", "normalized_steering_setpoint", ""),
    ("rover_steering_setpoint", "normalized_steering_angle", ""),
    ("vehicle_torque_setpoint", "xyz[2]", YAW_TORQUE),
    ("actuator_controls_0", "control[2]", YAW_TORQUE),
];

const YAW_TORQUE: &str = "no surface is a rudder, and this is the yaw torque asked of all of them";

const ATTITUDE: &str = "vehicle_attitude";
const ANGULAR_RATE: &str = "vehicle_angular_velocity";
const POSITION: &str = "vehicle_local_position";

/// Which field of which topic is which quantity, the preferred one first.
const CHANNELS: [KnownField; 8] = [
    (Heading, ATTITUDE, "yaw", Some(Radian)),
    (Roll, ATTITUDE, "roll", Some(Radian)),
    (Pitch, ATTITUDE, "pitch", Some(Radian)),
    (YawRate, ATTITUDE, "yawspeed", Some(RadianPerSecond)),
    (YawRate, ANGULAR_RATE, "xyz[2]", Some(RadianPerSecond)),
    (Speed, POSITION, "ground_speed", Some(MetrePerSecond)),
    (North, POSITION, "x", Some(Metre)),
    (East, POSITION, "y", Some(Metre)),
];

impl Messages for ULog {
    fn aircraft(&self) -> Option<&'static str> {
        let kind = self.parameters.get("MAV_TYPE")?;
        (0.0..256.0).contains(kind).then(|| aircraft(*kind as u8))?
    }

    fn kinds(&self) -> &[Kind] {
        &self.kinds
    }

    fn known(&self) -> Known {
        let mut known = Known::default();
        if let Some((column, because)) = self.rudder_surface() {
            known.add(Rudder, column, Some(Fraction), &because);
        }
        for (topic, field, because) in YAW_COMMANDS {
            if has(&self.kinds, topic, field) {
                let column = format!("{topic}.{field}");
                known.add(Rudder, column, Some(Fraction), because);
            }
        }
        known.add_fields(&self.kinds, CHANNELS);
        // The local position of an aircraft has no depth.
        if self.parameters.get("MAV_TYPE") == Some(&SUBMARINE) {
            known.add_fields(&self.kinds, [(Depth, POSITION, "z", Some(Metre))]);
        }
        let found = names(&self.kinds);
        known.expects(Heading, "the topic vehicle_attitude", &found);
        known.expects(
            Rudder,
            "actuator_servos with a surface whose CA_SV_CSn_TYPE is 4 (rudder), vehicle_torque_setpoint or actuator_controls_0",
            &found,
        );
        known
    }

    fn next(&mut self, wanted: &[bool], message: &mut Message) -> Result<bool, Fault> {
        while let Some((kind, length)) = self.find_message()? {
            let body = &self.bytes.peek(HEADER + length)?[HEADER..HEADER + length];
            if kind != b'D' {
                let body = body.to_vec();
                self.define(kind, &body);
                self.bytes.skip(HEADER + length);
                continue;
            }
            let of = number(body, 0).and_then(|id: u16| self.subscriptions.get(&id));
            let wanted_kind = of.and_then(|of| Some((of, of.kind.filter(|kind| wanted[*kind])?)));
            let mut is_taken = false;
            if let Some((of, kind)) = wanted_kind
                && let Some(time_s) = of.layout.time_s(&body[2..])
            {
                message.kind = kind;
                message.time_s = time_s;
                of.layout.numbers(&body[2..], &mut message.values);
                is_taken = true;
            }
            self.bytes.skip(HEADER + length);
            if is_taken {
                return Ok(true);
            }
        }
        Ok(false)
    }

    fn bytes(&mut self) -> &mut Bytes {
        &mut self.bytes
    }

    fn warnings(&self) -> Vec<String> {
        let (times, lost_s) = (self.dropouts, self.dropped_ms as f64 / 1e3);
        let lost = format!("the logger lost samples {times} times, {lost_s:.3} s in all");
        Vec::from_iter((times > 0).then_some(lost))
    }
}
