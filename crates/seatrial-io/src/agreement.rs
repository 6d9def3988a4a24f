//! Every number of every message of every native log, against what the formats' own Python libraries read.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use crate::joined::{Kind, Message, Messages};
use crate::table::hexadecimal;

/// Made by `expect.py` beside it: log, kind, messages, hash of all numbers.
const EXPECTED: &str = include_str!("../tests/agreement/expected.txt");

/// Fields that this crate computes: they stand behind the log's own.
fn computed(kind: &Kind) -> usize {
    let has = |name: &str| kind.fields.iter().any(|field| field == name);
    let ends_in = |name: &str| kind.fields.last().is_some_and(|field| field == name);
    let of_ros = ["roll_rad", "pitch_rad", "heading_rad", "yaw_rate_rad_s"];
    let is_of_ros = |field: &&String| of_ros.iter().any(|name| field.ends_with(name));
    3 * usize::from(has("q[0]") && has("q[3]") && has("timestamp"))
        + usize::from(ends_in("ground_speed"))
        + usize::from(ends_in("steering_fraction"))
        + kind.fields.iter().filter(is_of_ros).count()
}

/// Messages and hash of every kind, as `expect.py` makes them.
fn kinds(mut log: impl Messages) -> BTreeMap<String, (usize, String)> {
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

fn found(path: &Path) -> BTreeMap<String, (usize, String)> {
    let file = File::open(path).unwrap();
    match path.extension().and_then(|suffix| suffix.to_str()) {
        Some("BIN") => kinds(crate::dataflash::DataFlash::open(file).unwrap()),
        Some("tlog") => kinds(crate::tlog::Telemetry::open(file).unwrap()),
        Some("ulg") => kinds(crate::ulog::ULog::open(file).unwrap()),
        Some("mcap") => kinds(crate::mcap::Mcap::open(file).unwrap()),
        _ => kinds(crate::rosbag::Bag::open(file, path).unwrap()),
    }
}

#[test]
fn val_every_number_is_that_of_the_python_libraries() {
    let crate_folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let data = std::env::var_os("SEATRIAL_DATA")
        .map_or_else(|| crate_folder.join("../../../shared/data"), PathBuf::from);
    let mut expected: BTreeMap<&str, BTreeMap<String, (usize, String)>> = BTreeMap::new();
    for line in EXPECTED.lines() {
        let [log, kind, count, hash] = line.split('\t').collect::<Vec<_>>()[..] else {
            panic!("{line}");
        };
        let kinds = expected.entry(log).or_default();
        kinds.insert(kind.into(), (count.parse().unwrap(), hash.into()));
    }
    assert!(expected.len() > 10);
    for (log, expected) in expected {
        let path = match log.contains('/') {
            true => data.join("native").join(log),
            false => crate_folder.join("tests/agreement").join(log),
        };
        if !path.exists() {
            eprintln!("skipped: no {} (set SEATRIAL_DATA)", path.display());
            continue;
        }
        assert_eq!(found(&path), expected, "{log}");
    }
}
