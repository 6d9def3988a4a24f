//! `seatrial fleet` as a process.

use std::path::Path;
use std::process::{Command, Output};
use std::thread;
use std::time::Duration;

use seatrial_dev::program;
use serde_json::Value;

fn seatrial(args: &[&str]) -> Command {
    let mut command = program();
    command.args(args);
    command
}

fn output(args: &[&str]) -> Output {
    seatrial(args).output().unwrap()
}

/// A log of five speeds, and names of it under which a job finds it again and again.
fn logs(folder: &Path, copies: usize) {
    let log = folder.join("run0000.csv");
    let made = output(&["sim", "log", "--seed", "1", "--out", log.to_str().unwrap()]);
    assert!(made.status.success());
    for copy in 1..copies {
        std::fs::hard_link(&log, folder.join(format!("run{copy:04}.csv"))).unwrap();
    }
    std::fs::write(folder.join("bad.csv"), "time,heading\n").unwrap();
}

#[test]
fn cli_a_fleet_has_a_row_for_each_manoeuvre_and_a_summary() {
    let folder = tempfile::tempdir().unwrap();
    logs(folder.path(), 1);
    let out = folder.path().join("fleet.out");
    let args = [folder.path().to_str().unwrap(), "--out", out.to_str().unwrap()];
    let done = output(&[&["fleet", "--json"], &args[..]].concat());
    assert_eq!(done.status.code(), Some(0), "{done:?}");
    let document: Value = serde_json::from_slice(&done.stdout).unwrap();
    assert_eq!(document["schema"], "seatrial.fleet.v1");
    assert_eq!(document["logs"], 2);
    assert_eq!(document["errors"], 1);
    assert_eq!(document["estimate"], "refined");
    // Two at each of five speeds.
    assert_eq!(document["manoeuvres"], 10);
    assert!(std::fs::read(&out).unwrap().starts_with(b"PAR1"));
}

#[test]
fn cli_no_log_that_can_be_read_is_an_input_failure() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("bad.csv"), "time,heading\n").unwrap();
    let out = folder.path().join("fleet.out");
    let log = folder.path().to_str().unwrap();
    let done = output(&["fleet", log, "--out", out.to_str().unwrap()]);
    assert_eq!(done.status.code(), Some(3));
    let nothing = output(&["fleet", "no/such/*.csv", "--out", "fleet.parquet"]);
    assert_eq!(nothing.status.code(), Some(3));
}

/// Killed without notice wherever it is, the job goes on and gives the same file.
#[test]
fn cli_a_killed_fleet_is_resumed_without_loss() {
    let folder = tempfile::tempdir().unwrap();
    logs(folder.path(), 60);
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let pattern = path("*.csv");
    let (whole, killed) = (path("whole.out"), path("killed.out"));
    let args = |out| ["fleet", pattern.as_str(), "--estimate", "online", "--out", out];
    assert_eq!(output(&args(&whole)).status.code(), Some(0));
    let mut kills = 0;
    let mut wait_ms = 20;
    loop {
        let mut child = seatrial(&[&args(&killed)[..], &["--resume"]].concat()).spawn().unwrap();
        thread::sleep(Duration::from_millis(wait_ms));
        child.kill().unwrap();
        let status = child.wait().unwrap();
        if status.success() {
            break;
        }
        kills += 1;
        wait_ms += 20;
    }
    assert!(kills > 1, "{kills}");
    let bytes = |path: &str| std::fs::read(path).unwrap();
    assert_eq!(bytes(&whole), bytes(&killed));
}
