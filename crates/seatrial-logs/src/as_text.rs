//! Files that are read as the delimited text that their programs would export: workbooks, MATLAB's arrays, text in other encodings.

use std::io::{self, Cursor, Read};

use encoding_rs::{CoderResult, Encoding};

use crate::error::Fault;
use crate::input::Input;

/// Bytes that are decoded at once.
const PIECE: usize = 1 << 14;
/// Bytes that one encoded byte decodes to at most, and room for what a decoder keeps.
const LONGEST_DECODED: usize = 3 * PIECE + 64;

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
    let letters = decoded.chars().filter(|letter| is_japanese(*letter)).count();
    // In Latin-1 single bytes beyond ASCII stand among those of ASCII.
    let others = text.iter().filter(|byte| !byte.is_ascii()).count();
    (!has_errors && 4 * letters > others).then_some(encoding_rs::SHIFT_JIS)
}

/// The text of a file as UTF-8.
pub(crate) fn decoded(
    file: &Input,
    encoding: &'static Encoding,
) -> Result<impl Read + Send + 'static, Fault> {
    let mut encoded = file.another().map_err(Fault::read)?;
    let mut decoder = encoding.new_decoder_with_bom_removal();
    let (mut piece, mut at_end) = (vec![0; PIECE], false);
    Ok(Rows::below(String::new(), move || {
        let mut text = String::new();
        while text.is_empty() && !at_end {
            let count = encoded.read(&mut piece)?;
            at_end = count == 0;
            text.reserve(LONGEST_DECODED);
            let (result, ..) = decoder.decode_to_string(&piece[..count], &mut text, at_end);
            debug_assert_eq!(result, CoderResult::InputEmpty);
        }
        Ok(text)
    }))
}

/// Rows of text that are made one after the other; an empty one is the end.
pub(crate) struct Rows<F> {
    next: F,
    row: Cursor<String>,
}

impl<F: FnMut() -> io::Result<String>> Rows<F> {
    /// Below a first row.
    pub fn below(first: String, next: F) -> Self {
        Self { next, row: Cursor::new(first) }
    }
}

impl<F: FnMut() -> io::Result<String>> Read for Rows<F> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.row.position() == self.row.get_ref().len() as u64 {
            self.row = Cursor::new((self.next)()?);
        }
        self.row.read(buffer)
    }
}

impl From<Fault> for io::Error {
    fn from(fault: Fault) -> Self {
        Self::other(fault)
    }
}
