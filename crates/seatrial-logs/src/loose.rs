//! Rows that are no samples yet: one value a row with its name, or columns that are filled at different rates.
//!
//! Both become messages: each name or column is a kind of its own, and [`MessageTable`] makes samples of them.

use std::collections::{BTreeMap, VecDeque};
use std::vec::IntoIter;

use crate::bytes::Bytes;
use crate::choice::ChannelChoice;
use crate::clock::Clock;
use crate::error::Fault;
use crate::input::Input;
use crate::look_ahead::Row;
use crate::matching::Matches;
use crate::message_table::{Kind, Message, MessageTable, Messages};
use crate::name::{ColumnName, StatedUnit};
use crate::table::{Cell, Table};
use crate::words::{is_among, words};
use crate::{Quantity, Unit};

/// Values that are held: 48 MB.
const MOST_VALUES: usize = 2_000_000;
/// Names of channels in one column.
const MOST_NAMES: usize = 10_000;
/// Cells on which the unit of the time is inferred.
const LOOK_AHEAD: usize = 20_000;
/// Under this share of rows that hold what the others hold, columns are filled at different rates.
const LEAST_FILLED: f64 = 0.75;
/// Words of a column that names the channel of its row.
const NAMES: &str = "series metric field measurement name path topic channel key signal variable parameter sensor \
    entity";
/// Names of the column of the values, and of that of their units.
const VALUES: &str = "value val values reading state";
const UNITS: &str = "unit units";

/// Values with their times and names.
struct Loose {
    kinds: Vec<Kind>,
    values: IntoIter<(f64, usize, f64)>,
    /// Where they came from.
    table: Box<dyn Table>,
    bytes: Bytes,
    left_out: u64,
}

/// Values on the way in.
struct Heap {
    kinds: Vec<Kind>,
    values: Vec<(f64, usize, f64)>,
    /// Is the time an instant? It is then in seconds since 1970.
    are_instants: bool,
    left_out: u64,
}

impl Heap {
    fn new(kinds: Vec<Kind>) -> Self {
        Self { kinds, values: Vec::new(), are_instants: false, left_out: 0 }
    }

    /// A name of the last row alone is one that was cut off.
    fn leave_out_the_last_kind(&mut self) {
        self.kinds.pop();
        let cut = self.kinds.len();
        self.values.retain(|(_, kind, _)| *kind != cut);
        self.left_out += 1;
    }

    fn push(&mut self, time: &Cell, kind: usize, value: f64) -> Result<(), Fault> {
        let time = match time {
            Cell::Number(time) | Cell::OfDay(time) if time.is_finite() => *time,
            Cell::Instant(instant) => {
                self.are_instants = true;
                instant.as_nanosecond() as f64 / 1e9
            }
            _ => {
                self.left_out += 1;
                return Ok(());
            }
        };
        if self.values.len() == MOST_VALUES {
            return Err(Fault::TooMuch {
                format: "text",
                what: format!("more than {MOST_VALUES} values, each in a row of its own"),
            });
        }
        self.values.push((time, kind, value));
        Ok(())
    }

    /// The values in the order of time, in seconds.
    fn into_table(
        mut self,
        table: Box<dyn Table>,
        column: &str,
        stated: Option<Unit>,
    ) -> Result<Box<dyn Table>, Fault> {
        if !self.are_instants {
            let times = self.values.iter().take(LOOK_AHEAD);
            let cells: Vec<Cell> = times.map(|(time, ..)| Cell::Number(*time)).collect();
            let found = Clock::find(&cells, stated);
            if found.is_doubtful {
                return Err(Fault::ImplausibleValues {
                    column: column.into(),
                    quantity: Quantity::Time,
                    largest: self.values.last().map_or(f64::NAN, |(time, ..)| *time),
                });
            }
            let start_s = found.clock.start_unix_s().unwrap_or(0.0);
            for (time, ..) in &mut self.values {
                let seconds = found.clock.seconds(&Cell::Number(*time));
                *time = seconds.map_or(f64::NAN, |seconds| start_s + seconds);
            }
            self.values.retain(|(time, ..)| time.is_finite());
        }
        self.values.sort_by(|one, two| one.0.total_cmp(&two.0));
        let format = table.format();
        let nothing = Input::of_memory(Vec::new());
        let loose = Loose {
            kinds: self.kinds,
            values: self.values.into_iter(),
            table,
            bytes: Bytes::new(nothing)?,
            left_out: self.left_out,
        };
        Ok(Box::new(MessageTable::new(format, Box::new(loose))))
    }
}

/// Without what was chosen for the time, whose column has become seconds.
fn without_time(mut choice: ChannelChoice) -> ChannelChoice {
    choice.columns.remove(&Quantity::Time);
    choice.units.remove(&Quantity::Time);
    choice
}

/// The unit of the time by choice or by its name.
fn unit_of_time(column: &str, choice: &ChannelChoice) -> Option<Unit> {
    let named = match ColumnName::new(column).unit(Quantity::Time) {
        StatedUnit::Known(unit) => Some(unit),
        StatedUnit::None | StatedUnit::Unknown(_) => None,
    };
    choice.units.get(&Quantity::Time).copied().or(named)
}

/// A table of one value a row as a table of samples; another as it is.
pub(crate) fn from_long(
    mut table: Box<dyn Table>,
    choice: ChannelChoice,
) -> Result<(Box<dyn Table>, ChannelChoice), Fault> {
    let Some(Long { time, value, names, has_unit }) = Long::find(table.columns(), &choice) else {
        return Ok((table, choice));
    };
    let column = table.columns()[time].clone();
    // `Value [°]`: the unit of all values.
    let of_all = table.columns()[value].find('[');
    let of_all = of_all.map_or_else(String::new, |at| table.columns()[value][at..].to_owned());
    let selected = [time, value].into_iter().chain(names);
    table.select(&selected.map(|column| (Quantity::Time, column)).collect::<Vec<_>>());
    let (mut heap, kind_of) = heaped(&mut *table)?;
    let telling = telling(&kind_of);
    for (name, kind) in &kind_of {
        heap.kinds[*kind].name = match has_unit {
            true => {
                let names = name.len() - 1;
                let unit = format!("[{}]", name[names]);
                with_unit(name_of(&name[..names], &telling[..names]), &unit)
            }
            false => with_unit(name_of(name, &telling), &of_all),
        };
    }
    let stated = unit_of_time(&column, &choice);
    let table = heap.into_table(table, &column, stated)?;
    Ok((table, without_time(choice)))
}

/// The values of the selected columns on a heap, and the kind of each name. A kind that only the last row has is cut off with it.
fn heaped(table: &mut dyn Table) -> Result<(Heap, BTreeMap<Vec<String>, usize>), Fault> {
    let mut heap = Heap::new(Vec::new());
    let mut kind_of: BTreeMap<Vec<String>, usize> = BTreeMap::new();
    let (mut cells, mut new_in_the_last_row) = (Vec::new(), None);
    loop {
        match table.next_row(&mut cells) {
            Ok(None) => break,
            Ok(Some(_)) => new_in_the_last_row = None,
            // Tables of other columns follow each other in exports of databases.
            Err(fault) if fault.is_in_one_row() => {
                heap.left_out += 1;
                continue;
            }
            Err(fault) => return Err(fault),
        }
        let [time, Cell::Number(value), names @ ..] = &cells[..] else {
            heap.left_out += 1;
            continue;
        };
        let name: Vec<String> = names.iter().map(text_of).collect();
        let kind = match kind_of.get(&name) {
            Some(kind) => *kind,
            None if heap.kinds.len() == MOST_NAMES => continue,
            None => {
                heap.kinds.push(Kind { name: String::new(), fields: vec![String::new()] });
                new_in_the_last_row = Some(name.clone());
                kind_of.insert(name, heap.kinds.len() - 1);
                heap.kinds.len() - 1
            }
        };
        heap.push(time, kind, *value)?;
    }
    if let Some(cut) = new_in_the_last_row.filter(|_| heap.kinds.len() > 1) {
        kind_of.remove(&cut);
        heap.leave_out_the_last_kind();
    }
    Ok((heap, kind_of))
}

/// The name with a unit in brackets, where it is one.
fn with_unit(name: String, unit: &str) -> String {
    match unit.trim_matches(['[', ']']).parse::<Unit>() {
        Ok(_) => format!("{name} {unit}"),
        Err(_) => name,
    }
}

fn text_of(cell: &Cell) -> String {
    match cell {
        Cell::Text(text) => text.to_string(),
        cell => cell.to_string(),
    }
}

/// Does each column of names tell channels apart? One name for all of them, such as the boat's, tells nothing.
fn telling(kind_of: &BTreeMap<Vec<String>, usize>) -> Vec<bool> {
    let Some(first) = kind_of.keys().next() else {
        return Vec::new();
    };
    let differs = |at: usize| kind_of.keys().any(|name| name[at] != first[at]);
    let is_only = kind_of.len() == 1;
    (0..first.len()).map(|at| is_only || differs(at)).collect()
}

/// The name of a row's channel: the texts of its columns but for `value`, which databases call a field without a name.
fn name_of(name: &[String], telling: &[bool]) -> String {
    let mut texts: Vec<&str> = Vec::new();
    for (text, _) in name.iter().zip(telling).filter(|(_, tells)| **tells) {
        if !text.is_empty() && text != "value" && !texts.contains(&text.as_str()) {
            texts.push(text);
        }
    }
    texts.join(".")
}

/// The columns of a table of one value a row.
struct Long {
    time: usize,
    value: usize,
    names: Vec<usize>,
    /// Is the last of the names the unit?
    has_unit: bool,
}

impl Long {
    fn find(columns: &[String], choice: &ChannelChoice) -> Option<Self> {
        let names_of = |quantity: Quantity| {
            let fits = move |name: &String| ColumnName::new(name).fit(quantity).map(|fit| fit.rank);
            (0..columns.len()).filter_map(move |at| Some((fits(&columns[at])?, at))).min()
        };
        if names_of(Quantity::Heading).is_some() && names_of(Quantity::Rudder).is_some() {
            return None;
        }
        let words: Vec<Vec<String>> = columns.iter().map(|name| words(name)).collect();
        let position = |of: &str| {
            columns.iter().position(|name| {
                // The unit behind the numbers stands in brackets.
                let words = crate::words::words(name.split('[').next().unwrap_or_default());
                matches!(&words[..], [word] if is_among(of, word))
            })
        };
        let is_name = |words: &&Vec<String>| words.iter().any(|word| is_among(NAMES, word));
        let (value, unit) = (position(VALUES)?, position(UNITS));
        let mut names: Vec<usize> = (0..columns.len()).filter(|at| is_name(&&words[*at])).collect();
        // InfluxDB writes the field before the measurement that it is a field of.
        names.sort_by_key(|at| words[*at].iter().any(|word| word == "field"));
        let chosen = choice.columns.get(&Quantity::Time);
        let time = match chosen {
            Some(chosen) => columns.iter().position(|name| name == chosen)?,
            // `_start` and `_stop` of InfluxDB name no time; `_time` does.
            None => names_of(Quantity::Time)?.1,
        };
        (!names.is_empty()).then(|| Self {
            time,
            value,
            names: [&names[..], unit.as_slice()].concat(),
            has_unit: unit.is_some(),
        })
    }
}

/// Are the columns filled at different rates? Hardly a row with a heading has a rudder then.
pub(crate) fn is_sparse(found: &Matches, rows: &VecDeque<Row>) -> bool {
    let position = |quantity: Quantity| found.matches.iter().position(|m| m.quantity == quantity);
    let (Some(heading), Some(rudder)) = (position(Quantity::Heading), position(Quantity::Rudder))
    else {
        return false;
    };
    let holds =
        |cells: &[Cell], at: usize| matches!(cells[at], Cell::Number(number) if !number.is_nan());
    let count =
        |of: &dyn Fn(&[Cell]) -> bool| rows.iter().flatten().filter(|(_, cells)| of(cells)).count();
    let headings = count(&|cells| holds(cells, heading));
    let rudders = count(&|cells| holds(cells, rudder));
    let both = count(&|cells| holds(cells, heading) && holds(cells, rudder));
    rudders > 0 && (both as f64) < LEAST_FILLED * headings as f64
}

/// A kind of each matched column; the time is no field: every row has it.
fn kinds_of_columns(found: &Matches, columns: &[String]) -> Vec<Kind> {
    let kinds = found.matches.iter().map(|m| match m.quantity {
        Quantity::Time => Kind::default(),
        _ => Kind { name: columns[m.column].clone(), fields: vec![String::new()] },
    });
    kinds.collect()
}

/// A table whose columns are filled at different rates as a table of samples.
pub(crate) fn from_sparse(
    mut table: Box<dyn Table>,
    found: &Matches,
    rows: VecDeque<Row>,
    choice: ChannelChoice,
) -> Result<(Box<dyn Table>, ChannelChoice), Fault> {
    let columns = table.columns().to_vec();
    let mut heap = Heap::new(kinds_of_columns(found, &columns));
    let at = found.matches.iter().position(|m| m.quantity == Quantity::Time);
    let Some(at) = at else {
        return Ok((table, choice));
    };
    let mut take = |cells: &[Cell]| -> Result<(), Fault> {
        for (kind, cell) in cells.iter().enumerate().filter(|(kind, _)| *kind != at) {
            match cell {
                Cell::Number(value) if !value.is_nan() => {
                    heap.push(&cells[at], kind, *value)?;
                }
                Cell::Missing | Cell::Number(_) => {}
                Cell::OfDay(_) | Cell::Instant(_) | Cell::Text(_) => heap.left_out += 1,
            }
        }
        Ok(())
    };
    let goes_on = |fault: &Fault| fault.is_in_one_row() && choice.drop_invalid;
    for row in rows {
        match row {
            Ok((_, cells)) => take(&cells)?,
            Err(fault) if goes_on(&fault) => {}
            Err(fault) => return Err(fault),
        }
    }
    let mut cells = Vec::new();
    loop {
        match table.next_row(&mut cells) {
            Ok(Some(_)) => take(&cells)?,
            Ok(None) => break,
            Err(fault) if goes_on(&fault) => {}
            Err(fault) => return Err(fault),
        }
    }
    let column = &columns[found.matches[at].column];
    let mut chosen = without_time(choice.clone());
    for m in found.matches.iter().filter(|m| m.quantity != Quantity::Time) {
        chosen.columns.insert(m.quantity, columns[m.column].clone());
    }
    let stated = unit_of_time(column, &choice);
    Ok((heap.into_table(table, column, stated)?, chosen))
}

impl Messages for Loose {
    fn kinds(&self) -> &[Kind] {
        &self.kinds
    }

    fn next(&mut self, wanted: &[bool], message: &mut Message) -> Result<bool, Fault> {
        let Some((time_s, kind, value)) = self.values.find(|(_, kind, _)| wanted[*kind]) else {
            return Ok(false);
        };
        message.set(kind, time_s, [value]);
        Ok(true)
    }

    fn bytes(&mut self) -> &mut Bytes {
        &mut self.bytes
    }

    fn sha256(&mut self) -> Result<String, Fault> {
        self.table.sha256()
    }

    fn position(&mut self) -> u64 {
        self.table.bytes_read()
    }

    fn warnings(&self) -> Vec<String> {
        let mut warnings = self.table.warnings();
        if self.left_out > 0 {
            let count = self.left_out;
            warnings.push(format!("{count} cells hold no number or no time and are left out"));
        }
        warnings
    }
}
