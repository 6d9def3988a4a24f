//! A file that somebody mistyped is refused in words or used: through the whole program, with the exit code of its kind. Vehicles,
//! scenarios and plans are tried in `crates/seatrial-sim/tests/damaged_text.rs`.

use std::path::Path;

use seatrial_dev::{Damage, damaged_copies, program, text};

/// Damaged copies of each text.
const OF_EACH: u64 = 60;

/// Each damaged copy through the verb; how many were used and how many refused.
fn try_all(folder: &Path, file: &str, contents: &str, verb: &[&str], first_seed: u64) {
    let (mut used, mut refused) = (0, 0);
    for copy in 0..damaged_copies(OF_EACH) {
        let written = Damage::new(first_seed + copy).of(contents.as_bytes());
        std::fs::write(folder.join(file), &written).unwrap();
        let output = program().args(verb).current_dir(folder).output().unwrap();
        let said = text(&output.stderr);
        let shown = String::from_utf8_lossy(&written);
        match output.status.code() {
            Some(0 | 4 | 5) => used += 1,
            Some(2 | 3) => {
                refused += 1;
                assert!(said.len() > 20, "{verb:?}: {said}\n{shown}");
                let is_plain = |c: char| matches!(c, '\n' | '\t') || !c.is_control();
                assert!(said.chars().all(is_plain), "{verb:?}: {said:?}");
            }
            other => panic!("{verb:?}, seed {}: {other:?}: {said}\n{shown}", first_seed + copy),
        }
    }
    assert!(refused > 0 && used > 0, "{verb:?}: {used} {refused}");
}

fn csv() -> String {
    let rows = (0..200).map(|k: u32| {
        let rudder_deg = if k.is_multiple_of(40) { 10 } else { -10 };
        format!("{},{},{rudder_deg},1.2\n", 0.05 * f64::from(k), k % 360)
    });
    ["t,psi,delta,u\n".into()].into_iter().chain(rows).collect()
}

#[test]
fn prop_no_damaged_file_of_channels_ends_the_program() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("run.csv"), csv()).unwrap();
    let channels = "[channels.heading]\ncolumn = 'psi'\nunit = 'deg'\n[channels.rudder]\ncolumn = 'delta'\nunit = 'deg'\nscale = 0.1\n";
    let verb = ["inspect", "run.csv", "--channels", "channels.toml"];
    try_all(folder.path(), "channels.toml", channels, &verb, 1 << 40);
}

#[test]
fn prop_no_damaged_schedule_ends_the_program() {
    let folder = tempfile::tempdir().unwrap();
    let schedule = "rudder_limit_rad = 0.26\nfull_rudder_rad = 0.35\n[[point]]\nthrust = 0.6\nsurge_speed_m_s = 1.07\n\
                    a22_per_s = -0.95\nb2_per_s2 = 0.60\nc0_rad_per_s2 = 0.0072\n[[point]]\nthrust = 0.8\nsurge_speed_m_s = 1.6\n\
                    a22_per_s = -1.07\nb2_per_s2 = 1.08\nc0_rad_per_s2 = 0.012\n";
    let verb = ["gains", "--schedule", "schedule.toml"];
    try_all(folder.path(), "schedule.toml", schedule, &verb, 2 << 40);
}

#[test]
fn prop_no_damaged_document_of_a_model_ends_the_program() {
    let folder = tempfile::tempdir().unwrap();
    let rows = (0..1400).map(|k: u32| {
        let time_s = 0.05 * f64::from(k);
        let rudder_rad = if k % 120 < 60 { 0.26 } else { -0.26 };
        format!("{time_s:.2},{:.5},{rudder_rad}\n", 0.4 * (0.6 * time_s).sin())
    });
    let log: String = ["time_s,heading_rad,rudder_rad\n".into()].into_iter().chain(rows).collect();
    std::fs::write(folder.path().join("run.csv"), log).unwrap();
    let identify = ["identify", "run.csv", "--from", "0", "--to", "40", "--json"];
    let output = program().args(identify).current_dir(folder.path()).output().unwrap();
    let document = text(&output.stdout);
    assert!(document.contains("\"verdict\""), "{document}");
    let verb = ["validate", "run.csv", "--model", "model.json"];
    try_all(folder.path(), "model.json", &document, &verb, 3 << 40);
}

#[test]
fn prop_no_damaged_plan_of_a_pitch_trial_ends_the_program() {
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
    try_all(folder.path(), "plan.toml", &plan, &verb, 4 << 40);
}
