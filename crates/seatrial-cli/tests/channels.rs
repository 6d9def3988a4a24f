//! `--channels FILE.toml`, and logs on standard input.

use std::f64::consts::PI;
use std::fs::File;
use std::path::Path;
use std::process::{Output, Stdio};

use seatrial_dev::{data, program};
use serde_json::Value;

fn seatrial(arguments: &[&str], folder: &Path, input: Option<&Path>) -> Output {
    let input = input.map_or(Stdio::null(), |path| File::open(path).unwrap().into());
    program().args(arguments).current_dir(folder).stdin(input).output().unwrap()
}

/// The paper's vehicle at 20 Hz: heading in degrees clockwise, two fins in degrees that turn against each other.
fn write_log(folder: &Path) {
    let (mut heading_rad, mut rate_rad_s) = (1.0, 0.0);
    let mut text = String::from("clock_ms,compass,upper,lower\n");
    for k in 0..600 {
        let rudder_rad: f64 = match k % 200 {
            60..90 => 0.2,
            90..120 => -0.2,
            _ => 0.0,
        };
        let fin_deg = -rudder_rad * 180.0 / PI;
        text += &format!(
            "{},{},{},{}\n",
            50 * k,
            360.0 - heading_rad * 180.0 / PI,
            fin_deg + 3.0,
            -fin_deg + 1.0
        );
        for _ in 0..50 {
            rate_rad_s += 0.001 * (-1.07 * rate_rad_s + 1.08 * rudder_rad);
            heading_rad += 0.001 * rate_rad_s;
        }
    }
    std::fs::write(folder.join("run.csv"), text).unwrap();
}

const MAPPING: &str = "[plan]\nanything = 1\n\n[channels]\ntime = { column = \"clock_ms\", unit = \"ms\" }\n\
    [channels.heading]\ncolumn = \"compass\"\nunit = \"deg\"\nreversed = true\n\
    [channels.rudder]\ncolumns = [\"upper\", \"lower\"]\nunit = \"deg\"\noffset = 1.0\nscale = -1.0\n";

fn b2_per_s2(output: &Output) -> f64 {
    let text = String::from_utf8_lossy(&output.stderr);
    let document: serde_json::Value =
        serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {text}"));
    document["online"]["b2_per_s2"].as_f64().unwrap()
}

/// `identify` of the log in a folder by its `channels.toml`.
fn identified(folder: &Path) -> Output {
    let arguments = ["identify", "run.csv", "--channels", "channels.toml", "--json"];
    seatrial(&arguments, folder, None)
}

#[test]
fn cli_channels_of_a_file_turn_scale_and_pair_columns() {
    let folder = tempfile::tempdir().unwrap();
    write_log(folder.path());
    std::fs::write(folder.path().join("channels.toml"), MAPPING).unwrap();
    let output = identified(folder.path());
    // Forward Euler at 1 kHz against the exact plant, and filters at 20 Hz: a few per mille.
    let b2 = b2_per_s2(&output);
    assert!((b2 - 1.08).abs() < 0.02 * 1.08, "{b2}");
    let said = String::from_utf8_lossy(&output.stderr);
    for expected in [
        "rudder from (upper - lower) / 2 [deg, less 1, times -1]",
        "heading from compass [deg, times -1]",
        "time from clock_ms [ms]",
    ] {
        assert!(said.contains(expected), "{said}");
    }

    let arguments = ["identify", "-", "--channels", "channels.toml", "--json"];
    let piped = seatrial(&arguments, folder.path(), Some(&folder.path().join("run.csv")));
    assert_eq!(b2_per_s2(&piped), b2);
}

/// Half the difference of two motors of which one counts the other way stands still: the motor is named, and a minus turns it.
#[test]
fn cli_a_mirrored_motor_is_named_with_what_turns_it() {
    let folder = tempfile::tempdir().unwrap();
    write_log(folder.path());
    let path = folder.path().join("run.csv");
    let text = std::fs::read_to_string(&path).unwrap();
    let mirrored = |line: &str| {
        let (others, lower) = line.rsplit_once(',').unwrap();
        match lower.parse::<f64>() {
            Ok(lower) => format!("{others},{}\n", -lower),
            Err(_) => format!("{line}\n"),
        }
    };
    std::fs::write(&path, text.lines().map(mirrored).collect::<String>()).unwrap();
    let identified_by = |mapping: &str| {
        std::fs::write(folder.path().join("channels.toml"), mapping).unwrap();
        identified(folder.path())
    };
    let refused: Value = serde_json::from_slice(&identified_by(MAPPING).stdout).unwrap();
    let cause = &refused["verdict"]["reasons"][0];
    assert_eq!(cause["code"], "constant", "{cause}");
    assert_eq!(cause["of"], "rudder", "{cause}");
    let said = |field: &str| cause[field].as_str().unwrap();
    assert!(said("text").contains("`lower` counts the other way"), "{cause}");
    assert!(said("action").contains("--rudder 'upper,-lower'"), "{cause}");

    let b2 = b2_per_s2(&identified_by(&MAPPING.replace("\"lower\"", "\"-lower\"")));
    assert!((b2 - 1.08).abs() < 0.02 * 1.08, "{b2}");
}

/// A heading that somebody chose and that is later than another is told so, and no rudder is accused.
#[test]
fn cli_a_late_heading_that_was_chosen_names_the_other() {
    let folder = tempfile::tempdir().unwrap();
    write_log(folder.path());
    let path = folder.path().join("run.csv");
    let text = std::fs::read_to_string(&path).unwrap();
    let compass = |line: &str| line.split(',').nth(1).unwrap().to_owned();
    let lines: Vec<&str> = text.lines().collect();
    let rows = lines.iter().enumerate().map(|(row, line)| match row {
        0 => format!("{line},heading_late\n"),
        _ => format!("{line},{}\n", compass(lines[row.saturating_sub(12).max(1)])),
    });
    std::fs::write(&path, rows.collect::<String>()).unwrap();
    let mapping = MAPPING.replace("\"compass\"", "\"heading_late\"");
    std::fs::write(folder.path().join("channels.toml"), mapping).unwrap();
    let output = identified(folder.path());
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("0.6 s later than `compass`"), "{said}");
    let document: Value = serde_json::from_slice(&output.stdout).unwrap();
    let reasons = document["verdict"]["reasons"].as_array().unwrap();
    let has = |code: &str| reasons.iter().any(|reason| reason["code"] == code);
    assert!(has("late") && !has("model_order"), "{reasons:?}");
}

#[test]
fn cli_errors_of_a_channels_file_name_file_line_and_field() {
    let folder = tempfile::tempdir().unwrap();
    write_log(folder.path());
    for (from, to, expected) in [
        ("\"compass\"", "\"bearing\"", "channels.toml line 6, channels.heading"),
        ("\"lower\"", "\"low\"", "channels.toml line 10, channels.rudder"),
        ("unit = \"ms\"", "unit = \"furlong\"", "`furlong` is no unit"),
        ("[channels.rudder]", "[channels.ruder]", "unknown variant `ruder`"),
        ("offset = 1.0", "offset = nan", "offset = NaN"),
        ("scale = -1.0", "scale = 0.0", "scale = 0"),
        ("scale = -1.0", "full_deg = 95.0", "full_deg = 95"),
        ("column = \"compass\"", "columns = [\"compass\", \"upper\"]", "is for rudder and thrust"),
        ("column = \"compass\"", "", "expected `column = "),
    ] {
        assert!(MAPPING.contains(from), "{from}");
        let text = MAPPING.replace(from, to);
        std::fs::write(folder.path().join("channels.toml"), text).unwrap();
        let arguments = ["inspect", "run.csv", "--channels", "channels.toml"];
        let output = seatrial(&arguments, folder.path(), None);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(3), "{to}: {said}");
        assert!(said.contains("channels.toml") && said.contains(expected), "{to}: {said}");
    }
}

/// A name with one letter wrong can mean one column only: it is taken, and said.
#[test]
fn cli_a_misspelt_column_is_taken_and_said() {
    let folder = tempfile::tempdir().unwrap();
    write_log(folder.path());
    let text = MAPPING.replace("\"compass\"", "\"compas\"");
    std::fs::write(folder.path().join("channels.toml"), text).unwrap();
    let arguments = ["inspect", "run.csv", "--channels", "channels.toml"];
    let output = seatrial(&arguments, folder.path(), None);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_ne!(output.status.code(), Some(3), "{said}");
    assert!(said.contains("no such column; `compass` is taken"), "{said}");
}

/// Binary formats are read twice.
#[test]
fn cli_binary_logs_come_on_standard_input_too() {
    let Some(log) = data("native/ardupilot/ardusub_small.BIN") else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let log_name = log.to_str().unwrap();
    let named = seatrial(&["inspect", log_name, "--json"], folder.path(), None);
    let piped = seatrial(&["inspect", "-", "--json"], folder.path(), Some(&log));
    assert_eq!(named.status.code(), piped.status.code());
    let found = |output: &Output| -> Value { serde_json::from_slice(&output.stdout).unwrap() };
    let (named, piped) = (found(&named), found(&piped));
    for part in ["sampling", "ranges", "manoeuvres", "verdict"] {
        assert!(!piped[part].is_null(), "{part}: {piped}");
        assert_eq!(named[part], piped[part], "{part}");
    }

    let bag = folder.path().join("bag");
    std::fs::write(&bag, b"SQLite format 3\0").unwrap();
    let refused = seatrial(&["inspect", "-"], folder.path(), Some(&bag));
    let said = String::from_utf8_lossy(&refused.stderr);
    assert_eq!(refused.status.code(), Some(3));
    assert!(said.contains("rosbag2 file in which nothing can be read"), "{said}");
}

/// Heading and rudder in degrees of a vehicle with a time constant of 2 s at 10 Hz, with what a function makes of the heading of a row
/// and of the rudder.
fn write_columns(path: &Path, names: &str, of: impl Fn(usize, &[f64], f64) -> [f64; 2]) {
    let (mut heading_deg, mut rate_deg_s) = (45.0_f64, 0.0);
    let (mut headings, mut rudders) = (Vec::new(), Vec::new());
    for k in 0..900_u32 {
        let rudder_deg = match k % 200 {
            50..110 => 12.0,
            110..170 => -12.0,
            _ => 0.0,
        };
        // Noise of a compass, 0.1 deg.
        let noise_deg =
            0.14 * f64::from(k.wrapping_mul(2_654_435_761) >> 16 & 0x3ff) / 512.0 - 0.14;
        headings.push((100.0 * (heading_deg + noise_deg)).round() / 100.0);
        rudders.push(rudder_deg);
        for _ in 0..10 {
            rate_deg_s += 0.01 * (0.6 * rudder_deg - rate_deg_s) / 2.0;
            heading_deg += 0.01 * rate_deg_s;
        }
    }
    let mut text = format!("time_s,{names}\n");
    for (k, rudder_deg) in rudders.into_iter().enumerate() {
        let [heading_deg, rudder] = of(k, &headings, rudder_deg);
        text += &format!("{:.1},{heading_deg},{rudder}\n", 0.1 * k as f64);
    }
    std::fs::write(path, text).unwrap();
}

/// Validation data whose rudder has another sign or unit than that of the training are told so: nothing is wrong with rudder or compass.
#[test]
fn cli_validation_data_of_another_sign_or_unit_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    let degrees = "heading_deg,rudder_deg";
    write_columns(&file("run.csv"), degrees, |k, heading, rudder| [heading[k], rudder]);
    write_columns(&file("reversed.csv"), degrees, |k, heading, rudder| [heading[k], -rudder]);
    write_columns(&file("percent.csv"), "heading_deg,rudder_percent", |k, heading, rudder| {
        [heading[k], rudder / 0.35]
    });
    let validated = |on: &str| {
        let output = seatrial(&["identify", "run.csv", "--validate-on", on], folder.path(), None);
        let said = [output.stdout, output.stderr].concat();
        String::from_utf8_lossy(&said).into_owned()
    };
    let said = validated("reversed.csv");
    assert!(said.contains("counts to the") && said.contains("reversed = true"), "{said}");
    assert!(!said.contains("compass did not"), "{said}");
    let said = validated("percent.csv");
    assert!(said.contains("percent.csv: one rudder is an angle"), "{said}");
}

/// A rudder in radians by the name of degrees moved, and a heading that is new once a second is why it does not follow the rudder.
#[test]
fn cli_the_first_cause_is_the_column_that_is_wrong() {
    let folder = tempfile::tempdir().unwrap();
    let cause = |of: fn(usize, &[f64], f64) -> [f64; 2]| {
        write_columns(&folder.path().join("run.csv"), "heading_deg,rudder_deg", of);
        let output = seatrial(&["identify", "run.csv", "--json"], folder.path(), None);
        let document: Value = serde_json::from_slice(&output.stdout).unwrap();
        let reason = &document["verdict"]["reasons"][0];
        [reason["code"].clone(), reason["of"].clone()]
    };
    let radians = cause(|k, heading, rudder| [heading[k], rudder.to_radians()]);
    assert_eq!(radians, ["unit_doubtful", "rudder"]);
    let held = cause(|k, heading, rudder| [heading[k / 10 * 10], rudder]);
    assert_eq!(held, ["sampled_too_seldom", "heading"]);
}
