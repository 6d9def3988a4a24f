//! A live server for Foxglove, with the topics of the MCAP files.

use std::io;
use std::sync::Arc;

use foxglove::{
    Context, FoxgloveError, PartialMetadata, RawChannel, Schema, WebSocketServerHandle,
};

use super::ros2::{
    DEFINITION, DEFINITION_ENCODING, MESSAGE_ENCODING, Messages, TOPICS, TYPE_NAME, topic,
};
use super::{Row, RowWriter};

/// Shows rows to every connected client. There may be none; a client that is too slow misses rows.
pub struct FoxgloveServer {
    host: String,
    server: WebSocketServerHandle,
    channels: Vec<Arc<RawChannel>>,
    /// Server and channels only refer to it.
    _context: Arc<Context>,
    messages: Messages,
}

impl FoxgloveServer {
    /// Listens at a port; port 0 is any that is free.
    pub fn start(host: &str, port: u16) -> io::Result<Self> {
        let context = Context::new();
        let channel = |number| {
            context
                .channel_builder(topic(number))
                .message_encoding(MESSAGE_ENCODING)
                .schema(Schema::new(TYPE_NAME, DEFINITION_ENCODING, DEFINITION.as_bytes()))
                .build_raw()
        };
        let channels = (0..TOPICS).map(channel).collect::<Result<_, _>>();
        Ok(Self {
            host: host.into(),
            channels: channels.map_err(as_io)?,
            server: context
                .websocket_server()
                .name("seatrial")
                .bind(host, port)
                .start_blocking()
                .map_err(as_io)?,
            messages: Messages::default(),
            _context: context,
        })
    }

    /// What to connect to.
    pub fn url(&self) -> String {
        format!("ws://{}:{}", self.host, self.server.port())
    }
}

impl RowWriter for FoxgloveServer {
    fn write(&mut self, row: &Row) -> io::Result<()> {
        let (time_ns, messages) = self.messages.of(row)?;
        for (number, message) in messages {
            let at = PartialMetadata::with_log_time(time_ns);
            self.channels[number].log_with_meta(&message, at);
        }
        Ok(())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }

    fn finish(self: Box<Self>) -> io::Result<()> {
        self.server.stop().detach_all();
        Ok(())
    }
}

fn as_io(error: FoxgloveError) -> io::Error {
    io::Error::other(error)
}
