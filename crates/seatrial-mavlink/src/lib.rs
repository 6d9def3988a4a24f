#![doc = include_str!("../README.md")]

pub mod ardupilot;
mod checksum;
mod definition;
mod field;
mod frame;
pub mod logged;
pub mod message;
mod seeds;
mod sender;
mod signing;
mod vehicle_type;

pub use definition::{Definition, MessageClock};
pub use frame::{Damage, Decoder, Encoder, Frame};
pub use message::Message;
pub use sender::Sender;
pub use signing::{Key, KeyError, Refused, Signing};
pub use vehicle_type::aircraft;
