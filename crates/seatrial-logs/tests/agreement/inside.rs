//! Every number of every message of every native log, against what other libraries read; every log as a stream, against the file.

#[path = "../seeds/mod.rs"]
mod seeds;

use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::process::Command;

use seatrial_dev::{data, python_with};
use sha2::{Digest, Sha256};

use crate::content::{open_stream, table};
use crate::formats::Formats;
use crate::input::FileMap;
use crate::message_table::{Kind, Message, Messages};
use crate::table::{Table, hexadecimal};
use crate::{ChannelChoice, LogReader};

/// Made by `expect.py` beside it: log, kind, messages, hash of all numbers.
const EXPECTED: &str = include_str!("expected.txt");

/// Messages and hash of every kind.
type Kinds = BTreeMap<String, (usize, String)>;

/// Fields that this crate computes: they stand behind the log's own.
fn computed(kind: &Kind) -> usize {
    let has = |name: &str| kind.fields.iter().any(|field| field == name);
    let ends_in = |name: &str| kind.fields.last().is_some_and(|field| field == name);
    let of_ros = [".roll_rad", ".pitch_rad", ".heading_rad", ".yaw_rate_rad_s"];
    let is_of_ros = |field: &&String| of_ros.iter().any(|name| field.ends_with(name));
    3 * usize::from(has("q[0]") && has("q[3]") && has("timestamp"))
        + usize::from(ends_in("ground_speed"))
        + usize::from(ends_in("steering_fraction"))
        + kind.fields.iter().filter(is_of_ros).count()
}

/// Messages and hash of every kind, as `expect.py` makes them.
fn kinds(log: &mut dyn Messages) -> Kinds {
    let wanted = vec![true; log.kinds().len()];
    let mut hashes = vec![(0, Sha256::new()); wanted.len()];
    let mut message = Message::default();
    while log.next(&wanted, &mut message).unwrap() {
        let kind = &log.kinds()[message.kind];
        assert_eq!(message.values.len(), kind.fields.len(), "{}", kind.name);
        let own = message.values.len() - computed(kind);
        let (count, hash) = &mut hashes[message.kind];
        *count += 1;
        for value in &message.values[..own] {
            let value = if value.is_nan() { f64::NAN } else { *value };
            hash.update(value.to_le_bytes());
        }
    }
    let named = log.kinds().iter().zip(hashes);
    named
        .filter(|(_, (count, _))| *count > 0)
        .map(|(kind, (count, hash))| {
            let digits = hexadecimal(&hash.finalize())[..16].to_string();
            (kind.name.clone(), (count, digits))
        })
        .collect()
}

fn found(path: &Path) -> Kinds {
    let file = FileMap::default().open(path).unwrap();
    match path.extension().and_then(|suffix| suffix.to_str()) {
        Some("BIN") => kinds(&mut crate::dataflash::DataFlash::open(file).unwrap()),
        Some("tlog") => kinds(&mut crate::tlog::Telemetry::open(file).unwrap()),
        Some("ulg") => kinds(&mut crate::ulog::ULog::open(file).unwrap()),
        Some("mcap") => kinds(&mut crate::mcap::Mcap::open(file).unwrap()),
        Some("dbd") => {
            kinds(&mut crate::slocum::Glider::open(file, path, &FileMap::default()).unwrap())
        }
        Some("raw" | "all") => kinds(&mut *crate::nmea2000::open(file).unwrap()),
        Some("nmea") => kinds(&mut crate::nmea0183::Sentences::open(file).unwrap()),
        _ => kinds(&mut crate::rosbag::Bag::open(file, path).unwrap()),
    }
}

/// By log, what `expect.py` prints.
fn expected(text: &str) -> BTreeMap<&str, Kinds> {
    let mut expected: BTreeMap<&str, Kinds> = BTreeMap::new();
    for line in text.lines() {
        let [log, kind, count, hash] = line.split('\t').collect::<Vec<_>>()[..] else {
            panic!("{line}");
        };
        let kinds = expected.entry(log).or_default();
        kinds.insert(kind.into(), (count.parse().unwrap(), hash.into()));
    }
    expected
}

/// Of a glider's thousands of sensors only some are expected.
fn assert_agrees(path: &Path, expected: &Kinds) {
    let mut found = found(path);
    if path.extension().is_some_and(|suffix| suffix == "dbd") {
        found.retain(|kind, _| expected.contains_key(kind));
    }
    assert_eq!(found, *expected, "{}", path.display());
}

fn agreement() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/agreement")
}

#[test]
fn val_every_number_is_that_of_the_python_libraries() {
    let expected = expected(EXPECTED);
    assert!(expected.len() > 14);
    for (log, expected) in expected {
        let path = match log.contains('/') {
            true => data(&format!("native/{log}")),
            false => Some(agreement().join(log)),
        };
        if let Some(path) = path {
            assert_agrees(&path, &expected);
        }
    }
}

/// The libraries as they are installed now, on the logs that are here on every machine.
#[test]
fn val_the_python_libraries_read_the_same_today() {
    let Some(python) =
        python_with("dbdreader, mcap_ros2, nmea2000, pymavlink, pynmea2, pyulog, rosbags")
    else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    for (name, log) in [
        ("seed.BIN", seeds::dataflash()),
        ("seed.tlog", seeds::tlog()),
        ("seed.ulg", seeds::ulog()),
        ("seed.raw", seeds::nmea2000::canboat()),
    ] {
        std::fs::write(folder.path().join(name), log).unwrap();
    }
    let output = Command::new(python)
        .arg(agreement().join("expect.py"))
        .arg(folder.path())
        .output()
        .unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    let text = String::from_utf8(output.stdout).unwrap();
    let expected = expected(&text);
    assert_eq!(expected.len(), 7, "{:?}", expected.keys());
    for (log, expected) in expected {
        let path = match log.starts_with("seed") {
            true => folder.path().join(log),
            false => agreement().join(log),
        };
        assert_agrees(&path, &expected);
    }
}

#[test]
fn io_every_format_comes_on_standard_input_and_from_memory_too() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log");
    let samples = |table: Box<dyn Table>| {
        let reader = LogReader::new(String::new(), table, &ChannelChoice::default()).unwrap();
        reader.collect::<Result<Vec<_>, _>>().unwrap()
    };
    for (format, _) in seeds::FORMATS {
        for seed in seeds::of(format) {
            std::fs::write(&path, &seed).unwrap();
            let named = samples(table(&path, &FileMap::default(), &Formats::default()).unwrap());
            let mut held = FileMap::default();
            held.insert("no/such/log", seed.clone());
            let in_memory =
                samples(table(Path::new("no/such/log"), &held, &Formats::default()).unwrap());
            let piped = samples(open_stream(Cursor::new(seed), &Formats::default()).unwrap());
            assert!(!piped.is_empty(), "{format}");
            assert_eq!(named, piped, "{format}");
            assert_eq!(named, in_memory, "{format}");
        }
    }
}
