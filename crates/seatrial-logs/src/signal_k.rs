//! Recordings of Signal K: deltas in JSON, one a line or an array of them, behind a time and a letter or not.
//!
//! Every path that has numbers is a kind of its own; Signal K's numbers are in SI units, and its paths say what they are.

use std::collections::{BTreeMap, VecDeque};

use serde_json::Value;

use crate::bytes::Bytes;
use crate::clock::instant;
use crate::error::Fault;
use crate::input::Input;
use crate::joined::{Kind, Message, Messages};
use crate::nmea0183::time_before;

const MOST_KINDS: usize = 10_000;

/// A recording.
pub(crate) struct Deltas {
    bytes: Bytes,
    kinds: Vec<Kind>,
    /// Kind by path and source.
    kind_of: BTreeMap<[String; 2], usize>,
    ready: VecDeque<(usize, f64, f64)>,
}

/// Is one of the first lines a delta?
pub(crate) fn is_start(start: &[u8]) -> bool {
    let text = String::from_utf8_lossy(start);
    let is_delta = |line: &str| delta(line).is_some_and(|json| json.contains("\"updates\""));
    text.lines().take(3).any(is_delta)
}

/// The JSON of a line.
fn delta(line: &str) -> Option<&str> {
    line.get(line.find('{')?..)
}

impl Deltas {
    /// Reads the file once for its paths.
    pub fn open(file: Input) -> Result<Self, Fault> {
        let mut log = Self {
            bytes: Bytes::new(file)?,
            kinds: Vec::new(),
            kind_of: BTreeMap::new(),
            ready: VecDeque::new(),
        };
        while log.next_line(true)? {
            log.ready.clear();
        }
        log.bytes.begin_again()?;
        Ok(log)
    }

    /// Takes in the next line; `false` at the end.
    fn next_line(&mut self, is_new: bool) -> Result<bool, Fault> {
        let position = self.bytes.position();
        let Some(line) = self.bytes.line()? else {
            return Ok(false);
        };
        let length = line.len();
        let line = String::from_utf8_lossy(line).into_owned();
        let Some(mut rest) = delta(&line) else {
            // Sentences of other recordings stand between deltas.
            if !line.is_empty() && self.bytes.is_line_cut() {
                self.bytes.not_a_line(position, length);
            }
            return Ok(true);
        };
        let before_s = time_before(&line[..line.len() - rest.len()]);
        while !rest.is_empty() {
            let mut values = serde_json::Deserializer::from_str(rest).into_iter::<Value>();
            let Some(Ok(delta)) = values.next() else {
                self.bytes.not_a_line(position, length);
                break;
            };
            rest = rest[values.byte_offset()..].trim_start_matches([',', ']', ' ']);
            self.take(&delta, before_s, is_new);
        }
        Ok(true)
    }

    fn take(&mut self, delta: &Value, before_s: Option<f64>, is_new: bool) {
        let list = |of: &Value, name: &str| of[name].as_array().cloned().unwrap_or_default();
        for update in list(delta, "updates") {
            let own = update["timestamp"].as_str().and_then(instant);
            let own_s = own.map(|time| time.as_duration().as_secs_f64());
            let Some(time_s) = own_s.or(before_s) else {
                continue;
            };
            let source = source(&update);
            for change in list(&update, "values") {
                let path = change["path"].as_str().unwrap_or_default();
                match (&change["value"], change["value"].as_f64()) {
                    (_, Some(number)) => self.push(path, &source, time_s, number, is_new),
                    (Value::Object(parts), _) => {
                        for (name, part) in parts {
                            if let Some(number) = part.as_f64() {
                                let path = format!("{path}.{name}");
                                self.push(&path, &source, time_s, number, is_new);
                            }
                        }
                    }
                    _ => {}
                }
            }
        }
    }

    fn push(&mut self, path: &str, source: &str, time_s: f64, number: f64, is_new: bool) {
        let key = [path.to_owned(), source.to_owned()];
        let known = self.kind_of.get(&key).copied();
        if let Some(kind) = known {
            self.ready.push_back((kind, time_s, number));
        } else if is_new && self.kinds.len() < MOST_KINDS {
            let is_second = self.kind_of.keys().any(|[of, _]| of == path);
            let name = match is_second {
                true => format!("{source}: {path}"),
                false => path.to_owned(),
            };
            self.kind_of.insert(key, self.kinds.len());
            self.kinds.push(Kind {
                name,
                fields: vec![String::new()],
            });
        }
    }
}

/// The name of an update's source, which older servers write in parts.
fn source(update: &Value) -> String {
    let text = |of: &Value| of.as_str().unwrap_or_default().to_owned();
    let parts = &update["source"];
    match parts.is_object() {
        true => [&parts["label"], &parts["src"]].map(text).join("."),
        false => text(&update["$source"]),
    }
}

impl Messages for Deltas {
    fn kinds(&self) -> &[Kind] {
        &self.kinds
    }

    fn next(&mut self, wanted: &[bool], message: &mut Message) -> Result<bool, Fault> {
        loop {
            while let Some((kind, time_s, value)) = self.ready.pop_front() {
                if wanted[kind] {
                    *message = Message {
                        kind,
                        time_s,
                        values: vec![value],
                    };
                    return Ok(true);
                }
            }
            if !self.next_line(false)? {
                return Ok(false);
            }
        }
    }

    fn bytes(&self) -> &Bytes {
        &self.bytes
    }

    fn bytes_mut(&mut self) -> &mut Bytes {
        &mut self.bytes
    }
}
