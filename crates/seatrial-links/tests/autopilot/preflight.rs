//! What refuses a trial before it begins.

use seatrial_links::autopilot::{Autopilot, Profile, Settings, Speaker};
use seatrial_links::link::{Key, Signing};
use seatrial_sim::{FirstOrderVehicle, VehicleConfig};

use super::sea::{FULL_RUDDER_RAD, INTERVAL_S, Sea, Weather, boat};
use super::{assert_as_before, failures, settings, starfish, taken_with};

#[test]
fn io_a_preflight_refuses_and_says_why() {
    let refused = |change: fn(&mut Sea), settings: Settings| {
        let mut sea = Sea::new(starfish(), Weather::default(), 1);
        change(&mut sea);
        failures(&Autopilot::new(sea, settings, None).inspect().checks).join("; ")
    };
    let with = |change: fn(&mut Settings)| {
        let mut settings = settings();
        change(&mut settings);
        settings
    };
    type Case = (fn(&mut Sea), Settings, &'static str);
    let cases: [Case; 6] = [
        (|sea| sea.boat.is_armed = false, settings(), "armed"),
        (|sea| sea.boat.battery_percent = 10, settings(), "battery"),
        (|sea| sea.weather.loss = 1.0, settings(), "heartbeat"),
        (|_| {}, with(|s| s.system_id = 254), "system id"),
        (|_| {}, with(|s| s.sample_interval_s = 0.02), "rates"),
        (|_| {}, with(|s| s.envelope = None), "envelope"),
    ];
    for (change, settings, expected) in cases {
        let refused = refused(change, settings);
        assert!(refused.contains(expected), "{expected}: {refused}");
    }
}

/// The angle at full steering is told, and that nobody gave it.
#[test]
fn exact_a_preflight_says_what_full_steering_is_taken_for() {
    for is_full_rudder_assumed in [true, false] {
        let settings = Settings { full_rudder_rad: 0.6, is_full_rudder_assumed, ..settings() };
        let sea = Sea::new(starfish(), Weather::default(), 1);
        let found = Autopilot::new(sea, settings, None).inspect();
        let item = found.checks.iter().find(|check| check.name == "full rudder");
        let text = &item.unwrap().text;
        assert!(text.contains("34.4 degrees"), "{text}");
        assert_eq!(text.contains("ASSUMED"), is_full_rudder_assumed, "{text}");
    }
}

/// A rudder that turns the other way, and one whose output does not move, are found before the trial.
#[test]
fn io_the_wiggle_finds_a_rudder_that_does_not_answer() {
    let refused = |config: VehicleConfig, settings: Settings| {
        let mut autopilot = Autopilot::new(Sea::new(config, Weather::default(), 1), settings, None);
        let preflight = autopilot.inspect();
        let checks = autopilot.take_control(&preflight.changes, &mut |_| Ok(()));
        let failures = failures(&checks).join("; ");
        autopilot.hand_back();
        assert_as_before(autopilot.wire());
        failures
    };
    let mut reversed = starfish();
    reversed.speeds.iter_mut().for_each(|speed| speed.b2_per_s2 *= -1.0);
    assert!(refused(reversed, settings()).contains("rudder sense"));
    let elsewhere = Settings {
        outputs: Some(seatrial_links::autopilot::SteeringOutputs {
            outputs: vec![2],
            pulses_us: [1100.0, 1500.0, 1900.0],
        }),
        ..settings()
    };
    assert!(refused(starfish(), elsewhere).contains("echo"));
}

/// Without a place for the backup nothing is changed.
#[test]
fn io_no_backup_no_change() {
    let sea = Sea::new(starfish(), Weather::default(), 1);
    let mut autopilot = Autopilot::new(sea, settings(), None);
    let preflight = autopilot.inspect();
    let checks =
        autopilot.take_control(&preflight.changes, &mut |_| Err(std::io::Error::other("full")));
    assert!(failures(&checks).join("").contains("full"));
    assert_as_before(autopilot.wire());
    assert_eq!(autopilot.wire().boat.mode, 4);
}

/// On its firmware half of the stick's way is what a submarine's outputs do unless a button of the pilot's changes it.
#[test]
fn regress_a_submarine_makes_less_of_its_stick() {
    let mut sea = Sea::new(starfish(), Weather::default(), 1);
    sea.boat = boat(&starfish(), Profile::Sub);
    let mut autopilot = Autopilot::new(sea, settings(), None);
    let preflight = autopilot.inspect();
    let gain = preflight.checks.iter().find(|c| c.name == "stick gain");
    assert!(gain.is_some_and(|gain| gain.text.starts_with("PilotGain is 0.50")));
    let checks = autopilot.take_control(&preflight.changes, &mut |_| Ok(()));
    assert_eq!(failures(&checks), [""; 0]);
    autopilot.hand_back();
    // A thruster would be at its end.
    let mut sea = Sea::new(starfish(), Weather::default(), 1);
    sea.boat = boat(&starfish(), Profile::Sub);
    let greedy = Settings { most_asked: 2.2, ..settings() };
    let refused = failures(&Autopilot::new(sea, greedy, None).inspect().checks);
    assert_eq!(refused.len(), 1, "{refused:?}");
    assert!(refused[0].contains("0.45 would do"), "{refused:?}");
}

/// A submarine without a remote control keeps the last stick until a failsafe, whose default disarms it: before a trial too.
#[test]
fn regress_a_submarine_without_a_remote_control() {
    let sea_with = |action: f32| {
        let mut sea = Sea::new(starfish(), Weather::default(), 1);
        sea.boat = boat(&starfish(), Profile::Sub);
        sea.boat.has_remote_control = false;
        sea.boat.set_parameter("FS_PILOT_INPUT", action);
        sea
    };
    let settings = Settings { without_remote_control: true, ..settings() };
    let mut disarmed = Autopilot::new(sea_with(2.0), settings.clone(), None);
    let refused = failures(&disarmed.inspect().checks).join("; ");
    assert!(refused.contains("FS_PILOT_INPUT is 2"), "{refused}");
    for action in [0.0, 1.0] {
        let (mut autopilot, backup) = taken_with(sea_with(action), settings.clone());
        assert!(autopilot.wire().boat.is_armed);
        assert_eq!(autopilot.wire().boat.parameter("FS_PILOT_INPUT"), Some(1.0));
        let done = autopilot.hand_back();
        assert!(done.is_complete(), "{done:?}");
        for (name, stored) in &backup.parameters {
            let now = autopilot.wire().boat.parameter(name).map(f64::from);
            assert_eq!(now, Some(stored.number), "{name}");
        }
        assert_eq!(backup.parameters["FS_PILOT_TIMEOUT"].number, 3.0);
    }
}

/// A vehicle that signs and hears nobody who does not: its frames are understood, nothing is answered.
#[test]
fn regress_a_vehicle_that_wants_a_key() {
    let mut sea = Sea::new(starfish(), Weather::default(), 1);
    let key = Signing::new(Key::new([7; 32]), 0, 0.0);
    let vehicle = FirstOrderVehicle::new(starfish(), 1).unwrap();
    sea.boat = Speaker::new(vehicle, Profile::Rover, INTERVAL_S, FULL_RUDDER_RAD, Some(key));
    let refused = failures(&Autopilot::new(sea, settings(), None).inspect().checks);
    assert_eq!(refused.len(), 1, "{refused:?}");
    assert!(refused[0].contains("--signing-key"), "{refused:?}");
}
