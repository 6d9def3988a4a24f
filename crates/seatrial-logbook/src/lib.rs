//! The logbook: every campaign, run, sample, action and estimate in one SQLite file.
//!
//! ```text
//! configuration (payload) -> campaign (plan, software) -> run -> estimate, trace, stage
//!                                                    \-> sample, action, live estimate
//! ```
//!
//! **Exact.** Every number comes back with the bits it had. Samples are one row each, not packed,
//! so that any SQLite tool can query them (about 150 bytes a sample: `io_a_sample_takes_about_150_bytes`).
//!
//! **Durable.** The file is in WAL mode. A run, its result and its hash are committed in one
//! transaction with `synchronous = FULL`: once [`Logbook::finish_run`] has returned, the run
//! survives a loss of power. Samples in between are committed about once a second with
//! `synchronous = NORMAL`: a killed process loses at most the last second, a loss of power may
//! lose the samples of the unfinished run. Neither damages the file. After each finished run all of it is in the file itself, and a copy
//! of that alone holds it; what came since is in the file beside it whose name ends in `-wal`, without which [`Logbook::missing`] says so.
//!
//! **Provable.** A campaign's hash covers its plan and what it ran on; each run's hash covers the
//! hash before it, every sample, action and estimate and the result; the last one how it ended.
//! [`Logbook::verify`] recomputes the chain and holds every number of every row against its neighbours. There is no key in it: it
//! proves that nothing was changed by accident or in part, not that nobody rewrote the whole chain. Not sealed are the steps of a run
//! that has no result yet; that the newest campaigns are missing altogether it cannot tell. Commands and reviews have chains of their own.
//! The schema is compared with the one that this version writes before anything is read, so that nothing in the file decides what is
//! read of it. [`Logbook::campaign`] and [`Logbook::campaigns`] say what is damaged, and no model of that is accepted.
//!
//! **Repeatable.** From a [`Recording`] the trial is conducted again on its samples, and every action, every estimate and every
//! result compared bit for bit, on either [axis](CampaignEntry::axis).
//!
//! **Attributable.** What operators commanded over the network is kept, and their word on a run, which goes before its
//! verdict wherever the run is read; the hash chain and a replay are those of what the program found.
//!
//! ```
//! use seatrial_core::Outcome;
//! use seatrial_logbook::{Logbook, NewCampaign, Recorder};
//!
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("seatrial.db");
//! let new = NewCampaign {
//!     configuration: "bare hull",
//!     notes: Some("new antifouling"),
//!     software_version: "0.3.0",
//!     vehicle: "my boat",
//!     seed: None,
//!     rudder_limit_rad: 0.26,
//!     full_rudder: None,
//!     scenario: None,
//!     plan: "",
//! };
//! let mut recorder = Recorder::begin(Logbook::open(&path)?, &new)?;
//! recorder.begin_run(1, 0.6, 1)?;
//! // For every sample `recorder.step(step)`, at the end of the run `recorder.finish_run(&run)`.
//! recorder.finish(Outcome::Finished)?;
//!
//! let logbook = Logbook::open_read_only(&path)?;
//! assert_eq!(logbook.campaigns()?.len(), 1);
//! assert!(logbook.verify()?.damage.is_empty());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Reading never writes, but rolls back what a killed process left half written. Several processes
//! may read while one writes.

mod chain;
mod connect;
mod damage;
mod error;
mod keeper;
mod open_here;
mod operators;
mod read;
mod recorder;
mod recording;
mod row;
mod row_places;
mod schema;
mod stored;
mod trail;
mod verify;
mod write;
mod write_ahead;

use std::fs::OpenOptions;
use std::path::{Path, PathBuf};
use std::time::Duration;

use rusqlite::backup::Backup;
use rusqlite::{Connection, OpenFlags, OptionalExtension};
use serde::Serialize;
use tempfile::TempDir;

pub use damage::Damage;
pub use error::Error;
pub use keeper::{Keeper, KeeperReport};
pub use operators::{Circumstances, CommandEntry, NewCommand, Review};
pub use read::RunEntry;
pub use recorder::Recorder;
pub use recording::Recording;
pub use stored::{CampaignEntry, State};
pub use verify::Verification;
pub use write::NewCampaign;

pub use connect::WriteLock;
use connect::{Database, beside, connect, connect_for_reading, file_identity, harden};
use open_here::OpenHere;
use schema::{Identity, MIGRATIONS, altered, identity, migrate};

/// The example of the readme, which is compiled.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

/// Number of a campaign in its logbook.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct CampaignId(pub i64);

/// Key of a run in its logbook.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RunId(i64);

/// An open logbook.
#[derive(Debug)]
pub struct Logbook {
    connection: Connection,
    path: PathBuf,
    /// No table was in the file when it was opened.
    was_empty: bool,
    /// Which file was opened to be written.
    file: Option<(u64, u64)>,
    /// What is not there, where a write-ahead log is missing.
    missing: Option<String>,
    _copy: Option<TempDir>,
    /// Dropped last, behind the connection.
    _open: OpenHere,
}

impl Logbook {
    /// Opens a logbook for writing; makes it where there is none, migrates an older one.
    ///
    /// Campaigns without an outcome are marked interrupted; one that another process is still
    /// writing takes the mark away with its next run.
    pub fn open(path: impl Into<PathBuf>) -> Result<Self, Error> {
        let path = path.into();
        reject_directory(&path)?;
        reject_log_of_another(&path)?;
        let (open, _) = OpenHere::after(|| ());
        let access = OpenFlags::SQLITE_OPEN_READ_WRITE | OpenFlags::SQLITE_OPEN_CREATE;
        let connection = connect(&path, access).map_err(|error| Error::opening(&path, &error))?;
        let connected = Database { connection, copy: None };
        let mut logbook = Self::of(connected, path, open);
        logbook.file = file_identity(&logbook.path);
        logbook.identify()?;
        logbook.prepare_for_writing().map_err(|error| Error::writing(&logbook.path, &error))?;
        // What is written to has the schema that it should have, and a trial may take as long as it does.
        let unlimited = logbook.connection.progress_handler(0, None::<fn() -> bool>);
        logbook.reading(unlimited)?;
        Ok(logbook)
    }

    /// Could a trial be kept there, as far as can be told without writing anything? Not in a logbook that is damaged: no gain would be taken
    /// from it.
    pub fn check_writable(path: impl Into<PathBuf>) -> Result<(), Error> {
        let path = path.into();
        reject_directory(&path)?;
        reject_log_of_another(&path)?;
        let refused = |cause: String| Error::NotSaved { path: path.clone(), cause };
        if path.exists() {
            let opened = || OpenOptions::new().append(true).open(&path).map(drop);
            let (_open, opened) = OpenHere::after(opened);
            Self::open_read_only(&path)?.check_undamaged()?;
            return opened.unwrap_or(Ok(())).map_err(|error| {
                refused(format!("{error}; make the file and its folder writable"))
            });
        }
        match path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() && !folder.is_dir() => {
                Err(Error::Unreadable {
                    path: path.clone(),
                    cause: "does its folder exist, and may you open files there?".into(),
                })
            }
            _ => Ok(()),
        }
    }

    /// Opens a logbook for reading. An older one is migrated in memory; the file stays as it is.
    pub fn open_read_only(path: impl Into<PathBuf>) -> Result<Self, Error> {
        let path = path.into();
        reject_directory(&path)?;
        if !path.exists() {
            return Err(Error::Missing(path));
        }
        // Asked first: a reader makes such a file, too.
        let lacks_log = connect::lacks_log(&path);
        let (open, log_damage) = OpenHere::after(|| write_ahead::damage(&path));
        let connected =
            connect_for_reading(&path).map_err(|error| Error::opening(&path, &error))?;
        let mut logbook = Self::of(connected, path, open);
        let found = logbook.identify()?;
        logbook.was_empty = found == Identity::Empty;
        if found != Identity::Logbook(MIGRATIONS.len()) {
            logbook.connection = migrated_copy(&logbook.connection)
                .map_err(|error| Error::opening(&logbook.path, &error))?;
        }
        if let Some(damage) = log_damage.flatten() {
            logbook.missing = Some(format!(
                "{}: its {} {damage}; what stood there is missing",
                logbook.path.display(),
                beside(&logbook.path, "-wal").display()
            ));
        }
        if lacks_log {
            logbook.missing = logbook.reading(unfinished(&logbook.connection))?.map(|campaign| {
                format!(
                    "{}: its {} is not beside it; what came after the last finished run of campaign {campaign} may be missing",
                    logbook.path.display(),
                    beside(&logbook.path, "-wal").display()
                )
            });
        }
        Ok(logbook)
    }

    fn of(connected: Database, path: PathBuf, open: OpenHere) -> Self {
        Self {
            connection: connected.connection,
            path,
            was_empty: false,
            file: None,
            missing: None,
            _copy: connected.copy,
            _open: open,
        }
    }

    fn check_undamaged(&self) -> Result<(), Error> {
        let damage = match self.was_empty {
            true => None,
            false => self.verify()?.damage.into_iter().next(),
        };
        damage.map_or(Ok(()), |damage| {
            Err(Error::Damaged {
                path: self.path.clone(),
                place: damage.place,
                found: format!(
                    "{}; no gain is taken from it, so that no trial is kept in it: give a new file with --logbook",
                    damage.found
                ),
            })
        })
    }

    /// Keeps everybody from writing to a logbook: to try what a disk that hangs does.
    pub fn hold(path: &Path) -> Result<WriteLock, Error> {
        WriteLock::of(path).map_err(|error| Error::writing(path, &error))
    }

    /// What the file lacks, in words: it was copied or moved during a trial, without the write-ahead log beside it.
    pub fn missing(&self) -> Option<&str> {
        self.missing.as_deref()
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    fn identify(&self) -> Result<Identity, Error> {
        let path = self.path.clone();
        let opening = |error| Error::opening(&self.path, &error);
        let found = identity(&self.connection).map_err(opening)?;
        match found {
            Identity::Foreign => Err(Error::NotALogbook {
                path,
                found: "an SQLite database of something else".into(),
            }),
            Identity::Logbook(found) if found > MIGRATIONS.len() => {
                Err(Error::Newer { path, found, known: MIGRATIONS.len() })
            }
            Identity::Logbook(version) => {
                match altered(&self.connection, version).map_err(opening)? {
                    Some(found) => Err(Error::Altered { path, found }),
                    None => Ok(found),
                }
            }
            Identity::Empty => Ok(found),
        }
    }

    /// One view of the file for all that is read, also while another process is writing.
    fn viewing<T>(&self, read: impl FnOnce() -> Result<T, Error>) -> Result<T, Error> {
        if !self.connection.is_autocommit() {
            return read();
        }
        let view = self.reading(self.connection.unchecked_transaction())?;
        let read = read()?;
        self.reading(view.finish())?;
        Ok(read)
    }

    fn prepare_for_writing(&mut self) -> Result<(), rusqlite::Error> {
        // Answers with the mode in force; a file system without shared memory keeps the rollback
        // journal, which is as safe, only slower.
        self.connection.pragma_update_and_check(None, "journal_mode", "WAL", |_| Ok(()))?;
        self.connection.pragma_update(None, "foreign_keys", true)?;
        migrate(&mut self.connection, MIGRATIONS)?;
        self.connection.execute("UPDATE campaign SET interrupted = 1 WHERE outcome IS NULL", [])?;
        Ok(())
    }

    fn reading<T>(&self, result: Result<T, rusqlite::Error>) -> Result<T, Error> {
        result.map_err(|error| Error::reading(&self.path, &error))
    }
}

/// A write-ahead log without its logbook belongs to one that was renamed or removed; SQLite would take it for the new one's.
fn reject_log_of_another(path: &Path) -> Result<(), Error> {
    let log = beside(path, "-wal");
    let is_empty = path.metadata().map_or(true, |about| about.len() == 0);
    match is_empty && log.metadata().is_ok_and(|about| about.len() > 0) {
        true => Err(Error::Unreadable {
            path: path.into(),
            cause: format!(
                "{} is there without it: a logbook was renamed or removed while a trial wrote it; put it back under this name, or give a name that was not used",
                log.display()
            ),
        }),
        false => Ok(()),
    }
}

/// A campaign that has not ended, and that no writer has seen interrupted.
fn unfinished(connection: &Connection) -> Result<Option<i64>, rusqlite::Error> {
    connection
        .query_row(
            "SELECT id FROM campaign WHERE outcome IS NULL AND interrupted = 0 LIMIT 1",
            [],
            |row| row.get(0),
        )
        .optional()
}

fn reject_directory(path: &Path) -> Result<(), Error> {
    if path.is_dir() {
        return Err(Error::NotALogbook { path: path.to_path_buf(), found: "a directory".into() });
    }
    Ok(())
}

fn migrated_copy(file: &Connection) -> Result<Connection, rusqlite::Error> {
    let mut copy = Connection::open_in_memory()?;
    harden(&copy)?;
    Backup::new(file, &mut copy)?.run_to_completion(1024, Duration::ZERO, None)?;
    migrate(&mut copy, MIGRATIONS)?;
    Ok(copy)
}
