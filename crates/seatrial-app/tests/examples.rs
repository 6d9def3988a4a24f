//! The examples, run as they stand.

#![allow(clippy::duplicate_mod, reason = "each example is a program of its own")]

#[path = "../examples/gains_to_autopilot.rs"]
#[allow(dead_code, reason = "main is not called here")]
mod gains_to_autopilot;
#[path = "../examples/identify_log.rs"]
#[allow(dead_code, reason = "main is not called here")]
mod identify_log;
#[path = "../examples/trial_on_simulator.rs"]
#[allow(dead_code, reason = "main is not called here")]
mod trial_on_simulator;

#[test]
fn recover_a_log_is_identified_at_each_of_its_speeds() {
    let found = identify_log::run(None).unwrap();
    let models = found.models.as_ref().expect("two speeds");
    assert_eq!(models.len(), 2);
    assert!(models.iter().all(|model| model.verdict.accepted));
}

#[test]
fn io_gains_become_parameters_of_an_autopilot() {
    let parameters = gains_to_autopilot::run(None).unwrap();
    assert!(parameters.contains("\nATC_STR_ANG_P,"), "{parameters}");
}

#[test]
fn recover_a_trial_on_a_simulator_has_a_model_at_each_speed() {
    let campaign = trial_on_simulator::run().unwrap();
    assert_eq!(campaign.accepted_runs().len(), 2);
}
