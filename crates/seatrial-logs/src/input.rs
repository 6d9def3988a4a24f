//! Where the bytes of a log come from: a file, or memory.

use std::collections::BTreeMap;
use std::fmt;
use std::fs::File;
use std::io::{self, Cursor, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Files in memory, by the paths that they are opened by: where there is no file system, as in a browser, or a log was
/// never written to one. A path that is not held is one of the file system.
#[derive(Clone, Default, PartialEq, Eq)]
pub struct Held(BTreeMap<PathBuf, Arc<[u8]>>);

impl Held {
    /// Holds a file, in place of one of the same path.
    pub fn insert(&mut self, path: impl Into<PathBuf>, bytes: impl Into<Arc<[u8]>>) {
        self.0.insert(path.into(), bytes.into());
    }

    pub(crate) fn get(&self, path: &Path) -> Option<Input> {
        let bytes = self.0.get(path)?;
        Some(Input::Memory(Cursor::new(Arc::clone(bytes))))
    }

    /// The file of this path, held or not.
    pub(crate) fn open(&self, path: &Path) -> io::Result<Input> {
        match self.get(path) {
            Some(held) => Ok(held),
            None => File::open(path).map(Input::File),
        }
    }
}

impl fmt::Debug for Held {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let lengths = self.0.iter().map(|(path, bytes)| (path, bytes.len()));
        f.debug_map().entries(lengths).finish()
    }
}

/// The bytes of a file, from any place.
pub(crate) enum Input {
    File(File),
    Memory(Cursor<Arc<[u8]>>),
}

impl Input {
    pub fn is_folder(&self) -> io::Result<bool> {
        match self {
            Self::File(file) => Ok(file.metadata()?.is_dir()),
            Self::Memory(_) => Ok(false),
        }
    }

    #[cfg(any(feature = "mcap-reader", feature = "rosbag2"))]
    pub fn length(&self) -> io::Result<u64> {
        match self {
            Self::File(file) => Ok(file.metadata()?.len()),
            Self::Memory(bytes) => Ok(bytes.get_ref().len() as u64),
        }
    }

    /// The name by which the file system opens it; empty where it does not.
    #[cfg(feature = "rosbag2")]
    pub fn path<'a>(&self, path: &'a Path) -> &'a Path {
        match self {
            Self::File(_) => path,
            Self::Memory(_) => Path::new(""),
        }
    }

    /// As a file of the file system, for who reads no other: what is in memory goes into one without a name.
    #[cfg(feature = "parquet")]
    pub fn into_file(self) -> io::Result<File> {
        match self {
            Self::File(file) => Ok(file),
            Self::Memory(mut bytes) => {
                let mut file = tempfile::tempfile()?;
                io::copy(&mut bytes, &mut file)?;
                file.rewind()?;
                Ok(file)
            }
        }
    }
}

impl Read for Input {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self {
            Self::File(file) => file.read(buffer),
            Self::Memory(bytes) => bytes.read(buffer),
        }
    }
}

impl Seek for Input {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        match self {
            Self::File(file) => file.seek(to),
            Self::Memory(bytes) => bytes.seek(to),
        }
    }
}
