//! Damaged, cut and hostile files: an error that says what is wrong, never a panic, and soon.
#![cfg(feature = "parquet")]

use std::path::Path;

use proptest::prelude::*;
use seatrial_core::Sample;
use seatrial_logs::{
    ChannelChoice, Fault, ReadError, Row, open, write_csv, write_mcap, write_parquet,
};

fn samples(count: u32) -> Vec<Sample<f64>> {
    (0..count)
        .map(|k| {
            let time_s = f64::from(k) * 0.05;
            Sample {
                time_s,
                heading_rad: 3.0 + 0.2 * (0.7 * time_s).sin(),
                rudder_rad: 0.26 * (0.7 * time_s).cos(),
                depth_m: (k % 3 > 0).then_some(2.0 + 0.01 * time_s),
                ..Sample::default()
            }
        })
        .collect()
}

/// Reads a file of these bytes to its end.
fn rows(samples: &[Sample<f64>]) -> Vec<Row> {
    samples.iter().copied().map(Row::from).collect()
}

fn read(folder: &Path, bytes: &[u8], drop_invalid: bool) -> Result<Vec<Sample<f64>>, ReadError> {
    let path = folder.join("log");
    std::fs::write(&path, bytes).unwrap();
    let mut choice = ChannelChoice::default();
    choice.drop_invalid = drop_invalid;
    let mut reader = open(&path, &choice)?;
    let samples = reader.by_ref().collect::<Result<Vec<_>, _>>()?;
    reader.sha256()?;
    Ok(samples)
}

#[test]
fn io_csv_cut_at_every_byte_gives_the_samples_before_the_cut() {
    let folder = tempfile::tempdir().unwrap();
    let whole = samples(20);
    let mut bytes = Vec::new();
    write_csv(&mut bytes, &rows(&whole)).unwrap();
    for length in 0..bytes.len() {
        match read(folder.path(), &bytes[..length], false) {
            // The last sample may have lost digits; those before it are whole.
            Ok(read) => assert_eq!(read[..read.len() - 1], whole[..read.len() - 1], "{length}"),
            Err(error) => {
                let lines = bytes[..length].iter().filter(|byte| **byte == b'\n').count();
                let last_line_ends_in_sign =
                    bytes[..length].ends_with(b"-") || bytes[..length].ends_with(b"e");
                assert!(lines < 2 || last_line_ends_in_sign, "{length}: {error}");
            }
        }
    }
}

#[test]
fn io_parquet_cut_at_every_byte_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut bytes = Vec::new();
    write_parquet(&mut bytes, &rows(&samples(20))).unwrap();
    for length in 0..bytes.len() {
        let error = read(folder.path(), &bytes[..length], false).unwrap_err();
        assert!(length < 4 || matches!(error.fault, Fault::Damaged { .. }), "{length}: {error}");
    }
}

#[test]
fn io_parquet_with_any_byte_changed_never_panics() {
    let folder = tempfile::tempdir().unwrap();
    let mut bytes = Vec::new();
    write_parquet(&mut bytes, &rows(&samples(20))).unwrap();
    for at in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[at] ^= [0x01, 0x80, 0xff][at % 3];
        // Which bytes matter is the format's business; that reading returns is what counts.
        let _ = read(folder.path(), &damaged, false);
    }
}

/// Lines of a log as a broken logger might write them.
fn log_like() -> impl Strategy<Value = Vec<u8>> {
    let cell = prop_oneof![
        4 => any::<f64>().prop_map(|value| value.to_string()),
        4 => (-9.0..9.0_f64).prop_map(|value| value.to_string()),
        1 => Just("\"".to_string()),
        1 => "[a-zA-Z,;#\t \"-]{0,8}",
    ];
    let line = prop::collection::vec(cell, 0..6).prop_map(|cells| cells.join(","));
    prop::collection::vec(line, 0..30)
        .prop_map(|lines| format!("t,yaw,rudder,speed\n{}", lines.join("\n")).into_bytes())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn io_garbage_never_panics_and_no_sample_of_it_is_invalid(
        bytes in prop_oneof![
            prop::collection::vec(any::<u8>(), 0..2000),
            log_like(),
            prop::collection::vec(any::<u8>(), 0..200).prop_map(|rest| [b"PAR1", &rest[..], b"PAR1"].concat()),
        ],
        drop_invalid: bool,
    ) {
        let folder = tempfile::tempdir().unwrap();
        if let Ok(samples) = read(folder.path(), &bytes, drop_invalid) {
            prop_assert!(samples.is_sorted_by(|a, b| a.time_s < b.time_s));
            prop_assert!(samples.iter().all(|s| s.time_s.is_finite()
                && s.heading_rad.is_finite()
                && s.rudder_rad.is_finite()));
        }
    }
}

#[test]
fn io_a_line_without_end_is_refused_with_bounded_memory() {
    let folder = tempfile::tempdir().unwrap();
    let mut bytes = b"t,yaw,rudder\n0,0,0\n1,\"".to_vec();
    bytes.resize(3 << 20, b'7');
    let error = read(folder.path(), &bytes, true).unwrap_err();
    assert!(matches!(error.fault, Fault::LineTooLong { line: 3, .. }), "{error}");
    let header = vec![b','; 5000];
    let error = read(folder.path(), &header, true).unwrap_err();
    assert!(matches!(error.fault, Fault::TooManyColumns { .. }), "{error}");
}

/// The library writes no checksums of pages; the file has its own.
#[test]
fn io_a_flipped_bit_of_our_own_parquet_changes_no_sample_in_silence() {
    let mut whole = Vec::new();
    write_parquet(&mut whole, &rows(&samples(400))).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.parquet");
    let footer = u32::from_le_bytes(whole[whole.len() - 8..][..4].try_into().unwrap()) as usize;
    let read = |bytes: &[u8]| -> Result<Vec<_>, ReadError> {
        std::fs::write(&path, bytes).unwrap();
        open(&path, &ChannelChoice::default())?.collect()
    };
    assert_eq!(read(&whole).unwrap().len(), 400);
    let (first, end) = (4, whole.len() - 8 - footer);
    // The index of the pages before the footer is not read.
    for at in (first..end - 1000).step_by(37) {
        let mut flipped = whole.clone();
        flipped[at] ^= 1 << (at % 8);
        assert!(read(&flipped).is_err(), "byte {at} of {}", whole.len());
    }
}

/// Not a logger that was not running.
#[test]
fn io_a_damaged_first_chunk_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let mut bytes = Vec::new();
    write_mcap(&mut bytes, &rows(&samples(400))).unwrap();
    let middle = bytes.len() / 4;
    bytes[middle] ^= 4;
    std::fs::write(&path, bytes).unwrap();
    let fault = open(&path, &ChannelChoice::default()).err().map(|e| e.fault);
    assert!(matches!(fault, Some(Fault::Damaged { .. })), "{fault:?}");
}
