//! rosbag2 files in SQLite (`.db3`) with ROS 2 messages in CDR.

mod definitions;
mod sqlite;

use std::fmt::Display;
use std::io::{Read, Seek};
use std::path::Path;

use crate::bytes::{Bytes, ZSTD};
use crate::error::{Fault, clipped};
use crate::input::Input;
use crate::message_table::{Kind, Message, Messages};
use crate::ros2::{Topics, nothing_in, plain};
use crate::table::Known;
use definitions::DEFINITIONS;
use sqlite::Tables;

/// Longer messages are images or clouds.
const LONGEST_MESSAGE: usize = 1 << 20;

/// A bag.
pub(crate) struct Bag {
    bytes: Bytes,
    tables: Tables,
    topics: Topics,
    length: u64,
    rows: i64,
    /// Number of the last message that was fetched.
    last: i64,
    fetched: std::vec::IntoIter<sqlite::StoredMessage>,
    read: i64,
    /// Bytes that the database has when it is whole, where there are fewer.
    cut_from: Option<u64>,
    what: Option<String>,
}

impl Bag {
    /// Finds the topics with messages.
    pub fn open(mut file: Input, path: &Path) -> Result<Self, Fault> {
        let length = file.length().map_err(Fault::read)?;
        let size = Size::of(&mut file)?;
        let cut_from = size.whole().filter(|whole| length < *whole);
        let mut bag = Self {
            tables: Tables::open(&mut file, path, &size)?,
            bytes: Bytes::new(file)?,
            topics: Topics::default(),
            length,
            rows: 0,
            last: i64::MIN,
            fetched: Vec::new().into_iter(),
            read: 0,
            cut_from,
            what: None,
        };
        bag.find_topics().map_err(|error| match cut_from {
            Some(whole) => Fault::Damaged {
                format: "rosbag2",
                what: format!(
                    "{length} of its {whole} bytes are there, and the list of its topics is not among them"
                ),
            },
            None => damaged(&error),
        })?;
        if bag.topics.kinds.is_empty() {
            let (expected, unknown) =
                ("topics in CDR whose definitions it holds", &bag.topics.unknown);
            return Err(nothing_in("rosbag2", expected, unknown, "no topics"));
        }
        Ok(bag)
    }

    fn find_topics(&mut self) -> Result<(), rusqlite::Error> {
        let (rows, topics) = self.tables.topics(self.cut_from.is_some())?;
        self.rows = rows;
        for topic in topics {
            let plain_name = plain(&topic.type_name);
            let built_in = DEFINITIONS.iter().find(|(name, _)| *name == plain_name);
            let definition =
                topic.definition.or_else(|| Some(built_in?.1.to_string())).unwrap_or_default();
            self.topics.add(topic.id as u64, &topic.name, &topic.type_name, &definition);
        }
        Ok(())
    }

    fn fetch(&mut self) -> Result<(), rusqlite::Error> {
        let mut fetched = Vec::new();
        let end = self.tables.fetch(&mut fetched);
        // Behind a number a damaged index can lead to it again, and for ever.
        let mut last = self.last;
        let in_order = fetched.iter().take_while(|message| {
            let is_next = message.id > last;
            last = message.id;
            is_next
        });
        let count = in_order.count();
        if count < fetched.len() {
            self.what = Some("its messages are out of order".into());
            fetched.truncate(count);
        }
        self.last = fetched.last().map_or(self.last, |message| message.id);
        self.fetched = fetched.into_iter();
        end
    }
}

/// What the head of a database says about its size.
pub(crate) struct Size {
    page: u64,
    pages: Option<u64>,
}

impl Size {
    fn of(file: &mut Input) -> Result<Self, Fault> {
        let mut head = Vec::new();
        file.take(100).read_to_end(&mut head).map_err(Fault::read)?;
        file.rewind().map_err(Fault::read)?;
        let page = head.get(16..18).map_or(0, |size| u64::from(size[0]) << 8 | u64::from(size[1]));
        let pages = head.get(28..).and_then(|size| size.first_chunk()).copied();
        // Writers of old left the number of pages as it was.
        let is_current = head.len() == 100 && head[24..28] == head[92..96];
        Ok(Self {
            page: if page == 1 { 1 << 16 } else { page.max(512) },
            pages: pages.filter(|_| is_current).map(|pages| u32::from_be_bytes(pages).into()),
        })
    }

    fn whole(&self) -> Option<u64> {
        Some(self.page * self.pages?)
    }
}

/// A message of a bag that packs each by zstd. No message in CDR begins like that; what cannot be unpacked is left as it is,
/// and counted as one that cannot be decoded.
fn unpacked(data: Vec<u8>) -> Vec<u8> {
    match data.starts_with(ZSTD) {
        true => zstd::bulk::decompress(&data, LONGEST_MESSAGE).unwrap_or(data),
        false => data,
    }
}

fn damaged(error: &impl Display) -> Fault {
    Fault::Damaged { format: "rosbag2", what: clipped(&error.to_string()) }
}

impl Messages for Bag {
    fn kinds(&self) -> &[Kind] {
        &self.topics.kinds
    }

    fn known(&self) -> Known {
        self.topics.known()
    }

    fn next(&mut self, wanted: &[bool], message: &mut Message) -> Result<bool, Fault> {
        loop {
            for stored in self.fetched.by_ref() {
                self.read += 1;
                let time_s = stored.time_ns as f64 / 1e9;
                let data = unpacked(stored.data);
                if self.topics.take(stored.topic as u64, time_s, &data, wanted, message) {
                    return Ok(true);
                }
            }
            // What a damaged database gives before its damage counts.
            if self.what.is_some() {
                return Ok(false);
            }
            match self.fetch() {
                Ok(()) if self.fetched.len() == 0 => return Ok(false),
                Ok(()) => {}
                Err(error) => self.what = Some(clipped(&error.to_string())),
            }
        }
    }

    fn bytes(&mut self) -> &mut Bytes {
        &mut self.bytes
    }

    fn position(&mut self) -> u64 {
        (self.length as f64 * self.read as f64 / self.rows.max(1) as f64) as u64
    }

    fn warnings(&self) -> Vec<String> {
        let what = match (self.cut_from, &self.what) {
            (Some(whole), _) => Some(format!(
                "the file is cut off: {} of its {whole} bytes are there; the messages before the first one that is lost are read",
                self.length
            )),
            (None, what) => what.as_ref().map(|what| {
                format!("the database is damaged ({what}); everything before that is read")
            }),
        };
        let mut warnings: Vec<String> = what.into_iter().collect();
        warnings.extend(self.topics.warnings());
        warnings
    }
}
