//! What the first lines of a text log say: how cells are separated and numbers written, and where the names are.

use std::collections::BTreeSet;

use super::decoded;
use super::number::{is_grouped, number, unit_behind};
use crate::Unit;
use crate::clock::{instant, time_of_day};

/// The most rows above the names of columns.
const MOST_TITLES: usize = 200;
/// Names of columns of rows without names that hold one value each.
const TOPIC: [&str; 3] = ["time", "topic", "value"];
/// So many rows show that they are of this kind.
const LEAST_ROWS_OF_TOPICS: usize = 4;
/// Time, heading and rudder.
pub(super) const LEAST_COLUMNS: usize = 3;

/// How cells are separated and numbers written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Dialect {
    /// `b' '`: any run of blanks and tabs.
    pub delimiter: u8,
    pub decimal_comma: bool,
}

/// What the first lines say about a text log.
pub(super) struct Header {
    pub dialect: Dialect,
    /// The line of the names, or the first that is no comment.
    pub line: u64,
    /// Names of columns in the comment above the first row, where that row is numbers or times; [`TOPIC`] of rows without names.
    pub in_comment: Option<Vec<String>>,
    /// What lines begin with that are no rows.
    pub comment: u8,
    /// The row under the names, where it holds units.
    pub units: Option<Vec<String>>,
    /// The unit behind the numbers of each column, where there is one.
    pub units_behind: Vec<Option<&'static str>>,
}

impl Header {
    pub fn find(start: &[u8]) -> Option<Self> {
        let start = start.strip_prefix(b"\xef\xbb\xbf").unwrap_or(start);
        let mut comments: [Option<&[u8]>; 2] = [None; 2];
        let mut lines = start
            .split(|&byte| byte == b'\n' || byte == b'\r')
            .filter(|line| !line.trim_ascii().is_empty());
        let mut sign = b'#';
        let first = loop {
            let line = lines.next()?;
            match line.split_first() {
                Some((first @ (b'#' | b'%'), text)) => {
                    (sign, comments) = (*first, [comments[1], Some(text)]);
                }
                _ => break line,
            }
        };
        let rows: Vec<&[u8]> = std::iter::once(first)
            .chain(lines)
            .take(MOST_TITLES + 20)
            .collect();
        let titles = titles(&rows);
        let (first, rows) = rows[titles..].split_first()?;
        let delimiter = delimiter(first);
        let rows = &rows[..rows.len().min(20)];
        let values = cells(first, delimiter);
        let are_values = values.iter().filter(|cell| is_value(cell)).count() >= LEAST_COLUMNS;
        let is_header =
            |names: &Vec<String>| names.len() == values.len() && !names.iter().any(|n| is_value(n));
        let [above, comment] = comments.map(|comment| {
            let names = comment.map(|comment| cells(comment, delimiter));
            names.filter(|_| are_values).filter(is_header)
        });
        let in_comment = match (above, comment) {
            (Some(names), Some(units)) if are_units(&units) => Some(with_units(&names, &units)),
            (_, Some(names)) => Some(names),
            (_, None) => {
                are_of_topics(first, rows, delimiter).then(|| TOPIC.map(str::to_owned).to_vec())
            }
        };
        let units = rows.first().map(|row| cells(row, delimiter));
        Some(Self {
            dialect: Dialect {
                delimiter,
                decimal_comma: has_decimal_commas(rows, delimiter),
            },
            line: if titles > 0 { line_of(start, first) } else { 1 },
            in_comment,
            comment: sign,
            units_behind: units_behind(rows, delimiter),
            units: units.filter(|cells| are_units(cells)),
        })
    }
}

/// Are rows without names above them times, topics and numbers, one value a row? Topics then come again.
fn are_of_topics(first: &[u8], rows: &[&[u8]], delimiter: u8) -> bool {
    let rows: Vec<Vec<String>> = std::iter::once(&first)
        .chain(rows)
        .map(|row| cells(row, delimiter))
        .collect();
    let is_row = |row: &Vec<String>| {
        matches!(&row[..], [time, topic, value]
            if is_value(time) && !is_value(topic) && topic.contains(char::is_alphabetic)
                && number(value, false).is_some())
    };
    let topics: BTreeSet<&str> = rows
        .iter()
        .filter_map(|row| row.get(1))
        .map(String::as_str)
        .collect();
    rows.len() >= LEAST_ROWS_OF_TOPICS && topics.len() < rows.len() && rows.iter().all(is_row)
}

/// The line in which a part of the start begins, from 1.
fn line_of(start: &[u8], part: &[u8]) -> u64 {
    let at = part.as_ptr() as usize - start.as_ptr() as usize;
    1 + start[..at].iter().filter(|&&byte| byte == b'\n').count() as u64
}

/// The rows above the names of columns: what a spreadsheet has for a title. The names are followed by numbers or times in
/// as many columns as a log needs, with a row of units between them or not.
fn titles(rows: &[&[u8]]) -> usize {
    let is_header = |at: usize| {
        let delimiter = delimiter(rows[at]);
        let names = cells(rows[at], delimiter);
        let is_name = |name: &&String| !name.is_empty() && !is_value(name);
        let below = |by: usize| rows.get(at + by).map(|row| cells(row, delimiter));
        let has_units = below(1).is_some_and(|row| are_units(&row));
        let values = below(1 + usize::from(has_units)).unwrap_or_default();
        names.iter().filter(is_name).count() >= LEAST_COLUMNS
            && values.len() >= LEAST_COLUMNS
            && values.iter().filter(|cell| is_value(cell)).count() >= LEAST_COLUMNS
    };
    (0..rows.len().min(MOST_TITLES))
        .find(|at| is_header(*at))
        .unwrap_or(0)
}

/// Is it a number with a point or a comma, or a time?
fn is_value(cell: &str) -> bool {
    number(cell, false).is_some()
        || number(cell, true).is_some()
        || instant(cell).is_some()
        || time_of_day(cell).is_some()
}

/// Are numbers written with a comma? Points of dates are none of numbers.
fn has_decimal_commas(rows: &[&[u8]], delimiter: u8) -> bool {
    let cells: Vec<String> = rows.iter().flat_map(|row| cells(row, delimiter)).collect();
    let has_point = cells
        .iter()
        .any(|cell| cell.contains('.') && !is_grouped(cell, '.') && number(cell, false).is_some());
    let is_comma = |cell: &String| {
        cell.contains(',') && !is_grouped(cell, ',') && number(cell, true).is_some()
    };
    !has_point && cells.iter().any(is_comma)
}

/// Is every cell a unit, or empty? `-` is none.
fn are_units(cells: &[String]) -> bool {
    let unit = |cell: &String| {
        cell.trim_matches(|c: char| "[]()\"".contains(c))
            .parse::<Unit>()
    };
    let is_none = |cell: &String| cell.is_empty() || cell == "-";
    cells.iter().all(|cell| is_none(cell) || unit(cell).is_ok())
        && cells.iter().any(|cell| unit(cell).is_ok())
}

/// Names of columns with the units of the row below: `speed [kn]`.
pub(super) fn with_units(names: &[String], units: &[String]) -> Vec<String> {
    let units = units
        .iter()
        .map(|unit| unit.trim_matches(|c: char| "[]()-\"".contains(c)));
    let units = units.chain(std::iter::repeat(""));
    names
        .iter()
        .zip(units)
        .map(|(name, unit)| match unit.is_empty() {
            true => name.clone(),
            false => format!("{name} [{unit}]"),
        })
        .collect()
}

/// The delimiter that stands in a header most often, outside quotes; blanks where none does.
fn delimiter(header: &[u8]) -> u8 {
    let mut counts = [(b',', 0), (b';', 0), (b'\t', 0), (b'|', 0)];
    let mut quoted = false;
    for byte in header {
        quoted ^= *byte == b'"';
        if let Some((_, count)) = counts.iter_mut().find(|(d, _)| d == byte && !quoted) {
            *count += 1;
        }
    }
    match counts.iter().max_by_key(|(_, count)| *count) {
        Some((delimiter, 1..)) => *delimiter,
        _ => b' ',
    }
}

fn cells(line: &[u8], delimiter: u8) -> Vec<String> {
    let text = decoded(line);
    if delimiter == b' ' {
        text.split_whitespace().map(String::from).collect()
    } else {
        let mut quoted = false;
        text.split(|c: char| {
            quoted ^= c == '"';
            c == char::from(delimiter) && !quoted
        })
        .map(|cell| cell.trim().trim_matches('"').to_string())
        .collect()
    }
}

/// The unit behind the numbers of each column; `None` where there is none, or where rows have different ones.
fn units_behind(rows: &[&[u8]], delimiter: u8) -> Vec<Option<&'static str>> {
    let rows: Vec<Vec<String>> = rows.iter().map(|row| cells(row, delimiter)).collect();
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    (0..columns)
        .map(|column| {
            let mut units = rows.iter().filter_map(|row| unit_behind(row.get(column)?));
            let first = units.next()?;
            units.all(|unit| unit == first).then_some(first)
        })
        .collect()
}
