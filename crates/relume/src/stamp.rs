//! Stamps: whether a file is the one that its companion was written with.

use std::fmt;

use serde::{Deserialize, Serialize};

/// The length of a file and the CRC-32 of its bytes (as in PNG and zip; ISO/IEC 3309): enough to tell files
/// of one kind apart, but no protection against forgery.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Stamp {
    /// The number of bytes.
    pub bytes: u64,
    /// Their checksum.
    pub crc32: u32,
}

impl Stamp {
    /// The stamp of the bytes of a file.
    ///
    /// ```
    /// use relume::Stamp;
    /// assert_eq!(Stamp::of(b"123456789"), Stamp { bytes: 9, crc32: 0xcbf4_3926 });
    /// ```
    pub fn of(bytes: &[u8]) -> Self {
        Self { bytes: bytes.len() as u64, crc32: crc32fast::hash(bytes) }
    }
}

impl fmt::Display for Stamp {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} bytes with checksum {:08x}", self.bytes, self.crc32)
    }
}
