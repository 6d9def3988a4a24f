//! What is done, kept so that it survives the end of the process at any instant.
//!
//! A line of JSON for each log or run, written at once and whole; a last line that was cut off is dropped when the journal
//! is opened again. It stands beside the Parquet file that is made from it, or in the working folder where an object store takes that, and
//! goes when that is there.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use super::log::Options;
use super::objects::{self, ObjectError, is_object};
use super::table::TableWriter;
use super::{Row, Source, earlier};
use crate::outputs::{OutputError, OutputKind, Outputs};

/// After so long what was written goes to the disk, so that a power failure costs no more than that.
const SYNC_EVERY: Duration = Duration::from_secs(5);

/// The rows of a log or of a run of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Entry {
    /// The log.
    #[serde(with = "any_path")]
    pub source: PathBuf,
    /// Its length when it was read.
    pub bytes: u64,
    /// When it was last written, ns since 1970.
    pub modified_ns: i64,
    /// What its object store called this version of it.
    #[serde(default)]
    pub etag: Option<String>,
    /// Which run of it, from 0; 0 of a log that is not divided.
    pub run: u64,
    /// One for each manoeuvre, or an error row.
    pub rows: Vec<Row>,
}

/// A path as text, or as its bytes where it is not UTF-8.
mod any_path {
    use std::ffi::OsString;
    use std::path::{Path, PathBuf};

    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    #[derive(Deserialize)]
    #[serde(untagged)]
    enum Name {
        Text(PathBuf),
        Bytes(Vec<u8>),
    }

    pub fn serialize<S: Serializer>(path: &Path, serializer: S) -> Result<S::Ok, S::Error> {
        match path.to_str() {
            Some(text) => text.serialize(serializer),
            None => path.as_os_str().as_encoded_bytes().serialize(serializer),
        }
    }

    pub fn deserialize<'a, D: Deserializer<'a>>(deserializer: D) -> Result<PathBuf, D::Error> {
        Ok(match Name::deserialize(deserializer)? {
            Name::Text(path) => path,
            Name::Bytes(bytes) => of_bytes(bytes).into(),
        })
    }

    #[cfg(unix)]
    fn of_bytes(bytes: Vec<u8>) -> OsString {
        std::os::unix::ffi::OsStringExt::from_vec(bytes)
    }

    /// A name that is not found again, so that its log is done again.
    #[cfg(not(unix))]
    fn of_bytes(bytes: Vec<u8>) -> OsString {
        String::from_utf8_lossy(&bytes).into_owned().into()
    }
}

/// The first line.
#[derive(PartialEq, Serialize, Deserialize)]
struct Header {
    schema: String,
    options: String,
}

/// Why a job cannot begin or be saved.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum JournalError {
    /// Another job left its journal.
    #[error(
        "{}: an unfinished job left this journal; go on with it (--resume), or remove it to begin again",
        .0.display()
    )]
    Unfinished(PathBuf),
    /// The journal is of a job with other options.
    #[error(
        "{}: is the journal of a job with other options: {found}; expected {expected}; give the same, or remove it to begin again",
        .path.display()
    )]
    OtherOptions {
        /// The journal.
        path: PathBuf,
        /// The settings of the interrupted job.
        found: String,
        /// The settings of this job.
        expected: String,
    },
    /// The table would take the place of something that is kept.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The object store that the table is to go to.
    #[error(transparent)]
    Object(#[from] ObjectError),
    /// Another process writes it.
    #[error("{}: another job is writing this journal", .0.display())]
    InUse(PathBuf),
    /// It cannot be written.
    #[error("{}: {source}", .path.display())]
    NotSaved {
        /// Which file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
}

/// What a job made, of which some may have been kept from before.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Summary {
    /// Logs, or runs where a column tells them apart.
    pub logs: u64,
    /// How many of these were kept: from the journal of an interrupted job, or from the table of an earlier one.
    pub done_before: u64,
    /// Rows with a manoeuvre.
    pub manoeuvres: u64,
    /// Manoeuvres whose model may be used.
    pub accepted: u64,
    /// Manoeuvres by the first reason of their verdict.
    pub verdicts: BTreeMap<String, u64>,
    /// Error rows.
    pub errors: u64,
    /// Error rows by their code.
    pub error_codes: BTreeMap<String, u64>,
}

/// Where an entry begins in the journal, by its place in the Parquet file.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Place {
    source: usize,
    run: u64,
    offset: u64,
}

/// The journal of a job.
pub struct Journal {
    path: PathBuf,
    out: PathBuf,
    outputs: Outputs,
    file: File,
    length: u64,
    indices: HashMap<PathBuf, usize>,
    sources: Vec<Source>,
    settings: String,
    done: HashSet<(usize, u64)>,
    /// Logs of which everything is done.
    whole: HashSet<usize>,
    places: Vec<Place>,
    done_before: u64,
    synced: Instant,
}

/// The file of a new journal, or with `resume` of the one that is there, for this process alone.
fn locked(path: &Path, resume: bool) -> Result<File, JournalError> {
    if path.exists() && !resume {
        return Err(JournalError::Unfinished(path.to_owned()));
    }
    let file = OpenOptions::new()
        .read(true)
        .append(true)
        .create(true)
        .open(path)
        .map_err(|source| JournalError::NotSaved { path: path.to_owned(), source })?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(_) => Err(JournalError::InUse(path.to_owned())),
    }
}

impl Journal {
    /// Opens the journal of a job that writes `out`: a new one, or with `resume` the one that is there. What an earlier job with the
    /// same options left in `out` is done for the logs that are as they were.
    pub fn open(
        out: &Path,
        sources: &[Source],
        options: &Options,
        resume: bool,
    ) -> Result<Self, JournalError> {
        let mut named: Vec<PathBuf> = sources.iter().map(|source| source.path.clone()).collect();
        named.push(out.to_path_buf());
        let path = journal_path(out);
        named.push(path.clone());
        let outputs = Outputs::of(named);
        let stored = objects::earlier(out)?;
        let earlier = stored.as_ref().map_or(out, |copy| copy.path());
        let checked = outputs.check_for(earlier, OutputKind::Results);
        checked.map_err(|error| error.of(out))?;
        outputs.check(&path)?;
        let file = locked(&path, resume)?;
        let mut journal = Self {
            file,
            length: 0,
            indices: sources
                .iter()
                .enumerate()
                .map(|(i, source)| (source.path.clone(), i))
                .collect(),
            sources: sources.to_vec(),
            settings: settings(options),
            done: HashSet::new(),
            whole: HashSet::new(),
            places: Vec::new(),
            done_before: 0,
            synced: Instant::now(),
            out: out.to_path_buf(),
            outputs,
            path: path.clone(),
        };
        let header = Header {
            schema: "seatrial.fleet_journal.v1".into(),
            options: journal.settings.clone(),
        };
        let found = journal.read_back();
        let found = found.map_err(|source| journal.not_saved(source))?;
        match found {
            Some(found) if found != header => {
                return Err(JournalError::OtherOptions {
                    path,
                    found: found.options,
                    expected: header.options,
                });
            }
            Some(_) => {}
            None => journal.write_line(&header)?,
        }
        if options.run_column.is_none() {
            journal.whole = journal.done.iter().map(|(source, _)| *source).collect();
        }
        journal.take_earlier(earlier)?;
        journal.done_before = journal.places.len() as u64;
        Ok(journal)
    }

    /// Takes over what the table of an earlier job says of unchanged logs.
    fn take_earlier(&mut self, table: &Path) -> Result<(), JournalError> {
        let settings = self.settings.clone();
        earlier::for_each_log(table, &settings, |rows| {
            let path = rows.first().map(|row| Path::new(&row.source));
            let Some(&source) = path.and_then(|path| self.indices.get(path)) else {
                return Ok(());
            };
            let Some(rows) = earlier::unchanged(&self.sources[source], rows) else {
                return Ok(());
            };
            let runs = rows.chunk_by(|one, next| one.run == next.run);
            for (run, rows) in runs.enumerate() {
                let now = &self.sources[source];
                self.keep(&Entry {
                    source: now.path.clone(),
                    bytes: now.bytes,
                    modified_ns: now.modified_ns,
                    etag: now.etag.clone(),
                    run: run as u64,
                    rows: rows.to_vec(),
                })?;
            }
            self.whole.insert(source);
            Ok(())
        })
    }

    /// Reads what is there as far as it is whole, and cuts off the rest.
    fn read_back(&mut self) -> io::Result<Option<Header>> {
        let mut lines = BufReader::new(self.file.try_clone()?);
        lines.seek(SeekFrom::Start(0))?;
        let mut header = None;
        let mut line = Vec::new();
        loop {
            line.clear();
            lines.read_until(b'\n', &mut line)?;
            let Some((b'\n', text)) = line.split_last() else {
                break;
            };
            if header.is_none() {
                let Ok(first) = serde_json::from_slice(text) else {
                    break;
                };
                header = Some(first);
            } else {
                let Ok(entry) = serde_json::from_slice::<Entry>(text) else {
                    break;
                };
                self.take(&entry);
            }
            self.length += line.len() as u64;
        }
        self.file.set_len(self.length)?;
        Ok(header)
    }

    /// Takes an entry at the end of the journal as done. Of a log that is not part of the job, has changed since,
    /// or was done before: `false`.
    fn take(&mut self, entry: &Entry) -> bool {
        let Some(&source) = self.indices.get(&entry.source) else {
            return false;
        };
        let now = &self.sources[source];
        let is_same = (now.bytes, now.modified_ns, &now.etag)
            == (entry.bytes, entry.modified_ns, &entry.etag);
        let is_new = is_same && self.done.insert((source, entry.run));
        if is_new {
            self.places.push(Place { source, run: entry.run, offset: self.length });
        }
        is_new
    }

    /// Is this run of this source done?
    pub fn is_done(&self, source: usize, run: u64) -> bool {
        self.done.contains(&(source, run))
    }

    /// Is all of this source done? Of the runs of a file only the table of an earlier job tells that before the file has been read.
    pub fn is_whole(&self, source: usize) -> bool {
        self.whole.contains(&source)
    }

    /// Keeps what was made of a log. What is there already is not kept twice.
    pub fn keep(&mut self, entry: &Entry) -> Result<(), JournalError> {
        if self.take(entry) {
            self.write_line(entry)?;
        }
        Ok(())
    }

    fn write_line(&mut self, line: &impl Serialize) -> Result<(), JournalError> {
        let mut bytes = serde_json::to_vec(line).map_err(|error| self.not_saved(error.into()))?;
        bytes.push(b'\n');
        let is_due = self.synced.elapsed() > SYNC_EVERY;
        let written = self.file.write_all(&bytes).and_then(|()| match is_due {
            true => self.file.sync_data(),
            false => Ok(()),
        });
        written.map_err(|source| self.not_saved(source))?;
        if is_due {
            self.synced = Instant::now();
        }
        self.length += bytes.len() as u64;
        Ok(())
    }

    fn not_saved(&self, source: io::Error) -> JournalError {
        JournalError::NotSaved { path: self.path.clone(), source }
    }

    /// Writes the Parquet file, puts it in its place in one step, and removes the journal.
    pub fn finish(mut self) -> Result<Summary, JournalError> {
        let (outputs, out) = (self.outputs.clone(), self.out.clone());
        if is_object(&out) {
            let not_saved = |source| self.not_saved(source);
            let mut file = tempfile::tempfile().map_err(not_saved)?;
            let summary = self.write_table(&file).map_err(|source| self.not_saved(source))?;
            objects::put(&out, &mut file)?;
            return self.end(summary);
        }
        let mut summary = Summary::default();
        let saved = outputs.save_with(&out, |file| {
            summary = self.write_table(file)?;
            Ok(())
        });
        saved.map_err(|failed| match failed {
            OutputError::NotSaved { path, error } => JournalError::NotSaved { path, source: error },
            refused @ OutputError::Refused { .. } => JournalError::Output(refused),
        })?;
        self.end(summary)
    }

    fn end(self, summary: Summary) -> Result<Summary, JournalError> {
        fs::remove_file(&self.path).map_err(|source| self.not_saved(source))?;
        Ok(summary)
    }

    fn write_table(&mut self, file: &File) -> io::Result<Summary> {
        self.places.sort_unstable();
        let mut summary = Summary { done_before: self.done_before, ..Summary::default() };
        let mut table = TableWriter::new(file, &self.settings)?;
        let mut journal = BufReader::new(self.file.try_clone()?);
        let mut line = Vec::new();
        let mut at = journal.seek(SeekFrom::Start(0))?;
        for place in &self.places {
            journal.seek_relative(place.offset as i64 - at as i64)?;
            line.clear();
            at = place.offset + journal.by_ref().read_until(b'\n', &mut line)? as u64;
            let entry: Entry = serde_json::from_slice(&line)?;
            summary.logs += 1;
            for row in entry.rows {
                summary.count(&row);
                table.push(row)?;
            }
        }
        table.finish()?;
        file.sync_all()?;
        Ok(summary)
    }
}

impl Summary {
    fn count(&mut self, row: &Row) {
        if let Some(code) = &row.error {
            self.errors += 1;
            *self.error_codes.entry(code.clone()).or_default() += 1;
            return;
        }
        self.manoeuvres += 1;
        self.accepted += u64::from(row.accepted == Some(true));
        let verdict = row.verdict.clone().unwrap_or_default();
        *self.verdicts.entry(verdict).or_default() += 1;
    }
}

/// What the rows depend on besides the logs.
fn settings(options: &Options) -> String {
    format!("seatrial {}, {options:?}", env!("CARGO_PKG_VERSION"))
}

/// `fleet.parquet.journal`
fn journal_path(out: &Path) -> PathBuf {
    let place = match is_object(out) {
        true => Path::new(out.file_name().unwrap_or_default()),
        false => out,
    };
    place.with_added_extension("journal")
}
