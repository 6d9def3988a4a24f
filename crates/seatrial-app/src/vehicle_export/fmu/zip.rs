//! Files in a ZIP archive, not compressed.

use crc32fast::hash;

/// An archive that is written.
#[derive(Default)]
pub(super) struct Archive {
    bytes: Vec<u8>,
    directory: Vec<u8>,
    count: u16,
}

/// Version 2.0, no flags, stored, 1 January 1980: what begins both headers of a file.
const STORED: [u16; 5] = [20, 0, 0, 0, 0x21];

impl Archive {
    /// Adds a file; `None` where the archive cannot hold it.
    pub(super) fn add(&mut self, path: &str, content: &[u8]) -> Option<()> {
        let offset = u32::try_from(self.bytes.len()).ok()?;
        let size = u32::try_from(content.len()).ok()?;
        let name = u16::try_from(path.len()).ok()?;
        let mut header = Vec::new();
        header.extend(STORED.iter().flat_map(|x| x.to_le_bytes()));
        header.extend(
            [hash(content), size, size]
                .iter()
                .flat_map(|x| x.to_le_bytes()),
        );
        header.extend(name.to_le_bytes());
        header.extend(0_u16.to_le_bytes());

        self.bytes.extend(b"PK\x03\x04");
        self.bytes.extend(&header);
        self.bytes.extend(path.as_bytes());
        self.bytes.extend(content);

        self.directory.extend(b"PK\x01\x02");
        // Made on Unix, version 2.0.
        self.directory.extend([20, 3]);
        self.directory.extend(&header);
        // No comment, first disk, no internal attributes; a file that all may read.
        self.directory.extend([0; 6]);
        self.directory.extend((0o100_644_u32 << 16).to_le_bytes());
        self.directory.extend(offset.to_le_bytes());
        self.directory.extend(path.as_bytes());
        self.count = self.count.checked_add(1)?;
        u32::try_from(self.bytes.len()).ok().map(drop)
    }

    /// The archive with its directory.
    pub(super) fn finish(mut self) -> Vec<u8> {
        let [offset, size] = [self.bytes.len(), self.directory.len()].map(|n| n as u32);
        self.bytes.append(&mut self.directory);
        self.bytes.extend(b"PK\x05\x06");
        self.bytes.extend([0; 4]);
        self.bytes.extend(self.count.to_le_bytes());
        self.bytes.extend(self.count.to_le_bytes());
        self.bytes.extend(size.to_le_bytes());
        self.bytes.extend(offset.to_le_bytes());
        self.bytes.extend([0; 2]);
        self.bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The check sum of the catalogue stands where the header has it.
    #[test]
    fn exact_the_check_sum_of_the_catalogue() {
        for (content, expected) in [(&b"123456789"[..], 0xCBF4_3926_u32), (b"", 0)] {
            let mut archive = Archive::default();
            archive.add("a", content).unwrap();
            assert_eq!(archive.finish()[14..18], expected.to_le_bytes());
        }
    }
}
