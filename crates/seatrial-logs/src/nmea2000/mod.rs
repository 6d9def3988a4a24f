//! NMEA 2000: frames of a bus, from whatever recorder wrote them.
//!
//! A container gives frames or whole messages; frames of a fast packet are put together here. Every source, and every rudder of a
//! source, is a kind of its own.

mod binary;
mod fast_packet;
mod groups;
mod json;
mod text;

use std::collections::BTreeMap;

use crate::Quantity;
use crate::bytes::{Bytes, Found};
use crate::error::Fault;
use crate::input::Input;
use crate::line_log::LineLog;
use crate::message_table::{FieldNumbers, Kind, Message, Messages, names};
use crate::table::Known;
use fast_packet::FastPackets;
use groups::{CHANNELS, GROUPS, fields};

/// A bus of 250 kbit/s carries no more frames in a second: each has at least 110 bits.
const MOST_PER_S: f64 = 2300.0;
/// This many messages in less time than the bus needs are no burst.
const MANY_MESSAGES: u64 = 1000;
/// A bus is never silent for so long while a log of a manoeuvre is made, s.
const LONGEST_PAUSE_S: f64 = 60.0;
const MOST_KINDS: usize = 1024;
/// The most bytes of a message.
const MOST_BYTES: usize = 223;

/// What a recorder wrote of one frame, or of a whole message.
#[derive(Debug, Default)]
struct Frame {
    time_s: f64,
    number: u32,
    source: u8,
    data: Vec<u8>,
    /// Is it one frame of the bus, and maybe a part of a message?
    is_of_bus: bool,
}

impl Frame {
    /// A frame of the bus with this identifier.
    fn of_bus(time_s: f64, identifier: u32, data: Vec<u8>) -> Self {
        let format = identifier >> 16 & 0xff;
        let page = identifier >> 8 & 0x3_ff00;
        // Below 240 the next byte is who it is for.
        let number = match format < 240 {
            true => page,
            false => page | identifier >> 8 & 0xff,
        };
        Self { time_s, number, source: identifier as u8, data, is_of_bus: true }
    }

    /// A whole message.
    fn of_message(time_s: f64, number: u32, source: u8, data: Vec<u8>) -> Self {
        Self { time_s, number, source, data, is_of_bus: false }
    }

    fn group(&self) -> Option<usize> {
        GROUPS.iter().position(|(number, ..)| *number == self.number)
    }

    fn key(&self) -> Option<(usize, u8, u8)> {
        let group = self.group()?;
        let instance = match GROUPS[group].2 {
            true => *self.data.first()?,
            false => 0,
        };
        Some((group, self.source, instance))
    }

    fn values(&self, group: usize) -> impl Iterator<Item = f64> + '_ {
        fields(group).map(|(_, at, kind, resolution)| {
            kind.below_none(&self.data, at).map_or(f64::NAN, |number| number * resolution)
        })
    }
}

/// What a record is.
enum Piece {
    Frame(Frame),
    /// The time of what follows, s.
    Time(f64),
    /// Sound, and no frame: a comment or a record of the recorder.
    Other,
}

/// How a recorder writes frames.
#[derive(Clone, Copy)]
enum Container {
    Lines(fn(&str) -> Option<Frame>),
    Records(Records),
}

/// Records of bytes.
#[derive(Clone, Copy)]
struct Records {
    /// Reads one; how many bytes it takes.
    read: fn(&[u8]) -> Found<(Piece, usize)>,
    /// The time after which the recorder's clock begins again, s.
    period_s: Option<f64>,
}

/// How the start of a file writes frames; `None` where it has none.
fn container(start: &[u8]) -> Option<Container> {
    binary::container(start)
        .map(Container::Records)
        .or_else(|| text::container(start).map(Container::Lines))
}

/// Is this the start of a file of frames?
pub(crate) fn is_start(start: &[u8]) -> bool {
    container(start).is_some() || json::is_start(start)
}

/// Is this the start of a file of frames without times?
pub(crate) fn is_untimed(start: &[u8]) -> bool {
    text::are_untimed(start)
}

/// Opens a file of frames, or of messages in JSON.
pub(crate) fn open(file: Input) -> Result<Box<dyn Messages>, Fault> {
    let mut bytes = Bytes::new(file)?;
    let start = bytes.peek(START)?;
    if json::is_start(start) {
        return Ok(Box::new(LineLog::open(bytes, json::Analyzed::default())?));
    }
    match container(start) {
        Some(container) => Ok(Box::new(Capture::open(bytes, container)?)),
        None => Err(Fault::Damaged {
            format: "NMEA 2000",
            what: "no frame is found at its beginning".into(),
        }),
    }
}

/// Bytes by which a container is told.
const START: usize = 4096;
/// The longest record of a binary container.
const LONGEST_RECORD: usize = 1024;
const DAY_S: f64 = 86_400.0;

/// A capture.
struct Capture {
    bytes: Bytes,
    container: Container,
    packets: FastPackets,
    kinds: Vec<Kind>,
    /// Kind by group, source and instance.
    kind_of: BTreeMap<(usize, u8, u8), usize>,
    /// Of every field of every kind.
    numbers: Vec<Vec<FieldNumbers>>,
    /// Added to times of a clock that begins again.
    added_s: f64,
    last_s: f64,
    frames: u64,
    /// The last time that stood between frames, s.
    time_before_s: Option<f64>,
    /// Do the frames say no times of their own?
    are_timed_between: bool,
    /// Do the frames say the time since the one before, as `candump -t d` writes it?
    are_timed_by_differences: bool,
}

impl Capture {
    /// Reads the file once for its sources.
    fn open(bytes: Bytes, container: Container) -> Result<Self, Fault> {
        let mut capture = Self {
            bytes,
            container,
            packets: FastPackets::default(),
            kinds: Vec::new(),
            kind_of: BTreeMap::new(),
            numbers: Vec::new(),
            added_s: 0.0,
            last_s: f64::NEG_INFINITY,
            frames: 0,
            time_before_s: None,
            are_timed_between: false,
            are_timed_by_differences: false,
        };
        capture.are_timed_between = capture.has_times_between()?;
        capture.are_timed_by_differences = capture.has_differences()?;
        let (mut first_s, mut last_s) = (f64::INFINITY, f64::NEG_INFINITY);
        while let Some(frame) = capture.next_message()? {
            (first_s, last_s) = (first_s.min(frame.time_s), last_s.max(frame.time_s));
            capture.register(&frame);
        }
        let span_s = last_s - first_s;
        if capture.frames > MANY_MESSAGES && capture.frames as f64 > MOST_PER_S * span_s {
            return Err(Fault::TimeCollapsed {
                messages: capture.frames,
                span_s,
                most_per_s: MOST_PER_S,
            });
        }
        capture.bytes.begin_again()?;
        capture.packets = FastPackets::default();
        capture.time_before_s = None;
        (capture.added_s, capture.last_s) = (0.0, f64::NEG_INFINITY);
        Ok(capture)
    }

    /// Reads a file for times that stand between its frames, where these have none.
    fn has_times_between(&mut self) -> Result<bool, Fault> {
        if matches!(self.container, Container::Lines(_)) {
            return Ok(false);
        }
        let mut have_times = false;
        while let Some(frame) = self.next_frame()? {
            have_times |= frame.time_s.is_finite() && frame.time_s != 0.0;
        }
        self.bytes.begin_again()?;
        Ok(!have_times && self.time_before_s.take().is_some())
    }

    /// Reads a file of lines for times that are those since the frame before: short ones, of which many are shorter than the one before.
    fn has_differences(&mut self) -> Result<bool, Fault> {
        if matches!(self.container, Container::Records(_)) {
            return Ok(false);
        }
        let (mut frames, mut falls, mut largest_s, mut before_s) = (0_u64, 0_u64, 0.0_f64, 0.0);
        while frames < MANY_MESSAGES
            && let Some(frame) = self.next_frame()?
        {
            frames += 1;
            falls += u64::from(frame.time_s < before_s);
            largest_s = largest_s.max(frame.time_s);
            before_s = frame.time_s;
        }
        self.bytes.begin_again()?;
        Ok(largest_s < LONGEST_PAUSE_S && 10 * falls > frames)
    }

    /// The next whole message, of whatever number.
    fn next_message(&mut self) -> Result<Option<Frame>, Fault> {
        loop {
            let Some(mut frame) = self.next_frame()? else {
                return Ok(None);
            };
            if self.are_timed_between {
                frame.time_s = self.time_before_s.unwrap_or(f64::NAN);
            }
            if !frame.time_s.is_finite() {
                continue;
            }
            self.frames += 1;
            frame.time_s = match self.are_timed_by_differences {
                true => self.last_s.max(0.0) + frame.time_s,
                false => frame.time_s,
            };
            frame.time_s = self.going_on(frame.time_s);
            let is_fast = frame.group().is_some() && binary::FAST.contains(&frame.number);
            if !(is_fast && frame.is_of_bus) {
                return Ok(Some(frame));
            }
            if let Some(data) = self.packets.take(frame.number, frame.source, &frame.data) {
                return Ok(Some(Frame { data, ..frame }));
            }
        }
    }

    /// The time on a clock that goes on where the recorder's begins again: at midnight, or where a counter is full.
    fn going_on(&mut self, time_s: f64) -> f64 {
        let begins_again_s = match self.container {
            Container::Records(records) => records.period_s,
            Container::Lines(_) => Some(DAY_S),
        };
        if let Some(period_s) = begins_again_s
            && self.last_s - (time_s + self.added_s) > 0.5 * period_s
        {
            self.added_s += period_s;
        }
        self.last_s = time_s + self.added_s;
        self.last_s
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, Fault> {
        loop {
            match self.container {
                Container::Lines(read) => {
                    let position = self.bytes.position();
                    let Some(line) = self.bytes.line()? else {
                        return Ok(None);
                    };
                    if line.is_empty() || matches!(line[0], b'#' | b';') {
                        continue;
                    }
                    let length = line.len();
                    let line = String::from_utf8_lossy(line).into_owned();
                    match read(&line) {
                        // The last byte of a line that was cut off may be half of one.
                        Some(frame) if !self.bytes.is_line_cut() => return Ok(Some(frame)),
                        Some(frame) if frame.data.len() >= 8 => return Ok(Some(frame)),
                        _ => self.bytes.not_a_line(position, length),
                    }
                }
                Container::Records(records) => {
                    let Some((piece, count)) =
                        self.bytes.find_packet(LONGEST_RECORD, records.read)?
                    else {
                        return Ok(None);
                    };
                    self.bytes.skip(count);
                    match piece {
                        Piece::Frame(frame) => return Ok(Some(frame)),
                        Piece::Time(time_s) => self.time_before_s = Some(time_s),
                        Piece::Other => {}
                    }
                }
            }
        }
    }

    fn register(&mut self, frame: &Frame) {
        let Some(key) = frame.key() else { return };
        let (group, source, instance) = key;
        if !self.kind_of.contains_key(&key) {
            if self.kinds.len() == MOST_KINDS {
                return;
            }
            let (_, name, has_instance) = GROUPS[group];
            self.kind_of.insert(key, self.kinds.len());
            let kind = Kind {
                name: match has_instance {
                    true => format!("{name}.{source}.{instance}"),
                    false => format!("{name}.{source}"),
                },
                fields: fields(group).map(|(name, ..)| name.into()).collect(),
            };
            self.numbers.push(FieldNumbers::of(&kind));
            self.kinds.push(kind);
        }
        let numbers = self.numbers[self.kind_of[&key]].iter_mut();
        for (numbers, value) in numbers.zip(frame.values(group)) {
            numbers.take(value);
        }
    }
}

impl Messages for Capture {
    fn kinds(&self) -> &[Kind] {
        &self.kinds
    }

    fn known(&self) -> Known {
        let mut known = Known::default();
        for (quantity, group, field, unit) in CHANNELS {
            // Of several sources the one that says most, and of those the ones that change.
            let best = self
                .kind_of
                .iter()
                .filter(|((of, ..), _)| GROUPS[*of].1 == group)
                .filter_map(|((of, ..), kind)| {
                    let index = fields(*of).position(|(name, ..)| name == field)?;
                    let numbers = self.numbers[*kind][index];
                    Some(((numbers.changes, numbers.count), *kind))
                })
                .max_by_key(|(says, kind)| (*says, std::cmp::Reverse(*kind)));
            if let Some(((_, 1..), kind)) = best {
                let column = format!("{}.{field}", self.kinds[kind].name);
                known.add(quantity, column, Some(unit), "");
            }
        }
        let found = match self.kinds.is_empty() {
            true => "no message that is read".into(),
            false => names(&self.kinds),
        };
        known.expects(Quantity::Heading, "PGN 127250 or 127257 with a heading", &found);
        known.expects(Quantity::Rudder, "PGN 127245 with a position or an order", &found);
        known
    }

    fn next(&mut self, wanted: &[bool], message: &mut Message) -> Result<bool, Fault> {
        while let Some(frame) = self.next_message()? {
            let Some((group, kind)) = frame
                .key()
                .and_then(|key| Some((key.0, *self.kind_of.get(&key)?)))
                .filter(|(_, kind)| wanted[*kind])
            else {
                continue;
            };
            message.set(kind, frame.time_s, frame.values(group));
            return Ok(true);
        }
        Ok(false)
    }

    fn bytes(&mut self) -> &mut Bytes {
        &mut self.bytes
    }
}
