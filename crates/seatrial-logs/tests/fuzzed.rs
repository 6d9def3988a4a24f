//! A short run of what `fuzz/` does at length: seeds of every format, changed at random, on any toolchain.
#![cfg(all(feature = "parquet", feature = "mcap", feature = "rosbag2"))]

use std::path::Path;
use std::time::{Duration, Instant};

use seatrial_logs::{ChannelChoice, Fault, open};

use crate::memory::peak_memory_kb;
use crate::random::Random;
use crate::seeds;

/// Damaged logs of every seed.
const CASES: u64 = 400;
/// And as much again for every MB; whole seeds, of some kB, are read in less than a millisecond.
const SOON: Duration = Duration::from_secs(1);
/// What readers may hold beside twice the log.
const MOST_MEMORY_KB: u64 = 64 << 10;

/// Bits turned, numbers made extreme, segments lost or repeated, the end cut off.
fn damaged(seed: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = seed.to_vec();
    for _ in 0..=random.below(6) {
        let at = random.below(bytes.len());
        let end = (at + 1 + random.below(16)).min(bytes.len());
        match random.below(6) {
            0 | 1 => bytes[at] ^= 1 << random.below(8),
            2 => bytes[at] = random.below(256) as u8,
            3 => bytes[at..end].fill([0, 0xff, 0x7f, 0x80, b'9'][random.below(5)]),
            4 => drop(bytes.drain(at..end)),
            _ => {
                let piece = bytes[at..end].to_vec();
                bytes.splice(at..at, piece);
            }
        }
        if bytes.is_empty() {
            break;
        }
    }
    if random.below(4) == 0 {
        bytes.truncate(random.below(bytes.len()));
    }
    bytes
}

/// A cut log gives what is before the cut, or says why it gives nothing.
#[test]
fn io_every_format_cut_at_every_byte_is_read_up_to_there() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log");
    let read = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        let mut reader = open(&path, &ChannelChoice::default())?;
        let samples: Vec<_> = reader.by_ref().map_while(Result::ok).collect();
        Ok::<_, seatrial_logs::ReadError>((samples, reader.warnings()))
    };
    for (format, _) in seeds::FORMATS.iter().copied() {
        for seed in seeds::of(format) {
            let (whole, _) = read(&seed).unwrap();
            let (mut most, mut silent) = (0, 0);
            let step = if format == "rosbag2" { 101 } else { 1 + seed.len() / 800 };
            for length in (0..seed.len()).step_by(step) {
                let Ok((samples, warnings)) = read(&seed[..length]) else {
                    continue;
                };
                // The rudder of the last sample was not known to its end.
                let certain = samples.len().saturating_sub(1);
                for (cut, whole) in samples[..certain].iter().zip(&whole) {
                    let both = [cut, whole].map(|s| (s.time_s, s.heading_rad));
                    assert_eq!(both[0], both[1], "{format} {length}");
                }
                most = most.max(samples.len());
                silent += usize::from(warnings.iter().all(|w| !w.contains("cut off")));
            }
            assert!(
                ["parquet", "xlsx", "mat"].contains(&format) || most + 1 >= whole.len(),
                "{format}: {most}"
            );
            // Between two messages, and within the end of a line, nothing is cut; CSV cannot tell a short number from a cut one.
            let few = match format {
                "csv" => seed.len(),
                "rosbag2" => 0,
                "mcap" => seed.len() / 2,
                _ => 13 * seeds::ROWS as usize,
            };
            assert!(silent <= few, "{format}: {silent} of {}", seed.len());
        }
    }
}

/// The files in `found` once took for ever, or seconds for each kB.
#[test]
fn regress_what_fuzzing_found_is_read_soon() {
    let folder = tempfile::tempdir().unwrap();
    let found = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/found");
    let mut count = 0;
    for entry in std::fs::read_dir(found).unwrap() {
        let bytes = std::fs::read(entry.unwrap().path()).unwrap();
        for drop_invalid in [false, true] {
            read(folder.path(), &bytes, drop_invalid);
        }
        count += 1;
    }
    assert!(count >= 3);
}

/// Samples of a log of these bytes; the fault that ends it.
fn read(folder: &Path, bytes: &[u8], drop_invalid: bool) -> (usize, Option<Fault>) {
    let path = folder.join("log");
    std::fs::write(&path, bytes).unwrap();
    let mut choice = ChannelChoice::default();
    choice.drop_invalid = drop_invalid;
    let begun = Instant::now();
    let (mut samples, mut fault) = (0, None);
    match open(&path, &choice) {
        Ok(mut reader) => {
            for sample in reader.by_ref() {
                match sample {
                    Ok(sample) => {
                        assert!(sample.time_s.is_finite() && sample.rudder_rad.is_finite());
                        samples += 1;
                    }
                    Err(error) => fault = Some(error.fault),
                }
            }
        }
        Err(error) => fault = Some(error.fault),
    }
    let most = SOON.mul_f64(1.0 + bytes.len() as f64 / 1e6);
    assert!(begun.elapsed() < most, "{:?}", begun.elapsed());
    (samples, fault)
}

/// One test, because memory is that of the process.
#[test]
fn io_damage_costs_neither_time_nor_memory() {
    // Libraries panic on some files; the readers catch that. A trace of the stack would cost 100 MB.
    std::panic::set_hook(Box::new(|panic| eprintln!("{panic}")));
    let folder = tempfile::tempdir().unwrap();
    let seeds: Vec<(&str, Vec<u8>)> = seeds::FORMATS
        .iter()
        .flat_map(|(format, _)| seeds::of(format).into_iter().map(|seed| (*format, seed)))
        .collect();
    for (format, seed) in &seeds {
        let (samples, fault) = read(folder.path(), seed, false);
        assert!(fault.is_none(), "{format}: {fault:?}");
        assert!(samples >= seeds::ROWS as usize - 1, "{format}: {samples}");
    }
    let before_kb = peak_memory_kb();
    for (number, (_, seed)) in seeds.iter().enumerate() {
        for case in 0..CASES {
            let bytes = damaged(seed, &mut Random(number as u64 * CASES + case));
            read(folder.path(), &bytes, case % 2 == 0);
        }
    }
    if let (Some(before_kb), Some(after_kb)) = (before_kb, peak_memory_kb()) {
        let grown_kb = after_kb - before_kb;
        assert!(grown_kb < MOST_MEMORY_KB, "{grown_kb} kB");
    }
}
