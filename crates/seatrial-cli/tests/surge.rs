//! `seatrial surge` as a process.

/// The surge of a trial, and what is missing of one speed.
#[test]
fn cli_surge_of_a_trial() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let run = |arguments: &str| {
        let arguments: Vec<&str> = arguments.split(' ').collect();
        seatrial_dev::run_in(folder, &arguments)
    };
    run("trial --vehicle sim:remus100 --seed 1 --yes");
    let output = run("surge --json");
    assert_eq!(output.status.code(), Some(0));
    let surge = seatrial_dev::document(&output);
    assert_eq!(surge["schema"], "seatrial.surge.v1");
    let lag_s = surge["thrust_lag_s"]["value"].as_f64().unwrap();
    // The shaft of the simulated vehicle follows with 1 s.
    assert!((lag_s - 1.0).abs() < 0.2, "{lag_s}");
    run("plan --thrust 0.6 --out one.toml");
    run("trial --vehicle sim:remus100 --seed 1 --plan one.toml --yes --logbook one.db");
    let output = run("surge --logbook one.db");
    assert_eq!(output.status.code(), Some(4));
    let said = seatrial_dev::unwrapped(&seatrial_dev::text(&output.stdout));
    assert!(said.contains("not identifiable from this record"), "{said}");
}
