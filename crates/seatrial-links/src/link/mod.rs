//! Bytes over UDP, TCP or a serial line, frames of MAVLink 1 and 2 in them, messages in those.

mod transport;

pub use seatrial_mavlink::{
    Damage, Decoder, Encoder, Frame, Key, KeyError, Message, Refused, Sender, Signing, message,
};
pub use transport::{Address, InvalidAddress, Transport, Wire};
