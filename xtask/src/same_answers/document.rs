//! One answer without what may differ between two runs of one binary.

use std::path::Path;

use anyhow::{Context, Result};
use serde_json::Value;

/// Fields that say where, when, how fast or with which version an answer was made.
const VOLATILE: [&str; 8] = [
    "path",
    "time_ms",
    "software_version",
    "recorded_by",
    "replayed_by",
    "started_utc",
    "finished_utc",
    "logbook",
];

/// What a command printed.
pub struct Document {
    /// Says which command on which log or vehicle.
    pub name: String,
    /// The exit code.
    pub exit: i32,
    /// The JSON document, `Null` where nothing was printed.
    pub value: Value,
}

impl Document {
    /// Fails where the output is not one JSON document.
    pub fn new(name: &str, exit: i32, stdout: &[u8], data: &Path) -> Result<Self> {
        let mut value = match stdout {
            [] => Value::Null,
            _ => serde_json::from_slice(stdout).with_context(|| name.to_owned())?,
        };
        let data = data.to_string_lossy();
        for_each(&mut value, &mut |value| match value {
            Value::Object(fields) => fields.retain(|name, _| !VOLATILE.contains(&name.as_str())),
            Value::String(text) => *text = text.replace(&*data, "DATA"),
            _ => {}
        });
        Ok(Self { name: name.to_owned(), exit, value })
    }
}

/// Visits every value of a document, from the outermost one in.
fn for_each(value: &mut Value, visit: &mut impl FnMut(&mut Value)) {
    visit(value);
    match value {
        Value::Object(fields) => fields.values_mut().for_each(|field| for_each(field, visit)),
        Value::Array(items) => items.iter_mut().for_each(|item| for_each(item, visit)),
        _ => {}
    }
}

/// Splits a document into what a program reads and the sentences that a person reads, which hold a blank.
pub fn split_sentences(value: &Value) -> (Value, Vec<String>) {
    let mut values = value.clone();
    let mut sentences = Vec::new();
    for_each(&mut values, &mut |value| match value {
        Value::String(text) if text.contains(' ') => {
            sentences.push(std::mem::replace(text, "a sentence".into()));
        }
        _ => {}
    });
    (values, sentences)
}

/// The first field, in the order of names, that differs, with both values.
pub fn first_difference(before: &Value, now: &Value) -> Option<String> {
    let here = |name: &str, before: Option<&Value>, now: Option<&Value>| match (before, now) {
        (Some(before), Some(now)) => {
            first_difference(before, now).map(|rest| format!("{name}{rest}"))
        }
        (Some(before), None) => Some(format!("{name}: {} -> absent", short(before))),
        (None, Some(now)) => Some(format!("{name}: absent -> {}", short(now))),
        (None, None) => None,
    };
    match (before, now) {
        (Value::Object(a), Value::Object(b)) => {
            let names: std::collections::BTreeSet<_> = a.keys().chain(b.keys()).collect();
            names.into_iter().find_map(|name| here(&format!(".{name}"), a.get(name), b.get(name)))
        }
        (Value::Array(a), Value::Array(b)) => (0..a.len().max(b.len()))
            .find_map(|index| here(&format!("[{index}]"), a.get(index), b.get(index))),
        _ if before == now => None,
        _ => Some(format!(": {} -> {}", short(before), short(now))),
    }
}

fn short(value: &Value) -> String {
    let text = value.to_string();
    match text.char_indices().nth(160) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn exact_the_first_difference_names_its_field() {
        let before = json!({"a": [1, {"b": 2.0}], "c": "x"});
        let now = json!({"a": [1, {"b": 2.5}], "c": "y"});
        let found = first_difference(&before, &now);
        assert_eq!(found.as_deref(), Some(".a[1].b: 2.0 -> 2.5"));
        assert_eq!(first_difference(&before, &before), None);
        let shorter = json!({"a": [1], "c": "x"});
        let found = first_difference(&before, &shorter);
        assert_eq!(found.as_deref(), Some(".a[1]: {\"b\":2.0} -> absent"));
    }

    #[test]
    fn exact_what_differs_between_two_runs_is_left_out() {
        let text = br#"{"path": "/d/x.csv", "methods": [{"time_ms": 3.5, "r2": 0.5}], "text": "in /d/x.csv"}"#;
        let document = Document::new("name", 0, text, Path::new("/d")).unwrap();
        let kept = json!({"methods": [{"r2": 0.5}], "text": "in DATA/x.csv"});
        assert_eq!(document.value, kept);
        let (values, sentences) = split_sentences(&document.value);
        assert_eq!(values["text"], "a sentence");
        assert_eq!(sentences, ["in DATA/x.csv"]);
    }
}
