//! What an earlier run left in the table: the rows of the logs that have not changed since.

use std::fs::File;
use std::path::Path;

use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::{Field, Row as Fields};
use seatrial_logs::sha256;
use serde_json::{Map, Number, Value};

use super::table::SETTINGS;
use super::{Row, Source};

/// Hands over the rows of a table log by log. None where there is no table, or one that other settings or another version made. A
/// damaged table gives what stands before the damage.
pub(super) fn for_each_log<E>(
    table: &Path,
    settings: &str,
    mut take: impl FnMut(Vec<Row>) -> Result<(), E>,
) -> Result<(), E> {
    let Some(table) = File::open(table).ok().filter(is_file) else {
        return Ok(());
    };
    let Ok(table) = SerializedFileReader::new(table) else {
        return Ok(());
    };
    let metadata = table.metadata().file_metadata().key_value_metadata();
    let mut written = metadata.into_iter().flatten();
    if !written.any(|pair| pair.key == SETTINGS && pair.value.as_deref() == Some(settings)) {
        return Ok(());
    }
    let Ok(rows) = table.get_row_iter(None) else {
        return Ok(());
    };
    let mut log: Vec<Row> = Vec::new();
    for fields in rows {
        let Some(row) = fields.ok().and_then(row) else {
            return Ok(());
        };
        if log.first().is_some_and(|first| first.source != row.source) {
            take(std::mem::take(&mut log))?;
        }
        log.push(row);
    }
    take(log)
}

fn is_file(file: &File) -> bool {
    file.metadata().is_ok_and(|about| about.is_file())
}

fn row(fields: Fields) -> Option<Row> {
    let fields = fields.into_columns().into_iter();
    let cells = fields.map(|(name, field)| (name, value(&field)));
    serde_json::from_value(Value::Object(cells.collect::<Map<_, _>>())).ok()
}

fn value(field: &Field) -> Value {
    match field {
        Field::Bool(cell) => (*cell).into(),
        Field::Long(cell) | Field::TimestampMicros(cell) => (*cell).into(),
        Field::Double(cell) => Number::from_f64(*cell).map_or(Value::Null, Value::Number),
        Field::Str(cell) => cell.as_str().into(),
        Field::ListInternal(cells) => cells.elements().iter().map(value).collect(),
        _ => Value::Null,
    }
}

/// The rows of a log that is as it was: of the same length, and of the same version, or, where no store tells that, of the same time or
/// check sum. A log that could not be read is tried again.
pub(super) fn unchanged(source: &Source, mut rows: Vec<Row>) -> Option<Vec<Row>> {
    let first = rows.first()?;
    let is_same = || match &source.etag {
        Some(_) => first.etag == source.etag,
        None => {
            first.modified.is_some() && first.modified == source.modified()
                || first.sha256.is_some() && first.sha256 == sha256(&source.path).ok()
        }
    };
    let is_kept =
        first.bytes == source.bytes && rows.iter().all(|row| row.format.is_some()) && is_same();
    for row in &mut rows {
        row.modified = source.modified();
    }
    is_kept.then_some(rows)
}
