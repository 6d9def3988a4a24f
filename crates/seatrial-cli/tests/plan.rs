//! `seatrial plan` at the process boundary.

use std::path::Path;

use seatrial_dev::{document, run_in, run_to_text, unwrapped};
use serde_json::Value;
use tempfile::TempDir;

/// `plan --json` with these arguments and its exit code.
fn plan(folder: &Path, arguments: &[&str]) -> (Value, Option<i32>) {
    let output = run_in(folder, &[&["plan", "--json"], arguments].concat());
    (document(&output), output.status.code())
}

fn folder() -> TempDir {
    tempfile::tempdir().unwrap()
}

fn number(document: &Value, pointer: &str) -> f64 {
    let value = document.pointer(pointer).and_then(Value::as_f64);
    value.unwrap_or_else(|| panic!("{pointer}: {document:#}"))
}

#[test]
fn cli_the_papers_plan_is_previewed_on_the_starfish() {
    let folder = folder();
    let (document, code) = plan(folder.path(), &[]);
    assert_eq!(code, Some(0));
    assert_eq!(document["schema"], "seatrial.plan.v1");
    assert_eq!(document["preview"]["vehicle"], "sim:starfish");
    assert_eq!(document["preview"]["outcome"]["state"], "finished");
    assert_eq!(document["comparison"], Value::Null);
    assert_eq!(document["recommendation"], Value::Null);
    // Five speeds of 12 s, 16.5 s and 16.5 s.
    assert!((number(&document, "/preview/duration_s") - 225.0).abs() < 1e-6);
    let expected = "/preview/speeds/2/expected";
    // By dense linear algebra in another language, to the three digits kept of it.
    for (index, width) in [(0, 0.0352), (1, 0.0261)] {
        let found = number(&document, &format!("{expected}/relative_half_width_95/{index}"));
        assert!((found - width).abs() < 5e-4, "{found}");
    }
    let radius = number(&document, &format!("{expected}/steady_turning_radius_m/0/value"));
    // 1.63 m/s at b2 0.26 + C0 over -a22.
    assert!((radius - 1.63 * 1.07 / (1.08 * 0.26 + 0.012)).abs() < 1e-9);
}

#[test]
fn cli_noise_widens_the_intervals_in_proportion() {
    let folder = folder();
    let width = |noise: &str| {
        let still = ["--disturbance", "0,1", "--noise-deg", noise];
        let (document, _) = plan(folder.path(), &still);
        number(&document, "/preview/speeds/0/expected/half_width_95/1")
    };
    // Rounding.
    assert!((width("1") / width("0.5") - 2.0).abs() < 1e-6);
}

#[test]
fn cli_the_recommended_doublet_is_written_and_tried() {
    let folder = folder();
    let wanted = ["--thrust", "0.8", "--target", "a22:10%,b2:5%"];
    let adopt = ["--adopt", "recommended", "--out", "plan.toml"];
    let (document, code) = plan(folder.path(), &[&wanted[..], &adopt].concat());
    assert_eq!(code, Some(0));
    let amplitude_rad = number(&document, "/recommendation/doublets/0/amplitude_rad");
    let adopted = "/plan/training/excitation/doublet/amplitude_rad";
    assert_eq!(amplitude_rad, number(&document, adopted));
    assert!(amplitude_rad < 0.26);
    let trial = ["trial", "--json", "--plan", "plan.toml", "--seed", "3"];
    let output = run_in(folder.path(), &trial);
    assert_eq!(output.status.code(), Some(0));
    let document: Value = serde_json::from_slice(&output.stdout).unwrap();
    let refined = "/runs/0/identification/refined";
    let interval =
        |end: usize| number(&document, &format!("{refined}/interval_95/b2_per_s2/{end}"));
    let half_width = 0.5 * (interval(1) - interval(0));
    assert!(half_width / number(&document, &format!("{refined}/b2_per_s2")) < 0.05);
}

#[test]
fn cli_a_designed_manoeuvre_is_compared_written_and_tried() {
    let folder = folder();
    let arguments = ["--thrust", "0.8", "--adopt", "designed-calm", "--out", "plan.toml"];
    let (document, code) = plan(folder.path(), &arguments);
    assert_eq!(code, Some(0));
    let names: Vec<&Value> = document["comparison"]["designs"]
        .as_array()
        .unwrap()
        .iter()
        .map(|design| &design["name"])
        .collect();
    assert_eq!(names, ["doublet", "3-2-1-1", "designed", "designed_calm"]);
    assert_eq!(
        document["plan"]["training"]["excitation"],
        document["comparison"]["designs"][3]["excitation"]
    );
    let output = run_in(folder.path(), &["trial", "--json", "--plan", "plan.toml"]);
    assert_eq!(output.status.code(), Some(0));
}

#[test]
fn cli_what_an_earlier_trial_found_is_the_prior() {
    let folder = folder();
    let trial = run_in(folder.path(), &["trial", "--json", "--logbook", "a.db"]);
    std::fs::write(folder.path().join("trial.json"), &trial.stdout).unwrap();
    let document: Value = serde_json::from_slice(&trial.stdout).unwrap();
    for source in [["--logbook", "a.db"], ["--model", "trial.json"]] {
        let (preview, code) = plan(folder.path(), &source);
        assert_eq!(code, Some(0));
        let speed = &preview["preview"]["speeds"][2];
        let refined = &document["runs"][2]["identification"]["refined"];
        assert_eq!(speed["b2_per_s2"], refined["b2_per_s2"]);
        assert_eq!(speed["noise"]["heading_rad"], refined["heading_noise_rad"]);
        assert_eq!(speed["noise"]["disturbance_rad_s2"], refined["disturbance_rad_s2"]);
    }
}

#[test]
fn cli_what_cannot_be_had_is_exit_4_and_said() {
    let folder = folder();
    for (arguments, said) in [
        (&["--target", "a22:1%"][..], "NOT REACHABLE within the rudder limit"),
        (&["--amplitude-deg", "0.3"], "TOO LITTLE to accept a model at 60 %, 70 %"),
        (
            &["--a22", "0.5", "--b2", "1", "--hold-gain", "2"],
            "ABORTED after 17 s: yaw rate outside the envelope",
        ),
        (
            &["--target", "a22:1%", "--adopt", "recommended"],
            "--adopt recommended: no doublet within the rudder limit",
        ),
    ] {
        let output = run_in(folder.path(), &[&["plan"], arguments].concat());
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(4), "{arguments:?}: {message}");
        assert!(unwrapped(&message).contains(said), "{arguments:?}: {message}");
    }
}

#[test]
fn cli_a_vehicle_file_that_cannot_be_read_is_exit_3() {
    let folder = folder();
    let output = run_in(folder.path(), &["plan", "--vehicle", "sim:missing.toml"]);
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(3), "{message}");
    assert!(message.contains("missing.toml"), "{message}");
}

#[test]
fn cli_bad_options_are_exit_2_and_named() {
    let folder = folder();
    for (arguments, said) in [
        (&["--target", "c0:5%"][..], "as in a22:10%,b2:5%"),
        (&["--target", "a22:10"], "as in a22:10%,b2:5%"),
        (&["--noise-deg", "-1"], "expected a positive number"),
        (&["--disturbance", "0.1"], "as in 0.005,2"),
        (&["--disturbance", "-1,2"], "as in 0.005,2"),
        (&["--adopt", "recommended"], "as in --target a22:10%,b2:5%"),
        (&["--a22", "0.5", "--b2", "1"], "--hold-gain"),
        (&["--hold-gain", "NaN"], "--hold-gain"),
        (&["--heading-deg", "inf"], "--heading-deg"),
        (&["--vehicle", "sim:nope"], "sim:nope"),
        (&["--vehicle", "sim:starfish", "--a22", "-1", "--b2", "1"], "--vehicle"),
        (&["--amplitude-deg", "40"], "training.excitation"),
        (&["--rudder-limit-deg", "0"], "rudder_limit_rad"),
        (&["--campaign", "1"], "--logbook"),
    ] {
        let output = run_in(folder.path(), &[&["plan"], arguments].concat());
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
        assert!(output.stdout.is_empty());
        assert!(message.contains(said), "{arguments:?}: {message}");
    }
}

/// The surge of a trial of this plan, and its exit code.
fn surge_of_trial(folder: &Path, plan: &str, logbook: &str) -> (Value, Option<i32>) {
    let vehicle = ["trial", "--vehicle", "sim:remus100", "--seed", "1", "--yes"];
    let options = ["--plan", plan, "--logbook", logbook];
    let trial = run_in(folder, &[&vehicle[..], &options].concat());
    assert_eq!(trial.status.code(), Some(0));
    let output = run_in(folder, &["surge", "--json", "--logbook", logbook]);
    (document(&output), output.status.code())
}

/// A plan of one thrust tells no lag, and so small a step no drag length; with the run that is added the trial tells both.
#[test]
fn cli_the_step_that_is_added_makes_the_surge_identifiable() {
    let folder = folder();
    let folder = folder.path();
    for (name, thrusts) in
        [("one", &["--thrust", "0.6"][..]), ("near", &["--thrust", "0.6", "--thrust", "0.62"])]
    {
        let common = [&["--vehicle", "sim:remus100"][..], thrusts].concat();
        let file = |kind: &str| format!("{name}-{kind}.toml");
        let (_, code) = plan(folder, &[&common[..], &["--out", &file("plain")]].concat());
        assert_eq!(code, Some(0));
        let (without, _) = surge_of_trial(folder, &file("plain"), &format!("{name}-plain.db"));
        let are_known = |surge: &Value| {
            ["drag_length_m", "thrust_lag_s"].map(|key| surge[key]["value"].is_number())
        };
        assert_eq!(are_known(&without), [false, false], "{without:#}");
        let (found, code) =
            plan(folder, &[&common[..], &["--surge", "--out", &file("step")]].concat());
        assert_eq!(code, Some(0), "{found:#}");
        let added = &found["surge"]["added"];
        let thrusts = found["plan"]["thrusts"].as_array().unwrap();
        assert!(thrusts.contains(&added["thrust"]), "{found:#}");
        // Three stages of a plan of one more run: 12 to 40 s of settling and two of 16.5 s.
        let cost_s = added["cost_s"].as_f64().unwrap();
        assert!((45.0..=73.0).contains(&cost_s), "{cost_s}");
        let (with, code) = surge_of_trial(folder, &file("step"), &format!("{name}-step.db"));
        assert_eq!((are_known(&with), code), ([true, true], Some(0)), "{with:#}");
        // What was expected of the interval is what the trial finds, up to the noise of its own estimate and the drag length believed in.
        let [low, high] = [0, 1].map(|k| with["drag_length_m"]["interval_95"][k].as_f64().unwrap());
        let expected = added["with"]["drag_length_factor_95"].as_f64().unwrap();
        let factor = (high / low).sqrt();
        assert!(factor < expected * 1.05, "{factor} {expected}");
    }
}

#[test]
fn cli_a_plan_that_tells_the_surge_stays_as_it_is() {
    let folder = folder();
    for vehicle in ["sim:remus100", "sim:starfish-6dof"] {
        let (plain, _) = plan(folder.path(), &["--vehicle", vehicle]);
        let (found, code) = plan(folder.path(), &["--vehicle", vehicle, "--surge"]);
        assert_eq!(code, Some(0));
        assert_eq!(found["surge"]["added"], Value::Null);
        assert_eq!(found["plan"], plain["plan"]);
        assert_eq!(plain["surge"], Value::Null);
    }
    let output = run_in(folder.path(), &["plan", "--vehicle", "sim:remus100", "--surge"]);
    let said = unwrapped(&String::from_utf8(output.stderr).unwrap());
    assert!(said.contains("nothing is added"), "{said}");
}

#[test]
fn cli_a_surge_that_no_step_tells_is_exit_4_and_one_without_speed_exit_2() {
    let folder = folder();
    let models = ["plan", "--a22", "-1.07", "--b2", "1.08", "--thrust", "0.8", "--surge"];
    for (arguments, code, said) in [
        (&["--speed", "1.6", "--speed-noise", "3"][..], 4, "NOT IDENTIFIABLE"),
        (&["--speed", "1.6"], 0, "which costs"),
        (&[], 2, "the models have no speed"),
        (&["--speed", "1.6", "--speed-noise", "-1"], 2, "expected a positive number"),
    ] {
        let output = run_in(folder.path(), &[&models[..], arguments].concat());
        let message = unwrapped(&String::from_utf8(output.stderr).unwrap());
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {message}");
        assert!(message.contains(said), "{arguments:?}: {message}");
    }
}

/// A ship of 30 s is rehearsed at one speed, on a simulated vehicle that is as slow.
#[test]
fn cli_a_slow_ship_is_planned_and_rehearsed() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let long = ["plan", "--time-constant", "30", "--out", "long.toml"];
    let (exit, said, _) = run_to_text(folder, &long);
    assert_eq!(exit, 0, "{said}");
    let said = unwrapped(&said);
    for part in [
        "LONG: begin with one speed",
        "--thrust 0.8",
        "Written long.toml",
        "seatrial trial --plan long.toml",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    let one = ["plan", "--time-constant", "30", "--thrust", "0.8", "--out", "slow.toml"];
    let (exit, said, _) = run_to_text(folder, &one);
    assert_eq!(exit, 0, "{said}");
    assert!(!said.contains("LONG"), "{said}");
    let (exit, said, errors) = run_to_text(folder, &["trial", "--plan", "slow.toml", "--json"]);
    assert_eq!(exit, 0, "{said}{errors}");
    let trial: serde_json::Value = serde_json::from_str(&said).unwrap();
    assert_eq!(trial["vehicle"], "sim:slow:30");
    let t_s = trial["runs"][0]["identification"]["nomoto"]["t_s"].as_f64().unwrap();
    // The paper's vehicle has 0.935 s at that speed where its plan is for 0.93 s.
    assert!((t_s / 30.0 - 1.0).abs() < 0.15, "{t_s}");
    let (exit, _, errors) = run_to_text(folder, &["trial", "--vehicle", "sim:slow:never"]);
    assert_eq!(exit, 2, "{errors}");
    assert!(errors.contains("from 0.1 to 1000 s"), "{errors}");
}
