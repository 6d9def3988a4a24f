//! What a file is, by its content; its name does not matter.

mod alog;
mod expedition;
mod lsf;

use std::io::{self, Cursor, Read, Seek};
use std::path::Path;

#[cfg(feature = "containers")]
use crate::as_text::{decoded, encoding};
use crate::bytes::Bytes;
use crate::csv::Text;
use crate::error::{Fault, ReadError};
use crate::format_name::Format;
use crate::formats::Formats;
use crate::input::{FileMap, Input};
use crate::line_log::{LineFormat, LineLog};
use crate::message_table::{MessageTable, Messages};
use crate::name::ColumnName;
use crate::no_log::{MATLAB, ROS1, check_is_log, has_keys, holds, is_workbook};
use crate::quantity::Quantity;
use crate::table::Table;

/// Bytes that are enough to tell every format.
const START: u64 = 4096;

/// Opens a format that this build may have been made without.
macro_rules! built {
    ($needed:literal, $feature:literal, $name:literal, $open:expr) => {{
        #[cfg(feature = $needed)]
        {
            Ok(Box::new($open))
        }
        #[cfg(not(feature = $needed))]
        {
            Err(Fault::NotBuilt { format: $name, feature: concat!("--features ", $feature) })
        }
    }};
}

/// What these first bytes are the start of; text where they are nothing else.
fn format(start: &[u8]) -> Format {
    let starts = [
        (start.starts_with(b"PAR1"), Format::Parquet),
        (is_dataflash(start), Format::DataFlash),
        (is_telemetry(start), Format::Tlog),
        (start.starts_with(b"ULog\x01\x12\x35"), Format::Ulog),
        (start.starts_with(b"\x89MCAP0\r\n"), Format::Mcap),
        (start.starts_with(b"SQLite format 3\0"), Format::Rosbag),
        (is_dbd(start), Format::Slocum),
        (crate::nmea2000::is_start(start), Format::Canboat),
        (is_nmea0183(start), Format::Nmea0183),
        (expedition::is_start(start), Format::Expedition),
        (crate::signal_k::is_start(start), Format::SignalK),
        (lsf::is_start(start), Format::Lsf),
        (start.starts_with(b"%%%%"), Format::Alog),
        (start.starts_with(b"%% LOG"), Format::Alog),
        (start.starts_with(ROS1), Format::Rosbag1),
        (start.starts_with(MATLAB), Format::Matlab),
        (is_workbook(start), Format::Workbook),
    ];
    let found = starts.into_iter().find(|(is_it, _)| *is_it);
    found.map_or(Format::Csv, |(_, format)| format)
}

/// Is it the text that `dbd2asc` makes of a glider's log? The log itself has bytes or a list of sensors behind its header.
fn is_dbd_ascii(start: &[u8]) -> bool {
    let is_text = |byte: &u8| (b' '..0x7f).contains(byte) || byte.is_ascii_whitespace();
    start.starts_with(b"dbd_label:") && start.iter().all(is_text) && !holds(start, b"\ns: ")
}

fn start(input: impl Read) -> Result<Vec<u8>, Fault> {
    let mut start = Vec::new();
    input.take(START).read_to_end(&mut start).map_err(Fault::read)?;
    Ok(start)
}

/// Is this file a log, or what packs one? Of a text or a Parquet file its columns tell: a heading, and a rudder or a time.
pub fn is_log(path: &Path) -> bool {
    let Ok(start) = crate::input::opened(path).map_err(Fault::read).and_then(start) else {
        return false;
    };
    if let Err(fault) = check_is_log(&start) {
        return !start.starts_with(b"PK") && !matches!(fault, Fault::NoLog { .. });
    }
    match format(&start) {
        Format::Csv | Format::Parquet | Format::Workbook | Format::Matlab => columns(path)
            .is_ok_and(|columns| {
                let has = |quantity| {
                    let mut columns = columns.iter();
                    columns.any(|name| ColumnName::new(name).fit(quantity).is_some())
                };
                // A table of results has a verdict, as that of many logs has.
                let is_of_results = columns.iter().any(|name| name == "verdict");
                has(Quantity::Heading)
                    && (has(Quantity::Rudder) || has(Quantity::Time))
                    && !is_of_results
            }),
        _ => true,
    }
}

/// The names of a log's columns, topics with fields, or messages with fields, whether or not their meaning is known.
pub fn columns(path: &Path) -> Result<Vec<String>, ReadError> {
    columns_from(path, &FileMap::default())
}

/// [`columns`] of a path that may be one of a file in memory.
pub fn columns_from(path: &Path, held: &FileMap) -> Result<Vec<String>, ReadError> {
    let named = table(path, held, &Formats::default()).map(|table| table.columns().to_vec());
    let log = path.display().to_string();
    named.map_err(|fault| ReadError { log, fault })
}

pub(crate) fn table(
    path: &Path,
    held: &FileMap,
    formats: &Formats,
) -> Result<Box<dyn Table>, Fault> {
    if path == Path::new("-") {
        return open_stream(io::stdin(), formats);
    }
    let opening = |source| Fault::Io { doing: "opened", source };
    let file = held.open(path).map_err(opening)?;
    if file.is_folder().map_err(opening)? {
        return Err(Fault::Folder);
    }
    open(file, path, held, formats)
}

/// Opens what comes on standard input: text as it comes; the others, which are read more than once, from a
/// file without a name.
pub(crate) fn open_stream(
    mut input: impl Read + Send + 'static,
    formats: &Formats,
) -> Result<Box<dyn Table>, Fault> {
    let path = Path::new("");
    let start = start(&mut input)?;
    let mut input = Cursor::new(start.clone()).chain(input);
    if formats.of(&start, path).is_none() {
        check_is_log(&start)?;
        let is_made_into_one = has_keys(&start) || is_dbd_ascii(&start);
        let is_table = std::str::from_utf8(&start).is_ok() && !is_made_into_one;
        if format(&start) == Format::Csv && is_table {
            return Ok(Box::new(Text::open(input)?));
        }
    }
    let mut file = tempfile::tempfile().map_err(Fault::read)?;
    io::copy(&mut input, &mut file).map_err(Fault::read)?;
    file.rewind().map_err(Fault::read)?;
    open(Input::File(file), path, &FileMap::default(), formats)
}

/// Opens a file as what it is.
pub(crate) fn open(
    mut file: Input,
    path: &Path,
    held: &FileMap,
    formats: &Formats,
) -> Result<Box<dyn Table>, Fault> {
    let start = start(&mut file)?;
    file.rewind().map_err(Fault::read)?;
    if let Some(brought) = formats.of(&start, path) {
        let messages = brought.open(Bytes::new(file)?)?;
        let format = Format::Other(brought.name().into());
        return Ok(Box::new(MessageTable::new(format, messages)));
    }
    check_is_log(&start)?;
    if crate::dataflash_text::is_start(&start) {
        file = crate::dataflash_text::binary(file)?;
    }
    if !crate::pcap::is_start(&start) {
        return built_in(format(&start), file, path, held);
    }
    let mut lines = crate::pcap::lines(file)?;
    let start = self::start(&mut lines)?;
    lines.rewind().map_err(Fault::read)?;
    built_in(format(&start), lines, path, held)
}

fn built_in(
    format: Format,
    file: Input,
    path: &Path,
    held: &FileMap,
) -> Result<Box<dyn Table>, Fault> {
    match format {
        Format::Parquet => {
            built!("parquet-reader", "parquet", "Parquet", crate::parquet::Columnar::open(file)?)
        }
        Format::Mcap => built!(
            "mcap-reader",
            "mcap",
            "MCAP",
            MessageTable::new(format, Box::new(crate::mcap::Mcap::open(file)?))
        ),
        Format::Rosbag => built!(
            "rosbag2",
            "rosbag2",
            "rosbag2",
            MessageTable::new(format, {
                let path = file.path(path);
                Box::new(crate::rosbag::Bag::open(file, path)?)
            })
        ),
        Format::DataFlash => joined(format, crate::dataflash::DataFlash::open(file)),
        Format::Tlog => joined(format, crate::tlog::Telemetry::open(file)),
        Format::Ulog => joined(format, crate::ulog::ULog::open(file)),
        Format::Lsf => joined(format, lsf::Lsf::open(file)),
        Format::Slocum => joined(format, crate::slocum::Glider::open(file, path, held)),
        Format::Canboat => Ok(Box::new(MessageTable::new(format, crate::nmea2000::open(file)?))),
        Format::Nmea0183 => joined(format, crate::nmea0183::Sentences::open(file)),
        Format::Expedition => lines(format, file, expedition::Pairs::default()),
        Format::SignalK => lines(format, file, crate::signal_k::Deltas),
        Format::Alog => lines(format, file, alog::Alog),
        Format::Rosbag1 => built!(
            "containers",
            "containers",
            "a bag of ROS 1",
            MessageTable::new(format, Box::new(crate::ros1::Bag::open(file)?))
        ),
        Format::Workbook => built!("containers", "containers", "a workbook", {
            let mut file = file;
            let (text, warnings) = crate::workbook::text(&mut file)?;
            Text::made_of(file, format, Cursor::new(text), warnings)?
        }),
        Format::Matlab => built!("containers", "containers", "a MATLAB file", {
            let mut file = file;
            let rows = crate::matlab::text(&mut file)?;
            Text::made_of(file, format, rows, Vec::new())?
        }),
        Format::Csv | Format::Other(_) => text(file),
    }
}

/// Delimited text, in whatever encoding, or lines that are made into it.
#[cfg(feature = "containers")]
fn text(mut file: Input) -> Result<Box<dyn Table>, Fault> {
    let first = start(&mut file)?;
    file.rewind().map_err(Fault::read)?;
    let table = if let Some(encoding) = encoding(&first) {
        let remark = format!("the text is read as {}", encoding.name());
        let text = decoded(&file, encoding)?;
        Text::made_of(file, Format::Csv, text, vec![remark])?
    } else if has_keys(&first) {
        let lines = crate::key_value::text(&file)?;
        Text::made_of(file, Format::Csv, lines, Vec::new())?
    } else if is_dbd_ascii(&first) {
        let table = crate::slocum::of_ascii(&file)?;
        Text::made_of(file, Format::Csv, table, Vec::new())?
    } else {
        Text::open(file)?
    };
    Ok(Box::new(table))
}

/// Delimited text.
#[cfg(not(feature = "containers"))]
fn text(mut file: Input) -> Result<Box<dyn Table>, Fault> {
    file.rewind().map_err(Fault::read)?;
    Ok(Box::new(Text::open(file)?))
}

fn joined(
    format: Format,
    messages: Result<impl Messages + 'static, Fault>,
) -> Result<Box<dyn Table>, Fault> {
    Ok(Box::new(MessageTable::new(format, Box::new(messages?))))
}

fn lines(
    format: Format,
    file: Input,
    lines: impl LineFormat + 'static,
) -> Result<Box<dyn Table>, Fault> {
    joined(format, LineLog::open(Bytes::new(file)?, lines))
}

/// The first message describes messages.
fn is_dataflash(start: &[u8]) -> bool {
    start.starts_with(&[0xa3, 0x95, 0x80]) || crate::dataflash_text::is_start(start)
}

fn is_dbd(start: &[u8]) -> bool {
    start.starts_with(b"dbd_label:") && !is_dbd_ascii(start)
}

/// A time of arrival, us since 1970, of the years 1990 to 2100 (ground stations have a clock), then a frame.
fn is_telemetry(start: &[u8]) -> bool {
    let stamp = start.first_chunk().map(|bytes| u64::from_be_bytes(*bytes));
    stamp.is_some_and(|us| (630_000_000_000_000..4_100_000_000_000_000).contains(&us))
        && matches!(start.get(8), Some(0xfd | 0xfe))
}

/// Lines of text without comments and blanks.
fn first_lines(start: &[u8]) -> impl Iterator<Item = &[u8]> {
    start
        .split(|byte| *byte == b'\n')
        .map(<[u8]>::trim_ascii)
        .filter(|line| !line.is_empty() && !line.starts_with(b"#"))
}

/// One of the first lines is a sentence: `$` or `!`, an address in capitals, a comma.
fn is_nmea0183(start: &[u8]) -> bool {
    let is_sentence = |line: &[u8]| {
        let Some(at) = line.iter().position(|byte| matches!(byte, b'$' | b'!')) else {
            return false;
        };
        let address = line[at + 1..].split(|byte| *byte == b',').next();
        line[at..].contains(&b',')
            && address.is_some_and(|address| {
                (5..=8).contains(&address.len())
                    && address.iter().all(|byte| byte.is_ascii_uppercase() || byte.is_ascii_digit())
            })
    };
    first_lines(start).take(3).any(is_sentence)
}
