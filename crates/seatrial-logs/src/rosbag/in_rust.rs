//! The tables of a bag, read without C.

use std::collections::BTreeSet;
use std::path::Path;

use super::{
    BATCH, BATCH_BYTES, BagTables, LONGEST_MESSAGE, MOST_TOPICS, Size, Stored, Topic, damaged,
};
use crate::error::Fault;
use crate::input::Input;
use crate::sqlite::{Broken, Database, Row, Scan, Table, Value};

/// Bytes of a record that are enough for the numbers before its data.
const NUMBERS: usize = 64;
/// Bytes of a definition of a message.
const LONGEST_DEFINITION: usize = 1 << 20;

/// A database that is open.
pub(crate) struct Tables {
    database: Database,
    messages: Option<(Table, Scan)>,
}

impl Tables {
    /// Goes through a table, with at most so many bytes of each record.
    fn each(
        &mut self,
        table: &Table,
        most: usize,
        mut with: impl FnMut(&Row),
    ) -> Result<(), Broken> {
        let mut scan = self.database.rows(table)?;
        while let Some(row) = self.database.next(&mut scan, most)? {
            with(&row);
        }
        Ok(())
    }

    /// Topics in CDR, whether or not they have messages.
    fn listed(&mut self, table: &Table) -> Result<Vec<Topic>, Broken> {
        let mut topics = Vec::new();
        self.each(table, LONGEST_DEFINITION, |row| {
            let value = table.values(row);
            let text = |column| text(value(column));
            if let (Value::Integer(id), Some(name), Some(type_name)) =
                (value("id"), text("name"), text("type"))
                && text("serialization_format").as_deref() == Some("cdr")
                && topics.len() < MOST_TOPICS
            {
                topics.push(Topic {
                    id,
                    name,
                    type_name,
                    definition: None,
                });
            }
        })?;
        Ok(topics)
    }

    /// Gives topics the definitions that the bag holds.
    fn define(&mut self, topics: &mut [Topic]) -> Result<(), Broken> {
        let Some(table) = self.database.table("message_definitions")? else {
            return Ok(());
        };
        self.each(&table, LONGEST_DEFINITION, |row| {
            let value = table.values(row);
            let text = |column| text(value(column));
            if text("encoding").as_deref() != Some("ros2msg") {
                return;
            }
            let of = text("topic_type");
            let is_of = |topic: &&mut Topic| Some(&topic.type_name) == of.as_ref();
            for topic in topics.iter_mut().filter(is_of) {
                if topic.definition.is_none() {
                    topic.definition = text("encoded_message_definition");
                }
            }
        })
    }
}

impl BagTables for Tables {
    type Broken = Broken;

    fn open(file: &mut Input, _: &Path, _: &Size) -> Result<Self, Fault> {
        let file = file.another().map_err(Fault::read)?;
        let database = Database::open(file).map_err(|error| damaged(&error))?;
        Ok(Self {
            database,
            messages: None,
        })
    }

    fn topics(&mut self, is_cut: bool) -> Result<(i64, Vec<Topic>), Broken> {
        let topics = self.database.table("topics")?;
        let messages = self.database.table("messages")?;
        let (Some(topics), Some(messages)) = (topics, messages) else {
            return Ok((0, Vec::new()));
        };
        let mut topics = self.listed(&topics)?;
        self.define(&mut topics)?;
        let (mut rows, mut with_messages) = (0, BTreeSet::new());
        let all = self.each(&messages, NUMBERS, |row| {
            rows += 1;
            if let Value::Integer(topic) = messages.values(row)("topic_id") {
                with_messages.insert(topic);
            }
        });
        if !is_cut {
            all?;
            topics.retain(|topic| with_messages.contains(&topic.id));
        }
        let scan = self.database.rows(&messages)?;
        self.messages = Some((messages, scan));
        Ok((rows, topics))
    }

    fn fetch(&mut self, fetched: &mut Vec<Stored>) -> Result<(), Broken> {
        let Some((table, scan)) = &mut self.messages else {
            return Ok(());
        };
        let mut bytes = 0;
        while bytes <= BATCH_BYTES && fetched.len() < BATCH {
            let Some(row) = self.database.next(scan, LONGEST_MESSAGE + NUMBERS)? else {
                break;
            };
            let columns = ["id", "topic_id", "timestamp", "data"];
            match columns.map(table.values(&row)) {
                [
                    Value::Integer(id),
                    Value::Integer(topic),
                    Value::Integer(time_ns),
                    Value::Blob(data),
                ] if data.len() <= LONGEST_MESSAGE => {
                    bytes += data.len();
                    fetched.push(Stored {
                        id,
                        topic,
                        time_ns,
                        data: data.to_vec(),
                    });
                }
                [.., Value::Blob(_) | Value::Unread] => {}
                _ => return Err(Broken::NotRead("a message has values of other kinds")),
            }
        }
        Ok(())
    }
}

fn text(value: Value) -> Option<String> {
    match value {
        Value::Text(text) => Some(String::from_utf8_lossy(text).into_owned()),
        _ => None,
    }
}
