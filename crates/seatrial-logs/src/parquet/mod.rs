//! Apache Parquet, batch by batch.

mod page_header;
mod pages;

use std::collections::VecDeque;
use std::io::{Read, Seek, SeekFrom};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use jiff::Timestamp;
use parquet::basic::{LogicalType, TimeUnit, Type as PhysicalType};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl, get_column_reader};
use parquet::data_type::{ByteArray, DataType, Int96};
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::schema::types::ColumnDescriptor;

use crate::Quantity;
use crate::clock::instant;
use crate::error::{Fault, Place};
use crate::format_name::Format;
use crate::input::Input;
use crate::number::number;
use crate::table::{Cell, Table};
use page_header::is_structure;
use pages::{Allowance, Pages, TooMuch};

/// Rows read at once.
const BATCH_ROWS: usize = 1024;
/// Rows of a file, beside two for every byte of it: repetition can say that there are any number.
const MOST_ROWS: u64 = 500_000;
/// Bytes of the footer, beside a 32nd of the file: what is made of it takes up to 60 times as much.
const MOST_FOOTER: u64 = 1 << 19;
/// Under this name our own files tell for each row group where it ends and the CRC-32 of all bytes from the end of the one before on, as in
/// `1204:9f3a0c11,2310:00b1e52c`: the library writes no checksums of pages.
pub(crate) const SUMS: &str = "seatrial.crc32";
/// Characters of a text that are kept: none that means anything here is longer.
const TEXT: usize = 64;

/// A Parquet file, read row group by row group.
pub(crate) struct Columnar {
    file: Input,
    length: u64,
    reader: SerializedFileReader<Input>,
    allowance: Arc<Allowance>,
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
    pub fn open(file: Input) -> Result<Self, Fault> {
        guarded(|| Self::open_unguarded(file))
    }

    fn open_unguarded(file: Input) -> Result<Self, Fault> {
        let length = file.length().map_err(Fault::read)?;
        let mut own = file.another().map_err(Fault::read)?;
        check_footer(&mut own, length)?;
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
            let own_rows = u64::try_from(group.num_rows())
                .map_err(|_| broken("a row group with a negative number of rows"))?;
            rows = rows.saturating_add(own_rows);
            if group.num_columns() != schema.num_columns() {
                return Err(broken("a row group without all columns"));
            }
            for chunk in group.columns() {
                let from =
                    chunk.dictionary_page_offset().unwrap_or_else(|| chunk.data_page_offset());
                let end = from.checked_add(chunk.compressed_size());
                let is_inside = from >= 0
                    && chunk.compressed_size() >= 0
                    && end.is_some_and(|end| end.unsigned_abs() <= length);
                if !is_inside {
                    return Err(broken("a column that lies outside the file"));
                }
            }
        }
        if rows > MOST_ROWS + 2 * length {
            return Err(too_much(format!("it says that it has {rows} rows in {length} bytes")));
        }
        Ok(Self {
            file: own,
            length,
            allowance: Allowance::of(length),
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

    /// Holds the next row group against its checksum, where the file has one.
    fn check_sum(&mut self) -> Result<(), Fault> {
        let metadata = self.reader.metadata().file_metadata();
        let told = metadata.key_value_metadata().into_iter().flatten();
        let mut told = told.filter(|pair| pair.key == SUMS);
        let Some(sums) = told.find_map(|pair| pair.value.as_deref()) else {
            return Ok(());
        };
        let wrong = || broken("the checksums in its footer are damaged");
        let mut sums = sums.split(',').map(|pair| {
            let (end, sum) = pair.split_once(':')?;
            Some((end.parse().ok()?, u32::from_str_radix(sum, 16).ok()?))
        });
        let from: u64 = match self.next_group.checked_sub(1) {
            Some(before) => sums.nth(before).flatten().ok_or_else(wrong)?.0,
            None => 0,
        };
        let (end, sum): (u64, u32) = sums.next().flatten().ok_or_else(wrong)?;
        if end < from || end > self.length {
            return Err(wrong());
        }
        self.file.seek(SeekFrom::Start(from)).map_err(Fault::read)?;
        let mut rest = (&mut self.file).take(end - from);
        let mut hash = crc32fast::Hasher::new();
        let mut buffer = vec![0; 1 << 16];
        loop {
            match rest.read(&mut buffer).map_err(Fault::read)? {
                0 => break,
                count => hash.update(buffer.get(..count).unwrap_or_default()),
            }
        }
        match hash.finalize() == sum {
            true => Ok(()),
            false => Err(broken(&format!("the checksum of its bytes {from} to {end} is wrong"))),
        }
    }

    /// Opens the next row group that has rows. `false` at the end of the file.
    fn open_group(&mut self) -> Result<bool, Fault> {
        while self.next_group < self.reader.metadata().num_row_groups() {
            self.check_sum()?;
            let group = self.reader.get_row_group(self.next_group).map_err(damaged)?;
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
                    let chunk = group.metadata().column(leaf);
                    let description = chunk.column_descr_ptr();
                    let file = self.file.another().map_err(Fault::read)?;
                    let pages = Pages::of(file, chunk, Arc::clone(&self.allowance));
                    Ok(Column {
                        reader: get_column_reader(description.clone(), Box::new(pages)),
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
        self.file.sha256().map_err(Fault::read)
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
                let end = text.char_indices().nth(TEXT).map_or(text.len(), |(at, _)| at);
                let text = &text[..end];
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
            ColumnReader::Int32ColumnReader(reader) => {
                batch(reader, cells, present, |value| meaning.integer(i64::from(*value)))
            }
            ColumnReader::Int64ColumnReader(reader) => {
                batch(reader, cells, present, |value| meaning.integer(*value))
            }
            ColumnReader::Int96ColumnReader(reader) => {
                batch(reader, cells, present, |value: &Int96| meaning.integer(value.to_nanos()))
            }
            ColumnReader::FloatColumnReader(reader) => {
                batch(reader, cells, present, |value| meaning.float(f64::from(*value)))
            }
            ColumnReader::DoubleColumnReader(reader) => {
                batch(reader, cells, present, |value| meaning.float(*value))
            }
            ColumnReader::ByteArrayColumnReader(reader) => {
                batch(reader, cells, present, |value| meaning.text(value))
            }
            ColumnReader::BoolColumnReader(reader) => {
                batch(reader, cells, present, |value| Cell::Text(value.to_string().into()))
            }
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
    let (rows, _, _) =
        reader.read_records(BATCH_ROWS, Some(&mut levels), None, &mut values).map_err(damaged)?;
    let mut values = values.iter();
    if levels.is_empty() {
        cells.extend(values.map(cell));
        return Ok(());
    }
    cells.extend(levels.iter().take(rows).map(|level| {
        (*level == present).then(|| values.next()).flatten().map_or(Cell::Missing, &cell)
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
    match &error {
        ParquetError::External(source) if let Some(what) = source.downcast_ref::<TooMuch>() => {
            too_much(what.to_string())
        }
        ParquetError::NYI(what) => Fault::NothingToRead { format: "Parquet", what: what.clone() },
        _ => broken(&error.to_string()),
    }
}

/// The library makes all of the footer before anything can be looked at, and counts through lists that say they are any length.
fn check_footer(file: &mut Input, length: u64) -> Result<(), Fault> {
    let mut end = [0; 8];
    if length < end.len() as u64 {
        return Err(broken("it is shorter than the shortest one"));
    }
    file.seek(SeekFrom::End(-(end.len() as i64)))
        .and_then(|_| file.read_exact(&mut end))
        .map_err(Fault::read)?;
    let footer = number::<u32>(&end, 0).unwrap_or(0);
    let before = length - end.len() as u64;
    // Where it is cut off, these are no length: the library says so.
    if !end.ends_with(b"PAR1") || u64::from(footer) > before {
        return Ok(());
    }
    if u64::from(footer) >= MOST_FOOTER + length / 32 {
        return Err(too_much(format!("its footer has {footer} bytes of {length}")));
    }
    let mut structure = vec![0; footer as usize];
    file.seek(SeekFrom::Start(before - u64::from(footer)))
        .and_then(|_| file.read_exact(&mut structure))
        .map_err(Fault::read)?;
    match is_structure(&structure) {
        true => Ok(()),
        false => Err(broken("its footer is damaged")),
    }
}

fn too_much(what: String) -> Fault {
    Fault::TooMuch { format: "Parquet", what }
}

fn broken(what: &str) -> Fault {
    Fault::Damaged { format: "Parquet", what: what.chars().take(200).collect() }
}
