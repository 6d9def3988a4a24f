//! Logs of lines, each of which holds values of channels: what a format says of a line, and the rest for all of them.

use std::collections::{BTreeMap, VecDeque};

use crate::bytes::Bytes;
use crate::error::Fault;
use crate::message_table::{Kind, Message, Messages};
use crate::table::Known;

/// Channels of a log; those beyond are left out.
const MOST_CHANNELS: usize = 10_000;

/// What a format says of its lines.
pub(crate) trait LineFormat: Send {
    /// What tells one channel from another.
    type Key: Ord + Send;

    /// Gives the values of a line to the channels; `false` where it is no line of this format. One that is cut off is the file's last, and
    /// its last number may look whole.
    fn read(&mut self, line: &str, is_cut: bool, channels: &mut Channels<Self::Key>) -> bool;

    /// What the format knows about channels by their names; where it says nothing these decide.
    fn known(&self, _channels: &Channels<Self::Key>) -> Known {
        Known::default()
    }
}

/// The channels of a log, each a kind of message of one value, and values that wait to be taken.
pub(crate) struct Channels<K> {
    pub kinds: Vec<Kind>,
    pub kind_of: BTreeMap<K, usize>,
    /// Values of each kind.
    pub counts: Vec<u64>,
    ready: VecDeque<(usize, f64, f64)>,
    /// Is the file read for its channels?
    is_first_reading: bool,
}

impl<K: Ord> Channels<K> {
    /// Adds a value at a time, s. A channel is named by its first value, and left out where that gives it no name.
    pub fn add(
        &mut self,
        key: K,
        [time_s, value]: [f64; 2],
        name: impl FnOnce(&Self) -> Option<String>,
    ) {
        if let Some(kind) = self.kind_of.get(&key) {
            self.counts[*kind] += u64::from(self.is_first_reading);
            self.ready.push_back((*kind, time_s, value));
        } else if self.is_first_reading
            && self.kinds.len() < MOST_CHANNELS
            && let Some(name) = name(self)
        {
            self.kind_of.insert(key, self.kinds.len());
            self.counts.push(1);
            self.kinds.push(Kind { name, fields: vec![String::new()] });
        }
    }
}

/// A log of lines.
pub(crate) struct LineLog<F: LineFormat> {
    bytes: Bytes,
    format: F,
    channels: Channels<F::Key>,
}

impl<F: LineFormat> LineLog<F> {
    /// Reads the file once for its channels.
    pub fn open(bytes: Bytes, format: F) -> Result<Self, Fault> {
        let mut log = Self {
            bytes,
            format,
            channels: Channels {
                kinds: Vec::new(),
                kind_of: BTreeMap::new(),
                counts: Vec::new(),
                ready: VecDeque::new(),
                is_first_reading: true,
            },
        };
        log.bytes.begin_again()?;
        while log.next_line()? {
            log.channels.ready.clear();
        }
        log.channels.is_first_reading = false;
        log.bytes.begin_again()?;
        Ok(log)
    }

    /// Takes in the next line; `false` at the end.
    fn next_line(&mut self) -> Result<bool, Fault> {
        let position = self.bytes.position();
        let Some(line) = self.bytes.line()? else {
            return Ok(false);
        };
        let length = line.len();
        let line = String::from_utf8_lossy(line).into_owned();
        let is_cut = self.bytes.is_line_cut();
        if !line.is_empty() && !self.format.read(&line, is_cut, &mut self.channels) {
            self.bytes.not_a_line(position, length);
        }
        Ok(true)
    }
}

impl<F: LineFormat> Messages for LineLog<F> {
    fn kinds(&self) -> &[Kind] {
        &self.channels.kinds
    }

    fn known(&self) -> Known {
        self.format.known(&self.channels)
    }

    fn next(&mut self, wanted: &[bool], message: &mut Message) -> Result<bool, Fault> {
        loop {
            while let Some((kind, time_s, value)) = self.channels.ready.pop_front() {
                if wanted[kind] {
                    message.set(kind, time_s, [value]);
                    return Ok(true);
                }
            }
            if !self.next_line()? {
                return Ok(false);
            }
        }
    }

    fn bytes(&mut self) -> &mut Bytes {
        &mut self.bytes
    }
}
