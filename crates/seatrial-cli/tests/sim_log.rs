//! `sim log`: a simulated trial as a log.

use seatrial_dev::run_to_text;

#[test]
fn cli_simulated_logs_read_back_and_say_nothing_of_the_truth() {
    let folder = tempfile::tempdir().unwrap();
    let log = |out: &str| {
        let arguments = ["sim", "log", "--seed", "5", "--thrust", "0.8", "--json", "--out", out];
        let truth = ["--truth", "truth.toml"];
        let (exit, stdout, stderr) = run_to_text(folder.path(), &[&arguments[..], &truth].concat());
        assert_eq!(exit, 0, "{stderr}");
        assert!(!stdout.contains("a22"), "{stdout}");
        let (exit, stdout, stderr) = run_to_text(folder.path(), &["inspect", out, "--json"]);
        assert_eq!(exit, 0, "{stderr}");
        assert!(!stderr.contains("warning"), "{stderr}");
        serde_json::from_str::<serde_json::Value>(&stdout).unwrap()
    };
    let (csv, parquet, mcap) = (log("run.csv"), log("run.parquet"), log("run.mcap"));
    assert_eq!(csv["source"]["format"], "csv");
    assert_eq!(parquet["source"]["format"], "parquet");
    assert_eq!(mcap["source"]["format"], "mcap");
    for other in [&parquet, &mcap] {
        assert!(csv["ranges"].is_array());
        assert_eq!(csv["ranges"], other["ranges"]);
    }
    assert_eq!(csv["manoeuvres"], parquet["manoeuvres"]);
    // Times of MCAP are rounded to the nanosecond.
    let count = |document: &serde_json::Value| document["manoeuvres"].as_array().unwrap().len();
    assert_eq!(count(&csv), count(&mcap));
    let truth = std::fs::read_to_string(folder.path().join("truth.toml")).unwrap();
    // Table II at 80 %.
    assert!(truth.contains("a22_per_s = -1.07"), "{truth}");
}

#[cfg(target_os = "linux")]
#[test]
fn cli_a_full_disk_exits_6() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["full.csv", "full.parquet", "full.mcap"] {
        std::os::unix::fs::symlink("/dev/full", folder.path().join(name)).unwrap();
        let (exit, _, stderr) =
            run_to_text(folder.path(), &["sim", "log", "--thrust", "0.8", "--out", name]);
        assert_eq!(exit, 6, "{stderr}");
        assert!(stderr.contains("No space left"), "{stderr}");
    }
}

#[test]
fn cli_the_same_seed_writes_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let log = |seed: &str, out: &str| {
        let arguments = ["sim", "log", "--thrust", "1", "--seed", seed, "--out", out];
        assert_eq!(run_to_text(folder.path(), &arguments).0, 0);
        std::fs::read(folder.path().join(out)).unwrap()
    };
    assert_eq!(log("7", "a.csv"), log("7", "b.csv"));
    assert_ne!(log("7", "a.csv"), log("8", "c.csv"));
}

#[test]
fn cli_vehicles_of_six_degrees_of_freedom_are_practised_with() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for (vehicle, log) in [("sim:starfish-6dof", "starfish.csv"), ("sim:remus100", "remus.csv")] {
        for truth in ["truth.toml", "truth.json"] {
            let arguments = [
                "sim",
                "log",
                "--vehicle",
                vehicle,
                "--thrust",
                "0.8",
                "--out",
                log,
                "--truth",
                truth,
            ];
            let (exit, _, stderr) = run_to_text(folder, &arguments);
            assert_eq!(exit, 0, "{stderr}");
            let truth = std::fs::read_to_string(folder.join(truth)).unwrap();
            assert!(truth.contains("a22_per_s") && truth.contains("munk_moment"), "{truth}");
        }
        let (exit, stdout, stderr) = run_to_text(folder, &["identify", log, "--json"]);
        assert_eq!(exit, 0, "{vehicle}: {stdout}{stderr}");
        let (exit, stdout, stderr) = run_to_text(folder, &["trial", "--vehicle", vehicle]);
        // At full thrust the fin of the REMUS 100 lags by a third of the vehicle's time constant, and 20 Hz may be refused
        // as too slow.
        let is_fast = vehicle == "sim:remus100" && stdout.starts_with("4 of 5 runs accepted");
        assert!(exit == 0 || exit == 4 && is_fast, "{vehicle}: {stdout}{stderr}");
        let (exit, stdout, stderr) = run_to_text(folder, &["plan", "--vehicle", vehicle]);
        assert_eq!(exit, 0, "{vehicle}: {stdout}{stderr}");
    }
}
