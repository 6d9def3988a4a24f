//! Parquet.

use std::io::{self, Write};
use std::sync::Arc;

use parquet::basic::{Compression, ZstdLevel};
use parquet::data_type::DoubleType;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;

use super::{Row, columns_of};
use crate::parquet::SUMS;

/// Rows of a row group.
const GROUP_ROWS: usize = 65_536;

/// Counts and sums what passes.
struct Summed<W> {
    out: W,
    length: u64,
    sum: crc32fast::Hasher,
}

impl<W: Write> Write for Summed<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.out.write(bytes)?;
        self.length += count as u64;
        self.sum.update(bytes.get(..count).unwrap_or_default());
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

/// Writes rows as Parquet, compressed.
pub fn write_parquet(out: impl Write + Send, rows: &[Row]) -> io::Result<()> {
    let columns = columns_of(rows);
    let fields: Vec<String> =
        columns.iter().map(|column| format!("OPTIONAL DOUBLE {};", column.name)).collect();
    let schema = parse_message_type(&format!("message log {{ {} }}", fields.join(" ")))
        .map_err(io::Error::other)?;
    let properties = WriterProperties::builder()
        .set_compression(Compression::ZSTD(ZstdLevel::default()))
        .build();
    let out = Summed { out, length: 0, sum: crc32fast::Hasher::new() };
    let mut writer = SerializedFileWriter::new(out, Arc::new(schema), Arc::new(properties))?;
    let mut sums = Vec::new();
    for group in rows.chunks(GROUP_ROWS) {
        let mut group_writer = writer.next_row_group()?;
        for column in &columns {
            let cells: Vec<Option<f64>> = group.iter().map(column.value).collect();
            let levels: Vec<i16> = cells.iter().map(|c| i16::from(c.is_some())).collect();
            let values: Vec<f64> = cells.into_iter().flatten().collect();
            let Some(mut column_writer) = group_writer.next_column()? else {
                return Err(io::Error::other("the schema has fewer columns than it was given"));
            };
            column_writer.typed::<DoubleType>().write_batch(&values, Some(&levels), None)?;
            column_writer.close()?;
        }
        group_writer.close()?;
        writer.flush()?;
        let out = writer.inner_mut();
        let sum = std::mem::take(&mut out.sum).finalize();
        sums.push(format!("{}:{sum:08x}", out.length));
    }
    let sums = KeyValue::new(SUMS.to_owned(), sums.join(","));
    writer.append_key_value_metadata(sums);
    writer.into_inner()?.flush()
}
