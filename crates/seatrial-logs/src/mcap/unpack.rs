//! Chunks packed with zstd and lz4, unpacked without C.

mod lz4;

use mcap::sans_io::LinearReader;
use mcap::sans_io::decompressor::{DecompressResult, Decompressor};
use mcap::{McapError, McapResult};
use ruzstd::decoding::FrameDecoder;

/// The longest block of zstd, its header and that of its frame: so much makes progress.
const MOST_FOR_PROGRESS: usize = (128 << 10) + 3 + 18;

/// Gives the reader decoders that are written in Rust.
pub(super) fn with_rust(mut reader: LinearReader) -> LinearReader {
    let zstd = reader.add_decompressor(Zstd::default());
    let lz4 = reader.add_decompressor(lz4::Lz4::default());
    debug_assert!(zstd.is_ok() && lz4.is_ok(), "the decoders have names");
    reader
}

/// The frames of one chunk.
#[derive(Default)]
struct Zstd {
    frame: FrameDecoder,
    is_begun: bool,
}

impl Decompressor for Zstd {
    fn next_read_size(&self) -> usize {
        MOST_FOR_PROGRESS
    }

    fn decompress(&mut self, src: &[u8], dst: &mut [u8]) -> McapResult<DecompressResult> {
        let failed =
            |error: &dyn std::fmt::Display| McapError::DecompressionError(format!("zstd: {error}"));
        let mut rest = src;
        if !self.is_begun || (self.frame.is_finished() && self.frame.can_collect() == 0) {
            self.frame.init(&mut rest).map_err(|error| failed(&error))?;
            self.is_begun = true;
        }
        let header = src.len() - rest.len();
        let (consumed, wrote) = self
            .frame
            .decode_from_to(rest, dst)
            .map_err(|error| failed(&error))?;
        Ok(DecompressResult {
            consumed: header + consumed,
            wrote,
        })
    }

    fn reset(&mut self) -> McapResult<()> {
        *self = Self::default();
        Ok(())
    }

    fn name(&self) -> &'static str {
        "zstd"
    }
}

#[cfg(all(test, feature = "mcap"))]
mod tests {
    use mcap::records::MessageHeader;
    use mcap::sans_io::linear_reader::LinearReadEvent;

    use super::*;

    /// 200 messages of 3 kB in chunks of 64 kB, half of it noise that does not pack.
    fn packed(by: mcap::Compression) -> Vec<u8> {
        let mut file = std::io::Cursor::new(Vec::new());
        let options = mcap::WriteOptions::new()
            .compression(Some(by))
            .chunk_size(Some(64 << 10));
        let mut writer = options.create(&mut file).unwrap();
        let channel = writer.add_channel(0, "/heading", "cdr", &Default::default());
        let channel_id = channel.unwrap();
        let mut noise = 1_u32;
        for k in 0..200_u32 {
            let header = MessageHeader {
                channel_id,
                sequence: k,
                log_time: u64::from(k),
                publish_time: u64::from(k),
            };
            let body: Vec<u8> = (0..3000_u32)
                .map(|i| {
                    noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    (if i % 2 == 0 { noise >> 24 } else { k }) as u8
                })
                .collect();
            writer.write_to_known_channel(&header, &body).unwrap();
        }
        writer.finish().unwrap();
        drop(writer);
        file.into_inner()
    }

    /// Every record, or what stopped the reader.
    fn records(mut reader: LinearReader, file: &[u8], piece: usize) -> McapResult<Vec<Vec<u8>>> {
        let (mut records, mut at) = (Vec::new(), 0);
        while let Some(event) = reader.next_event() {
            match event? {
                LinearReadEvent::ReadRequest(count) => {
                    let count = count.clamp(1, piece).min(file.len() - at);
                    reader.insert(count)[..count].copy_from_slice(&file[at..at + count]);
                    reader.notify_read(count);
                    at += count;
                }
                LinearReadEvent::Record { data, opcode } => {
                    records.push([&[opcode], data].concat());
                }
            }
        }
        Ok(records)
    }

    #[test]
    fn exact_rust_unpacks_what_c_unpacks() {
        for by in [mcap::Compression::Zstd, mcap::Compression::Lz4] {
            let file = packed(by);
            let expected = records(LinearReader::new(), &file, usize::MAX).unwrap();
            assert!(expected.len() > 200);
            for piece in [1000, 1 << 16, usize::MAX] {
                let found = records(with_rust(LinearReader::new()), &file, piece).unwrap();
                assert!(found == expected, "{by:?} {piece}");
            }
        }
    }

    #[test]
    fn exact_damaged_chunks_end_the_reading() {
        for by in [mcap::Compression::Zstd, mcap::Compression::Lz4] {
            let file = packed(by);
            for at in (200..file.len()).step_by(997) {
                let mut damaged = file.clone();
                damaged[at] ^= 0x55;
                // No panic and no end without an end: either all is read or an error says why.
                let _ = records(with_rust(LinearReader::new()), &damaged, 1 << 16);
            }
        }
    }
}
