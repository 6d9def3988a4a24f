//! Files that are read as the delimited text that their programs would export: workbooks, MATLAB's arrays, text in other encodings.

use std::io::{self, Read};

use encoding_rs::{CoderResult, Decoder, Encoding};

use crate::Quantity;
use crate::csv::Text;
use crate::description::Format;
use crate::error::{Fault, Place};
use crate::input::Input;
use crate::table::{Cell, Table};

/// Bytes that are decoded at once.
const PIECE: usize = 1 << 14;
/// Bytes that one encoded byte decodes to at most, and room for what a decoder keeps.
const LONGEST_DECODED: usize = 3 * PIECE + 64;

/// A file and the text that it is read as.
pub(crate) struct AsText {
    file: Input,
    format: Format,
    text: Text<Box<dyn Read + Send>>,
    warnings: Vec<String>,
}

impl AsText {
    pub fn new(
        format: Format,
        file: Input,
        text: impl Read + Send + 'static,
        warnings: Vec<String>,
    ) -> Result<Self, Fault> {
        let text: Box<dyn Read + Send> = Box::new(text);
        Ok(Self {
            text: Text::open(text)?,
            file,
            format,
            warnings,
        })
    }

    /// Text in an encoding other than UTF-8.
    pub fn encoded(file: Input, encoding: &'static Encoding) -> Result<Self, Fault> {
        let text = Decoded {
            encoded: file.another().map_err(Fault::read)?,
            decoder: encoding.new_decoder_with_bom_removal(),
            text: Vec::new(),
            given: 0,
            at_end: false,
        };
        let warning = format!("the text is read as {}", encoding.name());
        Self::new(Format::Csv, file, text, vec![warning])
    }
}

/// The encoding of a text that begins so, where it is not UTF-8.
pub(crate) fn encoding(start: &[u8]) -> Option<&'static Encoding> {
    if let Some((encoding, _)) = Encoding::for_bom(start) {
        return Some(encoding).filter(|encoding| *encoding != encoding_rs::UTF_8);
    }
    let is_control = |byte: &u8| *byte < b'\t' || (0x0e..0x20).contains(byte);
    // A letter cut by the end is no error.
    let end = start.iter().rposition(|byte| *byte == b'\n')? + 1;
    let text = &start[..end];
    if std::str::from_utf8(text).is_ok() || text.iter().any(is_control) {
        return None;
    }
    let (decoded, has_errors) = encoding_rs::SHIFT_JIS.decode_without_bom_handling(text);
    let is_japanese = |letter: char| ('\u{3040}'..='\u{9fff}').contains(&letter);
    let letters = decoded
        .chars()
        .filter(|letter| is_japanese(*letter))
        .count();
    // In Latin-1 single bytes beyond ASCII stand among those of ASCII.
    let others = text.iter().filter(|byte| !byte.is_ascii()).count();
    (!has_errors && 4 * letters > others).then_some(encoding_rs::SHIFT_JIS)
}

/// Rows of text that are made one after the other; an empty one is the end.
pub(crate) struct Rows<F> {
    next: F,
    row: Vec<u8>,
    given: usize,
}

impl<F: FnMut() -> Result<String, Fault>> Rows<F> {
    pub fn new(next: F) -> Self {
        Self {
            next,
            row: Vec::new(),
            given: 0,
        }
    }
}

impl<F: FnMut() -> Result<String, Fault>> Read for Rows<F> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.given == self.row.len() {
            self.row = (self.next)().map_err(io::Error::other)?.into_bytes();
            self.given = 0;
        }
        let count = buffer.len().min(self.row.len() - self.given);
        buffer[..count].copy_from_slice(&self.row[self.given..self.given + count]);
        self.given += count;
        Ok(count)
    }
}

/// Text as UTF-8.
struct Decoded {
    encoded: Input,
    decoder: Decoder,
    text: Vec<u8>,
    given: usize,
    at_end: bool,
}

impl Read for Decoded {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        while self.given == self.text.len() && !self.at_end {
            let mut piece = [0; PIECE];
            let count = self.encoded.read(&mut piece)?;
            self.at_end = count == 0;
            self.text.resize(LONGEST_DECODED, 0);
            let (result, _, written, _) =
                self.decoder
                    .decode_to_utf8(&piece[..count], &mut self.text, self.at_end);
            debug_assert_eq!(result, CoderResult::InputEmpty);
            self.text.truncate(written);
            self.given = 0;
        }
        let count = buffer.len().min(self.text.len() - self.given);
        buffer[..count].copy_from_slice(&self.text[self.given..self.given + count]);
        self.given += count;
        Ok(count)
    }
}

impl Table for AsText {
    fn format(&self) -> Format {
        self.format.clone()
    }

    fn columns(&self) -> &[String] {
        self.text.columns()
    }

    fn select(&mut self, columns: &[(Quantity, usize)]) {
        self.text.select(columns);
    }

    fn leave_out(&mut self, position: usize) {
        self.text.leave_out(position);
    }

    fn next_row(&mut self, cells: &mut Vec<Cell>) -> Result<Option<Place>, Fault> {
        self.text.next_row(cells)
    }

    fn bytes_read(&self) -> u64 {
        self.text.bytes_read()
    }

    fn sha256(&mut self) -> Result<String, Fault> {
        self.file.sha256().map_err(Fault::read)
    }

    fn warnings(&self) -> Vec<String> {
        [self.warnings.clone(), self.text.warnings()].concat()
    }
}
