//! Bags of ROS 1 (`.bag`, version 2.0).
//!
//! ```text
//! record = length of head (u32), head, length of data (u32), data;   head = fields of length (u32) and `name=value`
//! ```
//!
//! A chunk's data are records, packed or not: connections, which say what a topic's messages consist of, and messages.

use std::collections::BTreeMap;
use std::io::{self, Read, Take};

use bzip2::read::MultiBzDecoder;
use lz4_flex::frame::FrameDecoder;

use crate::bytes::Bytes;
use crate::error::{Fault, clipped};
use crate::input::Input;
use crate::message_table::{Kind, Message, Messages};
use crate::number::number;
use crate::ros2::{Topics, Wire, nothing_in};
use crate::table::Known;

/// What bags begin with.
const MAGIC: &[u8] = b"#ROSBAG V2.0\n";
/// The longest head of a record: it holds the definition of a message.
const LONGEST_HEAD: usize = 1 << 20;
/// The longest chunk, packed or not; recorders make them of 768 kB.
const LONGEST_CHUNK: usize = 16 << 20;
/// Unpacked bytes for each byte of the file, beyond the longest chunk: no log has so many.
const MOST_UNPACKED: u64 = 256;
const MOST_CONNECTIONS: usize = 10_000;

const MESSAGE: u8 = 2;
const CHUNK: u8 = 5;
const CONNECTION: u8 = 7;

/// A bag.
pub(crate) struct Bag {
    bytes: Bytes,
    topics: Topics,
    /// The records of the chunk that was read last, and where the next begins.
    chunk: Vec<u8>,
    at: usize,
    unpacked: u64,
    what: Option<String>,
}

/// A topic's connection.
#[derive(Default)]
struct Connection {
    topic: String,
    type_name: String,
    definition: String,
    has_messages: bool,
}

/// The fields of a head.
struct Head<'a>(&'a [u8]);

impl<'a> Head<'a> {
    fn field(&self, name: &str) -> Option<&'a [u8]> {
        let mut rest = self.0;
        while !rest.is_empty() {
            let field = piece(&mut rest)?;
            let at = field.iter().position(|byte| *byte == b'=')?;
            if &field[..at] == name.as_bytes() {
                return Some(&field[at + 1..]);
            }
        }
        None
    }

    fn text(&self, name: &str) -> Option<String> {
        Some(String::from_utf8_lossy(self.field(name)?).into_owned())
    }

    fn op(&self) -> Option<u8> {
        self.field("op")?.first().copied()
    }

    /// The number of its connection.
    fn connection(&self) -> Option<u32> {
        number(self.field("conn")?, 0)
    }
}

/// The next bytes behind their length.
fn piece<'a>(rest: &mut &'a [u8]) -> Option<&'a [u8]> {
    let length = number::<u32>(rest, 0)? as usize;
    let piece = rest.get(4..)?.get(..length)?;
    *rest = &rest[4 + length..];
    Some(piece)
}

impl Bag {
    /// Reads the bag once for its topics with messages.
    pub fn open(file: Input) -> Result<Self, Fault> {
        let mut bag = Self {
            bytes: Bytes::new(file)?,
            topics: Topics::of_wire(Wire::Ros1),
            chunk: Vec::new(),
            at: 0,
            unpacked: 0,
            what: None,
        };
        let connections = bag.connections()?;
        for (number, connection) in connections.iter().filter(|(_, c)| c.has_messages) {
            let Connection { topic, type_name, definition, .. } = connection;
            bag.topics.add(u64::from(*number), topic, type_name, definition);
        }
        if bag.topics.kinds.is_empty() {
            let nothing = bag.what.as_deref().unwrap_or("no messages");
            let (expected, unknown) = ("topics with messages", &bag.topics.unknown);
            return Err(nothing_in("bag of ROS 1", expected, unknown, nothing));
        }
        bag.begin()?;
        Ok(bag)
    }

    /// The connections of the whole bag.
    fn connections(&mut self) -> Result<BTreeMap<u32, Connection>, Fault> {
        let mut connections = BTreeMap::<u32, Connection>::new();
        self.begin()?;
        while let Some([head, data]) = self.next_record()? {
            let (head, data) = (Head(&self.chunk[head]), &self.chunk[data]);
            let Some(known) = head.connection() else {
                continue;
            };
            if connections.len() == MOST_CONNECTIONS && !connections.contains_key(&known) {
                continue;
            }
            let connection = connections.entry(known).or_default();
            match head.op() {
                Some(MESSAGE) => connection.has_messages = true,
                Some(CONNECTION) => {
                    let says = Head(data);
                    connection.topic = head.text("topic").unwrap_or_default();
                    connection.type_name = says.text("type").unwrap_or_default();
                    connection.definition = says.text("message_definition").unwrap_or_default();
                }
                _ => {}
            }
        }
        Ok(connections)
    }

    fn begin(&mut self) -> Result<(), Fault> {
        self.bytes.begin_again()?;
        self.bytes.peek(MAGIC.len())?;
        self.bytes.skip(MAGIC.len());
        self.chunk.clear();
        self.at = 0;
        self.unpacked = 0;
        self.what = None;
        Ok(())
    }

    /// The next record of a chunk: where its head and its data stand. `None` at the end, and at what is damaged.
    fn next_record(&mut self) -> Result<Option<[std::ops::Range<usize>; 2]>, Fault> {
        loop {
            let mut rest = &self.chunk[self.at..];
            if !rest.is_empty() {
                let before = rest.len();
                let pieces = piece(&mut rest).zip(piece(&mut rest));
                let Some((head, data)) = pieces else {
                    self.what = Some("a chunk ends within a record".into());
                    self.chunk.clear();
                    self.at = 0;
                    return Ok(None);
                };
                let head = self.at + 4..self.at + 4 + head.len();
                let data = head.end + 4..head.end + 4 + data.len();
                self.at += before - rest.len();
                return Ok(Some([head, data]));
            }
            if !self.next_chunk()? {
                return Ok(None);
            }
        }
    }

    /// Unpacks the next chunk.
    fn next_chunk(&mut self) -> Result<bool, Fault> {
        self.chunk.clear();
        self.at = 0;
        while self.what.is_none() {
            let position = self.bytes.position();
            if self.bytes.peek(1)?.is_empty() {
                return Ok(false);
            }
            let (mut head, mut data) = (Vec::new(), Vec::new());
            let is_whole =
                self.take(LONGEST_HEAD, &mut head)? && self.take(LONGEST_CHUNK, &mut data)?;
            if !is_whole {
                self.bytes.damage.cut_at = self.what.is_none().then_some(position);
                return Ok(false);
            }
            let head = Head(&head);
            match head.op() {
                Some(CHUNK) => {}
                Some(_) => continue,
                None => {
                    self.what = Some(format!("the record at byte {position} has no kind"));
                    return Ok(false);
                }
            }
            let packer = head.text("compression").unwrap_or_default();
            match unpacked(&packer, data) {
                Ok(records) => {
                    self.unpacked += records.len() as u64;
                    let limit = MOST_UNPACKED * self.bytes.length()? + LONGEST_CHUNK as u64;
                    if self.unpacked > limit {
                        self.what = Some("it unpacks to more than any log holds".into());
                        return Ok(false);
                    }
                    self.chunk = records;
                    return Ok(true);
                }
                Err(error) => self.what = Some(format!("the chunk at byte {position}: {error}")),
            }
        }
        Ok(false)
    }

    /// The next bytes behind their length, no more than so many; `false` where they are not there.
    fn take(&mut self, most: usize, taken: &mut Vec<u8>) -> Result<bool, Fault> {
        let Some(length) = number::<u32>(self.bytes.peek(4)?, 0) else {
            return Ok(false);
        };
        if length as usize > most {
            self.what = Some(format!(
                "the record at byte {} says that it has {length} bytes",
                self.bytes.position()
            ));
            return Ok(false);
        }
        self.bytes.skip(4);
        self.bytes.take(length as usize, taken)
    }
}

/// What a chunk's bytes stand for.
fn unpacked(packer: &str, data: Vec<u8>) -> io::Result<Vec<u8>> {
    match packer {
        "none" => Ok(data),
        "bz2" => read_all(MultiBzDecoder::new(&data[..]).take(LONGEST_CHUNK as u64)),
        "lz4" => read_all(FrameDecoder::new(&data[..]).take(LONGEST_CHUNK as u64)),
        other => {
            Err(io::Error::other(format!("chunks packed by `{}` are not read", clipped(other))))
        }
    }
}

fn read_all(mut unpacked: Take<impl Read>) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    unpacked.read_to_end(&mut bytes)?;
    Ok(bytes)
}

impl Messages for Bag {
    fn kinds(&self) -> &[Kind] {
        &self.topics.kinds
    }

    fn known(&self) -> Known {
        self.topics.known()
    }

    fn next(&mut self, wanted: &[bool], message: &mut Message) -> Result<bool, Fault> {
        while let Some([head, data]) = self.next_record()? {
            let head = Head(&self.chunk[head]);
            let time = head.field("time").unwrap_or_default();
            let (Some(MESSAGE), Some(connection), Some(seconds), Some(nanoseconds)) =
                (head.op(), head.connection(), number::<u32>(time, 0), number::<u32>(time, 4))
            else {
                continue;
            };
            let time_s = f64::from(seconds) + f64::from(nanoseconds) / 1e9;
            let body = &self.chunk[data];
            if self.topics.take(connection.into(), time_s, body, wanted, message) {
                return Ok(true);
            }
        }
        Ok(false)
    }

    fn bytes(&mut self) -> &mut Bytes {
        &mut self.bytes
    }

    fn warnings(&self) -> Vec<String> {
        let damage = self.what.iter().map(|what| {
            format!("the bag is damaged ({}); everything before that is read", clipped(what))
        });
        damage.chain(self.topics.warnings()).collect()
    }

    fn is_damaged(&self) -> bool {
        self.what.is_some()
    }
}
