//! MCAP files with ROS 2 messages in CDR.

use std::collections::BTreeMap;
use std::fs::File;
use std::panic::{AssertUnwindSafe, catch_unwind};

use mcap::records::Record;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};

use crate::bytes::{Bytes, Damage};
use crate::error::{Fault, clipped};
use crate::joined::{Kind, Message, Messages};
use crate::reader::Format;
use crate::ros2::Topics;
use crate::table::Known;

/// The longest record: images are skipped, but pass through memory.
const LONGEST_RECORD: usize = 32 << 20;
/// Read at once.
const PIECE: usize = 1 << 16;
const MOST_CHANNELS: usize = 1 << 16;

/// An MCAP file.
pub(crate) struct Mcap {
    bytes: Bytes,
    reader: LinearReader,
    topics: Topics,
    /// How messages are written that cannot be read.
    other_encodings: Vec<String>,
    is_at_end: bool,
    damage: Damage,
    what: Option<String>,
}

/// A record that matters.
enum Taken {
    Schema {
        id: u16,
        name: String,
        text: String,
    },
    Channel {
        id: u16,
        schema: u16,
        topic: String,
        encoding: String,
    },
    Message {
        channel: u16,
    },
    Other,
    End,
}

impl Mcap {
    /// Reads the file once for the topics with messages.
    pub fn open(file: File) -> Result<Self, Fault> {
        let mut log = Self {
            bytes: Bytes::new(file)?,
            reader: fresh_reader(),
            topics: Topics::default(),
            other_encodings: Vec::new(),
            is_at_end: false,
            damage: Damage::default(),
            what: None,
        };
        let mut schemas = BTreeMap::new();
        let mut channels = BTreeMap::new();
        loop {
            match log.next_record(|_, _, _| ())? {
                Taken::Schema { id, name, text } if schemas.len() < MOST_CHANNELS => {
                    schemas.insert(id, (name, text));
                }
                Taken::Channel {
                    id,
                    schema,
                    topic,
                    encoding,
                } if channels.len() < MOST_CHANNELS => {
                    channels.insert(id, (schema, topic, encoding));
                }
                Taken::Message { channel } if !log.topics.has(channel.into()) => {
                    let Some((schema, topic, encoding)) = channels.remove(&channel) else {
                        continue;
                    };
                    match schemas.get(&schema) {
                        Some((name, text)) if encoding == "cdr" => {
                            log.topics.add(channel.into(), &topic, name, text);
                        }
                        _ => log.other_encodings.push(format!("{topic} ({encoding})")),
                    }
                }
                Taken::End => break,
                _ => {}
            }
        }
        if log.topics.kinds.is_empty() {
            let found = match (&log.what, log.other_encodings.is_empty()) {
                (_, false) => log.other_encodings.join(", "),
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
        log.reader = fresh_reader();
        log.is_at_end = false;
        log.damage = Damage::default();
        Ok(log)
    }

    /// The next record that matters; a message's bytes are given away at once. The library is trusted with
    /// nothing: what it calls broken, or panics on, ends the file.
    fn next_record(&mut self, mut with: impl FnMut(u16, f64, &[u8])) -> Result<Taken, Fault> {
        while !self.is_at_end {
            let reader = &mut self.reader;
            let event = catch_unwind(AssertUnwindSafe(|| match reader.next_event() {
                None => Ok(Next::End),
                Some(Err(error)) => Err(error.to_string()),
                Some(Ok(LinearReadEvent::ReadRequest(count))) => Ok(Next::Read(count)),
                Some(Ok(LinearReadEvent::Record { data, opcode })) => {
                    taken(opcode, data, &mut with).map(Next::Record)
                }
            }));
            match event.unwrap_or_else(|_| Err("its reader gave up".into())) {
                Ok(Next::Read(count)) => {
                    let count = count.clamp(1, PIECE);
                    let seen = self.bytes.peek(count)?;
                    let count = count.min(seen.len());
                    self.reader.insert(count)[..count].copy_from_slice(&seen[..count]);
                    self.reader.notify_read(count);
                    self.bytes.skip(count);
                }
                Ok(Next::Record(Taken::Other)) => {}
                Ok(Next::Record(Taken::End)) => self.is_at_end = true,
                Ok(Next::End) => {
                    self.damage.cut_at = Some(self.bytes.position());
                    self.is_at_end = true;
                }
                Ok(Next::Record(record)) => return Ok(record),
                Err(what) => {
                    self.damage.cut_at = Some(self.bytes.position());
                    self.what = Some(what);
                    self.is_at_end = true;
                }
            }
        }
        Ok(Taken::End)
    }
}

/// What the library asks for or gives.
enum Next {
    Read(usize),
    Record(Taken),
    End,
}

fn fresh_reader() -> LinearReader {
    LinearReader::new_with_options(
        LinearReaderOptions::default()
            .with_skip_end_magic(true)
            .with_record_length_limit(LONGEST_RECORD),
    )
}

fn taken(opcode: u8, data: &[u8], with: &mut impl FnMut(u16, f64, &[u8])) -> Result<Taken, String> {
    const SCHEMA: u8 = 3;
    const CHANNEL: u8 = 4;
    const MESSAGE: u8 = 5;
    const DATA_END: u8 = 15;
    match opcode {
        DATA_END => return Ok(Taken::End),
        SCHEMA | CHANNEL | MESSAGE => {}
        _ => return Ok(Taken::Other),
    }
    let record = mcap::parse_record(opcode, data).map_err(|error| error.to_string())?;
    Ok(match record {
        Record::Schema { header, data } => Taken::Schema {
            id: header.id,
            name: header.name,
            text: match header.encoding.as_str() {
                "ros2msg" => String::from_utf8_lossy(&data).into_owned(),
                _ => String::new(),
            },
        },
        Record::Channel(channel) => Taken::Channel {
            id: channel.id,
            schema: channel.schema_id,
            topic: channel.topic,
            encoding: channel.message_encoding,
        },
        Record::Message { header, data } => {
            with(header.channel_id, header.log_time as f64 / 1e9, &data);
            Taken::Message {
                channel: header.channel_id,
            }
        }
        _ => Taken::Other,
    })
}

impl Messages for Mcap {
    fn format(&self) -> Format {
        Format::Mcap
    }

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
            let record = self.next_record(|channel, log_time_s, body| {
                is_taken = topics.take(channel.into(), log_time_s, body, wanted, message);
            });
            match record {
                Ok(Taken::Message { .. }) if is_taken => break Ok(true),
                Ok(Taken::End) => break Ok(false),
                Ok(_) => {}
                Err(fault) => break Err(fault),
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
