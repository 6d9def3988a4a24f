//! Messages that canboat's analyzer wrote, one a line, as JSON or as text:
//! `2026-06-08-01:51:24.127 2 15 255 127250 Vessel Heading:  SID = 0; Heading = 78.4 deg; ...`

use std::cmp::Reverse;

use serde_json::{Map, Value, json};

use super::text::date_s;
use crate::line_log::{Channels, LineFormat};
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

/// Messages of the analyzer.
#[derive(Default)]
pub(super) struct Analyzed {
    largest_heading: f64,
}

/// Place in [`FIELDS`], source and instance.
type Key = (usize, u64, u64);

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
    fields.get(name).or_else(|| Some(fields.as_object()?.iter().find(is_it)?.1))
}

/// A number, or the value of an object with a name beside it.
fn as_number(value: &Value) -> Option<f64> {
    value.as_f64().or_else(|| value.get("value")?.as_f64())
}

impl Analyzed {
    /// Gives the values of a message to their channels; nothing of one without a time, a number or fields.
    fn take(&mut self, object: &Value, channels: &mut Channels<Key>) -> Option<()> {
        let count = |name: &str| object.get(name)?.as_u64();
        let time_s = date_s(object.get("timestamp")?.as_str()?)?;
        let (number, source) = (count("pgn")?, count("src").unwrap_or(0));
        let fields = object.get("fields")?;
        let instance = field(fields, "Instance").and_then(as_number).unwrap_or(0.0) as u64;
        let known = FIELDS.iter().enumerate();
        for (place, (_, name, quantity)) in known.filter(|(_, (of, ..))| *of == number) {
            if let Some(value) = field(fields, name).and_then(as_number) {
                if *quantity == Some(Quantity::Heading) {
                    self.largest_heading = self.largest_heading.max(value);
                }
                channels.add((place, source, instance), [time_s, value], |_| {
                    Some(format!("{number}.{source}.{instance}.{name}"))
                });
            }
        }
        Some(())
    }
}

impl LineFormat for Analyzed {
    type Key = Key;

    fn read(&mut self, line: &str, _is_cut: bool, channels: &mut Channels<Key>) -> bool {
        let object = match line.starts_with('{') {
            true => serde_json::from_str::<Value>(line).ok(),
            false => of_text(line),
        };
        object.map(|object| self.take(&object, channels)).is_some()
    }

    fn known(&self, channels: &Channels<Key>) -> Known {
        let mut known = Known::default();
        let in_degrees = self.largest_heading > LARGEST_RAD;
        for (place, (.., quantity)) in FIELDS.iter().enumerate() {
            let of_place = channels.kind_of.iter().filter(|((of, ..), _)| *of == place);
            let best = of_place.max_by_key(|(_, kind)| (channels.counts[**kind], Reverse(**kind)));
            if let (Some((_, kind)), Some(quantity)) = (best, quantity) {
                let unit = match quantity {
                    Quantity::Speed => Some(Unit::MetrePerSecond),
                    Quantity::YawRate => in_degrees.then_some(Unit::DegreePerSecond),
                    _ => in_degrees.then_some(Unit::Degree),
                };
                known.add(*quantity, channels.kinds[*kind].name.clone(), unit, "");
            }
        }
        for quantity in [Quantity::Heading, Quantity::Rudder] {
            known.lacks(quantity, "no PGN 127250 or 127245 with a value".into());
        }
        known
    }
}
