//! The pitch axis at the process boundary.

use std::process::{Command, Output};

fn seatrial(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_seatrial"))
        .args(arguments)
        .output()
        .unwrap()
}

#[test]
fn cli_a_pitch_trial_and_its_log_give_the_same_model() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("pitch.csv");
    let log = log.to_str().unwrap();
    let run = seatrial(&[
        "trial",
        "--axis",
        "pitch",
        "--vehicle",
        "sim:remus100",
        "--log",
        log,
        "--json",
    ]);
    assert!(run.status.success(), "{run:?}");
    let trial: serde_json::Value = serde_json::from_slice(&run.stdout).unwrap();
    let live = &trial["runs"][2]["identification"];
    let time = |window: &serde_json::Value, end: &str| window[end].as_f64().unwrap().to_string();
    let run = seatrial(&[
        "identify",
        log,
        "--axis",
        "pitch",
        "--json",
        "--from",
        &time(&live["training"], "from_s"),
        "--to",
        &time(&live["training"], "to_s"),
        "--validate-from",
        &time(&live["fresh"]["window"], "from_s"),
        "--validate-to",
        &time(&live["fresh"]["window"], "to_s"),
    ]);
    assert!(run.status.success(), "{run:?}");
    let read: serde_json::Value = serde_json::from_slice(&run.stdout).unwrap();
    let model = &read["refined"]["model"];
    for name in ["damping_per_s", "restoring_per_s2", "authority_per_s2"] {
        let (live, read) = (&live["refined"]["model"][name], &model[name]);
        // The file has every digit; the warming of the filters differs, where the search starts.
        let difference = live.as_f64().unwrap() - read.as_f64().unwrap();
        assert!(difference.abs() < 1e-4, "{name}: {live} {read}");
    }
}

#[test]
fn cli_a_vehicle_without_pitch_is_refused_by_name() {
    let run = seatrial(&["trial", "--axis", "pitch", "--vehicle", "sim:starfish"]);
    assert_eq!(run.status.code(), Some(2));
    let said = String::from_utf8(run.stderr).unwrap();
    assert!(
        said.contains("sim:starfish") && said.contains("no pitch"),
        "{said}"
    );
}
