//! MCAP, which Foxglove opens and ROS 2 plays.

use std::collections::BTreeMap;
use std::io::{self, Write};

use mcap::records::MessageHeader;
use mcap::write::NoSeek;
use mcap::{McapError, WriteOptions, Writer};

use super::ros2::{
    DEFINITION, DEFINITION_ENCODING, MESSAGE_ENCODING, Messages, TOPICS, TYPE_NAME, topic,
};
use super::{Row, RowWriter};

/// Writes rows as MCAP with ROS 2 messages: a topic of `std_msgs/Float64` for each column. Times are whole ns.
pub fn write_mcap(out: impl Write, rows: &[Row]) -> io::Result<()> {
    let mut writer = Box::new(McapWriter::new(out)?);
    for row in rows {
        writer.write(row)?;
    }
    writer.finish()
}

/// MCAP row by row. What was flushed is whole: a file without its end is read up to there.
pub struct McapWriter<W: Write> {
    writer: Writer<NoSeek<W>>,
    schema: u16,
    channels: [Option<u16>; TOPICS],
    messages: Messages,
    sequence: u32,
}

impl<W: Write> McapWriter<W> {
    /// Writes the header.
    pub fn new(out: W) -> io::Result<Self> {
        let mut writer = WriteOptions::new()
            .profile("ros2")
            .library(concat!("seatrial ", env!("CARGO_PKG_VERSION")))
            .compression_threads(0)
            .disable_seeking(true)
            .create(NoSeek::new(out))
            .map_err(as_io)?;
        let schema = writer
            .add_schema(TYPE_NAME, DEFINITION_ENCODING, DEFINITION.as_bytes())
            .map_err(as_io)?;
        Ok(Self {
            writer,
            schema,
            channels: [None; TOPICS],
            messages: Messages::default(),
            sequence: 0,
        })
    }

    /// The channel of a topic, which is there from its first message.
    fn channel(&mut self, number: usize) -> io::Result<u16> {
        if let Some(channel) = self.channels[number] {
            return Ok(channel);
        }
        let channel = self
            .writer
            .add_channel(self.schema, &topic(number), MESSAGE_ENCODING, &BTreeMap::new())
            .map_err(as_io)?;
        self.channels[number] = Some(channel);
        Ok(channel)
    }
}

impl<W: Write> RowWriter for McapWriter<W> {
    fn write(&mut self, row: &Row) -> io::Result<()> {
        let (time_ns, messages) = self.messages.of(row)?;
        for (number, message) in messages {
            let header = MessageHeader {
                channel_id: self.channel(number)?,
                sequence: self.sequence,
                log_time: time_ns,
                publish_time: time_ns,
            };
            self.writer.write_to_known_channel(&header, &message).map_err(as_io)?;
        }
        self.sequence = self.sequence.wrapping_add(1);
        Ok(())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer.flush().map_err(as_io)
    }

    fn finish(mut self: Box<Self>) -> io::Result<()> {
        self.writer.finish().map_err(as_io)?;
        self.writer.into_inner().flush()
    }
}

/// The error of the file, where it is one.
fn as_io(error: McapError) -> io::Error {
    match error {
        McapError::Io(error) => error,
        error => io::Error::other(error),
    }
}
