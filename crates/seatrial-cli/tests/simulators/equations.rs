//! Targets that cannot run here: the parameters of the file in the equations of the target's source, written again.

use std::process::Command;

use seatrial_dev::{python_with, text};

use super::{BOAT, INTERVAL_S, ONE_SPEED, assert_alike, exported, script, zig_zag};

/// The number in an element.
fn element(sdf: &str, name: &str) -> f64 {
    let open = format!("<{name}>");
    let (_, after) = sdf.split_once(&open).unwrap_or_else(|| panic!("{name}\n{sdf}"));
    after.split('<').next().unwrap().parse().unwrap()
}

/// The number that follows a text.
fn after(text: &str, before: &str) -> f64 {
    let (_, after) = text.split_once(before).unwrap_or_else(|| panic!("{before}\n{text}"));
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
    assert!(sdf.contains(plugin) && sdf.contains("<link_name>base_link</link_name>"), "{sdf}");
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
    for name in ["one speed", "world", "__boat__", "a::b", "<&>\\\" --> x", "Bjørn"] {
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
    assert!((0.0..=100.0).contains(&turn_rate), "uSimMarine clips it there: {turn_rate}");
    let (thrust_percent, rudder_percent) = (90.0, 100.0);
    // SimEngine::propagateHeading: rudder/100 of the turn rate, times 1 + (thrust - 50)/50.
    let deg_s = rudder_percent * (turn_rate / 100.0) * (1.0 + (thrust_percent - 50.0) / 50.0);
    // (b2 delta + C0)/a22 to either side, whose mean has no C0.
    let expected = (1.6 * 0.5 / 1.3_f64).to_degrees();
    assert!((deg_s / expected - 1.0).abs() < 1e-9, "{deg_s} {expected}");
    assert!(block.contains("thrust_map = 0:0, 50.0:1.0, 90.0:1.9\n"), "{block}");
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
    assert!(is(after(&yaml, "minimum_turning_radius: "), 1.9 / weaker), "{yaml}");
    assert!(is(after(&yaml, "vx_max: "), 1.9), "{yaml}");
    for key in [
        "controller_server:",
        "velocity_smoother:",
        "planner_server:",
        "AckermannConstraints:",
        // Slowing down is always allowed.
        "vx_min: 0.0",
        "min_velocity: [0.0, 0.0",
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
    assert!((exported_m / needed_m - 1.0).abs() < 0.1, "{exported_m} {needed_m}");
    assert!(number("lookahead_m") > number("turning_radius_port_m"));
}

/// What the parameters of `ros2_controllers` are, by the YAML that generates them: `pid_controller/src/pid_controller.yaml`,
/// `diff_drive_controller/src/diff_drive_controller_parameter.yaml` and `tricycle_controller/src/tricycle_controller_parameter.yaml`.
const ROS2_CONTROLLERS: &[(&str, &[(&str, char)])] = &[
    ("heading_controller", PID),
    ("yaw_rate_controller", PID),
    (
        "diff_drive_controller",
        &[
            ("linear.x.max_velocity", '+'),
            ("linear.x.min_velocity", '-'),
            ("linear.x.max_acceleration", '+'),
            ("linear.x.max_deceleration", '-'),
            ("angular.z.max_velocity", '+'),
            ("angular.z.min_velocity", '-'),
            ("angular.z.max_acceleration", '+'),
            ("angular.z.max_deceleration", '-'),
            ("angular.z.max_acceleration_reverse", '-'),
            ("angular.z.max_deceleration_reverse", '+'),
        ],
    ),
    (
        "tricycle_controller",
        &[
            ("traction_joint_name", 's'),
            ("steering_joint_name", 's'),
            ("wheelbase", '+'),
            ("wheel_radius", '+'),
            ("traction.max_velocity", '+'),
            ("traction.max_acceleration", '+'),
            ("traction.max_deceleration", '+'),
            ("steering.max_position", '+'),
            ("steering.max_velocity", '+'),
        ],
    ),
];

/// `gains` is a map of the names of `dof_names`. Types: s string, a list of strings, b bool, d double, + and - doubles that may not lie
/// beyond 0 on the other side.
const PID: &[(&str, char)] = &[
    ("dof_names", 'a'),
    ("command_interface", 's'),
    ("reference_and_state_dof_names", 'a'),
    ("reference_and_state_interfaces", 'a'),
    ("gains.rudder_joint.p", 'd'),
    ("gains.rudder_joint.i", 'd'),
    ("gains.rudder_joint.d", 'd'),
    ("gains.rudder_joint.u_clamp_max", 'd'),
    ("gains.rudder_joint.u_clamp_min", 'd'),
    ("gains.rudder_joint.i_clamp_max", 'd'),
    ("gains.rudder_joint.i_clamp_min", 'd'),
    ("gains.rudder_joint.antiwindup_strategy", 's'),
    ("gains.rudder_joint.angle_wraparound", 'b'),
];

/// The values of YAML whose maps are in blocks of two spaces, by their paths.
fn leaves(yaml: &str) -> Vec<(String, String)> {
    let mut path: Vec<&str> = Vec::new();
    let mut found = Vec::new();
    for line in yaml.lines().filter(|line| !line.starts_with('#')) {
        let depth = (line.len() - line.trim_start().len()) / 2;
        let (key, value) = line.trim().split_once(':').unwrap();
        path.truncate(depth);
        path.push(key);
        if !value.is_empty() {
            found.push((path.join("."), value.trim().to_owned()));
        }
    }
    found
}

fn is_of_type(value: &str, kind: char) -> bool {
    let is_text = |text: &str| text.len() > 2 && text.starts_with('"') && text.ends_with('"');
    // A double of a ROS 2 parameter file has a point: 1 is an integer, and refused.
    let double = value.parse().ok().filter(|x: &f64| x.is_finite() && value.contains('.'));
    match kind {
        's' => is_text(value),
        'a' => is_text(value.trim_start_matches('[').trim_end_matches(']')),
        'b' => value == "true" || value == "false",
        '+' => double.is_some_and(|x| x >= 0.0),
        '-' => double.is_some_and(|x| x <= 0.0),
        _ => double.is_some(),
    }
}

#[test]
fn val_ros2_controllers_know_every_parameter() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["test boat", "\\\": [#\\n boat"] {
        let file = BOAT.replace("test boat", name);
        let yaml = exported(folder.path(), &file, "ros2_control", "boat.yaml");
        let leaves = leaves(&yaml);
        let manager: Vec<&(String, String)> =
            leaves.iter().filter(|(path, _)| path.starts_with("controller_manager.")).collect();
        assert_eq!(manager.len(), 5, "{yaml}");
        assert_eq!(manager[0].1, "20", "an integer, Hz");
        for (controller, known) in ROS2_CONTROLLERS {
            let prefix = format!("{controller}.ros__parameters.");
            let set: Vec<(&str, &str)> = leaves
                .iter()
                .filter_map(|(path, value)| Some((path.strip_prefix(&prefix)?, value.as_str())))
                .collect();
            assert_eq!(set.len(), known.len(), "{controller}\n{yaml}");
            for (name, value) in set {
                let kind = known.iter().find(|(known, _)| *known == name);
                let (_, kind) = kind.unwrap_or_else(|| panic!("{controller}.{name}"));
                assert!(is_of_type(value, *kind), "{controller}.{name}: {value}");
            }
        }
    }
}

/// Gains and limits against the closed form, with the signs of REP-103.
#[test]
fn val_ros2_control_has_the_gains_and_limits_of_the_model() {
    let folder = tempfile::tempdir().unwrap();
    let yaml = exported(folder.path(), BOAT, "ros2_control", "boat.yaml");
    let leaves = leaves(&yaml);
    let number = |path: &str| -> f64 {
        let full = path.replacen('.', ".ros__parameters.", 1);
        let found = leaves.iter().find(|(known, _)| *known == full);
        found.unwrap_or_else(|| panic!("{path}\n{yaml}")).1.parse().unwrap()
    };
    // Rounding.
    let is = |path: &str, expected: f64| {
        let found = number(path);
        assert!((found / expected - 1.0).abs() < 1e-9, "{path} {found} {expected}");
    };
    let (a, b, c, limit, speed): (f64, f64, f64, f64, f64) = (1.3, 1.6, 0.005, 0.5, 1.9);
    let (late_s, interval_s) = (0.15 + 0.2, 0.05);
    // The loop of the heading crosses 1 at omega: p b = omega sqrt(omega^2 + a^2), with the phase margin of a damping ratio of 1/sqrt(2).
    let p = number("heading_controller.gains.rudder_joint.p");
    let omega = (0.5 * ((a.powi(4) + 4.0 * (p * b).powi(2)).sqrt() - a * a)).sqrt();
    let margin = (a / omega).atan() - omega * (late_s + 0.5 * interval_s);
    let root_2 = 2.0_f64.sqrt();
    // The export solves it by iteration.
    assert!((margin - (root_2 / (root_2 - 1.0).sqrt()).atan()).abs() < 1e-6, "{margin}");
    let rate = "yaw_rate_controller.gains.rudder_joint";
    let gain = 1.0 / (b * (1.0 / a + late_s + 0.5 * interval_s));
    is(&format!("{rate}.p"), gain);
    is(&format!("{rate}.i"), gain * a);
    is(&format!("{rate}.u_clamp_max"), limit);
    let (port, starboard) = ((b * limit - c) / a, (b * limit + c) / a);
    is("diff_drive_controller.angular.z.max_velocity", port);
    is("diff_drive_controller.angular.z.min_velocity", -starboard);
    is("diff_drive_controller.angular.z.max_acceleration", a * port);
    is("diff_drive_controller.angular.z.max_acceleration_reverse", -a * starboard);
    is("diff_drive_controller.linear.x.max_velocity", speed);
    // u' = u^2/l at the full speed without thrust, half of it for a time constant l/(2u).
    is("diff_drive_controller.linear.x.max_acceleration", speed * speed / 8.0);
    // tricycle_controller: yaw rate = u tan(rudder)/wheelbase; a small rudder turns as the model does.
    let wheelbase = number("tricycle_controller.wheelbase");
    assert!((speed * 0.001_f64.tan() / wheelbase / (b * 0.001 / a) - 1.0).abs() < 1e-6);
    is("tricycle_controller.steering.max_position", limit);
    is("tricycle_controller.steering.max_velocity", 0.8);
    is("tricycle_controller.traction.max_velocity", speed);
    assert!(yaml.contains("rudder_joint is minus the rudder"), "{yaml}");
    assert!(yaml.contains("Not carried: the lag of the yaw rate"), "{yaml}");
    for (reversed, said) in [
        (BOAT.replace("b2_per_s2 = ", "b2_per_s2 = -"), "rudder_joint is equal to the rudder"),
        (BOAT.replace("c0_rad_per_s2 = 0.005", "c0_rad_per_s2 = 0.0"), "rudder_joint is minus"),
    ] {
        let other = exported(folder.path(), &reversed, "ros2_control", "other.yaml");
        assert!(other.contains(said), "{other}");
    }
}

/// `pid_controller` with the gains of the file steers the vehicle: the yaw rate is reached without a lasting error in spite of the
/// offset, the heading with little overshoot.
#[test]
fn val_ros2_control_gains_steer_the_vehicle() {
    let folder = tempfile::tempdir().unwrap();
    let yaml = exported(folder.path(), BOAT, "ros2_control", "boat.yaml");
    let vehicle = seatrial_sim::IdentifiedVehicle::from_toml(BOAT).unwrap();
    let gains = |controller: &str| {
        let (_, part) = yaml.split_once(&format!("\n{controller}:\n")).unwrap();
        ["p: ", "i: "].map(|name| after(part, &format!("  {name}")))
    };
    // Positive to port, as the file says: the heading's and the rudder's sign turn round.
    let play = |controller: &str, wanted: f64, measured: fn(&seatrial_sim::plant::Plant) -> f64| {
        let [p, i] = gains(controller);
        let mut plant = vehicle.plant(0.9);
        let mut integral = 0.0;
        (0..600)
            .map(|_| {
                let error = wanted - measured(&plant);
                let unlimited = p * error + i * integral;
                let joint = unlimited.clamp(-0.5, 0.5);
                if joint == unlimited {
                    integral += error * INTERVAL_S;
                }
                plant.advance(-joint, 0.9, 0.0, INTERVAL_S);
                measured(&plant)
            })
            .collect::<Vec<f64>>()
    };
    let rates = play("yaw_rate_controller", 0.2, |plant| -plant.yaw.yaw_rate_rad_s);
    assert!((rates[599] / 0.2 - 1.0).abs() < 0.01, "{}", rates[599]);
    let headings = play("heading_controller", 0.3, |plant| -plant.yaw.heading_rad);
    let most = headings.iter().copied().fold(0.0, f64::max);
    // A damping ratio of 0.7 overshoots by 4 %; the offset of 0.003 rad of rudder moves the end by less than 0.02 rad.
    assert!(most < 0.3 * 1.08 && (headings[599] - 0.3).abs() < 0.02, "{most} {}", headings[599]);
}

#[test]
fn val_ros2_control_joints_are_those_of_the_yaml() {
    let folder = tempfile::tempdir().unwrap();
    let urdf = exported(folder.path(), BOAT, "ros2_control-urdf", "boat.urdf");
    for part in [
        "<ros2_control name=\"test boat\" type=\"system\">",
        "<plugin>mock_components/GenericSystem</plugin>",
        "<joint name=\"rudder_joint\">",
        "<param name=\"min\">-0.5</param>",
        "<param name=\"max\">0.5</param>",
        "<param name=\"max\">1.9</param>",
        "<sensor name=\"heading\">",
    ] {
        assert!(urdf.contains(part), "{part}\n{urdf}");
    }
    let Some(python) = python_with("xml.etree.ElementTree") else {
        return;
    };
    for name in ["a--b", "<&>\\\" --> x", "Bjørn"] {
        let vehicle = BOAT.replace("test boat", name);
        exported(folder.path(), &vehicle, "ros2_control-urdf", "boat.urdf");
        let parse = "import sys, xml.etree.ElementTree as e\nassert e.parse(sys.argv[1]).getroot().tag == 'ros2_control'";
        let output = Command::new(&python)
            .args(["-c", parse, "boat.urdf"])
            .current_dir(folder.path())
            .output()
            .unwrap();
        assert!(output.status.success(), "{name}: {}", text(&output.stderr));
    }
}
