//! Is the overshoot that is promised the one that the vehicle has?

use seatrial::gains::DAMPING_RATIO;
use seatrial::identify::{IdentifySettings, identify};
use seatrial::{COURSE_CHANGE_RAD, CourseChange, GainAllowance, Window};
use seatrial_core::model::YawState;
use seatrial_core::{HeadingGain, YawModel};

use crate::drift::doublet;

const THRUSTS: [f64; 5] = [0.6, 0.7, 0.8, 0.9, 1.0];
const INTERVAL_S: f64 = 0.05;

/// Overshoot of the vehicle under a gain, a sample late, from its steady course.
fn overshoot_rad(truth: &YawModel<f64>, gain: &HeadingGain<f64>) -> f64 {
    let rudder = |wanted_rad: f64, heading_rad: f64| {
        gain.proportional_gain * (wanted_rad - heading_rad) + gain.feed_forward_rudder_rad
    };
    let mut state = YawState::default();
    let mut late = gain.feed_forward_rudder_rad;
    let mut most = f64::NEG_INFINITY;
    for k in 0..2000 {
        let wanted_rad = if k < 1000 { 0.0 } else { COURSE_CHANGE_RAD };
        let asked = rudder(wanted_rad, state.heading_rad);
        state = truth.advance(state, late, INTERVAL_S);
        late = asked;
        most = most.max(state.heading_rad - COURSE_CHANGE_RAD);
    }
    most.max(0.0)
}

#[test]
fn recover_the_overshoot_of_the_vehicle_lies_within_the_promise() {
    let mut inside = 0;
    let mut tried = 0;
    for seed in 0..20 {
        for thrust in THRUSTS {
            let (record, truth) = doublet(thrust, seed);
            let truth = truth.model;
            let training = Window { from_s: 5.0, to_s: 21.0 };
            let found = identify(&record, training, None, &IdentifySettings::default()).unwrap();
            let Some(promise) = CourseChange::of(&found, None) else {
                continue;
            };
            let gain = GainAllowance::of(&found).design(&found.model(), DAMPING_RATIO);
            let overshoot = overshoot_rad(&truth, &gain.unwrap());
            let [low, high] = promise.overshoot_95_rad;
            tried += 1;
            inside += u32::from((low..=high).contains(&overshoot));
        }
    }
    // Of 95 % some fall outside by chance: with 100 tries at least 88 are inside in 999 of 1000 studies.
    assert!(tried >= 90 && 100 * inside >= 88 * tried, "{inside} of {tried}");
}
