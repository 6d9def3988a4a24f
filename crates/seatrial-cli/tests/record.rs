//! `trial --record`: what the trial saw and estimated, in every format, also after a kill.

use std::process::{Output, Stdio};
use std::time::{Duration, Instant};

use seatrial_dev::{document, program, run_in};
use serde_json::Value;

fn json(output: &Output) -> Value {
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{stderr}");
    document(output)
}

const PLAN: &str = "thrusts = [0.6, 0.8]\n";

#[test]
fn cli_a_recording_is_what_the_trial_saw() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("plan.toml"), PLAN).unwrap();
    let record = |name: &str| {
        let logbook = format!("{name}.db");
        let arguments = ["trial", "--plan", "plan.toml", "--json", "--record", name];
        json(&run_in(folder, &[&arguments[..], &["--logbook", &logbook]].concat()))
    };
    let trial = record("run.csv");
    let stage = &trial["runs"][0]["stages"][1];
    assert_eq!(stage["stage"], "train");
    let (from, to) = (stage["from_s"].to_string(), stage["to_s"].to_string());
    let identify = |name: &str| {
        // How the model validates is not the subject.
        let unvalidated = ["--json", "--accept-unvalidated"];
        let windows = ["--from", &from, "--to", &to];
        let arguments = [&["identify", name][..], &unvalidated, &windows].concat();
        json(&run_in(folder, &arguments))
    };
    let model = identify("run.csv")["refined"].clone();
    assert!(model["a22_per_s"].is_f64());
    for name in ["run.parquet", "run.mcap"] {
        record(name);
        let found = identify(name)["refined"].clone();
        for parameter in ["a22_per_s", "b2_per_s2", "c0_rad_per_s2"] {
            let number = |model: &Value| model[parameter].as_f64().unwrap();
            // Times of MCAP are rounded to the nanosecond, 1e-8 of a sample.
            let error = (number(&found) - number(&model)).abs();
            let most = if name == "run.mcap" { 1e-7 } else { 0.0 };
            assert!(error <= most, "{name}: {parameter} {error}");
        }
    }

    let csv = std::fs::read_to_string(folder.join("run.csv")).unwrap();
    let mut lines = csv.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let column = |name: &str| names.iter().position(|n| *n == name).unwrap();
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    let last_trained = rows
        .iter()
        .rfind(|row| {
            row[column("stage")] == "2" && row[0].parse::<f64>().ok() < stage["to_s"].as_f64()
        })
        .unwrap();
    // The online estimate of the first run is the last one of its training.
    let online = &trial["runs"][0]["identification"]["online"];
    let recorded: f64 = last_trained[column("estimate_a22_per_s")].parse().unwrap();
    assert_eq!(online["a22_per_s"].as_f64(), Some(recorded));
    let half_width: f64 = last_trained[column("half_width_a22_per_s")].parse().unwrap();
    assert!((0.0..0.5).contains(&half_width), "{half_width}");
}

#[test]
fn cli_a_killed_trial_leaves_a_recording() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for name in ["killed.csv", "killed.mcap"] {
        let mut trial = program()
            .args(["trial", "--realtime", "--logbook", "trial.db", "--record", name])
            .current_dir(folder)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let begun = Instant::now();
        // Three seconds of the vehicle's time take at least that.
        std::thread::sleep(Duration::from_secs(3));
        let length = || std::fs::metadata(folder.join(name)).map_or(0, |file| file.len());
        while length() < 8_000 {
            assert!(begun.elapsed() < Duration::from_secs(60));
            std::thread::sleep(Duration::from_millis(50));
        }
        trial.kill().unwrap();
        trial.wait().unwrap();
        let inspected = run_in(folder, &["inspect", name, "--json"]);
        let stderr = String::from_utf8_lossy(&inspected.stderr);
        assert_eq!(stderr.contains("cut off"), name == "killed.mcap", "{stderr}");
        let document: Value = serde_json::from_slice(&inspected.stdout).unwrap();
        let samples = document["source"]["samples_read"].as_u64();
        assert!(samples >= Some(35), "{document:#}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn cli_a_recording_that_cannot_be_saved_does_not_stop_the_trial() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("plan.toml"), PLAN).unwrap();
    for name in ["full.csv", "full.mcap"] {
        std::os::unix::fs::symlink("/dev/full", folder.join(name)).unwrap();
        let trial = run_in(folder, &["trial", "--plan", "plan.toml", "--record", name]);
        let stderr = String::from_utf8_lossy(&trial.stderr);
        let code = trial.status.code();
        assert!(code == Some(6) && stderr.contains("No space left"), "{stderr}");
        if name == "full.mcap" {
            // Only the recording is lost.
            assert!(String::from_utf8_lossy(&trial.stdout).contains("USE"));
        }
    }
    for (name, code) in [("run.txt", 2), ("nowhere/run.csv", 6)] {
        let trial = run_in(folder, &["trial", "--record", name]);
        assert_eq!(trial.status.code(), Some(code), "{name}");
    }
}

#[cfg(not(feature = "foxglove"))]
#[test]
fn cli_a_build_without_foxglove_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let trial = run_in(folder.path(), &["trial", "--foxglove"]);
    assert_eq!(trial.status.code(), Some(2));
    let stderr = String::from_utf8_lossy(&trial.stderr);
    assert!(stderr.contains("--features foxglove"), "{stderr}");
}

#[cfg(feature = "foxglove")]
#[test]
fn cli_foxglove_may_connect_to_a_trial() {
    use std::io::{BufRead, BufReader};

    let folder = tempfile::tempdir().unwrap();
    let start = |address: &str| {
        program()
            .args(["trial", "--realtime", "--foxglove", address])
            .current_dir(folder.path())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap()
    };
    let mut trial = start("0");
    let mut lines = BufReader::new(trial.stderr.take().unwrap()).lines();
    let line = lines.next().unwrap().unwrap();
    let (_, address) = line.split_once("ws://").unwrap();
    // Of this machine alone.
    assert!(address.starts_with("127.0.0.1:"), "{line}");
    std::net::TcpStream::connect(address).unwrap();
    let taken = start(address).wait_with_output().unwrap();
    assert_eq!(taken.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&taken.stderr).contains(address));
    trial.kill().unwrap();
    trial.wait().unwrap();
}
