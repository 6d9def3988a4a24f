//! ArduPilot's logs as topics in Foxglove, read as `seatrial identify` reads them.
//!
//! The topics are those of a recording of seatrial, so that its layout shows a log, too.

mod log;

use std::io::Read;

use foxglove_data_loader::{
    BackfillArgs, DataLoader, DataLoaderArgs, Initialization, Message, MessageIterator,
    MessageIteratorArgs, Problem, reader,
};

pub use log::{Log, Topic};

// Names of its functions are none that other linkers take.
#[cfg(target_arch = "wasm32")]
foxglove_data_loader::export!(Loader);

/// The type of every topic, its definition, and how both are written.
const TYPE: (&str, &str, &str) = ("std_msgs/msg/Float64", "float64 data", "ros2msg");
const MESSAGE_ENCODING: &str = "cdr";

/// What Foxglove asks.
pub struct Loader {
    paths: Vec<String>,
    log: Log,
}

impl Loader {
    /// A loader of a log that has been read.
    pub fn of(log: Log) -> Self {
        Self {
            paths: Vec::new(),
            log,
        }
    }
}

impl DataLoader for Loader {
    type MessageIterator = Messages;
    type Error = String;

    fn new(args: DataLoaderArgs) -> Self {
        Self {
            paths: args.paths,
            log: Log::default(),
        }
    }

    fn initialize(&mut self) -> Result<Initialization, String> {
        if let Some(path) = self.paths.first() {
            let mut bytes = Vec::new();
            let read = reader::open(path).read_to_end(&mut bytes);
            read.map_err(|error| format!("{path}: {error}"))?;
            self.log = Log::read(path, bytes).map_err(|error| error.to_string())?;
        }
        let mut builder = Initialization::builder();
        let (name, definition, encoding) = TYPE;
        let schema = foxglove::Schema::new(name, encoding, definition.as_bytes().to_vec());
        let schema = builder
            .add_schema(schema)
            .message_encoding(MESSAGE_ENCODING);
        for (number, topic) in self.log.topics.iter().enumerate() {
            // Numbers of channels are those of the topics.
            let number = u16::try_from(number).map_err(|error| error.to_string())?;
            let channel = schema.add_channel_with_id(number, topic.name);
            let channel = channel.ok_or("a bug: two topics have one number")?;
            channel.message_count(topic.points.len() as u64);
        }
        let mut builder = builder
            .start_time(self.log.start_ns)
            .end_time(self.log.end_ns);
        for warning in &self.log.warnings {
            builder = builder.add_problem(Problem::warn(warning));
        }
        Ok(builder.build())
    }

    fn create_iter(&mut self, args: MessageIteratorArgs) -> Result<Messages, String> {
        let from = args.start_time.unwrap_or(0);
        let to = args.end_time.unwrap_or(u64::MAX);
        let mut messages: Vec<Message> = args
            .channels
            .iter()
            .filter_map(|number| Some((*number, self.log.topics.get(usize::from(*number))?)))
            .flat_map(|(number, topic)| {
                let within = topic
                    .points
                    .iter()
                    .filter(move |(ns, _)| (from..=to).contains(ns));
                within.map(move |(ns, value)| message(number, *ns, *value))
            })
            .collect();
        messages.sort_by_key(|message| message.log_time);
        Ok(Messages(messages.into_iter()))
    }

    fn get_backfill(&mut self, args: BackfillArgs) -> Result<Vec<Message>, String> {
        let before = args.channels.iter().filter_map(|number| {
            let points = &self.log.topics.get(usize::from(*number))?.points;
            let (ns, value) = points.iter().rev().find(|(ns, _)| *ns <= args.time)?;
            Some(message(*number, *ns, *value))
        });
        Ok(before.collect())
    }
}

/// Messages in the order of time.
pub struct Messages(std::vec::IntoIter<Message>);

impl MessageIterator for Messages {
    type Error = String;

    fn next(&mut self) -> Option<Result<Message, String>> {
        self.0.next().map(Ok)
    }
}

/// CDR in little endian: four bytes say so, then the number.
fn message(channel_id: u16, log_time: u64, value: f64) -> Message {
    let mut data = vec![0, 1, 0, 0];
    data.extend(value.to_le_bytes());
    Message {
        channel_id,
        log_time,
        publish_time: log_time,
        data,
    }
}
