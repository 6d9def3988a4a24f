//! R^2 against an independent implementation on simulated runs.

use std::path::Path;

use seatrial_core::{Sample, Validation, YawModel};
use seatrial_dev::data;
use serde_json::Value;

/// The samples of a run (columns t, yaw, rudder, ...) inside a half-open window.
fn window(path: &Path, from_s: f64, to_s: f64) -> Vec<Sample<f64>> {
    let text = std::fs::read_to_string(path).unwrap();
    text.lines()
        .skip(1)
        .map(|line| {
            let mut fields = line.split(',').map(|field| field.parse().unwrap());
            Sample {
                time_s: fields.next().unwrap(),
                heading_rad: fields.next().unwrap(),
                rudder_rad: fields.next().unwrap(),
                ..Sample::default()
            }
        })
        .filter(|sample| sample.time_s >= from_s - 1e-9 && sample.time_s < to_s - 1e-9)
        .collect()
}

/// `R2_mean2s` is R^2 (35) of a simulation that starts at the mean heading of the first 2 s with no
/// rate, `R2_first` of one that starts at the first sample.
#[test]
fn val_reference_r2_from_averaged_initial_conditions() {
    let Some(folder) = data("simulated") else {
        return;
    };
    let text = std::fs::read_to_string(folder.join("reference_results.json")).unwrap();
    let runs: Vec<Value> = serde_json::from_str(&text).unwrap();
    let mut compared = 0;
    for run in &runs {
        let file = run["file"].as_str().unwrap();
        let [from_s, to_s] = [0, 1].map(|i| run["validation"][i].as_f64().unwrap());
        let samples = window(&folder.join(file), from_s, to_s);
        for estimate in run["svf_rls"].as_array().unwrap() {
            let theta = [0, 1, 2].map(|i| estimate["theta"][i].as_f64().unwrap());
            let model = YawModel::from_theta(theta);
            for (name, lead_in_s) in [("R2_mean2s", 2.0), ("R2_first", 0.0)] {
                let expected = estimate[name].as_f64().unwrap();
                let r2 = Validation::of(model, lead_in_s, &samples).r2_heading.unwrap();
                // Both are exact up to rounding; 1 - R^2 spans 1e-6 to 5000, hence relative to it.
                assert!(
                    (r2 - expected).abs() < 1e-9 * (1.0 + (1.0 - expected).abs()),
                    "{file} {name}: {r2} instead of {expected}"
                );
                compared += 1;
            }
        }
    }
    assert!(compared > 0);
}
