//! `compare` of several logs: damping over the turn rate.

use std::fmt::Write;
use std::path::Path;

use seatrial_dev::{data, run_to_text, unwrapped};
use serde_json::Value;

/// Four doublets of this rudder at 10 Hz, of a hull whose damping grows with its yaw rate, with 0.2 deg of noise in the heading.
fn write_log(folder: &Path, name: &str, rudder_deg: f64, speed_m_s: f64, seed: u64) {
    let mut state = seed;
    let mut uniform = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let mut text = "time_s,heading_deg,rudder_deg,speed_m_s\n".to_owned();
    let (mut heading_rad, mut rate) = (0.0_f64, 0.0_f64);
    for k in 0..1200_u32 {
        let rudder = match k % 300 {
            60..120 => rudder_deg,
            120..180 => -rudder_deg,
            _ => 0.0,
        };
        // The sum of twelve has a variance of 1.
        let noise: f64 = (0..12).map(|_| uniform()).sum();
        let heading_deg = heading_rad.to_degrees() + 0.2 * noise;
        let time_s = 0.1 * f64::from(k);
        writeln!(text, "{time_s:.1},{heading_deg:.3},{rudder:.2},{speed_m_s}").unwrap();
        for _ in 0..20 {
            let slope = |r: f64| -0.5 * r - 3.0 * r.abs() * r + 0.5 * rudder.to_radians();
            let middle = rate + 0.0025 * slope(rate);
            heading_rad += 0.005 * middle;
            rate += 0.005 * slope(middle);
        }
    }
    std::fs::write(folder.join(name), text).unwrap();
}

fn compare(folder: &Path, arguments: &[&str]) -> (i32, String, String) {
    run_to_text(folder, &[&["compare"], arguments].concat())
}

fn document(folder: &Path, arguments: &[&str]) -> Value {
    let (exit, said, error) = compare(folder, &[&["--json"], arguments].concat());
    assert_eq!(exit, 0, "{error}");
    serde_json::from_str(&said).unwrap()
}

#[test]
fn cli_damping_that_grows_with_the_turn_rate_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_log(folder, "gentle.csv", 4.0, 1.2, 1);
    write_log(folder, "hard.csv", 25.0, 1.2, 2);
    let (exit, said, error) = compare(folder, &["gentle.csv", "hard.csv"]);
    assert_eq!(exit, 0, "{said}{error}");
    println!("{said}");
    let sentences = unwrapped(&said);
    for expected in [
        "Damping grows with the turn rate: a22 is -0.",
        "Use the model of the turn rate that you steer with.",
        "gentle.csv: use",
        "hard.csv: use",
        "chi-square",
    ] {
        assert!(sentences.contains(expected), "{expected}: {said}");
    }
    assert!(said.lines().all(|line| line.chars().count() <= 80), "{said}");
    let document = document(folder, &["gentle.csv", "hard.csv"]);
    let fit = &document["speeds"][0]["over_amplitude"];
    assert_eq!(fit["finding"], "grows");
    assert_eq!(fit["degrees_of_freedom"], 1);
    let bound = |index: usize| fit["quadratic_per_rad"]["interval_95"][index].as_f64().unwrap();
    assert!(bound(0) < -3.0 && -3.0 < bound(1) && bound(1) < 0.0, "{fit:#}");
}

#[test]
fn cli_records_of_one_turn_rate_agree() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_log(folder, "first.csv", 15.0, 1.2, 3);
    write_log(folder, "second.csv", 15.0, 1.2, 4);
    let (exit, said, error) = compare(folder, &["first.csv", "second.csv"]);
    assert_eq!(exit, 0, "{said}{error}");
    assert!(said.starts_with("The records agree"), "{said}");
    // At another speed they are not compared.
    write_log(folder, "faster.csv", 15.0, 1.8, 5);
    let (exit, said, _) = compare(folder, &["first.csv", "faster.csv"]);
    assert_eq!(exit, 4, "{said}");
    let sentences = unwrapped(&said);
    for expected in ["The speeds differ by more than 10 %", "two are needed"] {
        assert!(sentences.contains(expected), "{expected}: {said}");
    }
    // Windows are for one log.
    let (exit, _, error) = compare(folder, &["first.csv", "second.csv", "--from", "3"]);
    assert_eq!(exit, 2);
    assert!(error.contains("for one log"), "{error}");
}

/// The tanker's zig-zags begin at one speed, whatever the turns cost.
#[test]
fn cli_the_tankers_zig_zags_are_of_one_speed() {
    let Some(real) = data("real") else {
        return;
    };
    let logs = ["05_01", "15_01", "20_10_P", "25_05", "30_05"];
    let logs = logs.map(|name| format!("kvlcc2hsva_Z_{name}.csv"));
    let found = document(&real, &logs.each_ref().map(String::as_str));
    let speeds = found["speeds"].as_array().unwrap();
    assert_eq!(speeds.len(), 1, "{found:#}");
    assert_eq!(speeds[0]["over_amplitude"]["finding"], "grows");
}
