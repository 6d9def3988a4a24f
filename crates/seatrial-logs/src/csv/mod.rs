//! Delimited text: comma, semicolon, tab or blanks; decimal point or comma; comments; quotes.

mod header;
mod number;

use std::borrow::Cow;
use std::cell::Cell as Count;
use std::io::{self, Read};

use csv_core::{ReadRecordResult, ReaderBuilder};
use sha2::{Digest, Sha256};

use crate::Quantity;
use crate::clock::{instant, time_of_day};
use crate::error::{Fault, Place, clipped};
use crate::format_name::Format;
use crate::input::Input;
use crate::table::{Cell, Table, hexadecimal};
use header::{Dialect, Header, blank_garbage, is_control, join_quoted_names};
use number::is_no_value;
pub(crate) use number::number;

/// Bytes read at once; the delimiter is found in the first of these.
const BUFFER: usize = 1 << 16;
/// The longest record.
const LONGEST_LINE: usize = 1 << 20;
/// Cells without a value, in capitals or not.
const NO_VALUES: &str = "NA N/A #N/A null none - -- --- #NV #DIV/0! k.A. 欠測";
/// The most columns.
const MOST_COLUMNS: usize = 4096;

/// How a line begins that says of the text what is damaged of what it was made of. A program that exports samples of something damaged
/// writes one above the names of columns.
pub const DAMAGE_MARK: &str = "# damaged: ";

/// A text log, read record by record.
pub(crate) struct Text {
    input: Box<dyn Read + Send>,
    format: Format,
    /// What the text was made of, and what should be known of that.
    made_of: Option<Input>,
    remarks: Vec<String>,
    buffer: Vec<u8>,
    unread: std::ops::Range<usize>,
    bytes_read: u64,
    hash: Sha256,
    parser: csv_core::Reader,
    dialect: Dialect,
    last_byte: u8,
    record: Record,
    columns: Vec<String>,
    selected: Vec<usize>,
    at_end: bool,
    incomplete_line: Option<u64>,
    /// What the text says is damaged of what it was made of.
    damage: Option<String>,
    /// Cells that hold what instruments write for no value.
    no_values: Count<u64>,
    /// The last number of each selected column.
    last: Vec<f64>,
    /// Rows that are the names of columns again, as where logs were put behind each other.
    repeated_names: u64,
}

/// The bytes of one record and where its cells end.
struct Record {
    bytes: Vec<u8>,
    ends: Vec<usize>,
    cells: usize,
}

impl Record {
    fn cell(&self, index: usize) -> &[u8] {
        let from = if index == 0 { 0 } else { self.ends[index - 1] };
        self.bytes[from..self.ends[index]].trim_ascii()
    }

    /// Blanks are one delimiter however many they are.
    fn drop_empty_cells(&mut self) {
        let mut kept = 0;
        let mut from = 0;
        for i in 0..self.cells {
            let end = self.ends[i];
            if end > from {
                self.ends[kept] = end;
                kept += 1;
            }
            from = end;
        }
        self.cells = kept;
    }

    /// A delimiter at the end of the line makes no cell.
    fn drop_empty_cells_after(&mut self, expected: usize) {
        while self.cells > expected && self.cell(self.cells - 1).is_empty() {
            self.cells -= 1;
        }
    }

    fn is_blank(&self) -> bool {
        (0..self.cells).all(|i| self.cell(i).is_empty())
    }
}

impl Text {
    /// Reads the header.
    pub fn open(input: impl Read + Send + 'static) -> Result<Self, Fault> {
        let mut text = Self {
            input: Box::new(input),
            format: Format::Csv,
            made_of: None,
            remarks: Vec::new(),
            buffer: vec![0; BUFFER],
            unread: 0..0,
            bytes_read: 0,
            hash: Sha256::new(),
            parser: csv_core::Reader::new(),
            dialect: Dialect { delimiter: b',', decimal_comma: false },
            last_byte: b'\n',
            record: Record { bytes: vec![0; LONGEST_LINE], ends: vec![0; MOST_COLUMNS], cells: 0 },
            columns: Vec::new(),
            selected: Vec::new(),
            at_end: false,
            incomplete_line: None,
            damage: None,
            no_values: Count::new(0),
            last: Vec::new(),
            repeated_names: 0,
        };
        while !text.at_end && text.unread.end < BUFFER {
            text.fill()?;
        }
        let start = &mut text.buffer[text.unread.clone()];
        blank_garbage(start);
        join_quoted_names(start);
        check_is_text(start)?;
        let header = Header::find(start).ok_or(Fault::Empty)?;
        text.damage = stated_damage(start);
        text.dialect = header.dialect;
        text.parser = ReaderBuilder::new()
            .delimiter(text.dialect.delimiter)
            .comment(Some(header.comment))
            .build();
        text.blanks_for_tabs(text.unread.clone());
        match header.in_comment {
            Some(columns) => text.columns = columns,
            None => text.columns = text.read_names(&header)?,
        }
        Ok(text)
    }

    /// [`open`](Self::open) of a text that was made of a file, with remarks on how.
    #[cfg(feature = "containers")]
    pub fn made_of(
        file: Input,
        format: Format,
        text: impl Read + Send + 'static,
        remarks: Vec<String>,
    ) -> Result<Self, Fault> {
        Ok(Self { format, made_of: Some(file), remarks, ..Self::open(text)? })
    }

    /// Reads as far as the row of names, and the rows below it that are no samples.
    fn read_names(&mut self, header: &Header) -> Result<Vec<String>, Fault> {
        let mut line = self.read_record()?.ok_or(Fault::Empty)?;
        while line < header.line {
            line = self.read_record()?.ok_or(Fault::Empty)?;
        }
        let mut columns: Vec<String> =
            (0..self.record.cells).map(|i| decoded(self.record.cell(i)).into_owned()).collect();
        while columns.last().is_some_and(String::is_empty) {
            columns.pop();
        }
        let is_number = |name: &&String| name.parse::<f64>().is_ok();
        let numbers = columns.iter().filter(is_number).count();
        let are_most = numbers >= header::LEAST_COLUMNS && 2 * numbers > columns.len();
        if are_most || numbers == columns.len() {
            return Err(Fault::NoHeader { line, found: clipped(&columns.join(",")) });
        }
        for _ in 0..header.below {
            self.read_record()?;
        }
        Ok(header.complete(columns))
    }

    /// Reads more behind the unread bytes.
    fn fill(&mut self) -> Result<(), Fault> {
        if self.unread.is_empty() {
            self.unread = 0..0;
        }
        let from = self.unread.end;
        let count = loop {
            match self.input.read(&mut self.buffer[from..]) {
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                result => break result.map_err(Fault::read)?,
            }
        };
        self.hash.update(&self.buffer[from..from + count]);
        self.unread.end += count;
        self.at_end = count == 0;
        Ok(())
    }

    fn blanks_for_tabs(&mut self, bytes: std::ops::Range<usize>) {
        if self.dialect.delimiter == b' ' {
            for byte in self.buffer[bytes].iter_mut().filter(|byte| **byte == b'\t') {
                *byte = b' ';
            }
        }
    }

    /// The next record that is not blank, and its line.
    fn read_record(&mut self) -> Result<Option<u64>, Fault> {
        loop {
            let (mut length, mut ends) = (0, 0);
            loop {
                if self.unread.is_empty() && !self.at_end {
                    self.fill()?;
                    self.blanks_for_tabs(self.unread.clone());
                }
                let (result, read, written, ended) = self.parser.read_record(
                    &self.buffer[self.unread.clone()],
                    &mut self.record.bytes[length..],
                    &mut self.record.ends[ends..],
                );
                if read > 0 {
                    self.last_byte = self.buffer[self.unread.start + read - 1];
                }
                self.unread.start += read;
                self.bytes_read += read as u64;
                length += written;
                ends += ended;
                match result {
                    ReadRecordResult::InputEmpty => {}
                    ReadRecordResult::Record => break,
                    ReadRecordResult::End => return Ok(None),
                    ReadRecordResult::OutputFull => {
                        return Err(Fault::LineTooLong { line: self.line(), limit: LONGEST_LINE });
                    }
                    ReadRecordResult::OutputEndsFull => {
                        return Err(Fault::TooManyColumns {
                            line: self.line(),
                            limit: MOST_COLUMNS,
                        });
                    }
                }
            }
            self.record.cells = ends;
            if self.dialect.delimiter == b' ' {
                self.record.drop_empty_cells();
            }
            if !self.record.is_blank() {
                return Ok(Some(self.line()));
            }
        }
    }

    /// The line of the record just read: the parser has already counted its line feed.
    fn line(&self) -> u64 {
        self.parser.line() - u64::from(self.last_byte == b'\n' && self.parser.line() > 1)
    }

    /// Is the record the names of columns, which may have got a unit?
    fn repeats_the_names(&self) -> bool {
        let is_name = |(index, name): (usize, &String)| {
            let cell = self.record.cell(index);
            !cell.is_empty() && name.as_bytes().starts_with(cell)
        };
        let first = self.record.bytes.first().copied().unwrap_or_default();
        !matches!(first, b'0'..=b'9' | b'-' | b'+' | b'.')
            && self.record.cells == self.columns.len()
            && self.columns.iter().enumerate().all(is_name)
    }

    /// The value of a cell whose column last held a number: a coordinate may pass what instruments write for no value.
    fn parsed(&self, bytes: &[u8], last: f64) -> Cell {
        if bytes.is_empty() {
            return Cell::Missing;
        }
        let text: &str = &decoded(bytes);
        let is_none = |word: &str| word.eq_ignore_ascii_case(text);
        match number(text, self.dialect.decimal_comma) {
            Some(number) if is_no_value(number) && !is_near(number, last) => {
                self.no_values.set(self.no_values.get() + 1);
                Cell::Missing
            }
            Some(number) => Cell::Number(number),
            None if NO_VALUES.split(' ').any(is_none) => Cell::Missing,
            None => match (instant(text), time_of_day(text)) {
                (Some(instant), _) => Cell::Instant(instant),
                (None, Some(seconds)) => Cell::OfDay(seconds),
                (None, None) => Cell::Text(text.into()),
            },
        }
    }
}

impl Table for Text {
    fn format(&self) -> Format {
        self.format.clone()
    }

    fn columns(&self) -> &[String] {
        &self.columns
    }

    fn select(&mut self, columns: &[(Quantity, usize)]) {
        self.selected = columns.iter().map(|(_, column)| *column).collect();
        self.last = vec![f64::NAN; columns.len()];
    }

    fn leave_out(&mut self, position: usize) {
        self.selected.remove(position);
        self.last.remove(position);
    }

    fn next_row(&mut self, cells: &mut Vec<Cell>) -> Result<Option<Place>, Fault> {
        let expected = self.columns.len();
        let line = loop {
            let Some(line) = self.read_record()? else {
                return Ok(None);
            };
            self.record.drop_empty_cells_after(expected);
            if !self.repeats_the_names() {
                break line;
            }
            self.repeated_names += 1;
        };
        if self.record.cells != expected {
            let is_cut_off = self.record.cells < expected && self.is_last_and_unterminated()?;
            if is_cut_off {
                self.incomplete_line = Some(line);
                return Ok(None);
            }
            return Err(Fault::Ragged {
                place: Place::Line(line),
                found: self.record.cells,
                expected,
            });
        }
        cells.clear();
        cells.extend(
            self.selected
                .iter()
                .zip(&self.last)
                .map(|(&index, &last)| self.parsed(self.record.cell(index), last)),
        );
        for (last, cell) in self.last.iter_mut().zip(cells) {
            if let Cell::Number(number) = cell {
                *last = *number;
            }
        }
        Ok(Some(Place::Line(line)))
    }

    fn bytes_read(&self) -> u64 {
        self.bytes_read
    }

    fn sha256(&mut self) -> Result<String, Fault> {
        if let Some(file) = &mut self.made_of {
            return file.sha256().map_err(Fault::read);
        }
        while !self.at_end {
            self.unread = 0..0;
            self.fill()?;
        }
        Ok(hexadecimal(&self.hash.clone().finalize()))
    }

    fn warnings(&self) -> Vec<String> {
        let cut_off = self
            .incomplete_line
            .map(|line| format!("line {line}, the last, is cut off and was left out"));
        let no_values = self.no_values.get();
        let none = (no_values > 0).then(|| {
            format!("-999 or -9999 was taken for a value that is missing, {no_values} times")
        });
        let repeated = self.repeated_names;
        let repeated = (repeated > 0)
            .then(|| format!("{repeated} rows repeat the names of the columns and are left out"));
        let damage = self.damage.as_ref();
        let damage = damage.map(|damage| format!("it was exported from what is damaged: {damage}"));
        let own = damage.into_iter().chain(cut_off).chain(none).chain(repeated);
        self.remarks.iter().cloned().chain(own).collect()
    }

    fn is_damaged(&self) -> bool {
        self.damage.is_some()
    }
}

/// What a line of the comment above the names of columns says is damaged.
fn stated_damage(start: &[u8]) -> Option<String> {
    let lines = start.split(|&byte| byte == b'\n');
    let mut comments = lines.take_while(|line| line.starts_with(b"#"));
    let damage = comments.find_map(|line| line.strip_prefix(DAMAGE_MARK.as_bytes()))?;
    Some(clipped(decoded(damage.trim_ascii()).as_ref()))
}

impl Text {
    fn is_last_and_unterminated(&mut self) -> Result<bool, Fault> {
        if self.unread.is_empty() && !self.at_end {
            self.fill()?;
            self.blanks_for_tabs(self.unread.clone());
        }
        Ok(self.unread.is_empty() && self.at_end && !matches!(self.last_byte, b'\n' | b'\r'))
    }
}

/// Does a number go on from the one before, within a twentieth of it?
fn is_near(number: f64, last: f64) -> bool {
    (number - last).abs() < 0.05 * number.abs()
}

/// Latin-1 where it is not UTF-8: `°` of older instruments.
fn decoded(bytes: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.into(),
        Err(_) => bytes.iter().map(|&byte| char::from(byte)).collect(),
    }
}

/// No control characters, and nothing outside UTF-8 but single letters and signs of Latin-1.
fn check_is_text(start: &[u8]) -> Result<(), Fault> {
    let is_wide = [[0xff, 0xfe], [0xfe, 0xff]].iter().any(|mark| start.starts_with(mark));
    if is_wide || (start.len() > 3 && start[0] != 0 && start[1] == 0 && start[3] == 0) {
        return Err(Fault::Utf16);
    }
    let not_text = |offset: usize| Fault::NotText { offset, found: start[offset] };
    // The instruments' 0x00 after a power loss is a fault of its row; in the first line it is not text.
    let first_line = start.iter().position(|&byte| byte == b'\n').unwrap_or(start.len());
    if let Some(offset) = start[..first_line].iter().position(is_control) {
        return Err(not_text(offset));
    }
    let mut checked = 0;
    while let Err(error) = std::str::from_utf8(&start[checked..first_line]) {
        let offset = checked + error.valid_up_to();
        // A letter of Latin-1 stands among those of ASCII; other encodings have several in a row, or bytes that Latin-1 has not.
        let is_ascii = |at: usize| start.get(at).is_none_or(u8::is_ascii);
        let is_alone = is_ascii(offset + 1) && (offset == 0 || is_ascii(offset - 1));
        let is_latin = start[offset] >= 0xa0 && is_alone;
        // A sequence cut by the end of the buffer is no error.
        if !is_latin && error.error_len().is_some() {
            return Err(Fault::OtherEncoding);
        }
        checked = offset + 1;
    }
    Ok(())
}
