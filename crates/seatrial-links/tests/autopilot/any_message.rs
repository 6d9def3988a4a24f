//! Whatever comes over the link in the vehicle's own name, with sound checksums, nothing ends the program.

use seatrial_app::conduct::conduct;
use seatrial_dev::{Damage, damaged_copies};
use seatrial_links::autopilot::{Autopilot, Profile, Settings, Speaker};
use seatrial_links::link::message::Payload;
use seatrial_links::link::{Message, Wire};
use seatrial_sim::FirstOrderVehicle;

use super::forged::{Tapped, VEHICLE, frame, outputs_of};
use super::sea::{FULL_RUDDER_RAD, INTERVAL_S, Sea, Weather};
use super::{Witness, about, calm, plan, settings};

/// Links with messages of chance, each from a seed.
const LINKS: u64 = 30;
const PROFILES: [Profile; 3] = [Profile::Rover, Profile::Sub, Profile::Px4];
/// Numbers of messages beyond these are not read.
const MOST_IDS: u32 = 512;
/// The vehicle goes on so long after the end, s.
const AFTERWARDS_S: f64 = 5.0;

/// Numbers of the messages that are read.
fn ids() -> Vec<u32> {
    let is_read = |id: &u32| Message::read(*id, &[0; 255]).is_some();
    (0..MOST_IDS).filter(is_read).collect()
}

/// Any bytes, often the ends of the ranges of integers and of numbers.
fn payload(damage: &mut Damage) -> Payload {
    let mut payload = [0; 255];
    let ends = [0x00, 0xff, 0x7f, 0x80];
    for byte in &mut payload {
        *byte = match damage.below(3) {
            0 => ends[damage.below(ends.len())],
            1 => 0,
            _ => damage.below(256) as u8,
        };
    }
    payload
}

/// A message from a seed: most seldom, so that a trial gets somewhere between them.
fn forged(damage: &mut Damage, ids: &[u32]) -> Vec<u8> {
    if damage.below(40) > 0 {
        return Vec::new();
    }
    let id = ids[damage.below(ids.len())];
    let message = Message::read(id, &payload(damage)).unwrap();
    frame(VEHICLE, message)
}

#[test]
fn prop_no_message_in_the_vehicles_name_ends_the_program() {
    let ids = ids();
    assert!(ids.len() > 20, "{ids:?}");
    let (mut refused, mut taken) = (0, 0);
    for seed in 0..damaged_copies(LINKS) {
        let profile = PROFILES[seed as usize % PROFILES.len()];
        let mut sea = Sea::new(calm(), Weather::default(), 1);
        let vehicle = FirstOrderVehicle::new(calm(), 1).unwrap();
        sea.boat = Speaker::new(vehicle, profile, INTERVAL_S, FULL_RUDDER_RAD, None);
        let settings = Settings { outputs: outputs_of(profile), ..settings() };
        let (mut damage, ids) = (Damage::new(seed), ids.clone());
        // An even seed lets the trial begin.
        let from_s = if seed.is_multiple_of(2) { 25.0 } else { 0.0 };
        let forge = move |now_s| match now_s < from_s {
            true => Vec::new(),
            false => forged(&mut damage, &ids),
        };
        let mut autopilot = Autopilot::new(Tapped::new(sea, forge), settings, None);
        let preflight = autopilot.inspect();
        if preflight.checks.iter().all(|check| check.passed) {
            let changed = autopilot.take_control(&preflight.changes, &mut |_| Ok(()));
            if changed.iter().all(|check| check.passed) {
                let conducted =
                    conduct(&mut autopilot, plan(), about(), &mut Witness::default()).unwrap();
                assert!(conducted.campaign.outcome.is_some(), "seed {seed}");
                taken += 1;
            }
            autopilot.hand_back();
        } else {
            refused += 1;
        }
        let end_s = autopilot.wire().sea.now_s + AFTERWARDS_S;
        let mut passed = Vec::new();
        while autopilot.wire().sea.now_s < end_s {
            autopilot.wire().sea.receive(&mut passed, end_s);
        }
        assert_eq!(
            autopilot.wire().sea.boat.steering(),
            0.0,
            "seed {seed}, {profile:?}: nobody holds the rudder at the end"
        );
    }
    assert!(taken > 0 && refused > 0, "{taken} taken, {refused} refused");
}
