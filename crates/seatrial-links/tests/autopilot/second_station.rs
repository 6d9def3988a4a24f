//! Another ground station that has our system id.

use seatrial_links::link::message::{Heartbeat, RcChannelsOverride};
use seatrial_links::link::{Encoder, Message, Sender};

const STATION: Sender = Sender { system: 255, component: 1 };

/// What tells that it is there.
pub fn heartbeat() -> Vec<u8> {
    let heartbeat = Message::from(Heartbeat::GROUND_STATION);
    Encoder::new(STATION).encode(&heartbeat, None, 0.0)
}

/// Its joystick, to starboard.
#[allow(dead_code, reason = "not every test plays it")]
pub fn joystick() -> Vec<u8> {
    let mut pulses = [u16::MAX; 8];
    (pulses[0], pulses[2]) = (1880, 1720);
    let moved = Message::from(RcChannelsOverride { pulses, target_system: 1, target_component: 1 });
    Encoder::new(STATION).encode(&moved, None, 0.0)
}
