//! Columns that are half the difference of two others: a pair of fins, or two thrusters.

use crate::Quantity;
use crate::description::Format;
use crate::error::{Fault, Place};
use crate::table::{Cell, Known, Table};

/// The name of half the difference of two columns.
pub(crate) fn name([first, second]: &[String; 2]) -> String {
    format!("({first} - {second}) / 2")
}

/// A table with such columns behind its own.
pub(crate) struct WithDifferences {
    table: Box<dyn Table>,
    columns: Vec<String>,
    differences: Vec<[usize; 2]>,
    /// Is a selected column a difference?
    is_difference: Vec<bool>,
    cells: Vec<Cell>,
}

impl WithDifferences {
    pub fn new(table: Box<dyn Table>, differences: Vec<[usize; 2]>) -> Self {
        let mut columns = table.columns().to_vec();
        columns.extend(
            differences
                .iter()
                .map(|pair| name(&pair.map(|column| table.columns()[column].clone())))
                .collect::<Vec<_>>(),
        );
        Self {
            table,
            columns,
            differences,
            is_difference: Vec::new(),
            cells: Vec::new(),
        }
    }
}

/// Half of what a cell has more than another.
fn half_difference(first: &Cell, second: &Cell) -> Cell {
    match (first, second) {
        (Cell::Number(first), Cell::Number(second)) => Cell::Number(0.5 * (first - second)),
        (Cell::Number(_), other) | (other, _) => other.clone(),
    }
}

impl Table for WithDifferences {
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
        let own = self.columns.len() - self.differences.len();
        let mut selected = Vec::new();
        for &(quantity, column) in columns {
            match column.checked_sub(own) {
                Some(index) => {
                    selected.extend(self.differences[index].map(|column| (quantity, column)));
                }
                None => selected.push((quantity, column)),
            }
        }
        self.is_difference = columns.iter().map(|(_, column)| *column >= own).collect();
        self.table.select(&selected);
    }

    fn leave_out(&mut self, position: usize) {
        let differences = self.is_difference[..position].iter().filter(|is| **is);
        let first = position + differences.count();
        for _ in 0..=usize::from(self.is_difference.remove(position)) {
            self.table.leave_out(first);
        }
    }

    fn next_row(&mut self, cells: &mut Vec<Cell>) -> Result<Option<Place>, Fault> {
        let place = self.table.next_row(&mut self.cells)?;
        cells.clear();
        let mut read = self.cells.iter();
        for is_difference in self.is_difference.iter().filter(|_| place.is_some()) {
            let cell = read.next().unwrap_or(&Cell::Missing);
            cells.push(match is_difference {
                true => half_difference(cell, read.next().unwrap_or(&Cell::Missing)),
                false => cell.clone(),
            });
        }
        Ok(place)
    }

    fn bytes_read(&self) -> u64 {
        self.table.bytes_read()
    }

    fn sha256(&mut self) -> Result<String, Fault> {
        self.table.sha256()
    }

    fn warnings(&self) -> Vec<String> {
        self.table.warnings()
    }

    fn is_damaged(&self) -> bool {
        self.table.is_damaged()
    }
}
