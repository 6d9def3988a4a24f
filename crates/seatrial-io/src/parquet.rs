//! Apache Parquet, batch by batch.

use std::collections::VecDeque;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::panic::{AssertUnwindSafe, catch_unwind};

use jiff::Timestamp;
use parquet::basic::{LogicalType, TimeUnit, Type as PhysicalType};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::{ByteArray, DataType, Int96};
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::schema::types::ColumnDescriptor;
use sha2::{Digest, Sha256};

use crate::Quantity;
use crate::clock::instant;
use crate::error::{Fault, Place};
use crate::reader::Format;
use crate::table::{Cell, Table, hexadecimal};

/// Rows read at once.
const BATCH_ROWS: usize = 1024;

/// A Parquet file, read row group by row group.
pub(crate) struct Columnar {
    file: File,
    length: u64,
    reader: SerializedFileReader<File>,
    names: Vec<String>,
    /// Index among all leaf columns of each name.
    leaves: Vec<usize>,
    selected: Vec<usize>,
    opened: Vec<Column>,
    next_group: usize,
    rows_left_in_group: usize,
    rows_read: u64,
    rows: u64,
}

/// A column of the row group that is being read.
struct Column {
    reader: ColumnReader,
    meaning: Meaning,
    /// Definition level of a value that is not null.
    present: i16,
    cells: VecDeque<Cell>,
}

/// What an integer stands for.
#[derive(Clone, Copy)]
enum Meaning {
    Number,
    Timestamp {
        nanoseconds: i128,
    },
    /// A decimal, a time of day or bytes: not read.
    Opaque,
}

impl Columnar {
    /// Reads the footer.
    pub fn open(file: File) -> Result<Self, Fault> {
        guarded(|| Self::open_unguarded(file))
    }

    fn open_unguarded(file: File) -> Result<Self, Fault> {
        let length = file.metadata().map_err(Fault::read)?.len();
        let own = file.try_clone().map_err(Fault::read)?;
        let reader = SerializedFileReader::new(file).map_err(damaged)?;
        let metadata = reader.metadata();
        let schema = metadata.file_metadata().schema_descr();
        let (mut names, mut leaves) = (Vec::new(), Vec::new());
        for leaf in 0..schema.num_columns() {
            let column = schema.column(leaf);
            if column.max_rep_level() == 0 {
                names.push(column.path().parts().join("."));
                leaves.push(leaf);
            }
        }
        let mut rows = 0_u64;
        for group in metadata.row_groups() {
            rows += u64::try_from(group.num_rows())
                .map_err(|_| broken("a row group with a negative number of rows"))?;
            if group.num_columns() != schema.num_columns() {
                return Err(broken("a row group without all columns"));
            }
            for chunk in group.columns() {
                let from = chunk
                    .dictionary_page_offset()
                    .unwrap_or_else(|| chunk.data_page_offset());
                let end = from.checked_add(chunk.compressed_size());
                let is_inside = from >= 0
                    && chunk.compressed_size() >= 0
                    && end.is_some_and(|end| end.unsigned_abs() <= length);
                if !is_inside {
                    return Err(broken("a column that lies outside the file"));
                }
            }
        }
        Ok(Self {
            file: own,
            length,
            names,
            leaves,
            selected: Vec::new(),
            opened: Vec::new(),
            next_group: 0,
            rows_left_in_group: 0,
            rows_read: 0,
            rows,
            reader,
        })
    }

    /// Opens the next row group that has rows. `false` at the end of the file.
    fn open_group(&mut self) -> Result<bool, Fault> {
        while self.next_group < self.reader.metadata().num_row_groups() {
            let group = self
                .reader
                .get_row_group(self.next_group)
                .map_err(damaged)?;
            self.next_group += 1;
            self.rows_left_in_group = usize::try_from(group.metadata().num_rows()).unwrap_or(0);
            if self.rows_left_in_group == 0 {
                continue;
            }
            self.opened = self
                .selected
                .iter()
                .map(|&column| {
                    let leaf = self.leaves[column];
                    let description = group.metadata().column(leaf).column_descr_ptr();
                    Ok(Column {
                        reader: group.get_column_reader(leaf).map_err(damaged)?,
                        meaning: Meaning::of(&description),
                        present: description.max_def_level(),
                        cells: VecDeque::new(),
                    })
                })
                .collect::<Result<_, Fault>>()?;
            return Ok(true);
        }
        Ok(false)
    }
}

impl Table for Columnar {
    fn format(&self) -> Format {
        Format::Parquet
    }

    fn columns(&self) -> &[String] {
        &self.names
    }

    fn select(&mut self, columns: &[(Quantity, usize)]) {
        self.selected = columns.iter().map(|(_, column)| *column).collect();
    }

    fn leave_out(&mut self, position: usize) {
        self.selected.remove(position);
        if position < self.opened.len() {
            self.opened.remove(position);
        }
    }

    fn next_row(&mut self, cells: &mut Vec<Cell>) -> Result<Option<Place>, Fault> {
        if self.rows_left_in_group == 0 && !guarded(|| self.open_group())? {
            return Ok(None);
        }
        cells.clear();
        for column in &mut self.opened {
            if column.cells.is_empty() {
                guarded(|| column.fill())?;
            }
            let cell = column.cells.pop_front();
            cells.push(cell.ok_or_else(|| broken("a column with too few rows"))?);
        }
        self.rows_left_in_group -= 1;
        self.rows_read += 1;
        Ok(Some(Place::Row(self.rows_read)))
    }

    fn bytes_read(&self) -> u64 {
        (self.length as f64 * self.rows_read as f64 / self.rows.max(1) as f64) as u64
    }

    fn sha256(&mut self) -> Result<String, Fault> {
        self.file.seek(SeekFrom::Start(0)).map_err(Fault::read)?;
        let mut hash = Sha256::new();
        let mut buffer = vec![0; 1 << 16];
        loop {
            match self.file.read(&mut buffer).map_err(Fault::read)? {
                0 => return Ok(hexadecimal(&hash.finalize())),
                count => hash.update(&buffer[..count]),
            }
        }
    }

    fn warnings(&self) -> Vec<String> {
        Vec::new()
    }
}

impl Meaning {
    fn of(column: &ColumnDescriptor) -> Self {
        match (column.physical_type(), column.logical_type_ref()) {
            (_, Some(LogicalType::Timestamp(timestamp))) => Self::Timestamp {
                nanoseconds: match timestamp.unit {
                    TimeUnit::MILLIS => 1_000_000,
                    TimeUnit::MICROS => 1_000,
                    TimeUnit::NANOS => 1,
                },
            },
            (PhysicalType::INT96, _) => Self::Timestamp { nanoseconds: 1 },
            (PhysicalType::INT32 | PhysicalType::INT64, Some(LogicalType::Integer(_)) | None)
            | (PhysicalType::FLOAT | PhysicalType::DOUBLE, _) => Self::Number,
            (PhysicalType::BYTE_ARRAY, Some(LogicalType::String) | None) => Self::Number,
            _ => Self::Opaque,
        }
    }

    fn integer(self, value: i64) -> Cell {
        match self {
            Self::Number => Cell::Number(value as f64),
            Self::Timestamp { nanoseconds } => {
                Timestamp::from_nanosecond(i128::from(value) * nanoseconds)
                    .map_or_else(|_| Cell::Text(value.to_string().into()), Cell::Instant)
            }
            Self::Opaque => Cell::Text("a value that is no number".into()),
        }
    }

    fn float(self, value: f64) -> Cell {
        Cell::Number(value)
    }

    fn text(self, value: &ByteArray) -> Cell {
        match (self, std::str::from_utf8(value.data())) {
            (Self::Number, Ok(text)) => {
                instant(text).map_or_else(|| Cell::Text(text.into()), Cell::Instant)
            }
            _ => Cell::Text("bytes".into()),
        }
    }
}

impl Column {
    fn fill(&mut self) -> Result<(), Fault> {
        let (meaning, present, cells) = (self.meaning, self.present, &mut self.cells);
        match &mut self.reader {
            ColumnReader::Int32ColumnReader(reader) => batch(reader, cells, present, |value| {
                meaning.integer(i64::from(*value))
            }),
            ColumnReader::Int64ColumnReader(reader) => {
                batch(reader, cells, present, |value| meaning.integer(*value))
            }
            ColumnReader::Int96ColumnReader(reader) => {
                batch(reader, cells, present, |value: &Int96| {
                    meaning.integer(value.to_nanos())
                })
            }
            ColumnReader::FloatColumnReader(reader) => batch(reader, cells, present, |value| {
                meaning.float(f64::from(*value))
            }),
            ColumnReader::DoubleColumnReader(reader) => {
                batch(reader, cells, present, |value| meaning.float(*value))
            }
            ColumnReader::ByteArrayColumnReader(reader) => {
                batch(reader, cells, present, |value| meaning.text(value))
            }
            ColumnReader::BoolColumnReader(reader) => batch(reader, cells, present, |value| {
                Cell::Text(value.to_string().into())
            }),
            ColumnReader::FixedLenByteArrayColumnReader(reader) => {
                batch(reader, cells, present, |_| Cell::Text("bytes".into()))
            }
        }
    }
}

/// Reads up to [`BATCH_ROWS`] rows of a column; below the level `present` a value is null.
fn batch<T: DataType>(
    reader: &mut ColumnReaderImpl<T>,
    cells: &mut VecDeque<Cell>,
    present: i16,
    cell: impl Fn(&T::T) -> Cell,
) -> Result<(), Fault> {
    let (mut values, mut levels) = (Vec::new(), Vec::new());
    let (rows, _, _) = reader
        .read_records(BATCH_ROWS, Some(&mut levels), None, &mut values)
        .map_err(damaged)?;
    let mut values = values.iter();
    if levels.is_empty() {
        cells.extend(values.map(cell));
        return Ok(());
    }
    cells.extend(levels.iter().take(rows).map(|level| {
        (*level == present)
            .then(|| values.next())
            .flatten()
            .map_or(Cell::Missing, &cell)
    }));
    Ok(())
}

/// The library panics on some damaged files. What was being read is lost and never used again; the
/// panic's own message has gone to standard error.
fn guarded<T>(read: impl FnOnce() -> Result<T, Fault>) -> Result<T, Fault> {
    catch_unwind(AssertUnwindSafe(read)).unwrap_or_else(|panic| {
        let message = panic
            .downcast_ref::<String>()
            .map(String::as_str)
            .or_else(|| panic.downcast_ref::<&str>().copied());
        Err(broken(message.unwrap_or("its reader gave up")))
    })
}

fn damaged(error: ParquetError) -> Fault {
    broken(&error.to_string())
}

fn broken(what: &str) -> Fault {
    Fault::Damaged {
        format: "Parquet",
        what: what.chars().take(200).collect(),
    }
}
