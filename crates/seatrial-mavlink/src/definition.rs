//! What a message holds, for readers of logs.

use crate::field::Numbers;

/// A message that is read: fields in the order of the wire.
pub struct Definition {
    /// Number of the message.
    pub id: u32,
    /// Name in the MAVLink definitions.
    pub name: &'static str,
    /// Seed of the checksum.
    pub(crate) crc_extra: u8,
    /// The time it carries.
    pub clock: MessageClock,
    pub(crate) fields: &'static [LoggedField],
}

/// The time in a message.
#[derive(Clone, Copy, PartialEq)]
pub enum MessageClock {
    /// Milliseconds since boot.
    BootMilliseconds,
    /// 32 bits, which start again after 71 minutes.
    BootMicroseconds,
    /// The message has no time.
    None,
}

/// A field of a message that is logged.
pub(crate) struct LoggedField {
    /// Names of its numbers in the MAVLink definitions.
    pub names: &'static [&'static str],
    pub width: usize,
    pub numbers: Numbers,
}

impl Definition {
    /// The number in a field of a payload.
    pub fn field(&self, payload: &[u8], name: &str) -> Option<f64> {
        let mut numbers = self.number_names().zip(self.numbers(payload));
        numbers.find(|(field, _)| *field == name).map(|(_, number)| number)
    }

    /// Every number of a payload, in the order of the wire.
    pub fn numbers<'a>(&'a self, payload: &'a [u8]) -> impl Iterator<Item = f64> + 'a {
        let mut at = 0;
        self.fields.iter().flat_map(move |field| {
            let begin = at;
            at += field.width;
            let Numbers { count, width, number } = field.numbers;
            (0..count).map(move |k| number(payload.get(begin + k * width..).unwrap_or_default()))
        })
    }

    /// Names of the numbers, in the order of the wire.
    pub fn number_names(&self) -> impl Iterator<Item = &'static str> {
        self.fields.iter().flat_map(|field| &field.names[..field.numbers.count]).copied()
    }
}
