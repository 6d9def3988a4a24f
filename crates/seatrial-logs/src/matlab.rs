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
use crate::number::Primitive;

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
    let (names, columns) = of_one_length(arrays.columns)?;
    let mut row = 0;
    Ok(Rows::below(names, move || {
        let cell = |column: &Vec<f64>| {
            let number = column.get(row).filter(|number| number.is_finite());
            number.map_or_else(String::new, f64::to_string)
        };
        if row >= columns[0].len() {
            return Ok(String::new());
        }
        let cells: Vec<String> = columns.iter().map(cell).collect();
        row += 1;
        Ok(cells.join("\t") + "\n")
    }))
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
    Fault::Damaged { format: "MATLAB", what: what.into() }
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
        let sizes: Vec<usize> = sizes.chunks(4).map(|size| self.count(size) as usize).collect();
        let (_, own) = self.element(&mut rest)?;
        let name = format!("{outer}{}", String::from_utf8_lossy(own));
        let rows = *sizes.first()?;
        let columns = sizes[1..].iter().try_fold(1_usize, |all, size| all.checked_mul(*size))?;
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
        let kind = match kind {
            1 => Primitive::I8,
            2 => Primitive::U8,
            3 => Primitive::I16,
            4 => Primitive::U16,
            5 => Primitive::I32,
            6 => Primitive::U32,
            7 => Primitive::F32,
            9 => Primitive::F64,
            12 => Primitive::I64,
            13 => Primitive::U64,
            _ => return None,
        };
        let count = data.len() / kind.width();
        self.left = self.left.checked_sub(count as u64)?;
        let mut numbers = vec![0.0; count];
        kind.read_all(data, !self.is_big_endian, &mut numbers);
        Some(numbers)
    }
}

/// The line of names, and the numbers, of the columns of the length that most have.
fn of_one_length(columns: Vec<(String, Vec<f64>)>) -> Result<(String, Vec<Vec<f64>>), Fault> {
    let mut lengths = BTreeMap::<usize, usize>::new();
    for (_, column) in columns.iter().filter(|(_, column)| column.len() > 1) {
        *lengths.entry(column.len()).or_default() += 1;
    }
    let most = lengths.iter().max_by_key(|(length, count)| (**count, **length));
    let (&length, _) = most.ok_or(Fault::Empty)?;
    let columns = columns.into_iter().filter(|(_, column)| column.len() == length);
    let (names, columns): (Vec<String>, Vec<Vec<f64>>) = columns.unzip();
    Ok((names.join("\t") + "\n", columns))
}
