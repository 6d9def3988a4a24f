//! MAVLink frames behind their time of arrival, and the few messages that are read.
//!
//! The messages stand in [`LOGGED`]; of all others only the length counts.

use std::ops::Range;

use crate::frame::Head;
pub use crate::frame::LONGEST_FRAME;
use crate::message::LOGGED;
use crate::sender::Sender;

/// Bytes of the time of arrival, us since 1970, big endian.
pub const STAMP: usize = 8;
/// Payload of a message with all its bytes; zeros at its end are not sent.
pub const PAYLOAD: usize = 255;
/// Where the first 256 messages stand in [`LOGGED`].
static INDICES: [Option<usize>; 256] = {
    let mut indices = [None; 256];
    let mut index = 0;
    while index < LOGGED.len() {
        indices[LOGGED[index].id as usize] = Some(index);
        index += 1;
    }
    indices
};

fn index_of(id: u32) -> Option<usize> {
    *INDICES.get(usize::try_from(id).ok()?)?
}

/// A frame in the log.
#[derive(Clone)]
pub struct Frame {
    /// Index in [`LOGGED`].
    pub message: Option<usize>,
    /// The sender of the message.
    pub sender: Sender,
    /// Length of the time stamp and the frame together, bytes.
    pub length: usize,
    /// Time of arrival, us since 1970.
    pub arrival_us: f64,
    /// Where it stands in the bytes that the frame was found in.
    payload: Range<usize>,
}

/// What comes next in the log.
pub enum Next {
    /// A sound frame.
    Frame(Frame),
    /// No frame begins here.
    NoFrame,
    /// The bytes end before the frame does.
    Cut,
}

impl Frame {
    /// The frame at the start of these bytes.
    pub fn at(seen: &[u8]) -> Next {
        let (Some(stamp), Some(frame)) = (seen.first_chunk::<STAMP>(), seen.get(STAMP..)) else {
            return Next::Cut;
        };
        match frame.first() {
            Some(0xfd | 0xfe) => {}
            Some(_) => return Next::NoFrame,
            None => return Next::Cut,
        }
        let Some((head, whole)) =
            Head::of(frame).and_then(|head| frame.get(..head.length()).map(|whole| (head, whole)))
        else {
            return Next::Cut;
        };
        let message = index_of(head.id);
        let is_sound = match message {
            Some(message) => head.is_sound(whole, LOGGED[message].crc_extra),
            // Without its seed the checksum says nothing; what follows must be a frame too.
            None => matches!(frame.get(whole.len() + STAMP), Some(0xfd | 0xfe) | None),
        };
        if !is_sound {
            return Next::NoFrame;
        }
        Next::Frame(Self {
            message,
            sender: head.sender,
            length: STAMP + whole.len(),
            arrival_us: u64::from_be_bytes(*stamp) as f64,
            payload: STAMP + head.header..STAMP + head.checked(),
        })
    }

    /// The payload, from the bytes that the frame was found in, with the zeros that were not sent.
    pub fn payload(&self, seen: &[u8]) -> [u8; PAYLOAD] {
        let mut payload = [0; PAYLOAD];
        let sent = seen.get(self.payload.clone()).unwrap_or_default();
        payload[..sent.len()].copy_from_slice(sent);
        payload
    }
}
