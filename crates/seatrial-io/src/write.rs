//! Samples into a log, with the unit in every column's name, so that [`open`](crate::open) gives
//! the same samples back.

use std::io::{self, Write};

use seatrial_core::Sample;

/// A column of the logs that are written.
struct Column {
    name: &'static str,
    value: fn(&Sample<f64>) -> Option<f64>,
}

const COLUMNS: [Column; 12] = [
    Column {
        name: "time_s",
        value: |s| Some(s.time_s),
    },
    Column {
        name: "heading_rad",
        value: |s| Some(s.heading_rad),
    },
    Column {
        name: "rudder_rad",
        value: |s| Some(s.rudder_rad),
    },
    Column {
        name: "surge_speed_m_s",
        value: |s| s.surge_speed_m_s,
    },
    Column {
        name: "depth_m",
        value: |s| s.depth_m,
    },
    Column {
        name: "altitude_m",
        value: |s| s.altitude_m,
    },
    Column {
        name: "roll_rad",
        value: |s| s.roll_rad,
    },
    Column {
        name: "pitch_rad",
        value: |s| s.pitch_rad,
    },
    Column {
        name: "yaw_rate_rad_s",
        value: |s| s.yaw_rate_rad_s,
    },
    Column {
        name: "north_m",
        value: |s| s.north_m,
    },
    Column {
        name: "east_m",
        value: |s| s.east_m,
    },
    Column {
        name: "thrust_fraction",
        value: |s| s.thrust,
    },
];

/// The columns that have a value somewhere.
fn columns_of(samples: &[Sample<f64>]) -> Vec<&'static Column> {
    COLUMNS
        .iter()
        .enumerate()
        .filter(|(i, column)| {
            *i < 3
                || samples
                    .iter()
                    .any(|sample| (column.value)(sample).is_some())
        })
        .map(|(_, column)| column)
        .collect()
}

/// Writes samples as CSV; every number is the shortest that reads back exactly.
pub fn write_csv(mut out: impl Write, samples: &[Sample<f64>]) -> io::Result<()> {
    let columns = columns_of(samples);
    let names: Vec<&str> = columns.iter().map(|column| column.name).collect();
    writeln!(out, "{}", names.join(","))?;
    for sample in samples {
        for (i, column) in columns.iter().enumerate() {
            if i > 0 {
                out.write_all(b",")?;
            }
            if let Some(value) = (column.value)(sample) {
                write!(out, "{value}")?;
            }
        }
        out.write_all(b"\n")?;
    }
    out.flush()
}

/// Rows of a Parquet row group.
#[cfg(feature = "parquet")]
const GROUP_ROWS: usize = 65_536;

/// Writes samples as Parquet, compressed.
#[cfg(feature = "parquet")]
pub fn write_parquet(out: impl Write + Send, samples: &[Sample<f64>]) -> io::Result<()> {
    use std::sync::Arc;

    use parquet::basic::{Compression, ZstdLevel};
    use parquet::data_type::DoubleType;
    use parquet::file::properties::WriterProperties;
    use parquet::file::writer::SerializedFileWriter;
    use parquet::schema::parser::parse_message_type;

    let columns = columns_of(samples);
    let fields: Vec<String> = columns
        .iter()
        .map(|column| format!("OPTIONAL DOUBLE {};", column.name))
        .collect();
    let schema = parse_message_type(&format!("message log {{ {} }}", fields.join(" ")))
        .map_err(io::Error::other)?;
    let properties = WriterProperties::builder()
        .set_compression(Compression::ZSTD(ZstdLevel::default()))
        .build();
    let mut writer = SerializedFileWriter::new(out, Arc::new(schema), Arc::new(properties))?;
    for group in samples.chunks(GROUP_ROWS) {
        let mut group_writer = writer.next_row_group()?;
        for column in &columns {
            let cells: Vec<Option<f64>> = group.iter().map(column.value).collect();
            let levels: Vec<i16> = cells.iter().map(|c| i16::from(c.is_some())).collect();
            let values: Vec<f64> = cells.into_iter().flatten().collect();
            let Some(mut column_writer) = group_writer.next_column()? else {
                return Err(io::Error::other(
                    "the schema has fewer columns than it was given",
                ));
            };
            column_writer
                .typed::<DoubleType>()
                .write_batch(&values, Some(&levels), None)?;
            column_writer.close()?;
        }
        group_writer.close()?;
    }
    writer.into_inner()?.flush()
}
