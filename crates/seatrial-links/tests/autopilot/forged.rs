//! Forged messages of a second autopilot.

use seatrial_links::autopilot::{Autopilot, Settings};
use seatrial_links::link::message::Heartbeat;
use seatrial_links::link::{Decoder, Encoder, Message, Sender, Wire};

use crate::sea::{Sea, Weather};
use crate::{calm, failures, settings};

/// A vehicle on whose link somebody else sends, too; what we send is noted.
struct Tapped {
    sea: Sea,
    forge: Box<dyn FnMut(f64) -> Vec<u8>>,
    decoder: Decoder,
    sent: Vec<Message>,
}

impl Tapped {
    fn new(sea: Sea, forge: impl FnMut(f64) -> Vec<u8> + 'static) -> Self {
        Self {
            sea,
            forge: Box::new(forge),
            decoder: Decoder::default(),
            sent: Vec::new(),
        }
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

/// An armed Rover.
const ROVER: Heartbeat = Heartbeat {
    custom_mode: 0,
    kind: 11,
    autopilot: 3,
    base_mode: 0x81,
    system_status: 4,
    mavlink_version: 3,
};

/// Only where it is known which autopilot is the vehicle is anybody asked for a parameter, a message or a mode.
#[test]
fn io_a_spoofed_autopilot_heard_first_is_asked_for_nothing() {
    let other_system = Sender {
        system: 9,
        component: 1,
    };
    let namesake = Sender {
        system: 1,
        component: 25,
    };
    let chosen = Settings {
        vehicle: Some(1),
        ..settings()
    };
    for (spoof, settings, told) in [
        (other_system, settings(), "--vehicle-id"),
        (namesake, chosen, "components 1 and 25 of system 1"),
    ] {
        let sea = Sea::new(calm(), Weather::default(), 1);
        let forged = Encoder::new(spoof).encode(&Message::from(ROVER), None, 0.0);
        let wire = Tapped::new(sea, move |_| forged.clone());
        let mut autopilot = Autopilot::new(wire, settings, None);
        let refused = failures(&autopilot.inspect().checks).join("; ");
        assert!(refused.contains(told), "{refused}");
        let asked = autopilot.wire().sent.iter();
        let asked: Vec<_> = asked
            .filter(|message| !matches!(message, Message::Heartbeat(_) | Message::Timesync(_)))
            .collect();
        assert!(asked.is_empty(), "{asked:?}");
    }
}
