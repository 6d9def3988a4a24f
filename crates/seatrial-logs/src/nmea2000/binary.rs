//! Frames in records of bytes.
//!
//! | recorder | record |
//! |---|---|
//! | Yacht Devices (.DAT) | ms of the minute (2), identifier (4), 8 bytes; of a fast packet sequence, length and all bytes |
//! | Actisense (.ebl) | ESC SOH, kind, a time or a message, ESC LF; between them messages of the NGT-1; an ESC twice |
//! | Actisense NGT-1 | DLE STX, message, sum, DLE ETX; a DLE of the message twice |

use super::{Frame, LONGEST_RECORD, MOST_BYTES, Piece, Records};
use crate::bytes::Found;
use crate::clock::ticks_unix_s;
use crate::number::number;

const ESCAPE: u8 = 0x1b;
const DATA_LINK_ESCAPE: u8 = 0x10;
/// The kind of a record of Actisense that is the time of what follows, as Windows counts it.
const TIME_RECORD: u8 = 0x03;
/// The identifier of records that Yacht Devices' recorder writes of itself.
const SERVICE: u32 = u32::MAX;
/// Records by which a file of Yacht Devices is told.
const LEAST_RECORDS: usize = 8;

/// Numbers of messages of several frames, of which Yacht Devices writes a length.
pub(super) const FAST: [u32; 54] = [
    65_240, 126_208, 126_464, 126_720, 126_983, 126_988, 126_996, 126_998, 127_233, 127_237,
    127_489, 127_496, 127_498, 127_503, 127_504, 127_506, 127_507, 127_509, 128_275, 128_520,
    129_029, 129_038, 129_039, 129_040, 129_041, 129_044, 129_045, 129_284, 129_285, 129_301,
    129_302, 129_538, 129_540, 129_542, 129_545, 129_547, 129_549, 129_551, 129_556, 129_792,
    129_793, 129_794, 129_798, 129_802, 129_809, 129_810, 130_052, 130_054, 130_060, 130_061,
    130_064, 130_074, 130_320, 130_578,
];

/// How the start of a file writes records.
pub(super) fn container(start: &[u8]) -> Option<Records> {
    let records = |read, period_s| Some(Records { read, period_s });
    if start.starts_with(&[ESCAPE, 0x01]) {
        // 16 bits of milliseconds in messages of the newer kind.
        return records(actisense, Some(65.536));
    }
    if start.starts_with(&[DATA_LINK_ESCAPE, 0x02]) {
        return records(gateway, None);
    }
    // A recording that begins in a message.
    let begin = start.windows(3).position(|bytes| *bytes == [DATA_LINK_ESCAPE, 0x02, 0x93]);
    if let Some(at) = begin.filter(|at| *at < LONGEST_RECORD)
        && matches!(gateway(&start[at..]), Found::Packet((Piece::Frame(_), _)))
    {
        return records(gateway, None);
    }
    if is_utf_16(start) {
        return None;
    }
    let mut at = 0;
    for _ in 0..LEAST_RECORDS {
        let Found::Packet((_, count)) = yacht_devices(start.get(at..)?) else {
            return None;
        };
        at += count;
    }
    records(yacht_devices, Some(60.0))
}

/// Text of two bytes a letter, whose times and identifiers would be sound, too; those of the bus hardly have priority 0.
fn is_utf_16(start: &[u8]) -> bool {
    let mut pairs = start.chunks_exact(2).take(7);
    pairs.len() == 7 && pairs.all(|pair| pair[0] != 0 && pair[1] == 0)
}

fn yacht_devices(bytes: &[u8]) -> Found<(Piece, usize)> {
    let fields = number::<u16>(bytes, 0).zip(number::<u32>(bytes, 2));
    let Some((milliseconds, identifier)) = fields else {
        return Found::Cut;
    };
    let time_s = f64::from(milliseconds) / 1e3;
    if identifier == SERVICE {
        return Found::Packet((Piece::Other, 14));
    }
    if milliseconds >= 60_000 || identifier >> 29 != 0 {
        return Found::Nothing(1);
    }
    let mut frame = Frame::of_bus(time_s, identifier, Vec::new());
    frame.is_of_bus = false;
    let (from, length) = match (frame.number, FAST.contains(&frame.number)) {
        (59_904, _) => (6, 3),
        (_, true) => match bytes.get(7) {
            Some(length) if usize::from(*length) <= MOST_BYTES => (8, usize::from(*length)),
            Some(_) => return Found::Nothing(1),
            None => return Found::Cut,
        },
        _ => (6, 8),
    };
    match bytes.get(from..from + length) {
        Some(data) => {
            frame.data = data.to_vec();
            Found::Packet((Piece::Frame(frame), from + length))
        }
        None => Found::Cut,
    }
}

/// A record that does not end: the file's last, or none.
fn without_end(bytes: &[u8]) -> Found<(Piece, usize)> {
    match bytes.len() < LONGEST_RECORD {
        true if !bytes[2..].windows(2).any(|pair| *pair == bytes[..2]) => Found::Cut,
        _ => Found::Nothing(1),
    }
}

/// What stands between a beginning and an end that the first escape marks, with every escape twice; how many bytes that is with both.
fn escaped(bytes: &[u8], escapes: &[u8], end: u8) -> Option<(Vec<u8>, usize)> {
    let mut message = Vec::new();
    let mut at = 2;
    loop {
        match (*bytes.get(at)?, bytes.get(at + 1)) {
            (byte, Some(next)) if escapes.contains(&byte) && *next == byte => {
                message.push(byte);
                at += 2;
            }
            (byte, Some(next)) if byte == escapes[0] && *next == end => {
                return Some((message, at + 2));
            }
            (byte, _) if escapes.contains(&byte) => return None,
            (byte, _) => {
                message.push(byte);
                at += 1;
            }
        }
    }
}

fn actisense(bytes: &[u8]) -> Found<(Piece, usize)> {
    if bytes == [ESCAPE] {
        return Found::Cut;
    }
    if bytes.starts_with(&[DATA_LINK_ESCAPE, 0x02]) {
        return message_between(bytes, &[DATA_LINK_ESCAPE, ESCAPE]);
    }
    if !bytes.starts_with(&[ESCAPE, 0x01]) {
        return Found::Nothing(1);
    }
    let Some((record, count)) = escaped(bytes, &[ESCAPE], 0x0a) else {
        return without_end(bytes);
    };
    // The first byte is the kind of record; messages of the bus begin with their own kind behind it.
    let piece = match (record.first(), record.get(1..)) {
        (Some(&TIME_RECORD), Some(time)) => {
            number::<u64>(time, 0).map(|ticks| Piece::Time(ticks_unix_s(ticks as f64)))
        }
        (Some(_), Some(message)) => match message.first() {
            Some(0x95) => short_message(message),
            _ => long_message(message),
        }
        .map(Piece::Frame),
        _ => None,
    };
    Found::Packet((piece.unwrap_or(Piece::Other), count))
}

fn gateway(bytes: &[u8]) -> Found<(Piece, usize)> {
    if bytes == [DATA_LINK_ESCAPE] {
        return Found::Cut;
    }
    if !bytes.starts_with(&[DATA_LINK_ESCAPE, 0x02]) {
        return Found::Nothing(1);
    }
    message_between(bytes, &[DATA_LINK_ESCAPE])
}

/// A message of the NGT-1 between its beginning and its end.
fn message_between(bytes: &[u8], escapes: &[u8]) -> Found<(Piece, usize)> {
    let Some((message, count)) = escaped(bytes, escapes, 0x03) else {
        return without_end(bytes);
    };
    let frame = long_message(&message).or_else(|| sent_message(&message));
    Found::Packet((frame.map_or(Piece::Other, Piece::Frame), count))
}

/// Kind 0x94, a message that was sent, without a time: length, priority, number (3), destination, length, data.
fn sent_message(message: &[u8]) -> Option<Frame> {
    let (0x94, body) = (*message.first()?, message.get(2..)?) else {
        return None;
    };
    let length = usize::from(*body.get(5)?);
    let (number, data) = (number::<u32>(body, 1)? & 0xff_ffff, body.get(6..6 + length)?);
    Some(Frame::of_message(f64::NAN, number, 0, data.to_vec()))
}

/// Kind 0x93: length, priority, number (3), destination, source, ms (4), length, data.
pub(super) fn long_message(message: &[u8]) -> Option<Frame> {
    let (0x93, body) = (*message.first()?, message.get(2..)?) else {
        return None;
    };
    let length = usize::from(*body.get(10)?);
    let (time_s, data) = (f64::from(number::<u32>(body, 6)?) / 1e3, body.get(11..11 + length)?);
    let group = number::<u32>(body, 1)? & 0xff_ffff;
    Some(Frame::of_message(time_s, group, *body.get(5)?, data.to_vec()))
}

/// Kind 0x95: length, ms (2), source, number without its page (2), page and priority, data of one frame.
fn short_message(message: &[u8]) -> Option<Frame> {
    let length = usize::from(*message.get(1)?);
    let body = message.get(2..2 + length)?;
    let [low, high, page] = *body.get(3..6)? else {
        return None;
    };
    let identifier = u32::from(page & 0x3) << 24 | u32::from(high) << 16 | u32::from(low) << 8;
    let time_s = f64::from(number::<u16>(body, 0)?) / 1e3;
    let mut frame = Frame::of_bus(time_s, identifier, body.get(6..)?.to_vec());
    frame.source = body[2];
    Some(frame)
}
