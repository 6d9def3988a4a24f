//! Studies of estimators, faults and lying logs as a process.

use std::process::Output;

use seatrial_dev::lab;
use serde_json::Value;

fn study(args: &[&str]) -> Output {
    lab().args(args).arg("--json").output().unwrap()
}

fn estimators(args: &[&str]) -> Output {
    study(&[&["estimators"], args].concat())
}

const QUIET: [&str; 8] =
    ["--runs", "40", "--noise-deg", "0.5", "--disturbance", "0", "--estimator", "refined"];

fn quantity<'a>(document: &'a Value, name: &str) -> &'a Value {
    let quantities = &document["cells"][0]["estimators"][0]["quantities"];
    quantities.as_array().unwrap().iter().find(|quantity| quantity["name"] == name).unwrap()
}

#[test]
fn cli_the_study_does_not_depend_on_the_threads() {
    let alone = estimators(&[&QUIET[..], &["--threads", "1"]].concat());
    let together = estimators(&[&QUIET[..], &["--threads", "3"]].concat());
    assert_eq!(alone.status.code(), Some(0));
    assert_eq!(alone.stdout, together.stdout);
}

#[test]
fn recover_the_refined_estimate_is_near_the_bound_and_covers() {
    let document: Value = serde_json::from_slice(&estimators(&QUIET).stdout).unwrap();
    assert_eq!(document["schema"], "seatrial.study.v1");
    assert_eq!(document["cells"][0]["runs"], 40);
    for name in ["a22", "b2"] {
        let found = quantity(&document, name);
        // 0.9 is measured over 1000 runs; of 40 runs an efficiency is known to sqrt(2/40) = 0.22, a
        // coverage to sqrt(0.05/40) = 0.035: three of each.
        let efficiency = found["efficiency"].as_f64().unwrap();
        assert!((0.3..1.6).contains(&efficiency), "{name} {efficiency}");
        let coverage = found["coverage"].as_f64().unwrap();
        assert!(coverage >= 0.85, "{name} {coverage}");
    }
    let gain = quantity(&document, "K_p");
    assert!(gain["efficiency"].is_null());
    assert!(gain["coverage"].as_f64().unwrap() >= 0.85);
}

/// The paper's filters and ridge are biased: a study must show it.
#[test]
fn recover_the_bias_of_the_paper_is_seen() {
    let found = estimators(&[
        "--runs",
        "10",
        "--noise-deg",
        "0.2",
        "--disturbance",
        "0",
        "--estimator",
        "paper",
    ]);
    let document: Value = serde_json::from_slice(&found.stdout).unwrap();
    let a22 = quantity(&document, "a22");
    let bias = a22["bias"].as_f64().unwrap();
    // The ridge of P0 = 100 alone takes 5 % of 1.07 1/s.
    assert!(bias > 0.03, "{bias}");
    assert!(a22["coverage"].is_null());
}

#[test]
fn cli_bad_options_are_usage_errors() {
    for (args, word) in [
        (["--disturbance", "0.005"], "RAD_S2,S"),
        (["--estimator", "best"], "output-error"),
        (["--thrust", "1.5"], "fraction"),
        (["--noise-deg", "-1"], "below 0"),
        (["--runs", "1"], "2.."),
    ] {
        let refused = estimators(&args);
        let text = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert_eq!(refused.status.code(), Some(2), "{args:?} {text}");
        assert!(text.contains(word), "{args:?}: {text}");
    }
}

/// A quick part of the fault matrix; the whole is in validation/.
#[test]
fn val_every_fault_ends_in_a_correct_model_or_for_its_own_reason() {
    let output = study(&["faults", "--seeds", "1", "--stage", "training"]);
    let document: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(document["schema"], "seatrial.fault_matrix.v1");
    assert_eq!(document["failed"], 0, "{document}");
    assert_eq!(output.status.code(), Some(0));
    // All but the current step, which a first-order vehicle cannot play.
    assert_eq!(document["trials"], 17);
    let refused = study(&["faults", "--kind", "current_step"]);
    assert_eq!(refused.status.code(), Some(2));
}

/// Seeds at which a rudder that is jammed for good once passed for a vehicle with a hundredth of its authority.
#[test]
fn regress_a_jammed_rudder_is_no_vehicle() {
    for (stage, seed) in [("settle", "2002"), ("between", "2007")] {
        let jam = ["faults", "--kind", "rudder_jam", "--seeds", "1"];
        let output = study(&[&jam[..], &["--stage", stage, "--seed", seed]].concat());
        let document: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(document["failed"], 0, "{document}");
    }
}

/// 1.28 times the bound's time is measured over 40 runs: the interval's prior expects more disturbance than there is.
#[test]
fn recover_intervals_are_narrow_not_long_after_the_bound_allows() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("study.html");
    let arguments = ["--width", "0.1", "--report", page.to_str().unwrap()];
    let found = estimators(&[&["--runs", "6"], &QUIET[2..], &arguments].concat());
    let document: Value = serde_json::from_slice(&found.stdout).unwrap();
    let convergence = &document["cells"][0]["convergence"];
    let of = |name: &str| convergence[name].as_f64().unwrap();
    assert!(of("reached") >= 0.9 * of("possible"), "{convergence}");
    let ratio = of("found_s") / of("bound_s");
    // The scatter of six runs is 0.05.
    assert!((1.0..1.5).contains(&ratio), "{convergence}");
    let page = std::fs::read_to_string(page).unwrap();
    assert!(page.contains("the bound allows") && page.contains("Efficiency"));
}

/// Two logs of every kind, one with windows and one without; `validation/2026-11-24-lies` has 24.
#[test]
fn recover_a_lying_log_gives_no_wrong_model_unsaid() {
    let output = study(&["lies", "--seeds", "2"]);
    let document: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(document["schema"], "seatrial.lying_logs.v1");
    let share = |decidability: &str, of: &str, among: &str| {
        let totals = document["totals"].as_array().unwrap();
        let total = totals.iter().find(|t| t["decidability"] == decidability);
        let total = total.unwrap();
        total[of].as_f64().unwrap() / total[among].as_f64().unwrap()
    };
    // 98 % of 24 seeds; one of these logs is 3 %.
    assert!(share("sound", "accepted", "logs") >= 0.92);
    // 1.8 % of 24 seeds, nearly all of them a rudder with play; of these 156 logs, 95 % of the time under 4 %.
    assert!(share("decidable", "wrong", "logs") < 0.04);
    assert_eq!(share("undecidable", "wrong_without_note", "logs"), 0.0);
}
