//! The examples, run as they stand.

#[expect(dead_code, reason = "the example's own start reads the command line")]
#[path = "../examples/open_log.rs"]
mod open_log;

#[test]
fn io_an_example_opens_a_log() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.csv");
    std::fs::write(&path, "time_s,heading_deg,rudder_pct\n0,359,0\n0.05,1,-10\n").unwrap();
    open_log::describe(&path).unwrap();
    assert!(open_log::describe(folder.path()).is_err());
}
