//! Arrays of a MATLAB file (`.mat`, version 5 to 7) as a table: those of one length are its columns.
//!
//! ```text
//! element = type (u32), length (u32), data up to a multiple of 8;   short element = type (u16), length (u16), data (4 bytes)
//! matrix  = class, sizes, name, numbers | names of fields, matrices
//! ```

use std::collections::BTreeMap;
use std::io::Read;

use flate2::read::ZlibDecoder;

use crate::as_text::Rows;
use crate::bytes::Bytes;
use crate::error::Fault;
use crate::input::Input;

const HEADER: usize = 128;
/// Numbers that are kept, and those for each byte of the file.
const MOST_NUMBERS: u64 = 1 << 21;
const NUMBERS_FOR_A_BYTE: u64 = 2;
/// An element, unpacked.
const LONGEST_ELEMENT: u64 = 16 << 20;
const LONGEST_FOR_A_BYTE: u64 = 16;
/// Columns, and structures within structures.
const MOST_COLUMNS: usize = 4096;
const DEEPEST: usize = 8;

const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;
const STRUCTURE: u8 = 2;

/// The rows of the arrays of the length that most have.
pub(crate) fn text(file: &mut Input) -> Result<impl Read + Send + 'static, Fault> {
    let mut bytes = Bytes::new(file.another().map_err(Fault::read)?)?;
    let length = bytes.length()?;
    let mut arrays = Arrays {
        columns: Vec::new(),
        is_big_endian: false,
        left: MOST_NUMBERS + NUMBERS_FOR_A_BYTE * length,
    };
    let longest = LONGEST_ELEMENT + LONGEST_FOR_A_BYTE * length;
    let mut head = Vec::new();
    if !bytes.take(HEADER, &mut head)? {
        return Err(damaged("it ends within its header"));
    }
    arrays.is_big_endian = head.ends_with(b"MI");
    loop {
        let mut tag = Vec::new();
        match bytes.take(8, &mut tag)? {
            true => {}
            false if tag.is_empty() => break,
            false => return Err(damaged("an array is not there as a whole")),
        }
        let [kind, length] = [0, 4].map(|at| arrays.count(&tag[at..]));
        let mut element = Vec::new();
        if u64::from(length) > longest || !bytes.take(length as usize, &mut element)? {
            return Err(damaged("an array is not there as a whole"));
        }
        if kind == COMPRESSED {
            let mut unpacked = Vec::new();
            ZlibDecoder::new(&element[..])
                .take(longest)
                .read_to_end(&mut unpacked)
                .map_err(|error| damaged(&error.to_string()))?;
            let found = arrays.element(&mut &unpacked[..]);
            if let Some((MATRIX, matrix)) = found {
                arrays.matrix("", matrix, 0);
            }
        } else if kind == MATRIX {
            arrays.matrix("", &element, 0);
        }
    }
    without_outer(&mut arrays.columns);
    let mut columns = Columns::of(arrays.columns)?;
    Ok(Rows::new(move || Ok(columns.next_row())))
}

/// Takes the name of the structure off that all columns are fields of.
fn without_outer(columns: &mut [(String, Vec<f64>)]) {
    while let Some((outer, _)) = columns.first().and_then(|(name, _)| name.split_once('.')) {
        let outer = format!("{outer}.");
        if !columns.iter().all(|(name, _)| name.starts_with(&outer)) {
            return;
        }
        for (name, _) in columns.iter_mut() {
            name.drain(..outer.len());
        }
    }
}

fn damaged(what: &str) -> Fault {
    Fault::Damaged {
        format: "MATLAB",
        what: what.into(),
    }
}

/// Columns of arrays.
struct Arrays {
    columns: Vec<(String, Vec<f64>)>,
    is_big_endian: bool,
    /// Numbers that may still be kept.
    left: u64,
}

impl Arrays {
    fn count(&self, bytes: &[u8]) -> u32 {
        let bytes = bytes.first_chunk().copied().unwrap_or_default();
        match self.is_big_endian {
            true => u32::from_be_bytes(bytes),
            false => u32::from_le_bytes(bytes),
        }
    }

    /// Type and data of the next element.
    fn element<'a>(&self, rest: &mut &'a [u8]) -> Option<(u32, &'a [u8])> {
        let tag = rest.get(..8)?;
        let kind = self.count(tag);
        let (kind, from, length): (_, usize, usize) = match kind >> 16 {
            0 => (kind, 8, self.count(&tag[4..]) as usize),
            length => (kind & 0xffff, 4, length as usize),
        };
        let data = rest.get(from..from.checked_add(length)?)?;
        let end = (from + length).next_multiple_of(8).min(rest.len());
        *rest = &rest[end..];
        Some((kind, data))
    }

    /// Keeps the columns of a matrix, or of the fields of a structure. What is no number is passed over.
    fn matrix(&mut self, outer: &str, mut rest: &[u8], depth: usize) -> Option<()> {
        let (_, class) = self.element(&mut rest)?;
        let class = self.count(class) as u8;
        let (_, sizes) = self.element(&mut rest)?;
        let sizes: Vec<usize> = sizes
            .chunks(4)
            .map(|size| self.count(size) as usize)
            .collect();
        let (_, own) = self.element(&mut rest)?;
        let name = format!("{outer}{}", String::from_utf8_lossy(own));
        let rows = *sizes.first()?;
        let columns = sizes[1..]
            .iter()
            .try_fold(1_usize, |all, size| all.checked_mul(*size))?;
        if class == STRUCTURE {
            return self.structure(&name, rows.checked_mul(columns)?, rest, depth);
        }
        let (kind, data) = self.element(&mut rest)?;
        let numbers = self.numbers(kind, data)?;
        let (rows, columns) = match rows {
            1 => (columns, 1),
            rows => (rows, columns),
        };
        if rows.checked_mul(columns)? != numbers.len() || rows == 0 {
            return None;
        }
        for (place, column) in numbers.chunks(rows).enumerate() {
            if self.columns.len() == MOST_COLUMNS {
                break;
            }
            let name = match columns {
                1 => name.clone(),
                _ => format!("{name}_{}", place + 1),
            };
            self.columns.push((name, column.to_vec()));
        }
        Some(())
    }

    /// The matrices of the fields, of one structure behind the other.
    fn structure(&mut self, name: &str, count: usize, mut rest: &[u8], depth: usize) -> Option<()> {
        let (_, width) = self.element(&mut rest)?;
        let width = self.count(width) as usize;
        let (_, names) = self.element(&mut rest)?;
        if depth == DEEPEST || width == 0 {
            return None;
        }
        let names: Vec<String> = names.chunks(width).map(crate::bytes::text_of).collect();
        for place in 1..=count {
            for field in &names {
                let (_, matrix) = self.element(&mut rest)?;
                let outer = match count {
                    1 => format!("{name}.{field}"),
                    _ => format!("{name}_{place}.{field}"),
                };
                // Without numbers it is no column.
                let _ = self.matrix(&outer, matrix, depth + 1);
            }
        }
        Some(())
    }

    fn numbers(&mut self, kind: u32, data: &[u8]) -> Option<Vec<f64>> {
        macro_rules! of {
            ($number:ty) => {{
                let (numbers, _) = data.as_chunks();
                self.left = self.left.checked_sub(numbers.len() as u64)?;
                let number = |bytes: &[u8; size_of::<$number>()]| match self.is_big_endian {
                    true => <$number>::from_be_bytes(*bytes) as f64,
                    false => <$number>::from_le_bytes(*bytes) as f64,
                };
                Some(numbers.iter().map(number).collect())
            }};
        }
        match kind {
            1 => of!(i8),
            2 => of!(u8),
            3 => of!(i16),
            4 => of!(u16),
            5 => of!(i32),
            6 => of!(u32),
            7 => of!(f32),
            9 => of!(f64),
            12 => of!(i64),
            13 => of!(u64),
            _ => None,
        }
    }
}

/// Columns of one length as lines of text.
struct Columns {
    names: Option<String>,
    columns: Vec<Vec<f64>>,
    row: usize,
}

impl Columns {
    fn of(columns: Vec<(String, Vec<f64>)>) -> Result<Self, Fault> {
        let mut lengths = BTreeMap::<usize, usize>::new();
        for (_, column) in columns.iter().filter(|(_, column)| column.len() > 1) {
            *lengths.entry(column.len()).or_default() += 1;
        }
        let most = lengths
            .iter()
            .max_by_key(|(length, count)| (**count, **length));
        let Some((&length, _)) = most else {
            return Err(Fault::Empty);
        };
        let columns = columns
            .into_iter()
            .filter(|(_, column)| column.len() == length);
        let (names, columns): (Vec<String>, Vec<Vec<f64>>) = columns.unzip();
        Ok(Self {
            columns,
            row: 0,
            names: Some(names.join("\t") + "\n"),
        })
    }
}

impl Columns {
    fn next_row(&mut self) -> String {
        if let Some(names) = self.names.take() {
            return names;
        }
        let cell = |column: &Vec<f64>| {
            let number = column.get(self.row).filter(|number| number.is_finite());
            number.map_or_else(String::new, f64::to_string)
        };
        if self.row >= self.columns[0].len() {
            return String::new();
        }
        let cells: Vec<String> = self.columns.iter().map(cell).collect();
        self.row += 1;
        cells.join("\t") + "\n"
    }
}
