//! Messages that canboat's analyzer wrote, one a line, as JSON or as text:
//! `2026-06-08-01:51:24.127 2 15 255 127250 Vessel Heading:  SID = 0; Heading = 78.4 deg; ...`

use serde_json::{Map, Value, json};

use super::MOST_KINDS;
use super::text::date_s;
use crate::bytes::Bytes;
use crate::error::Fault;
use crate::joined::{Kind, Message, Messages};
use crate::table::Known;
use crate::{Quantity, Unit};

/// What is read: number, field, and the quantity that it feeds, the preferred first. Angles are in degrees or radians, as the
/// analyzer was told.
const FIELDS: [(u64, &str, Option<Quantity>); 18] = [
    (127_250, "Heading", Some(Quantity::Heading)),
    (127_257, "Yaw", Some(Quantity::Heading)),
    (127_245, "Position", Some(Quantity::Rudder)),
    (127_245, "Angle Order", Some(Quantity::Rudder)),
    (127_237, "Commanded Rudder Angle", Some(Quantity::Rudder)),
    (127_251, "Rate", Some(Quantity::YawRate)),
    (128_259, "Speed Water Referenced", Some(Quantity::Speed)),
    (129_026, "SOG", Some(Quantity::Speed)),
    (127_257, "Roll", Some(Quantity::Roll)),
    (127_257, "Pitch", Some(Quantity::Pitch)),
    (127_252, "Heave", None),
    (127_488, "Speed", None),
    (127_489, "Percent Engine Load", None),
    (127_489, "Percent Engine Torque", None),
    (129_025, "Latitude", None),
    (129_025, "Longitude", None),
    (129_029, "Latitude", None),
    (129_029, "Longitude", None),
];

/// A heading beyond a turn in radians is in degrees, and with it every angle of the file.
const LARGEST_RAD: f64 = 6.3;

/// A file of objects.
pub(super) struct Objects {
    bytes: Bytes,
    kinds: Vec<Kind>,
    /// Place in [`FIELDS`], source and instance of every kind, and how many values it has.
    sources: Vec<((usize, u64, u64), u64)>,
    ready: Vec<(usize, f64, f64)>,
    largest_heading: f64,
}

/// Does a file begin with such messages?
pub(super) fn is_start(start: &[u8]) -> bool {
    let text = String::from_utf8_lossy(start);
    let lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
    // The analyzer begins with its version.
    let is_message = |line: &str| is_object(line) || of_text(line).is_some();
    lines.take(3).any(is_message)
}

/// Is the line a message in JSON? Signal K names the PGN of a source, too.
fn is_object(line: &str) -> bool {
    line.starts_with('{') && line.contains("\"pgn\"") && !line.contains("\"updates\"")
}

/// A message in text as the object that it is in JSON.
fn of_text(line: &str) -> Option<Value> {
    let (head, fields) = line.split_once(':').and_then(|(hours, _)| {
        // The first colon behind those of the time ends the description.
        let at = hours.len() + line[hours.len()..].find(' ')?;
        let end = at + line[at..].find(": ")?;
        Some((&line[..end], &line[end + 2..]))
    })?;
    let mut head = head.split_whitespace();
    let time = head.next().filter(|time| date_s(time).is_some())?;
    let mut count = || head.next()?.parse::<u64>().ok();
    let [_, source, _, number] = [count()?, count()?, count()?, count()?];
    let fields: Map<String, Value> = fields
        .split(';')
        .filter_map(|field| {
            let (name, value) = field.split_once('=')?;
            let number: f64 = value.split_whitespace().next()?.parse().ok()?;
            Some((name.trim().to_owned(), json!(number)))
        })
        .collect();
    Some(json!({"timestamp": time, "pgn": number, "src": source, "fields": fields}))
}

/// A field by its name, which one option of the analyzer writes in camel case.
fn field<'a>(fields: &'a Value, name: &str) -> Option<&'a Value> {
    let plain = |name: &str| -> String {
        let letters = name.chars().filter(|c| c.is_alphanumeric());
        letters.flat_map(char::to_lowercase).collect()
    };
    let is_it = |(known, _): &(&String, &Value)| plain(known) == plain(name);
    fields
        .get(name)
        .or_else(|| Some(fields.as_object()?.iter().find(is_it)?.1))
}

/// A number, or the value of an object with a name beside it.
fn as_number(value: &Value) -> Option<f64> {
    value.as_f64().or_else(|| value.get("value")?.as_f64())
}

impl Objects {
    /// Reads the file once for its sources.
    pub fn open(bytes: Bytes) -> Result<Self, Fault> {
        let mut log = Self {
            bytes,
            kinds: Vec::new(),
            sources: Vec::new(),
            ready: Vec::new(),
            largest_heading: 0.0,
        };
        log.bytes.begin_again()?;
        let mut message = Message::default();
        while log.next_value(None, &mut message)? {
            let ((place, ..), count) = &mut log.sources[message.kind];
            *count += 1;
            if FIELDS[*place].2 == Some(Quantity::Heading) {
                log.largest_heading = log.largest_heading.max(message.values[0]);
            }
        }
        log.bytes.begin_again()?;
        Ok(log)
    }

    fn next_value(
        &mut self,
        wanted: Option<&[bool]>,
        message: &mut Message,
    ) -> Result<bool, Fault> {
        loop {
            if let Some((kind, time_s, value)) = self.ready.pop() {
                if wanted.is_some_and(|wanted| !wanted[kind]) {
                    continue;
                }
                message.kind = kind;
                message.time_s = time_s;
                message.values = vec![value];
                return Ok(true);
            }
            let position = self.bytes.position();
            let Some(line) = self.bytes.line()? else {
                return Ok(false);
            };
            if line.is_empty() {
                continue;
            }
            let length = line.len();
            let object = match line.starts_with(b"{") {
                true => serde_json::from_slice::<Value>(line).ok(),
                false => of_text(&String::from_utf8_lossy(line)),
            };
            match object {
                Some(object) => self.take(&object, wanted.is_none()),
                None => self.bytes.not_a_line(position, length),
            }
        }
    }

    fn take(&mut self, object: &Value, is_new: bool) {
        let text = |name: &str| object.get(name).and_then(Value::as_str);
        let count = |name: &str| object.get(name).and_then(Value::as_u64);
        let time_s = text("timestamp").and_then(date_s);
        let (Some(time_s), Some(number)) = (time_s, count("pgn")) else {
            return;
        };
        let source = count("src").unwrap_or(0);
        let Some(fields) = object.get("fields") else {
            return;
        };
        let instance = field(fields, "Instance").and_then(as_number).unwrap_or(0.0) as u64;
        let of_message = FIELDS
            .iter()
            .enumerate()
            .filter(|(_, (of, ..))| *of == number);
        for (place, (_, name, _)) in of_message {
            let Some(value) = field(fields, name).and_then(as_number) else {
                continue;
            };
            let key = (place, source, instance);
            let known = self.sources.iter().position(|(known, _)| *known == key);
            if let Some(kind) = known {
                self.ready.push((kind, time_s, value));
            } else if is_new && self.kinds.len() < MOST_KINDS {
                self.kinds.push(Kind {
                    name: format!("{number}.{source}.{instance}"),
                    fields: vec![name.to_string()],
                });
                self.sources.push((key, 0));
                self.ready.push((self.kinds.len() - 1, time_s, value));
            }
        }
    }
}

impl Messages for Objects {
    fn kinds(&self) -> &[Kind] {
        &self.kinds
    }

    fn known(&self) -> Known {
        let mut known = Known::default();
        for (place, (_, name, quantity)) in FIELDS.iter().enumerate() {
            let of_place = self
                .sources
                .iter()
                .enumerate()
                .filter(|(_, ((of, ..), _))| *of == place);
            let best = of_place.max_by_key(|(kind, (_, count))| (*count, std::cmp::Reverse(*kind)));
            if let (Some((kind, _)), Some(quantity)) = (best, quantity) {
                let in_degrees = self.largest_heading > LARGEST_RAD;
                let unit = match quantity {
                    Quantity::Speed => Some(Unit::MetrePerSecond),
                    Quantity::YawRate => in_degrees.then_some(Unit::DegreePerSecond),
                    _ => in_degrees.then_some(Unit::Degree),
                };
                known.add(
                    *quantity,
                    format!("{}.{name}", self.kinds[kind].name),
                    unit,
                    "",
                );
            }
        }
        for quantity in [Quantity::Heading, Quantity::Rudder] {
            known.lacks(quantity, "no PGN 127250 or 127245 with a value".into());
        }
        known
    }

    fn next(&mut self, wanted: &[bool], message: &mut Message) -> Result<bool, Fault> {
        self.next_value(Some(wanted), message)
    }

    fn bytes(&self) -> &Bytes {
        &self.bytes
    }

    fn bytes_mut(&mut self) -> &mut Bytes {
        &mut self.bytes
    }
}
