//! A trial whose logbook does not fit on the disk goes on, and says so.
#![cfg(target_os = "linux")]

use std::path::Path;
use std::process::{Command, Output};

use seatrial_dev::{program, program_path};
use seatrial_logbook::{Logbook, Verification};
use serde_json::Value;

/// A trial where no file may grow beyond so many blocks of 512 bytes; a whole logbook takes 2000.
fn trial(logbook: &Path, blocks: u32) -> Output {
    // Ignored, the signal of the limit turns into an error of the write, as on a full disk.
    let limited = format!(
        "trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" trial --yes --json --logbook \"$1\""
    );
    Command::new("sh").args(["-c", &limited]).arg(program_path()).arg(logbook).output().unwrap()
}

fn verify(logbook: &Path) -> Verification {
    Logbook::open_read_only(logbook).unwrap().verify().unwrap()
}

#[test]
fn cli_a_trial_goes_on_when_the_disk_fills_up() {
    let folder = tempfile::tempdir().unwrap();
    let logbook = folder.path().join("seatrial.db");
    let output = trial(&logbook, 800);
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(6), "{message}");
    assert!(message.contains("seatrial.db: not saved"), "{message}");
    let document: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(document["outcome"]["state"], "finished");
    assert_eq!(document["runs"].as_array().unwrap().len(), 5);
    // What had room is kept, and whole.
    let kept = verify(&logbook);
    assert_eq!(kept.damage, []);
    assert!(kept.runs_finished >= 1, "{kept:?}");
}

#[test]
fn cli_a_disk_that_is_full_from_the_start_stops_the_trial_before_the_vehicle_moves() {
    let folder = tempfile::tempdir().unwrap();
    let logbook = folder.path().join("seatrial.db");
    let output = trial(&logbook, 16);
    assert_eq!(output.status.code(), Some(6));
    assert_eq!(output.stdout, b"");
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(message.contains("the disk may be full"), "{message}");
    // What there is of the file is no logbook, and nothing in it is damaged.
    let damage = verify(&logbook).damage;
    assert!(damage.iter().all(|damage| damage.place == "file"), "{damage:?}");
}

/// Where even the messages have no room.
#[test]
fn cli_a_full_standard_error_does_not_stop_a_trial() {
    let folder = tempfile::tempdir().unwrap();
    let logbook = folder.path().join("seatrial.db");
    let status = program()
        .args(["trial", "--yes", "--logbook"])
        .arg(&logbook)
        .stderr(std::fs::File::create("/dev/full").unwrap())
        .output()
        .unwrap()
        .status;
    assert_eq!(status.code(), Some(0));
    assert_eq!(verify(&logbook).runs_finished, 5);
}
