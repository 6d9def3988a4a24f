//! The records of an MCAP file that matter, and what they say of its channels.

use std::collections::{BTreeMap, BTreeSet};

use crate::number::number;
use crate::ros2::Topics;

const MOST_CHANNELS: usize = 1 << 16;

/// A record that matters.
pub(super) enum Record<'a> {
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

pub(super) struct Schema {
    pub(super) name: String,
    pub(super) text: String,
}

pub(super) struct Channel {
    pub(super) schema: u16,
    pub(super) topic: String,
    pub(super) encoding: String,
}

/// What a file says about its channels.
#[derive(Default)]
pub(super) struct Directory {
    pub(super) schemas: BTreeMap<u16, Schema>,
    pub(super) channels: BTreeMap<u16, Channel>,
    pub(super) with_messages: BTreeSet<u16>,
}

impl Directory {
    pub(super) fn take(&mut self, record: Record) {
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
                self.with_messages.extend(counted.map(|(channel, _)| *channel));
            }
            _ => {}
        }
    }

    /// The topics that have messages, and names of those that are no CDR.
    pub(super) fn topics(&self) -> (Topics, Vec<String>) {
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

impl<'a> Record<'a> {
    /// `None` where the record is shorter than it says.
    pub(super) fn of(opcode: u8, data: &'a [u8]) -> Option<Self> {
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
                let text = if encoding == "ros2msg" { text } else { String::new() };
                Self::Schema(number(data, 0)?, Schema { name, text })
            }
            CHANNEL => {
                let (topic, rest) = text(data.get(4..)?)?;
                let (encoding, _) = text(rest)?;
                let schema = number(data, 2)?;
                Self::Channel(number(data, 0)?, Channel { schema, topic, encoding })
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
    let (text, rest) = data.get(4..)?.split_at_checked(number::<u32>(data, 0)? as usize)?;
    Some((String::from_utf8_lossy(text).into_owned(), rest))
}
