//! The longest sheet of an Excel workbook (`.xlsx`) as text.

use std::io::{self, BufReader, Read, Seek};
use std::panic::{AssertUnwindSafe, catch_unwind};

use calamine::{DataRef, ExcelDateTime, Reader, Xlsx, XlsxError};
use zip::ZipArchive;

use crate::error::{Fault, clipped};
use crate::input::Input;

/// What the parts of a workbook may unpack to, and that for each byte of the file.
const MOST_UNPACKED: u64 = 8 << 20;
const MOST_UNPACKED_FOR_A_BYTE: u64 = 32;
/// Columns that are read.
const MOST_COLUMNS: u32 = 4096;
/// Cells are parted by tabs, which no cell holds.
const BETWEEN: &str = "\t";

/// The rows of a sheet, and what should be known of it.
pub(crate) fn text(file: &mut Input) -> Result<(Vec<u8>, Vec<String>), Fault> {
    check_size(file)?;
    // A library that gives up on a damaged file is done with: what it was reading is never used again.
    let read = || read(file);
    let rows = catch_unwind(AssertUnwindSafe(read))
        .unwrap_or_else(|_| Err(damaged("its reader gave up")))?;
    let width = rows.lines.iter().map(|(_, count)| *count).max().unwrap_or(0);
    let mut text = Vec::new();
    for (line, count) in &rows.lines {
        text.extend(line.as_bytes());
        text.extend(BETWEEN.repeat((width - count) as usize).as_bytes());
        text.push(b'\n');
    }
    let others = (!rows.others.is_empty()).then(|| {
        format!(
            "the sheet `{}` is read; other sheets are {}",
            clipped(&rows.name),
            clipped(&rows.others.join(", "))
        )
    });
    Ok((text, others.into_iter().collect()))
}

fn damaged(what: impl ToString) -> Fault {
    Fault::Damaged { format: "xlsx", what: clipped(&what.to_string()) }
}

/// Unpacks all parts to nothing: no length that the file says is believed.
fn check_size(file: &mut Input) -> Result<(), Fault> {
    let length = file.length().map_err(Fault::read)?;
    let mut left = MOST_UNPACKED + MOST_UNPACKED_FOR_A_BYTE * length;
    let mut parts = ZipArchive::new(&mut *file).map_err(damaged)?;
    for part in 0..parts.len() {
        let part = parts.by_index(part).map_err(damaged)?;
        let unpacked = io::copy(&mut part.take(left + 1), &mut io::sink()).map_err(damaged)?;
        left = left
            .checked_sub(unpacked)
            .ok_or_else(|| damaged("it unpacks to more than any log holds"))?;
    }
    file.rewind().map_err(Fault::read)
}

/// A sheet as lines.
struct Rows {
    name: String,
    others: Vec<String>,
    /// Text, and cells in it.
    lines: Vec<(String, u32)>,
}

fn read(file: &mut Input) -> Result<Rows, Fault> {
    let mut book: Xlsx<_> = Xlsx::new(BufReader::new(file)).map_err(damaged)?;
    let names = book.sheet_names();
    let mut longest: Option<(&String, Vec<(String, u32)>)> = None;
    for name in &names {
        let lines = lines(&mut book, name).map_err(damaged)?;
        // Remarks stand in one column.
        let count = |lines: &[(String, u32)]| lines.iter().filter(|(_, cells)| *cells > 1).count();
        let is_longer = longest.as_ref().is_none_or(|(_, of)| count(&lines) > count(of));
        if lines.len() > 1 && is_longer {
            longest = Some((name, lines));
        }
    }
    let (name, lines) = longest.ok_or(Fault::Empty)?;
    let others = names.iter().filter(|other| *other != name);
    Ok(Rows { name: name.clone(), others: others.cloned().collect(), lines })
}

fn lines<R: Read + Seek>(book: &mut Xlsx<R>, sheet: &str) -> Result<Vec<(String, u32)>, XlsxError> {
    let mut cells = book.worksheet_cells_reader(sheet)?;
    let mut lines: Vec<(String, u32)> = Vec::new();
    let mut last_row = None;
    while let Some(cell) = cells.next_cell()? {
        let (row, column) = cell.get_position();
        let value = text_of(cell.get_value());
        if column >= MOST_COLUMNS || value.is_empty() {
            continue;
        }
        if last_row.replace(row) != Some(row) {
            lines.push((String::new(), 0));
        }
        if let Some((line, count)) = lines.last_mut().filter(|(_, count)| *count <= column) {
            *line += &BETWEEN.repeat((column + u32::from(*count > 0) - *count) as usize);
            *line += &value;
            *count = column + 1;
        }
    }
    Ok(lines)
}

fn text_of(value: &DataRef) -> String {
    match value {
        DataRef::Int(number) => number.to_string(),
        DataRef::Float(number) => number.to_string(),
        DataRef::Bool(is) => u8::from(*is).to_string(),
        DataRef::String(text) => plain(text),
        DataRef::SharedString(text) => plain(text),
        DataRef::DateTimeIso(text) | DataRef::DurationIso(text) => plain(text),
        DataRef::DateTime(time) => time_text(time),
        DataRef::Error(_) | DataRef::Empty => String::new(),
    }
}

/// In one line, without what parts cells.
fn plain(text: &str) -> String {
    text.split(['\t', '\n', '\r']).collect::<Vec<_>>().join(" ")
}

/// A date and time; the time of day where there is no day; seconds of a duration.
fn time_text(time: &ExcelDateTime) -> String {
    let (year, month, day, hour, minute, second, millisecond) = time.to_ymd_hms_milli();
    let of_day = format!("{hour:02}:{minute:02}:{second:02}.{millisecond:03}");
    match (time.is_duration(), time.as_f64() < 1.0) {
        (true, _) => (time.as_f64() * 86_400.0).to_string(),
        (false, true) => of_day,
        (false, false) => format!("{year:04}-{month:02}-{day:02}T{of_day}"),
    }
}
