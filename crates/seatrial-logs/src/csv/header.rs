//! What the first lines of a text log say: how cells are separated and numbers written, and where the names are.

use std::collections::BTreeSet;

use super::decoded;
use super::number::{is_grouped, number, unit_behind};
use crate::clock::{instant, time_of_day};
use crate::name::{ColumnName, StatedUnit};
use crate::{Quantity, Unit};

/// The most rows above the names of columns.
const MOST_TITLES: usize = 200;
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";
/// Bytes of names of columns that may go over several lines.
const LONGEST_NAMES: usize = 4096;
/// Bytes of a first line that may be garbage, and lines of text behind them.
const MOST_GARBAGE: usize = 256;
const LEAST_LINES: usize = 3;
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
    /// Rows of units and rules between the names and the first numbers.
    pub below: usize,
    /// The row above the names: to what groups of columns belong.
    above: Option<Vec<String>>,
    /// The row of units among those below the names.
    units: Option<Vec<String>>,
    /// The unit behind the numbers of each column, where there is one.
    units_behind: Vec<Option<&'static str>>,
    /// The most cells of the rows.
    widest: usize,
}

impl Header {
    pub fn find(start: &[u8]) -> Option<Self> {
        let start = start.strip_prefix(BYTE_ORDER_MARK).unwrap_or(start);
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
        let rows: Vec<&[u8]> = std::iter::once(first).chain(lines).take(MOST_TITLES + 20).collect();
        let titles = titles(&rows);
        let groups = titles.checked_sub(1).map(|at| rows[at]);
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
            (Some(names), Some(units)) if are_units(&units) => {
                Some(with_units(&names, units.iter().map(String::as_str)))
            }
            (_, Some(names)) => Some(names),
            (_, None) => {
                are_of_topics(first, rows, delimiter).then(|| TOPIC.map(str::to_owned).to_vec())
            }
        };
        let between: Vec<Vec<String>> =
            rows.iter().take(3).map(|row| cells(row, delimiter)).collect();
        let below = below(&between);
        let widest = rows[below..].iter().map(|row| cells(row, delimiter).len());
        Some(Self {
            dialect: Dialect { delimiter, decimal_comma: has_decimal_commas(rows, delimiter) },
            line: if titles > 0 { line_of(start, first) } else { 1 },
            in_comment,
            comment: sign,
            below,
            above: groups.map(|row| cells(row, delimiter)),
            units: between.into_iter().take(below).find(|row| are_units(row)),
            units_behind: units_behind(rows, delimiter),
            widest: widest.max().unwrap_or(0),
        })
    }

    /// Names of columns with what the rows about them say: the group of a name that comes again or is a unit, and units.
    pub fn complete(&self, mut names: Vec<String>) -> Vec<String> {
        // LabVIEW names a column that its rows leave out.
        let is_left_out = |name: &String| name.eq_ignore_ascii_case("comment");
        if names.len() == self.widest + 1 && names.last().is_some_and(is_left_out) {
            names.pop();
        }
        if let Some(groups) = self.above.as_ref().filter(|row| row.len() >= names.len()) {
            let is_vague = |name: &String| {
                let again = names.iter().filter(|other| *other == name).count() > 1;
                again || name.parse::<Unit>().is_ok()
            };
            let of_group = names.iter().zip(groups).map(|(name, group)| match is_vague(name) {
                true => format!("{group} {name}").trim().to_owned(),
                false => name.clone(),
            });
            names = of_group.collect();
        }
        let below = self.units.iter().flatten().map(String::as_str);
        let behind = self.units_behind.iter().map(|unit| unit.unwrap_or(""));
        with_units(&with_units(&names, below), behind)
    }
}

pub(super) fn is_control(byte: &u8) -> bool {
    *byte < b'\t' || (0x0e..0x20).contains(byte) || *byte == 0x7f
}

/// Blanks the bytes that a logger wrote before its first line, where the lines behind them are text.
pub(super) fn blank_garbage(start: &mut [u8]) {
    let Some(end) = start.iter().position(|&byte| byte == b'\n') else {
        return;
    };
    if !start[..end].iter().any(is_control) {
        return;
    }
    let (first, rest) = start.split_at_mut(end);
    let is_text = |byte: &u8| matches!(*byte, b'\t' | b'\n' | b'\r' | b' '..=b'~');
    let lines = rest.iter().filter(|byte| **byte == b'\n').count();
    if first.len() <= MOST_GARBAGE && lines > LEAST_LINES && rest.iter().all(is_text) {
        for byte in first.iter_mut().filter(|byte| !is_text(byte)) {
            *byte = b' ';
        }
    }
}

/// Blanks the ends of lines within the names of columns that a spreadsheet quotes.
pub(super) fn join_quoted_names(start: &mut [u8]) {
    let mark = match start.starts_with(BYTE_ORDER_MARK) {
        true => BYTE_ORDER_MARK.len(),
        false => 0,
    };
    if start.get(mark) != Some(&b'"') {
        return;
    }
    let mut is_quoted = false;
    for byte in start[mark..].iter_mut().take(LONGEST_NAMES) {
        match byte {
            b'"' => is_quoted = !is_quoted,
            b'\n' | b'\r' if is_quoted => *byte = b' ',
            b'\n' => return,
            _ => {}
        }
    }
}

/// Does the name of a column state the unit of an angle?
fn states_a_unit(name: &str) -> bool {
    let angles = [Quantity::Heading, Quantity::YawRate];
    let name = ColumnName::new(name);
    angles.iter().any(|of| name.unit(*of) != StatedUnit::None)
}

/// How many of the rows under names are units, or lines of dashes; one of words may follow the units, as Campbell's loggers write it.
fn below(rows: &[Vec<String>]) -> usize {
    let is_rule = |row: &Vec<String>| {
        let cells = row.concat();
        !cells.is_empty() && !cells.contains(char::is_alphanumeric)
    };
    let is_none = |row: &Vec<String>| is_rule(row) || are_units(row);
    match rows {
        [one, two, three, ..] if is_none(one) && !has_values(two) && has_values(three) => 2,
        [one, ..] if is_none(one) => 1,
        _ => 0,
    }
}

/// Are there as many numbers or times as a log needs?
fn has_values(cells: &[String]) -> bool {
    cells.iter().filter(|cell| is_value(cell)).count() >= LEAST_COLUMNS
}

/// Are rows without names above them times, topics and numbers, one value a row? Topics then come again.
fn are_of_topics(first: &[u8], rows: &[&[u8]], delimiter: u8) -> bool {
    let rows: Vec<Vec<String>> =
        std::iter::once(&first).chain(rows).map(|row| cells(row, delimiter)).collect();
    let is_row = |row: &Vec<String>| {
        matches!(&row[..], [time, topic, value]
            if is_value(time) && !is_value(topic) && topic.contains(char::is_alphabetic)
                && number(value, false).is_some())
    };
    let topics: BTreeSet<&str> =
        rows.iter().filter_map(|row| row.get(1)).map(String::as_str).collect();
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
        let is_name = |name: &&String| name.contains(char::is_alphabetic) && !is_value(name);
        let under = rows[at + 1..].iter().take(3);
        let under: Vec<Vec<String>> = under.map(|row| cells(row, delimiter)).collect();
        names.iter().filter(is_name).count() >= LEAST_COLUMNS
            && under.get(below(&under)).is_some_and(|row| has_values(row))
    };
    (0..rows.len().min(MOST_TITLES)).find(|at| is_header(*at)).unwrap_or(0)
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
    let has_numbers_with = |mark: char| {
        let has_mark = |cell: &&String| cell.contains(mark) && !is_grouped(cell, mark);
        cells.iter().filter(has_mark).any(|cell| number(cell, mark == ',').is_some())
    };
    !has_numbers_with('.') && has_numbers_with(',')
}

/// Are at least half of the cells with words units, and none of them numbers? `-` is no word.
fn are_units(cells: &[String]) -> bool {
    let is_unit = |cell: &&String| bare(cell).parse::<Unit>().is_ok();
    let words = cells.iter().filter(|cell| !bare(cell).is_empty()).count();
    let units = cells.iter().filter(is_unit).count();
    units > 0 && 2 * units >= words && !cells.iter().any(|cell| is_value(cell))
}

/// A unit without what stands about it.
fn bare(cell: &str) -> &str {
    cell.trim_matches(|c: char| "[]()-\"".contains(c))
}

/// Names of columns with the units of the row below or behind their numbers, where they state none: `speed [kn]`.
fn with_units<'a>(names: &[String], units: impl Iterator<Item = &'a str>) -> Vec<String> {
    let units = units.map(bare).chain(std::iter::repeat(""));
    names
        .iter()
        .zip(units)
        .map(|(name, unit)| match unit.parse::<Unit>() {
            Ok(_) if !states_a_unit(name) => format!("{name} [{unit}]"),
            _ => name.clone(),
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
