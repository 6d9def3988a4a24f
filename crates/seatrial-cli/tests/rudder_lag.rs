//! A first-order vehicle behind a slow servo, of which the log has the command only.

use std::path::Path;

use seatrial_dev::{data, document, program};
use serde_json::Value;

/// What `identify` finds, and its exit code.
fn identify(log: &Path, arguments: &[&str]) -> (Value, Option<i32>) {
    let output = program()
        .args(["identify", "--json"])
        .arg(log)
        .args(arguments)
        .output()
        .unwrap();
    (document(&output), output.status.code())
}

/// The delay that a gain allows for, less a sample.
fn allowed_lag_s(document: &Value) -> f64 {
    let folder = tempfile::tempdir().unwrap();
    let model = folder.path().join("model.json");
    std::fs::write(&model, document.to_string()).unwrap();
    let output = program()
        .args(["gains", "--json", "--model"])
        .arg(&model)
        .output()
        .unwrap();
    let gains = seatrial_dev::document(&output);
    let timing = &gains["points"][0]["allowance"]["timing"];
    timing["delay_s"].as_f64().unwrap() - timing["sample_interval_s"].as_f64().unwrap()
}

fn assert_within(document: &Value, name: &str, truth: f64, share: f64) {
    let found = document["refined"][name].as_f64().unwrap();
    assert!(
        (found / truth - 1.0).abs() < share,
        "{name} {found}, truth {truth}"
    );
    let interval = document["refined"]["interval_95"][name].as_array().unwrap();
    let (low, high) = (interval[0].as_f64().unwrap(), interval[1].as_f64().unwrap());
    assert!(
        low <= truth && truth <= high,
        "{name} {low} to {high}, truth {truth}"
    );
}

/// ArduPilot's Rover firmware on a simulated boat of known a22 and b2 at two throttles, with a rudder lag of 0.15 s.
/// The tolerance is 10 %.
#[test]
fn val_ardupilot_rover_with_a_lagging_rudder() {
    let Some(log) = data("native/ardupilot/rover_json_physics.tlog") else {
        return;
    };
    for (windows, a22, b2) in [
        (["86.6", "97", "100.6", "110"], -0.91, 1.75),
        (["125.6", "136", "139.6", "150"], -1.26, 3.71),
    ] {
        let [from, to, validate_from, validate_to] = windows;
        let identified = |given: &[&str], share: f64| {
            let windows = ["--from", from, "--to", to];
            let fresh = [
                "--validate-from",
                validate_from,
                "--validate-to",
                validate_to,
            ];
            let range = ["--rudder-range-deg", "35"];
            let (document, code) = identify(&log, &[&windows[..], &fresh, &range, given].concat());
            assert_eq!(code, Some(0));
            assert_within(&document, "a22_per_s", a22, share);
            assert_within(&document, "b2_per_s2", b2, share);
            document
        };
        let found = identified(&[], 0.1);
        let lag = found["higher_order"]["model"]["rudder_lag_s"]
            .as_f64()
            .unwrap();
        // Its interval is 0.03 s either side.
        assert!((lag - 0.15).abs() < 0.03, "{lag}");
        // Given, no order is left to explain. 0.144 and 0.156 s fit best, and the interval of a22 at the faster throttle is 19 %
        // either side.
        let given = identified(&["--rudder-lag", "0.15"], 0.15);
        assert!(given["higher_order"].is_null(), "{given}");
        assert_eq!(given["source"]["servo"]["lag_s"], 0.15);
        // Found or given, the gain allows for it beside a sample.
        for document in [found, given] {
            let lag_s = allowed_lag_s(&document);
            assert!((lag_s - 0.15).abs() < 0.03, "{lag_s}");
        }
    }
}

#[test]
fn cli_a_lag_that_cannot_be_is_a_usage_error() {
    for (option, value) in [("--rudder-lag", "-0.1"), ("--rudder-delay", "1000")] {
        let output = program()
            .args(["identify", "no.csv", option, value])
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(2));
        let text = String::from_utf8(output.stderr).unwrap();
        assert!(text.contains(option) && text.contains(value), "{text}");
    }
}
