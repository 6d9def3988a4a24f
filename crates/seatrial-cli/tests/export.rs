//! `seatrial export` at the process boundary.

use std::path::Path;

use seatrial_dev::{run_in, text};
use seatrial_sim::IdentifiedVehicle;
use serde_json::Value;

/// Runs it in a folder, and requires an exit code.
fn seatrial(folder: &Path, expected: i32, arguments: &str) -> (String, String) {
    let arguments: Vec<&str> = arguments.split_whitespace().collect();
    let output = run_in(folder, &arguments);
    let (said, errors) = (text(&output.stdout), text(&output.stderr));
    assert_eq!(output.status.code(), Some(expected), "{arguments:?}\n{said}{errors}");
    (said, errors)
}

/// The models of a logbook: thrust, a22 and b2 of each.
fn models(folder: &Path, logbook: &str) -> Vec<[f64; 3]> {
    let (document, _) = seatrial(folder, 0, &format!("gains --logbook {logbook} --json"));
    let document: Value = serde_json::from_str(&document).unwrap();
    let number = |value: &Value| value.as_f64().unwrap();
    let points = document["points"].as_array().unwrap().iter();
    points
        .map(|p| [number(&p["thrust"]), number(&p["a22_per_s"]), number(&p["b2_per_s2"])])
        .collect()
}

/// A trial, the vehicle file of its logbook, and a trial on the twin, which is found again.
#[test]
fn recover_a_vehicle_trains_on_its_twin() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    seatrial(folder, 0, "trial --vehicle sim:starfish --seed 1 --yes");
    seatrial(folder, 0, "export --to vehicle --logbook seatrial.db --name boat --out boat.toml");
    let vehicle = IdentifiedVehicle::load(&folder.join("boat.toml")).unwrap();
    let identified = models(folder, "seatrial.db");
    assert_eq!(vehicle.speeds.len(), identified.len());
    for (speed, [thrust, a22, b2]) in vehicle.speeds.iter().zip(&identified) {
        assert_eq!([speed.thrust, speed.a22_per_s, speed.b2_per_s2], [*thrust, *a22, *b2]);
        assert!(speed.covariance.is_some() && speed.seen_rudder_rad.is_some());
    }
    assert!(vehicle.provenance.is_rehearsal);
    assert!(vehicle.provenance.source.contains("campaign 1"));
    // The trial changes its speed, so that nothing had to be assumed; this simulator's turns cost no speed.
    let assumptions = &vehicle.provenance.assumptions;
    let is_of_turns = |said: &String| said.starts_with("surge.turning_drag_m");
    assert!(assumptions.iter().all(is_of_turns), "{assumptions:?}");
    assert!(vehicle.surge.drag_length_m.is_some());
    seatrial(folder, 0, "trial --vehicle sim:boat.toml --seed 2 --logbook twin.db --yes");
    for ([_, a22, b2], [_, a22_of_twin, b2_of_twin]) in
        identified.iter().zip(models(folder, "twin.db"))
    {
        // 16 s of record determine a22 to 3 % and b2 to 2.5 % (one standard deviation): four times that.
        assert!((a22_of_twin / a22 - 1.0).abs() < 0.12, "{a22} {a22_of_twin}");
        assert!((b2_of_twin / b2 - 1.0).abs() < 0.10, "{b2} {b2_of_twin}");
    }
}

#[test]
fn cli_an_unmeasured_quantity_is_named_and_kept() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let (said, errors) = seatrial(
        folder,
        0,
        "export --to vehicle --a22 -1.07 --b2 1.08 --speed 1.63 --name boat --out boat.toml",
    );
    assert_eq!(said, "boat.toml\n");
    for part in [
        "surge is not identifiable from this record",
        "thrust is ASSUMED",
        "rudder.lag_s is ASSUMED",
    ] {
        assert!(errors.contains(part), "{errors}");
    }
    let vehicle = IdentifiedVehicle::load(&folder.join("boat.toml")).unwrap();
    assert_eq!(vehicle.provenance.assumptions.len(), 3);
    let (same, _) = seatrial(folder, 0, "export --to vehicle --vehicle sim:boat.toml");
    assert_eq!(same, std::fs::read_to_string(folder.join("boat.toml")).unwrap());
    let (document, _) = seatrial(folder, 0, "export --to vehicle --vehicle sim:boat.toml --json");
    let document: Value = serde_json::from_str(&document).unwrap();
    assert_eq!(document["schema"], "seatrial.vehicle.v1");
    let (_, errors) = seatrial(folder, 3, "export --to vehicle --a22 -1.07 --b2 1.08");
    assert!(errors.contains("give a single model's with --speed"), "{errors}");
    let spoilt = same.replace("limit_rad = 0.26", "limit_rad = 14.9");
    std::fs::write(folder.join("boat.toml"), spoilt).unwrap();
    let (_, errors) = seatrial(folder, 3, "trial --vehicle sim:boat.toml --yes");
    let expected = "rudder.limit_rad must be an angle from 0.001 to 1.5708 rad, not 14.9";
    assert!(errors.contains(expected), "{errors}");
}

/// A rudder that was logged as a fraction of full needs its angle.
#[test]
fn cli_a_rudder_in_fractions_of_full_needs_its_angle() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let schedule = "rudder_unit = \"full_rudder\"\n[[point]]\nsurge_speed_m_s = 1.0\na22_per_s = -1.0\nb2_per_s2 = 0.4\n";
    std::fs::write(folder.join("s.toml"), schedule).unwrap();
    for form in ["ros2", "c", "json", "px4"] {
        let (_, errors) = seatrial(folder, 2, &format!("gains --schedule s.toml --export {form}"));
        assert!(errors.contains("this file has angles"), "{errors}");
    }
    seatrial(folder, 0, "gains --schedule s.toml --export ardupilot");
    let (_, errors) = seatrial(folder, 2, "export --to vehicle --schedule s.toml");
    assert!(errors.contains("--full-steering-deg"), "{errors}");
    seatrial(
        folder,
        0,
        "export --to vehicle --schedule s.toml --full-steering-deg 28.64788975654116 --out v.toml",
    );
    let vehicle = IdentifiedVehicle::load(&folder.join("v.toml")).unwrap();
    // 28.6 degrees are half a rad.
    assert!((vehicle.speeds[0].b2_per_s2 - 0.8).abs() < 1e-12);
    assert!((vehicle.rudder.limit_rad - 0.5).abs() < 1e-12);
}
