//! The examples, run as they stand.

#[path = "../examples/online_estimator.rs"]
#[allow(dead_code)]
mod online_estimator;

#[test]
fn recover_the_online_estimator() {
    online_estimator::run().unwrap();
}
