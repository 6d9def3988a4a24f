//! Recordings: what a trial sees and estimates, in a log whose suffix says its format.

use std::fs::File;
use std::io::{self, BufWriter, LineWriter};
use std::path::{Path, PathBuf};

use seatrial_logs::{CsvWriter, McapWriter, Row, RowWriter, write_csv, write_mcap, write_parquet};

use crate::output::Failure;
#[cfg(feature = "foxglove")]
use crate::output::say;

/// Formats that are written.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Format {
    Csv,
    Parquet,
    Mcap,
}

impl Format {
    /// Of a file by its suffix; the option is named to who gave another.
    pub fn of(path: &Path, option: &str) -> Result<Self, Failure> {
        match path.extension().and_then(|suffix| suffix.to_str()) {
            Some("csv") => Ok(Self::Csv),
            Some("parquet") => Ok(Self::Parquet),
            Some("mcap") => Ok(Self::Mcap),
            _ => Err(Failure::usage(format!(
                "{option} {}: expected a name that ends in .csv, .parquet or .mcap",
                path.display()
            ))),
        }
    }
}

/// Writes a whole log.
pub fn write(path: &Path, format: Format, rows: &[Row]) -> Result<(), Failure> {
    write_file(path, format, rows).map_err(|error| not_saved(path, &error))
}

fn write_file(path: &Path, format: Format, rows: &[Row]) -> io::Result<()> {
    let file = BufWriter::new(File::create(path)?);
    match format {
        Format::Csv => write_csv(file, rows),
        Format::Parquet => write_parquet(file, rows),
        Format::Mcap => write_mcap(file, rows),
    }
}

fn not_saved(path: &Path, error: &io::Error) -> Failure {
    Failure::not_saved(format!("{}: {error}", path.display()))
}

/// Shows rows live to Foxglove at an address, HOST:PORT or a port of this machine alone, and says where.
#[cfg(feature = "foxglove")]
pub fn show(address: &str) -> Result<Box<dyn RowWriter>, Failure> {
    let (host, port) = address.rsplit_once(':').unwrap_or(("127.0.0.1", address));
    let port = port.parse().map_err(|_| {
        Failure::usage(format!(
            "--foxglove {address}: expected a port or HOST:PORT, 127.0.0.1:8765"
        ))
    })?;
    let server = seatrial_logs::FoxgloveServer::start(host, port)
        .map_err(|error| Failure::usage(format!("--foxglove {address}: {error}")))?;
    say(format!("Foxglove may connect to {}", server.url()));
    Ok(Box::new(server))
}

/// Without Foxglove.
#[cfg(not(feature = "foxglove"))]
pub fn show(address: &str) -> Result<Box<dyn RowWriter>, Failure> {
    Err(Failure::usage(format!(
        "--foxglove {address}: this seatrial was built without; build it with --features foxglove"
    )))
}

/// A log that grows with a trial.
pub struct Recording {
    path: PathBuf,
    rows: Rows,
}

enum Rows {
    /// On disk up to the last row (CSV) or the last second of the vehicle's time (MCAP).
    Streamed {
        writer: Box<dyn RowWriter>,
        flush_due_s: f64,
    },
    /// Parquet begins to be readable with its end: written anew whenever a run is over.
    Kept(Vec<Row>),
}

impl Recording {
    /// Creates the file.
    pub fn start(path: &Path, format: Format) -> Result<Self, Failure> {
        let rows = File::create(path).and_then(|file| {
            let writer: Box<dyn RowWriter> = match format {
                Format::Parquet => return Ok(Rows::Kept(Vec::new())),
                Format::Csv => Box::new(CsvWriter::new(LineWriter::new(file))?),
                Format::Mcap => Box::new(McapWriter::new(BufWriter::new(file))?),
            };
            Ok(Rows::Streamed {
                writer,
                flush_due_s: f64::NEG_INFINITY,
            })
        });
        Ok(Self {
            rows: rows.map_err(|error| not_saved(path, &error))?,
            path: path.into(),
        })
    }

    /// Takes a row.
    pub fn take(&mut self, row: Row) -> Result<(), Failure> {
        let taken = match &mut self.rows {
            Rows::Kept(rows) => {
                rows.push(row);
                Ok(())
            }
            Rows::Streamed {
                writer,
                flush_due_s,
            } => {
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
        taken.map_err(|error| not_saved(&self.path, &error))
    }

    /// A run is over: the file holds it from now on.
    pub fn run_ended(&mut self) -> Result<(), Failure> {
        match &mut self.rows {
            Rows::Kept(rows) => {
                let unfinished = self.path.with_extension("parquet.part");
                write_file(&unfinished, Format::Parquet, rows)
                    .and_then(|()| std::fs::rename(&unfinished, &self.path))
            }
            Rows::Streamed { writer, .. } => writer.flush(),
        }
        .map_err(|error| not_saved(&self.path, &error))
    }

    /// The trial is over.
    pub fn finish(mut self) -> Result<(), Failure> {
        self.run_ended()?;
        match self.rows {
            Rows::Kept(_) => Ok(()),
            Rows::Streamed { writer, .. } => writer
                .finish()
                .map_err(|error| not_saved(&self.path, &error)),
        }
    }
}
