//! Recordings of Signal K: deltas in JSON, one a line or an array of them, behind a time and a letter or not.
//!
//! Every path that has numbers is a channel; Signal K's numbers are in SI units, and its paths say what they are.

use serde_json::Value;

use crate::clock::instant;
use crate::line_log::{Channels, LineFormat};
use crate::nmea0183::time_before;

/// Path and source of a channel.
type Key = [String; 2];

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

/// Recordings of deltas.
pub(crate) struct Deltas;

impl LineFormat for Deltas {
    type Key = Key;

    fn read(&mut self, line: &str, is_cut: bool, channels: &mut Channels<Key>) -> bool {
        let Some(mut rest) = delta(line) else {
            // Sentences of other recordings stand between deltas.
            return !is_cut;
        };
        let before_s = time_before(&line[..line.len() - rest.len()]);
        while !rest.is_empty() {
            let mut values = serde_json::Deserializer::from_str(rest).into_iter::<Value>();
            let Some(Ok(delta)) = values.next() else {
                return false;
            };
            rest = rest[values.byte_offset()..].trim_start_matches([',', ']', ' ']);
            take(&delta, before_s, channels);
        }
        true
    }
}

fn take(delta: &Value, before_s: Option<f64>, channels: &mut Channels<Key>) {
    let list = |of: &Value, name: &str| of[name].as_array().cloned().unwrap_or_default();
    for update in list(delta, "updates") {
        let own = update["timestamp"].as_str().and_then(instant);
        let own_s = own.map(|time| time.as_duration().as_secs_f64());
        let Some(time_s) = own_s.or(before_s) else {
            continue;
        };
        let source = source(&update);
        let mut add = |path: &str, number: f64| {
            let key = [path.to_owned(), source.clone()];
            channels.add(key, [time_s, number], |channels| {
                let is_second = channels.kind_of.keys().any(|[of, _]| of == path);
                Some(match is_second {
                    true => format!("{source}: {path}"),
                    false => path.to_owned(),
                })
            });
        };
        for change in list(&update, "values") {
            let path = change["path"].as_str().unwrap_or_default();
            match (&change["value"], change["value"].as_f64()) {
                (_, Some(number)) => add(path, number),
                (Value::Object(parts), _) => {
                    for (name, part) in parts {
                        if let Some(number) = part.as_f64() {
                            add(&format!("{path}.{name}"), number);
                        }
                    }
                }
                _ => {}
            }
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
