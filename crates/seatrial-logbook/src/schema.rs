//! The schema and its migrations.

use rusqlite::{Connection, Error, Transaction, TransactionBehavior};

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
];

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
        connection
            .execute("INSERT INTO configuration (name) VALUES ('bare')", [])
            .unwrap();
        let next = [
            MIGRATIONS,
            &["ALTER TABLE configuration ADD COLUMN owner TEXT DEFAULT 'us'"],
        ]
        .concat();
        for _ in 0..2 {
            migrate(&mut connection, &next).unwrap();
            assert_eq!(
                identity(&connection).unwrap(),
                Identity::Logbook(MIGRATIONS.len() + 1)
            );
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
        assert_eq!(
            identity(&connection).unwrap(),
            Identity::Logbook(MIGRATIONS.len())
        );
        assert!(connection.prepare("SELECT * FROM half").is_err());
    }
}
