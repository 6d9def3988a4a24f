//! What Rust reads of a bag is what SQLite reads of it.

use super::seeds;
use crate::error::Fault;
use crate::input::Held;
use crate::joined::{Message, Messages};
use crate::rosbag::{Bag, BagTables, Sqlite, Tables};

/// Kinds, every message, and what is said of those that are missing.
type Read = (Vec<String>, Vec<(usize, u64, Vec<u64>)>, Vec<String>);

fn read<S: BagTables>(bytes: &[u8]) -> Result<Read, Fault> {
    let mut held = Held::default();
    held.insert("bag.db3", bytes.to_vec());
    let mut bag = Bag::<S>::open(held.get("bag.db3".as_ref()).unwrap(), "".as_ref())?;
    let kinds: Vec<String> = bag.kinds().iter().map(|kind| kind.name.clone()).collect();
    let wanted = vec![true; kinds.len()];
    let (mut message, mut messages) = (Message::default(), Vec::new());
    while bag.next(&wanted, &mut message)? {
        let values = message.values.iter().map(|value| value.to_bits()).collect();
        messages.push((message.kind, message.time_s.to_bits(), values));
    }
    Ok((kinds, messages, bag.warnings()))
}

fn read_by_both(bytes: &[u8]) -> [Result<Read, Fault>; 2] {
    [read::<Sqlite>(bytes), read::<Tables>(bytes)]
}

/// A bag of tables with the names of a bag's, and whatever a test puts into them.
fn bag(statements: &str) -> Vec<u8> {
    let file = tempfile::NamedTempFile::new().unwrap();
    let database = rusqlite::Connection::open(file.path()).unwrap();
    database.execute_batch(statements).unwrap();
    drop(database);
    std::fs::read(file.path()).unwrap()
}

#[test]
fn exact_rust_reads_of_a_bag_what_sqlite_reads() {
    let [sqlite, rust] = read_by_both(&seeds::rosbag());
    let (sqlite, rust) = (sqlite.unwrap(), rust.unwrap());
    assert_eq!(sqlite.1.len(), 3 * seeds::ROWS as usize);
    assert_eq!(sqlite, rust);
}

/// Trees of several levels, rows that go on elsewhere, numbers of rows that are negative, names in quotes, rows that are gone,
/// messages that are too long, and topics that have none.
#[test]
fn exact_rust_reads_large_and_odd_bags_as_sqlite_does() {
    for page in [512, 4096, 65536] {
        let bytes = bag(&format!(
            "PRAGMA page_size = {page};
             CREATE TABLE \"topics\" (id INTEGER PRIMARY KEY, 'name' TEXT NOT NULL, [type] TEXT, `serialization_format` TEXT,
                offered_qos_profiles TEXT DEFAULT (char(44, 41)), UNIQUE (id, name));
             CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB NOT NULL);
             CREATE INDEX timestamp_idx ON messages (timestamp ASC);
             INSERT INTO topics VALUES (1, '/heading', 'std_msgs/msg/Float64', 'cdr', ''), (2, '/rudder', 'std_msgs/msg/Float64', 'cdr', ''),
                (3, '/never', 'std_msgs/msg/Float64', 'cdr', ''), (4, '/json', 'std_msgs/msg/Float64', 'json', '');
             WITH RECURSIVE k(n) AS (SELECT -5 UNION ALL SELECT n + 1 FROM k WHERE n < 20000)
             INSERT INTO messages SELECT n, 1 + n % 2 * n % 2, 1780883460000000000 + 50000000 * n,
                X'000100000000000000' || CAST(zeroblob(0) AS BLOB) || X'00F83F' || zeroblob(CASE WHEN n % 7 = 0 THEN n ELSE 0 END)
                FROM k;
             UPDATE messages SET data = CAST(data AS BLOB);
             INSERT INTO messages VALUES (30000, 1, 1780883460000000000, zeroblob(1048577));
             INSERT INTO messages VALUES (30001, 2, 1790883460000000000, X'0001000000000000000000F0BF');
             DELETE FROM messages WHERE id BETWEEN 100 AND 3000;"
        ));
        let [sqlite, rust] = read_by_both(&bytes);
        let (sqlite, rust) = (sqlite.unwrap(), rust.unwrap());
        assert!(sqlite.1.len() > 10_000, "{page}: {:?}", sqlite.2);
        assert_eq!(sqlite.0, rust.0, "{page}");
        assert!(sqlite == rust, "{page}: {:?}, {:?}", sqlite.2, rust.2);
    }
}

#[test]
fn exact_rust_reads_a_cut_bag_as_sqlite_does() {
    let bytes = seeds::rosbag();
    for length in (600..bytes.len()).step_by(173) {
        let [sqlite, rust] = read_by_both(&bytes[..length]);
        match (sqlite, rust) {
            (Ok(sqlite), Ok(rust)) => assert_eq!(sqlite, rust, "{length}"),
            (Err(sqlite), Err(rust)) => {
                assert_eq!(sqlite.to_string(), rust.to_string(), "{length}");
            }
            (sqlite, rust) => panic!("{length}: {sqlite:?}, {rust:?}"),
        }
    }
}

/// No byte makes it panic or go on for ever, and what is given beside a damage is no more than what is there.
#[test]
fn io_damaged_bags_are_read_in_rust_to_an_end() {
    let bytes = seeds::rosbag();
    let whole = read::<Tables>(&bytes).unwrap().1.len();
    for at in 0..bytes.len() {
        for damage in [0x01, 0x80, 0xff] {
            let mut damaged = bytes.clone();
            damaged[at] ^= damage;
            if let Ok((_, messages, _)) = read::<Tables>(&damaged) {
                assert!(messages.len() <= 2 * whole, "{at}");
            }
        }
    }
}
