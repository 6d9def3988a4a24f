//! Where the bytes of a log come from: a file, memory, or whoever reads it at the places that are asked for.

use std::collections::BTreeMap;
use std::fmt;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use sha2::{Digest, Sha256};

use crate::table::hexadecimal;

/// SHA-256 of a file in hexadecimal, as [`LogReader::sha256`](crate::LogReader::sha256) gives it.
///
/// # Errors
/// The file cannot be read.
pub fn sha256(path: &Path) -> io::Result<String> {
    Input::File(File::open(path)?).sha256()
}

/// Bytes that can be read at any place.
pub trait Source: Send + Sync {
    /// Number of bytes.
    fn length(&self) -> u64;

    /// Reads bytes from a position on; how many were read, and 0 only behind the last byte or for an empty buffer.
    ///
    /// # Errors
    /// The bytes are no longer there.
    fn read_at(&self, position: u64, buffer: &mut [u8]) -> io::Result<usize>;

    /// SHA-256 of all bytes, where it is known without reading them.
    fn sha256(&self) -> Option<[u8; 32]> {
        None
    }
}

impl<T: AsRef<[u8]> + Send + Sync> Source for T {
    fn length(&self) -> u64 {
        self.as_ref().len() as u64
    }

    fn read_at(&self, position: u64, buffer: &mut [u8]) -> io::Result<usize> {
        let position = usize::try_from(position).unwrap_or(usize::MAX);
        let rest = self.as_ref().get(position..).unwrap_or_default();
        let count = rest.len().min(buffer.len());
        buffer[..count].copy_from_slice(&rest[..count]);
        Ok(count)
    }
}

/// Bytes that were made of a file.
struct DerivedBytes {
    bytes: Vec<u8>,
    /// Of the file.
    sha256: [u8; 32],
}

impl Source for DerivedBytes {
    fn length(&self) -> u64 {
        self.bytes.length()
    }

    fn read_at(&self, position: u64, buffer: &mut [u8]) -> io::Result<usize> {
        self.bytes.read_at(position, buffer)
    }

    fn sha256(&self) -> Option<[u8; 32]> {
        Some(self.sha256)
    }
}

/// Files by the paths that they are opened by: where there is no file system, as in a browser, or a log was
/// never written to one. A path that is not held is one of the file system.
#[derive(Clone, Default)]
pub struct FileMap(BTreeMap<PathBuf, Arc<dyn Source>>);

impl FileMap {
    /// Holds a file, in place of one of the same path.
    pub fn insert(&mut self, path: impl Into<PathBuf>, bytes: impl Source + 'static) {
        self.0.insert(path.into(), Arc::new(bytes));
    }

    pub(crate) fn get(&self, path: &Path) -> Option<Input> {
        let source = Arc::clone(self.0.get(path)?);
        Some(Input::Memory(Cursor { source, position: 0 }))
    }

    /// The file of this path, held or not.
    pub(crate) fn open(&self, path: &Path) -> io::Result<Input> {
        match self.get(path) {
            Some(held) => Ok(held),
            None => opened(path).map(Input::File),
        }
    }
}

/// Opens a file, or a folder. A device gives bytes without end, and a pipe keeps whoever opens it waiting.
pub(crate) fn opened(path: &Path) -> io::Result<File> {
    let about = std::fs::metadata(path)?;
    match about.is_file() || about.is_dir() {
        true => File::open(path),
        false => Err(io::Error::new(
            io::ErrorKind::InvalidInput,
            "no file but a device or a pipe; copy what it gives into a file, or name - for standard input",
        )),
    }
}

/// Equal are the same files in the same places, not equal bytes.
impl PartialEq for FileMap {
    fn eq(&self, other: &Self) -> bool {
        let mut pairs = self.0.values().zip(other.0.values());
        self.0.keys().eq(other.0.keys()) && pairs.all(|(one, two)| Arc::ptr_eq(one, two))
    }
}

impl fmt::Debug for FileMap {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let lengths = self.0.iter().map(|(path, source)| (path, source.length()));
        f.debug_map().entries(lengths).finish()
    }
}

/// The bytes of a file, from any place.
pub(crate) enum Input {
    File(File),
    Memory(Cursor),
}

/// A place in a source.
#[derive(Clone)]
pub(crate) struct Cursor {
    source: Arc<dyn Source>,
    position: u64,
}

impl Input {
    /// Bytes in memory.
    pub fn of_memory(bytes: Vec<u8>) -> Self {
        Self::Memory(Cursor { source: Arc::new(bytes), position: 0 })
    }

    /// Bytes in memory that were made of a file, with the file's own SHA-256.
    pub fn made_of(bytes: Vec<u8>, file: &mut Self) -> io::Result<Self> {
        let sha256 = file.digest()?;
        Ok(Self::Memory(Cursor { source: Arc::new(DerivedBytes { bytes, sha256 }), position: 0 }))
    }

    pub fn is_folder(&self) -> io::Result<bool> {
        match self {
            Self::File(file) => Ok(file.metadata()?.is_dir()),
            Self::Memory(_) => Ok(false),
        }
    }

    #[cfg(any(
        feature = "mcap-reader",
        feature = "parquet-reader",
        feature = "rosbag2",
        feature = "containers"
    ))]
    pub fn length(&self) -> io::Result<u64> {
        match self {
            Self::File(file) => Ok(file.metadata()?.len()),
            Self::Memory(held) => Ok(held.source.length()),
        }
    }

    /// SHA-256 of all bytes in hexadecimal; the place is lost.
    pub fn sha256(&mut self) -> io::Result<String> {
        self.digest().map(|digest| hexadecimal(&digest))
    }

    fn digest(&mut self) -> io::Result<[u8; 32]> {
        if let Self::Memory(held) = self
            && let Some(known) = held.source.sha256()
        {
            return Ok(known);
        }
        self.rewind()?;
        let mut hash = Sha256::new();
        let mut buffer = vec![0; 1 << 18];
        loop {
            match self.read(&mut buffer) {
                Ok(0) => return Ok(hash.finalize().into()),
                Ok(count) => hash.update(&buffer[..count]),
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
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

    /// Another handle of the file. Handles of one file of the file system share their place.
    #[cfg(any(feature = "parquet-reader", feature = "without-c", feature = "containers"))]
    pub fn another(&self) -> io::Result<Self> {
        match self {
            Self::File(file) => file.try_clone().map(Self::File),
            Self::Memory(held) => Ok(Self::Memory(held.clone())),
        }
    }
}

impl Read for Cursor {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.source.read_at(self.position, buffer)?;
        self.position += count as u64;
        Ok(count)
    }
}

impl Seek for Cursor {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let position = match to {
            SeekFrom::Start(position) => Some(position),
            SeekFrom::End(offset) => self.source.length().checked_add_signed(offset),
            SeekFrom::Current(offset) => self.position.checked_add_signed(offset),
        };
        self.position = position.ok_or(io::ErrorKind::InvalidInput)?;
        Ok(self.position)
    }
}

impl Read for Input {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self {
            Self::File(file) => file.read(buffer),
            Self::Memory(held) => held.read(buffer),
        }
    }
}

impl Seek for Input {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        match self {
            Self::File(file) => file.seek(to),
            Self::Memory(held) => held.seek(to),
        }
    }
}
