//! How commissions end under ArduSub.

use seatrial_app::trials::commission::{Ending, GainsLease};
use seatrial_core::YawModel;

use super::{OnSea, assert_kept_as_foreseen, assert_undone, changed, truth, under_water};

#[test]
fn recover_gains_of_a_true_model_are_kept_under_water_and_can_be_undone() {
    let mut vehicle = OnSea::take(under_water(1));
    let before = vehicle.gains();
    let found = vehicle.commission(&truth());
    assert_kept_as_foreseen(&found);
    assert_ne!(vehicle.gains(), before);
    assert_eq!(vehicle.restore, None);
    let boat = &vehicle.autopilot.wire().boat;
    assert_eq!(boat.parameter("RC_OVERRIDE_TIME"), Some(3.0));
    // It holds its depth and heading again.
    assert_eq!(boat.mode, 2);
    assert_undone(&mut vehicle, &before);
}

/// Half and twice the yaw's effect and the model of another boat: no gains are proposed, nothing is written, or the old gains are back
/// after the first small step.
#[test]
fn prop_a_wrong_model_leaves_the_old_gains_under_water() {
    let another = {
        let mut point = truth();
        point.point.model = YawModel::from_theta([-0.2, 0.15, 0.0]);
        point
    };
    for point in [changed(1.0, 0.5), changed(1.0, 2.0), another] {
        let mut vehicle = OnSea::take(under_water(2));
        let before = vehicle.gains();
        let model = point.point.model;
        // Where no gains do, nothing is asked of the vehicle.
        let Ok(proposal) = vehicle.proposed(&point) else {
            continue;
        };
        let found = vehicle.carry_out(&proposal);
        let is_refused = match &found.ending {
            Ending::Refused => true,
            Ending::PutBack { at_small_step, .. } => *at_small_step,
            _ => false,
        };
        assert!(is_refused, "{model:?}: {}", found.line());
        assert_eq!(vehicle.gains(), before, "{model:?}");
        assert_eq!(vehicle.restore, None);
    }
}

/// What ends a commission in the middle of a turn leaves the heading that the vehicle has then, not the one that it was taken on.
#[test]
fn exact_the_operator_gets_it_on_the_heading_that_it_has() {
    let mut vehicle = OnSea::take(under_water(3));
    let start_s = vehicle.autopilot.wire().now_s;
    let heading_rad = vehicle.autopilot.wire().boat.heading_rad();
    while vehicle.autopilot.wire().now_s < start_s + 8.0 {
        vehicle.next_sample().unwrap();
        vehicle.autopilot.steer_to(heading_rad + 0.6, 0.8);
    }
    let turned_rad = vehicle.autopilot.wire().boat.heading_rad();
    assert!((turned_rad - heading_rad).abs() > 0.2);
    vehicle.autopilot.hand_back();
    let end_s = vehicle.autopilot.wire().now_s + 15.0;
    while vehicle.autopilot.wire().pass(end_s).is_some() {}
    let boat = &vehicle.autopilot.wire().boat;
    let held_rad = boat.heading_rad();
    assert!((held_rad - turned_rad).abs() < 0.15, "{held_rad} {turned_rad}");
    assert_eq!((boat.thrust(), boat.mode), (0.0, 2));
}
