//! Whole trials, also through bad links.

use seatrial_core::Outcome;
use seatrial_links::autopilot::{Profile, Settings, SteeringOutputs};
use seatrial_sim::plant::Servo;

use super::sea::{Sea, Weather, boat};
use super::{
    Witness, assert_as_before, assert_near, assert_replays, calm, run, settings, taken, taken_with,
    truth,
};

#[test]
fn recover_a_whole_trial_replays_bit_for_bit() {
    let (mut autopilot, backup) = taken(Sea::new(calm(), Weather::default(), 1));
    assert_eq!(backup.mode, Some(4));
    assert_eq!(autopilot.wire().boat.mode, 0);
    let mut witness = Witness::default();
    let conducted = run(&mut autopilot, &mut witness);
    assert_eq!(conducted.fault, None);
    assert_eq!(conducted.campaign.outcome, Some(Outcome::Finished));
    let done = autopilot.hand_back();
    assert!(done.is_complete(), "{done:?}");
    assert_eq!(done.mode_restored, Some(true));
    assert_eq!(done.throttle_neutral, Some(true));
    assert_as_before(autopilot.wire());
    assert_eq!(autopilot.wire().boat.mode, 4);
    assert_replays(&witness.steps);
    // The 5 %.
    assert_near(&conducted.campaign, truth(&calm()), 0.05);
}

/// ArduPilot's Rover on the plant: a servo's lag of 0.15 s, which the outputs do not show.
#[test]
fn recover_a_lagging_rudder() {
    let mut config = calm();
    config.servo = Servo { time_constant_s: 0.15, ..config.servo };
    for speed in &mut config.speeds {
        (speed.a22_per_s, speed.b2_per_s2, speed.c0_rad_per_s2) = (-0.91, 1.75, 0.02);
    }
    let (mut autopilot, _) = taken(Sea::new(config.clone(), Weather::default(), 1));
    let mut witness = Witness::default();
    let conducted = run(&mut autopilot, &mut witness);
    // The 5 %, lag included.
    assert_near(&conducted.campaign, truth(&config), 0.05);
}

#[test]
fn recover_through_bad_links() {
    let loss = Weather { loss: 0.3, ..Weather::default() };
    let disorder =
        Weather { duplication: 0.3, jitter_s: 0.12, garbage: 0.05, ..Weather::default() };
    let late = Weather { latency_s: 0.5, ..Weather::default() };
    for (name, weather, share) in
        [("loss", loss, 0.1), ("disorder", disorder, 0.1), ("late", late, 0.05)]
    {
        let (mut autopilot, _) = taken(Sea::new(calm(), weather, 3));
        let mut witness = Witness::default();
        let conducted = run(&mut autopilot, &mut witness);
        let outcome = conducted.campaign.outcome;
        assert_eq!(outcome, Some(Outcome::Finished), "{name}: {:?}", conducted.fault);
        let done = autopilot.hand_back();
        assert!(done.is_complete(), "{name}: {done:?}");
        assert_as_before(autopilot.wire());
        assert_replays(&witness.steps);
        // A third of the samples are missing, and with them the instants of some edges.
        assert_near(&conducted.campaign, truth(&calm()), share);
    }
}

/// ArduSub and PX4 as their definitions have them: other messages, modes, parameters, outputs and reports.
#[test]
fn recover_on_other_kinds_of_autopilots() {
    for profile in [Profile::Sub, Profile::Px4] {
        let mut sea = Sea::new(calm(), Weather::default(), 1);
        sea.boat = boat(&calm(), profile);
        let before = sea.boat.mode;
        let outputs = (profile == Profile::Px4)
            .then(|| SteeringOutputs { outputs: vec![1], pulses_us: [1100.0, 1500.0, 1900.0] });
        let settings = Settings { outputs, ..settings() };
        let (mut autopilot, backup) = taken_with(sea, settings);
        assert_eq!(backup.parameters.len(), 1, "{profile:?}: its timeout");
        assert!(autopilot.wire().boat.is_steered());
        let mut witness = Witness::default();
        let conducted = run(&mut autopilot, &mut witness);
        assert_eq!(conducted.campaign.outcome, Some(Outcome::Finished));
        let done = autopilot.hand_back();
        assert!(done.is_complete(), "{profile:?}: {done:?}");
        assert_eq!(done.mode_restored, Some(true), "{profile:?}");
        let is_thrust_known = profile == Profile::Sub;
        assert_eq!(done.throttle_neutral, is_thrust_known.then_some(true));
        assert_eq!(autopilot.wire().boat.mode, before);
        for (name, stored) in &backup.parameters {
            let now = autopilot.wire().boat.parameter(name).map(f64::from);
            assert_eq!(now, Some(stored.number), "{name}");
        }
        assert_replays(&witness.steps);
        // The 5 %.
        assert_near(&conducted.campaign, truth(&calm()), 0.05);
    }
}
