//! CSV.

use std::io::{self, Write};

use super::{COLUMNS, Column, Row, RowWriter, columns_of};

/// Writes rows as CSV; every number is the shortest that reads back exactly.
pub fn write_csv(out: impl Write, rows: &[Row]) -> io::Result<()> {
    let mut writer = CsvWriter::with_columns(out, columns_of(rows))?;
    for row in rows {
        writer.write(row)?;
    }
    writer.flush()
}

/// CSV with every column, row by row.
pub struct CsvWriter<W> {
    out: W,
    columns: Vec<Column>,
}

impl<W: Write> CsvWriter<W> {
    /// Writes the header.
    pub fn new(out: W) -> io::Result<Self> {
        Self::with_columns(out, COLUMNS.into())
    }

    fn with_columns(mut out: W, columns: Vec<Column>) -> io::Result<Self> {
        let names: Vec<&str> = columns.iter().map(|column| column.name).collect();
        writeln!(out, "{}", names.join(","))?;
        Ok(Self { out, columns })
    }
}

impl<W: Write> RowWriter for CsvWriter<W> {
    fn write(&mut self, row: &Row) -> io::Result<()> {
        for (i, column) in self.columns.iter().enumerate() {
            if i > 0 {
                self.out.write_all(b",")?;
            }
            if let Some(value) = (column.value)(row) {
                write!(self.out, "{value}")?;
            }
        }
        self.out.write_all(b"\n")
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }

    fn finish(mut self: Box<Self>) -> io::Result<()> {
        self.out.flush()
    }
}
