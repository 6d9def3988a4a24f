//! One file that holds many runs, which a column tells apart.

use std::collections::{HashSet, VecDeque};
use std::path::Path;
use std::sync::Arc;

use crate::Quantity;
use crate::choice::{ChannelChoice, mirrored};
use crate::content::table;
use crate::description::LogDescription;
use crate::error::{Fault, Place, ReadError, clipped};
use crate::format_name::Format;
use crate::input::FileMap;
use crate::reader::{LogReader, open_in};
use crate::table::{Cell, Table};
use crate::view::{wanted_rows, with_computed};

/// The most rows of a run that are held in memory: some 100 MB.
const MOST_ROWS: usize = 500_000;

/// Larger integers are not distinct as floating-point numbers.
const MOST_NUMBER: f64 = 9_007_199_254_740_992.0;

/// The runs of a file, one by one, each a log of its own. One run is in memory at a time.
pub struct Runs {
    log: String,
    table: Box<dyn Table>,
    description: LogDescription,
    choice: Arc<ChannelChoice>,
    /// The columns that are read; the last tells the runs apart.
    columns: Vec<String>,
    seen: HashSet<Box<str>>,
    /// The first row of the next run.
    ahead: Option<(Place, Vec<Cell>)>,
    is_finished: bool,
}

/// A run of a file.
pub struct Run {
    /// As the column has it.
    pub id: String,
    log: String,
    rows: Result<Gathered, Fault>,
    choice: Arc<ChannelChoice>,
}

impl Run {
    /// Its samples.
    pub fn open(self) -> Result<LogReader, ReadError> {
        let Self { log, rows, choice, .. } = self;
        rows.and_then(|rows| LogReader::new(log.clone(), Box::new(rows), &choice))
            .map_err(|fault| ReadError { log, fault })
    }
}

impl Runs {
    /// Opens a file whose rows belong to runs. Columns and units are found as for a single log and are then the same
    /// for every run.
    pub fn open(path: &Path, choice: &ChannelChoice, run_column: &str) -> Result<Self, ReadError> {
        Self::open_in(path, &FileMap::default(), choice, run_column)
    }

    /// As [`open`](Self::open), of files that may be held.
    pub fn open_in(
        path: &Path,
        held: &FileMap,
        choice: &ChannelChoice,
        run_column: &str,
    ) -> Result<Self, ReadError> {
        let description = open_in(path, held, choice)?.description().clone();
        let log = path.display().to_string();
        table(path, held, &choice.formats)
            .and_then(|table| Self::new(log.clone(), table, description, choice, run_column))
            .map_err(|fault| ReadError { log, fault })
    }

    fn new(
        log: String,
        table: Box<dyn Table>,
        description: LogDescription,
        choice: &ChannelChoice,
        run_column: &str,
    ) -> Result<Self, Fault> {
        let mut choice = choice.clone();
        choice.take_motors(table.columns(), !table.known().is_empty());
        // Each run takes half differences itself.
        let halves = std::mem::take(&mut choice.half_differences);
        let (mut table, mut choice) = with_computed(wanted_rows(table, &choice)?, choice)?;
        choice.half_differences = halves;
        choice.rows_where.clear();
        let mut columns: Vec<String> = Vec::new();
        for channel in &description.channels {
            choice.units.insert(channel.quantity, channel.unit);
            match choice.half_differences.get(&channel.quantity) {
                Some([first, second]) => {
                    let second = mirrored(second).unwrap_or(second);
                    columns.extend([first.clone(), second.to_owned()]);
                }
                None => {
                    choice.columns.insert(channel.quantity, channel.column.clone());
                    columns.push(channel.column.clone());
                }
            }
        }
        for quantity in Quantity::ALL {
            let is_read = description.channels.iter().any(|c| c.quantity == quantity);
            if !is_read {
                choice.columns.insert(quantity, "none".into());
            }
        }
        columns.push(run_column.into());
        let Some(selected) = places(&*table, &columns) else {
            return Err(Fault::NoRunColumn {
                name: run_column.into(),
                columns: description.columns,
            });
        };
        table.select(&selected);
        Ok(Self {
            log,
            table,
            description,
            choice: Arc::new(choice),
            columns,
            seen: HashSet::new(),
            ahead: None,
            is_finished: false,
        })
    }

    /// What the file is and how it is read.
    pub fn description(&self) -> &LogDescription {
        &self.description
    }

    /// Bytes of the file consumed so far.
    pub fn bytes_read(&self) -> u64 {
        self.table.bytes_read()
    }

    /// The next row and the run that it belongs to.
    fn next_row(&mut self) -> Result<Option<(Place, Vec<Cell>, String)>, Fault> {
        let (place, cells) = match self.ahead.take() {
            Some(row) => row,
            None => {
                let mut cells = Vec::with_capacity(self.columns.len());
                match self.table.next_row(&mut cells)? {
                    Some(place) => (place, cells),
                    None => return Ok(None),
                }
            }
        };
        let id = match cells.last() {
            Some(Cell::Number(number)) if number.abs() >= MOST_NUMBER || number.is_nan() => {
                return Err(Fault::NotANumber {
                    place,
                    column: self.columns.last().map_or_else(String::new, |c| clipped(c)),
                    found: number.to_string(),
                    expected: "the run as text or as a whole number below 2^53",
                });
            }
            Some(Cell::Text(text)) => text.to_string(),
            Some(cell) => cell.to_string(),
            None => String::new(),
        };
        Ok(Some((place, cells, id)))
    }

    /// Gathers the rows of the next run.
    fn next_run(&mut self) -> Result<Option<Run>, Fault> {
        let Some((first_place, first, id)) = self.next_row()? else {
            return Ok(None);
        };
        let mut rows = VecDeque::from([Ok((first_place, first))]);
        let mut is_long = false;
        loop {
            match self.next_row() {
                Ok(Some((place, cells, other))) if other != id => {
                    self.ahead = Some((place, cells));
                    break;
                }
                Ok(Some((place, cells, _))) if rows.len() < MOST_ROWS => {
                    rows.push_back(Ok((place, cells)));
                }
                Ok(Some(_)) => is_long = true,
                Ok(None) => break,
                Err(fault) if fault.is_in_one_row() => rows.push_back(Err(fault)),
                Err(fault) => return Err(fault),
            }
        }
        let rows = if !self.seen.insert(id.clone().into()) {
            Err(Fault::ScatteredRun { place: first_place, run: id.clone() })
        } else if is_long {
            Err(Fault::LongRun { run: id.clone(), limit: MOST_ROWS })
        } else {
            Ok(Gathered {
                format: self.table.format(),
                columns: self.columns.clone(),
                rows,
                selected: Vec::new(),
                is_damaged: self.table.is_damaged(),
            })
        };
        Ok(Some(Run { id, log: self.log.clone(), rows, choice: Arc::clone(&self.choice) }))
    }

    fn error(&self, fault: Fault) -> ReadError {
        ReadError { log: self.log.clone(), fault }
    }
}

impl Iterator for Runs {
    type Item = Result<Run, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.is_finished {
            return None;
        }
        let next = self.next_run().map_err(|fault| self.error(fault));
        self.is_finished = matches!(next, Err(_) | Ok(None));
        next.transpose()
    }
}

/// The rows of one run.
struct Gathered {
    format: Format,
    columns: Vec<String>,
    rows: VecDeque<Result<(Place, Vec<Cell>), Fault>>,
    selected: Vec<usize>,
    /// Is the file that it is of?
    is_damaged: bool,
}

impl Table for Gathered {
    fn format(&self) -> Format {
        self.format.clone()
    }

    fn columns(&self) -> &[String] {
        &self.columns
    }

    fn select(&mut self, columns: &[(Quantity, usize)]) {
        self.selected = columns.iter().map(|(_, column)| *column).collect();
    }

    fn leave_out(&mut self, position: usize) {
        self.selected.remove(position);
    }

    fn next_row(&mut self, cells: &mut Vec<Cell>) -> Result<Option<Place>, Fault> {
        let Some(row) = self.rows.pop_front() else {
            return Ok(None);
        };
        let (place, row) = row?;
        cells.clear();
        cells.extend(self.selected.iter().map(|&column| row[column].clone()));
        Ok(Some(place))
    }

    fn bytes_read(&self) -> u64 {
        0
    }

    /// The file is that of all runs.
    fn sha256(&mut self) -> Result<String, Fault> {
        Ok(String::new())
    }

    fn warnings(&self) -> Vec<String> {
        Vec::new()
    }

    fn is_damaged(&self) -> bool {
        self.is_damaged
    }
}

/// Where columns stand in a table; `None` where one is missing, or where the table does not tell its columns by a header.
fn places(table: &dyn Table, columns: &[String]) -> Option<Vec<(Quantity, usize)>> {
    let position = |name: &String| table.columns().iter().position(|column| column == name);
    let places = columns.iter().map(|name| Some((Quantity::Time, position(name)?)));
    let places: Option<Vec<_>> = places.collect();
    places.filter(|_| table.known().is_empty())
}
