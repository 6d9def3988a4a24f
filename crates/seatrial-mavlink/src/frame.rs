//! Frames of MAVLink 1 and 2 in a stream of bytes.
//!
//! ```text
//! version 1: FE length sequence system component id                    payload checksum
//! version 2: FD length incompatible compatible sequence system component id id id  payload checksum [signature]
//! ```
//!
//! The checksum is CRC-16/MCRF4XX over all from the length on, then over the message's seed. Source:
//! <https://mavlink.io/en/guide/serialization.html>.

use super::message::{Message, Payload};
use super::seeds::seed;
use super::sender::Sender;
use super::signing::{Refused, SIGNATURE, Signing};
use crate::checksum::checksum;

/// The longest frame: MAVLink 2, 255 bytes of payload, signed.
pub const LONGEST_FRAME: usize = 10 + 255 + 2 + SIGNATURE;
/// The first byte of a frame.
const VERSION_1: u8 = 0xfe;
const VERSION_2: u8 = 0xfd;
/// The only incompatible flag that exists: a signature follows.
const IS_SIGNED: u8 = 1;
/// Bytes that may wait for the rest of their frame; more than a frame means that nobody takes them.
const MOST_WAITING: usize = 1 << 16;

/// A frame with the right checksum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// The sender of the frame.
    pub sender: Sender,
    /// Counts the sender's frames.
    pub sequence: u8,
    /// Number of the message.
    pub id: u32,
    /// The payload with the zeros that were not sent.
    pub payload: Payload,
}

impl Frame {
    /// The message; `None` where nobody reads it.
    pub fn message(&self) -> Option<Message> {
        Message::read(self.id, &self.payload)
    }
}

/// What came that was no good.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Damage {
    /// Bytes that belong to no frame.
    pub garbage_bytes: u64,
    /// Frames that signing refuses.
    pub refused_frames: u64,
    /// Signed frames that were taken without a key to check them with.
    pub unchecked_frames: u64,
}

/// Bytes in, frames out. Garbage is passed over byte by byte: a sound frame behind it is found.
#[derive(Debug, Default)]
pub struct Decoder {
    waiting: Vec<u8>,
    damage: Damage,
}

/// What stands at the first of the waiting bytes.
enum Next {
    Frame { head: Head, length: usize },
    Skip { length: usize, is_garbage: bool },
    Cut,
}

/// What stands before a payload.
pub(crate) struct Head {
    /// Bytes of it, and of the payload.
    pub header: usize,
    payload: usize,
    pub sender: Sender,
    sequence: u8,
    pub id: u32,
    is_signed: bool,
}

impl Decoder {
    /// Takes in what a link has received.
    pub fn push(&mut self, bytes: &[u8]) {
        self.waiting.extend_from_slice(bytes);
        let surplus = self.waiting.len().saturating_sub(MOST_WAITING);
        self.damage.garbage_bytes += surplus as u64;
        self.waiting.drain(..surplus);
    }

    /// The next sound frame. With signing, only one whose signature holds.
    pub fn next(&mut self, signing: Option<&mut Signing>, now_s: f64) -> Option<Frame> {
        let mut signing = signing;
        let mut at = 0;
        let found = loop {
            let seen = &self.waiting[at..];
            match next(seen) {
                Next::Cut => break None,
                Next::Skip { length, is_garbage } => {
                    at += length;
                    self.damage.garbage_bytes += if is_garbage { length as u64 } else { 0 };
                }
                Next::Frame { head, length } => {
                    let whole = &seen[..length];
                    let accepted = signing.as_deref_mut().map_or(Ok(()), |signing| {
                        let signature =
                            whole.len().checked_sub(SIGNATURE).filter(|_| head.is_signed);
                        let signed = signature.ok_or(Refused::Unsigned)?;
                        signing.check(head.sender, &whole[..signed], &whole[signed..], now_s)
                    });
                    at += length;
                    if signing.is_none() && head.is_signed {
                        self.damage.unchecked_frames += 1;
                    }
                    if accepted.is_err() {
                        self.damage.refused_frames += 1;
                        continue;
                    }
                    let mut payload = [0; 255];
                    payload[..head.payload].copy_from_slice(&whole[head.header..head.checked()]);
                    break Some(Frame {
                        sender: head.sender,
                        sequence: head.sequence,
                        id: head.id,
                        payload,
                    });
                }
            }
        };
        self.waiting.drain(..at);
        found
    }

    /// What came that was no good.
    pub fn damage(&self) -> Damage {
        self.damage
    }
}

impl Head {
    /// Of a frame of either version; `None` where it is not complete.
    pub fn of(frame: &[u8]) -> Option<Self> {
        let is_version_2 = *frame.first()? == VERSION_2;
        let (header, sender) = if is_version_2 { (10, 5) } else { (6, 3) };
        let head = frame.get(..header)?;
        let id = match is_version_2 {
            true => u32::from_le_bytes([head[7], head[8], head[9], 0]),
            false => head[5].into(),
        };
        Some(Self {
            header,
            payload: head[1].into(),
            sender: Sender { system: head[sender], component: head[sender + 1] },
            sequence: head[sender - 1],
            id,
            is_signed: is_version_2 && head[2] & IS_SIGNED != 0,
        })
    }

    /// Bytes before the checksum.
    pub fn checked(&self) -> usize {
        self.header + self.payload
    }

    /// Bytes of the whole frame.
    pub fn length(&self) -> usize {
        self.checked() + 2 + if self.is_signed { SIGNATURE } else { 0 }
    }

    /// Is the checksum of a whole frame that of its bytes and of this seed?
    pub fn is_sound(&self, whole: &[u8], seed: u8) -> bool {
        let sum = checksum(&whole[1..self.checked()], seed);
        whole[self.checked()..self.checked() + 2] == sum.to_le_bytes()
    }
}

fn next(seen: &[u8]) -> Next {
    let garbage = |length| Next::Skip { length, is_garbage: true };
    let head = match seen.first() {
        None => return Next::Cut,
        Some(&(VERSION_1 | VERSION_2)) => Head::of(seen),
        Some(_) => {
            let is_mark = |byte: &u8| [VERSION_1, VERSION_2].contains(byte);
            return garbage(seen.iter().position(is_mark).unwrap_or(seen.len()));
        }
    };
    let Some(head) = head else {
        return Next::Cut;
    };
    if seen[0] == VERSION_2 && seen[2] & !IS_SIGNED != 0 {
        return garbage(1);
    }
    let length = head.length();
    let Some(seed) = seed(head.id) else {
        // Without its seed the checksum says nothing; another frame must follow.
        return match seen.get(length) {
            Some(&(VERSION_1 | VERSION_2)) => Next::Skip { length, is_garbage: false },
            _ => garbage(1),
        };
    };
    let Some(whole) = seen.get(..length) else {
        return Next::Cut;
    };
    match head.is_sound(whole, seed) {
        true => Next::Frame { head, length },
        false => garbage(1),
    }
}

/// Messages in, bytes of MAVLink 2 out.
#[derive(Debug)]
pub struct Encoder {
    sender: Sender,
    sequence: u8,
}

impl Encoder {
    /// For frames of this sender.
    pub fn new(sender: Sender) -> Self {
        Self { sender, sequence: 0 }
    }

    /// The next frame, signed where there is a key.
    pub fn encode(
        &mut self,
        message: &Message,
        signing: Option<&mut Signing>,
        now_s: f64,
    ) -> Vec<u8> {
        let (payload, whole) = message.payload();
        // At least one byte is sent.
        let sent = payload[..whole].iter().rposition(|byte| *byte != 0);
        let sent = &payload[..sent.map_or(1, |last| last + 1)];
        let [low, middle, high, _] = message.id().to_le_bytes();
        let incompatible = if signing.is_some() { IS_SIGNED } else { 0 };
        let Sender { system, component } = self.sender;
        let mut frame = Vec::with_capacity(LONGEST_FRAME);
        frame.extend([VERSION_2, sent.len() as u8, incompatible, 0, self.sequence]);
        frame.extend([system, component, low, middle, high]);
        frame.extend(sent);
        self.sequence = self.sequence.wrapping_add(1);
        let sum = checksum(&frame[1..], seed(message.id()).unwrap_or(0));
        frame.extend(sum.to_le_bytes());
        if let Some(signing) = signing {
            let signature = signing.sign(&frame, now_s);
            frame.extend(signature);
        }
        frame
    }
}
