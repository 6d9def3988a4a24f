//! ArduPilot DataFlash logs (`.bin`).
//!
//! A message is `0xA3 0x95`, its type and as many bytes as the type's FMT message says. FMT, FMTU and PARM
//! messages describe the rest; a first pass collects them.

use std::collections::BTreeMap;

use crate::Quantity::*;
use crate::Unit::*;
use crate::bytes::{Bytes, Found, text_of};
use crate::error::{Fault, clipped};
use crate::input::Input;
use crate::message_table::{Kind, Message, Messages, has, names};
use crate::number::Primitive;
use crate::table::{Known, KnownField};
use seatrial_mavlink::ardupilot::{Parameters, Steering};

/// The two bytes before every message.
const MARK: [u8; 2] = [0xa3, 0x95];
/// Mark and type.
const HEADER: usize = 3;
/// The type of the messages that describe the others, and their length.
const FORMAT: u8 = 128;
const FORMAT_LENGTH: usize = 89;
/// The longest message: its length is a byte.
const LONGEST: usize = 255;
/// Sensors of one kind are numbered below this.
const MOST_INSTANCES: usize = 16;
/// Outputs in RCOU.
const OUTPUTS: usize = 14;
/// The field that [`DataFlash`] adds to RCOU.
const STEERING: &str = "steering_fraction";

/// Fields that feed a quantity, the preferred one first.
const CHANNELS: [KnownField; 13] = [
    (Heading, "ATT", "Yaw", Some(Degree)),
    (Roll, "ATT", "Roll", Some(Degree)),
    (Pitch, "ATT", "Pitch", Some(Degree)),
    (YawRate, "RATE", "Y", Some(DegreePerSecond)),
    (YawRate, "IMU", "GyrZ", Some(RadianPerSecond)),
    (Speed, "GPS", "Spd", Some(MetrePerSecond)),
    (Thrust, "THR", "ThrOut", Some(Percent)),
    (Depth, "XKF1", "PD", Some(Metre)),
    (North, "XKF1", "PN", Some(Metre)),
    (East, "XKF1", "PE", Some(Metre)),
    (Depth, "NKF1", "PD", Some(Metre)),
    (North, "NKF1", "PN", Some(Metre)),
    (East, "NKF1", "PE", Some(Metre)),
];

/// A DataFlash log.
pub(crate) struct DataFlash {
    bytes: Bytes,
    /// By type.
    layouts: Vec<Option<Layout>>,
    kinds: Vec<Kind>,
    parameters: Parameters,
    steering: Option<Steering>,
    /// Where the pulses of the outputs stand among the numbers of RCOU.
    outputs: Vec<Option<usize>>,
    is_submarine: bool,
    aircraft: Option<&'static str>,
    firmware: Option<String>,
    last_time_s: f64,
}

/// How the messages of a type are laid out.
#[derive(Clone, Debug)]
struct Layout {
    name: String,
    length: usize,
    fields: Vec<Field>,
    /// Where the time stands, and how many of its units are 1 s.
    clock: Option<(usize, f64)>,
    /// The field that counts sensors of a kind.
    instance: Option<usize>,
    /// Kind of every instance that occurs.
    kinds: [Option<usize>; MOST_INSTANCES],
}

/// A field of a message.
#[derive(Clone, Debug)]
struct Field {
    name: String,
    code: u8,
    offset: usize,
}

impl Layout {
    /// The numbers of one instance of these messages.
    fn kind(&self, instance: usize) -> Kind {
        let fields = self.fields.iter().filter(|field| field.is_number());
        Kind::of_instance(&self.name, instance, fields.map(|field| field.name.clone()).collect())
    }

    /// From the body of an FMT message.
    fn of(body: &[u8]) -> Option<(u8, Self)> {
        let (number, length) = (*body.first()?, usize::from(*body.get(1)?));
        let name = text_of(body.get(2..6)?);
        let codes = text_of(body.get(6..22)?);
        let labels = text_of(body.get(22..86)?);
        let mut offset = HEADER;
        let mut fields = Vec::new();
        for (code, label) in codes.bytes().zip(labels.split(',')) {
            let width = width(code)?;
            fields.push(Field { name: label.to_string(), code, offset });
            offset += width;
        }
        let is_sound = length >= HEADER && offset <= length && !name.is_empty();
        let clock = [("TimeUS", 1e6), ("TimeMS", 1e3)];
        let clock = clock.into_iter().find_map(|(name, per_s)| {
            let index = fields.iter().position(|field: &Field| field.name == name)?;
            Some((index, per_s))
        });
        is_sound.then_some((
            number,
            Self { name, length, fields, clock, instance: None, kinds: [None; MOST_INSTANCES] },
        ))
    }

    fn field(&self, name: &str) -> Option<&Field> {
        self.fields.iter().find(|field| field.name == name)
    }

    fn number(&self, message: &[u8], name: &str) -> Option<f64> {
        self.field(name)?.number(message)
    }

    fn text(&self, message: &[u8], name: &str) -> Option<String> {
        let field = self.field(name)?;
        let bytes = message.get(field.offset..field.offset + width(field.code)?)?;
        Some(text_of(bytes))
    }

    fn time_s(&self, message: &[u8]) -> Option<f64> {
        let (index, per_s) = self.clock?;
        Some(self.fields.get(index)?.number(message)? / per_s)
    }

    fn instance(&self, message: &[u8]) -> usize {
        self.instance
            .and_then(|field| self.fields.get(field)?.number(message))
            .map_or(0, |number| number as usize)
    }
}

impl Field {
    /// `None` of text.
    fn number(&self, message: &[u8]) -> Option<f64> {
        let (kind, counts) = primitive(self.code)?;
        Some(kind.number(message, self.offset)? / counts)
    }

    fn is_number(&self) -> bool {
        primitive(self.code).is_some()
    }
}

/// The kind of number that a code stands for, and how many of its counts are one.
fn primitive(code: u8) -> Option<(Primitive, f64)> {
    Some(match code {
        b'b' => (Primitive::I8, 1.0),
        b'B' | b'M' => (Primitive::U8, 1.0),
        b'h' => (Primitive::I16, 1.0),
        b'H' => (Primitive::U16, 1.0),
        b'i' => (Primitive::I32, 1.0),
        b'I' => (Primitive::U32, 1.0),
        b'q' => (Primitive::I64, 1.0),
        b'Q' => (Primitive::U64, 1.0),
        b'f' => (Primitive::F32, 1.0),
        b'd' => (Primitive::F64, 1.0),
        b'c' => (Primitive::I16, 100.0),
        b'C' => (Primitive::U16, 100.0),
        b'e' => (Primitive::I32, 100.0),
        b'E' => (Primitive::U32, 100.0),
        b'L' => (Primitive::I32, 1e7),
        _ => return None,
    })
}

/// Bytes of a field; `None` of a code that is unknown.
pub(crate) fn width(code: u8) -> Option<usize> {
    match code {
        b'g' => Some(2),
        b'n' => Some(4),
        b'N' => Some(16),
        b'a' | b'Z' => Some(64),
        code => primitive(code).map(|(kind, _)| kind.width()),
    }
}

impl DataFlash {
    /// Reads the file once for its kinds of messages and its parameters.
    pub fn open(file: Input) -> Result<Self, Fault> {
        let mut log = Self {
            bytes: Bytes::new(file)?,
            layouts: vec![None; 256],
            kinds: Vec::new(),
            parameters: Parameters::default(),
            steering: None,
            outputs: Vec::new(),
            is_submarine: false,
            aircraft: None,
            firmware: None,
            last_time_s: 0.0,
        };
        log.layouts[usize::from(FORMAT)] = Some(Layout {
            name: "FMT".into(),
            length: FORMAT_LENGTH,
            fields: Vec::new(),
            clock: None,
            instance: None,
            kinds: [None; MOST_INSTANCES],
        });
        let mut instance_fields = BTreeMap::new();
        while let Some(number) = log.find_message()? {
            log.learn(number, &mut instance_fields)?;
        }
        if log.kinds.is_empty() {
            return Err(Fault::NothingToRead {
                format: "DataFlash",
                what: "there is nothing but descriptions of messages".into(),
            });
        }
        log.steering = Steering::find(&log.parameters, OUTPUTS);
        if let Some(kind) = log.kinds.iter_mut().find(|kind| kind.name == "RCOU")
            && log.steering.is_some()
        {
            let position = |name: String| kind.fields.iter().position(|field| *field == name);
            log.outputs = (1..=OUTPUTS).map(|n| position(format!("C{n}"))).collect();
            kind.fields.push(STEERING.into());
        }
        log.bytes.begin_again()?;
        Ok(log)
    }

    /// Goes to the next complete message and says its type.
    fn find_message(&mut self) -> Result<Option<u8>, Fault> {
        self.bytes.find_packet(LONGEST, |seen| {
            let number = seen.get(MARK.len()).copied().filter(|_| seen.starts_with(&MARK));
            let layout = |number: u8| Some((number, self.layouts[usize::from(number)].as_ref()?));
            match number.and_then(layout) {
                Some((number, layout)) if seen.len() >= layout.length => Found::Packet(number),
                Some(_) => Found::Cut,
                None if MARK.starts_with(seen) => Found::Cut,
                None => Found::Nothing(1),
            }
        })
    }

    /// Takes what a message says about the others, and its own kind.
    fn learn(
        &mut self,
        number: u8,
        instance_fields: &mut BTreeMap<u8, usize>,
    ) -> Result<(), Fault> {
        let Some(layout) = &mut self.layouts[usize::from(number)] else {
            return Ok(());
        };
        let length = layout.length;
        let message = &self.bytes.peek(length)?[..length];
        match layout.name.as_str() {
            "FMT" => {
                if let Some((described, mut new)) = Layout::of(&message[HEADER..]) {
                    new.instance = instance_fields.get(&described).copied();
                    // A second description of a type would change messages that were already read.
                    self.layouts[usize::from(described)].get_or_insert(new);
                }
            }
            "FMTU" => {
                let described = layout.number(message, "FmtType");
                let units = layout.text(message, "UnitIds");
                if let (Some(described), Some(units)) = (described, units)
                    && let Some(field) = units.bytes().position(|unit| unit == b'#')
                {
                    let described = described as u8;
                    instance_fields.insert(described, field);
                    if let Some(layout) = &mut self.layouts[usize::from(described)] {
                        layout.instance = Some(field);
                    }
                }
            }
            "PARM" => {
                let name = layout.text(message, "Name");
                let value = layout.number(message, "Value");
                if let (Some(name), Some(value)) = (name, value) {
                    self.parameters.insert(name, value);
                }
            }
            "MSG" => {
                let text = layout.text(message, "Message").unwrap_or_default();
                self.is_submarine |= text.starts_with("ArduSub");
                self.aircraft = self.aircraft.or(aircraft_of_firmware(&text));
                if self.firmware.is_none() && is_firmware(&text) {
                    self.firmware = Some(clipped(text.trim()));
                }
            }
            "UNIT" | "MULT" => {}
            _ => {
                let instance = layout.instance(message);
                if layout.kinds.get(instance) == Some(&None) {
                    layout.kinds[instance] = Some(self.kinds.len());
                    self.kinds.push(layout.kind(instance));
                }
            }
        }
        self.bytes.skip(length);
        Ok(())
    }
}

/// What a firmware flies, by how it calls itself.
fn aircraft_of_firmware(text: &str) -> Option<&'static str> {
    [
        ("ArduCopter", "a copter"),
        ("APM:Copter", "a copter"),
        ("ArduPlane", "a plane"),
        ("APM:Plane", "a plane"),
        ("Blimp", "an airship"),
    ]
    .into_iter()
    .find_map(|(firmware, aircraft)| text.starts_with(firmware).then_some(aircraft))
}

/// Is it how a firmware calls itself, with its version?
fn is_firmware(text: &str) -> bool {
    let name = text.split_whitespace().next().unwrap_or_default();
    let is_known = ["ArduRover", "ArduSub", "APM:Rover"].contains(&name);
    is_known || aircraft_of_firmware(name).is_some()
}

impl Messages for DataFlash {
    fn firmware(&self) -> Option<&str> {
        self.firmware.as_deref()
    }

    fn aircraft(&self) -> Option<&'static str> {
        self.aircraft
    }

    fn kinds(&self) -> &[Kind] {
        &self.kinds
    }

    fn known(&self) -> Known {
        let mut known = Known::default();
        let has_outputs = self.kinds.iter().any(|kind| kind.name == "RCOU");
        match self.steering.filter(|_| has_outputs) {
            Some(steering) => known.add(
                Rudder,
                format!("RCOU.{STEERING}"),
                Some(Fraction),
                &steering.text(),
            ),
            None if has(&self.kinds, "RATE", "YOut") => known.add(
                Rudder,
                "RATE.YOut".into(),
                Some(Fraction),
                "no output is a rudder, and this is what the yaw controller asks of all of them",
            ),
            None => known.expects(
                Rudder,
                "RCOU messages and one of the outputs 1 to 14 with SERVOn_FUNCTION 21 (rudder), 26 (ground steering) or 73 and 74 (throttle left and right), or RATE messages",
                &self.parameters.functions(),
            ),
        }
        let is_in_air = |of: &KnownField| of.0 == Depth && !self.is_submarine;
        let fields = CHANNELS.into_iter().filter(|of| !is_in_air(of));
        known.add_fields(&self.kinds, fields);
        known.expects(Heading, "ATT messages", &names(&self.kinds));
        known
    }

    fn next(&mut self, wanted: &[bool], message: &mut Message) -> Result<bool, Fault> {
        while let Some(number) = self.find_message()? {
            let Some(layout) = &self.layouts[usize::from(number)] else {
                continue;
            };
            let length = layout.length;
            let bytes = &self.bytes.peek(length)?[..length];
            let time_s = layout.time_s(bytes).unwrap_or(self.last_time_s);
            self.last_time_s = time_s;
            let kind = layout.kinds.get(layout.instance(bytes)).copied().flatten();
            if let Some(kind) = kind.filter(|kind| wanted[*kind]) {
                let numbers = layout.fields.iter().filter(|field| field.is_number());
                let numbers = numbers.map(|field| field.number(bytes).unwrap_or(f64::NAN));
                message.set(kind, time_s, numbers);
                if let Some(steering) = self.steering.filter(|_| layout.name == "RCOU") {
                    let pulse_us = |output: usize| match self.outputs.get(output - 1) {
                        Some(Some(index)) => message.values[*index],
                        _ => f64::NAN,
                    };
                    let fraction = steering.fraction(pulse_us);
                    message.values.push(fraction);
                }
                self.bytes.skip(length);
                return Ok(true);
            }
            self.bytes.skip(length);
        }
        Ok(false)
    }

    fn bytes(&mut self) -> &mut Bytes {
        &mut self.bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_a_firmware_is_known_by_the_name_that_it_gives_itself() {
        for text in ["ArduRover V4.5.7 (1a2b3c4d)", "ArduSub V4.1.0", "ArduCopter V4.3.0"] {
            assert!(is_firmware(text), "{text}");
        }
        for text in ["", "Frame: BOAT", "ChibiOS: 88b84600"] {
            assert!(!is_firmware(text), "{text}");
        }
    }
}
