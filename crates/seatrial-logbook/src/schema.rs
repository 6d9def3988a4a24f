//! The schema and its migrations.

use std::fmt;

use rusqlite::{Connection, Error, Transaction, TransactionBehavior};

use super::trail::Trail;

/// `PRAGMA application_id`: "STLB", seatrial logbook.
pub(super) const APPLICATION_ID: i32 = i32::from_be_bytes(*b"STLB");

/// Migration k takes schema version k to k + 1. Released ones are never edited: a change of the
/// schema is a new one at the end.
pub(super) const MIGRATIONS: &[&str] = &[
    include_str!("schema_v1.sql"),
    include_str!("schema_v2.sql"),
    include_str!("schema_v3.sql"),
    include_str!("schema_v4.sql"),
    include_str!("schema_v5.sql"),
    include_str!("schema_v6.sql"),
    include_str!("schema_v7.sql"),
];

/// The version from which on commands and reviews are in a hash chain.
const WITH_TRAILS: usize = 7;

/// What a file says about itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Identity {
    /// No table yet: a new file, or one whose creation was cut short.
    Empty,
    /// A logbook with this schema version.
    Logbook(usize),
    /// A database of something else.
    Foreign,
}

/// Reads what the file says about itself.
pub(super) fn identity(connection: &Connection) -> Result<Identity, Error> {
    let pragma = |name: &str| connection.pragma_query_value(None, name, |row| row.get::<_, i32>(0));
    let tables: i64 =
        connection.query_row("SELECT count(*) FROM sqlite_schema", [], |row| row.get(0))?;
    let version = usize::try_from(pragma("user_version")?).ok();
    Ok(match (pragma("application_id")?, version) {
        (APPLICATION_ID, Some(version)) if version > 0 => Identity::Logbook(version),
        (0, Some(0)) if tables == 0 => Identity::Empty,
        _ => Identity::Foreign,
    })
}

/// The first part of the schema that is not as a logbook of this version has it: its kind and name, and what is wrong with it.
///
/// Asked before anything else: a trigger, a view or a column that computes its value decides what is read and written.
pub(super) fn altered(connection: &Connection, version: usize) -> Result<Option<String>, Error> {
    let written = Connection::open_in_memory()?;
    for migration in MIGRATIONS.iter().take(version) {
        written.execute_batch(migration)?;
    }
    let (written, found) = (parts(&written)?, parts(connection)?);
    let missing = written.iter().find(|part| !found.contains(part));
    let added = found.iter().find(|part| !written.contains(part));
    let same_name = |part: &Part| written.iter().any(|other| other.name == part.name);
    Ok(match (added, missing) {
        (Some(part), _) if same_name(part) => Some(format!("{part} was changed")),
        (Some(part), _) => Some(format!("{part} was added")),
        (None, Some(part)) => Some(format!("{part} is missing")),
        (None, None) => None,
    })
}

/// A table, an index, a trigger or a view.
#[derive(PartialEq)]
struct Part {
    kind: String,
    name: String,
    table: String,
    sql: Option<String>,
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "the {} {:?}", self.kind, self.name)
    }
}

fn parts(connection: &Connection) -> Result<Vec<Part>, Error> {
    let mut query = connection.prepare("SELECT type, name, tbl_name, sql FROM sqlite_schema")?;
    let part = |row: &rusqlite::Row| {
        Ok(Part { kind: row.get(0)?, name: row.get(1)?, table: row.get(2)?, sql: row.get(3)? })
    };
    query.query_map([], part)?.collect()
}

/// Has a campaign begun while commands and reviews had hash chains?
fn has_trails(connection: &Connection, version: usize) -> Result<bool, Error> {
    let sql = "SELECT EXISTS (SELECT 1 FROM campaign WHERE notes_sealed > 1)";
    // The column came with the sixth schema, the one before.
    match version + 1 == WITH_TRAILS {
        true => connection.query_row(sql, [], |row| row.get(0)),
        false => Ok(false),
    }
}

/// Brings an empty file or an older logbook to the newest schema, in one transaction.
pub(super) fn migrate(connection: &mut Connection, migrations: &[&str]) -> Result<(), Error> {
    let transaction = Transaction::new(connection, TransactionBehavior::Immediate)?;
    // Asked again under the write lock: another process may have migrated meanwhile.
    let version = match identity(&transaction)? {
        Identity::Logbook(version) => version,
        Identity::Empty => 0,
        Identity::Foreign => return Ok(()),
    };
    for migration in migrations.iter().skip(version) {
        transaction.execute_batch(migration)?;
    }
    // A logbook that has been without its chains since they were begun was altered, and its commands and reviews stay unsealed.
    if version < WITH_TRAILS && !has_trails(&transaction, version)? {
        for trail in [Trail::Commands, Trail::Reviews] {
            trail.seal(&transaction, 0)?;
        }
    }
    transaction.pragma_update(None, "application_id", APPLICATION_ID)?;
    transaction.pragma_update(None, "user_version", migrations.len().max(version) as i64)?;
    transaction.commit()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn io_migrations_run_in_order_once_and_keep_the_data() {
        let mut connection = Connection::open_in_memory().unwrap();
        migrate(&mut connection, MIGRATIONS).unwrap();
        connection.execute("INSERT INTO configuration (name) VALUES ('bare')", []).unwrap();
        let next = [MIGRATIONS, &["ALTER TABLE configuration ADD COLUMN owner TEXT DEFAULT 'us'"]]
            .concat();
        for _ in 0..2 {
            migrate(&mut connection, &next).unwrap();
            assert_eq!(identity(&connection).unwrap(), Identity::Logbook(MIGRATIONS.len() + 1));
        }
        let row: (String, String) = connection
            .query_row("SELECT name, owner FROM configuration", [], |row| {
                Ok((row.get(0)?, row.get(1)?))
            })
            .unwrap();
        assert_eq!(row, ("bare".into(), "us".into()));
    }

    #[test]
    fn io_a_failing_migration_leaves_the_schema_as_it_was() {
        let mut connection = Connection::open_in_memory().unwrap();
        migrate(&mut connection, MIGRATIONS).unwrap();
        let broken = [MIGRATIONS, &["CREATE TABLE half (a); CREATE NONSENSE"]].concat();
        assert!(migrate(&mut connection, &broken).is_err());
        assert_eq!(identity(&connection).unwrap(), Identity::Logbook(MIGRATIONS.len()));
        assert!(connection.prepare("SELECT * FROM half").is_err());
    }
}
