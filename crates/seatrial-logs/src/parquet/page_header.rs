//! Structures of Thrift's compact protocol, as the header of a Parquet page is one.

use std::collections::BTreeMap;

/// Structures within structures that are followed.
const DEEPEST: u32 = 8;

/// What is needed of a header.
#[derive(Debug, PartialEq)]
pub(super) struct PageHeader {
    /// Bytes of the header itself.
    pub length: usize,
    /// Bytes behind the header.
    pub packed: usize,
    /// Bytes when they are unpacked.
    pub unpacked: usize,
    /// CRC-32 of the bytes behind the header, where the writer gives it.
    pub checksum: Option<u32>,
    pub kind: PageKind,
}

#[derive(Debug, PartialEq)]
pub(super) enum PageKind {
    Data {
        values: u32,
        encoding: i64,
        definition_encoding: i64,
    },
    /// Version 2: the levels stand before the values and are never packed.
    Data2 {
        values: u32,
        nulls: u32,
        rows: u32,
        encoding: i64,
        definition_length: u32,
        repetition_length: u32,
        is_packed: bool,
    },
    Dictionary {
        values: u32,
        encoding: i64,
    },
    Other,
}

impl PageHeader {
    /// The header at the start of these bytes; `None` where it is none or goes on behind them.
    pub fn read(bytes: &[u8]) -> Option<Self> {
        let thrift = Thrift::walked(bytes)?;
        let number = |structure: i64, field: i64| thrift.numbers.get(&(structure, field)).copied();
        let count = |structure, field| u32::try_from(number(structure, field)?).ok();
        let kind = match number(0, 1)? {
            0 => PageKind::Data {
                values: count(5, 1)?,
                encoding: number(5, 2)?,
                definition_encoding: number(5, 3)?,
            },
            2 => PageKind::Dictionary { values: count(7, 1)?, encoding: number(7, 2)? },
            3 => PageKind::Data2 {
                values: count(8, 1)?,
                nulls: count(8, 2)?,
                rows: count(8, 3)?,
                encoding: number(8, 4)?,
                definition_length: count(8, 5)?,
                repetition_length: count(8, 6)?,
                is_packed: number(8, 7) != Some(0),
            },
            _ => PageKind::Other,
        };
        let size = |field| usize::try_from(number(0, field)?).ok();
        Some(Self {
            length: thrift.at,
            packed: size(3)?,
            unpacked: size(2)?,
            checksum: number(0, 4).map(|sum| sum as u32),
            kind,
        })
    }
}

/// Are these bytes a structure, none of whose lists and texts is longer than what is left of them?
pub(super) fn is_structure(bytes: &[u8]) -> bool {
    Thrift::walked(bytes).is_some()
}

/// A reader of structures. It keeps their whole numbers and truth values, and passes over the rest.
struct Thrift<'a> {
    bytes: &'a [u8],
    at: usize,
    /// By the structure's field in the header (0: the header itself) and its own field.
    numbers: BTreeMap<(i64, i64), i64>,
}

impl<'a> Thrift<'a> {
    /// At the end of the structure that these bytes begin with.
    fn walked(bytes: &'a [u8]) -> Option<Self> {
        let mut thrift = Self { bytes, at: 0, numbers: BTreeMap::new() };
        thrift.structure(0, 0)?;
        Some(thrift)
    }

    fn byte(&mut self) -> Option<u8> {
        let byte = *self.bytes.get(self.at)?;
        self.at += 1;
        Some(byte)
    }

    fn skip(&mut self, count: u64) -> Option<()> {
        self.at = self.at.checked_add(usize::try_from(count).ok()?)?;
        (self.at <= self.bytes.len()).then_some(())
    }

    /// Seven bits a byte, the lowest first.
    fn unsigned(&mut self) -> Option<u64> {
        let mut value = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            value |= u64::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Some(value);
            }
        }
        None
    }

    /// 0, -1, 1, -2, ... as 0, 1, 2, 3, ...
    fn signed(&mut self) -> Option<i64> {
        let value = self.unsigned()?;
        Some((value >> 1) as i64 ^ -((value & 1) as i64))
    }

    /// Fields of the header's own field `structure`; those of deeper ones are passed over.
    fn structure(&mut self, structure: i64, depth: u32) -> Option<()> {
        let mut field = 0_i64;
        loop {
            let head = self.byte()?;
            let kind = head & 0xf;
            if kind == 0 {
                return Some(());
            }
            field = match head >> 4 {
                0 => self.signed()?,
                step => field.checked_add(step.into())?,
            };
            let number = match kind {
                1 => Some(1),
                2 => Some(0),
                4..=6 => Some(self.signed()?),
                12 if depth == 0 => {
                    self.structure(field, 1)?;
                    None
                }
                _ => {
                    self.pass_over(kind, depth)?;
                    None
                }
            };
            if let Some(number) = number.filter(|_| depth < 2) {
                self.numbers.insert((structure, field), number);
            }
        }
    }

    fn pass_over(&mut self, kind: u8, depth: u32) -> Option<()> {
        match kind {
            1..=3 => self.skip(1),
            4..=6 => self.signed().map(drop),
            7 => self.skip(8),
            8 => {
                let length = self.unsigned()?;
                self.skip(length)
            }
            9 | 10 => {
                let head = self.byte()?;
                let count = match head >> 4 {
                    15 => self.unsigned()?,
                    count => count.into(),
                };
                (0..count).try_for_each(|_| self.pass_over(head & 0xf, depth))
            }
            12 if depth < DEEPEST => self.structure(-1, depth.max(1) + 1),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of a file that the library wrote: a page of three values with their least and greatest.
    #[test]
    fn exact_a_header_is_read_to_its_end() {
        let statistics = [0x18, 2, b'a', b'b', 0x18, 1, b'c', 0x16, 0, 0];
        let header = [
            &[0x15, 0, 0x15, 48, 0x15, 52, 0x2c, 0x15, 6, 0x15, 0, 0x15, 6, 0x15, 6][..],
            &[0x1c],
            &statistics,
            &[0, 0],
        ]
        .concat();
        let expected = PageHeader {
            length: header.len(),
            packed: 26,
            unpacked: 24,
            checksum: None,
            kind: PageKind::Data { values: 3, encoding: 0, definition_encoding: 3 },
        };
        assert_eq!(PageHeader::read(&[&header[..], b"behind"].concat()), Some(expected));
        for length in 0..header.len() {
            assert_eq!(PageHeader::read(&header[..length]), None, "{length}");
        }
    }

    /// As pyarrow writes it with `write_page_checksum`: field 4 of the header.
    #[test]
    fn exact_the_checksum_of_a_page_is_read() {
        let header = [
            0x15, 0, 0x15, 48, 0x15, 52, 0x15, 0x9, 0x1c, 0x15, 6, 0x15, 0, 0x15, 6, 0x15, 6, 0, 0,
        ];
        let found = PageHeader::read(&header).unwrap();
        assert_eq!(found.checksum, Some(-5_i32 as u32));
        assert_eq!(found.packed, 26);
    }

    #[test]
    fn io_lengths_of_a_header_are_not_trusted() {
        let long_text = [0x18, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 1, 0];
        let long_list = [0x19, 0xf3, 0xff, 0xff, 0xff, 0xff, 0x7f, 0];
        let deep = [0x1c; 100_000];
        for bytes in [&long_text[..], &long_list, &deep, &[0x05, 0xff]] {
            assert_eq!(PageHeader::read(bytes), None);
            assert!(!is_structure(bytes));
        }
    }
}
