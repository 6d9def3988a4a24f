//! Logs of Expedition and of yacht recorders like it: names of channels in the first line, their numbers in the second, and rows of a
//! boat, a time in days and pairs of number and value.
//!
//! ```text
//! !Boat,Utc,BSP,HDG
//! !boat,0,1,13
//! 0,44259.520833,1,6.102,13,45.10
//! ```

use std::collections::{BTreeMap, VecDeque};

use crate::bytes::Bytes;
use crate::clock::days_unix_s;
use crate::error::Fault;
use crate::input::Input;
use crate::joined::{Kind, Message, Messages};

const MOST_KINDS: usize = 10_000;
/// The channel of the time.
const TIME: u32 = 0;

/// A log of pairs.
pub(crate) struct Pairs {
    bytes: Bytes,
    /// Names of channels by their numbers.
    names: BTreeMap<u32, String>,
    kinds: Vec<Kind>,
    /// Kind by boat and channel.
    kind_of: BTreeMap<(u32, u32), usize>,
    ready: VecDeque<(usize, f64, f64)>,
}

/// Does a file begin with names and numbers of channels?
pub(crate) fn is_start(start: &[u8]) -> bool {
    let text = String::from_utf8_lossy(start);
    names(&mut text.lines()).is_some()
}

/// The names of the channels, from the first two lines.
fn names<'a>(lines: &mut impl Iterator<Item = &'a str>) -> Option<BTreeMap<u32, String>> {
    let mut of_line = || {
        let line = lines.next()?.trim().strip_prefix('!')?;
        Some(
            line.split(',')
                .map(|cell| cell.trim().to_owned())
                .collect::<Vec<_>>(),
        )
    };
    let (names, numbers) = (of_line()?, of_line()?);
    let numbers = numbers.iter().skip(1).map(|number| number.parse().ok());
    let pairs = numbers.zip(names.iter().skip(1).cloned());
    let named: Option<BTreeMap<u32, String>> =
        pairs.map(|(number, name)| Some((number?, name))).collect();
    named.filter(|named| named.contains_key(&TIME))
}

/// The unit of a channel, which these recorders never write: angles are in degrees, speeds in knots.
fn unit(name: &str) -> &'static str {
    let name = name.to_ascii_lowercase();
    match name.as_str() {
        "hdg" | "heading" | "heel" => " (deg)",
        _ if name.starts_with("rudder") => " (deg)",
        "bsp" | "sog" => " (kn)",
        _ => "",
    }
}

/// A boat, its time, and pairs of a number and a value.
type Numbered = (u32, f64, Vec<(u32, f64)>);

/// Boat, time and pairs of a row. The time's own number may stand before it.
fn row(line: &str) -> Option<Numbered> {
    let cells: Vec<&str> = line.split(',').map(str::trim).collect();
    let boat = cells.first()?.parse().ok()?;
    let from = match cells.len() % 2 {
        0 => 1,
        _ => 2,
    };
    if from == 2 && cells.get(1)?.parse::<u32>().ok()? != TIME {
        return None;
    }
    let time_s = days_unix_s(cells.get(from)?.parse().ok()?)?;
    let pairs = cells[from + 1..]
        .chunks_exact(2)
        .map(|pair| Some((pair[0].parse().ok()?, pair[1].parse().unwrap_or(f64::NAN))));
    Some((boat, time_s, pairs.collect::<Option<_>>()?))
}

impl Pairs {
    /// Reads the file once for its channels.
    pub fn open(file: Input) -> Result<Self, Fault> {
        let mut bytes = Bytes::new(file)?;
        let mut head = Vec::new();
        while let Some(line) = bytes.line()?.filter(|_| head.len() < 2) {
            head.push(String::from_utf8_lossy(line).into_owned());
        }
        let names = names(&mut head.iter().map(String::as_str)).unwrap_or_default();
        bytes.begin_again()?;
        let mut log = Self {
            bytes,
            names,
            kinds: Vec::new(),
            kind_of: BTreeMap::new(),
            ready: VecDeque::new(),
        };
        let mut message = Message::default();
        while log.next_value(None, &mut message)? {}
        log.bytes.begin_again()?;
        Ok(log)
    }

    fn next_value(
        &mut self,
        wanted: Option<&[bool]>,
        message: &mut Message,
    ) -> Result<bool, Fault> {
        loop {
            if let Some((kind, time_s, value)) = self.ready.pop_front() {
                if wanted.is_none_or(|wanted| wanted[kind]) {
                    message.kind = kind;
                    message.time_s = time_s;
                    message.values = vec![value];
                    return Ok(true);
                }
                continue;
            }
            let position = self.bytes.position();
            let Some(line) = self.bytes.line()? else {
                return Ok(false);
            };
            if line.is_empty() || line.starts_with(b"!") {
                continue;
            }
            let length = line.len();
            let line = String::from_utf8_lossy(line).into_owned();
            // A number that was cut off looks whole.
            let Some((boat, time_s, pairs)) = row(&line).filter(|_| !self.bytes.is_line_cut())
            else {
                self.bytes.not_a_line(position, length);
                continue;
            };
            for (channel, value) in pairs {
                if let Some(kind) = self.kind(boat, channel, wanted.is_none()) {
                    self.ready.push_back((kind, time_s, value));
                }
            }
        }
    }

    /// The kind of a boat's channel; the first boat's has the channel's own name.
    fn kind(&mut self, boat: u32, channel: u32, is_new: bool) -> Option<usize> {
        let known = self.kind_of.get(&(boat, channel)).copied();
        if known.is_some() || !is_new || self.kinds.len() == MOST_KINDS {
            return known;
        }
        let name = self.names.get(&channel)?;
        let unit = unit(name);
        let name = match boat {
            0 => format!("{name}{unit}"),
            boat => format!("boat {boat}.{name}{unit}"),
        };
        self.kinds.push(Kind {
            name,
            fields: vec![String::new()],
        });
        self.kind_of.insert((boat, channel), self.kinds.len() - 1);
        Some(self.kinds.len() - 1)
    }
}

impl Messages for Pairs {
    fn kinds(&self) -> &[Kind] {
        &self.kinds
    }

    fn next(&mut self, wanted: &[bool], message: &mut Message) -> Result<bool, Fault> {
        self.next_value(Some(wanted), message)
    }

    fn bytes(&self) -> &Bytes {
        &self.bytes
    }

    fn bytes_mut(&mut self) -> &mut Bytes {
        &mut self.bytes
    }
}
