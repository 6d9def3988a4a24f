//! Targets whose engine runs here.

use std::path::Path;
use std::process::Command;

use seatrial_dev::{python_with, skip, text};

use super::{BOAT, Instant, assert_alike, exported, zig_zag};

fn write_commands(folder: &Path, ours: &[Instant]) {
    let rows: Vec<String> = ours
        .iter()
        .map(|at| format!("{:?},{:?},{:?}", at.time_s, at.rudder_rad, at.thrust))
        .collect();
    std::fs::write(folder.join("commands.csv"), rows.join("\n") + "\n").unwrap();
}

/// Rows of numbers.
fn rows<const N: usize>(said: &str) -> Vec<[f64; N]> {
    let row = |line: &str| {
        let numbers: Vec<f64> = line.split(',').map(|x| x.trim().parse().unwrap()).collect();
        numbers.try_into().unwrap()
    };
    said.lines().map(row).collect()
}

fn python(packages: &str, target: &str) {
    let Some(python) = python_with(packages) else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let ours = zig_zag(BOAT);
    exported(folder, BOAT, target, "exported.py");
    write_commands(folder, &ours);
    let play = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/simulators/play.py");
    let output = Command::new(python)
        .arg(play)
        .args([target, "exported.py", "commands.csv"])
        .current_dir(folder)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert_alike(target, &ours, &rows(&text(&output.stdout)));
}

#[test]
fn val_numpy_plays_the_same_zig_zag() {
    python("numpy", "python");
}

#[test]
fn val_casadi_plays_the_same_zig_zag() {
    python("casadi,numpy", "casadi");
}

#[test]
fn val_mujoco_plays_the_same_zig_zag() {
    python("mujoco,numpy", "mujoco");
}

#[test]
fn val_octave_plays_the_same_zig_zag() {
    if Command::new("octave-cli")
        .arg("--version")
        .output()
        .is_err()
    {
        skip("no octave-cli");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let ours = zig_zag(BOAT);
    exported(folder, BOAT, "octave", "exported.m");
    write_commands(folder, &ours);
    let script = "source('exported.m'); c = csvread('commands.csv'); p = vehicle_parameters(); \
                  s = vehicle_run(p, c(:, 1), c(:, 2), c(:, 3), 0); printf('%.17g,%.17g\\n', s(:, 3:4)');";
    let output = Command::new("octave-cli")
        .args(["--norc", "--no-gui", "--eval", script])
        .current_dir(folder)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert_alike("octave", &ours, &rows(&text(&output.stdout)));
}
