//! A table of text for people, columns as wide as their widest cell.

use std::fmt;

/// Rows of cells under a heading; every column is flush right.
pub struct Table {
    rows: Vec<Vec<String>>,
}

impl Table {
    /// A table with this heading: one `name unit` for each column, the unit in a line of its own.
    pub fn new(columns: &[(&str, &str)]) -> Self {
        let line = |of: fn(&(&str, &str)) -> String| columns.iter().map(of).collect();
        Self {
            rows: vec![line(|c| c.0.into()), line(|c| c.1.into())],
        }
    }

    /// Adds a row.
    pub fn row(&mut self, cells: Vec<String>) {
        self.rows.push(cells);
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let width = |column: usize| {
            let cells = self.rows.iter().filter_map(|row| row.get(column));
            cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
        };
        let columns = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        let widths: Vec<usize> = (0..columns).map(width).collect();
        for row in &self.rows {
            let line: String = row
                .iter()
                .zip(&widths)
                .map(|(cell, width)| format!("{cell:>width$}  "))
                .collect();
            writeln!(f, "{}", line.trim_end())?;
        }
        Ok(())
    }
}
