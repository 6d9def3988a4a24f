//! Chunks packed with zstd.

use mcap::sans_io::decompressor::{DecompressResult, Decompressor};
use mcap::{McapError, McapResult};
use ruzstd::decoding::FrameDecoder;

/// The longest block of zstd, its header and that of its frame: so much makes progress.
const MOST_FOR_PROGRESS: usize = (128 << 10) + 3 + 18;

/// The frames of one chunk.
#[derive(Default)]
pub(super) struct Zstd {
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
        let (consumed, wrote) =
            self.frame.decode_from_to(rest, dst).map_err(|error| failed(&error))?;
        Ok(DecompressResult { consumed: header + consumed, wrote })
    }

    fn reset(&mut self) -> McapResult<()> {
        *self = Self::default();
        Ok(())
    }

    fn name(&self) -> &'static str {
        "zstd"
    }
}
