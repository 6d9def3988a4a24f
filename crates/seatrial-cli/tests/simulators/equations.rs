//! Targets that cannot run here: the parameters of the file in the equations of the target's source, written again.

use std::process::Command;

use seatrial_dev::{python_with, text};

use super::{BOAT, INTERVAL_S, ONE_SPEED, assert_alike, exported, script, zig_zag};

/// The number in an element.
fn element(sdf: &str, name: &str) -> f64 {
    let open = format!("<{name}>");
    let (_, after) = sdf
        .split_once(&open)
        .unwrap_or_else(|| panic!("{name}\n{sdf}"));
    after.split('<').next().unwrap().parse().unwrap()
}

/// The number that follows a text.
fn after(text: &str, before: &str) -> f64 {
    let (_, after) = text
        .split_once(before)
        .unwrap_or_else(|| panic!("{before}\n{text}"));
    let end = after.find([' ', '\n', ',']).unwrap_or(after.len());
    after[..end].parse().unwrap()
}

/// The rigid body of the link under the plugin's wrench, in its axes forward, port and up, in steps of 1 ms: gz-sim's
/// `buildDampingMatrix` with the derivatives that the file sets. Rudder and thrust act as the comment in the file says.
#[test]
fn val_gazebo_hydrodynamics_play_the_same_zig_zag() {
    let folder = tempfile::tempdir().unwrap();
    let sdf = exported(folder.path(), ONE_SPEED, "gazebo", "boat.sdf");
    let plugin = "<plugin filename=\"gz-sim-hydrodynamics-system\" name=\"gz::sim::systems::Hydrodynamics\">";
    assert!(
        sdf.contains(plugin) && sdf.contains("<link_name>base_link</link_name>"),
        "{sdf}"
    );
    let [mass, inertia] = ["mass", "izz"].map(|name| element(&sdf, name));
    let [n_r_abs_u, n_uu, y_v, x_u_abs_u, x_rr] =
        ["nRabsU", "nUU", "yV", "xUabsU", "xRR"].map(|name| element(&sdf, name));
    let rudder = after(&sdf, "N = ");
    let push = after(&sdf, "X = ");
    let steady_per_thrust = 1.9 / 0.9;
    let ours = zig_zag(ONE_SPEED);
    let [mut u, mut v, mut r, mut yaw] = [1.9, 0.0, 0.0, 0.0];
    let theirs: Vec<[f64; 2]> = ours
        .iter()
        .map(|at| {
            let before = [-yaw, u];
            let steady: f64 = steady_per_thrust * at.thrust;
            let steps = 50;
            let h = INTERVAL_S / f64::from(steps);
            for _ in 0..steps {
                let x = x_u_abs_u * u * f64::abs(u) + x_rr * r * r + push * steady * steady.abs();
                let y = y_v * v;
                let n = n_r_abs_u * r * f64::abs(u)
                    + n_uu * u * u
                    + rudder * u * f64::abs(u) * at.rudder_rad;
                let (du, dv, dr) = (x / mass + v * r, y / mass - u * r, n / inertia);
                u += h * du;
                v += h * dv;
                r += h * dr;
                yaw += h * r;
            }
            before
        })
        .collect();
    assert_alike("gazebo", &ours, &theirs);
}

/// The file keeps to SDFormat 1.9, whatever the vehicle is called.
#[test]
fn val_gazebo_files_keep_to_sdformat() {
    let Some(python) = python_with("xml.etree.ElementTree") else {
        return;
    };
    for name in [
        "one speed",
        "world",
        "__boat__",
        "a::b",
        "<&>\\\" --> x",
        "Bjørn",
    ] {
        let folder = tempfile::tempdir().unwrap();
        let vehicle = ONE_SPEED.replace("one speed", name);
        exported(folder.path(), &vehicle, "gazebo", "boat.sdf");
        let output = Command::new(&python)
            .arg(script("check_sdf.py"))
            .arg("boat.sdf")
            .current_dir(folder.path())
            .output()
            .unwrap();
        assert!(output.status.success(), "{name}: {}", text(&output.stderr));
    }
}

/// uSimMarine's `SimEngine`: what it turns at and goes at in the steady state, which is all it carries.
#[test]
fn val_moos_turns_and_goes_as_the_vehicle_does_steadily() {
    let folder = tempfile::tempdir().unwrap();
    let block = exported(folder.path(), BOAT, "moos", "boat.moos");
    assert!(block.contains("ProcessConfig = uSimMarine\n{"), "{block}");
    let turn_rate = after(&block, "turn_rate = ");
    assert!(
        (0.0..=100.0).contains(&turn_rate),
        "uSimMarine clips it there: {turn_rate}"
    );
    let (thrust_percent, rudder_percent) = (90.0, 100.0);
    // SimEngine::propagateHeading: rudder/100 of the turn rate, times 1 + (thrust - 50)/50.
    let deg_s = rudder_percent * (turn_rate / 100.0) * (1.0 + (thrust_percent - 50.0) / 50.0);
    // (b2 delta + C0)/a22 to either side, whose mean has no C0.
    let expected = (1.6 * 0.5 / 1.3_f64).to_degrees();
    assert!((deg_s / expected - 1.0).abs() < 1e-9, "{deg_s} {expected}");
    assert!(
        block.contains("thrust_map = 0:0, 50.0:1.0, 90.0:1.9\n"),
        "{block}"
    );
    assert!(block.contains("uSimMarine turns at once"), "{block}");
}

/// Nav2's limits keep within a turn under full rudder to the weaker side.
#[test]
fn val_nav2_limits_are_those_of_the_weaker_side() {
    let folder = tempfile::tempdir().unwrap();
    let yaml = exported(folder.path(), BOAT, "nav2", "boat.yaml");
    let weaker = (1.6 * 0.5 - 0.005) / 1.3;
    // The closed form against the export's own: rounding.
    let is = |found: f64, expected: f64| (found / expected - 1.0).abs() < 1e-9;
    assert!(is(after(&yaml, "wz_max: "), weaker), "{yaml}");
    assert!(is(after(&yaml, "az_max: "), 1.3 * weaker), "{yaml}");
    assert!(is(after(&yaml, "min_turning_r: "), 1.9 / weaker), "{yaml}");
    assert!(
        is(after(&yaml, "minimum_turning_radius: "), 1.9 / weaker),
        "{yaml}"
    );
    assert!(is(after(&yaml, "vx_max: "), 1.9), "{yaml}");
    for key in [
        "controller_server:",
        "velocity_smoother:",
        "planner_server:",
        "AckermannConstraints:",
    ] {
        assert!(yaml.contains(key), "{key}\n{yaml}");
    }
}

/// The guidance file: a vehicle on its Dubins circle, and a turn by 90 degrees that begins a waypoint radius before the corner.
#[test]
fn exact_guidance_says_where_a_turn_begins() {
    let folder = tempfile::tempdir().unwrap();
    let guidance = exported(folder.path(), BOAT, "guidance", "boat.toml.guidance");
    let table: toml::Table = toml::from_str(&guidance).unwrap();
    let speed = &table["speed"].as_array().unwrap()[1];
    let number = |name: &str| speed[name].as_float().unwrap();
    let starboard = (1.6 * 0.5 + 0.005) / 1.3;
    assert!((number("yaw_rate_starboard_rad_s") / starboard - 1.0).abs() < 1e-9);
    assert!((number("turning_radius_starboard_m") * starboard / 1.9 - 1.0).abs() < 1e-9);
    // A turn by 90 degrees of the vehicle itself, at constant speed, in steps of 1 ms: the corner lies as far ahead of where the rudder is
    // ordered as the track then runs beside the new leg.
    let vehicle = seatrial_sim::IdentifiedVehicle::from_toml(
        &BOAT.replace("turning_drag_m = 0.5", "turning_drag_m = 0.0"),
    )
    .unwrap();
    let mut plant = vehicle.plant(0.9);
    while plant.yaw.heading_rad > -std::f64::consts::FRAC_PI_2 {
        plant.advance(-0.5, 0.9, 0.0, 0.001);
    }
    let needed_m = plant.position_m[0];
    let exported_m = number("waypoint_radius_m");
    // The turn still builds up at its end, and the rudder's rate limit is not counted: within a tenth.
    assert!(
        (exported_m / needed_m - 1.0).abs() < 0.1,
        "{exported_m} {needed_m}"
    );
    assert!(number("lookahead_m") > number("turning_radius_port_m"));
}
