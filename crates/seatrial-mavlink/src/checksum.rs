//! The checksum of MAVLink frames.

/// CRC-16/MCRF4XX over the frame without its mark, then over the message's seed.
pub(crate) fn checksum(bytes: &[u8], crc_extra: u8) -> u16 {
    let next = |crc: u16, byte: u8| (crc >> 8) ^ REMAINDERS[0][usize::from(byte ^ crc as u8)];
    let (eights, rest) = bytes.as_chunks::<8>();
    let crc = eights.iter().fold(0xffff_u16, |crc, eight| {
        let [low, high] = crc.to_le_bytes();
        let mut mixed = *eight;
        mixed[0] ^= low;
        mixed[1] ^= high;
        mixed
            .iter()
            .zip(REMAINDERS.iter().rev())
            .fold(0, |crc, (byte, remainders)| crc ^ remainders[usize::from(*byte)])
    });
    let crc = rest.iter().fold(crc, |crc, byte| next(crc, *byte));
    next(crc, crc_extra)
}

/// What each byte leaves of the checksum's polynomial, 0x1021 with its bits reversed, behind up to seven zeros.
static REMAINDERS: [[u16; 256]; 8] = {
    let mut remainders = [[0; 256]; 8];
    let mut byte = 0;
    while byte < 256 {
        let mut remainder = byte as u16;
        let mut zeros = 0;
        while zeros < 8 {
            let mut bit = 0;
            while bit < 8 {
                remainder = (remainder >> 1) ^ (0x8408 * (remainder & 1));
                bit += 1;
            }
            remainders[zeros][byte] = remainder;
            zeros += 1;
        }
        byte += 1;
    }
    remainders
};

#[cfg(test)]
mod tests {
    use super::*;

    /// The check value of CRC-16/MCRF4XX.
    #[test]
    fn exact_checksum() {
        assert_eq!(checksum(b"12345678", b'9'), 0x6f91);
    }
}
