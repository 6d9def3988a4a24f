//! The examples, run as they stand.

#[expect(dead_code, reason = "the example's own start prints what the test looks at")]
#[path = "../examples/own_vehicle.rs"]
mod own_vehicle;

#[test]
fn recover_the_boat_of_the_example() {
    let runs = own_vehicle::trial().unwrap();
    assert!(!runs.is_empty());
    for run in runs {
        // The record is free of noise; what is left is the estimator's start.
        assert!((run.model.a22_per_s + 1.07).abs() < 0.02, "{run:?}");
        assert!((run.model.b2_per_s2 - 1.08).abs() < 0.02, "{run:?}");
    }
}
