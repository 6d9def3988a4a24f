//! Forged messages, by a second autopilot and under the vehicle's own name; garbage by the kilobyte; every kind of autopilot.

use seatrial::campaign::Run;
use seatrial_app::conduct::{TrialResult, conduct};
use seatrial_core::{AbortReason, Outcome};
use seatrial_links::autopilot::{Autopilot, Profile, Settings, Speaker, SteeringOutputs, Stop};
use seatrial_links::link::message::{Heartbeat, ServoOutputRaw};
use seatrial_links::link::{Decoder, Encoder, Key, Message, Sender, Signing, Wire};
use seatrial_sim::FirstOrderVehicle;

use super::sea::{Draw, FULL_RUDDER_RAD, INTERVAL_S, Mishap, Sea, Weather, boat};
use super::{Witness, about, calm, failures, plan, settings, truth};

pub const VEHICLE: Sender = Sender { system: 1, component: 1 };

/// A vehicle on whose link somebody else sends, too; what we send is noted.
pub struct Tapped {
    pub sea: Sea,
    forge: Box<dyn FnMut(f64) -> Vec<u8>>,
    decoder: Decoder,
    sent: Vec<Message>,
}

impl Tapped {
    pub fn new(sea: Sea, forge: impl FnMut(f64) -> Vec<u8> + 'static) -> Self {
        Self { sea, forge: Box::new(forge), decoder: Decoder::default(), sent: Vec::new() }
    }
}

impl Wire for Tapped {
    fn now_s(&self) -> f64 {
        self.sea.now_s
    }

    fn receive(&mut self, bytes: &mut Vec<u8>, until_s: f64) {
        bytes.extend((self.forge)(self.sea.now_s));
        self.sea.receive(bytes, until_s);
    }

    fn send(&mut self, bytes: &[u8]) {
        self.decoder.push(bytes);
        while let Some(frame) = self.decoder.next(None, 0.0) {
            self.sent.extend(frame.message());
        }
        self.sea.send(bytes);
    }
}

pub fn frame(sender: Sender, message: impl Into<Message>) -> Vec<u8> {
    Encoder::new(sender).encode(&message.into(), None, 0.0)
}

fn armed(base_mode: u8, custom_mode: u32) -> Heartbeat {
    Heartbeat {
        custom_mode,
        kind: 11,
        autopilot: 3,
        base_mode,
        system_status: 4,
        mavlink_version: 3,
    }
}

/// Only where it is known which autopilot is the vehicle is anybody asked for a parameter, a message or a mode.
#[test]
fn io_a_spoofed_autopilot_heard_first_is_asked_for_nothing() {
    let other_system = Sender { system: 9, component: 1 };
    let namesake = Sender { system: 1, component: 25 };
    let chosen = Settings { vehicle: Some(1), ..settings() };
    for (spoof, settings, expected) in [
        (other_system, settings(), "--vehicle-id"),
        (namesake, chosen, "components 1 and 25 of system 1"),
    ] {
        let sea = Sea::new(calm(), Weather::default(), 1);
        let forged = frame(spoof, armed(0x81, 0));
        let wire = Tapped::new(sea, move |_| forged.clone());
        let mut autopilot = Autopilot::new(wire, settings, None);
        let refused = failures(&autopilot.inspect().checks).join("; ");
        assert!(refused.contains(expected), "{refused}");
        let asked = autopilot.wire().sent.iter();
        let asked: Vec<_> = asked
            .filter(|message| !matches!(message, Message::Heartbeat(_) | Message::Timesync(_)))
            .collect();
        assert!(asked.is_empty(), "{asked:?}");
    }
}

pub fn outputs_of(profile: Profile) -> Option<SteeringOutputs> {
    (profile == Profile::Px4)
        .then(|| SteeringOutputs { outputs: vec![1], pulses_us: [1100.0, 1500.0, 1900.0] })
}

/// A whole trial beside a forger.
fn trial(
    profile: Profile,
    is_signed: bool,
    forge: impl FnMut(f64) -> Vec<u8> + 'static,
) -> (TrialResult<Stop>, Autopilot<Tapped>) {
    let key = || is_signed.then(|| Signing::new(Key::new([7; 32]), 0, 1.8e9));
    let mut sea = Sea::new(calm(), Weather::default(), 1);
    let vehicle = FirstOrderVehicle::new(calm(), 1).unwrap();
    sea.boat = Speaker::new(vehicle, profile, INTERVAL_S, FULL_RUDDER_RAD, key());
    let settings = Settings { outputs: outputs_of(profile), ..settings() };
    let mut autopilot = Autopilot::new(Tapped::new(sea, forge), settings, key());
    let preflight = autopilot.inspect();
    assert_eq!(failures(&preflight.checks), [""; 0]);
    let checks = autopilot.take_control(&preflight.changes, &mut |_| Ok(()));
    assert_eq!(failures(&checks), [""; 0]);
    let mut witness = Witness::default();
    let conducted = conduct(&mut autopilot, plan(), about(), &mut witness).unwrap();
    (conducted, autopilot)
}

/// In the middle of the training, whoever forges.
const FORGED_FROM_S: f64 = 45.0;

fn from_then_on(bytes: Vec<u8>) -> impl FnMut(f64) -> Vec<u8> {
    move |now_s| match now_s > FORGED_FROM_S {
        true => bytes.clone(),
        false => Vec::new(),
    }
}

fn forged_outputs() -> Vec<u8> {
    let outputs = ServoOutputRaw {
        time_us: 1,
        pulses: [1900, 1500, 1100, 1500, 1500, 1500, 1500, 1500],
        port: 0,
        more_pulses: [0; 8],
    };
    frame(VEHICLE, outputs)
}

/// Accepted runs whose a22 or b2 is beyond two half widths of its interval from the truth.
fn wrong_models(conducted: &TrialResult<Stop>) -> usize {
    let [a22_per_s, b2_per_s2] = truth(&calm());
    let is_wrong = |run: &&Run| {
        let found = run.identification.as_ref();
        let found = found.and_then(|found| found.refined.as_ref());
        found.is_none_or(|found| {
            let interval = found.interval_95;
            let pairs = [(a22_per_s, interval.a22_per_s), (b2_per_s2, interval.b2_per_s2)];
            pairs.iter().any(|(truth, [low, high])| (truth - 0.5 * (low + high)).abs() > high - low)
        })
    };
    let accepted = conducted.campaign.runs.iter();
    let accepted = accepted.filter(|run| run.verdict.accepted);
    accepted.filter(is_wrong).count()
}

/// Without a signature a forger can end or spoil the trial, and no more: the vehicle is handed back as it was, and no wrong
/// model is accepted.
#[test]
fn io_forged_messages_end_a_trial_that_is_not_signed_and_no_other() {
    let disarmed = || frame(VEHICLE, armed(0x01, 0));
    for (forged, expected) in [(disarmed(), "disarmed"), (forged_outputs(), "outputs")] {
        let (conducted, mut autopilot) = trial(Profile::Rover, false, from_then_on(forged.clone()));
        let outcome = conducted.campaign.outcome;
        if expected == "disarmed" {
            assert_eq!(outcome, Some(Outcome::Aborted(AbortReason::Disarmed)));
        }
        assert!(outcome.is_some(), "{expected}");
        assert_eq!(wrong_models(&conducted), 0, "{expected}: {:?}", conducted.campaign);
        let done = autopilot.hand_back();
        assert_eq!(done.not_restored, [""; 0], "{expected}");
        let sea = &autopilot.wire().sea;
        assert_eq!(sea.boat.parameter("RC_OVERRIDE_TIME"), Some(3.0));
        assert_eq!(sea.boat.steering(), 0.0);

        let (conducted, mut autopilot) = trial(Profile::Rover, true, from_then_on(forged));
        let outcome = conducted.campaign.outcome;
        assert_eq!(outcome, Some(Outcome::Finished), "{expected}");
        assert!(conducted.campaign.runs.iter().any(|run| run.verdict.accepted));
        assert!(autopilot.damage().refused_frames > 0);
        assert!(autopilot.hand_back().is_complete());
    }
}

/// Two kilobytes between every two datagrams, with the first bytes of frames among them.
#[test]
fn io_garbage_under_load_stops_no_trial() {
    for profile in [Profile::Rover, Profile::Sub, Profile::Px4] {
        let mut draw = Draw(5);
        let garbage = move |_| {
            let bytes = (0..2000).map(|_| (256.0 * draw.next()) as u8);
            bytes.map(|byte| if byte < 16 { 0xfd } else { byte }).collect()
        };
        let (conducted, mut autopilot) = trial(profile, false, garbage);
        let outcome = conducted.campaign.outcome;
        assert_eq!(outcome, Some(Outcome::Finished), "{profile:?}: {:?}", conducted.fault);
        let done = autopilot.hand_back();
        assert!(done.is_complete(), "{profile:?}: {done:?}");
    }
}

/// ArduSub and PX4 let go and are put back as Rover is.
#[test]
fn io_mishaps_on_other_kinds_of_autopilots() {
    for profile in [Profile::Sub, Profile::Px4] {
        for (mishap, expected, longest_s) in [
            (Mishap::LinkLost, AbortReason::LinkLost, 1.0),
            (Mishap::Mute, AbortReason::LinkLost, 1.0),
            // Told by a heartbeat, once a second.
            (Mishap::Disarmed, AbortReason::Disarmed, 1.2),
            (Mishap::PilotMode, AbortReason::ModeChanged, 1.2),
            (Mishap::Battery, AbortReason::LowBattery, 1.2),
        ] {
            let context = format!("{profile:?}, {mishap:?}");
            let mut sea = Sea::new(calm(), Weather::default(), 1);
            sea.boat = boat(&calm(), profile);
            let settings = Settings { outputs: outputs_of(profile), ..settings() };
            let (mut autopilot, backup) = super::taken_with(sea, settings);
            let at_s = autopilot.wire().now_s + 14.0;
            autopilot.wire().mishap = Some((at_s, mishap));
            let conducted = super::run(&mut autopilot, &mut Witness::default());
            let outcome = conducted.campaign.outcome.unwrap();
            let is_noticed_first = outcome == Outcome::Aborted(AbortReason::RudderNotFollowed);
            assert!(
                outcome == Outcome::Aborted(expected)
                    || (mishap == Mishap::Disarmed && is_noticed_first),
                "{context}: {outcome:?}"
            );
            let done = autopilot.hand_back();
            let held_s = autopilot.wire().held_s - at_s;
            assert!(held_s <= longest_s + 2.0 * INTERVAL_S, "{context}: {held_s} s");
            let is_cut = matches!(mishap, Mishap::LinkLost | Mishap::Mute);
            assert_eq!(done.not_restored.is_empty(), !is_cut, "{context}: {done:?}");
            autopilot.wire().mishap = None;
            if is_cut {
                let done = autopilot.restore(&backup);
                assert!(done.is_complete(), "{context}: {done:?}");
            }
            for (name, stored) in &backup.parameters {
                let now = autopilot.wire().boat.parameter(name).map(f64::from);
                assert_eq!(now, Some(stored.number), "{context}: {name}");
            }
        }
    }
}
