//! Messages of more than eight bytes, which come in several frames.
//!
//! The first byte of a frame has the message's sequence in its upper three bits and the frame's place in the lower five; the second
//! byte of the first frame is the length of the message.

use std::collections::BTreeMap;

use super::MOST_BYTES;

/// Messages that are put together at a time.
const MOST_OPEN: usize = 1024;
const FIRST: usize = 6;
const OTHERS: usize = 7;

/// The messages that are not whole yet, by number, source and sequence.
#[derive(Default)]
pub(super) struct FastPackets(BTreeMap<(u32, u8, u8), Open>);

struct Open {
    length: usize,
    next: u8,
    data: Vec<u8>,
}

impl FastPackets {
    /// Takes a frame in; the message that it ends.
    pub fn take(&mut self, number: u32, source: u8, frame: &[u8]) -> Option<Vec<u8>> {
        let (&head, rest) = frame.split_first()?;
        let key = (number, source, head >> 5);
        let place = head & 0x1f;
        if place == 0 {
            let (&length, rest) = rest.split_first()?;
            let length = usize::from(length);
            if length > MOST_BYTES || (self.0.len() == MOST_OPEN && !self.0.contains_key(&key)) {
                return None;
            }
            let open = Open { length, next: 1, data: rest[..rest.len().min(FIRST)].to_vec() };
            self.0.insert(key, open);
        } else {
            let open = self.0.get_mut(&key)?;
            if open.next != place {
                // A frame is lost, and with it the message.
                self.0.remove(&key);
                return None;
            }
            open.next += 1;
            open.data.extend_from_slice(&rest[..rest.len().min(OTHERS)]);
        }
        let is_whole = self.0.get(&key).is_some_and(|open| open.data.len() >= open.length);
        let mut open = is_whole.then(|| self.0.remove(&key))??;
        open.data.truncate(open.length);
        Some(open.data)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_frames_are_put_together_in_their_order_only() {
        let mut packets = FastPackets::default();
        let data: Vec<u8> = (0..15).collect();
        let frames: [Vec<u8>; 3] = [
            [&[0x40, 15], &data[..6]].concat(),
            [&[0x41], &data[6..13]].concat(),
            [&[0x42], &data[13..], &[0xff; 5]].concat(),
        ];
        assert_eq!(packets.take(129_029, 3, &frames[0]), None);
        assert_eq!(packets.take(129_029, 4, &frames[1]), None);
        assert_eq!(packets.take(129_029, 3, &frames[1]), None);
        assert_eq!(packets.take(129_029, 3, &frames[2]), Some(data));
        packets.take(129_029, 3, &frames[0]);
        assert_eq!(packets.take(129_029, 3, &frames[2]), None);
        assert_eq!(packets.take(129_029, 3, &frames[1]), None);
    }
}
