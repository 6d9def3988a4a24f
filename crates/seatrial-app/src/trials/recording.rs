//! Recordings: what a trial sees and estimates, in a log whose suffix says its format.

use std::fs::File;
use std::io::{self, BufWriter, LineWriter, Write};
use std::path::{Path, PathBuf};

use seatrial_logs::{CsvWriter, Row, RowWriter, write_csv};

use crate::outputs::{OutputError, Outputs, replace};

/// Formats that are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Format {
    /// Text, complete up to the last row.
    Csv,
    /// Columns, readable once its end is written.
    Parquet,
    /// Messages, which Foxglove opens.
    Mcap,
}

impl Format {
    /// The format of a file by its suffix; `None` where no such format is written.
    pub fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()? {
            "csv" => Some(Self::Csv),
            "parquet" => Some(Self::Parquet),
            "mcap" => Some(Self::Mcap),
            _ => None,
        }
    }
}

fn not_saved(path: &Path) -> impl FnOnce(io::Error) -> OutputError {
    let path = path.into();
    |error| OutputError::NotSaved { path, error }
}

/// Writes a whole log.
///
/// # Errors
/// A place that is [refused](Outputs::save), a format that this program was built without, or a disk that does not take it.
pub fn write(
    outputs: &Outputs,
    path: &Path,
    format: Format,
    rows: &[Row],
) -> Result<(), OutputError> {
    built(format).map_err(not_saved(path))?;
    outputs.save_with(path, |file| write_rows(file, format, rows))
}

fn write_rows(file: impl Write + Send, format: Format, rows: &[Row]) -> io::Result<()> {
    let file = BufWriter::new(file);
    match format {
        Format::Csv => write_csv(file, rows),
        #[cfg(feature = "parquet")]
        Format::Parquet => seatrial_logs::write_parquet(file, rows),
        #[cfg(feature = "mcap")]
        Format::Mcap => seatrial_logs::write_mcap(file, rows),
        #[cfg(not(feature = "parquet"))]
        Format::Parquet => built(format),
        #[cfg(not(feature = "mcap"))]
        Format::Mcap => built(format),
    }
}

/// An error of a format that this program was built without.
fn built(format: Format) -> io::Result<()> {
    let feature = match format {
        Format::Parquet if cfg!(not(feature = "parquet")) => "parquet",
        Format::Mcap if cfg!(not(feature = "mcap")) => "mcap",
        Format::Csv | Format::Parquet | Format::Mcap => return Ok(()),
    };
    Err(io::Error::new(
        io::ErrorKind::Unsupported,
        format!("this program was built without that format; build it with `--features {feature}`"),
    ))
}

/// A log that grows with a trial.
pub struct Recording {
    path: PathBuf,
    rows: Rows,
}

enum Rows {
    /// On disk up to the last row (CSV) or the last second of the vehicle's time (MCAP).
    Streamed { writer: Box<dyn RowWriter + Send>, flush_due_s: f64 },
    /// Parquet begins to be readable with its end: written anew whenever a run is over.
    Kept { rows: Vec<Row>, file: File },
}

impl Recording {
    /// Creates the file.
    ///
    /// # Errors
    /// As [`write()`].
    pub fn start(outputs: &Outputs, path: &Path, format: Format) -> Result<Self, OutputError> {
        built(format).map_err(not_saved(path))?;
        let file = outputs.grow(path)?;
        let start = || -> io::Result<Rows> {
            let writer: Box<dyn RowWriter + Send> = match format {
                Format::Parquet => {
                    let rows = Vec::new();
                    return Ok(Rows::Kept { rows, file });
                }
                Format::Csv => Box::new(CsvWriter::new(LineWriter::new(file))?),
                #[cfg(feature = "mcap")]
                Format::Mcap => Box::new(seatrial_logs::McapWriter::new(BufWriter::new(file))?),
                #[cfg(not(feature = "mcap"))]
                Format::Mcap => return Err(io::ErrorKind::Unsupported.into()),
            };
            Ok(Rows::Streamed { writer, flush_due_s: f64::NEG_INFINITY })
        };
        Ok(Self { rows: start().map_err(not_saved(path))?, path: path.into() })
    }

    /// Takes a row.
    pub fn take(&mut self, row: Row) -> Result<(), OutputError> {
        let taken = match &mut self.rows {
            Rows::Kept { rows, .. } => {
                rows.push(row);
                Ok(())
            }
            Rows::Streamed { writer, flush_due_s } => {
                let time_s = row.sample.time_s;
                let written = writer.write(&row);
                // Also where the vehicle's clock jumped back or is not a number.
                if (*flush_due_s - 1.0..*flush_due_s).contains(&time_s) {
                    written
                } else {
                    *flush_due_s = time_s + 1.0;
                    written.and(writer.flush())
                }
            }
        };
        taken.map_err(not_saved(&self.path))
    }

    /// A run is over: the file holds it from now on.
    pub fn run_ended(&mut self) -> Result<(), OutputError> {
        match &mut self.rows {
            Rows::Kept { rows, file } => {
                let write = |file: &mut File| write_rows(file, Format::Parquet, rows);
                replace(&self.path, file, write).map(|new| *file = new)
            }
            Rows::Streamed { writer, .. } => writer.flush(),
        }
        .map_err(not_saved(&self.path))
    }

    /// The trial is over.
    pub fn finish(mut self) -> Result<(), OutputError> {
        self.run_ended()?;
        match self.rows {
            Rows::Kept { .. } => Ok(()),
            Rows::Streamed { writer, .. } => writer.finish().map_err(not_saved(&self.path)),
        }
    }
}
