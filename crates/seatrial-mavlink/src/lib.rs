//! MAVLink frames, signing and the messages that steer a vehicle, and ArduPilot's output parameters; no I/O.

pub mod ardupilot;
mod frame;
pub mod log_fields;
pub mod message;
mod seeds;
mod signing;

pub use frame::{Damage, Decoder, Encoder, Frame, Sender};
pub use message::Message;
pub use signing::{Key, KeyError, Refused, Signing};
