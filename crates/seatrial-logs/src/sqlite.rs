//! Tables of an SQLite database, read row by row without SQLite, as <https://sqlite.org/fileformat.html> describes the file.
//!
//! No SQL, no indices, no write-ahead log beside the file. Nothing in the file is trusted: pages are looked at once, depths and lengths
//! are bounded.

use std::io::{self, Read, Seek, SeekFrom};

use crate::input::Input;

/// The head of the file, before the tree of the first page.
const HEAD: usize = 100;
/// Levels of a tree; a real one has six at most.
const DEEPEST: usize = 20;
/// Bytes of a definition of a table that are read.
const LONGEST_DEFINITION: usize = 1 << 16;

/// Why a database is not read, or no further.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Broken {
    #[error("{0}")]
    Io(#[from] io::Error),
    #[error("page {page} is damaged: {what}")]
    Page { page: u32, what: &'static str },
    #[error("{0}")]
    NotRead(&'static str),
}

/// A database.
pub(crate) struct Database {
    file: Input,
    /// Bytes of a page, and of those that are used.
    page: usize,
    usable: usize,
    pages: u64,
}

/// A table: where its tree begins, and the names of its columns in the order of its records.
pub(crate) struct Table {
    root: u32,
    columns: Vec<String>,
    /// The column that is the number of the row, and stands in no record.
    row_number: Option<usize>,
}

/// A way through a table, in the order of the row numbers.
pub(crate) struct Scan {
    /// Pages from the root on, each with the place of the next cell.
    open: Vec<(Page, usize)>,
    seen: u64,
}

/// A row.
pub(crate) struct Row {
    /// Its number.
    pub number: i64,
    /// The beginning of its record.
    record: Vec<u8>,
}

/// A value of a row. Of one behind the part of the record that was read nothing is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Value<'a> {
    Integer(i64),
    Text(&'a [u8]),
    Blob(&'a [u8]),
    Unread,
    Other,
}

struct Page {
    number: u32,
    bytes: Vec<u8>,
}

impl Database {
    pub fn open(mut file: Input) -> Result<Self, Broken> {
        let mut head = [0; HEAD];
        file.rewind()?;
        file.read_exact(&mut head)?;
        let page = match u16::from_be_bytes([head[16], head[17]]) {
            1 => 1 << 16,
            size => usize::from(size),
        };
        let usable = page.saturating_sub(head[20].into());
        if !page.is_power_of_two() || page < 512 || usable < 480 {
            return Err(Broken::NotRead("its pages have a size that cannot be"));
        }
        if head[56..60] != [0, 0, 0, 1] {
            return Err(Broken::NotRead("its texts are not in UTF-8"));
        }
        let pages = file.length()?.div_ceil(page as u64);
        Ok(Self {
            file,
            page,
            usable,
            pages,
        })
    }

    /// The table of this name; `None` where there is none, or it is no plain one.
    pub fn table(&mut self, name: &str) -> Result<Option<Table>, Broken> {
        let mut schema = self.scan(1)?;
        let mut found = None;
        while let Some(row) = self.next(&mut schema, LONGEST_DEFINITION)? {
            let values = row.values();
            let &[
                Value::Text(kind),
                Value::Text(own),
                _,
                Value::Integer(root),
                Value::Text(sql),
            ] = &values[..]
            else {
                continue;
            };
            if own == name.as_bytes() && kind == b"table" {
                let sql = String::from_utf8_lossy(sql);
                found = Table::of(root, &sql);
            }
        }
        Ok(found)
    }

    /// The rows of a table.
    pub fn rows(&mut self, table: &Table) -> Result<Scan, Broken> {
        self.scan(table.root)
    }

    fn scan(&mut self, root: u32) -> Result<Scan, Broken> {
        let mut scan = Scan {
            open: Vec::new(),
            seen: 0,
        };
        self.descend(&mut scan, root)?;
        Ok(scan)
    }

    fn descend(&mut self, scan: &mut Scan, number: u32) -> Result<(), Broken> {
        scan.seen += 1;
        if scan.seen > self.pages || scan.open.len() == DEEPEST {
            return Err(damaged(number, "its tree leads back to itself"));
        }
        let page = self.read(number)?;
        scan.open.push((page, 0));
        Ok(())
    }

    fn read(&mut self, number: u32) -> Result<Page, Broken> {
        if number == 0 {
            return Err(damaged(number, "there is no such page"));
        }
        let mut bytes = vec![0; self.page];
        let at = u64::from(number - 1) * self.page as u64;
        self.file.seek(SeekFrom::Start(at))?;
        match self.file.read_exact(&mut bytes) {
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => {
                Err(damaged(number, "the file ends before it"))
            }
            other => other.map(|()| Page { number, bytes }).map_err(Broken::Io),
        }
    }

    /// The next row, with at most so many bytes of its record.
    pub fn next(&mut self, scan: &mut Scan, most: usize) -> Result<Option<Row>, Broken> {
        const INNER: u8 = 0x05;
        const LEAF: u8 = 0x0d;
        while let Some((page, next)) = scan.open.last_mut() {
            let (kind, cells) = page.head()?;
            let at = *next;
            *next += 1;
            match kind {
                LEAF if at < cells => {
                    let cell = page.cell(at, 8)?;
                    let (page, cell) = (page.number, cell.to_vec());
                    return self.row(page, &cell, most).map(Some);
                }
                INNER if at < cells => {
                    let child = page.cell(at, 12)?.first_chunk().copied();
                    let child = child.ok_or(damaged(page.number, "a cell is cut off"))?;
                    self.descend(scan, u32::from_be_bytes(child))?;
                }
                INNER if at == cells => {
                    let child = page.right_most();
                    self.descend(scan, child)?;
                }
                LEAF | INNER => {
                    scan.open.pop();
                }
                _ => return Err(damaged(page.number, "it belongs to no table")),
            }
        }
        Ok(None)
    }

    /// A row from its cell: the record's length, the row's number, and the record, of which a long one goes on elsewhere.
    fn row(&mut self, page: u32, cell: &[u8], most: usize) -> Result<Row, Broken> {
        let cut = || damaged(page, "a row is cut off");
        let mut rest = cell;
        let length = varint(&mut rest).ok_or_else(cut)?;
        let number = varint(&mut rest).ok_or_else(cut)? as i64;
        let own = self.own_part(length) as usize;
        let mut record = rest.get(..own).ok_or_else(cut)?.to_vec();
        let wanted = length.min(most as u64) as usize;
        if length > own as u64 {
            let mut next = rest.get(own..).and_then(<[u8]>::first_chunk).copied();
            while record.len() < wanted {
                let number = next.map(u32::from_be_bytes).ok_or_else(cut)?;
                let part = self.read(number)?;
                next = part.bytes.first_chunk().copied();
                record.extend_from_slice(&part.bytes[4..self.usable]);
            }
        }
        record.truncate(wanted);
        Ok(Row { number, record })
    }

    /// How many bytes of a record of this length stand in its cell.
    fn own_part(&self, length: u64) -> u64 {
        let usable = self.usable as u64;
        let (most, least) = (usable - 35, (usable - 12) * 32 / 255 - 23);
        if length <= most {
            return length;
        }
        match least + (length - least) % (usable - 4) {
            part if part <= most => part,
            _ => least,
        }
    }
}

impl Page {
    /// Where the head of the tree stands.
    fn base(&self) -> usize {
        if self.number == 1 { HEAD } else { 0 }
    }

    /// The kind of the page and the number of its cells.
    fn head(&self) -> Result<(u8, usize), Broken> {
        let head = self.bytes.get(self.base()..).unwrap_or_default();
        match head {
            [kind, _, _, high, low, ..] => Ok((*kind, u16::from_be_bytes([*high, *low]).into())),
            _ => Err(damaged(self.number, "it is empty")),
        }
    }

    fn right_most(&self) -> u32 {
        let at = self.base() + 8;
        let bytes = self.bytes.get(at..).and_then(<[u8]>::first_chunk);
        bytes.map_or(0, |bytes| u32::from_be_bytes(*bytes))
    }

    /// The bytes from a cell on; `head` is the length of the page's own head.
    fn cell(&self, at: usize, head: usize) -> Result<&[u8], Broken> {
        let pointer = self.bytes.get(self.base() + head + 2 * at..);
        let pointer = pointer.and_then(<[u8]>::first_chunk).copied();
        pointer
            .and_then(|pointer| self.bytes.get(usize::from(u16::from_be_bytes(pointer))..))
            .ok_or(damaged(self.number, "a cell lies outside"))
    }
}

impl Row {
    /// The values of its record.
    pub fn values(&self) -> Vec<Value<'_>> {
        let mut rest = self.record.as_slice();
        let Some(head) = varint(&mut rest).and_then(|head| usize::try_from(head).ok()) else {
            return Vec::new();
        };
        let used = self.record.len() - rest.len();
        let mut kinds = self.record.get(used..head).unwrap_or_default();
        let mut body = self.record.get(head..).unwrap_or_default();
        let mut values = Vec::new();
        while let Some(kind) = varint(&mut kinds) {
            let length = match kind {
                1..=4 => kind,
                5 => 6,
                6 | 7 => 8,
                12.. => (kind - 12) / 2,
                _ => 0,
            };
            let part = usize::try_from(length)
                .ok()
                .and_then(|length| body.split_at_checked(length));
            let Some((bytes, behind)) = part else {
                body = &[];
                values.push(Value::Unread);
                continue;
            };
            body = behind;
            values.push(match kind {
                1..=6 => Value::Integer(integer(bytes)),
                8 => Value::Integer(0),
                9 => Value::Integer(1),
                12.. if kind % 2 == 0 => Value::Blob(bytes),
                12.. => Value::Text(bytes),
                _ => Value::Other,
            });
        }
        values
    }
}

impl Table {
    /// From the statement that made it: names of columns are all that is taken of it.
    fn of(root: i64, sql: &str) -> Option<Self> {
        let upper = sql.to_ascii_uppercase();
        let (open, close) = (sql.find('(')?, sql.rfind(')')?);
        if upper.starts_with("CREATE VIRTUAL") || upper.get(close..)?.contains("WITHOUT ROWID") {
            return None;
        }
        let parts = parts(sql.get(open + 1..close)?);
        let mut table = Self {
            root: u32::try_from(root).ok()?,
            columns: Vec::new(),
            row_number: None,
        };
        for part in parts {
            let words: Vec<String> = part
                .split_whitespace()
                .map(str::to_ascii_uppercase)
                .collect();
            let first = words.first()?;
            let constraints = ["PRIMARY", "UNIQUE", "CHECK", "FOREIGN", "CONSTRAINT"];
            if constraints.contains(&first.as_str()) {
                continue;
            }
            // A computed column stands in no record, or not where it is named.
            if words.iter().any(|word| word == "AS" || word == "GENERATED") {
                return None;
            }
            if words
                .get(1..4)
                .is_some_and(|of| of == ["INTEGER", "PRIMARY", "KEY"])
            {
                table.row_number = Some(table.columns.len());
            }
            let name = part.split_whitespace().next()?;
            let quotes = ['"', '`', '[', ']', '\''];
            table.columns.push(name.trim_matches(quotes).to_owned());
        }
        Some(table)
    }

    /// The values of a row of this table by the names of their columns.
    pub fn values<'a>(&'a self, row: &'a Row) -> impl Fn(&str) -> Value<'a> {
        let values = row.values();
        move |column| {
            let at = self.columns.iter().position(|own| own == column);
            match at {
                Some(at) if self.row_number == Some(at) => Value::Integer(row.number),
                Some(at) => values.get(at).copied().unwrap_or(Value::Other),
                None => Value::Other,
            }
        }
    }
}

/// What stands between the commas that no brackets enclose.
fn parts(text: &str) -> Vec<&str> {
    let (mut parts, mut from, mut depth) = (Vec::new(), 0, 0_i32);
    for (at, char) in text.char_indices() {
        match char {
            '(' => depth += 1,
            ')' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(&text[from..at]);
                from = at + 1;
            }
            _ => {}
        }
    }
    parts.push(&text[from..]);
    parts
}

/// Seven bits a byte, the highest first, while the eighth is set; all eight of a ninth byte.
fn varint(rest: &mut &[u8]) -> Option<u64> {
    let mut value = 0_u64;
    for count in 1..=9 {
        let (&byte, behind) = rest.split_first()?;
        *rest = behind;
        if count == 9 {
            return Some(value << 8 | u64::from(byte));
        }
        value = value << 7 | u64::from(byte & 0x7f);
        if byte < 0x80 {
            break;
        }
    }
    Some(value)
}

/// Of two's complement, the highest byte first.
fn integer(bytes: &[u8]) -> i64 {
    let negative = bytes.first().is_some_and(|byte| *byte >= 0x80);
    let start = if negative { -1 } else { 0 };
    bytes
        .iter()
        .fold(start, |value: i64, byte| value << 8 | i64::from(*byte))
}

fn damaged(page: u32, what: &'static str) -> Broken {
    Broken::Page { page, what }
}
