//! Texts and bytes as people and programs damage them, the same for a seed.

/// What is often not expected.
const TOKENS: [&[u8]; 20] = [
    b"1e999",
    b"-1",
    b"NaN",
    b"inf",
    b"null",
    b"{}",
    b"[",
    b"]]",
    b"\"",
    b"'''",
    b"\0",
    b"\n",
    b"%00",
    b"%ff",
    b"../",
    b"18446744073709551616",
    b"\xf0\x9f\x9a\xa2",
    b"true",
    b"&a=",
    b"\\u0000",
];

/// Damages texts.
///
/// ```
/// let [once, again] = [7, 7].map(|seed| seatrial_dev::Damage::new(seed).of(b"thrusts = [0.6]"));
/// assert_eq!(once, again);
/// ```
#[derive(Clone, Debug)]
pub struct Damage(u64);

impl Damage {
    /// The random numbers of this seed.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// The next number from 0 to below `count`; 0 where that is 0.
    pub fn below(&mut self, count: usize) -> usize {
        // SplitMix64.
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % count.max(1) as u64) as usize
    }

    /// The bytes with one to three of them changed, taken out or cut off, or with tokens put in.
    pub fn of(&mut self, bytes: &[u8]) -> Vec<u8> {
        let mut bytes = bytes.to_vec();
        for _ in 0..=self.below(3) {
            let place = self.below(bytes.len() + 1);
            match self.below(8) {
                0 | 1 if place < bytes.len() => bytes[place] = self.below(256) as u8,
                2 | 3 if place < bytes.len() => {
                    bytes.remove(place);
                }
                4 => bytes.truncate(place),
                5 => {
                    let end = (place + self.below(40)).min(bytes.len());
                    let copied = bytes[place..end].to_vec();
                    bytes.splice(place..place, copied);
                }
                _ => {
                    let token = TOKENS[self.below(TOKENS.len())];
                    bytes.splice(place..place, token.iter().copied());
                }
            }
        }
        bytes
    }

    /// A text with such damage; what is no UTF-8 any more is replaced.
    pub fn of_text(&mut self, text: &str) -> String {
        String::from_utf8_lossy(&self.of(text.as_bytes())).into_owned()
    }
}

/// How many damaged copies of each text a test tries: as many as `SEATRIAL_DAMAGED` says, or so many.
///
/// # Panics
///
/// Where `SEATRIAL_DAMAGED` is no number.
pub fn damaged_copies(usual: u64) -> u64 {
    std::env::var("SEATRIAL_DAMAGED").map_or(usual, |count| count.parse().expect("a number"))
}
