//! Signed frames of MAVLink 2.
//!
//! ```text
//! signature = link id (1 byte), timestamp (6 bytes, 10 us since 2015), first 48 bits of
//!             SHA-256(key, frame with its checksum, link id, timestamp)
//! ```
//!
//! A stream is a system, component and link id. A frame is refused whose timestamp is not above the last of its
//! stream, or, in a stream not met before, more than a minute behind our own. Source:
//! <https://mavlink.io/en/guide/message_signing.html>.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};
use thiserror::Error;

use super::sender::Sender;

/// Bytes of a signature.
pub(super) const SIGNATURE: usize = 13;
/// Bytes of a key.
const KEY: usize = 32;
/// Units of a timestamp in a second.
const PER_S: f64 = 1e5;
/// From 1970 to 2015, s.
const EPOCH_S: f64 = 1_420_070_400.0;
/// A minute.
const NEW_STREAM_WINDOW: u64 = 6_000_000;

/// A secret key. It is never shown.
#[derive(Clone)]
pub struct Key([u8; KEY]);

impl std::fmt::Debug for Key {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str("Key(not shown)")
    }
}

/// A key that cannot be used.
#[derive(Debug, Error)]
pub enum KeyError {
    /// The file cannot be read.
    #[error("{}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: std::io::Error,
    },
    /// The file holds no key.
    #[error(
        "{}: expected a signing key, 32 bytes or 64 hexadecimal digits; found {length} bytes that are neither",
        path.display()
    )]
    NoKey {
        /// The file.
        path: PathBuf,
        /// Bytes in it.
        length: usize,
    },
}

impl Key {
    /// A key of these bytes.
    pub fn new(bytes: [u8; KEY]) -> Self {
        Self(bytes)
    }

    /// The key in a file, 32 bytes or 64 hexadecimal digits.
    pub fn load(path: &Path) -> Result<Self, KeyError> {
        let bytes =
            std::fs::read(path).map_err(|source| KeyError::Read { path: path.into(), source })?;
        let no_key = || KeyError::NoKey { path: path.into(), length: bytes.len() };
        if let Ok(key) = bytes.as_slice().try_into() {
            return Ok(Self(key));
        }
        let digits = bytes.trim_ascii();
        if digits.len() != 2 * KEY {
            return Err(no_key());
        }
        let mut key = [0; KEY];
        for (byte, pair) in key.iter_mut().zip(digits.chunks_exact(2)) {
            let digit = |digit: u8| char::from(digit).to_digit(16);
            let (Some(high), Some(low)) = (digit(pair[0]), digit(pair[1])) else {
                return Err(no_key());
            };
            *byte = (16 * high + low) as u8;
        }
        Ok(Self(key))
    }
}

/// Why a frame is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum Refused {
    /// The frame has no signature.
    #[error("no signature")]
    Unsigned,
    /// Another key signed it, or it was changed.
    #[error("a signature by another key")]
    Forged,
    /// The frame was sent before.
    #[error("an old timestamp")]
    Replayed,
}

/// Signs what is sent and checks what has come.
#[derive(Debug)]
pub struct Signing {
    key: Key,
    link_id: u8,
    start_s: f64,
    /// The greatest timestamp that was sent or accepted.
    latest: u64,
    streams: BTreeMap<(Sender, u8), u64>,
}

impl Signing {
    /// With this key, on a link whose time 0 is `start_unix_s`, s since 1970.
    pub fn new(key: Key, link_id: u8, start_unix_s: f64) -> Self {
        Self { key, link_id, start_s: start_unix_s - EPOCH_S, latest: 0, streams: BTreeMap::new() }
    }

    fn clock(&self, now_s: f64) -> u64 {
        (((self.start_s + now_s) * PER_S) as u64).max(self.latest)
    }

    /// The signature of a frame that ends with its checksum.
    pub fn sign(&mut self, frame: &[u8], now_s: f64) -> [u8; SIGNATURE] {
        self.latest = self.clock(now_s).max(self.latest + 1);
        let mut signature = [0; SIGNATURE];
        signature[0] = self.link_id;
        signature[1..7].copy_from_slice(&self.latest.to_le_bytes()[..6]);
        let hash = self.hash(frame, &signature[..7]);
        signature[7..].copy_from_slice(&hash);
        signature
    }

    /// Is this the signature of the frame, and is it new?
    pub fn check(
        &mut self,
        sender: Sender,
        frame: &[u8],
        signature: &[u8],
        now_s: f64,
    ) -> Result<(), Refused> {
        let (stamp, hash) = signature.split_at_checked(7).ok_or(Refused::Unsigned)?;
        if self.hash(frame, stamp) != *hash {
            return Err(Refused::Forged);
        }
        let mut time = [0; 8];
        time[..6].copy_from_slice(&stamp[1..7]);
        let time = u64::from_le_bytes(time);
        let stream = (sender, stamp[0]);
        let is_new = match self.streams.get(&stream) {
            Some(last) => time > *last,
            None => time + NEW_STREAM_WINDOW >= self.clock(now_s),
        };
        if !is_new {
            return Err(Refused::Replayed);
        }
        self.streams.insert(stream, time);
        self.latest = self.latest.max(time);
        Ok(())
    }

    fn hash(&self, frame: &[u8], stamp: &[u8]) -> [u8; 6] {
        let hash = Sha256::new()
            .chain_update(self.key.0)
            .chain_update(frame)
            .chain_update(stamp)
            .finalize();
        std::array::from_fn(|k| hash[k])
    }
}
