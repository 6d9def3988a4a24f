//! Another ground station that has our system id.

use seatrial_links::link::message::Heartbeat;
use seatrial_links::link::{Encoder, Message, Sender};

/// What tells that it is there.
pub fn heartbeat() -> Vec<u8> {
    let station = Sender {
        system: 255,
        component: 1,
    };
    let heartbeat = Message::from(Heartbeat::GROUND_STATION);
    Encoder::new(station).encode(&heartbeat, None, 0.0)
}
