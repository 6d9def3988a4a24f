//! Which logs there are.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::log_file::{LogFiles, Source, is_log_name};
use super::objects::{self, ObjectError, is_object};

/// Where no logs can be looked for.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum NotFound {
    /// A folder or list that cannot be read.
    #[error("{}: {source}", .path.display())]
    Io {
        /// The path or pattern.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// Not a pattern.
    #[error(
        "{pattern}: {source}; expected a folder, a file, a list of files or a pattern such as 'logs/**/*.csv'"
    )]
    Pattern {
        /// As given.
        pattern: String,
        /// Where it is wrong.
        source: glob::PatternError,
    },
    /// Nothing fits.
    #[error(
        "{input}: no log there; expected a folder with logs, a log, a pattern such as 'logs/**/*.csv', or @LIST with a file name a line"
    )]
    Nothing {
        /// As given.
        input: String,
    },
    /// An object store that cannot be asked.
    #[error(transparent)]
    Object(#[from] ObjectError),
}

/// Looks for logs: below folders, by patterns (`*`, `?`, `[a-z]`, `**`), in lists (`@FILE` with a name a line, as
/// `find` prints them; blank lines and lines that begin with `#` are passed over), or a log itself; each in the file system or in an
/// object store. The table that the job writes is no log, wherever it stands.
pub fn find(inputs: &[String], out: &Path) -> Result<LogFiles, NotFound> {
    let mut sources = BTreeMap::new();
    let mut passed_over = 0;
    let table = out.canonicalize().ok();
    let is_table = |path: &Path| {
        path == out
            || path.file_name() == out.file_name()
                && table.is_some()
                && path.canonicalize().ok() == table
    };
    for input in inputs {
        let mut found = BTreeSet::new();
        let mut objects = Vec::new();
        let path = Path::new(input);
        if let Some(stored) = objects::find(input) {
            let stored = stored?;
            passed_over += stored.passed_over;
            objects = stored.sources;
        } else if let Some(list) = input.strip_prefix('@') {
            let list = Path::new(list);
            let text = fs::read(list).map_err(|source| io_error(list, source))?;
            let names = text.split(|byte| *byte == b'\n').map(<[u8]>::trim_ascii);
            let names = names.filter(|name| !name.is_empty() && !name.starts_with(b"#"));
            let (stored, files): (Vec<_>, Vec<_>) =
                names.map(path_of).partition(|path| is_object(path));
            objects = objects::look(&stored)?;
            found.extend(files);
        } else if path.is_dir() {
            passed_over += walk(path, &mut found)?;
        } else if path.exists() {
            found.insert(path.to_path_buf());
        } else {
            let pattern = glob::glob(input)
                .map_err(|source| NotFound::Pattern { pattern: input.clone(), source })?;
            found.extend(pattern.flatten().filter(|path| path.is_file()));
            fit_no_text(input, &mut found);
        }
        let mut found: Vec<Source> = found.iter().map(|path| Source::of(path)).collect();
        found.extend(objects);
        if path != out {
            found.retain(|source| !is_table(&source.path));
        }
        if found.is_empty() {
            return Err(NotFound::Nothing { input: input.clone() });
        }
        sources.extend(found.into_iter().map(|source| (source.path.clone(), source)));
    }
    Ok(LogFiles { sources: sources.into_values().collect(), passed_over })
}

/// Adds the files of a pattern whose names are no text, which the library of patterns passes over in silence.
fn fit_no_text(pattern: &str, found: &mut BTreeSet<PathBuf>) {
    let Ok(fits) = glob::Pattern::new(pattern) else {
        return;
    };
    let fixed = pattern.find(['*', '?', '[']).unwrap_or(pattern.len());
    let (root, rest) = pattern.split_at(pattern[..fixed].rfind('/').map_or(0, |at| at + 1));
    let depth = match rest.contains("**") {
        true => usize::MAX,
        false => rest.matches('/').count(),
    };
    let options =
        glob::MatchOptions { require_literal_separator: true, ..glob::MatchOptions::new() };
    let mut folders = vec![(PathBuf::from(root), 0)];
    while let Some((folder, below)) = folders.pop() {
        let named = match folder.as_os_str().is_empty() {
            true => Path::new("."),
            false => &folder,
        };
        // A folder that cannot be read holds nothing for the library either.
        for entry in fs::read_dir(named).into_iter().flatten().flatten() {
            let path = folder.join(entry.file_name());
            if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
                folders.extend((below < depth).then_some((path, below + 1)));
            } else if path.to_str().is_none()
                && fits.matches_with(&path.to_string_lossy(), options)
                && path.is_file()
            {
                found.insert(path);
            }
        }
    }
}

/// The path of a name that may be in any encoding.
#[cfg(unix)]
fn path_of(name: &[u8]) -> PathBuf {
    <std::ffi::OsStr as std::os::unix::ffi::OsStrExt>::from_bytes(name).into()
}

/// The path of a name in UTF-8.
#[cfg(not(unix))]
fn path_of(name: &[u8]) -> PathBuf {
    String::from_utf8_lossy(name).into_owned().into()
}

/// Adds the logs below a folder; how many files were passed over. Hidden files are none, and folders that are links
/// are not followed.
fn walk(folder: &Path, paths: &mut BTreeSet<PathBuf>) -> Result<usize, NotFound> {
    let mut passed_over = 0;
    let mut folders = vec![folder.to_path_buf()];
    while let Some(folder) = folders.pop() {
        let reading = |source| io_error(&folder, source);
        for entry in fs::read_dir(&folder).map_err(reading)? {
            let entry = entry.map_err(reading)?;
            let path = entry.path();
            if entry.file_name().to_string_lossy().starts_with('.') {
                continue;
            }
            if entry.file_type().map_err(reading)?.is_dir() {
                folders.push(path);
                continue;
            }
            if is_log_name(&path) && path.is_file() {
                paths.insert(path);
            } else {
                passed_over += 1;
            }
        }
    }
    Ok(passed_over)
}

fn io_error(path: &Path, source: io::Error) -> NotFound {
    NotFound::Io { path: path.to_path_buf(), source }
}
