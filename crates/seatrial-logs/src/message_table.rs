//! Messages of many kinds, each at a rate of its own, joined into one table.
//!
//! A row is a message that holds the heading. Other quantities keep the value of their last message. What
//! the rudder did until the next row is the time mean of its commands meanwhile:
//!
//! ```text
//! rudder_k = 1 / (t_(k+1) - t_k) integral over t_k..t_(k+1) of the held output
//! ```
//!
//! so that a movement between two rows has its exact effect on the heading of the second. A yaw rate whose messages have times of their own
//! is straight between them: held, it would look late by up to the interval of its messages. All times are of
//! the vehicle's own clock, never of the message's arrival.

use std::collections::VecDeque;

use crate::bytes::{Bytes, Damage};
use crate::error::{Fault, Place};
use crate::format_name::Format;
use crate::table::{Cell, Known, KnownField, Table};
use crate::{Quantity, Unit};

/// Rows that wait for the rudder; the rows of a log whose rudder is silent for longer are given as they are.
const MOST_WAITING_ROWS: usize = 1024;
/// Changes of the rudder that are remembered between two rows.
const MOST_CHANGES: usize = 1 << 14;
/// Characters of the name of a kind in the names of its columns.
const LONGEST_NAME: usize = 256;
/// The column that every row has.
pub(crate) const TIME_COLUMN: &str = "time_s";

/// A kind of message: its name and its numeric fields. A kind of one field needs no name for it, and fields with names of their own
/// no name of the kind. Its columns are `name.field`.
#[derive(Clone, Debug, Default)]
pub struct Kind {
    /// Before the names of its fields.
    pub name: String,
    /// Names of its fields.
    pub fields: Vec<String>,
}

impl Kind {
    /// That of one of several sources, counted from 0, that give messages of this name.
    pub(crate) fn of_instance(name: &str, instance: usize, fields: Vec<String>) -> Self {
        match instance {
            0 => Self { name: name.into(), fields },
            _ => Self { name: format!("{name}.{instance}"), fields },
        }
    }
}

/// A message.
#[derive(Debug, Default)]
pub struct Message {
    /// The place of its kind among the kinds.
    pub kind: usize,
    /// On the vehicle's clock, s.
    pub time_s: f64,
    /// A number for each field of its kind; NaN without one.
    pub values: Vec<f64>,
}

impl Message {
    /// Becomes another message.
    pub(crate) fn set(&mut self, kind: usize, time_s: f64, values: impl IntoIterator<Item = f64>) {
        (self.kind, self.time_s) = (kind, time_s);
        self.values.clear();
        self.values.extend(values);
    }
}

/// A log as messages. Opening it reads the file once to learn which kinds there are.
pub trait Messages: Send {
    /// The kinds that occur.
    fn kinds(&self) -> &[Kind];

    /// What the format itself says about its channels; where it says nothing the names of columns decide, as for CSV.
    fn known(&self) -> Known {
        Known::default()
    }

    /// The next message of a kind that is wanted, by its place among the kinds; others may come, too. `false` at the end.
    ///
    /// # Errors
    /// A file that cannot be read further. What is damaged and has sound messages behind it is passed over and told in `warnings`.
    fn next(&mut self, wanted: &[bool], message: &mut Message) -> Result<bool, Fault>;

    /// The bytes of the file, which tell how far it is read and what of it is damaged.
    fn bytes(&mut self) -> &mut Bytes;

    /// SHA-256 of the whole file in hexadecimal, after the last message.
    ///
    /// # Errors
    /// The operating system refuses.
    fn sha256(&mut self) -> Result<String, Fault> {
        self.bytes().sha256()
    }

    /// Bytes consumed.
    fn position(&mut self) -> u64 {
        self.bytes().position()
    }

    /// What was left out beside damaged bytes, after the last message.
    fn warnings(&self) -> Vec<String> {
        Vec::new()
    }

    /// Was a part left out because it is damaged: by its checksum, or because it does not unpack? Asked after the last message.
    fn is_damaged(&self) -> bool {
        false
    }

    /// The aircraft that the log says it is of, with its article: a copter.
    fn aircraft(&self) -> Option<&'static str> {
        None
    }

    /// The firmware as the log names it: `ArduRover V4.5.7 (1a2b3c4d)`.
    fn firmware(&self) -> Option<&str> {
        None
    }
}

/// The name of the column of a field.
fn column_name(kind: &str, field: &str) -> String {
    match (kind, field) {
        (kind, "") => kind.to_string(),
        ("", field) => field.to_string(),
        (kind, field) => format!("{kind}.{field}"),
    }
}

/// The names of kinds, for messages.
pub(crate) fn names(kinds: &[Kind]) -> String {
    let names: Vec<&str> = kinds.iter().map(|kind| kind.name.as_str()).collect();
    names.join(", ")
}

/// Is a field of this name in a kind of this name?
pub(crate) fn has(kinds: &[Kind], name: &str, field: &str) -> bool {
    let mut of_name = kinds.iter().filter(|kind| kind.name == name);
    of_name.any(|kind| kind.fields.iter().any(|known| known == field))
}

/// The numbers that a field has had: how many, the last, and whether another came before.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FieldNumbers {
    pub count: u64,
    last: f64,
    pub changes: bool,
}

impl FieldNumbers {
    /// None yet, of each field of a kind.
    pub fn of(kind: &Kind) -> Vec<Self> {
        let none = Self { count: 0, last: f64::NAN, changes: false };
        vec![none; kind.fields.len()]
    }

    pub fn take(&mut self, value: f64) {
        if value.is_finite() {
            self.count += 1;
            self.changes |= self.last.is_finite() && self.last != value;
            self.last = value;
        }
    }
}

impl Known {
    /// Adds those of these fields that a log has.
    pub(crate) fn add_fields(
        &mut self,
        kinds: &[Kind],
        fields: impl IntoIterator<Item = KnownField>,
    ) {
        for (quantity, name, field, unit) in fields {
            if has(kinds, name, field) {
                self.add(quantity, column_name(name, field), unit, "");
            }
        }
    }
}

/// Messages as a table.
pub(crate) struct MessageTable {
    format: Format,
    messages: Box<dyn Messages>,
    columns: Vec<String>,
    /// Kind and field of every column; none of the time.
    sources: Vec<Option<(usize, usize)>>,
    selected: Vec<Selected>,
    wanted: Vec<bool>,
    heading_kind: Option<usize>,
    /// The rudder's columns by their positions in the row: one, or two whose difference steers.
    rudders: Vec<(usize, Output)>,
    yaw_rate: Option<Straight>,
    message: Message,
    waiting: VecDeque<Row>,
    is_at_end: bool,
    rows: u64,
    /// Bytes consumed, and those that are damaged.
    position: u64,
    damage: Damage,
}

/// A column of the rows to come.
struct Selected {
    source: Option<(usize, usize)>,
    latest: f64,
}

/// A column that is straight between its messages.
struct Straight {
    position: usize,
    source: (usize, usize),
    /// The time, s, and the value of the last message.
    last: Option<(f64, f64)>,
}

impl Straight {
    /// Takes in a message and gives the rows since the one before their values.
    fn take(&mut self, time_s: f64, value: f64, waiting: &mut VecDeque<Row>) {
        let since = self.last.filter(|(last_s, _)| *last_s < time_s);
        self.last = Some((time_s, value)).filter(|_| value.is_finite());
        let (Some((last_s, last)), true) = (since, value.is_finite()) else {
            return;
        };
        let rows = waiting.iter_mut().rev();
        for row in rows.take_while(|row| row.time_s >= last_s) {
            if row.time_s < time_s {
                let share = (row.time_s - last_s) / (time_s - last_s);
                row.values[self.position] = last + share * (value - last);
            }
        }
    }
}

/// A row whose rudder is not known yet.
struct Row {
    time_s: f64,
    values: Vec<f64>,
}

impl MessageTable {
    pub fn new(format: Format, mut messages: Box<dyn Messages>) -> Self {
        let mut columns = vec![TIME_COLUMN.to_string()];
        let mut sources = vec![None];
        for (kind, Kind { name, fields }) in messages.kinds().iter().enumerate() {
            // One long name before each of thousands of fields would be as many long names.
            let end = name.char_indices().nth(LONGEST_NAME).map_or(name.len(), |(at, _)| at);
            let name = &name[..end];
            for (field, field_name) in fields.iter().enumerate() {
                columns.push(column_name(name, field_name));
                sources.push(Some((kind, field)));
            }
        }
        Self {
            format,
            wanted: vec![false; messages.kinds().len()],
            position: messages.position(),
            damage: messages.bytes().damage,
            messages,
            columns,
            sources,
            selected: Vec::new(),
            heading_kind: None,
            rudders: Vec::new(),
            yaw_rate: None,
            message: Message::default(),
            waiting: VecDeque::new(),
            is_at_end: false,
            rows: 0,
        }
    }

    /// Takes in the message that was just read.
    fn take(&mut self) {
        let Message { kind, time_s, values } = &self.message;
        let same_time = self.waiting.back_mut().filter(|row| row.time_s == *time_s);
        let mut same_time = same_time.filter(|_| self.heading_kind != Some(*kind));
        for (position, selected) in self.selected.iter_mut().enumerate() {
            if let Some((_, field)) = selected.source.filter(|(of, _)| of == kind) {
                selected.latest = values.get(field).copied().unwrap_or(f64::NAN);
                if let Some(row) = &mut same_time {
                    row.values[position] = selected.latest;
                }
            }
        }
        if let Some(rate) = self.yaw_rate.as_mut().filter(|rate| rate.source.0 == *kind) {
            let value = values.get(rate.source.1).copied().unwrap_or(f64::NAN);
            rate.take(*time_s, value, &mut self.waiting);
        }
        let of_kind = |(_, rudder): &&mut (usize, Output)| rudder.source.0 == *kind;
        for (_, rudder) in self.rudders.iter_mut().filter(of_kind) {
            let value = values.get(rudder.source.1).copied().unwrap_or(f64::NAN);
            rudder.changes(*time_s, value);
        }
        if self.heading_kind == Some(*kind) {
            self.waiting.push_back(Row {
                time_s: *time_s,
                values: self.selected.iter().map(|s| s.latest).collect(),
            });
        }
    }

    /// The first waiting row, once it is known what the rudder did until the next.
    fn ready(&mut self) -> Option<Row> {
        let until_s = self.waiting.get(1).map(|next| next.time_s);
        let is_known = self.is_at_end
            || until_s.is_some_and(|until_s| {
                let is_known = |(_, rudder): &(usize, Output)| rudder.known_until_s >= until_s;
                self.rudders.iter().all(is_known) || self.waiting.len() > MOST_WAITING_ROWS
            });
        if !is_known {
            return None;
        }
        let mut row = self.waiting.pop_front()?;
        for (position, rudder) in &mut self.rudders {
            row.values[*position] = rudder.mean(row.time_s, until_s.unwrap_or(row.time_s));
        }
        Some(row)
    }
}

impl Table for MessageTable {
    fn format(&self) -> Format {
        self.format.clone()
    }

    fn aircraft(&self) -> Option<&'static str> {
        self.messages.aircraft()
    }

    fn firmware(&self) -> Option<&str> {
        self.messages.firmware()
    }

    fn columns(&self) -> &[String] {
        &self.columns
    }

    fn known(&self) -> Known {
        let mut known = self.messages.known();
        if !known.is_empty() {
            known.add(Quantity::Time, TIME_COLUMN.into(), Some(Unit::Second), "");
        }
        known
    }

    fn select(&mut self, columns: &[(Quantity, usize)]) {
        self.selected = columns
            .iter()
            .map(|&(_, column)| Selected { source: self.sources[column], latest: f64::NAN })
            .collect();
        for (position, &(quantity, column)) in columns.iter().enumerate() {
            if let Some(source) = self.sources[column] {
                self.wanted[source.0] = true;
                match quantity {
                    Quantity::Heading => self.heading_kind = Some(source.0),
                    Quantity::Rudder => self.rudders.push((position, Output::new(source))),
                    Quantity::YawRate => {
                        self.yaw_rate = Some(Straight { position, source, last: None });
                    }
                    _ => {}
                }
            }
        }
        // Rates of the heading's own messages have its times.
        let heading = self.heading_kind;
        self.yaw_rate.take_if(|rate| Some(rate.source.0) == heading);
    }

    fn leave_out(&mut self, position: usize) {
        self.selected.remove(position);
        let behind = self.rudders.iter_mut().filter(|(at, _)| *at > position);
        behind.for_each(|(at, _)| *at -= 1);
        self.yaw_rate.take_if(|rate| rate.position == position);
        if let Some(rate) = self.yaw_rate.as_mut().filter(|rate| rate.position > position) {
            rate.position -= 1;
        }
        for row in &mut self.waiting {
            row.values.remove(position);
        }
    }

    fn next_row(&mut self, cells: &mut Vec<Cell>) -> Result<Option<Place>, Fault> {
        let row = loop {
            match self.ready() {
                Some(row) => break row,
                None if self.is_at_end => return Ok(None),
                None => {}
            }
            let next = self.messages.next(&self.wanted, &mut self.message);
            self.position = self.messages.position();
            self.damage = self.messages.bytes().damage;
            match next? {
                true => self.take(),
                false => self.is_at_end = true,
            }
        };
        cells.clear();
        cells.extend(self.selected.iter().zip(&row.values).map(|(selected, value)| {
            match selected.source {
                None => Cell::Number(row.time_s),
                Some(_) if value.is_finite() => Cell::Number(*value),
                Some(_) => Cell::Missing,
            }
        }));
        self.rows += 1;
        Ok(Some(Place::Row(self.rows)))
    }

    fn bytes_read(&self) -> u64 {
        self.position
    }

    fn sha256(&mut self) -> Result<String, Fault> {
        self.messages.sha256()
    }

    fn warnings(&self) -> Vec<String> {
        [self.damage.warnings(), self.messages.warnings()].concat()
    }

    fn is_damaged(&self) -> bool {
        self.messages.is_damaged()
    }
}

/// The commands to an output, held from change to change.
struct Output {
    source: (usize, usize),
    /// Time and value, in the order of time.
    changes: VecDeque<(f64, f64)>,
    known_until_s: f64,
}

impl Output {
    fn new(source: (usize, usize)) -> Self {
        Self { source, changes: VecDeque::new(), known_until_s: f64::NEG_INFINITY }
    }

    fn changes(&mut self, time_s: f64, value: f64) {
        if self.changes.back().is_some_and(|(last, _)| time_s < *last) {
            self.changes.clear();
        }
        let is_the_same = |last: &(f64, f64)| last.1.to_bits() == value.to_bits();
        if !self.changes.back().is_some_and(is_the_same) {
            if self.changes.len() == MOST_CHANGES {
                self.changes.pop_front();
            }
            self.changes.push_back((time_s, value));
        }
        self.known_until_s = time_s;
    }

    /// The time mean from one time to another, where there was an output all the while.
    fn mean(&mut self, from_s: f64, to_s: f64) -> f64 {
        while self.changes.get(1).is_some_and(|(at, _)| *at <= from_s) {
            self.changes.pop_front();
        }
        let Some(&(first_s, first)) = self.changes.front() else {
            return f64::NAN;
        };
        if first_s > from_s {
            return f64::NAN;
        }
        if self.changes.get(1).is_none_or(|(at, _)| *at >= to_s) {
            return first;
        }
        let mut sum = 0.0;
        let (mut since_s, mut held) = (from_s, first);
        for &(at, value) in self.changes.iter().skip(1).take_while(|(at, _)| *at < to_s) {
            sum += held * (at - since_s);
            (since_s, held) = (at, value);
        }
        (sum + held * (to_s - since_s)) / (to_s - from_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows between two messages get their share of the change, rows before the first and behind a gap keep what is held.
    #[test]
    fn exact_a_yaw_rate_is_straight_between_its_messages() {
        let row = |time_s: f64| Row { time_s, values: vec![-1.0] };
        let mut waiting: VecDeque<Row> = [0.0, 1.0, 1.5, 2.0, 3.0].map(row).into();
        let mut rate = Straight { position: 0, source: (0, 0), last: None };
        for (time_s, value) in [(1.0, 10.0), (2.0, 30.0), (2.5, f64::NAN), (4.0, 50.0)] {
            rate.take(time_s, value, &mut waiting);
        }
        let values: Vec<f64> = waiting.iter().map(|row| row.values[0]).collect();
        assert_eq!(values, [-1.0, 10.0, 20.0, -1.0, -1.0]);
    }

    #[test]
    fn exact_an_output_is_averaged_over_the_interval_it_acts_in() {
        let mut output = Output::new((0, 0));
        for (time_s, value) in [(0.0, 1.0), (0.25, 1.0), (0.5, 3.0), (0.75, -1.0), (3.0, 8.0)] {
            output.changes(time_s, value);
        }
        assert!(output.mean(-1.0, 0.5).is_nan());
        assert_eq!(output.mean(0.0, 0.5), 1.0);
        assert_eq!(output.mean(0.0, 1.0), 0.5 + 0.75 - 0.25);
        assert_eq!(output.mean(0.5, 0.75), 3.0);
        assert_eq!(output.mean(1.0, 2.0), -1.0);
        assert_eq!(output.mean(3.0, 3.0), 8.0);
    }
}
