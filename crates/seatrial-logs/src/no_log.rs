//! What people give for a log that is none: what it is, and what to give in its place.

use crate::bytes::ZSTD;
use crate::error::Fault;

/// What MATLAB's files and bags of ROS 1 begin with; MATLAB's since version 7.3 are HDF5.
pub(crate) const MATLAB: &[u8] = b"MATLAB 5.0 MAT-file";
const MATLAB_73: &[u8] = b"MATLAB 7.3 MAT-file";
pub(crate) const ROS1: &[u8] = b"#ROSBAG V2.0\n";

/// What packs files, the bytes it begins them with, and the command that unpacks to standard output.
const PACKERS: [(&str, &[u8], &str); 4] = [
    ("gzip", b"\x1f\x8b\x08", "gzip -dc"),
    ("zstd", ZSTD, "zstd -dc"),
    ("bzip2", b"BZh", "bzip2 -dc"),
    ("xz", b"\xfd7zXZ\0", "xz -dc"),
];

/// What the packed workbooks of spreadsheets hold near their beginning.
const WORKBOOK: [&[u8]; 2] = [b"[Content_Types].xml", b"xl/"];
const OPEN_DOCUMENT: &[u8] = b"application/vnd.oasis.opendocument.spreadsheet";

/// What is recorded where boats are, by the bytes that it begins with, and what to give in its place.
const NO_LOGS: &[(&[u8], &str, &str)] = &[
    (
        b"LOGG",
        "a log of CAN frames (BLF)",
        "convert it with `python -m can.logconvert LOG.blf LOG.asc`, and give the .asc",
    ),
    (
        b"MDF     ",
        "a measurement file (MDF)",
        "export its columns of time, heading and rudder as CSV, as `asammdf` does",
    ),
    (
        b"\xed\xa1\xda\x01",
        "a log of LCM",
        "write its channels of heading and rudder as CSV, as Python's `lcm.EventLog` reads them",
    ),
    (b"\x02\0\0\0\xb2\x07", "a sonar log of Navico (SL2), without a rudder", NMEA_INSTEAD),
    (b"\x02\0\0\0\x80\x0c", "a sonar log of Navico (SL2), without a rudder", NMEA_INSTEAD),
    (b"FTP NEW", "a raw file of HYPACK, without a rudder", NMEA_INSTEAD),
    (
        b"\x89HDF\r\n",
        "a file of arrays (HDF5)",
        "write its columns of time, heading and rudder as CSV, as `pandas.DataFrame(...).to_csv(\"log.csv\")` does",
    ),
    (b"TITLE = ", TECPLOT, TECPLOT_INSTEAD),
    (b"TITLE=", TECPLOT, TECPLOT_INSTEAD),
    (b"VARIABLES", TECPLOT, TECPLOT_INSTEAD),
    (b"INSERT INTO", SQL, SQL_INSTEAD),
    (b"CREATE TABLE", SQL, SQL_INSTEAD),
    (b"\x89PNG\r\n", "a picture (PNG)", LOG_INSTEAD),
    (b"\xff\xd8\xff", "a picture (JPEG)", LOG_INSTEAD),
    (b"GIF8", "a picture (GIF)", LOG_INSTEAD),
    (b"%PDF-", "a document (PDF)", LOG_INSTEAD),
    (b"{\\rtf", "a document (RTF)", LOG_INSTEAD),
    (b"OggS", "a sound or a film (Ogg)", LOG_INSTEAD),
    (b"PK\x05\x06", "an empty zip archive", LOG_INSTEAD),
    (b"PK\x03\x04", "a zip archive", "unpack it, and give the log that is in it"),
];

const TECPLOT: &str = "a data file of Tecplot";
const TECPLOT_INSTEAD: &str =
    "give its rows as CSV, with the names of its VARIABLES in the line above them";
const SQL: &str = "statements of a database (SQL)";
const SQL_INSTEAD: &str =
    "export the table as CSV, as `sqlite3 -header -csv LOG.db 'SELECT * FROM log'` does";
const NMEA_INSTEAD: &str = "record the NMEA sentences or frames of compass and rudder";
pub(crate) const LOG_INSTEAD: &str = "give the log itself, with time, heading and rudder";

/// How the columns of applications that record a phone begin: Sensor Logger, phyphox.
const PHONE: [&str; 3] = ["seconds_elapsed", "Gyroscope x", "Linear Acceleration x"];

/// A table without a rudder that is of a phone, or of no vehicle: it has no heading and nothing else than a time.
pub(crate) fn table_of_else(columns: &[String], is_of_no_vehicle: bool) -> Option<Fault> {
    let is_of_a_phone =
        columns.iter().any(|column| PHONE.iter().any(|name| column.starts_with(name)));
    let (what, instead) = match (is_of_a_phone, is_of_no_vehicle) {
        (true, _) => (
            "the log of a phone, which cannot tell how the boat steers",
            "record the rudder beside the heading",
        ),
        (false, true) => (
            "a table without heading and rudder",
            "give the log of a vehicle, or name its columns with --heading NAME and --rudder NAME",
        ),
        (false, false) => return None,
    };
    Some(Fault::NoLog { what, instead })
}

/// What a film of a phone or a camera has at its fifth byte.
const FILM: &[u8] = b"ftyp";

/// Roots of documents in XML.
const TRACK_INSTEAD: &str =
    "record the rudder and the heading, and give this file as the positions beside that log";
const XML: [(&[u8], &str, &str); 4] = [
    (b"<gpx", "a GPX track, positions without a rudder", TRACK_INSTEAD),
    (b"<kml", "a KML track, positions without a rudder", TRACK_INSTEAD),
    (b"<TrainingCenterDatabase", "a TCX track, positions without a rudder", TRACK_INSTEAD),
    (b"<html", "a page (HTML)", LOG_INSTEAD),
];

/// What is to be done with a document in XML or JSON.
const XML_INSTEAD: &str =
    "export the log as CSV, one row per sample, with time, heading and rudder";
const JSON_INSTEAD: &str = "export the log as CSV, one row per sample, as `jq -rs '[\"time\", \"heading\", \"rudder\"], (flatten[] | [.time, .heading, .rudder]) | @csv'` does";

/// A text that is the document of something else than a log.
fn document(start: &[u8]) -> Option<(&'static str, &'static str)> {
    let start = start.strip_prefix(b"\xef\xbb\xbf").unwrap_or(start).trim_ascii_start();
    if let Some((_, what, instead)) =
        XML.iter().find(|(root, ..)| holds(start, root)).filter(|_| start.starts_with(b"<"))
    {
        return Some((what, instead));
    }
    if start.starts_with(b"<?xml") || start.starts_with(b"<!DOCTYPE") {
        return Some(("a document in XML", XML_INSTEAD));
    }
    if start.starts_with(b"header:") && holds(start, b"\n---\n") {
        return Some((
            "messages as `ros2 topic echo` prints them",
            "record a bag of heading and rudder, as `ros2 bag record` does",
        ));
    }
    let is_json = start.starts_with(b"{") || start.starts_with(b"[{") || start.starts_with(b"[[");
    let is_read =
        has_keys(start) || crate::signal_k::is_start(start) || crate::nmea2000::is_start(start);
    (is_json && !is_read).then_some(("a document in JSON", JSON_INSTEAD))
}

pub(crate) fn holds(start: &[u8], name: &[u8]) -> bool {
    start.windows(name.len()).any(|part| part == name)
}

pub(crate) fn is_workbook(start: &[u8]) -> bool {
    start.starts_with(b"PK") && WORKBOOK.iter().any(|name| holds(start, name))
}

/// Refuses what holds a log, or belongs to one, and is none itself.
pub(crate) fn check_is_log(start: &[u8]) -> Result<(), Fault> {
    let packer = PACKERS.iter().find(|(_, bytes, _)| start.starts_with(bytes));
    let known = NO_LOGS.iter().find(|(bytes, ..)| start.starts_with(bytes));
    let film = (start.get(4..8) == Some(FILM)).then_some(("a film (MP4)", LOG_INSTEAD));
    Err(if is_workbook(start) {
        return Ok(());
    } else if start.starts_with(b"PK") && holds(start, OPEN_DOCUMENT) {
        Fault::Workbook
    } else if start.starts_with(MATLAB_73) {
        Fault::Matlab73
    } else if let Some((packer, _, unpack)) = packer {
        Fault::Packed { packer, unpack }
    } else if let Some((what, instead)) = known
        .map(|(_, what, instead)| (*what, *instead))
        .or(film)
        .or_else(|| document(start))
        .or_else(|| untimed(start))
    {
        Fault::NoLog { what, instead }
    } else if start.starts_with(b"s: T ") || start.starts_with(b"s: F ") {
        Fault::SlocumCache
    } else if start.starts_with(b"#ROSBAG V") && !start.starts_with(ROS1) {
        Fault::NothingToRead {
            format: "bag of ROS 1",
            what: "expected version 2.0, to which `rosbag fix FILE.bag NEW.bag` converts it".into(),
        }
    } else {
        return Ok(());
    })
}

fn untimed(start: &[u8]) -> Option<(&'static str, &'static str)> {
    crate::nmea2000::is_untimed(start).then_some((
        "frames of a CAN bus without times",
        "record them with their times, as `candump -l can0` does",
    ))
}

#[cfg(feature = "containers")]
pub(crate) fn has_keys(start: &[u8]) -> bool {
    crate::key_value::is_start(start)
}

#[cfg(not(feature = "containers"))]
pub(crate) fn has_keys(_: &[u8]) -> bool {
    false
}
