//! The pages of a column, unpacked within bounds.
//!
//! The library trusts what headers say of sizes and counts, and unpacks gzip without any bound; here a page is
//! refused before it is unpacked where it and those that other columns hold would be more than
//!
//! ```text
//! 32 MB + the length of the file            at one time
//! 64 MB + 256 times the length of the file  from the first page to the last
//! ```

use std::io::{Read, Seek, SeekFrom};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use bytes::Bytes;
use parquet::basic::{Compression, Encoding};
use parquet::column::page::{Page, PageMetadata, PageReader};
use parquet::errors::{ParquetError, Result};
use parquet::file::metadata::ColumnChunkMetaData;
use parquet::file::reader::{ChunkReader, Length};

use super::page_header::{PageHeader, PageKind};
use crate::input::Input;

/// Headers hold statistics; no writer makes longer ones.
const LONGEST_HEADER: u64 = 1 << 16;
/// What a page counts for at least: reading many short ones takes time, too.
const SHORTEST_COUNTED: u64 = 1 << 12;
/// A decoded value of a dictionary of texts, beside its bytes.
const DICTIONARY_VALUE: u64 = 40;

/// A file that is sound, as far as one can tell, and asks for more than is given.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub(super) struct TooMuch(String);

/// What all columns together may hold and unpack.
pub(super) struct Allowance {
    most_held: u64,
    most_unpacked: u64,
    held: AtomicU64,
    unpacked: AtomicU64,
}

impl Allowance {
    pub fn of(file_length: u64) -> Arc<Self> {
        Arc::new(Self {
            most_held: (32 << 20) + file_length,
            most_unpacked: (64 << 20) + 256 * file_length,
            held: AtomicU64::new(0),
            unpacked: AtomicU64::new(0),
        })
    }

    fn hold(&self, bytes: u64) -> Result<()> {
        let held = self.held.fetch_add(bytes, Ordering::Relaxed) + bytes;
        let counted = bytes.max(SHORTEST_COUNTED);
        let unpacked = self.unpacked.fetch_add(counted, Ordering::Relaxed) + counted;
        let too_much = |what: String| Err(ParquetError::External(Box::new(TooMuch(what))));
        if held > self.most_held {
            return too_much(format!(
                "a page of {bytes} bytes with those of other columns is more than the {} that are held of a file of this length",
                self.most_held
            ));
        }
        if unpacked > self.most_unpacked {
            return too_much(format!(
                "it unpacks to more than {} bytes, 256 times its length",
                self.most_unpacked
            ));
        }
        Ok(())
    }
}

/// The pages of a column in a row group.
pub(super) struct Pages {
    file: Input,
    at: u64,
    end: u64,
    compression: Compression,
    has_definition_levels: bool,
    allowance: Arc<Allowance>,
    /// Bytes of the dictionary and of the last two pages: the reader may hold both.
    dictionary: u64,
    last: [u64; 2],
}

impl Pages {
    pub fn of(file: Input, column: &ColumnChunkMetaData, allowance: Arc<Allowance>) -> Self {
        let (from, length) = column.byte_range();
        Self {
            file,
            at: from,
            end: from + length,
            compression: column.compression(),
            has_definition_levels: column.column_descr().max_def_level() > 0,
            allowance,
            dictionary: 0,
            last: [0; 2],
        }
    }

    fn header(&self) -> Result<PageHeader> {
        let mut seen = Vec::new();
        for window in [1 << 8, LONGEST_HEADER] {
            let mut rest = self.file.get_read(self.at)?.take(window.min(self.end - self.at));
            seen.clear();
            rest.read_to_end(&mut seen)?;
            if let Some(header) = PageHeader::read(&seen) {
                return Ok(header);
            }
        }
        Err(broken("the header of a page is none"))
    }

    /// Charges a page before it is unpacked.
    fn hold(&mut self, header: &PageHeader) -> Result<()> {
        let bytes = header.unpacked.max(header.packed) as u64;
        let (bytes, freed) = match header.kind {
            PageKind::Dictionary { values, .. } => {
                let decoded = bytes + DICTIONARY_VALUE * u64::from(values);
                (decoded, std::mem::replace(&mut self.dictionary, decoded))
            }
            _ => {
                let freed = self.last[0];
                self.last = [self.last[1], bytes];
                (bytes, freed)
            }
        };
        self.allowance.held.fetch_sub(freed, Ordering::Relaxed);
        self.allowance.hold(bytes)
    }

    /// Bytes of a page of this length when they are unpacked: neither more nor fewer.
    fn unpack(&self, packed: &[u8], length: usize) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        match self.compression {
            _ if length == 0 => {}
            Compression::SNAPPY => {
                bytes.resize(length, 0);
                let count = snap::raw::Decoder::new().decompress(packed, &mut bytes);
                let count = count.map_err(|error| broken(&error.to_string()))?;
                bytes.truncate(count);
            }
            Compression::ZSTD(_) => bytes = unpacked_by_zstd(packed, length)?,
            Compression::GZIP(_) => {
                let mut rest = flate2::read::MultiGzDecoder::new(packed).take(length as u64 + 1);
                rest.read_to_end(&mut bytes)?;
            }
            other => {
                return Err(ParquetError::NYI(format!(
                    "its pages are packed by {other}; expected SNAPPY, ZSTD or GZIP"
                )));
            }
        }
        match bytes.len() == length {
            true => Ok(bytes),
            false => Err(broken("a page unpacks to another length than its header says")),
        }
    }

    /// The page of a header; `None` where it is none of data.
    fn page(&mut self, header: &PageHeader) -> Result<Option<Page>> {
        if let PageKind::Other = header.kind {
            return Ok(None);
        }
        self.hold(header)?;
        let body = self.file.get_bytes(self.at, header.packed)?;
        if header.checksum.is_some_and(|sum| sum != crc32fast::hash(&body)) {
            let what = format!("the page at byte {} has a wrong checksum", self.at);
            return Err(broken(&what));
        }
        let is_plain = matches!(self.compression, Compression::UNCOMPRESSED);
        let whole = |body: &[u8]| match is_plain {
            true => Ok(body.to_vec()),
            false => self.unpack(body, header.unpacked),
        };
        Ok(Some(match header.kind {
            PageKind::Data { values, encoding, definition_encoding } => {
                if self.has_definition_levels && definition_encoding != RLE {
                    return Err(broken("levels in an encoding that is no longer allowed"));
                }
                Page::DataPage {
                    buf: whole(&body)?.into(),
                    num_values: values,
                    encoding: encoding_of(encoding)?,
                    def_level_encoding: Encoding::RLE,
                    rep_level_encoding: Encoding::RLE,
                    statistics: None,
                }
            }
            PageKind::Data2 {
                values,
                nulls,
                rows,
                encoding,
                definition_length,
                repetition_length,
                is_packed,
            } => {
                let levels = definition_length as usize + repetition_length as usize;
                let Some((first, rest)) =
                    body.split_at_checked(levels).filter(|_| levels <= header.unpacked)
                else {
                    return Err(broken("the levels of a page are longer than the page"));
                };
                let buf = match is_plain || !is_packed {
                    true => body.clone(),
                    false => {
                        let values = self.unpack(rest, header.unpacked - levels)?;
                        [first, &values].concat().into()
                    }
                };
                Page::DataPageV2 {
                    buf,
                    num_values: values,
                    encoding: encoding_of(encoding)?,
                    num_nulls: nulls,
                    num_rows: rows,
                    def_levels_byte_len: definition_length,
                    rep_levels_byte_len: repetition_length,
                    is_compressed: is_packed,
                    statistics: None,
                }
            }
            PageKind::Dictionary { values, encoding } => {
                let buf = whole(&body)?;
                if values as usize > buf.len() {
                    return Err(broken("a dictionary has more values than bytes"));
                }
                Page::DictionaryPage {
                    buf: buf.into(),
                    num_values: values,
                    encoding: encoding_of(encoding)?,
                    is_sorted: false,
                }
            }
            PageKind::Other => return Ok(None),
        }))
    }
}

/// At most so many bytes.
#[cfg(feature = "parquet")]
fn unpacked_by_zstd(packed: &[u8], length: usize) -> std::io::Result<Vec<u8>> {
    zstd::bulk::decompress(packed, length)
}

/// At most so many bytes.
#[cfg(not(feature = "parquet"))]
fn unpacked_by_zstd(packed: &[u8], length: usize) -> std::io::Result<Vec<u8>> {
    crate::unpack::zstd(packed, length)
}

impl Length for Input {
    fn len(&self) -> u64 {
        self.length().unwrap_or(0)
    }
}

impl ChunkReader for Input {
    type T = Self;

    fn get_read(&self, start: u64) -> Result<Self> {
        let mut other = self.another()?;
        other.seek(SeekFrom::Start(start))?;
        Ok(other)
    }

    fn get_bytes(&self, start: u64, length: usize) -> Result<Bytes> {
        let mut bytes = Vec::with_capacity(length);
        let mut part = self.get_read(start)?.take(length as u64);
        match part.read_to_end(&mut bytes)? == length {
            true => Ok(bytes.into()),
            false => Err(broken("the file ends before its last page")),
        }
    }
}

impl Drop for Pages {
    fn drop(&mut self) {
        let held = self.dictionary + self.last[0] + self.last[1];
        self.allowance.held.fetch_sub(held, Ordering::Relaxed);
    }
}

impl Iterator for Pages {
    type Item = Result<Page>;

    fn next(&mut self) -> Option<Self::Item> {
        self.get_next_page().transpose()
    }
}

impl PageReader for Pages {
    fn get_next_page(&mut self) -> Result<Option<Page>> {
        while self.at < self.end {
            let header = self.header()?;
            self.at += header.length as u64;
            if header.packed as u64 > self.end - self.at {
                return Err(broken("a page goes on behind the end of its column"));
            }
            let page = self.page(&header)?;
            self.at += header.packed as u64;
            if page.is_some() {
                return Ok(page);
            }
        }
        Ok(None)
    }

    fn peek_next_page(&mut self) -> Result<Option<PageMetadata>> {
        Err(ParquetError::NYI("pages are read one after another".into()))
    }

    fn skip_next_page(&mut self) -> Result<()> {
        self.get_next_page().map(drop)
    }

    /// Columns of lists are not read.
    fn at_record_boundary(&mut self) -> Result<bool> {
        Ok(true)
    }
}

const RLE: i64 = 3;

/// Encodings in which what is decoded is bounded by the page; of texts whose lengths or beginnings are
/// differences the library trusts counts.
fn encoding_of(number: i64) -> Result<Encoding> {
    Ok(match number {
        0 => Encoding::PLAIN,
        2 => Encoding::PLAIN_DICTIONARY,
        RLE => Encoding::RLE,
        5 => Encoding::DELTA_BINARY_PACKED,
        8 => Encoding::RLE_DICTIONARY,
        9 => Encoding::BYTE_STREAM_SPLIT,
        6 | 7 => {
            return Err(ParquetError::NYI(
                "text in the encodings DELTA_LENGTH_BYTE_ARRAY and DELTA_BYTE_ARRAY is not read; write it as PLAIN".into(),
            ));
        }
        _ => return Err(broken("a page is in an encoding that is unknown")),
    })
}

fn broken(what: &str) -> ParquetError {
    ParquetError::General(what.into())
}
