//! `identify` and `inspect` on logs with several manoeuvres, without windows.

use std::path::Path;

use seatrial_app::documents::IdentificationDocument;
use seatrial_app::{Options, identify_log};
use seatrial_dev::{data, document, run, unwrapped};

/// ArduPilot's Rover firmware on a simulated boat, if the shared data are here.
fn rover_log() -> Option<String> {
    let log = data("native/ardupilot/rover_json_physics.tlog")?;
    Some(log.to_str().unwrap().to_string())
}

/// Known a22 and b2 at two throttles, 1680 and 1830 us, behind a rudder lag of 0.15 s that the log does not tell; full
/// rudder is 35 deg, which the log does not tell either. The tolerance of 10 % is the requirement's.
#[test]
fn val_ardupilot_rover_without_any_option() {
    let Some(log) = rover_log() else { return };
    let output = run(&["identify", &log, "--json", "--verbose"]);
    assert_eq!(output.status.code(), Some(0));
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(stderr.contains("the doublet at 87.6 s"), "{stderr}");
    let document = document(&output);
    assert_eq!(document["source"]["rudder_unit"], "full_rudder");
    let models = document["models"].as_array().unwrap();
    assert_eq!(models.len(), 3);
    let full_rudder_rad = 35_f64.to_radians();
    for (model, speed_m_s, a22, b2) in [
        (&models[1], 3.8, -0.91, 1.75 * full_rudder_rad),
        (&models[2], 5.55, -1.26, 3.71 * full_rudder_rad),
    ] {
        assert_eq!(model["verdict"]["accepted"], true, "{model:#}");
        let found = |field: &str| model["identification"]["refined"][field].as_f64().unwrap();
        assert!((found("a22_per_s") / a22 - 1.0).abs() < 0.1, "{model:#}");
        assert!((found("b2_per_s2") / b2 - 1.0).abs() < 0.1, "{model:#}");
        // The speed falls by a tenth while the rudder works.
        let speed = model["surge_speed_m_s"].as_f64().unwrap();
        assert!((speed / speed_m_s - 1.0).abs() < 0.1, "{speed}");
    }
}

#[test]
fn val_ardupilot_rover_makes_a_schedule_and_an_inspection() {
    let Some(log) = rover_log() else { return };
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let schedule = path("schedule.toml");
    let output = run(&["identify", &log, "--schedule", &schedule]);
    assert_eq!(output.status.code(), Some(0));
    let gains = run(&["gains", "--schedule", &schedule, "--json"]);
    assert_eq!(gains.status.code(), Some(0), "{gains:?}");
    // The boat still gathers speed at the slowest throttle: 2.11 m/s in the doublet to train on, 1.61 m/s in the one to
    // validate on, where the rudder has 0.6 of the effect.
    assert_eq!(document(&gains)["points"].as_array().map(Vec::len), Some(2));
    for verb in ["gains", "turn"] {
        let page = run(&[verb, "--schedule", &schedule]);
        let page = unwrapped(&String::from_utf8_lossy(&page.stdout));
        assert!(page.contains("rudder limit 100.0 % of full"), "{page}");
    }

    let identified = run(&["identify", &log, "--json"]);
    let models = path("models.json");
    std::fs::write(&models, &identified.stdout).unwrap();
    let verdict = document(&identified)["models"][0]["verdict"].clone();
    assert_eq!(verdict["accepted"], false, "{verdict:#}");
    assert_eq!(verdict["reasons"][0]["code"], "drifted", "{verdict:#}");
    let text = verdict["reasons"][0]["detail"].as_str().unwrap_or_default();
    assert!(text.contains("1.62 m/s there and 2.11 m/s in"), "{text}");
    let same = run(&["gains", "--model", &models, "--json"]);
    assert_eq!(document(&same)["points"].as_array().map(Vec::len), Some(2));
    let stderr = String::from_utf8_lossy(&same.stderr);
    assert!(stderr.contains("10 % thrust has no accepted run"), "{stderr}");
    assert_eq!(same.status.code(), Some(0));

    let page = path("found.html");
    let inspected = run(&["inspect", &log, "--json", "--report", &page]);
    let html = std::fs::read_to_string(&page).unwrap();
    assert!(html.contains("class=\"span-train\"") && html.contains("Rudder, % of full"));
    let found = &document(&inspected)["manoeuvres"];
    let doublets = found.as_array().unwrap();
    let doublets = doublets.iter().filter(|m| m["kind"] == "doublet").count();
    assert_eq!(doublets, 6);
    let page = run(&["inspect", &log]);
    let page = String::from_utf8_lossy(&page.stdout).into_owned();
    assert!(page.contains("% of full"), "{page}");
    assert!(page.contains("identify takes"), "{page}");
}

/// `compare` and `report` look at the manoeuvres that `identify` would take.
#[test]
fn cli_every_verb_chooses_the_same_windows() {
    let Some(log) = rover_log() else { return };
    let training = |verb: &str| {
        let document = document(&run(&[verb, &log, "--json"]));
        assert!(document["training"]["from_s"].is_number(), "{document:#}");
        document["training"].clone()
    };
    assert_eq!(training("compare"), training("identify"));
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("report.html");
    let output = run(&["report", &log, "--out", page.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let html = std::fs::read_to_string(&page).unwrap();
    // Each speed has a line of its own. At the first the validation data contradict the model.
    for (cell, rows) in [(">✕ do not use<", 1), (">! use with care<", 2)] {
        assert_eq!(html.matches(cell).count(), rows, "{cell} {html}");
    }
}

/// Explicit windows win, and a log that is one manoeuvre is used as a whole.
#[test]
fn cli_windows_of_the_user_win() {
    let Some(log) = rover_log() else { return };
    let output = run(&["identify", &log, "--from", "86.6", "--to", "97", "--json"]);
    let document = document(&output);
    assert!(document["models"].is_null());
    assert_eq!(document["training"]["from_s"], 86.6);
}

/// The library gives what the terminal prints, byte for byte, and reads it back.
#[test]
fn cli_identify_prints_the_document_of_identify_log() {
    let folder = tempfile::tempdir().unwrap();
    let simulated = folder.path().join("run.csv").to_str().unwrap().to_string();
    assert!(run(&["sim", "log", "--seed", "1", "--out", &simulated]).status.success());
    for log in [Some(simulated), rover_log()].into_iter().flatten() {
        let printed = run(&["identify", &log, "--json"]).stdout;
        let found = identify_log(Path::new(&log), &Options::default()).unwrap();
        let text = serde_json::to_string_pretty(&found.document()).unwrap();
        assert_eq!(String::from_utf8(printed).unwrap().trim_end(), text);
        let read: IdentificationDocument = serde_json::from_str(&text).unwrap();
        assert_eq!(serde_json::to_string_pretty(&read).unwrap(), text);
        let described = read.source.source.description();
        assert_eq!(described.rudder_unit, found.logs.log.rudder_unit());
    }
}
