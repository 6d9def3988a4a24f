//! `seatrial-lab commission` as a process.

use std::path::Path;

use seatrial_dev::{document, lab};
use serde_json::Value;

fn study(folder: &Path, arguments: &[&str]) -> Value {
    let mut study = lab();
    study.args(["commission", "--json"]).args(arguments);
    document(&study.current_dir(folder).output().unwrap())
}

/// The goals of the README's table: overshoot at most 5 % in the middle, every boat settles, none later than with the defaults.
#[test]
fn cli_the_study_of_commissions_reaches_its_goals() {
    let found = study(Path::new("."), &["--boats", "4"]);
    for class in found["classes"].as_array().unwrap() {
        assert_eq!((&class["refused"], &class["kept"]), (&0.into(), &4.into()), "{class}");
        let commissioned = &class["methods"][3];
        assert_eq!(commissioned["method"], "commissioned");
        assert!(commissioned["overshoot_median"].as_f64().unwrap() <= 0.05, "{class}");
        assert_eq!(commissioned["unsettled"], 0, "{class}");
        assert_eq!(commissioned["later_than_defaults"], 0, "{class}");
        let quick_tuned = &class["methods"][1];
        assert!(quick_tuned["overshoot_median"].as_f64().unwrap() > 0.05, "{class}");
    }
}

/// A sea and a compass of half a degree do not put gains back that are better, and the promised overshoot is measured.
#[test]
fn cli_better_gains_are_kept_in_a_sea() {
    let found = study(Path::new("."), &["--boats", "8", "--sea", "--seed", "700"]);
    let sum = |what: &str| -> u64 {
        let classes = found["classes"].as_array().unwrap().iter();
        classes.map(|class| class[what].as_u64().unwrap()).sum()
    };
    assert_eq!(sum("refused"), 0);
    assert!(sum("better") >= 23, "{found}");
    assert!(sum("better_kept") + 1 >= sum("better"), "{found}");
    assert!(sum("as_foreseen") >= 22, "{found}");
}

/// Boats of the study for the firmware's simulation: each is a vehicle of its class.
#[test]
fn cli_the_boats_of_the_study_are_vehicles() {
    let folder = tempfile::tempdir().unwrap();
    let found = study(folder.path(), &["--boats", "2", "--vehicles", "boats"]);
    let vehicles = found["vehicles"].as_array().unwrap();
    assert_eq!(vehicles.len(), 6);
    for (number, path) in vehicles.iter().enumerate() {
        let path = folder.path().join(path.as_str().unwrap());
        let config =
            seatrial_sim::VehicleConfig::from_toml(&std::fs::read_to_string(path).unwrap());
        let time_constant_s = -1.0 / config.unwrap().speeds[0].a22_per_s;
        let [low, high] = [[0.2, 0.6], [0.6, 2.0], [2.0, 6.0]][number / 2];
        assert!((low..=high).contains(&time_constant_s), "{time_constant_s}");
    }
}
