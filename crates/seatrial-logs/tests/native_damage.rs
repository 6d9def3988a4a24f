//! Native logs with bytes changed, lost and repeated at random: never a panic, and soon.

use std::time::{Duration, Instant};

use seatrial_dev::data;
use seatrial_logs::{ChannelChoice, open};

use crate::random::Random;

/// Cases of each file.
const CASES: u64 = 120;
/// Of each file so many bytes are damaged: enough for descriptions of messages and messages.
const START: usize = 250_000;
/// The limit for a damaged file; undamaged ones of this size take a few ms.
const SOON: Duration = Duration::from_secs(2);

fn damaged(whole: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = whole.to_vec();
    for _ in 0..=random.below(20) {
        let at = random.below(bytes.len());
        match random.below(6) {
            0..3 => bytes[at] ^= 1 << random.below(8),
            3 => bytes[at] = [0, 0xff, 0x80, 0xa3][random.below(4)],
            4 => drop(bytes.drain(at..(at + random.below(300)).min(bytes.len()))),
            _ => {
                let piece = bytes[at..(at + random.below(300)).min(bytes.len())].to_vec();
                bytes.splice(at..at, piece);
            }
        }
        if bytes.is_empty() {
            break;
        }
    }
    if random.below(3) == 0 {
        bytes.truncate(random.below(bytes.len()));
    }
    bytes
}

#[test]
fn io_damaged_native_logs_never_panic_and_end_soon() {
    let folder = tempfile::tempdir().unwrap();
    for file in [
        "ardupilot/arduplane_pixhawk_64k.BIN",
        "ardupilot/ardusub_small.BIN",
        "ardupilot/rover_json_physics.tlog",
        "ardupilot/ardusub_small.tlog",
        "px4/fixedwing_fmuv6c.ulg",
        "px4/quad_v4pro_appended.ulg",
        "nmea2000/triton-engine-setup.all",
        "slocum/amadeus-2014-204-05-000.dbd",
    ] {
        let Some(path) = data(&format!("native/{file}")) else {
            continue;
        };
        let mut whole = std::fs::read(&path).unwrap();
        whole.truncate(START);
        let damaged_path = folder.path().join("log");
        // A glider's list of sensors.
        let cache = path.with_file_name("cac/468fd1be.cac");
        let _ = std::fs::copy(cache, folder.path().join("468fd1be.cac"));
        let mut opened = 0;
        for seed in 0..CASES {
            let bytes = damaged(&whole, &mut Random(seed));
            std::fs::write(&damaged_path, &bytes).unwrap();
            let mut choice = ChannelChoice::default();
            choice.drop_invalid = seed % 2 == 0;
            let begun = Instant::now();
            if let Ok(mut reader) = open(&damaged_path, &choice) {
                opened += 1;
                for sample in reader.by_ref().map_while(Result::ok) {
                    assert!(sample.time_s.is_finite() && sample.rudder_rad.is_finite());
                }
                reader.sha256().unwrap();
            }
            assert!(begun.elapsed() < SOON, "{file}, seed {seed}");
        }
        // Most damage must not cost the log.
        assert!(opened > CASES / 2, "{file}: {opened}");
    }
}
