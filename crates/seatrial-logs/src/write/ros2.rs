//! Rows as ROS 2 messages: each column is a topic of `std_msgs/Float64`, which every viewer plots.

use std::io;

use super::{COLUMNS, Row};

/// The type of every topic.
pub(crate) const TYPE_NAME: &str = "std_msgs/msg/Float64";
/// Its definition.
pub(crate) const DEFINITION: &str = "float64 data";
/// How definitions and messages are written.
pub(crate) const DEFINITION_ENCODING: &str = "ros2msg";
pub(crate) const MESSAGE_ENCODING: &str = "cdr";

/// Topics, one for each column but the time.
pub(crate) const TOPICS: usize = COLUMNS.len() - 1;

/// The topic of a number up to [`TOPICS`].
pub(crate) fn topic(number: usize) -> String {
    format!("/{}", COLUMNS[1 + number].name)
}

/// A topic's number and its message.
pub(crate) type Message = (usize, [u8; 12]);

/// Rows in the order of time as messages.
#[derive(Default)]
pub(crate) struct Messages {
    /// Topics whose last message was a number.
    has_value: [bool; TOPICS],
}

impl Messages {
    /// The time of a row, ns, and its messages with the numbers of their topics.
    ///
    /// What a row lacks is one message of NaN after the last value, since readers hold the last one.
    pub fn of(&mut self, row: &Row) -> io::Result<(u64, Vec<Message>)> {
        let time_ns = time_ns(row.sample.time_s)?;
        let mut messages = Vec::with_capacity(TOPICS);
        for (number, (column, has_value)) in
            COLUMNS[1..].iter().zip(&mut self.has_value).enumerate()
        {
            let value = (column.value)(row);
            if value.is_some() || *has_value {
                messages.push((number, float64(value.unwrap_or(f64::NAN))));
            }
            *has_value = value.is_some();
        }
        Ok((time_ns, messages))
    }
}

/// A `Float64` in CDR: four bytes that say little-endian, then the number.
fn float64(value: f64) -> [u8; 12] {
    let mut message = [0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];
    message[4..].copy_from_slice(&value.to_le_bytes());
    message
}

fn time_ns(time_s: f64) -> io::Result<u64> {
    let time_ns = (time_s * 1e9).round();
    if (0.0..=u64::MAX as f64).contains(&time_ns) {
        Ok(time_ns as u64)
    } else {
        Err(io::Error::new(
            io::ErrorKind::InvalidInput,
            "a sample has no time after 1970, which ROS 2 needs; it is left out",
        ))
    }
}
