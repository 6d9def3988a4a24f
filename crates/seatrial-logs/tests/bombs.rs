//! Small files that unpack to much: what a length says is bounded before it is believed.
#![cfg(all(feature = "parquet", feature = "mcap"))]

use std::io::Write;
use std::path::Path;
use std::time::{Duration, Instant};

use seatrial_logs::{ChannelChoice, Fault, open};

use crate::memory::peak_memory_kb;

/// A bomb is refused or read in this time, on a busy machine.
const SOON: Duration = Duration::from_secs(4);
/// What a reader may hold beside twice the log.
pub const MOST_MEMORY_KB: u64 = 64 << 10;

/// Blocks of 128 kB that are 256 MB.
const BLOCKS: u32 = 2048;

/// Samples of a log of these bytes and the fault that ends it.
pub fn read(folder: &Path, bytes: &[u8]) -> (usize, Option<Fault>) {
    let path = folder.join("log");
    std::fs::write(&path, bytes).unwrap();
    let mut choice = ChannelChoice::default();
    choice.drop_invalid = true;
    let begun = Instant::now();
    let (mut samples, mut fault) = (0, None);
    match open(&path, &choice) {
        Ok(mut reader) => {
            for sample in reader.by_ref() {
                match sample {
                    Ok(_) => samples += 1,
                    Err(error) => fault = Some(error.fault),
                }
            }
        }
        Err(error) => fault = Some(error.fault),
    }
    assert!(begun.elapsed() < SOON, "{:?}", begun.elapsed());
    (samples, fault)
}

fn record(opcode: u8, body: &[u8]) -> Vec<u8> {
    [&[opcode], &(body.len() as u64).to_le_bytes()[..], body].concat()
}

/// A chunk of an MCAP file that says it has so many bytes when it is unpacked.
fn mcap_bomb(compression: &str, packed: &[u8], unpacked: u64) -> Vec<u8> {
    let text = |text: &str| [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat();
    let mut chunk = [[0; 16].as_slice(), &unpacked.to_le_bytes(), &[0; 4]].concat();
    chunk.extend(text(compression));
    chunk.extend((packed.len() as u64).to_le_bytes());
    chunk.extend(packed);
    let header = record(1, &[text("ros2"), text("")].concat());
    [b"\x89MCAP0\r\n", &header[..], &record(6, &chunk)].concat()
}

/// Zeros as a frame of Zstandard: blocks of one byte and how often it is repeated, 128 kB each.
fn zstd_zeros(blocks: u32) -> Vec<u8> {
    let mut frame = vec![0x28, 0xb5, 0x2f, 0xfd, 0x00, 0x58];
    for block in 1..=blocks {
        let head = (1 << 17) << 3 | 1 << 1 | u32::from(block == blocks);
        frame.extend(&head.to_le_bytes()[..3]);
        frame.push(0);
    }
    frame
}

/// 256 MB of zeros as a frame of LZ4: a zero, copied in lengths of 255 through each block of 4 MB.
pub fn lz4_zeros() -> Vec<u8> {
    let mut block = vec![0x1f, 0, 1, 0];
    block.extend([255; 16_448]);
    block.extend([0, 0x50, 0, 0, 0, 0, 0]);
    let mut frame = vec![0x04, 0x22, 0x4d, 0x18, 0x60, 0x70, 0x73];
    for _ in 0..64 {
        frame.extend((block.len() as u32).to_le_bytes());
        frame.extend(&block);
    }
    frame.extend([0; 4]);
    frame
}

/// 256 MB of zeros in gzip.
fn gzip_zeros() -> Vec<u8> {
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    for _ in 0..256 {
        packed.write_all(&vec![0; 1 << 20]).unwrap();
    }
    packed.finish().unwrap()
}

/// Thrift's compact protocol: fields of a structure, each with the step from the one before and its type.
mod thrift {
    pub const I32: u8 = 5;
    pub const I64: u8 = 6;

    pub fn varint(mut value: u64) -> Vec<u8> {
        let mut bytes = Vec::new();
        while value > 0x7f {
            bytes.push(value as u8 | 0x80);
            value >>= 7;
        }
        bytes.push(value as u8);
        bytes
    }

    pub fn number(step: u8, kind: u8, value: i64) -> Vec<u8> {
        [&[step << 4 | kind][..], &varint((value << 1 ^ value >> 63) as u64)].concat()
    }

    pub fn text(step: u8, text: &str) -> Vec<u8> {
        [&[step << 4 | 8][..], &varint(text.len() as u64), text.as_bytes()].concat()
    }

    pub fn list(step: u8, kind: u8, elements: &[Vec<u8>]) -> Vec<u8> {
        let count = varint(elements.len() as u64);
        [&[step << 4 | 9, 0xf0 | kind][..], &count, &elements.concat()].concat()
    }

    pub fn structure(fields: &[Vec<u8>]) -> Vec<u8> {
        [&fields.concat()[..], &[0]].concat()
    }

    pub fn field(step: u8, fields: &[Vec<u8>]) -> Vec<u8> {
        [&[step << 4 | 12][..], &structure(fields)].concat()
    }
}

use thrift::{I32, I64, field, list, number, structure, text};

const PLAIN_CODEC: i64 = 0;
const SNAPPY: i64 = 1;
const GZIP: i64 = 2;
const ZSTD: i64 = 6;

/// A page of plain doubles that says it has so many bytes.
fn page(unpacked: i64, values: i64, body: &[u8]) -> Vec<u8> {
    let header = structure(&[
        number(1, I32, 0),
        number(1, I32, unpacked),
        number(1, I32, body.len() as i64),
        field(
            2,
            &[number(1, I32, values), number(1, I32, 0), number(1, I32, 3), number(1, I32, 3)],
        ),
    ]);
    [&header, body].concat()
}

fn dictionary(values: i64, body: &[u8]) -> Vec<u8> {
    let header = structure(&[
        number(1, I32, 2),
        number(1, I32, body.len() as i64),
        number(1, I32, body.len() as i64),
        field(4, &[number(1, I32, values), number(1, I32, 0)]),
    ]);
    [&header, body].concat()
}

/// Groups of rows of three columns, all of the same pages.
fn parquet_bomb(codec: i64, pages: &[u8], groups: usize, rows: i64) -> Vec<u8> {
    const NAMES: [&str; 3] = ["time_s", "heading_rad", "rudder_rad"];
    const DOUBLE: i64 = 5;
    let mut schema = vec![structure(&[text(4, "log"), number(1, I32, 3)])];
    schema.extend(
        NAMES.map(|name| structure(&[number(1, I32, DOUBLE), number(2, I32, 0), text(1, name)])),
    );
    let columns = NAMES.map(|name| {
        let name = [&[name.len() as u8][..], name.as_bytes()].concat();
        let about = [
            number(1, I32, DOUBLE),
            list(1, I32, &[vec![0]]),
            list(1, 8, &[name]),
            number(1, I32, codec),
            number(1, I64, rows),
            number(1, I64, 1000),
            number(1, I64, pages.len() as i64),
            number(2, I64, 4),
        ];
        structure(&[number(2, I64, 4), field(1, &about)])
    });
    let group = structure(&[list(1, 12, &columns), number(1, I64, 1000), number(1, I64, rows)]);
    let footer = structure(&[
        number(1, I32, 1),
        list(1, 12, &schema),
        number(1, I64, rows.saturating_mul(groups as i64)),
        list(1, 12, &vec![group; groups]),
    ]);
    let length = (footer.len() as u32).to_le_bytes();
    [b"PAR1", pages, &footer, &length, b"PAR1"].concat()
}

fn eight_doubles() -> Vec<u8> {
    (0..8).flat_map(|k| f64::from(k).to_le_bytes()).collect()
}

/// One test, because memory is that of the process.
#[test]
fn io_bombs_cost_neither_time_nor_memory() {
    // Libraries panic on some files; the readers catch that. A trace of the stack would cost 100 MB.
    std::panic::set_hook(Box::new(|panic| eprintln!("{panic}")));
    let folder = tempfile::tempdir().unwrap();
    let doubles = eight_doubles();
    let sound = parquet_bomb(PLAIN_CODEC, &page(64, 8, &doubles), 1, 8);
    assert!(matches!(read(folder.path(), &sound), (8, None)));

    let packed_zeros = [gzip_zeros(), zstd_zeros(BLOCKS)];
    let before_kb = peak_memory_kb();
    for bomb in [
        mcap_bomb("zstd", &zstd_zeros(BLOCKS), u64::from(BLOCKS) << 17),
        mcap_bomb("zstd", &zstd_zeros(BLOCKS), u64::MAX),
        mcap_bomb("lz4", &lz4_zeros(), 64 << 22),
        mcap_bomb("lz4", &lz4_zeros(), u64::MAX),
        mcap_bomb("", &[0; 100], u64::MAX),
    ] {
        let (samples, fault) = read(folder.path(), &bomb);
        assert_eq!(samples, 0);
        assert!(matches!(fault, Some(Fault::NothingToRead { .. })), "{fault:?}");
    }

    let [gzip, zstd] = &packed_zeros;
    let length_of_snappy = thrift::varint(1 << 30);
    let repeated = page(1 << 20, 1 << 17, &zstd_zeros(8));
    let most_values = i64::from(i32::MAX);
    let huge_footer = {
        let mut bytes = sound.clone();
        let end = bytes.len() - 8;
        bytes.splice(4..4, vec![0; 3 << 20]);
        let at = end + (3 << 20);
        bytes[at..at + 4].copy_from_slice(&(2_u32 << 20).to_le_bytes());
        bytes
    };
    for (name, bomb) in [
        ("256 MB, as it says", parquet_bomb(ZSTD, &page(256 << 20, 1 << 20, zstd), 1, 1000)),
        ("256 MB, said of gzip", parquet_bomb(GZIP, &page(256 << 20, 1 << 20, gzip), 1, 1000)),
        (
            "2 GB, which are not there",
            parquet_bomb(SNAPPY, &page(most_values, 1, &[0; 9]), 1, 1000),
        ),
        (
            "2 GB of values in a dictionary",
            parquet_bomb(PLAIN_CODEC, &dictionary(most_values, &doubles), 1, 8),
        ),
        ("a page of 1 MB, 400 times", parquet_bomb(ZSTD, &repeated, 400, 1)),
        ("a million million rows", parquet_bomb(PLAIN_CODEC, &page(64, 8, &doubles), 1, 1 << 40)),
        ("rows beyond counting", parquet_bomb(PLAIN_CODEC, &page(64, 8, &doubles), 3, i64::MAX)),
        ("a footer of 2 MB in 3", huge_footer),
    ] {
        let (_, fault) = read(folder.path(), &bomb);
        assert!(matches!(fault, Some(Fault::TooMuch { .. })), "{name}: {fault:?}");
    }
    for (name, bomb) in [
        ("256 MB that say they are 64 bytes", parquet_bomb(ZSTD, &page(64, 8, zstd), 1, 8)),
        ("256 MB that say they are 64 bytes", parquet_bomb(GZIP, &page(64, 8, gzip), 1, 8)),
        (
            "1 GB that says it is 64 bytes",
            parquet_bomb(SNAPPY, &page(64, 8, &length_of_snappy), 1, 8),
        ),
        (
            "100,000 values in 64 bytes",
            parquet_bomb(PLAIN_CODEC, &dictionary(100_000, &doubles), 1, 8),
        ),
        ("more rows than values", parquet_bomb(PLAIN_CODEC, &page(64, 8, &doubles), 1, 500_000)),
    ] {
        let (_, fault) = read(folder.path(), &bomb);
        assert!(matches!(fault, Some(Fault::Damaged { .. })), "{name}: {fault:?}");
    }
    if let (Some(before_kb), Some(after_kb)) = (before_kb, peak_memory_kb()) {
        let grown_kb = after_kb - before_kb;
        assert!(grown_kb < MOST_MEMORY_KB, "{grown_kb} kB");
        println!("{grown_kb} kB more than before");
    }
}
