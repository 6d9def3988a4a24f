//! Frames of lz4, as <https://github.com/lz4/lz4/blob/dev/doc/lz4_Frame_format.md> describes them. Check sums of frames are not compared:
//! a chunk has its own.

use lz4_flex::block::decompress_into_with_dict;
use mcap::sans_io::decompressor::{DecompressResult, Decompressor};
use mcap::{McapError, McapResult};

const MAGIC: [u8; 4] = [0x04, 0x22, 0x4d, 0x18];
/// Magic, two bytes of flags and one of their check sum; a size and the number of a dictionary may stand before the last.
const SHORTEST_HEAD: usize = 7;
/// What blocks may refer to of those before them.
const WINDOW: usize = 1 << 16;
/// Of the length of a block: it is not packed.
const IS_PLAIN: u32 = 1 << 31;

/// The frames of one chunk.
#[derive(Default)]
pub(super) struct Lz4 {
    /// What there is so far of the next head, block or end.
    packed: Vec<u8>,
    frame: Option<Frame>,
    /// The window before the last block, and that block from `begin` on, of which `given` bytes are given away.
    unpacked: Vec<u8>,
    begin: usize,
    given: usize,
}

/// What the head of a frame says.
#[derive(Clone, Copy)]
struct Frame {
    longest_block: usize,
    has_block_sums: bool,
    has_sum: bool,
}

impl Lz4 {
    /// Bytes of the next head, block or end, as far as its beginning says.
    fn wanted(&self) -> usize {
        let sum = |is: bool| if is { 4 } else { 0 };
        match (self.frame, self.block_length()) {
            (None, _) => {
                let flags = self.packed.get(4).copied().unwrap_or(0);
                let size = if flags & 1 << 3 > 0 { 8 } else { 0 };
                SHORTEST_HEAD + size + sum(flags & 1 > 0)
            }
            (Some(_), None) => 4,
            (Some(frame), Some(0)) => 4 + sum(frame.has_sum),
            (Some(frame), Some(length)) => {
                4 + (length & !IS_PLAIN) as usize + sum(frame.has_block_sums)
            }
        }
    }

    fn block_length(&self) -> Option<u32> {
        self.packed.first_chunk().copied().map(u32::from_le_bytes)
    }

    /// Takes in the head, block or end that is there as a whole.
    fn take(&mut self) -> McapResult<()> {
        match (self.frame, self.block_length()) {
            (None, _) => self.frame = Some(head(&self.packed)?),
            (_, None | Some(0)) => self.frame = None,
            (Some(frame), Some(length)) => self.unpack(frame, length)?,
        }
        self.packed.clear();
        Ok(())
    }

    fn unpack(&mut self, frame: Frame, length: u32) -> McapResult<()> {
        let bytes = (length & !IS_PLAIN) as usize;
        let block = self.packed.get(4..4 + bytes).unwrap_or_default();
        let before = self.unpacked.len().saturating_sub(WINDOW);
        self.unpacked.drain(..before);
        self.begin = self.unpacked.len();
        self.given = 0;
        if length & IS_PLAIN > 0 {
            self.unpacked.extend_from_slice(block);
            return Ok(());
        }
        let mut plain = vec![0; frame.longest_block];
        let count = decompress_into_with_dict(block, &mut plain, &self.unpacked)
            .map_err(|error| failed(&error.to_string()))?;
        self.unpacked.extend_from_slice(&plain[..count]);
        Ok(())
    }

    /// Bytes that can be given away.
    fn rest(&self) -> &[u8] {
        &self.unpacked[self.begin + self.given..]
    }
}

fn head(bytes: &[u8]) -> McapResult<Frame> {
    let [flags, sizes] = [4, 5].map(|at| bytes.get(at).copied().unwrap_or(0));
    let size = sizes >> 4 & 7;
    if !bytes.starts_with(&MAGIC) || flags >> 6 != 1 || size < 4 {
        return Err(failed("no frame of version 1"));
    }
    Ok(Frame {
        // 64 KiB, 256 KiB, 1 MiB or 4 MiB.
        longest_block: 1 << (8 + 2 * size),
        has_block_sums: flags & 1 << 4 > 0,
        has_sum: flags & 1 << 2 > 0,
    })
}

fn failed(what: &str) -> McapError {
    McapError::DecompressionError(format!("lz4: {what}"))
}

impl Decompressor for Lz4 {
    fn next_read_size(&self) -> usize {
        self.wanted().saturating_sub(self.packed.len())
    }

    fn decompress(&mut self, src: &[u8], dst: &mut [u8]) -> McapResult<DecompressResult> {
        let mut consumed = 0;
        while self.rest().is_empty() {
            let missing = self.wanted().saturating_sub(self.packed.len());
            if let Some(frame) = self.frame
                && self.wanted() > frame.longest_block + 8
            {
                return Err(failed("a block is longer than its frame says"));
            }
            if missing > 0 {
                let count = missing.min(src.len() - consumed);
                if count == 0 {
                    break;
                }
                self.packed.extend_from_slice(&src[consumed..consumed + count]);
                consumed += count;
            } else {
                self.take()?;
            }
        }
        let wrote = self.rest().len().min(dst.len());
        dst[..wrote].copy_from_slice(&self.rest()[..wrote]);
        self.given += wrote;
        Ok(DecompressResult { consumed, wrote })
    }

    fn reset(&mut self) -> McapResult<()> {
        *self = Self::default();
        Ok(())
    }

    fn name(&self) -> &'static str {
        "lz4"
    }
}
