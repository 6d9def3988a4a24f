//! A table with columns that are computed from its own, and with the rows of one vehicle only.

use crate::Quantity;
use crate::choice::ChannelChoice;
use crate::computed::{Computed, computed};
use crate::error::{Fault, Place};
use crate::format_name::Format;
use crate::matching::column_named;
use crate::table::{Cell, Known, Table};

/// A table with computed columns behind its own.
pub(crate) struct View {
    table: Box<dyn Table>,
    columns: Vec<String>,
    computed: Vec<Computed>,
    /// Columns and the text that they have in the rows that count.
    wanted: Vec<(usize, String)>,
    /// Of each selected column: how many cells of the table it takes, and which computed column it is.
    selected: Vec<(usize, Option<usize>)>,
    cells: Vec<Cell>,
}

impl View {
    fn new(table: Box<dyn Table>, computed: Vec<Computed>, wanted: Vec<(usize, String)>) -> Self {
        let mut columns = table.columns().to_vec();
        columns.extend(computed.iter().map(|column| column.name.clone()));
        Self { table, columns, computed, wanted, selected: Vec::new(), cells: Vec::new() }
    }
}

/// The rows of a table that a choice wants.
pub(crate) fn wanted_rows(
    table: Box<dyn Table>,
    choice: &ChannelChoice,
) -> Result<Box<dyn Table>, Fault> {
    if choice.rows_where.is_empty() {
        return Ok(table);
    }
    let own = table.columns();
    let wanted = choice
        .rows_where
        .iter()
        .map(|(name, text)| Ok((column_named(name, own)?, text.clone())))
        .collect::<Result<Vec<_>, Fault>>()?;
    Ok(Box::new(View::new(table, Vec::new(), wanted)))
}

/// The table with the columns that a choice and the names of columns ask for, and the choice that names them.
pub(crate) fn with_computed(
    table: Box<dyn Table>,
    mut choice: ChannelChoice,
) -> Result<(Box<dyn Table>, ChannelChoice), Fault> {
    let is_known = !table.known().is_empty();
    choice.take_motors(table.columns(), is_known);
    // Logs of autopilots hold positions of several estimators.
    let has_coordinates = !is_known || matches!(table.format(), Format::Nmea0183 | Format::Canboat);
    let computed = computed(table.columns(), is_known, has_coordinates, &choice)?;
    if computed.is_empty() {
        return Ok((table, choice));
    }
    for column in &computed {
        choice.columns.insert(column.quantity, column.name.clone());
        if let Some(unit) = column.unit() {
            choice.units.entry(column.quantity).or_insert(unit);
        }
    }
    Ok((Box::new(View::new(table, computed, Vec::new())), choice))
}

/// Is this what a row has where it counts? Numbers are compared as numbers.
fn is_wanted(cell: &Cell, text: &str) -> bool {
    match (cell, text.parse::<f64>()) {
        (Cell::Number(number), Ok(wanted)) => *number == wanted,
        (Cell::Text(found), _) => **found == *text,
        (cell, _) => cell.to_string() == text,
    }
}

impl Table for View {
    fn format(&self) -> Format {
        self.table.format()
    }

    fn columns(&self) -> &[String] {
        &self.columns
    }

    fn known(&self) -> Known {
        self.table.known()
    }

    fn select(&mut self, columns: &[(Quantity, usize)]) {
        let own = self.columns.len() - self.computed.len();
        let mut cells = Vec::new();
        self.selected.clear();
        for &(quantity, column) in columns {
            let computed = column.checked_sub(own);
            let sources = match computed {
                Some(index) => self.computed[index].sources.clone(),
                None => vec![column],
            };
            self.selected.push((sources.len(), computed));
            cells.extend(sources.into_iter().map(|column| (quantity, column)));
        }
        // What a quantity of them is does not matter for them.
        cells.extend(self.wanted.iter().map(|(column, _)| (Quantity::Thrust, *column)));
        self.table.select(&cells);
    }

    fn leave_out(&mut self, position: usize) {
        let first: usize = self.selected[..position].iter().map(|(count, _)| count).sum();
        let (count, _) = self.selected.remove(position);
        for _ in 0..count {
            self.table.leave_out(first);
        }
    }

    fn next_row(&mut self, cells: &mut Vec<Cell>) -> Result<Option<Place>, Fault> {
        let own: usize = self.selected.iter().map(|(count, _)| count).sum();
        loop {
            let Some(place) = self.table.next_row(&mut self.cells)? else {
                return Ok(None);
            };
            let tests = self.cells[own.min(self.cells.len())..].iter();
            if !tests.zip(&self.wanted).all(|(cell, (_, text))| is_wanted(cell, text)) {
                continue;
            }
            cells.clear();
            let mut from = 0;
            for (count, computed) in &self.selected {
                let sources = &self.cells[from..from + count];
                from += count;
                cells.push(match computed {
                    Some(index) => self.computed[*index].cell(sources),
                    None => sources[0].clone(),
                });
            }
            return Ok(Some(place));
        }
    }

    fn origin_deg(&self) -> Option<[f64; 2]> {
        let computed = self.computed.iter().find_map(Computed::origin_deg);
        computed.or_else(|| self.table.origin_deg())
    }

    fn bytes_read(&self) -> u64 {
        self.table.bytes_read()
    }

    fn sha256(&mut self) -> Result<String, Fault> {
        self.table.sha256()
    }

    fn warnings(&self) -> Vec<String> {
        let mut warnings = self.table.warnings();
        warnings.extend(self.computed.iter().filter_map(Computed::remark));
        warnings
    }

    fn is_damaged(&self) -> bool {
        self.table.is_damaged()
    }

    fn aircraft(&self) -> Option<&'static str> {
        self.table.aircraft()
    }

    fn firmware(&self) -> Option<&str> {
        self.table.firmware()
    }
}
