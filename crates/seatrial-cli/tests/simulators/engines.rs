//! Targets whose engine runs here.

use std::path::Path;
use std::process::Command;

use seatrial_dev::{program, python_with, skip, text, unwrapped};

use super::{BOAT, Instant, ONE_SPEED, assert_alike, export, exported, script, zig_zag};

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
    plays(packages, target, "exported.py", BOAT);
}

/// The vehicle's export plays the zig-zag that ours does.
fn plays(packages: &str, target: &str, file: &str, vehicle: &str) {
    let Some(python) = python_with(packages) else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let ours = zig_zag(vehicle);
    export(folder, vehicle, target, file);
    write_commands(folder, &ours);
    let output = Command::new(python)
        .arg(script("play.py"))
        .args([target, file, "commands.csv"])
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

/// By FMPy, with the binary that the export compiled.
#[test]
fn val_fmpy_plays_the_same_zig_zag() {
    plays("fmpy,numpy", "fmu", "exported.fmu", BOAT);
    plays("fmpy,numpy", "fmu", "exported.fmu", ONE_SPEED);
}

/// FMPy's checker has no complaint, and the unit keeps to the rules of FMI that its checker does not see.
#[test]
fn val_fmpy_checks_the_unit() {
    let Some(python) = python_with("fmpy,numpy") else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    export(folder, BOAT, "fmu", "exported.fmu");
    let output = Command::new(python)
        .arg(script("check_fmu.py"))
        .arg("exported.fmu")
        .current_dir(folder)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
}

/// Without a C compiler the unit holds its source code only, and the command says so.
#[test]
fn cli_a_unit_without_a_compiler_is_source_code() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("boat.toml"), BOAT).unwrap();
    let export = |out: &[&str]| {
        program()
            .args(["export", "--to", "fmu", "--vehicle", "sim:boat.toml"])
            .args(out)
            .env("CC", "no-such-compiler")
            .current_dir(folder)
            .output()
            .unwrap()
    };
    let output = export(&["--out", "boat.fmu"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let said = unwrapped(&text(&output.stderr));
    assert!(said.contains("source code only"), "{said}");
    let unit = std::fs::read(folder.join("boat.fmu")).unwrap();
    let holds = |name: &str| unit.windows(name.len()).any(|at| at == name.as_bytes());
    assert!(holds("sources/vehicle.c") && !holds("binaries/"));
    let output = export(&[]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("--out FILE.fmu"));
}

#[test]
fn val_octave_plays_the_same_zig_zag() {
    if Command::new("octave-cli").arg("--version").output().is_err() {
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
