//! Lines of `key=value` or `key: value` as a table with a column for every key: InfluxDB's line protocol, and what programs print.
//!
//! ```text
//! boat,host=pi heading=45.1,rudder=2 1714564800100000000
//! 2024-05-01 12:00:00.1 INFO heading=45.1; rudder=2
//! ```

use std::collections::BTreeMap;
use std::io::{self, Read};

use crate::bytes::Bytes;
use crate::error::Fault;
use crate::input::Input;

const MOST_COLUMNS: usize = 256;
/// Lines that are looked at, of which most have keys.
const LINES: usize = 20;
/// The column of what stands in a line without a key and begins with a digit.
const TIME: &str = "time";
/// The key of a line whose measurement says what it is.
const VALUE: &str = "value";

/// Does a text begin with such lines?
pub(crate) fn is_start(start: &[u8]) -> bool {
    let text = String::from_utf8_lossy(start);
    let lines: Vec<&str> = text
        .lines()
        .filter(|line| !line.is_empty())
        .take(LINES)
        .collect();
    let has_numbers = |line: &&&str| {
        let values = pairs(line).into_values();
        // A measurement and its time, or more.
        values
            .filter(|value| value.starts_with(is_of_number))
            .count()
            >= 2
    };
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
    let (mut pairs, mut measurement, mut time) = (BTreeMap::new(), String::new(), Vec::new());
    let mut key_before = None;
    for part in parts(line) {
        let named = match key_before.take() {
            Some(key) => Some((key, part.clone())),
            None => part
                .split_once(['=', ':'])
                .filter(|(key, _)| key.starts_with(char::is_alphabetic))
                .map(|(key, value)| (key.to_owned(), value.to_owned())),
        };
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

/// The table as text, cells parted by tabs.
pub(crate) struct Lines {
    bytes: Bytes,
    columns: BTreeMap<String, usize>,
    row: Vec<u8>,
    given: usize,
}

impl Lines {
    /// Reads the file once for its keys.
    pub fn open(file: &Input) -> Result<Self, Fault> {
        let mut bytes = Bytes::new(file.another().map_err(Fault::read)?)?;
        let mut columns = BTreeMap::new();
        while let Some(line) = bytes.line()? {
            for name in pairs(&String::from_utf8_lossy(line)).into_keys() {
                let place = columns.len();
                if place < MOST_COLUMNS {
                    columns.entry(name).or_insert(place);
                }
            }
        }
        bytes.begin_again()?;
        let mut names: Vec<(&String, &usize)> = columns.iter().collect();
        names.sort_by_key(|(_, place)| **place);
        let names: Vec<&str> = names.into_iter().map(|(name, _)| name.as_str()).collect();
        let row = (names.join("\t") + "\n").into_bytes();
        Ok(Self {
            bytes,
            columns,
            row,
            given: 0,
        })
    }

    /// The row of the next line with keys; empty at the end.
    fn next_row(&mut self) -> Result<String, Fault> {
        loop {
            let Some(line) = self.bytes.line()? else {
                return Ok(String::new());
            };
            let pairs = pairs(&String::from_utf8_lossy(line));
            let mut cells = vec![String::new(); self.columns.len()];
            for (key, value) in pairs {
                if let Some(place) = self.columns.get(&key) {
                    cells[*place] = value;
                }
            }
            // A number that was cut off looks whole.
            if cells.iter().any(|cell| !cell.is_empty()) && !self.bytes.is_line_cut() {
                return Ok(cells.join("\t") + "\n");
            }
        }
    }
}

impl Read for Lines {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.given == self.row.len() {
            self.row = self.next_row().map_err(io::Error::other)?.into_bytes();
            self.given = 0;
        }
        let count = buffer.len().min(self.row.len() - self.given);
        buffer[..count].copy_from_slice(&self.row[self.given..self.given + count]);
        self.given += count;
        Ok(count)
    }
}
