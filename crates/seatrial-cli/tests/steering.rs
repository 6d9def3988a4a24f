//! `turn`, `gains` and `paper` at the process boundary.

use std::path::Path;

use seatrial_dev::{document, run, run_in, text};
use serde_json::Value;

fn json(arguments: &[&str]) -> (Value, Option<i32>) {
    let output = run(&[arguments, &["--json"]].concat());
    (document(&output), output.status.code())
}

fn number(document: &Value, pointer: &str) -> f64 {
    let found = document.pointer(pointer).and_then(Value::as_f64);
    found.unwrap_or_else(|| panic!("no number at {pointer} in {document:#}"))
}

fn write(directory: &Path, name: &str, content: &str) -> String {
    let path = directory.join(name);
    std::fs::write(&path, content).expect("the file is written");
    path.to_str().expect("UTF-8").to_string()
}

/// The two ends of Table V.
const SCHEDULE: &str = "
[[point]]
thrust = 1.0
surge_speed_m_s = 2.13
a22_per_s = -1.48
b2_per_s2 = 2.02
c0_rad_per_s2 = 0.0312

[[point]]
thrust = 0.6
surge_speed_m_s = 1.05
a22_per_s = -1.28
b2_per_s2 = 0.65
c0_rad_per_s2 = 0.0129
";

const IDENTIFICATION: &str = r#"{"schema":"seatrial.identification.v1",
 "online":{"a22_per_s":-9,"b2_per_s2":9,"c0_rad_per_s2":9},
 "refined":{"a22_per_s":-1.07,"b2_per_s2":1.08,"c0_rad_per_s2":0.012,
  "interval_95":{"a22_per_s":[-1.1,-1.04],"b2_per_s2":[1.04,1.12],"c0_rad_per_s2":[0.01,0.014]}},
 "verdict":{"accepted":true,"reasons":[]}}"#;

/// Table IV with the delta0 that its row needs, and the example of the help text.
#[test]
fn cli_turn_is_table_iv_to_port() {
    let model = ["--a22", "-1.62", "--b2", "1.25", "--c0", "0.045", "--speed", "1.4"];
    let (document, code) = json(&[&["turn"], &model[..]].concat());
    assert_eq!(code, Some(0));
    assert_eq!(document["schema"], "seatrial.turn.v1");
    let port = "/points/0/hands/1";
    assert_eq!(document.pointer(port).unwrap()["hand"], "port");
    for (field, printed) in [
        ("u_turn_time_s", 20.65),
        ("u_turn_mean_radius_m", 9.20),
        ("steady_turning_radius_m", 8.10),
    ] {
        // Half a unit of the last digit printed.
        let found = number(&document, &format!("{port}/{field}/value"));
        assert!((found - printed).abs() < 0.005, "{field}: {found}");
    }
    let output = run(&[&["turn"], &model[..], &["--heading-change-deg", "90"]].concat());
    let table = text(&output.stdout);
    assert!(table.contains("Nomoto") && table.contains("starboard") && table.contains("9.20"));
}

/// No gain steers every vehicle that explains the log of the slower speed.
#[test]
fn cli_a_schedule_file_carries_that_a_model_has_no_gain() {
    let directory = tempfile::tempdir().unwrap();
    let may_be_unstable = format!("{SCHEDULE}may_be_unstable = true\n");
    let path = write(directory.path(), "schedule.toml", &may_be_unstable);
    let (document, _) = json(&["gains", "--schedule", &path]);
    let gain = |point: usize| document.pointer(&format!("/points/{point}/proportional_gain"));
    assert_eq!(gain(0), Some(&serde_json::Value::Null), "{document:#}");
    assert!(gain(1).is_some_and(|gain| gain["value"].is_number()));
}

/// An interval that leaves no damping gives no gain, and one that is none is a bad file.
#[test]
fn cli_an_interval_of_damping_never_makes_a_gain_larger() {
    let directory = tempfile::tempdir().unwrap();
    let with = |interval: &str| {
        let schedule = format!("{SCHEDULE}a22_interval_95_per_s = {interval}\n");
        let path = write(directory.path(), "schedule.toml", &schedule);
        run(&["gains", "--schedule", &path, "--json"])
    };
    for interval in ["[-1.9, 0.1]", "[-1.9, 0.0]", "[-1.9, -0.0001]"] {
        let document = document(&with(interval));
        let gain = document.pointer("/points/0/proportional_gain");
        assert_eq!(gain, Some(&Value::Null), "{interval}: {document:#}");
    }
    let sure = document(&with("[-1.3, -1.2]"));
    assert!(number(&sure, "/points/0/proportional_gain/value") > 0.0);
    for interval in ["[-0.1, -1.9]", "[-1.2, -1.1]", "[-1.9, -1.4]", "[-1.9, nan]"] {
        let refused = with(interval);
        let told = text(&refused.stderr);
        assert_eq!(refused.status.code(), Some(2), "{interval}: {told}");
        assert!(told.contains("point 2") && told.contains("interval of a22_per_s"), "{told}");
    }
}

/// What is no interval is refused in a document as in a schedule, by whatever takes a model from it.
#[test]
fn cli_a_document_whose_interval_does_not_hold_its_value_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("l.csv").display().to_string();
    run(&["sim", "log", "--seed", "1", "--thrust", "0.8", "--out", &log]);
    let (sound, _) = json(&["identify", &log]);
    let with = |path: &str, value: Value| {
        let mut changed = sound.clone();
        for refined in ["/refined", "/models/0/identification/refined"] {
            *changed.pointer_mut(&format!("{refined}/{path}")).unwrap() = value.clone();
        }
        write(folder.path(), "m.json", &changed.to_string())
    };
    for (path, value) in [
        ("interval_95/a22_per_s", serde_json::json!([-0.9, -1.9])),
        ("interval_95/a22_per_s", serde_json::json!([-1.9, -1.5])),
        ("interval_95/b2_per_s2", serde_json::json!([1.2, 0.9])),
        ("covariance/0/0", serde_json::json!(-0.1)),
    ] {
        let model = with(path, value);
        for line in [
            vec!["gains", "--model", &model],
            vec!["turn", "--model", &model],
            vec!["export", "--to", "vehicle", "--model", &model],
            vec!["validate", &log, "--model", &model],
            vec!["health", &model, &log],
            vec!["plan", "--thrust", "0.8", "--model", &model],
        ] {
            let refused = run(&line);
            let told = text(&refused.stderr);
            assert_eq!(refused.status.code(), Some(2), "{line:?} {path}: {told}");
            assert!(told.contains("run 1"), "{told}");
        }
    }
    // One that reaches 0 is an interval, and there is no gain.
    let model = with("interval_95/a22_per_s/1", serde_json::json!(0.0));
    let (none, code) = json(&["gains", "--model", &model]);
    assert_eq!((none.pointer("/points/0/proportional_gain"), code), (Some(&Value::Null), Some(4)));
}

/// Each figure that follows from others of the document, and each that no seatrial writes.
#[test]
fn cli_a_document_that_contradicts_itself_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("l.csv").display().to_string();
    run(&["sim", "log", "--seed", "1", "--thrust", "0.8", "--out", &log]);
    let (sound, _) = json(&["identify", &log]);
    let refused = |path: &str, value: &str| {
        let mut changed = sound.clone();
        *changed.pointer_mut(path).unwrap() = serde_json::from_str(value).unwrap();
        let model = write(folder.path(), "m.json", &changed.to_string());
        for line in [
            vec!["gains", "--model", &model],
            vec!["turn", "--model", &model],
            vec!["export", "--to", "vehicle", "--model", &model],
            vec!["validate", &log, "--model", &model],
            vec!["health", &model, &log],
        ] {
            let refused = run(&line);
            let told = text(&refused.stderr);
            assert_eq!(refused.status.code(), Some(2), "{line:?} {path}: {told}");
            assert!(told.contains("m.json"), "{told}");
        }
    };
    for of in ["", "/models/0/identification"] {
        refused(&format!("{of}/refined/interval_95/b2_per_s2"), "[-1, 1.5]");
        refused(&format!("{of}/refined/interval_95/a22_per_s"), "[-1e300, 1e300]");
        refused(&format!("{of}/refined/heading_noise_rad"), "-5");
        refused(&format!("{of}/refined/delta0_rad"), "0.2");
        refused(&format!("{of}/nomoto/t_s"), "2.5");
        refused(&format!("{of}/nomoto/k_per_s"), "-1");
        refused(&format!("{of}/valid_range/rudder"), "[0.26, -0.26]");
        refused(&format!("{of}/valid_range/band_rad_s"), "[6, 0.5]");
        refused(&format!("{of}/verdict/accepted"), "false");
        refused(&format!("{of}/verdict/reasons/0/code"), "\"low_r2\"");
        refused(&format!("{of}/verdict/outcome"), "\"do_not_use\"");
    }
    refused("/refined/b2_per_s2", "1.01");
    refused("/models/0/surge_speed_m_s", "16");
    refused("/models/0/identification/loop_timing/delay_s", "1e300");
    refused("/models/0/identification/refined/covariance/0/1", "0");
    // What refuses the models as a whole refuses each of them.
    let mut whole = sound.clone();
    whole["verdict"] = serde_json::json!({"accepted": false, "outcome": "do_not_use",
        "reasons": [{"code": "damping_changed", "text": "another vehicle"}]});
    let model = write(folder.path(), "m.json", &whole.to_string());
    let gains = run(&["gains", "--model", &model]);
    assert_eq!(gains.status.code(), Some(4));
    assert!(text(&gains.stdout).contains("DO NOT USE: another vehicle"));
}

#[test]
fn cli_turn_refuses_an_unstable_vehicle_as_a_value() {
    let (document, code) = json(&["turn", "--a22", "0.1", "--b2", "1"]);
    assert_eq!(code, Some(4));
    for hand in document.pointer("/points/0/hands").unwrap().as_array().unwrap() {
        assert!(hand["refused"].as_str().unwrap().contains("a22"));
        assert!(hand["yaw_rate_rad_s"].is_null());
    }
}

#[test]
fn cli_turn_finds_the_least_radius_over_speed_and_marks_extrapolation() {
    let directory = tempfile::tempdir().unwrap();
    let schedule = write(directory.path(), "schedule.toml", SCHEDULE);
    let (document, _) = json(&["turn", "--schedule", &schedule]);
    assert!(document.pointer("/over_speed/1/minimum").unwrap().is_null());
    let (document, _) = json(&["turn", "--schedule", &schedule, "--up-to-speed", "5"]);
    assert_eq!(document.pointer("/over_speed/1/minimum/extrapolated"), Some(&Value::Bool(true)));
    let output = run(&["turn", "--a22", "-1", "--b2", "1", "--up-to-speed", "5"]);
    assert_eq!(output.status.code(), Some(2));
}

#[test]
fn cli_gains_are_table_v_and_between_them_that_of_the_model() {
    let directory = tempfile::tempdir().unwrap();
    let schedule = write(directory.path(), "schedule.toml", SCHEDULE);
    let (document, code) = json(&["gains", "--schedule", &schedule, "--at-thrust", "0.65"]);
    assert_eq!(code, Some(0));
    for (pointer, printed) in [
        ("/points/0/proportional_gain/value", 1.26),
        ("/points/1/proportional_gain/value", 0.54),
        // a22 -1.305, b2 0.770 by the square of 1.185 m/s; the paper's line between gains has 1.17.
        ("/at/proportional_gain/value", 1.106),
    ] {
        // Half a unit of the last digit printed.
        assert!((number(&document, pointer) - printed).abs() < 0.005);
    }
    let overshoot = number(&document, "/points/0/loop/overshoot/value");
    // The default ratio is 1/sqrt(2) exactly.
    assert!((overshoot - (-std::f64::consts::PI).exp()).abs() < 1e-12);
    assert!(document.pointer("/points/0/loop/gain_margin").unwrap().is_null());
    assert_eq!(document.pointer("/at/extrapolated"), Some(&Value::Bool(false)));
}

#[test]
fn cli_gains_extrapolate_only_when_asked() {
    let directory = tempfile::tempdir().unwrap();
    let schedule = write(directory.path(), "schedule.toml", SCHEDULE);
    let outside = ["gains", "--schedule", &schedule, "--at-speed", "2.3"];
    let refused = run(&outside);
    assert_eq!(refused.status.code(), Some(2));
    assert!(text(&refused.stderr).contains("--extrapolate"));
    let allowed = run(&[&outside[..], &["--extrapolate"]].concat());
    assert_eq!(allowed.status.code(), Some(0));
    assert!(text(&allowed.stdout).contains("EXTRAPOLATED"));
    let too_far = ["gains", "--schedule", &schedule, "--at-thrust", "0.2", "--extrapolate"];
    assert_eq!(run(&too_far).status.code(), Some(2));
}

#[test]
fn cli_gains_carry_intervals_of_the_refined_estimate() {
    let directory = tempfile::tempdir().unwrap();
    let model = write(directory.path(), "model.json", IDENTIFICATION);
    let (document, code) =
        json(&["gains", "--model", &model, "--delay", "0.1", "--interval", "0.05"]);
    assert_eq!(code, Some(0));
    assert_eq!(number(&document, "/points/0/a22_per_s"), -1.07);
    let paper = number(&document, "/points/0/gain_of_57/value");
    let half_width = number(&document, "/points/0/gain_of_57/interval_95/1") - paper;
    // K_p = a22^2/(2 b2): relative variances add, twice that of a22 and once that of b2.
    let expected = paper * (2.0 * 0.03 / 1.07_f64).hypot(0.04 / 1.08);
    assert!((half_width / expected - 1.0).abs() < 1e-3);
    // To load: for a22 at -1.04, 5.5 % less, and for 0.125 s of delay.
    let gain = number(&document, "/points/0/proportional_gain/value");
    assert!((0.75..0.90).contains(&(gain / paper)), "{gain} {paper}");
    assert_eq!(number(&document, "/points/0/allowance/timing/delay_s"), 0.1);
    assert!((number(&document, "/points/0/allowance/damping_per_s") - 0.03).abs() < 1e-15);
    assert!(number(&document, "/points/0/loop/gain_margin/value") > 1.0);
}

/// A simulated log, and what `identify` says of it, saved as `model.json`.
fn identified(directory: &Path, made: &[&str], read: &[&str]) -> (String, Value) {
    let log = directory.join("log.csv").display().to_string();
    let sim = ["sim", "log", "--seed", "5", "--out", &log];
    assert!(run(&[&sim, made].concat()).status.success());
    let (found, code) = json(&[&["identify", &log], read].concat());
    assert_eq!(code, Some(0), "{found:#}");
    write(directory, "model.json", &found.to_string());
    (log, found)
}

#[test]
fn cli_gains_of_a_schedule_are_those_of_the_document() {
    let directory = tempfile::tempdir().unwrap();
    let schedule = directory.path().join("s.toml").display().to_string();
    let servo = ["--rudder-lag", "0.1", "--schedule", &schedule];
    let (_, found) = identified(directory.path(), &[], &servo);
    let model = directory.path().join("model.json").display().to_string();
    let (of_document, _) = json(&["gains", "--model", &model]);
    let (of_schedule, _) = json(&["gains", "--schedule", &schedule]);
    let points = of_document["points"].as_array().unwrap();
    assert!(points.len() > 2, "{of_document:#}");
    for k in 0..points.len() {
        for figure in ["value", "interval_95/0", "interval_95/1"] {
            let pointer = format!("/points/{k}/proportional_gain/{figure}");
            let [a, b] = [&of_document, &of_schedule].map(|of| number(of, &pointer));
            assert!((a / b - 1.0).abs() < 1e-9, "{pointer}: {a}, {b}");
        }
    }
    // A loop waits for a sample and for the servo, in the gain that `identify` prints as well.
    let interval_s = number(&of_document, "/timing/sample_interval_s");
    assert!((number(&of_document, "/timing/delay_s") - interval_s - 0.1).abs() < 1e-9);
    let delay_s = number(&found, "/models/0/identification/loop_timing/delay_s");
    assert!((delay_s - interval_s - 0.1).abs() < 1e-9);
}

#[test]
fn cli_the_model_of_a_whole_log_has_its_speed_and_its_rudder() {
    let directory = tempfile::tempdir().unwrap();
    let windows = ["--from", "12", "--to", "28.5", "--validate-from", "28.5"];
    let (log, _) = identified(directory.path(), &["--thrust", "0.8"], &windows);
    let model = directory.path().join("model.json").display().to_string();
    let (turn, code) = json(&["turn", "--model", &model]);
    assert_eq!(code, Some(0));
    let speed = number(&turn, "/points/0/surge_speed_m_s");
    assert!((speed - 1.63).abs() < 0.05, "{speed}");
    assert_eq!(number(&turn, "/rudder_limit_rad"), 0.26);

    let rows = std::fs::read_to_string(&log).unwrap();
    let shares = rows.replacen("rudder_rad", "rudder_fraction", 1);
    let shares = write(directory.path(), "shares.csv", &shares);
    let range = ["--rudder-range-deg", "25"];
    let (found, _) = json(&[&["identify", &shares][..], &windows, &range].concat());
    let found = write(directory.path(), "shares.json", &found.to_string());
    let (turn, _) = json(&["turn", "--model", &found]);
    assert!((number(&turn, "/rudder_limit_rad") - 25_f64.to_radians()).abs() < 1e-9);
}

#[test]
fn cli_gains_from_a_trial_take_the_last_accepted_run_of_each_thrust() {
    let run = |thrust: f64, a22: f64, accepted: bool| {
        format!(
            r#"{{"thrust":{thrust},"surge_speed_m_s":{},"verdict":{{"accepted":{accepted}}},
            "identification":{{"refined":null,
            "online":{{"a22_per_s":{a22},"b2_per_s2":1,"c0_rad_per_s2":0}}}}}}"#,
            2.0 * thrust
        )
    };
    let runs =
        [run(0.6, -1.0, true), run(0.8, -9.0, false), run(0.8, -2.0, true), run(0.6, -1.2, true)];
    let directory = tempfile::tempdir().unwrap();
    let trial = |name, runs: &[String]| {
        let document = format!(r#"{{"rudder_limit_rad":0.3,"runs":[{}]}}"#, runs.join(","));
        write(directory.path(), name, &document)
    };
    let (document, code) = json(&["gains", "--model", &trial("all.json", &runs)]);
    assert_eq!(code, Some(0));
    assert_eq!(number(&document, "/rudder_limit_rad"), 0.3);
    assert_eq!(document["points"].as_array().unwrap().len(), 2);
    assert_eq!(number(&document, "/points/0/a22_per_s"), -1.2);
    assert_eq!(number(&document, "/points/1/a22_per_s"), -2.0);

    let without_a_repeat = trial("some.json", &runs[..2]);
    let output = seatrial_dev::run(&["gains", "--model", &without_a_repeat]);
    // The other speeds are used with care, as the verdict on the trial says.
    assert_eq!(output.status.code(), Some(0));
    assert!(text(&output.stderr).contains("80 % thrust has no accepted run"));
}

#[test]
fn cli_gains_export_what_a_controller_needs() {
    let directory = tempfile::tempdir().unwrap();
    let schedule = write(directory.path(), "schedule.toml", SCHEDULE);
    let out = directory.path().join("gains.json");
    let out = out.to_str().unwrap();
    let export = ["gains", "--schedule", &schedule, "--export", "json"];
    let (gains, code) = json(&[&export[..], &["--out", out]].concat());
    assert_eq!(code, Some(0));
    assert_eq!(gains["schema"], "seatrial.gains.v1");
    let document: Value = serde_json::from_str(&std::fs::read_to_string(out).unwrap()).unwrap();
    assert_eq!(document["schema"], "seatrial.gain_schedule.v1");
    assert_eq!(number(&document, "/points/0/feed_forward_rudder_rad"), -0.0129 / 0.65);
    let missing = run(&[&export[..], &["--out", "/nowhere/gains.json"]].concat());
    assert_eq!(missing.status.code(), Some(6));
}

#[test]
fn cli_gains_export_for_autopilots_at_one_speed() {
    let directory = tempfile::tempdir().unwrap();
    let schedule = write(directory.path(), "schedule.toml", SCHEDULE);
    let export = |arguments: &[&str]| {
        let output = run(&[&["gains", "--schedule", &schedule, "--export"], arguments].concat());
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        (text(&output.stdout), text(&output.stderr))
    };
    // The fastest model, and it says so; A = alpha/2.
    let (fastest, warning) = export(&["ardupilot", "--vehicle-type", "underwater"]);
    assert!(fastest.contains("\nATC_ANG_YAW_P,0.74\n"), "{fastest}");
    assert!(warning.contains("100 % thrust"), "{warning}");
    let slowest = ["--vehicle-type", "underwater", "--at-speed", "1.05"];
    let (slowest, warning) = export(&[&["ardupilot"], &slowest[..]].concat());
    assert!(slowest.contains("\nATC_ANG_YAW_P,0.64\n"), "{slowest}");
    assert!(warning.contains("say --full-rudder-deg DEG"), "{warning}");
    assert!(!warning.contains("thrust"), "{warning}");
    // Twice the angle at full steering is half the steering for the same turn.
    let feed_forward = |arguments: &[&str]| {
        let (file, _) = export(&[&["ardupilot"], arguments].concat());
        let line = file.lines().find(|line| line.starts_with("ATC_STR_RAT_FF,"));
        line.unwrap()[15..].parse::<f64>().unwrap()
    };
    let ratio =
        feed_forward(&["--full-rudder-deg", "15"]) / feed_forward(&["--full-rudder-deg", "30"]);
    // Parameters are single precision.
    assert!((ratio - 2.0).abs() < 1e-6, "{ratio}");
    for (format, says) in
        [("px4", "\tRA_WHEEL_BASE\t"), ("ros2", "heading_controller:"), ("c", "#endif")]
    {
        let (file, _) = export(&[format]);
        assert!(file.contains(says), "{file}");
    }
    let no_json = ["gains", "--a22", "-1", "--b2", "1", "--export", "c", "--json"];
    assert_eq!(run(&no_json).status.code(), Some(2));
    // Of a log with servo outputs b2 is per full rudder: -a22/b2.
    let of_servo = IDENTIFICATION.replacen('{', r#"{"source":{"rudder_unit":"full_rudder"},"#, 1);
    let of_servo = write(directory.path(), "servo.json", &of_servo);
    let output = run(&["gains", "--model", &of_servo, "--export", "ardupilot"]);
    let file = text(&output.stdout);
    assert!(file.contains(&format!("\nATC_STR_RAT_FF,{}\n", (1.07 / 1.08) as f32)), "{file}");
    let outside = ["--at-speed", "9", "--export", "px4"];
    let outside = run(&[&["gains", "--schedule", &schedule], &outside[..]].concat());
    assert_eq!(outside.status.code(), Some(2));
    assert!(text(&outside.stderr).contains("--extrapolate"));
    let unstable = ["gains", "--a22", "0.1", "--b2", "1", "--export", "ardupilot"];
    let unstable = run(&unstable);
    assert_eq!(unstable.status.code(), Some(3));
    assert!(text(&unstable.stderr).contains("course unstable"));
}

#[test]
fn cli_bad_sources_say_what_is_wrong() {
    let directory = tempfile::tempdir().unwrap();
    let file = |name, content| write(directory.path(), name, content);
    let twice = SCHEDULE.replace("thrust = 1.0", "thrust = 0.6");
    for (arguments, code, says) in [
        (vec!["gains".into()], 2, "--model FILE"),
        (vec!["turn".into(), "--model".into(), "/nowhere.json".into()], 3, "/nowhere.json"),
        (vec!["turn".into(), "--model".into(), file("a.json", "a22")], 3, "identify --json"),
        (vec!["turn".into(), "--model".into(), file("b.json", "{}")], 3, "`refined`"),
        (
            vec!["turn".into(), "--model".into(), file("c.json", r#"{"online":{"a22_per_s":-1}}"#)],
            3,
            "`b2_per_s2`",
        ),
        (
            vec![
                "turn".into(),
                "--model".into(),
                file("c2.json", &IDENTIFICATION.replace("verdict", "comment")),
            ],
            3,
            "`verdict` is missing",
        ),
        (vec!["turn".into(), "--schedule".into(), file("d.toml", "")], 3, "[[point]]"),
        (
            vec!["turn".into(), "--schedule".into(), file("e.toml", "[[point]]\na22 = 1")],
            3,
            "line 2",
        ),
        (
            vec![
                "gains".into(),
                "--schedule".into(),
                file("f.toml", &twice),
                "--at-thrust".into(),
                "0.6".into(),
            ],
            3,
            "two points at 0.6",
        ),
        (
            ["gains", "--a22", "-1", "--b2", "1", "--zeta", "0"].map(String::from).to_vec(),
            2,
            "--zeta",
        ),
        (
            ["gains", "--a22", "-1", "--b2", "1", "--interval=-0.1"].map(String::from).to_vec(),
            2,
            "--interval",
        ),
        (
            ["turn", "--a22", "-1", "--b2", "1", "--rudder-limit-deg", "0"]
                .map(String::from)
                .to_vec(),
            2,
            "rudder limit",
        ),
    ] {
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let output = run(&arguments);
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {message}");
        assert!(message.contains(says), "{arguments:?}: {message}");
        assert!(output.stdout.is_empty());
    }
}

#[test]
fn cli_paper_writes_three_files_and_prints_the_rows_that_differ() {
    let directory = tempfile::tempdir().unwrap();
    let out = directory.path().join("new/paper");
    let out_text = out.to_str().unwrap();
    let output = run(&["paper", "--out", out_text]);
    assert_eq!(output.status.code(), Some(0));
    let printed = text(&output.stdout);
    assert!(printed.contains("least turning radius") && printed.contains("7.63"));
    let (document, _) = json(&["paper", "--out", out_text]);
    let rows = number(&document, "/summary/rows") as usize;
    assert_eq!(document["claims"].as_array().unwrap().len(), rows);
    let written = std::fs::read_to_string(out.join("paper.json")).unwrap();
    assert_eq!(serde_json::from_str::<Value>(&written).unwrap(), document);
    let csv = std::fs::read_to_string(out.join("paper.csv")).unwrap();
    assert_eq!(csv.lines().count(), rows + 1);
    let markdown = std::fs::read_to_string(out.join("paper.md")).unwrap();
    assert!(markdown.contains("| Table IV | R at 1.4 m/s with delta0 = 0.036 | m | 9.20 |"));
}

/// The circle of the thrust at which the U-turn was measured is the one measured, and so by ratio at the other.
#[test]
fn cli_a_measured_u_turn_scales_the_circles() {
    let folder = tempfile::tempdir().unwrap();
    let schedule = write(folder.path(), "schedule.toml", SCHEDULE);
    let with = |u_turn: &str| json(&["turn", "--schedule", &schedule, "--measured-u-turn", u_turn]);
    let (document, code) = with("2.13:9.9");
    assert_eq!(code, Some(0));
    let mean = |point: usize, name: &str| {
        let of = |hand| number(&document, &format!("/points/{point}/hands/{hand}/{name}/value"));
        0.5 * (of(0) + of(1))
    };
    let points = document["points"].as_array().unwrap();
    let fast = usize::from(points[1]["surge_speed_m_s"] == 2.13);
    // Rounding.
    assert!((mean(fast, "circle_by_u_turn_m") - 9.9).abs() < 1e-9);
    let ratio = number(&document, "/u_turn_ratio");
    let slow = 1 - fast;
    let expected = ratio * mean(slow, "steady_turning_radius_m");
    assert!((mean(slow, "circle_by_u_turn_m") - expected).abs() < 1e-9);
    let (document, _) = json(&["turn", "--schedule", &schedule]);
    assert!(document["u_turn_ratio"].is_null());
    assert!(document["points"][0]["hands"][0]["circle_by_u_turn_m"].is_null());
    for wrong in ["9.9", "2:-1", "9:9"] {
        let run = run(&["turn", "--schedule", &schedule, "--measured-u-turn", wrong]);
        assert_eq!(run.status.code(), Some(2), "{wrong}");
    }
}

#[test]
fn cli_gains_of_a_campaign_are_looked_for_in_the_usual_logbook() {
    let folder = tempfile::tempdir().unwrap();
    let trial = run_in(folder.path(), &["trial", "--seed", "1"]);
    assert!(trial.status.success());
    let output = run_in(folder.path(), &["gains", "--campaign", "1"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("seatrial.db, campaign 1"));
}
