//! A file read forward through a buffer of fixed size.

use std::io::{self, Read, Seek, SeekFrom};
use std::ops::Range;

use crate::error::Fault;
use crate::input::Input;

/// Bytes held at once: more than the longest message of any format that is read through here.
const BUFFER: usize = 1 << 18;

/// Bytes that are made of a file to be read in its place; a text copy of a log is about twice as long as the log.
const MOST_MADE: usize = 1 << 29;

/// What zstd begins with.
pub(crate) const ZSTD: &[u8] = b"\x28\xb5\x2f\xfd";

/// The bytes of a file, forward and more than once, through a buffer of fixed size: no file makes it larger.
pub struct Bytes {
    file: Input,
    buffer: Vec<u8>,
    unread: Range<usize>,
    position: u64,
    at_end: bool,
    is_line_ended: bool,
    /// What of them is no message.
    pub damage: Damage,
}

/// What bytes begin with, as a format of packets says it.
pub(crate) enum Found<P> {
    /// A sound packet.
    Packet(P),
    /// None within so many bytes.
    Nothing(usize),
    /// A packet that the file ends within.
    Cut,
}

/// An error where more is made of a file of this format than can be held, with what to give in its place.
pub(crate) fn check_made(length: usize, format: &'static str, instead: &str) -> Result<(), Fault> {
    if length <= MOST_MADE {
        return Ok(());
    }
    let what = format!("more than {} MB; {instead}", MOST_MADE >> 20);
    Err(Fault::TooMuch { format, what })
}

impl Bytes {
    /// From the first byte.
    pub(crate) fn new(file: Input) -> Result<Self, Fault> {
        let mut bytes = Self {
            file,
            buffer: vec![0; BUFFER],
            unread: 0..0,
            position: 0,
            at_end: false,
            is_line_ended: true,
            damage: Damage::default(),
        };
        bytes.go_to(0)?;
        Ok(bytes)
    }

    /// Goes on at this byte.
    ///
    /// # Errors
    /// The operating system refuses.
    pub fn go_to(&mut self, position: u64) -> Result<(), Fault> {
        self.file.seek(SeekFrom::Start(position)).map_err(Fault::read)?;
        self.unread = 0..0;
        self.position = position;
        self.at_end = false;
        Ok(())
    }

    /// Goes on at the first byte, as if nothing had been read.
    pub(crate) fn begin_again(&mut self) -> Result<(), Fault> {
        self.damage = Damage::default();
        self.go_to(0)
    }

    /// The next `count` bytes and what else the buffer holds; fewer only at the end of the file, or where the buffer of 256 KiB holds no more.
    ///
    /// # Errors
    /// The operating system refuses.
    pub fn peek(&mut self, count: usize) -> Result<&[u8], Fault> {
        if self.unread.len() < count && !self.at_end {
            self.buffer.copy_within(self.unread.clone(), 0);
            self.unread = 0..self.unread.len();
            while self.unread.len() < count.min(BUFFER) && !self.at_end {
                match self.file.read(&mut self.buffer[self.unread.end..]) {
                    Ok(0) => self.at_end = true,
                    Ok(read) => self.unread.end += read,
                    Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                    Err(error) => return Err(Fault::read(error)),
                }
            }
        }
        Ok(self.seen())
    }

    /// What the last peek saw and is not passed yet.
    pub fn seen(&self) -> &[u8] {
        &self.buffer[self.unread.clone()]
    }

    /// Adds the next `count` bytes, or as many as there are; `false` where there are fewer.
    #[cfg(feature = "containers")]
    pub(crate) fn take(&mut self, count: usize, taken: &mut Vec<u8>) -> Result<bool, Fault> {
        let mut left = count;
        while left > 0 {
            let seen = self.peek(left.min(BUFFER))?;
            let some = seen.len().min(left);
            if some == 0 {
                return Ok(false);
            }
            taken.extend_from_slice(&seen[..some]);
            self.skip(some);
            left -= some;
        }
        Ok(true)
    }

    /// Bytes of the file.
    #[cfg(any(feature = "mcap-reader", feature = "containers"))]
    pub(crate) fn length(&self) -> Result<u64, Fault> {
        self.file.length().map_err(Fault::read)
    }

    /// The next line without its end, and no more of it than the buffer holds; `None` at the end.
    ///
    /// # Errors
    /// The operating system refuses.
    pub fn line(&mut self) -> Result<Option<&[u8]>, Fault> {
        let mut asked = 1 << 12;
        let (length, end) = loop {
            let seen = self.peek(asked)?;
            match seen.iter().position(|byte| *byte == b'\n') {
                Some(at) => break (at, at + 1),
                None if seen.is_empty() => return Ok(None),
                None if seen.len() < asked || asked == BUFFER => break (seen.len(), seen.len()),
                None => asked = (4 * asked).min(BUFFER),
            }
        };
        let from = self.unread.start;
        self.skip(end);
        self.is_line_ended = end > length;
        Ok(Some(self.buffer[from..from + length].trim_ascii()))
    }

    /// Is the line that was read last the file's last, and without an end?
    pub fn is_line_cut(&self) -> bool {
        !self.is_line_ended && self.at_end && self.unread.is_empty()
    }

    /// Notes that the line that was read last, of this position and length, is none: cut off where it is the last.
    pub fn not_a_line(&mut self, position: u64, length: usize) {
        match self.is_line_cut() {
            true => self.damage.cut_at = Some(position),
            false => self.damage.skipped(position, length),
        }
    }

    /// Passes over bytes that were seen.
    pub fn skip(&mut self, count: usize) {
        let count = count.min(self.unread.len());
        self.unread.start += count;
        self.position += count as u64;
    }

    /// Goes to the next sound packet; `None` at the end. What is none is damage. `found` is asked of the next `count` bytes and what else
    /// the buffer holds, fewer only at the end.
    pub(crate) fn find_packet<P>(
        &mut self,
        count: usize,
        found: impl Fn(&[u8]) -> Found<P>,
    ) -> Result<Option<P>, Fault> {
        loop {
            let position = self.position;
            let seen = self.peek(count)?;
            let passed = match found(seen) {
                Found::Packet(packet) => return Ok(Some(packet)),
                _ if seen.is_empty() => return Ok(None),
                Found::Nothing(passed) => passed,
                Found::Cut => {
                    let rest = seen.len();
                    self.damage.cut_at = Some(position);
                    self.skip(rest);
                    return Ok(None);
                }
            };
            self.damage.skipped(position, passed);
            self.skip(passed);
        }
    }

    /// Bytes before the next.
    pub fn position(&self) -> u64 {
        self.position
    }

    /// The file, whose place is lost.
    pub(crate) fn file(&mut self) -> &mut Input {
        &mut self.file
    }

    /// SHA-256 of the whole file in hexadecimal; the next byte is the first.
    pub(crate) fn sha256(&mut self) -> Result<String, Fault> {
        let hash = self.file.sha256().map_err(Fault::read)?;
        self.go_to(0)?;
        Ok(hash)
    }
}

/// Text up to the first zero byte; what is not UTF-8 is replaced.
pub(crate) fn text_of(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|byte| *byte == 0);
    String::from_utf8_lossy(&bytes[..end.unwrap_or(bytes.len())]).into_owned()
}

/// Bytes that were no message, for the warnings.
#[derive(Clone, Copy, Debug, Default)]
pub struct Damage {
    /// Number of runs of such bytes.
    pub places: u64,
    /// Number of such bytes.
    pub bytes: u64,
    /// Where an incomplete message at the end of the file begins.
    pub cut_at: Option<u64>,
    previous_end: Option<u64>,
}

impl Damage {
    /// Notes that bytes at this position are left out.
    pub fn skipped(&mut self, position: u64, count: usize) {
        if self.previous_end != Some(position) {
            self.places += 1;
        }
        self.bytes += count as u64;
        self.previous_end = Some(position + count as u64);
    }

    /// For people.
    pub fn warnings(&self) -> Vec<String> {
        let skipped = (self.bytes > 0).then(|| {
            format!(
                "{} bytes in {} places are no messages and are left out",
                self.bytes, self.places
            )
        });
        let cut = self.cut_at.map(|position| {
            format!(
                "the file is cut off: the message that begins at byte {position} is incomplete; everything before it is read"
            )
        });
        skipped.into_iter().chain(cut).collect()
    }
}
