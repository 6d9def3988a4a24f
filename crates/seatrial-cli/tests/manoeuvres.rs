//! `seatrial sim manoeuvres` at the process boundary.

use seatrial_dev::program;

#[test]
fn cli_manoeuvres_are_written() {
    let folder = tempfile::tempdir().unwrap();
    let run = program()
        .args(["sim", "manoeuvres", "--thrust", "0.8", "--json", "--out"])
        .arg(folder.path())
        .output()
        .unwrap();
    assert!(run.status.success(), "{run:?}");
    let document: serde_json::Value = serde_json::from_slice(&run.stdout).unwrap();
    let manoeuvres = document["manoeuvres"].as_array().unwrap();
    assert_eq!(manoeuvres.len(), 1);
    assert_eq!(manoeuvres[0]["zig_zags"].as_array().unwrap().len(), 2);
    // Thirteen angles and back.
    assert_eq!(manoeuvres[0]["spiral"].as_array().unwrap().len(), 25);
    let page = std::fs::read_to_string(folder.path().join("manoeuvres.html")).unwrap();
    assert!(page.contains("<svg"));
}

#[test]
fn cli_a_thrust_out_of_range_is_named() {
    let run = program()
        .args(["sim", "manoeuvres", "--thrust", "1.2", "--out", "x"])
        .output()
        .unwrap();
    assert_eq!(run.status.code(), Some(2));
    assert!(String::from_utf8(run.stderr).unwrap().contains("1.2"));
}
