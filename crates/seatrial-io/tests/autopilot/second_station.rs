//! Another ground station that has our system id.

use seatrial_io::link::message::Heartbeat;
use seatrial_io::link::{Encoder, Message, Sender};

/// What tells that it is there.
pub fn heartbeat() -> Vec<u8> {
    let station = Sender {
        system: 255,
        component: 1,
    };
    let heartbeat = Message::from(Heartbeat {
        custom_mode: 0,
        kind: 6,
        autopilot: 8,
        base_mode: 0,
        system_status: 4,
        mavlink_version: 3,
    });
    Encoder::new(station).encode(&heartbeat, None, 0.0)
}
