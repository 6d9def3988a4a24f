//! The tables of a bag.

use std::io::{Read, Seek};
use std::path::Path;

use rusqlite::{Connection, OpenFlags, params};
use tempfile::NamedTempFile;

use super::{LONGEST_MESSAGE, Size, damaged};
use crate::error::Fault;
use crate::input::Input;

/// Messages fetched at once, and bytes of them.
const BATCH: usize = 256;
const BATCH_BYTES: usize = 4 << 20;
/// Topics that are looked at.
const MOST_TOPICS: usize = 10_000;

/// A topic in CDR that has messages.
pub(super) struct Topic {
    pub id: i64,
    pub name: String,
    pub type_name: String,
    /// What its messages consist of, where the bag says it.
    pub definition: Option<String>,
}

/// A message as it is stored.
pub(super) struct StoredMessage {
    pub id: i64,
    pub topic: i64,
    pub time_ns: i64,
    pub data: Vec<u8>,
}

/// A database that is open.
pub(super) struct Tables {
    database: Connection,
    /// Number of the last message that was fetched.
    last: i64,
    /// What the database reads in place of the file: it knows files by names, and takes half a page for one.
    _copy: Option<NamedTempFile>,
}

impl Tables {
    /// Is there a table of this name? Views and computed columns, which can be of any size, are none.
    fn has_table(&self, name: &str) -> Result<bool, rusqlite::Error> {
        self.database.query_row(
            "SELECT count(*) = 1 AND NOT EXISTS (SELECT 1 FROM pragma_table_xinfo(?1) WHERE hidden <> 0)
             FROM sqlite_schema WHERE name = ?1 AND type = 'table' AND sql NOT LIKE 'CREATE VIRTUAL%'",
            params![name],
            |row| row.get(0),
        )
    }

    /// What messages of a type consist of, where the bag says it.
    fn definition(&self, type_name: &str) -> Option<String> {
        let said = self.database.query_row(
            "SELECT encoded_message_definition FROM message_definitions
             WHERE topic_type = ?1 AND encoding = 'ros2msg'",
            params![type_name],
            |row| row.get(0),
        );
        said.ok()
    }

    /// Opens the database. What has no name in the file system, or ends within a page, is copied first.
    pub fn open(file: &mut Input, path: &Path, size: &Size) -> Result<Self, Fault> {
        let length = file.length().map_err(Fault::read)?;
        let is_cut = size.whole().is_some_and(|whole| length < whole);
        let is_in_page = is_cut && length % size.page > 0;
        let copy = match path.as_os_str().is_empty() || is_in_page {
            true => Some(copy_of(file, length - length % size.page).map_err(Fault::read)?),
            false => None,
        };
        let path = copy.as_ref().map_or(path, |copy| copy.path());
        let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
        let database = Connection::open_with_flags(path, flags).map_err(|error| damaged(&error))?;
        Ok(Self { database, last: i64::MIN, _copy: copy })
    }

    /// The number of messages, or 0 where nobody knows it, and the topics in CDR that have messages. In a cut
    /// database a topic of which none was found before the cut counts as one that has some.
    pub fn topics(&mut self, is_cut: bool) -> Result<(i64, Vec<Topic>), rusqlite::Error> {
        // A cut database is opened with this alone.
        self.database.pragma_update(None, "writable_schema", true)?;
        self.database.pragma_update(None, "trusted_schema", false)?;
        if !self.has_table("topics")? || !self.has_table("messages")? {
            return Ok((0, Vec::new()));
        }
        let has_definitions = self.has_table("message_definitions")?;
        let count = "SELECT count(*) FROM messages";
        let or_cut = |error| if is_cut { Ok(0) } else { Err(error) };
        let rows = self.database.query_row(count, [], |row| row.get(0)).or_else(or_cut)?;
        let mut topics = self.database.prepare(
            "SELECT id, name, type FROM topics WHERE serialization_format = 'cdr' LIMIT ?1",
        )?;
        let mut with_messages =
            self.database.prepare("SELECT EXISTS (SELECT 1 FROM messages WHERE topic_id = ?1)")?;
        let found: Vec<(i64, String, String)> = topics
            .query_map([MOST_TOPICS as i64], |row| Ok((row.get(0)?, row.get(1)?, row.get(2)?)))?
            .collect::<Result<_, _>>()?;
        let mut topics = Vec::new();
        for (id, name, type_name) in found {
            let has_messages = with_messages.query_row(params![id], |row| row.get(0));
            if has_messages.or_else(|error| if is_cut { Ok(true) } else { Err(error) })? {
                let definition = has_definitions.then(|| self.definition(&type_name));
                topics.push(Topic { id, name, definition: definition.flatten(), type_name });
            }
        }
        Ok((rows, topics))
    }

    /// Adds the next messages, in the order of their numbers, that are not longer than [`LONGEST_MESSAGE`]. None at the end.
    pub fn fetch(&mut self, fetched: &mut Vec<StoredMessage>) -> Result<(), rusqlite::Error> {
        let mut statement = self.database.prepare_cached(
            "SELECT id, topic_id, timestamp, data FROM messages
             WHERE id > ?1 AND length(data) <= ?2 ORDER BY id LIMIT ?3",
        )?;
        let bounds = params![self.last, LONGEST_MESSAGE as i64, BATCH as i64];
        let rows = statement.query_map(bounds, |row| {
            Ok(StoredMessage {
                id: row.get(0)?,
                topic: row.get(1)?,
                time_ns: row.get(2)?,
                data: row.get(3)?,
            })
        })?;
        let mut bytes = 0;
        for stored in rows {
            let stored = stored?;
            self.last = stored.id;
            bytes += stored.data.len();
            fetched.push(stored);
            if bytes > BATCH_BYTES {
                break;
            }
        }
        Ok(())
    }
}

fn copy_of(file: &mut Input, length: u64) -> std::io::Result<NamedTempFile> {
    let mut copy = NamedTempFile::new()?;
    std::io::copy(&mut file.take(length), &mut copy)?;
    file.rewind()?;
    Ok(copy)
}
