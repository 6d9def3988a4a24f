//! The example, run as it stands.

#[path = "../examples/own_log_format.rs"]
#[allow(dead_code, reason = "main is not called here")]
mod own_log_format;

#[test]
fn recover_a_log_of_a_format_of_ones_own() {
    let found = own_log_format::run().unwrap();
    assert!(found.verdict.accepted);
    // A compass in tenths of a degree: 2 %.
    assert!((found.model().a22_per_s / -1.07 - 1.0).abs() < 0.02);
}
