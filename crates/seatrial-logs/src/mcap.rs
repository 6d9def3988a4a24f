//! MCAP files with ROS 2 messages in CDR.

mod record;
mod unpack;

use std::panic::{AssertUnwindSafe, catch_unwind};

use mcap::McapError;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};

use crate::bytes::Bytes;
use crate::error::{Fault, clipped};
use crate::input::Input;
use crate::message_table::{Kind, Message, Messages};
use crate::number::number;
use crate::ros2::{Topics, nothing_in};
use crate::table::Known;
use record::{Directory, Record};

/// The longest record: images are skipped, but pass through memory.
const LONGEST_RECORD: usize = 32 << 20;
/// Read at once.
const PIECE: usize = 1 << 16;
/// Unpacked bytes for each byte of the file, beyond the longest record: no log has so many.
const MOST_UNPACKED: u64 = 256;
/// What a record counts for at least: reading many short ones takes time, too.
const SHORTEST_COUNTED: usize = 256;
/// Type and length before every record.
const RECORD_HEADER: usize = 9;
/// The last record, 20 bytes behind its header, and the magic behind it.
const FOOTER: usize = RECORD_HEADER + 20 + MAGIC.len();
/// Of the footer the summary's checksum covers what stands before it.
const SUMMED_OF_FOOTER: u64 = RECORD_HEADER as u64 + 16;
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
    what: Option<String>,
    /// A record of the file, outside chunks, begins here, not behind what has been read.
    boundary: u64,
    /// Are messages given before the checksum of their chunk was seen?
    is_streaming: bool,
    is_summary_damaged: bool,
}

impl Mcap {
    /// Finds the topics with messages: from the summary at the end, or by reading the file once.
    pub fn open(file: Input) -> Result<Self, Fault> {
        let mut log = Self {
            bytes: Bytes::new(file)?,
            reader: new_reader(LinearReaderOptions::default()),
            topics: Topics::default(),
            unpacked: 0,
            is_at_end: false,
            what: None,
            boundary: MAGIC.len() as u64,
            is_streaming: false,
            is_summary_damaged: false,
        };
        let directory = match log.summary()? {
            Some(directory) => directory,
            None => log.first_pass()?,
        };
        let (topics, others) = directory.topics();
        log.topics = topics;
        if log.topics.kinds.is_empty() {
            let expected = "topics with messages in CDR";
            let nothing = log.what.as_deref().unwrap_or("no messages");
            return Err(nothing_in("MCAP", expected, &others, nothing));
        }
        log.bytes.begin_again()?;
        log.unpacked = 0;
        log.is_at_end = false;
        log.what = None;
        log.boundary = MAGIC.len() as u64;
        log.is_streaming = false;
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
        let sum = number::<u32>(footer, RECORD_HEADER + 16).unwrap_or(0);
        self.bytes.go_to(start)?;
        if sum != 0 && self.sum_until(footer_at + SUMMED_OF_FOOTER)? != sum {
            self.is_summary_damaged = true;
            return Ok(None);
        }
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

    /// CRC-32 of what lies before this byte.
    fn sum_until(&mut self, end: u64) -> Result<u32, Fault> {
        let mut sum = crc32fast::Hasher::new();
        while self.bytes.position() < end {
            let count = (end - self.bytes.position()).min(PIECE as u64) as usize;
            let seen = self.bytes.peek(count)?;
            let count = count.min(seen.len());
            if count == 0 {
                break;
            }
            sum.update(&seen[..count]);
            self.bytes.skip(count);
        }
        Ok(sum.finalize())
    }

    fn first_pass(&mut self) -> Result<Directory, Fault> {
        self.bytes.begin_again()?;
        let mut directory = Directory::default();
        while self.next_record(|record| directory.take(record))? {}
        self.reader = new_reader(LinearReaderOptions::default());
        Ok(directory)
    }

    /// Gives the next record that matters away; `false` at the end. The library is trusted with nothing: a part that
    /// it calls broken is passed over, and where it panics the file ends.
    fn next_record(&mut self, mut with: impl FnMut(Record)) -> Result<bool, Fault> {
        while !self.is_at_end {
            let reader = &mut self.reader;
            let mut unpacked = 0;
            let event = catch_unwind(AssertUnwindSafe(|| match reader.next_event() {
                None => Next::End,
                Some(Err(error)) => Next::of(&error),
                Some(Ok(LinearReadEvent::ReadRequest(count))) => Next::Read(count),
                Some(Ok(LinearReadEvent::Record { data, opcode })) => {
                    unpacked = SHORTEST_COUNTED.max(data.len());
                    match Record::of(opcode, data) {
                        Some(Record::End) => Next::DataEnd,
                        Some(Record::Other | Record::Statistics(_)) => Next::Skipped,
                        Some(record) => {
                            with(record);
                            Next::Given
                        }
                        None => Next::Broken(format!(
                            "a record of type {opcode} is shorter than it says"
                        )),
                    }
                }
            }));
            self.unpacked += unpacked as u64;
            let most = LONGEST_RECORD as u64 + MOST_UNPACKED * self.bytes.position();
            match event {
                Ok(_) if self.unpacked > most => {
                    self.ends_with(format!("unpacks to more than {MOST_UNPACKED} times its size"));
                }
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
                Ok(Next::End) if self.is_streaming => self.is_cut()?,
                Ok(Next::End | Next::TooLarge) if !self.is_streaming => self.stream()?,
                Ok(Next::End | Next::TooLarge) => {
                    self.pass_over("a record that is too long".into())?;
                }
                Ok(Next::Broken(what)) => self.pass_over(what)?,
                Ok(Next::WrongSum) => self.ends_with("the checksum of its data is wrong".into()),
                Err(_) => self.ends_with("its reader gave up".into()),
            }
        }
        Ok(false)
    }

    fn ends_with(&mut self, what: String) {
        self.what.get_or_insert(what);
        self.is_at_end = true;
    }

    /// The file is cut off, unless its end is there: then a record is longer than was written.
    fn is_cut(&mut self) -> Result<(), Fault> {
        let length = self.bytes.length()?;
        self.bytes.damage.cut_at = Some(self.boundary);
        self.bytes.go_to(length.saturating_sub(MAGIC.len() as u64))?;
        if self.bytes.peek(MAGIC.len())? == MAGIC && length > MAGIC.len() as u64 {
            self.ends_with("a record before its end is longer than the file".into());
        }
        self.bytes.go_to(length)?;
        self.is_at_end = true;
        Ok(())
    }

    /// Reads the part that was being read again, and gives its messages as they come: of a chunk that was cut off the
    /// checksum will never come, and one that is too long is not held in memory.
    fn stream(&mut self) -> Result<(), Fault> {
        self.find_boundary()?;
        self.is_streaming = true;
        self.go_on_at(self.boundary)
    }

    /// Goes on behind the part that was being read.
    fn pass_over(&mut self, what: String) -> Result<(), Fault> {
        let end = self.find_boundary()?;
        let from = self.boundary;
        if end > self.bytes.length()? {
            return match self.is_streaming {
                true => self.is_cut(),
                false => self.stream(),
            };
        }
        let is_first = self.what.is_none();
        self.what.get_or_insert_with(|| format!("the part at byte {from} is left out: {what}"));
        self.bytes.damage.skipped(from, end.saturating_sub(from) as usize);
        if end >= self.bytes.length()? || (!is_first && end <= from) {
            self.is_at_end = true;
            return Ok(());
        }
        self.boundary = end;
        self.is_streaming = false;
        self.go_on_at(end)
    }

    fn go_on_at(&mut self, position: u64) -> Result<(), Fault> {
        let options = LinearReaderOptions::default().with_skip_start_magic(true);
        self.reader = new_reader(match self.is_streaming {
            true => options.with_validate_chunk_crcs(true),
            false => options,
        });
        self.bytes.go_to(position)
    }

    /// Moves the boundary to the record that was being read; where that ends.
    fn find_boundary(&mut self) -> Result<u64, Fault> {
        let read_to = self.bytes.position();
        loop {
            self.bytes.go_to(self.boundary)?;
            let length = number::<u64>(self.bytes.peek(RECORD_HEADER)?, 1);
            let end = length
                .and_then(|length| length.checked_add(self.boundary + RECORD_HEADER as u64))
                .unwrap_or(u64::MAX);
            if end >= read_to {
                return Ok(end);
            }
            self.boundary = end;
        }
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
    /// More than is held in memory.
    TooLarge,
    /// A part that cannot be read, and why.
    Broken(String),
    /// All data were read, and their checksum is another.
    WrongSum,
}

impl Next {
    fn of(error: &McapError) -> Self {
        match error {
            McapError::BadDataCrc { .. } => Self::WrongSum,
            McapError::ChunkTooLarge(_) | McapError::RecordTooLarge { .. } => Self::TooLarge,
            McapError::BadChunkCrc { .. } => Self::Broken("its checksum is wrong".into()),
            error => Self::Broken(error.to_string()),
        }
    }
}

/// Unless it is told to [stream](Mcap::stream), a reader gives no message of a chunk whose checksum is wrong.
fn new_reader(options: LinearReaderOptions) -> LinearReader {
    let (is_streaming, is_from_start) = (options.validate_chunk_crcs, !options.skip_start_magic);
    let options = options
        .with_skip_end_magic(true)
        .with_prevalidate_chunk_crcs(!is_streaming)
        .with_validate_data_section_crc(is_from_start)
        .with_record_length_limit(LONGEST_RECORD);
    unpack::with_rust(LinearReader::new_with_options(options))
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
                if let Record::Message { channel, log_time_s, body } = record {
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

    fn warnings(&self) -> Vec<String> {
        let what = self.what.as_ref();
        let what = what.map(|what| format!("MCAP: {}", clipped(what)));
        let summary = (self.is_summary_damaged)
            .then(|| "MCAP: the checksum of its summary is wrong".to_owned());
        let own = what.into_iter().chain(summary);
        own.chain(self.topics.warnings()).collect()
    }

    fn is_damaged(&self) -> bool {
        self.what.is_some() || self.bytes.damage.bytes > 0 || self.is_summary_damaged
    }
}
