//! The write-ahead log beside a logbook: is all there that was committed?
//!
//! SQLite reads it up to the first frame that does not check, in silence. The index in shared memory, which a killed process leaves
//! behind, says how many frames were committed.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use super::connect::beside;

/// Bytes of the header of the log, and of a frame before its page.
const HEADER: usize = 32;
const FRAME: usize = 24;
/// Bytes of one of the two equal headers of the index.
const INDEX: usize = 48;

/// The pages that a log can have.
const PAGE_SIZES: std::ops::RangeInclusive<usize> = 512..=65_536;

/// What is wrong with the write-ahead log of a logbook that nobody has opened yet, in words.
pub(super) fn damage(logbook: &Path) -> Option<&'static str> {
    // In this order: whoever writes adds to the log before the index counts it.
    let index = Index::of(&beside(logbook, "-shm"));
    let log = File::open(beside(logbook, "-wal")).ok()?;
    if log.metadata().is_ok_and(|about| about.len() == 0) {
        // Whoever empties it lets the index begin anew before.
        let later = Index::of(&beside(logbook, "-shm"));
        let is_cut = index.is_some_and(|index| index.frames > 0 && later == Some(index));
        return is_cut.then_some("was emptied before what was committed came into the file");
    }
    let mut log = BufReader::new(log);
    let mut header = [0; HEADER];
    let read = log.read_exact(&mut header).ok();
    let Some(mut frames) = read.and_then(|()| Frames::of(&header)) else {
        return Some("has a beginning that does not check");
    };
    let tail = frames.follow(&mut log);
    let committed = index.filter(|index| index.salts == frames.salts);
    match (committed, tail) {
        (Some(index), _) if index.frames > frames.whole => {
            Some("ends before what was committed, or is damaged")
        }
        (_, Tail::Damaged) => Some("has frames that do not check"),
        (None, Tail::Torn) => Some("ends in the middle of a change"),
        _ => None,
    }
}

/// How many frames were committed, and of which log.
#[derive(PartialEq)]
struct Index {
    frames: u32,
    salts: [u32; 2],
}

impl Index {
    /// `None` where there is none, or it is being written.
    fn of(path: &Path) -> Option<Self> {
        let mut bytes = [0; 2 * INDEX];
        File::open(path).ok()?.read_exact(&mut bytes).ok()?;
        let (one, other) = bytes.split_at(INDEX);
        let is_set = one == other && one.get(12) == Some(&1);
        let frames = one.get(16..20)?.try_into().ok()?;
        is_set.then_some(Self {
            frames: u32::from_ne_bytes(frames),
            // As the log has them.
            salts: [big_endian(one, 32), big_endian(one, 36)],
        })
    }
}

/// What follows the last frame that checks.
enum Tail {
    /// Nothing, or what an earlier log has left.
    Clean,
    /// A change without its end.
    Torn,
    /// Frames of this log that do not follow from those before.
    Damaged,
}

/// The frames of a log as far as they check.
struct Frames {
    salts: [u32; 2],
    page: usize,
    is_big_endian: bool,
    sums: [u32; 2],
    whole: u32,
}

impl Frames {
    fn of(header: &[u8; HEADER]) -> Option<Self> {
        let magic = big_endian(header, 0);
        let page = usize::try_from(big_endian(header, 8)).ok()?;
        let mut frames = Self {
            salts: [big_endian(header, 16), big_endian(header, 20)],
            page,
            is_big_endian: magic & 1 == 1,
            sums: [0; 2],
            whole: 0,
        };
        frames.sums = frames.summed(frames.sums, header.get(..24)?);
        let is_whole = magic & !1 == 0x377f_0682
            && PAGE_SIZES.contains(&page)
            && frames.sums == [big_endian(header, 24), big_endian(header, 28)];
        is_whole.then_some(frames)
    }

    /// Counts the frames that check, up to the last that ends a change.
    fn follow(&mut self, log: &mut impl Read) -> Tail {
        let mut frame = vec![0; FRAME + self.page];
        let mut is_ended = true;
        let mut read = 0;
        loop {
            let length = read_up_to(log, &mut frame);
            let is_of_this_log =
                [big_endian(&frame, 8), big_endian(&frame, 12)] == self.salts && length >= 16;
            if length < frame.len() || !is_of_this_log {
                let is_clean = is_ended && (length == 0 || !is_of_this_log);
                return if is_clean { Tail::Clean } else { Tail::Torn };
            }
            let (header, page) = frame.split_at(FRAME);
            let sums = self.summed(self.sums, header.get(..8).unwrap_or_default());
            let sums = self.summed(sums, page);
            if sums != [big_endian(header, 16), big_endian(header, 20)] {
                return Tail::Damaged;
            }
            self.sums = sums;
            read += 1;
            is_ended = big_endian(header, 4) != 0;
            if is_ended {
                self.whole = read;
            }
        }
    }

    fn summed(&self, sums: [u32; 2], bytes: &[u8]) -> [u32; 2] {
        let word = |at: &[u8]| {
            let word = big_endian(at, 0);
            match self.is_big_endian {
                true => word,
                false => word.swap_bytes(),
            }
        };
        let (pairs, _) = bytes.as_chunks::<8>();
        pairs.iter().fold(sums, |[one, other], pair| {
            let one = one.wrapping_add(word(pair)).wrapping_add(other);
            let other = other.wrapping_add(word(&pair[4..])).wrapping_add(one);
            [one, other]
        })
    }
}

/// Reads until the buffer is full or nothing is left; how much was read.
fn read_up_to(log: &mut impl Read, buffer: &mut [u8]) -> usize {
    let mut length = 0;
    while let Some(rest) = buffer.get_mut(length..).filter(|rest| !rest.is_empty()) {
        match log.read(rest) {
            Ok(0) | Err(_) => break,
            Ok(count) => length += count,
        }
    }
    length
}

/// The number in the four bytes there.
fn big_endian(bytes: &[u8], at: usize) -> u32 {
    let four = bytes.get(at..at + 4).and_then(|four| four.try_into().ok());
    four.map_or(0, u32::from_be_bytes)
}
