//! Other ground stations, other autopilots, and a process that was suspended.

use seatrial_core::{AbortReason, Action, Outcome, Steering, Vehicle};
use seatrial_links::autopilot::{Autopilot, Profile, Settings, Speaker, Stop};
use seatrial_links::link::message::Heartbeat;
use seatrial_links::link::{Encoder, Message, Sender, Wire};
use seatrial_sim::FirstOrderVehicle;

use super::sea::{FULL_RUDDER_RAD, Mishap, Sea, Weather};
use super::{Witness, failures, run, second_station, settings, starfish, taken};

/// A vehicle beside which somebody else is heard.
struct Beside {
    sea: Sea,
    other: Vec<u8>,
}

impl Wire for Beside {
    fn now_s(&self) -> f64 {
        self.sea.now_s()
    }

    fn receive(&mut self, bytes: &mut Vec<u8>, until_s: f64) {
        bytes.extend(&self.other);
        self.sea.receive(bytes, until_s);
    }

    fn send(&mut self, bytes: &[u8]) {
        self.sea.send(bytes);
    }
}

fn refused_beside(other: Vec<u8>, settings: Settings) -> Vec<String> {
    let sea = Sea::new(starfish(), Weather::default(), 1);
    let mut autopilot = Autopilot::new(Beside { sea, other }, settings, None);
    failures(&autopilot.inspect().checks)
}

#[test]
fn io_a_second_station_is_named_before_the_trial() {
    let refused = refused_beside(second_station::heartbeat(), settings()).join("; ");
    assert!(refused.contains("(component 1) has our system id 255"), "{refused}");
    let mission_planner = Sender { system: 255, component: 190 };
    let heartbeat = Message::from(Heartbeat::GROUND_STATION);
    let heard = Encoder::new(mission_planner).encode(&heartbeat, None, 0.0);
    let refused = refused_beside(heard, settings()).join("; ");
    assert!(refused.contains("Mission Planner or QGroundControl"), "{refused}");
}

/// Its heartbeat was not heard before; what it does to the vehicle is.
#[test]
fn io_the_joystick_of_a_second_station_ends_the_trial() {
    let (mut autopilot, _) = taken(Sea::new(starfish(), Weather::default(), 7));
    let at_s = autopilot.wire().now_s + 20.0;
    autopilot.wire().mishap = Some((at_s, Mishap::SecondJoystick));
    let mut witness = Witness::default();
    let conducted = run(&mut autopilot, &mut witness);
    let outcome = conducted.campaign.outcome;
    assert_eq!(outcome, Some(Outcome::Aborted(AbortReason::SecondStation)));
    let last_s = witness.steps.last().unwrap().sample.time_s;
    let started_s = autopilot.wire().now_s - at_s;
    assert!(started_s <= 0.5, "{started_s} s after it began, at {last_s} s");
}

/// An autopilot that nobody asked for must not be the one that is changed.
#[test]
fn io_two_autopilots_need_a_choice() {
    let other = Sender { system: 9, component: 1 };
    let heartbeat = Message::from(Heartbeat {
        custom_mode: 0,
        kind: 11,
        autopilot: 3,
        base_mode: 0x81,
        system_status: 4,
        mavlink_version: 3,
    });
    let heard = Encoder::new(other).encode(&heartbeat, None, 0.0);
    let chosen = Settings { vehicle: Some(1), ..settings() };
    assert_eq!(refused_beside(heard.clone(), chosen), [""; 0]);
    // Heard first, it is taken for the vehicle, and nothing that it does not answer is changed.
    let refused = refused_beside(heard, settings());
    assert!(!refused.is_empty());
}

/// As after SIGSTOP and SIGCONT: the reason is ours, whatever the vehicle did meanwhile.
#[test]
fn io_a_process_that_was_suspended_says_so() {
    for steering in [Steering::Rudder(0.1), Steering::HoldHeading(0.0)] {
        let (mut autopilot, _) = taken(Sea::new(starfish(), Weather::default(), 3));
        let action = Action { steering, thrust: Some(0.6), outcome: None };
        autopilot.act(&action).unwrap();
        autopilot.next_sample().unwrap();
        autopilot.wire().now_s += 6.0;
        let stopped = loop {
            match autopilot.next_sample() {
                Ok(_) => {}
                Err(stop) => break stop,
            }
        };
        assert!(matches!(stopped, Stop::NotAttended(_)), "{stopped}");
    }
}

/// A station's heartbeats come no faster because a vehicle is played faster.
#[test]
fn exact_a_vehicle_that_is_played_faster_waits_as_long_for_its_station() {
    let held_after_s = |speed: f64| {
        let vehicle = FirstOrderVehicle::new(starfish(), 1).unwrap();
        let mut speaker = Speaker::new(vehicle, Profile::Rover, 0.05, FULL_RUDDER_RAD, None);
        speaker.speed = speed;
        for (name, value) in [("FS_GCS_ENABLE", 1.0), ("FS_GCS_TIMEOUT", 0.3), ("FS_TIMEOUT", 0.0)]
        {
            speaker.set_parameter(name, value);
        }
        speaker.step().unwrap();
        speaker.receive(&second_station::heartbeat());
        let mut steps = 0.0;
        while !speaker.is_critical() && steps < 1e3 {
            speaker.step().unwrap();
            steps += 1.0;
        }
        steps * 0.05 / speed
    };
    for speed in [1.0, 4.0, 10.0] {
        let held_after_s = held_after_s(speed);
        assert!((0.3..=0.5).contains(&held_after_s), "{speed}: {held_after_s}");
    }
}
