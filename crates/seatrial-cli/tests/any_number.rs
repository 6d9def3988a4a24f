//! No number in any field of a file that people write ends the program: it is refused by name, or used. Vehicles, scenarios and
//! plans are tried in `crates/seatrial-sim/tests/any_number.rs`, vehicles on ROS 2 in `crates/seatrial-links/tests/any_number.rs`.

use std::path::Path;

use seatrial_dev::{program, text, with_any_number};
use toml::Table;

/// Runs the verb with each of the files: how many were used and how many refused.
fn counted(folder: &Path, file: &str, contents: &str, verb: &[&str]) -> (usize, usize) {
    let (mut used, mut refused) = (0, 0);
    let table: Table = contents.parse().unwrap();
    for table in with_any_number(&table) {
        let written = toml::to_string(&table).unwrap();
        std::fs::write(folder.join(file), &written).unwrap();
        let output = program().args(verb).current_dir(folder).output().unwrap();
        let said = text(&output.stderr);
        assert!(!said.contains("panicked"), "{verb:?}: {said}\n{written}");
        match output.status.code() {
            Some(0 | 4 | 5) => used += 1,
            Some(2 | 3) => {
                refused += 1;
                assert!(said.len() > 20, "{verb:?}: {said}\n{written}");
            }
            other => panic!("{verb:?}: {other:?}: {said}\n{written}"),
        }
    }
    (used, refused)
}

fn csv() -> String {
    let rows = (0..200).map(|k: u32| {
        let rudder_deg = if k.is_multiple_of(40) { 10 } else { -10 };
        format!("{},{},{rudder_deg},1.2\n", 0.05 * f64::from(k), k % 360)
    });
    ["t,psi,delta,u\n".into()].into_iter().chain(rows).collect()
}

#[test]
fn prop_any_number_in_a_file_of_channels() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("run.csv"), csv()).unwrap();
    let channels = "
        [channels.heading]
        column = 'psi'
        unit = 'deg'
        scale = 1.0
        offset = 0.5
        [channels.rudder]
        column = 'delta'
        unit = 'fraction'
        full_deg = 30.0
        scale = 0.1
        offset = 0.0
        [channels.surge_speed]
        column = 'u'
        scale = 1.0
    ";
    for verb in ["inspect", "identify"] {
        let (used, refused) = counted(
            folder.path(),
            "channels.toml",
            channels,
            &[verb, "run.csv", "--channels", "channels.toml", "--json"],
        );
        assert!(used + refused > 70 && refused > 20, "{used} {refused}");
    }
}

#[test]
fn prop_any_number_in_a_schedule_file() {
    let folder = tempfile::tempdir().unwrap();
    let schedule = "
        rudder_limit_rad = 0.26
        full_rudder_rad = 0.35
        [[point]]
        thrust = 0.6
        surge_speed_m_s = 1.07
        a22_per_s = -0.95
        b2_per_s2 = 0.60
        c0_rad_per_s2 = 0.0072
        [[point]]
        thrust = 0.8
        surge_speed_m_s = 1.6
        a22_per_s = -1.07
        b2_per_s2 = 1.08
        c0_rad_per_s2 = 0.012
    ";
    for verb in [
        &["turn", "--schedule", "schedule.toml"][..],
        &["turn", "--schedule", "schedule.toml", "--up-to-speed", "3", "--json"],
        &["gains", "--schedule", "schedule.toml"],
        &["gains", "--schedule", "schedule.toml", "--export", "ardupilot"],
    ] {
        let (used, refused) = counted(folder.path(), "schedule.toml", schedule, verb);
        assert!(used + refused > 150 && refused > 10, "{verb:?}: {used} {refused}");
    }
}

#[test]
fn prop_any_number_in_a_plan_of_a_pitch_trial() {
    let folder = tempfile::tempdir().unwrap();
    let pitch = seatrial_core::Plan::<f64>::pitch();
    let plan = seatrial_core::Plan {
        thrusts: seatrial_core::List::from_slice(&[0.6]).unwrap(),
        settle: seatrial_core::Settle { at_least_s: 10.0, at_most_s: 10.0, ..pitch.settle },
        ..pitch
    };
    let plan = toml::to_string(&plan).unwrap();
    let verb = [
        "trial",
        "--axis",
        "pitch",
        "--vehicle",
        "sim:starfish-6dof",
        "--plan",
        "plan.toml",
        "--yes",
    ];
    let (used, refused) = counted(folder.path(), "plan.toml", &plan, &verb);
    assert!(used > 5 && refused > 20, "{used} {refused}");
}
