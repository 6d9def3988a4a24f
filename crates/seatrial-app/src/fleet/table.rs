//! Rows as Parquet.

use std::fs::File;
use std::io;
use std::sync::Arc;

use parquet::basic::{Compression, ZstdLevel};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::parser::parse_message_type;

use super::{COLUMNS, Column, Row, Value};

/// The key of the file's metadata under which stands what made the rows: version and options.
pub(super) const SETTINGS: &str = "seatrial.fleet";

/// Rows of a row group, all that is in memory: some 20 MB.
const GROUP_ROWS: usize = 16_384;

/// Writes rows as they come, compressed.
pub(super) struct TableWriter<'a> {
    writer: SerializedFileWriter<&'a File>,
    rows: Vec<Row>,
}

impl<'a> TableWriter<'a> {
    pub fn new(file: &'a File, settings: &str) -> io::Result<Self> {
        let blank = Row::default();
        let fields: Vec<String> = COLUMNS
            .iter()
            .map(|column| {
                let kind = match (column.value)(&blank) {
                    Value::Text(_) => {
                        return format!("OPTIONAL BYTE_ARRAY {} (UTF8);", column.name);
                    }
                    Value::Number(_) => "DOUBLE",
                    Value::Integer(_) => "INT64",
                    Value::Bool(_) => "BOOLEAN",
                };
                format!("OPTIONAL {kind} {};", column.name)
            })
            .collect();
        let schema = parse_message_type(&format!("message fleet {{ {} }}", fields.join(" ")))
            .map_err(io::Error::other)?;
        let properties = WriterProperties::builder()
            .set_compression(Compression::ZSTD(ZstdLevel::default()))
            .set_key_value_metadata(Some(vec![KeyValue::new(
                SETTINGS.into(),
                settings.to_owned(),
            )]))
            .build();
        Ok(Self {
            writer: SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties))?,
            rows: Vec::with_capacity(GROUP_ROWS),
        })
    }

    pub fn push(&mut self, row: Row) -> io::Result<()> {
        self.rows.push(row);
        if self.rows.len() == GROUP_ROWS {
            self.write_group()?;
        }
        Ok(())
    }

    pub fn finish(mut self) -> io::Result<()> {
        if !self.rows.is_empty() {
            self.write_group()?;
        }
        self.writer.close()?;
        Ok(())
    }

    fn write_group(&mut self) -> io::Result<()> {
        let mut group = self.writer.next_row_group()?;
        for column in &COLUMNS {
            write_column(&mut group, column, &self.rows)?;
        }
        group.close()?;
        self.rows.clear();
        Ok(())
    }
}

fn write_column(
    group: &mut SerializedRowGroupWriter<&File>,
    column: &Column,
    rows: &[Row],
) -> io::Result<()> {
    let (mut texts, mut numbers, mut integers, mut bools) = (vec![], vec![], vec![], vec![]);
    let levels: Vec<i16> = rows
        .iter()
        .map(|row| match (column.value)(row) {
            Value::Text(text) => keep(&mut texts, text.map(ByteArray::from)),
            Value::Number(number) => keep(&mut numbers, number),
            Value::Integer(integer) => keep(&mut integers, integer.map(|i| i as i64)),
            Value::Bool(bool) => keep(&mut bools, bool),
        })
        .collect();
    match (column.value)(&rows[0]) {
        Value::Text(_) => write::<ByteArrayType>(group, &texts, &levels),
        Value::Number(_) => write::<DoubleType>(group, &numbers, &levels),
        Value::Integer(_) => write::<Int64Type>(group, &integers, &levels),
        Value::Bool(_) => write::<BoolType>(group, &bools, &levels),
    }
}

/// Keeps a value and says at which level it is defined.
fn keep<T>(values: &mut Vec<T>, value: Option<T>) -> i16 {
    let level = i16::from(value.is_some());
    values.extend(value);
    level
}

fn write<T: DataType>(
    group: &mut SerializedRowGroupWriter<&File>,
    values: &[T::T],
    levels: &[i16],
) -> io::Result<()> {
    let Some(mut writer) = group.next_column()? else {
        return Err(io::Error::other(
            "the schema has fewer columns than it was given",
        ));
    };
    writer
        .typed::<T>()
        .write_batch(values, Some(levels), None)?;
    writer.close()?;
    Ok(())
}
