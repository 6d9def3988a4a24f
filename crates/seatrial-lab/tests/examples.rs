//! The examples of the crate run as they stand.

#[path = "../examples/lying_logs.rs"]
#[allow(dead_code, reason = "main is not called here")]
mod lying_logs;

#[test]
fn io_lying_logs_are_written_with_their_truth() {
    let folder = tempfile::tempdir().unwrap();
    lying_logs::write(folder.path(), 1).unwrap();
    let truth = std::fs::read_to_string(folder.path().join("truth.csv")).unwrap();
    let kinds = seatrial_lab::lies::KINDS;
    assert_eq!(truth.lines().count(), 1 + kinds.len());
    assert!(folder.path().join(format!("{}_1.csv", kinds[0].name)).exists());
}
