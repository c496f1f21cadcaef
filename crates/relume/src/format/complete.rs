//! Whether a JPEG or PNG file is whole. Decoders fill in what a truncated file lacks; a
//! measurement must not, so the file's own end marker is looked for first.
//!
//! Markers as in ITU-T T.81, annex B; chunks as in W3C PNG (third edition), section 5.

use crate::error::{Error, Result};

const END_OF_IMAGE: u8 = 0xd9;
const START_OF_SCAN: u8 = 0xda;

/// Walks the markers of a JPEG file up to its end-of-image marker.
pub(super) fn check_jpeg(bytes: &[u8]) -> Result<()> {
    let truncated = || {
        Error::invalid(format!(
            "the JPEG data ends at byte {} without an end-of-image marker: the file is truncated",
            bytes.len()
        ))
    };
    let mut at = 2;
    loop {
        let marker_at = next_marker(bytes, at).ok_or_else(truncated)?;
        at = marker_at + 1;
        match bytes[marker_at] {
            END_OF_IMAGE => return Ok(()),
            0x01 | 0xd0..=0xd8 => {}
            marker => {
                let length = bytes.get(at..at + 2).ok_or_else(truncated)?;
                at += usize::from(u16::from_be_bytes([length[0], length[1]]));
                if marker == START_OF_SCAN && at > bytes.len() {
                    return Err(truncated());
                }
            }
        }
    }
}

/// The place of the next marker code: a byte after 0xff that is neither stuffing (0) nor fill (0xff).
fn next_marker(bytes: &[u8], from: usize) -> Option<usize> {
    let mut at = from;
    loop {
        at += bytes.get(at..)?.iter().position(|&byte| byte == 0xff)? + 1;
        if !matches!(bytes.get(at)?, 0x00 | 0xff) {
            return Some(at);
        }
    }
}

/// Walks the chunks of a PNG file up to its `IEND`.
pub(super) fn check_png(bytes: &[u8]) -> Result<()> {
    let mut at = 8;
    loop {
        let truncated = || {
            Error::invalid(format!(
                "the PNG data ends at byte {} inside the chunk at byte {at}: the file is truncated",
                bytes.len()
            ))
        };
        let head = bytes.get(at..at + 8).ok_or_else(truncated)?;
        let length = u32::from_be_bytes([head[0], head[1], head[2], head[3]]) as usize;
        let end = at.checked_add(length).and_then(|end| end.checked_add(12)).ok_or_else(truncated)?;
        if end > bytes.len() {
            return Err(truncated());
        }
        if &head[4..] == b"IEND" {
            return Ok(());
        }
        at = end;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_end_marker_inside_a_thumbnail_does_not_count() {
        let thumbnail = [0xff, 0xe1, 0, 8, 0xff, 0xd8, 1, 2, 0xff, 0xd9];
        let scan = [0xff, 0xda, 0, 3, 1, 0x12, 0xff, 0x00, 0x34, 0xff, 0xd3, 0x56];
        let whole = [&[0xff, 0xd8][..], &thumbnail, &scan, &[0xff, 0xff, 0xd9]].concat();
        assert!(check_jpeg(&whole).is_ok());
        assert!(check_jpeg(&[&whole[..], b"appended by a camera"].concat()).is_ok());
        for length in 0..whole.len() {
            assert!(check_jpeg(&whole[..length]).is_err(), "{length}");
        }
    }
}
