//! Chunks unpacked without C: of lz4 everywhere, of zstd where there is none of C.

mod lz4;
#[cfg(all(feature = "without-c", any(test, not(feature = "mcap"))))]
mod zstd;

use mcap::sans_io::LinearReader;

/// Gives the reader decoders that are written in Rust.
pub(super) fn with_rust(reader: LinearReader) -> LinearReader {
    let reader = with_lz4(reader);
    #[cfg(all(feature = "without-c", not(feature = "mcap")))]
    let reader = with_zstd(reader);
    reader
}

fn with_lz4(mut reader: LinearReader) -> LinearReader {
    let added = reader.add_decompressor(lz4::Lz4::default());
    debug_assert!(added.is_ok(), "the decoder has a name");
    reader
}

#[cfg(all(feature = "without-c", any(test, not(feature = "mcap"))))]
fn with_zstd(mut reader: LinearReader) -> LinearReader {
    let added = reader.add_decompressor(zstd::Zstd::default());
    debug_assert!(added.is_ok(), "the decoder has a name");
    reader
}

#[cfg(all(test, feature = "mcap", feature = "without-c"))]
mod tests {
    use mcap::McapResult;
    use mcap::records::MessageHeader;
    use mcap::sans_io::linear_reader::LinearReadEvent;

    use super::*;

    /// 200 messages of 3 kB in chunks of 64 kB, half of it noise that does not pack.
    fn packed(by: mcap::Compression) -> Vec<u8> {
        let mut file = std::io::Cursor::new(Vec::new());
        let options = mcap::WriteOptions::new().compression(Some(by)).chunk_size(Some(64 << 10));
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

    fn in_rust() -> LinearReader {
        with_zstd(with_lz4(LinearReader::new()))
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
                let found = records(in_rust(), &file, piece).unwrap();
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
                let _ = records(in_rust(), &damaged, 1 << 16);
            }
        }
    }
}
