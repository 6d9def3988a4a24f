//! Exported vehicles in the engines that they are for: one zig-zag with a change of speed, by ours and by theirs.

mod engines;
mod equations;

use std::path::{Path, PathBuf};

use seatrial_dev::{run_in, text};
use seatrial_sim::IdentifiedVehicle;

/// Two speeds, a lag, a dead time, a rate limit, an offset, and drag that grows with the square of the speed.
const BOAT: &str = r#"
schema = "seatrial.vehicle.v1"
name = "test boat"

[rudder]
limit_rad = 0.5
lag_s = 0.15
delay_s = 0.2
rate_limit_rad_s = 0.8

[surge]
time_constant_s = 2.5
drag_length_m = 8.0
turning_drag_m = 0.5

[[speed]]
thrust = 0.5
surge_speed_m_s = 1.0
a22_per_s = -1.0
b2_per_s2 = 0.7
c0_rad_per_s2 = 0.01

[[speed]]
thrust = 0.9
surge_speed_m_s = 1.9
a22_per_s = -1.3
b2_per_s2 = 1.6
c0_rad_per_s2 = 0.005
"#;

/// What one speed can carry: a22 that grows with the speed, b2 and C0 with its square, no lag.
const ONE_SPEED: &str = r#"
schema = "seatrial.vehicle.v1"
name = "one speed"

[rudder]
limit_rad = 0.5

[surge]
time_constant_s = 2.5
drag_length_m = 8.0
turning_drag_m = 0.5

[[speed]]
thrust = 0.9
surge_speed_m_s = 1.9
a22_per_s = -1.3
b2_per_s2 = 1.6
c0_rad_per_s2 = 0.005
"#;

const INTERVAL_S: f64 = 0.05;
const COUNT: usize = 1600;

/// Rudder and thrust from an instant on, and heading and speed at it.
#[derive(Clone, Copy)]
struct Instant {
    time_s: f64,
    rudder_rad: f64,
    thrust: f64,
    heading_rad: f64,
    surge_speed_m_s: f64,
}

/// A zig-zag of 20 degrees by our simulator, at the fastest thrust and from half the time on at the least.
fn zig_zag(file: &str) -> Vec<Instant> {
    let vehicle = IdentifiedVehicle::from_toml(file).unwrap();
    let angle_rad = 20_f64.to_radians();
    let [slow, fast] = [0.5, 0.9];
    let mut plant = vehicle.plant(fast);
    let mut side = 1.0;
    (0..COUNT)
        .map(|k| {
            if side * plant.yaw.heading_rad >= angle_rad {
                side = -side;
            }
            let instant = Instant {
                time_s: k as f64 * INTERVAL_S,
                rudder_rad: side * angle_rad,
                thrust: if k < COUNT / 2 { fast } else { slow },
                heading_rad: plant.yaw.heading_rad,
                surge_speed_m_s: plant.surge_speed_m_s,
            };
            plant.advance(instant.rudder_rad, instant.thrust, 0.0, INTERVAL_S);
            instant
        })
        .collect()
}

/// Writes a vehicle and what it is exported to, and returns that, a text.
fn exported(folder: &Path, vehicle: &str, target: &str, file: &str) -> String {
    export(folder, vehicle, target, file);
    std::fs::read_to_string(folder.join(file)).unwrap()
}

/// Writes a vehicle and what it is exported to.
fn export(folder: &Path, vehicle: &str, target: &str, file: &str) {
    std::fs::write(folder.join("boat.toml"), vehicle).unwrap();
    let output =
        run_in(folder, &["export", "--to", target, "--vehicle", "sim:boat.toml", "--out", file]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
}

/// A program beside this test.
fn script(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/simulators").join(name)
}

/// Heading and speed agree within 1 % rms of what they change by.
fn assert_alike(what: &str, ours: &[Instant], theirs: &[[f64; 2]]) {
    assert_eq!(ours.len(), theirs.len(), "{what}");
    let rms = |of: &dyn Fn(&Instant, &[f64; 2]) -> f64| {
        let squares: f64 = ours.iter().zip(theirs).map(|(a, b)| of(a, b).powi(2)).sum();
        (squares / ours.len() as f64).sqrt()
    };
    let heading = rms(&|a, b| a.heading_rad - b[0]) / rms(&|a, _| a.heading_rad);
    let speed = rms(&|a, b| a.surge_speed_m_s - b[1]) / rms(&|a, _| a.surge_speed_m_s);
    println!("{what}: heading {:.4} %, speed {:.4} % rms", 100.0 * heading, 100.0 * speed);
    assert!(heading < 0.01 && speed < 0.01, "{what}: heading {heading}, speed {speed}");
}

#[test]
fn cli_drawn_vehicles_differ_and_a_vehicle_without_covariance_draws_none() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let covariance = "covariance = [[0.0025, 0.0, 0.0], [0.0, 0.0025, 0.0], [0.0, 0.0, 1e-6]]\n";
    std::fs::write(folder.join("boat.toml"), format!("{ONE_SPEED}{covariance}")).unwrap();
    let arguments = "export --to vehicle --vehicle sim:boat.toml --sample 12 --out drawn";
    let arguments: Vec<&str> = arguments.split(' ').collect();
    let output = run_in(folder, &arguments);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let a22 = |number: u32| {
        let path = folder.join(format!("drawn/vehicle-{number:02}.toml"));
        IdentifiedVehicle::load(&path).unwrap().speeds[0].a22_per_s
    };
    let mut drawn: Vec<f64> = (1..=12).map(a22).collect();
    drawn.sort_by(f64::total_cmp);
    drawn.dedup();
    assert_eq!(drawn.len(), 12);
    // The standard deviation is 0.05: six of them.
    assert!(drawn.iter().all(|a22| (a22 + 1.3).abs() < 0.3), "{drawn:?}");
    std::fs::write(folder.join("boat.toml"), ONE_SPEED).unwrap();
    let output = run_in(folder, &arguments);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("no covariance"));
}
