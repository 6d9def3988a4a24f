//! MCAP files with ROS 2 messages in CDR.

mod unpack;

use std::collections::{BTreeMap, BTreeSet};
use std::panic::{AssertUnwindSafe, catch_unwind};

use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};

use crate::bytes::{Bytes, Damage};
use crate::error::{Fault, clipped};
use crate::input::Input;
use crate::joined::{Kind, Message, Messages};
use crate::number::number;
use crate::ros2::Topics;
use crate::table::Known;

/// The longest record: images are skipped, but pass through memory.
const LONGEST_RECORD: usize = 32 << 20;
/// Read at once.
const PIECE: usize = 1 << 16;
/// Unpacked bytes for each byte of the file, beyond the longest record: no log has so many.
const MOST_UNPACKED: u64 = 256;
/// What a record counts for at least: reading many short ones takes time, too.
const SHORTEST_COUNTED: usize = 256;
const MOST_CHANNELS: usize = 1 << 16;
/// Type and length before every record.
const RECORD_HEADER: usize = 9;
/// The last record, 20 bytes behind its header, and the magic behind it.
const FOOTER: usize = RECORD_HEADER + 20 + MAGIC.len();
const MAGIC: &[u8] = b"\x89MCAP0\r\n";
/// The longest record of a summary that is read at once.
const LONGEST_SUMMARY: usize = 1 << 17;

/// An MCAP file.
pub(crate) struct Mcap {
    bytes: Bytes,
    reader: LinearReader,
    topics: Topics,
    /// Bytes of the records given so far.
    unpacked: u64,
    is_at_end: bool,
    damage: Damage,
    what: Option<String>,
}

/// A record that matters.
enum Record<'a> {
    Schema(u16, Schema),
    Channel(u16, Channel),
    Message {
        channel: u16,
        log_time_s: f64,
        body: &'a [u8],
    },
    /// How many messages every channel has.
    Statistics(Vec<(u16, u64)>),
    End,
    Other,
}

struct Schema {
    name: String,
    text: String,
}

struct Channel {
    schema: u16,
    topic: String,
    encoding: String,
}

/// What a file says about its channels.
#[derive(Default)]
struct Directory {
    schemas: BTreeMap<u16, Schema>,
    channels: BTreeMap<u16, Channel>,
    with_messages: BTreeSet<u16>,
}

impl Directory {
    fn take(&mut self, record: Record) {
        match record {
            Record::Schema(id, schema) if self.schemas.len() < MOST_CHANNELS => {
                self.schemas.insert(id, schema);
            }
            Record::Channel(id, channel) if self.channels.len() < MOST_CHANNELS => {
                self.channels.insert(id, channel);
            }
            Record::Message { channel, .. } => {
                self.with_messages.insert(channel);
            }
            Record::Statistics(counts) => {
                let counted = counts.iter().filter(|(_, count)| *count > 0);
                self.with_messages
                    .extend(counted.map(|(channel, _)| *channel));
            }
            _ => {}
        }
    }

    /// The topics that have messages, and names of those that are no CDR.
    fn topics(&self) -> (Topics, Vec<String>) {
        let (mut topics, mut others) = (Topics::default(), Vec::new());
        for id in &self.with_messages {
            let Some(channel) = self.channels.get(id) else {
                continue;
            };
            match self.schemas.get(&channel.schema) {
                Some(schema) if channel.encoding == "cdr" => {
                    topics.add((*id).into(), &channel.topic, &schema.name, &schema.text);
                }
                _ => others.push(format!("{} ({})", channel.topic, channel.encoding)),
            }
        }
        (topics, others)
    }
}

impl Mcap {
    /// Finds the topics with messages: from the summary at the end, or by reading the file once.
    pub fn open(file: Input) -> Result<Self, Fault> {
        let mut log = Self {
            bytes: Bytes::new(file)?,
            reader: new_reader(),
            topics: Topics::default(),
            unpacked: 0,
            is_at_end: false,
            damage: Damage::default(),
            what: None,
        };
        let directory = match log.summary()? {
            Some(directory) => directory,
            None => log.first_pass()?,
        };
        let (topics, others) = directory.topics();
        log.topics = topics;
        if log.topics.kinds.is_empty() {
            let found = match (&log.what, others.is_empty()) {
                (_, false) => others.join(", "),
                (Some(what), _) => what.clone(),
                (None, _) => "no messages".into(),
            };
            return Err(Fault::NothingToRead {
                format: "MCAP",
                what: format!(
                    "expected topics with messages in CDR, found {}",
                    clipped(&found)
                ),
            });
        }
        log.bytes.go_to(0)?;
        log.unpacked = 0;
        log.is_at_end = false;
        log.damage = Damage::default();
        log.what = None;
        Ok(log)
    }

    /// What the summary says; `None` where there is none, or not all of it.
    fn summary(&mut self) -> Result<Option<Directory>, Fault> {
        let Some(footer_at) = self.bytes.length()?.checked_sub(FOOTER as u64) else {
            return Ok(None);
        };
        self.bytes.go_to(footer_at)?;
        let footer = self.bytes.peek(FOOTER)?;
        let start = number::<u64>(footer, RECORD_HEADER)
            .filter(|start| (1..footer_at).contains(start) && footer.ends_with(MAGIC));
        let Some(start) = start else {
            return Ok(None);
        };
        self.bytes.go_to(start)?;
        let mut directory = Directory::default();
        let mut has_statistics = false;
        while self.bytes.position() < footer_at {
            let header = self.bytes.peek(RECORD_HEADER)?;
            let opcode = header.first().copied();
            let length = number::<u64>(header, 1).and_then(|length| usize::try_from(length).ok());
            let Some((opcode, length)) = opcode.zip(length.filter(|l| *l <= LONGEST_SUMMARY))
            else {
                return Ok(None);
            };
            let seen = self.bytes.peek(RECORD_HEADER + length)?;
            let Some(record) = seen.get(RECORD_HEADER..RECORD_HEADER + length) else {
                return Ok(None);
            };
            match Record::of(opcode, record) {
                Some(record) => {
                    has_statistics |= matches!(record, Record::Statistics(_));
                    directory.take(record);
                }
                None => return Ok(None),
            }
            self.bytes.skip(RECORD_HEADER + length);
        }
        let is_whole = |id: &u16| {
            let channel = directory.channels.get(id);
            channel.is_some_and(|c| c.schema == 0 || directory.schemas.contains_key(&c.schema))
        };
        Ok((has_statistics && directory.with_messages.iter().all(is_whole)).then_some(directory))
    }

    fn first_pass(&mut self) -> Result<Directory, Fault> {
        self.bytes.go_to(0)?;
        let mut directory = Directory::default();
        while self.next_record(|record| directory.take(record))? {}
        self.reader = new_reader();
        Ok(directory)
    }

    /// Gives the next record that matters away; `false` at the end. The library is trusted with nothing:
    /// what it calls broken, or panics on, ends the file.
    fn next_record(&mut self, mut with: impl FnMut(Record)) -> Result<bool, Fault> {
        while !self.is_at_end {
            let reader = &mut self.reader;
            let mut unpacked = 0;
            let event = catch_unwind(AssertUnwindSafe(|| match reader.next_event() {
                None => Ok(Next::End),
                Some(Err(error)) => Err(error.to_string()),
                Some(Ok(LinearReadEvent::ReadRequest(count))) => Ok(Next::Read(count)),
                Some(Ok(LinearReadEvent::Record { data, opcode })) => {
                    unpacked = SHORTEST_COUNTED.max(data.len());
                    match Record::of(opcode, data) {
                        Some(Record::End) => Ok(Next::DataEnd),
                        Some(Record::Other | Record::Statistics(_)) => Ok(Next::Skipped),
                        Some(record) => {
                            with(record);
                            Ok(Next::Given)
                        }
                        None => Err(format!("a record of type {opcode} is shorter than it says")),
                    }
                }
            }));
            self.unpacked += unpacked as u64;
            let most = LONGEST_RECORD as u64 + MOST_UNPACKED * self.bytes.position();
            let event = match event {
                Ok(_) if self.unpacked > most => Err(format!(
                    "unpacks to more than {MOST_UNPACKED} times its size"
                )),
                event => event.unwrap_or_else(|_| Err("its reader gave up".into())),
            };
            match event {
                Ok(Next::Read(count)) => {
                    let count = count.clamp(1, PIECE);
                    let seen = self.bytes.peek(count)?;
                    let count = count.min(seen.len());
                    self.reader.insert(count)[..count].copy_from_slice(&seen[..count]);
                    self.reader.notify_read(count);
                    self.bytes.skip(count);
                }
                Ok(Next::Skipped) => {}
                Ok(Next::Given) => return Ok(true),
                Ok(Next::DataEnd) => self.is_at_end = true,
                Ok(Next::End) => {
                    self.damage.cut_at = Some(self.bytes.position());
                    self.is_at_end = true;
                }
                Err(what) => {
                    self.damage.cut_at = Some(self.bytes.position());
                    self.what = Some(what);
                    self.is_at_end = true;
                }
            }
        }
        Ok(false)
    }
}

/// What the library asks for or gives.
enum Next {
    Read(usize),
    Given,
    Skipped,
    /// As the file says.
    DataEnd,
    /// Without a word.
    End,
}

fn new_reader() -> LinearReader {
    let options = LinearReaderOptions::default()
        .with_skip_end_magic(true)
        .with_record_length_limit(LONGEST_RECORD);
    unpack::with_rust(LinearReader::new_with_options(options))
}

impl<'a> Record<'a> {
    /// `None` where the record is shorter than it says.
    fn of(opcode: u8, data: &'a [u8]) -> Option<Self> {
        const SCHEMA: u8 = 3;
        const CHANNEL: u8 = 4;
        const MESSAGE: u8 = 5;
        const STATISTICS: u8 = 11;
        const DATA_END: u8 = 15;
        Some(match opcode {
            DATA_END => Self::End,
            SCHEMA => {
                let (name, rest) = text(data.get(2..)?)?;
                let (encoding, rest) = text(rest)?;
                let (text, _) = text(rest)?;
                let text = if encoding == "ros2msg" {
                    text
                } else {
                    String::new()
                };
                Self::Schema(number(data, 0)?, Schema { name, text })
            }
            CHANNEL => {
                let (topic, rest) = text(data.get(4..)?)?;
                let (encoding, _) = text(rest)?;
                let schema = number(data, 2)?;
                Self::Channel(
                    number(data, 0)?,
                    Channel {
                        schema,
                        topic,
                        encoding,
                    },
                )
            }
            MESSAGE => Self::Message {
                channel: number(data, 0)?,
                log_time_s: number::<u64>(data, 6)? as f64 / 1e9,
                body: data.get(22..)?,
            },
            STATISTICS => {
                let length = number::<u32>(data, 42)? as usize;
                let counts = data.get(46..46_usize.checked_add(length)?)?;
                let counts = counts.chunks_exact(10);
                let count = |of: &[u8]| number(of, 0).zip(number(of, 2));
                Self::Statistics(counts.filter_map(count).collect())
            }
            _ => Self::Other,
        })
    }
}

/// A text behind its length, and what follows it.
fn text(data: &[u8]) -> Option<(String, &[u8])> {
    let (text, rest) = data
        .get(4..)?
        .split_at_checked(number::<u32>(data, 0)? as usize)?;
    Some((String::from_utf8_lossy(text).into_owned(), rest))
}

impl Messages for Mcap {
    fn kinds(&self) -> &[Kind] {
        &self.topics.kinds
    }

    fn known(&self) -> Known {
        self.topics.known()
    }

    fn next(&mut self, wanted: &[bool], message: &mut Message) -> Result<bool, Fault> {
        let mut topics = std::mem::take(&mut self.topics);
        let mut is_taken = false;
        let found = loop {
            let more = self.next_record(|record| {
                if let Record::Message {
                    channel,
                    log_time_s,
                    body,
                } = record
                {
                    is_taken = topics.take(channel.into(), log_time_s, body, wanted, message);
                }
            });
            match more {
                Ok(true) if !is_taken => {}
                end => break end,
            }
        };
        self.topics = topics;
        found
    }

    fn bytes(&mut self) -> &mut Bytes {
        &mut self.bytes
    }

    fn position(&self) -> u64 {
        self.bytes.position()
    }

    fn warnings(&self) -> Vec<String> {
        let mut warnings = self.damage.warnings();
        warnings.extend(
            self.what
                .iter()
                .map(|what| format!("MCAP: {}", clipped(what))),
        );
        warnings.extend(self.topics.warnings());
        warnings
    }
}
