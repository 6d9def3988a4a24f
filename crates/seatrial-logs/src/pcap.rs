//! Captures of a network or a CAN bus (`.pcap`, `.pcapng`), as the lines that a recorder beside it would write: NMEA 0183 sentences of
//! datagrams with the time before each, frames of a bus as `candump -l` has them.
//!
//! | link | before the packet of IP |
//! |---|---|
//! | 1 | Ethernet, with tags of VLANs or without |
//! | 113, 276 | Linux, any device |
//! | 0, 101 | loopback; nothing |
//! | 227 | none: frames of SocketCAN |

use crate::bytes::{Bytes, check_made};
use crate::error::Fault;
use crate::input::Input;

/// Packets are no longer than this.
const LONGEST: usize = 1 << 17;
/// The shortest sentence.
const SHORTEST_LINE: usize = 8;
/// Interfaces of one capture.
const MOST_INTERFACES: usize = 256;
/// Types of blocks of pcapng.
const SECTION: u32 = 0x0a0d_0d0a;
const INTERFACE: u32 = 1;
const PACKET: u32 = 6;
/// The option that says how many counts a second has.
const RESOLUTION: u16 = 9;
const UDP: u8 = 17;
const TCP: u8 = 6;

/// Does a capture begin so?
pub(crate) fn is_start(start: &[u8]) -> bool {
    start.starts_with(&SECTION.to_be_bytes()) || resolution(start).is_some()
}

/// Counts in a second and whether numbers begin with their last byte, of a capture that is not pcapng.
fn resolution(start: &[u8]) -> Option<(f64, bool)> {
    Some(match start.get(..4)? {
        [0xd4, 0xc3, 0xb2, 0xa1] => (1e6, true),
        [0xa1, 0xb2, 0xc3, 0xd4] => (1e6, false),
        [0x4d, 0x3c, 0xb2, 0xa1] => (1e9, true),
        [0xa1, 0xb2, 0x3c, 0x4d] => (1e9, false),
        _ => return None,
    })
}

/// The lines of a capture.
pub(crate) fn lines(file: Input) -> Result<Input, Fault> {
    let mut bytes = Bytes::new(file)?;
    let mut text = String::new();
    let is_whole = match resolution(bytes.peek(24)?) {
        Some(resolution) => plain(&mut bytes, resolution, &mut text)?,
        None => next_generation(&mut bytes, &mut text)?,
    };
    if text.is_empty() {
        return Err(Fault::NothingToRead {
            format: "capture of a network",
            what: "expected NMEA 0183 sentences in datagrams, or frames of a CAN bus".into(),
        });
    }
    if !is_whole {
        text.push('$');
    }
    Input::made_of(text.into_bytes(), bytes.file()).map_err(Fault::read)
}

fn word(bytes: &[u8], at: usize, is_little: bool) -> Option<u32> {
    let word = *bytes.get(at..)?.first_chunk()?;
    Some(match is_little {
        true => u32::from_le_bytes(word),
        false => u32::from_be_bytes(word),
    })
}

fn half(bytes: &[u8], at: usize, is_little: bool) -> Option<u16> {
    let half = *bytes.get(at..)?.first_chunk()?;
    Some(match is_little {
        true => u16::from_le_bytes(half),
        false => u16::from_be_bytes(half),
    })
}

/// Records of a time, lengths and a packet; `false` where the last is cut off.
fn plain(bytes: &mut Bytes, of: (f64, bool), text: &mut String) -> Result<bool, Fault> {
    let (per_second, is_little) = of;
    let link = word(bytes.seen(), 20, is_little).unwrap_or(0) & 0xffff;
    bytes.skip(24);
    loop {
        let head = bytes.peek(16)?;
        if head.is_empty() {
            return Ok(true);
        }
        let number = |at| word(head, at, is_little);
        let (Some(seconds), Some(counts), Some(length)) = (number(0), number(4), number(8)) else {
            return Ok(false);
        };
        let end = 16 + length as usize;
        if length as usize > LONGEST || bytes.peek(end)?.len() < end {
            return Ok(false);
        }
        let time_s = f64::from(seconds) + f64::from(counts) / per_second;
        packet(link, &bytes.seen()[16..end], time_s, text);
        check_made(text.len(), "capture of a network", "cut it with editcap")?;
        bytes.skip(end);
    }
}

/// Blocks; `false` where the last is cut off.
fn next_generation(bytes: &mut Bytes, text: &mut String) -> Result<bool, Fault> {
    let mut is_little = true;
    let mut interfaces: Vec<(u32, f64)> = Vec::new();
    loop {
        let head = bytes.peek(12)?;
        if head.is_empty() {
            return Ok(true);
        }
        if head.starts_with(&SECTION.to_be_bytes()) {
            is_little = head.get(8) == Some(&0x4d);
            interfaces.clear();
        }
        let number = |at| word(head, at, is_little);
        let (Some(kind), Some(length)) = (number(0), number(4)) else {
            return Ok(false);
        };
        let length = length as usize;
        if !(12..=LONGEST).contains(&length) || bytes.peek(length)?.len() < length {
            return Ok(false);
        }
        let block = &bytes.seen()[8..length - 4];
        match kind {
            INTERFACE if interfaces.len() < MOST_INTERFACES => {
                let link = half(block, 0, is_little).unwrap_or(0);
                interfaces.push((link.into(), per_second(block, is_little)));
            }
            PACKET => {
                let number = |at| word(block, at, is_little);
                let parts = [number(0), number(4), number(8), number(12)];
                if let [Some(interface), Some(high), Some(low), Some(length)] = parts
                    && let Some((link, per_second)) = interfaces.get(interface as usize)
                    && let Some(data) = block.get(20..20 + length as usize)
                {
                    let counts = (u64::from(high) << 32 | u64::from(low)) as f64;
                    packet(*link, data, counts / per_second, text);
                    check_made(text.len(), "capture of a network", "cut it with editcap")?;
                }
            }
            _ => {}
        }
        bytes.skip(length);
    }
}

/// Counts in a second of an interface: a million where no option says another.
fn per_second(block: &[u8], is_little: bool) -> f64 {
    let mut at = 8;
    while let (Some(option), Some(length)) =
        (half(block, at, is_little), half(block, at + 2, is_little))
    {
        match (option, block.get(at + 4)) {
            (RESOLUTION, Some(power)) if power & 0x80 != 0 => {
                return libm::exp2(f64::from(power & 0x7f));
            }
            (RESOLUTION, Some(power)) => return libm::pow(10.0, f64::from(*power)),
            (0, _) => break,
            _ => at += 4 + usize::from(length).next_multiple_of(4),
        }
    }
    1e6
}

/// Adds the lines of a packet.
fn packet(link: u32, data: &[u8], time_s: f64, text: &mut String) {
    let added = match link {
        227 => frame(data).map(|frame| format!("({time_s:.6}) can0 {frame}\n")),
        _ => payload(link, data).map(|payload| sentences(payload, time_s)),
    };
    text.extend(added);
}

/// A frame with an identifier of 29 bits, as candump writes it.
fn frame(data: &[u8]) -> Option<String> {
    const LONG: u32 = 1 << 31;
    let id = word(data, 0, false).filter(|id| id & LONG != 0)? & 0x1fff_ffff;
    let length = usize::from(*data.get(4)?).min(8);
    let hex: String = data.get(8..8 + length)?.iter().map(|byte| format!("{byte:02X}")).collect();
    Some(format!("{id:08X}#{hex}"))
}

/// What a datagram or a stream carries in a packet.
fn payload(link: u32, data: &[u8]) -> Option<&[u8]> {
    let mut at = match link {
        0 => 4,
        1 => 14,
        113 => 16,
        276 => 20,
        _ => 0,
    };
    if link == 1 && half(data, 12, false) == Some(0x8100) {
        at += 4;
    }
    let packet = data.get(at..)?;
    let first = *packet.first()?;
    let (protocol, carried) = match first >> 4 {
        4 => (*packet.get(9)?, packet.get(4 * usize::from(first & 0xf)..)?),
        6 => (*packet.get(6)?, packet.get(40..)?),
        _ => return None,
    };
    match protocol {
        UDP => carried.get(8..),
        TCP => carried.get(4 * usize::from(carried.get(12)? >> 4)..),
        _ => None,
    }
}

/// The sentences among the lines of a payload, each behind its time.
fn sentences(payload: &[u8], time_s: f64) -> String {
    let text = String::from_utf8_lossy(payload);
    let is_sentence = |line: &&str| line.len() >= SHORTEST_LINE && line.contains(['$', '!']);
    let lines = text.lines().filter(is_sentence);
    lines.map(|line| format!("{time_s:.6} {line}\n")).collect()
}
