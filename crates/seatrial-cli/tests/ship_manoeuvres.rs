//! `seatrial manoeuvres` at the process boundary.

use std::path::Path;

use seatrial_dev::{run_in, text};
use serde_json::Value;

fn document(folder: &Path, arguments: &str) -> Value {
    let arguments: Vec<&str> = arguments.split_whitespace().collect();
    let output = run_in(folder, &arguments);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    serde_json::from_str(&text(&output.stdout)).unwrap()
}

fn value(document: &Value, manoeuvre: &str, name: &str) -> f64 {
    let indices = document["indices"].as_array().unwrap().iter();
    let mut found = indices.filter(|index| {
        index["name"] == name && index["manoeuvre"].as_str().unwrap().starts_with(manoeuvre)
    });
    found.next().unwrap_or_else(|| panic!("{manoeuvre} {name}\n{document:#}"))["value"]
        .as_f64()
        .unwrap()
}

/// Figures that are predicted, and the same manoeuvre read from a record of the vehicle.
#[test]
fn exact_a_recorded_zig_zag_has_the_predicted_figures() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let vehicle = "schema = \"seatrial.vehicle.v1\"\nname = \"ship\"\n[rudder]\nlimit_rad = 0.62\nlag_s = 2.0\n[surge]\n\
                   time_constant_s = 60.0\n[[speed]]\nthrust = 0.8\nsurge_speed_m_s = 7.7\na22_per_s = -0.05\nb2_per_s2 = 0.0026\n";
    std::fs::write(folder.join("ship.toml"), vehicle).unwrap();
    let predicted = document(
        folder,
        "manoeuvres predict --vehicle sim:ship.toml --length 170 --report form.html --json",
    );
    assert_eq!(predicted["criteria"].as_array().unwrap().len(), 6);
    assert!(std::fs::read_to_string(folder.join("form.html")).unwrap().contains("MSC.137(76)"));
    let ship = seatrial_sim::IdentifiedVehicle::from_toml(vehicle).unwrap();
    let mut plant = ship.plant(0.8);
    let angle_rad = 20_f64.to_radians();
    let (mut side, mut rudder_rad) = (1.0, 0.0);
    let mut log = String::from("time_s,heading_rad,rudder_rad,surge_speed_m_s\n");
    for k in 0..2400 {
        if k == 100 {
            rudder_rad = angle_rad;
        }
        if side * plant.yaw.heading_rad >= angle_rad {
            side = -side;
            rudder_rad = side * angle_rad;
        }
        log += &format!(
            "{},{},{},{}\n",
            0.25 * f64::from(k),
            plant.yaw.heading_rad,
            rudder_rad,
            plant.surge_speed_m_s
        );
        plant.advance(rudder_rad, 0.8, 0.0, 0.25);
    }
    std::fs::write(folder.join("run.csv"), log).unwrap();
    let read = document(folder, "manoeuvres read run.csv --length 170 --json");
    for name in [
        "initial turning time",
        "initial turning track",
        "first overshoot angle",
        "second overshoot angle",
        "period",
    ] {
        let [ours, theirs] = [&predicted, &read].map(|d| value(d, "zig-zag 20/20", name));
        // Samples of 0.25 s: a rudder ordered over up to 0.25 s late, 1 % of the swings.
        assert!((theirs / ours - 1.0).abs() < 0.02, "{name}: {ours} {theirs}");
    }
    assert_eq!(read["criteria"].as_array().unwrap().len(), 1);
}

#[test]
fn cli_intervals_come_from_the_trial() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let trial = run_in(folder, &["trial", "--vehicle", "sim:starfish", "--seed", "1", "--yes"]);
    assert_eq!(trial.status.code(), Some(0));
    let found =
        document(folder, "manoeuvres --logbook seatrial.db --thrust 0.8 --draws 100 --json");
    let indices = found["indices"].as_array().unwrap();
    for index in indices.iter().filter(|i| i["manoeuvre"].as_str().unwrap().starts_with("zig-zag"))
    {
        let interval = index["interval_95"].as_array().unwrap_or_else(|| panic!("{index}"));
        let [low, high] = [0, 1].map(|k| interval[k].as_f64().unwrap());
        let value = index["value"].as_f64().unwrap();
        assert!(low < value && value < high, "{index}");
    }
    let refused =
        run_in(folder, &["manoeuvres", "predict", "--logbook", "seatrial.db", "--length", "-1"]);
    assert_eq!(refused.status.code(), Some(2));
    let refused = run_in(folder, &["manoeuvres", "read", "nowhere.csv"]);
    assert_eq!(refused.status.code(), Some(3));
}
