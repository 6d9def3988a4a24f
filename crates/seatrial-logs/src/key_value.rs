//! Lines of `key=value` or `key: value`, and objects of JSON, as a table with a column for every key: InfluxDB's line protocol, messages as
//! `mavlogdump` writes them, and what programs print.
//!
//! ```text
//! {"time": 1714564800.1, "imu": {"heading": 45.1}, "rudder": 2}
//! boat,host=pi heading=45.1,rudder=2 1714564800100000000
//! 2024-05-01 12:00:00.1 INFO boat: heading=45.1; rudder=2
//! ```

use std::collections::{BTreeMap, VecDeque};
use std::io::Read;

use serde_json::Value;

use crate::as_text::Rows;
use crate::bytes::Bytes;
use crate::error::Fault;
use crate::input::Input;

const MOST_COLUMNS: usize = 256;
/// Bytes by which such a text is told.
const START: usize = 4096;
/// Bytes of an object, and numbers of a list in it.
const LONGEST_OBJECT: usize = 1 << 16;
const MOST_PARTS: usize = 16;
/// Lines that are looked at, of which most have keys.
const LINES: usize = 20;
/// The column of what stands in a line without a key and begins with a digit.
const TIME: &str = "time";
/// The key of a line whose measurement says what it is.
const VALUE: &str = "value";

/// Does a text begin with such lines?
pub(crate) fn is_start(start: &[u8]) -> bool {
    let text = String::from_utf8_lossy(start);
    let lines: Vec<&str> = text.lines().filter(|line| !line.is_empty()).take(LINES).collect();
    let has_numbers = |line: &&&str| {
        let values = pairs(line).into_values();
        // A measurement and its time, or more.
        values.filter(|value| value.starts_with(is_of_number)).count() >= 2
    };
    if start.trim_ascii_start().starts_with(b"{") || start.trim_ascii_start().starts_with(b"[{") {
        return Objects::are_at(start);
    }
    2 * lines.iter().filter(has_numbers).count() > lines.len()
}

fn is_of_number(letter: char) -> bool {
    letter.is_ascii_digit() || matches!(letter, '-' | '+' | '.')
}

/// The parts of a line between blanks, commas and semicolons that are in no quotes and behind no backslash.
fn parts(line: &str) -> Vec<String> {
    let (mut parts, mut is_quoted, mut letters) = (vec![String::new()], false, line.chars());
    while let Some(letter) = letters.next() {
        let last = parts.len() - 1;
        match letter {
            '"' => is_quoted = !is_quoted,
            '\\' => parts[last].extend(letters.next()),
            ' ' | ',' | ';' | '\t' if !is_quoted => parts.push(String::new()),
            letter => parts[last].push(letter),
        }
    }
    parts.retain(|part| !part.is_empty());
    parts
}

/// The values of a line by their columns.
fn pairs(line: &str) -> BTreeMap<String, String> {
    if let Some(pairs) = of_message(line) {
        return pairs;
    }
    let (mut pairs, mut measurement, mut time) = (BTreeMap::new(), String::new(), Vec::new());
    let mut key_before: Option<String> = None;
    for part in parts(line) {
        let own =
            part.split_once(['=', ':']).filter(|(key, _)| key.starts_with(char::is_alphabetic));
        let own = own.map(|(key, value)| (key.to_owned(), value.to_owned()));
        // `boat: heading=45.1` names who says it.
        let before = key_before.take();
        let named = own.or_else(|| Some((before?, part.clone())));
        match named {
            // A blank stands behind the sign.
            Some((key, value)) if value.is_empty() => {
                key_before = Some(key);
                continue;
            }
            Some((key, value)) if key == VALUE => pairs.insert(measurement.clone(), number(&value)),
            Some((key, value)) => pairs.insert(key, number(&value)),
            None => {
                let part = part.trim_matches(['[', ']', '(', ')']);
                match part.starts_with(|c: char| c.is_ascii_digit()) {
                    true => time.push(part.to_owned()),
                    false => measurement = part.to_owned(),
                }
                continue;
            }
        };
    }
    if !time.is_empty() && !pairs.is_empty() {
        pairs.entry(TIME.into()).or_insert_with(|| time.join(" "));
    }
    pairs
}

/// Whole numbers of the line protocol end with a letter.
fn number(value: &str) -> String {
    let digits = value.trim_end_matches(['i', 'u']);
    let is_whole = digits.parse::<i64>().is_ok();
    let value = if is_whole { digits } else { value };
    value.replace(['\t', '"'], " ")
}

/// Values of a message as `mavlogdump` prints it: `2024-05-01 12:00:00.10: ATTITUDE {roll : 0.1, yaw : 1.2}`.
fn of_message(line: &str) -> Option<BTreeMap<String, String>> {
    let (head, fields) = line.trim_end().strip_suffix('}')?.split_once(" {")?;
    let (time, name) = head.rsplit_once(": ")?;
    let pair = |field: &str| {
        let (key, value) = field.split_once(" : ")?;
        Some((format!("{name}.{}", key.trim()), number(value.trim())))
    };
    let mut pairs: BTreeMap<String, String> = fields.split(", ").filter_map(pair).collect();
    pairs.insert(TIME.into(), time.into());
    Some(pairs)
}

/// Objects of JSON, one a line or in an array.
#[derive(Default)]
struct Objects {
    text: Vec<u8>,
    depth: usize,
    is_quoted: bool,
    is_escaped: bool,
    /// Those that are complete.
    whole: VecDeque<Vec<u8>>,
}

impl Objects {
    /// Does a text begin with several that have numbers?
    fn are_at(start: &[u8]) -> bool {
        let mut objects = Self::default();
        for line in start.split(|byte| *byte == b'\n') {
            objects.take(line);
        }
        let has_numbers = |text: &Vec<u8>| {
            let pairs = of_object(text);
            let numbers = pairs.values().filter(|v| v.starts_with(is_of_number));
            numbers.count() >= 2
        };
        let begins = matches!(start.trim_ascii_start(), [b'{' | b'[', ..]);
        begins && objects.whole.len() >= 2 && objects.whole.iter().all(has_numbers)
    }

    /// Takes in a line, at the end of which no text in quotes goes on.
    fn take(&mut self, line: &[u8]) {
        for &byte in line {
            if self.depth > 0 {
                self.text.push(byte);
            }
            match byte {
                _ if self.is_escaped => self.is_escaped = false,
                b'\\' if self.is_quoted => self.is_escaped = true,
                b'"' if self.depth > 0 => self.is_quoted = !self.is_quoted,
                _ if self.is_quoted => {}
                b'{' => {
                    if self.depth == 0 {
                        self.text = vec![byte];
                    }
                    self.depth += 1;
                }
                b'}' if self.depth > 0 => {
                    self.depth -= 1;
                    if self.depth == 0 {
                        self.whole.push_back(std::mem::take(&mut self.text));
                    }
                }
                _ => {}
            }
            if self.text.len() > LONGEST_OBJECT {
                self.leave_out();
            }
        }
        if self.is_quoted {
            self.leave_out();
        }
    }

    /// Begins anew behind what is no object.
    fn leave_out(&mut self) {
        *self = Self { whole: std::mem::take(&mut self.whole), ..Self::default() };
    }
}

/// The values of an object by their columns, those of an object in it behind its name.
fn of_object(text: &[u8]) -> BTreeMap<String, String> {
    let mut pairs = BTreeMap::new();
    let Ok(object) = serde_json::from_slice::<Value>(text) else {
        return pairs;
    };
    // `mavlogdump --format json` writes the name of a message and its time apart from its fields.
    let meta = &object["meta"];
    match (meta["type"].as_str(), &meta["timestamp"], &object["data"]) {
        (Some(name), time, fields @ Value::Object(_)) => {
            flatten(TIME.into(), time, &mut pairs);
            flatten(name.into(), fields, &mut pairs);
        }
        _ => flatten(String::new(), &object, &mut pairs),
    }
    pairs
}

fn flatten(name: String, value: &Value, pairs: &mut BTreeMap<String, String>) {
    let within = |key: &str| match name.is_empty() {
        true => key.to_owned(),
        false => format!("{name}.{key}"),
    };
    match value {
        Value::Object(parts) => {
            for (key, part) in parts {
                flatten(within(key), part, pairs);
            }
        }
        Value::Array(parts) => {
            for (at, part) in parts.iter().enumerate().take(MOST_PARTS) {
                flatten(within(&at.to_string()), part, pairs);
            }
        }
        Value::Number(number) => drop(pairs.insert(name, number.to_string())),
        Value::String(text) => drop(pairs.insert(name, text.replace(['\t', '\n', '\r', '"'], " "))),
        Value::Bool(_) | Value::Null => {}
    }
}

/// The table as text, cells parted by tabs.
pub(crate) fn text(file: &Input) -> Result<impl Read + Send + 'static, Fault> {
    let mut lines = Lines::open(file)?;
    let mut names: Vec<(&String, &usize)> = lines.columns.iter().collect();
    names.sort_by_key(|(_, place)| **place);
    let names: Vec<&str> = names.into_iter().map(|(name, _)| name.as_str()).collect();
    let names = names.join("\t") + "\n";
    Ok(Rows::below(names, move || Ok(lines.next_row()?)))
}

/// Lines of keys and values, or objects.
struct Lines {
    bytes: Bytes,
    /// Those that were read and not given; `None` where lines are not in JSON.
    objects: Option<Objects>,
    columns: BTreeMap<String, usize>,
}

impl Lines {
    /// Reads the file once for its keys.
    fn open(file: &Input) -> Result<Self, Fault> {
        let mut bytes = Bytes::new(file.another().map_err(Fault::read)?)?;
        let are_objects = Objects::are_at(bytes.peek(START)?);
        let mut lines =
            Self { bytes, objects: are_objects.then(Objects::default), columns: BTreeMap::new() };
        while let Some(pairs) = lines.next_pairs()? {
            for name in pairs.into_keys() {
                let place = lines.columns.len();
                if place < MOST_COLUMNS {
                    lines.columns.entry(name).or_insert(place);
                }
            }
        }
        lines.bytes.begin_again()?;
        lines.objects = are_objects.then(Objects::default);
        Ok(lines)
    }

    fn next_pairs(&mut self) -> Result<Option<BTreeMap<String, String>>, Fault> {
        loop {
            if let Some(object) = self.objects.as_mut().and_then(|o| o.whole.pop_front()) {
                return Ok(Some(of_object(&object)));
            }
            let Some(line) = self.bytes.line()? else {
                return Ok(None);
            };
            match &mut self.objects {
                Some(objects) => objects.take(line),
                None => {
                    let pairs = pairs(&String::from_utf8_lossy(line));
                    // A number that was cut off looks whole.
                    let is_cut = self.bytes.is_line_cut();
                    return Ok(Some(if is_cut { BTreeMap::new() } else { pairs }));
                }
            }
        }
    }

    /// The row of the next line with keys; empty at the end.
    fn next_row(&mut self) -> Result<String, Fault> {
        while let Some(pairs) = self.next_pairs()? {
            let mut cells = vec![String::new(); self.columns.len()];
            for (key, value) in pairs {
                if let Some(place) = self.columns.get(&key) {
                    cells[*place] = value;
                }
            }
            if cells.iter().any(|cell| !cell.is_empty()) {
                return Ok(cells.join("\t") + "\n");
            }
        }
        Ok(String::new())
    }
}
