//! A log among others, before it is read.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

use seatrial_logs::Format;

/// A log as it was when the job began.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Source {
    /// As found: a file, or the address of an object.
    pub path: PathBuf,
    /// Its length; 0 where it cannot be seen.
    pub bytes: u64,
    /// When it was last written, ns since 1970; 0 where that is not known.
    pub modified_ns: i64,
    /// What its object store calls this version of it.
    pub etag: Option<String>,
}

impl Source {
    /// Looks at a file. One that is not there is a source, too: reading it gives its error row.
    pub fn of(path: &Path) -> Self {
        let metadata = fs::metadata(path).ok();
        let modified = metadata.as_ref().and_then(|m| m.modified().ok());
        let since_1970 = modified.and_then(|at| at.duration_since(UNIX_EPOCH).ok());
        Self {
            path: path.to_path_buf(),
            bytes: metadata.as_ref().map_or(0, fs::Metadata::len),
            modified_ns: since_1970.map_or(0, |t| i64::try_from(t.as_nanos()).unwrap_or(0)),
            etag: None,
        }
    }

    /// When it was last written, as a row has it: microseconds since 1970.
    pub(super) fn modified(&self) -> Option<i64> {
        (self.modified_ns != 0).then_some(self.modified_ns.div_euclid(1000))
    }
}

/// The logs found.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LogFiles {
    /// In the order of their names, each once.
    pub sources: Vec<Source>,
    /// Files in folders whose names do not end like those of logs.
    pub passed_over: usize,
}

/// Does a name end like that of a log? In a folder other files are passed over.
pub(super) fn is_log_name(path: &Path) -> bool {
    let ending = path.extension().map(|ending| ending.to_ascii_lowercase());
    let endings = Format::NAMES.iter().flat_map(|(_, _, endings)| *endings);
    ending.is_some_and(|ending| endings.into_iter().any(|known| ending == *known))
}
