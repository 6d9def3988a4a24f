//! How a logbook is opened: as a file that a stranger may have made.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use rusqlite::config::DbConfig;
use rusqlite::limits::Limit;
use rusqlite::{Connection, ErrorCode, OpenFlags};
use tempfile::TempDir;

use super::schema::identity;

/// How long to wait for another process's transaction.
pub(super) const BUSY_TIMEOUT: Duration = Duration::from_secs(5);

/// Work without a pause that a logbook is given, beside a second for every megabyte of it.
const LONGEST_WORK: Duration = Duration::from_secs(30);
/// Instructions of SQLite between two looks at the clock: some 0.1 ms.
const LOOK_EVERY: i32 = 10_000;
/// Between two looks so far apart nothing was asked of the logbook.
const PAUSE: Duration = Duration::from_millis(100);

/// What no row and no statement of a logbook comes near to.
const LIMITS: [(Limit, i32); 10] = [
    (Limit::SQLITE_LIMIT_LENGTH, 256 << 20),
    (Limit::SQLITE_LIMIT_SQL_LENGTH, 1 << 17),
    (Limit::SQLITE_LIMIT_COLUMN, 100),
    (Limit::SQLITE_LIMIT_EXPR_DEPTH, 100),
    (Limit::SQLITE_LIMIT_COMPOUND_SELECT, 20),
    (Limit::SQLITE_LIMIT_VDBE_OP, 100_000),
    (Limit::SQLITE_LIMIT_ATTACHED, 0),
    (Limit::SQLITE_LIMIT_LIKE_PATTERN_LENGTH, 1000),
    (Limit::SQLITE_LIMIT_TRIGGER_DEPTH, 1),
    (Limit::SQLITE_LIMIT_WORKER_THREADS, 0),
];

/// A connection to a file.
#[derive(Debug)]
pub(super) struct Database {
    pub connection: Connection,
    /// The folder of the copy that it is to, where the file cannot be read in its own.
    pub copy: Option<TempDir>,
}

/// A logbook that nobody can write to until this is dropped, as on a disk that hangs.
#[derive(Debug)]
pub struct WriteLock {
    _connection: Connection,
}

impl WriteLock {
    pub(super) fn of(path: &Path) -> Result<Self, rusqlite::Error> {
        let connection = connect(path, OpenFlags::SQLITE_OPEN_READ_WRITE)?;
        connection.execute_batch("BEGIN IMMEDIATE")?;
        Ok(Self { _connection: connection })
    }
}

/// Opens a file.
pub(super) fn connect(path: &Path, access: OpenFlags) -> Result<Connection, rusqlite::Error> {
    let connection = Connection::open_with_flags(path, access | OpenFlags::SQLITE_OPEN_NO_MUTEX)?;
    connection.busy_timeout(BUSY_TIMEOUT)?;
    harden(&connection)?;
    let megabytes = path.metadata().map_or(0, |about| about.len() >> 20);
    let most = LONGEST_WORK + Duration::from_secs(megabytes);
    let (mut worked, mut looked) = (Duration::ZERO, Instant::now());
    let mut connection = connection;
    connection.progress_handler(
        LOOK_EVERY,
        Some(move || {
            let since = looked.elapsed();
            looked = Instant::now();
            worked = match since < PAUSE {
                true => worked + since,
                false => Duration::ZERO,
            };
            worked > most
        }),
    )?;
    Ok(connection)
}

/// Nothing in the file is run, whatever its schema says.
pub(super) fn harden(connection: &Connection) -> Result<(), rusqlite::Error> {
    for (setting, value) in [
        (DbConfig::SQLITE_DBCONFIG_DEFENSIVE, true),
        (DbConfig::SQLITE_DBCONFIG_TRUSTED_SCHEMA, false),
        (DbConfig::SQLITE_DBCONFIG_ENABLE_TRIGGER, false),
        (DbConfig::SQLITE_DBCONFIG_ENABLE_VIEW, false),
    ] {
        connection.set_db_config(setting, value)?;
    }
    for (limit, value) in LIMITS {
        connection.set_limit(limit, value)?;
    }
    Ok(())
}

/// Reading leaves no file behind and needs no permission to write, except to roll back the journal of a process that was killed
/// while it made the logbook.
///
/// Even a reader needs files for the write-ahead log and for shared memory beside a logbook, and only a connection that may write
/// removes them when it closes. So a logbook without them is opened by one that may write and does not, and one that nobody
/// may write to as a file that does not change. Where they exist, a writer is at work or was killed: they are read and left; on a
/// medium that is read-only, in a copy.
pub(super) fn connect_for_reading(path: &Path) -> Result<Database, rusqlite::Error> {
    let in_place = |connection| Database { connection, copy: None };
    if beside(path, "-wal").exists() || beside(path, "-journal").exists() {
        for access in [OpenFlags::SQLITE_OPEN_READ_ONLY, OpenFlags::SQLITE_OPEN_READ_WRITE] {
            let connection = connect(path, access)?;
            if !is_refused(&connection) {
                return Ok(in_place(connection));
            }
        }
        return copied(path);
    }
    let may_be_written = path.metadata().is_ok_and(|about| !about.permissions().readonly());
    if may_be_written {
        let connection = connect(path, OpenFlags::SQLITE_OPEN_READ_WRITE)?;
        connection.pragma_update(None, "query_only", true)?;
        if !is_refused(&connection) {
            return Ok(in_place(connection));
        }
    }
    let name = path.to_string_lossy().replace('%', "%25").replace('?', "%3f").replace('#', "%23");
    let unchanging = connect(
        Path::new(&format!("file:{name}?immutable=1")),
        OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_URI,
    );
    unchanging.map(in_place)
}

/// Can it not be read without writing to its folder?
fn is_refused(connection: &Connection) -> bool {
    identity(connection).is_err_and(|error| {
        let code = error.sqlite_error_code();
        matches!(code, Some(ErrorCode::ReadOnly | ErrorCode::CannotOpen))
    })
}

fn copied(path: &Path) -> Result<Database, rusqlite::Error> {
    let copy = || -> io::Result<(TempDir, PathBuf)> {
        let folder = tempfile::tempdir()?;
        let place = folder.path().join("logbook.db");
        std::fs::copy(path, &place)?;
        for ending in ["-wal", "-journal"] {
            let from = beside(path, ending);
            if from.exists() {
                std::fs::copy(from, beside(&place, ending))?;
            }
        }
        Ok((folder, place))
    };
    let (folder, place) =
        copy().map_err(|error| rusqlite::Error::ToSqlConversionFailure(error.into()))?;
    let connection = connect(&place, OpenFlags::SQLITE_OPEN_READ_WRITE)?;
    connection.pragma_update(None, "query_only", true)?;
    Ok(Database { connection, copy: Some(folder) })
}

/// The file that SQLite keeps beside this one.
pub(super) fn beside(path: &Path, ending: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(ending);
    name.into()
}

/// Is the file one whose newest rows stand in a write-ahead log, and there is none beside it?
pub(super) fn lacks_log(path: &Path) -> bool {
    let mut start = [0; 20];
    let is_read = File::open(path).is_ok_and(|mut file| file.read_exact(&mut start).is_ok());
    is_read && start[18..] == [2, 2] && !beside(path, "-wal").exists()
}

/// Which file it is, whatever its name.
#[cfg(unix)]
pub(super) fn file_identity(path: &Path) -> Option<(u64, u64)> {
    use std::os::unix::fs::MetadataExt;
    path.metadata().ok().map(|about| (about.dev(), about.ino()))
}

/// Does any name lead to this file, which this process has open? `None` where the system does not tell.
#[cfg(unix)]
pub(super) fn is_named(identity: (u64, u64)) -> Option<bool> {
    use std::os::unix::fs::MetadataExt;
    let open = std::fs::read_dir("/proc/self/fd").ok()?.flatten();
    let mut open = open.filter_map(|file| std::fs::metadata(file.path()).ok());
    let file = open.find(|about| (about.dev(), about.ino()) == identity)?;
    Some(file.nlink() > 0)
}

/// Elsewhere an open file cannot be moved.
#[cfg(not(unix))]
pub(super) fn is_named(_: (u64, u64)) -> Option<bool> {
    None
}

/// Elsewhere an open file cannot be moved.
#[cfg(not(unix))]
pub(super) fn file_identity(_: &Path) -> Option<(u64, u64)> {
    None
}
