//! Links to vehicles: bytes over UDP, TCP or a serial line, frames of MAVLink 1 and 2 in them, messages in those.

mod frame;
pub mod message;
mod seeds;
mod signing;
mod transport;

pub use frame::{Damage, Decoder, Encoder, Frame, Sender};
pub use message::Message;
pub use signing::{Key, KeyError, Refused, Signing};
pub use transport::{Address, Transport, Wire};
