//! How commissions end on a healthy vehicle.

use seatrial::gains::commission::ModelCheck;
use seatrial_app::trials::commission::Ending;
use seatrial_core::YawModel;

use seatrial_sim::VehicleConfig;

use super::{
    OnSea, assert_kept_as_foreseen, assert_undone, changed, sea, settings, truth, truth_of,
};
use crate::autopilot::sea::{FULL_RUDDER_RAD, Sea, Weather};
use seatrial_links::autopilot::{Autopilot, Profile};

#[test]
fn recover_gains_of_a_true_model_are_kept_and_can_be_undone() {
    let mut vehicle = OnSea::take(sea(1));
    let before = vehicle.gains();
    let found = vehicle.commission(&truth());
    assert_kept_as_foreseen(&found);
    let [old, new] = [found.old.unwrap(), found.new.unwrap()];
    // The defaults oscillate on this boat.
    assert!(old.settling_s.is_none_or(|old_s| new.settling_s.unwrap() < old_s));
    let after = vehicle.gains();
    assert_ne!(before, after);
    // The failsafes and the mode are as before, and nothing is left to restore.
    assert_eq!(vehicle.restore, None);
    let boat = &vehicle.autopilot.wire().boat;
    let failsafe = ["FS_GCS_TIMEOUT", "FS_TIMEOUT", "FS_GCS_ENABLE"].map(|n| boat.parameter(n));
    assert_eq!(failsafe, [Some(5.0), Some(1.5), Some(0.0)]);
    assert_eq!(boat.mode, 4);
    assert_undone(&mut vehicle, &before);
}

/// Boat 3-4 of `seatrial-lab commission`, full steering of which turns it by 4.5 degrees a second, farther off its centre. The angle gain is
/// so small that the emptied integral needs a minute for its time constant, and the heading is 3 degrees off before it has learnt.
#[test]
fn recover_a_boat_with_a_weak_rudder_waits_until_the_integral_has_learnt() {
    let mut config = VehicleConfig::starfish();
    config.disturbance.standard_deviation_rad_s2 = 1.6e-5;
    let authority = 0.0158;
    for speed in &mut config.speeds {
        speed.a22_per_s = -0.2026;
        speed.b2_per_s2 = authority / FULL_RUDDER_RAD;
        speed.c0_rad_per_s2 = 0.05 * authority;
    }
    let truth = truth_of(&config);
    let mut vehicle = OnSea::take(Sea::new(config, Weather::default(), 1));
    let proposal = vehicle.proposal(&truth);
    let integral_s = proposal.settings.integral_time_s().unwrap();
    assert!(integral_s > 45.0, "{integral_s}");
    let found = vehicle.carry_out(&proposal);
    assert!(matches!(found.ending, Ending::Kept { .. }), "{}", found.line());
    let small = found.small.unwrap();
    assert!(small.steady_error_rad < 0.007, "{small:?}");
    assert!(found.new.unwrap().overshoot <= 0.05, "{}", found.line());
}

/// Gains of QuickTune's rule ask for more than full steering, and the speed takes a part of it away before the outputs limit it.
#[test]
fn recover_a_model_is_known_as_the_boats_under_strong_gains_at_speed() {
    let truth = truth();
    let model = truth.point.model;
    let feed_forward_s = 0.9 * -model.a22_per_s / (model.b2_per_s2 * FULL_RUDDER_RAD);
    let mut sea = sea(1);
    for (name, value) in [
        ("ATC_STR_RAT_FF", feed_forward_s),
        ("ATC_STR_RAT_P", 2.0 * feed_forward_s),
        ("ATC_STR_RAT_I", 0.5 * feed_forward_s),
    ] {
        sea.boat.set_parameter(name, value as f32);
    }
    let found = OnSea::take(sea).commission(&truth);
    let Some(ModelCheck::Holds { scale, .. }) = found.model_check else {
        panic!("{found:?}");
    };
    assert!((scale - 1.0).abs() < 0.1, "{found:?}");
}

/// Half and twice the rudder's effect, half the damping, reversed, and the model of another boat: nothing is written, or the old
/// gains are back after the first small step.
#[test]
fn prop_a_wrong_model_leaves_the_old_gains() {
    let another = {
        let mut point = truth();
        point.point.model = YawModel::from_theta([-0.2, 0.15, 0.0]);
        point
    };
    let wrong =
        [changed(1.0, 0.5), changed(1.0, 1.5), changed(0.5, 1.0), changed(1.5, 1.0), another];
    for point in wrong {
        let mut vehicle = OnSea::take(sea(2));
        let before = vehicle.gains();
        let found = vehicle.commission(&point);
        let is_refused = match &found.ending {
            Ending::Refused => true,
            Ending::PutBack { at_small_step, .. } => *at_small_step,
            _ => false,
        };
        // A boat damped half as much again is not told from the model's by its steps; its gains must do well then.
        let is_good = matches!(found.ending, Ending::Kept { .. })
            && found.new.is_some_and(|new| new.overshoot < 0.08);
        let model = point.point.model;
        assert!(is_refused || is_good, "{model:?}: {}", found.line());
        if is_refused {
            assert_eq!(vehicle.gains(), before, "{model:?}");
            assert_eq!(vehicle.restore, None);
        }
        let is_half_or_twice = (model.b2_per_s2 / truth().point.model.b2_per_s2 - 1.0).abs() > 0.4;
        assert!(!is_half_or_twice || is_refused, "{model:?}: {}", found.line());
    }
}

/// A model whose rudder turns the other way gets no gains at all.
#[test]
fn exact_a_reversed_model_is_refused_before_the_vehicle_moves() {
    let vehicle = OnSea::take(sea(3));
    let reversed = changed(1.0, -1.0);
    let control = seatrial_app::trials::commission::Control {
        settings: vehicle.control.settings,
        loop_interval_s: 0.05,
        sample_interval_s: 0.05,
        output_scale: 1.0,
        steering_taken: 0.0,
        keeps_speed: true,
        rate_noise_rad_s: None,
    };
    let refused =
        seatrial_app::trials::commission::propose(&reversed, 0.26, &control, 0.5).unwrap_err();
    assert!(refused.to_string().contains("does not surely turn"), "{refused}");
}

/// PX4 has no heading that can be asked for from outside: it says so, and what to do instead.
#[test]
fn exact_px4_is_refused_and_told_what_to_do() {
    let config = VehicleConfig::starfish();
    let sea = Sea::of(Profile::Px4, config, Weather::default(), 1);
    let mut autopilot = Autopilot::new(sea, settings(), None);
    let (found, control) = autopilot.inspect_heading();
    assert_eq!(control, None);
    let refused = found.checks.iter().find(|check| !check.passed && check.name == "heading mode");
    let text = &refused.unwrap().text;
    assert!(text.contains("`seatrial gains --export px4 --out gains.params`"), "{text}");
}
