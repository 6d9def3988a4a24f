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

use serde_json::Map;

use super::{COLUMNS, Column, Row, Value};

/// Keys of the file's metadata: what made the rows, and what each column means and in which unit, as an object of JSON.
pub(super) const SETTINGS: &str = "seatrial.fleet";
const VERSION: &str = "seatrial.version";
const MEANINGS: &str = "seatrial.columns";

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
            .map(|Column { name, value, .. }| match value(&blank) {
                Value::Text(_) => format!("OPTIONAL BYTE_ARRAY {name} (UTF8);"),
                Value::Number(_) => format!("OPTIONAL DOUBLE {name};"),
                Value::Integer(_) => format!("OPTIONAL INT64 {name};"),
                Value::Bool(_) => format!("OPTIONAL BOOLEAN {name};"),
                Value::Time(_) => format!("OPTIONAL INT64 {name} (TIMESTAMP(MICROS,true));"),
                Value::Texts(_) => format!(
                    "OPTIONAL GROUP {name} (LIST) {{ REPEATED GROUP list {{ REQUIRED BYTE_ARRAY element (UTF8); }} }}"
                ),
            })
            .collect();
        let meanings: Map<_, _> = (COLUMNS.iter())
            .map(|column| (column.name.to_owned(), column.meaning.into()))
            .collect();
        let metadata = [
            (VERSION, env!("CARGO_PKG_VERSION").to_owned()),
            (SETTINGS, settings.to_owned()),
            (MEANINGS, serde_json::Value::Object(meanings).to_string()),
        ];
        let metadata = metadata.map(|(key, value)| KeyValue::new(key.into(), value));
        let schema = parse_message_type(&format!("message fleet {{ {} }}", fields.join(" ")))
            .map_err(io::Error::other)?;
        let properties = WriterProperties::builder()
            .set_compression(Compression::ZSTD(ZstdLevel::default()))
            .set_key_value_metadata(Some(metadata.into()))
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
        for column in COLUMNS {
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
    let (mut levels, mut repeated) = (Vec::with_capacity(rows.len()), Vec::new());
    for row in rows {
        let level = match (column.value)(row) {
            Value::Text(text) => keep(&mut texts, text.map(ByteArray::from)),
            Value::Number(number) => keep(&mut numbers, number),
            Value::Integer(integer) => keep(&mut integers, integer.map(|i| i as i64)),
            Value::Bool(bool) => keep(&mut bools, bool),
            Value::Time(time) => keep(&mut integers, time),
            Value::Texts(Some(list @ [_, rest @ ..])) => {
                texts.extend(list.iter().map(|text| ByteArray::from(text.as_str())));
                levels.extend(rest.iter().map(|_| IN_A_LIST));
                repeated.push(0);
                repeated.extend(rest.iter().map(|_| 1));
                levels.push(IN_A_LIST);
                continue;
            }
            Value::Texts(list) => {
                repeated.push(0);
                i16::from(list.is_some())
            }
        };
        levels.push(level);
    }
    match (column.value)(&rows[0]) {
        Value::Text(_) => write::<ByteArrayType>(group, &texts, &levels, None),
        Value::Number(_) => write::<DoubleType>(group, &numbers, &levels, None),
        Value::Integer(_) | Value::Time(_) => write::<Int64Type>(group, &integers, &levels, None),
        Value::Bool(_) => write::<BoolType>(group, &bools, &levels, None),
        Value::Texts(_) => write::<ByteArrayType>(group, &texts, &levels, Some(&repeated)),
    }
}

/// The level at which an element of a list is defined; 1 is an empty list.
const IN_A_LIST: i16 = 2;

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
    repeated: Option<&[i16]>,
) -> io::Result<()> {
    let Some(mut writer) = group.next_column()? else {
        return Err(io::Error::other("the schema has fewer columns than it was given"));
    };
    writer.typed::<T>().write_batch(values, Some(levels), repeated)?;
    writer.close()?;
    Ok(())
}
