//! Whether a file is large enough for the picture claimed by its header: the compression of its format has a
//! limit. A header alone must not make a reader allocate gigabytes.

use crate::error::{Error, Result};
use crate::size::Size;

/// The largest expansion by DEFLATE: 258 bytes for two bits (RFC 1951), plus a margin for the rest of a file.
pub(super) const DEFLATE: u64 = 1100;

/// The largest expansion by any compression of TIFF: runs in LZW reach 1340.
pub(super) const LZW: u64 = 2000;

/// Refuses a picture of `needed` bytes in `found` bytes that expand to at most `most` times as many.
pub(super) fn check(kind: &str, size: Size, needed: u64, found: u64, most: u64) -> Result<()> {
    if needed <= found.saturating_mul(most) {
        return Ok(());
    }
    Err(Error::invalid(format!(
        "the {kind} header claims {size} texels, and {found} bytes cannot hold so many: the file is damaged or \
         truncated"
    )))
}
