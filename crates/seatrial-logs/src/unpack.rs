//! Zstd unpacked without C.

use std::io;

use ruzstd::decoding::FrameDecoder;

/// The bytes that a whole text packed by zstd stands for, in memory of at most this many.
pub(crate) fn zstd(packed: &[u8], most: usize) -> io::Result<Vec<u8>> {
    let mut bytes = vec![0; most];
    let count = FrameDecoder::new()
        .decode_all(packed, &mut bytes)
        .map_err(|error| io::Error::new(io::ErrorKind::InvalidData, format!("zstd: {error}")))?;
    bytes.truncate(count);
    Ok(bytes)
}

#[cfg(all(test, any(feature = "parquet", feature = "rosbag2")))]
mod tests {
    use super::*;

    #[test]
    fn exact_rust_unpacks_what_c_packed_and_no_more_than_is_allowed() {
        for length in [0_usize, 1, 1000, 300_000] {
            let bytes: Vec<u8> = (0..length).map(|k| (k * k / 7) as u8).collect();
            for level in [1, 3, 19] {
                let packed = ::zstd::bulk::compress(&bytes, level).unwrap();
                assert_eq!(zstd(&packed, length).unwrap(), bytes);
                assert_eq!(zstd(&packed, length + 5).unwrap(), bytes);
                if length > 0 {
                    assert!(zstd(&packed, length - 1).is_err(), "{length}");
                    assert!(zstd(&packed[..packed.len() - 1], length).is_err());
                }
            }
        }
        assert!(zstd(b"no frame", 100).is_err());
    }
}
