//! What refuses a trial before it begins.

use seatrial_io::autopilot::{Autopilot, Settings};
use seatrial_sim::VehicleConfig;

use crate::sea::{Sea, Weather};
use crate::{assert_as_before, failures, settings, starfish};

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
    reversed
        .speeds
        .iter_mut()
        .for_each(|speed| speed.b2_per_s2 *= -1.0);
    assert!(refused(reversed, settings()).contains("rudder sense"));
    let elsewhere = Settings {
        outputs: Some(seatrial_io::autopilot::SteeringOutputs {
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
    let checks = autopilot.take_control(&preflight.changes, &mut |_| {
        Err(std::io::Error::other("full"))
    });
    assert!(failures(&checks).join("").contains("full"));
    assert_as_before(autopilot.wire());
    assert_eq!(autopilot.wire().boat.mode, 4);
}
