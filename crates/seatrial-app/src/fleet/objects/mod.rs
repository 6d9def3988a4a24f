//! Logs and tables in object stores: `s3://BUCKET/KEY`, `gs://BUCKET/KEY`, and `https://` of any server.
//!
//! A log is downloaded into a temporary file while it is worked on: memory stays bounded, and every format can be read from any place.

#[cfg_attr(not(feature = "object-stores"), path = "not_built.rs")]
mod store;

use std::fs::File;
use std::io::{self, Read, Seek};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use glob::{MatchOptions, Pattern};
use seatrial_logs::{Fault, FileMap, ReadError};
use tempfile::NamedTempFile;

use super::Source;
use super::log_file::{LogFiles, is_log_name};

/// How addresses begin.
const SCHEMES: [&str; 4] = ["s3", "gs", "https", "http"];

/// An object store cannot be asked, or does not give what is asked for.
#[derive(Debug, thiserror::Error)]
#[error("{address}: {cause}; {advice}")]
pub struct ObjectError {
    /// Of what.
    pub address: String,
    /// As the store or the network says it.
    pub cause: String,
    /// What to do.
    pub advice: &'static str,
}

/// A store and a key in it, as in `s3://bucket` and `logs/run.csv`.
#[derive(Clone, Copy)]
struct Address<'a> {
    text: &'a str,
    scheme: &'a str,
    /// Up to the bucket or the server.
    base: &'a str,
    key: &'a str,
}

impl<'a> Address<'a> {
    fn of(text: &'a str) -> Option<Self> {
        let (scheme, rest) = text.split_once("://")?;
        SCHEMES.contains(&scheme).then(|| {
            let end = rest.find('/').unwrap_or(rest.len());
            Self {
                text,
                scheme,
                base: &text[..text.len() - rest.len() + end],
                key: rest[end..].trim_start_matches('/'),
            }
        })
    }

    fn error(self, cause: impl ToString, advice: &'static str) -> ObjectError {
        ObjectError { address: self.text.to_owned(), cause: cause.to_string(), advice }
    }
}

/// Is this an address in an object store, and no file?
pub fn is_object(path: &Path) -> bool {
    address(path).is_some()
}

fn address(path: &Path) -> Option<Address<'_>> {
    path.to_str().and_then(Address::of)
}

/// The logs of an address: an object, a pattern, or everything below a prefix whose name ends like a log.
pub(super) fn find(text: &str) -> Option<Result<LogFiles, ObjectError>> {
    let address = Address::of(text)?;
    let fixed = address.key.find(['*', '?', '[']);
    Some(match fixed {
        Some(fixed) => fit(address, fixed),
        None => below(address),
    })
}

fn below(address: Address) -> Result<LogFiles, ObjectError> {
    if !address.key.is_empty()
        && !address.key.ends_with('/')
        && let Some(source) = store::look(address)?
    {
        return Ok(LogFiles { sources: vec![source], passed_over: 0 });
    }
    let listed = store::list(address, address.key)?;
    let all = listed.len();
    let sources: Vec<Source> =
        (listed.into_iter()).filter(|source| is_log_name(&source.path)).collect();
    Ok(LogFiles { passed_over: all - sources.len(), sources })
}

fn fit(address: Address, fixed: usize) -> Result<LogFiles, ObjectError> {
    let pattern = Pattern::new(address.key).map_err(|error| {
        address.error(error, "expected a pattern such as s3://bucket/logs/**/*.csv")
    })?;
    let options = MatchOptions { require_literal_separator: true, ..MatchOptions::new() };
    let prefix = &address.key[..address.key[..fixed].rfind('/').map_or(0, |at| at + 1)];
    let mut sources = store::list(address, prefix)?;
    sources.retain(|source| {
        let found = self::address(&source.path);
        found.is_some_and(|found| pattern.matches_with(found.key, options))
    });
    Ok(LogFiles { sources, passed_over: 0 })
}

/// Looks at objects of a list. One that is not there is a source, too: reading it gives its error row.
pub(super) fn look(paths: &[PathBuf]) -> Result<Vec<Source>, ObjectError> {
    let addresses: Vec<Address> = paths.iter().filter_map(|path| address(path)).collect();
    store::look_at_all(&addresses)
}

/// The bytes of a log, where it is an object; a file is read in its place.
pub(super) fn held(source: &Source) -> Result<FileMap, ReadError> {
    let mut held = FileMap::default();
    if let Some(address) = address(&source.path) {
        let failed = |source: io::Error| ReadError {
            log: address.text.to_owned(),
            fault: Fault::Io { doing: "downloaded", source },
        };
        let copy = copy(address, Some(source)).map_err(|error| {
            let ObjectError { cause, advice, .. } = error;
            failed(io::Error::other(format!("{cause}; {advice}")))
        })?;
        held.insert(&source.path, Download::of(copy.into_file()).map_err(failed)?);
    }
    Ok(held)
}

/// The table of an earlier job in a store, as a file here; `None` where nothing is stored, or the table is a file.
pub(super) fn earlier(out: &Path) -> Result<Option<NamedTempFile>, ObjectError> {
    let Some(address) = address(out) else {
        return Ok(None);
    };
    let found = store::look(address)?;
    found.map(|_| copy(address, None)).transpose()
}

/// Downloads an object; of a source only as it was when it was found.
fn copy(address: Address, source: Option<&Source>) -> Result<NamedTempFile, ObjectError> {
    let mut file = NamedTempFile::new().map_err(|error| address.error(error, DISK))?;
    store::download(address, source, file.as_file_mut())?;
    Ok(file)
}

/// Puts a file into a store.
pub(super) fn put(out: &Path, file: &mut File) -> Result<(), ObjectError> {
    match address(out) {
        Some(address) => store::upload(address, file),
        None => Ok(()),
    }
}

/// Where there is no place for a download.
const DISK: &str = "a download needs room in the folder of temporary files, which TMPDIR names";

/// A downloaded log. The file is gone when the log is closed.
struct Download {
    file: Mutex<File>,
    length: u64,
}

impl Download {
    fn of(file: File) -> io::Result<Self> {
        Ok(Self { length: file.metadata()?.len(), file: Mutex::new(file) })
    }
}

impl seatrial_logs::Source for Download {
    fn length(&self) -> u64 {
        self.length
    }

    fn read_at(&self, position: u64, buffer: &mut [u8]) -> io::Result<usize> {
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        file.seek(io::SeekFrom::Start(position))?;
        file.read(buffer)
    }
}
