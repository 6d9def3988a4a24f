//! Trials of the real process on a vehicle behind MAVLink, ended at random instants: killed, asked to stop, cut off, taken over.
//! SEATRIAL_INJECTIONS says how many; whatever ends them, the vehicle must be free within a second.
#![cfg(unix)]

mod boat;
#[path = "../../../seatrial-links/tests/autopilot/second_station.rs"]
mod second_station;

use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;
use std::process::Child;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU32, Ordering};

use boat::{Boat, INTERVAL_S, Injection};
use seatrial_dev::start_in;
use seatrial_logbook::{CampaignId, Logbook};

const PLAN: &str = "thrusts = [0.6]\n";
/// Injections where nobody says how many, and how many are under way at a time.
const INJECTIONS: u32 = 26;
const WORKERS: u32 = 26;
/// From the first command of the preflight's wiggle until so long before the trial's end that whatever comes ends it, s of the
/// vehicle.
const LIFE_S: f64 = 49.0;
/// The logbook is written once in a second; a sample is complete with the next, and one may be under way.
const KILLED_LOSES_S: f64 = 1.2;
const STOPPED_LOSES_S: f64 = 0.2;

/// What became of the trials that one injection ended.
#[derive(Default, Debug)]
struct Tally {
    count: u32,
    longest_held_s: f64,
    restored_at_once: u32,
    restored_later: u32,
    most_missing_s: f64,
}

fn errors(mut ended: Child) -> String {
    let mut text = String::new();
    let stderr = ended.stderr.as_mut().unwrap();
    stderr.read_to_string(&mut text).unwrap();
    text
}

/// One trial, ended at this instant of its life.
fn inject(injection: Injection, after_s: f64, tally: &mut Tally) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("plan.toml"), PLAN).unwrap();
    let mut boat = Boat::new(injection, after_s);
    let address = boat.address();
    let context = format!("{injection:?} after {after_s:.2} s");
    let mut trial = start_in(
        folder.path(),
        &[
            "trial",
            "--yes",
            "--plan",
            "plan.toml",
            "--full-rudder-deg",
            "14.9",
            "--vehicle",
            &address,
        ],
    );
    let status = boat.sail_with(&mut trial);
    let errors = errors(trial);
    let context = format!("{context}: {errors}");
    match injection {
        Injection::Kill => assert_eq!(status.code(), None, "{context}"),
        _ => assert_eq!(status.code(), Some(5), "{context}"),
    }
    let held_s = boat.held_s();
    // The second, and a step of the vehicle.
    assert!(held_s <= 1.0 + INTERVAL_S, "held for {held_s:.2} s: {context}");

    let backup = folder.path().join("seatrial.restore.toml");
    if backup.exists() {
        boat.be_reached();
        let arguments =
            ["vehicle", "restore", "--yes", "seatrial.restore.toml", "--vehicle", &address];
        let mut restoring = start_in(folder.path(), &arguments);
        let status = boat.sail_with(&mut restoring);
        let errors = self::errors(restoring);
        assert_eq!(status.code(), Some(0), "restoring: {errors}; {context}");
        assert!(!backup.exists(), "{context}");
        tally.restored_later += 1;
    } else {
        tally.restored_at_once += 1;
    }
    assert_eq!(boat.changed(), [""; 0], "{context}");

    let missing_s = missing_s(&folder.path().join("seatrial.db"), &boat, &context);
    let longest_s = match injection {
        Injection::Kill => KILLED_LOSES_S,
        _ => STOPPED_LOSES_S,
    };
    assert!(missing_s <= longest_s, "{missing_s:.2} s are missing: {context}");
    tally.count += 1;
    tally.longest_held_s = tally.longest_held_s.max(held_s);
    tally.most_missing_s = tally.most_missing_s.max(missing_s);
}

/// How much of what the vehicle sent before the injection is not in the logbook, s; 0 where the trial had not begun.
fn missing_s(logbook: &Path, boat: &Boat, context: &str) -> f64 {
    if !logbook.exists() {
        assert!(!boat.is_under_way(), "nothing was kept: {context}");
        return 0.0;
    }
    let logbook = Logbook::open_read_only(logbook).unwrap();
    assert_eq!(logbook.verify().unwrap().damage, [], "{context}");
    let steps = logbook.steps(CampaignId(1)).unwrap();
    match steps.last() {
        Some((_, step)) => (boat.sent_before_s() - step.sample.time_s).max(0.0),
        None => {
            assert!(!boat.is_under_way(), "nothing was kept: {context}");
            0.0
        }
    }
}

#[test]
fn prop_whatever_ends_the_process_the_vehicle_is_free() {
    let count = std::env::var("SEATRIAL_INJECTIONS").ok();
    let count = count.map_or(INJECTIONS, |count| count.parse().unwrap());
    let tallies = Mutex::new(BTreeMap::<&str, Tally>::new());
    let failures = AtomicU32::new(0);
    let next = AtomicU32::new(0);
    std::thread::scope(|scope| {
        for _ in 0..WORKERS.min(count) {
            scope.spawn(|| {
                loop {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    if number >= count {
                        break;
                    }
                    let injection = Injection::ALL[number as usize % Injection::ALL.len()];
                    // Spread evenly, and over each kind alike: the golden ratio's multiples.
                    let place = (f64::from(number) * 0.618_033_988_749_894_9).fract();
                    let mut tally = Tally::default();
                    let injected = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
                        inject(injection, LIFE_S * place, &mut tally);
                    }));
                    // What failed is told by then; the others go on.
                    failures.fetch_add(u32::from(injected.is_err()), Ordering::Relaxed);
                    let mut tallies = tallies.lock().unwrap();
                    let sum = tallies.entry(injection.name()).or_default();
                    sum.count += tally.count;
                    sum.restored_at_once += tally.restored_at_once;
                    sum.restored_later += tally.restored_later;
                    sum.longest_held_s = sum.longest_held_s.max(tally.longest_held_s);
                    sum.most_missing_s = sum.most_missing_s.max(tally.most_missing_s);
                }
            });
        }
    });
    for (name, tally) in tallies.into_inner().unwrap() {
        eprintln!(
            "| {name} | {} | {:.2} | {} | {} | {:.2} |",
            tally.count,
            tally.longest_held_s,
            tally.restored_at_once,
            tally.restored_later,
            tally.most_missing_s
        );
    }
    assert_eq!(failures.into_inner(), 0, "injections failed");
}
