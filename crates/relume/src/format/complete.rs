//! Whether a JPEG or PNG file is complete, and large enough for what its header claims. Decoders fill in what
//! a truncated file lacks; a measurement must not, so the end marker of the file is checked first.
//!
//! Markers as in ITU-T T.81, annex B; chunks as in W3C PNG (third edition), section 5.

use super::jpeg_scan::ScanCheck;
use super::plausible;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::size::Size;

const END_OF_IMAGE: u8 = 0xd9;
const START_OF_SCAN: u8 = 0xda;

/// What the frame header of a JPEG file claims (ITU-T T.81, B.2.2).
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    size: Size,
    channels: u64,
    /// Blocks of 8 x 8 samples of all components.
    blocks: u64,
    is_progressive: bool,
}

impl Frame {
    /// Whether the colours are those of four inks.
    pub(super) fn is_cmyk(&self) -> bool {
        self.channels == 4
    }

    /// Reads the segment that follows the marker of a frame.
    fn of(marker: u8, segment: &[u8]) -> Option<Self> {
        let [_, _, _, h1, h0, w1, w0, channels, components @ ..] = segment else { return None };
        let size = Size::new(u16::from_be_bytes([*w1, *w0]).into(), u16::from_be_bytes([*h1, *h0]).into());
        let factors: Vec<(usize, usize)> = components
            .chunks_exact(3)
            .take(usize::from(*channels))
            .map(|c| (usize::from(c[1] >> 4).max(1), usize::from(c[1] & 15).max(1)))
            .collect();
        let most = |side: fn(&(usize, usize)) -> usize| factors.iter().map(side).max().unwrap_or(1);
        let (across, down) = (most(|f| f.0), most(|f| f.1));
        let blocks = |&(h, v): &(usize, usize)| {
            let sides = ((size.width * h).div_ceil(8 * across), (size.height * v).div_ceil(8 * down));
            sides.0 as u64 * sides.1 as u64
        };
        let blocks = factors.iter().map(blocks).sum();
        Some(Self { size, channels: u64::from(*channels), blocks, is_progressive: marker == 0xc2 })
    }

    /// Bytes that decoding takes: the samples, and of a progressive file all coefficients.
    pub(super) fn working_bytes(&self) -> u64 {
        let coefficients = if self.is_progressive { 64 * 2 * self.blocks } else { 0 };
        self.size.texels() as u64 * self.channels + coefficients
    }
}

/// Follows the markers of a JPEG file up to its end-of-image marker; returns its frame, whose size is
/// plausible only if every block has at least one bit.
pub(super) fn check_jpeg(bytes: &[u8]) -> Result<Option<Frame>> {
    let truncated = || {
        Error::invalid(format!(
            "the JPEG data ends at byte {} without an end-of-image marker: the file is truncated",
            bytes.len()
        ))
    };
    let (mut at, mut frame) = (2, None);
    let mut check = ScanCheck::default();
    loop {
        let marker_at = next_marker(bytes, at).ok_or_else(truncated)?;
        at = marker_at + 1;
        match bytes[marker_at] {
            END_OF_IMAGE => return Ok(frame),
            0x01 | 0xd0..=0xd8 => {}
            marker => {
                let length = bytes.get(at..at + 2).ok_or_else(truncated)?;
                let end = at + usize::from(u16::from_be_bytes([length[0], length[1]]));
                if matches!(marker, 0xc0..=0xc3 | 0xc5..=0xc7 | 0xc9..=0xcb | 0xcd..=0xcf) {
                    frame = bytes.get(at..end).and_then(|segment| Frame::of(marker, segment));
                    if let Some(frame) = &frame {
                        let found = bytes.len() as u64;
                        plausible::check("JPEG", frame.size, frame.blocks, found, 8)?;
                    }
                }
                let data = bytes.get(at + 2..end);
                at = end;
                if marker == START_OF_SCAN && at > bytes.len() {
                    return Err(truncated());
                }
                match data {
                    Some(data) if marker == START_OF_SCAN && check.is_ready() => {
                        at = check.scan(data, bytes, at)?;
                    }
                    Some(data) => check.segment(marker, data),
                    None => {}
                }
            }
        }
    }
}

/// The position of the next marker code: a byte after 0xff that is neither stuffing (0) nor fill (0xff).
fn next_marker(bytes: &[u8], from: usize) -> Option<usize> {
    let mut at = from;
    loop {
        at += bytes.get(at..)?.iter().position(|&byte| byte == 0xff)? + 1;
        if !matches!(bytes.get(at)?, 0x00 | 0xff) {
            return Some(at);
        }
    }
}

/// Follows the chunks of a PNG file up to its `IEND`. Frames of an animation after the first, and bytes after the end,
/// become remarks of the job: they are not read.
pub(super) fn check_png(bytes: &[u8], job: &Job) -> Result<()> {
    let (mut at, mut claimed, mut data) = (8, None, 0);
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
        match &head[4..] {
            b"IHDR" => claimed = claimed.or_else(|| png_header(&bytes[at + 8..end])),
            b"IDAT" => data += length as u64,
            b"acTL" => {
                if let Some(&[n0, n1, n2, n3]) = bytes[at + 8..end].first_chunk::<4>() {
                    let frames = u32::from_be_bytes([n0, n1, n2, n3]);
                    job.remark(format!(
                        "the PNG file is an animation of {frames} frames: its still picture is taken"
                    ));
                }
            }
            b"IEND" => {
                if end < bytes.len() {
                    job.remark(format!(
                        "{} bytes after the end of the PNG picture are not read",
                        bytes.len() - end
                    ));
                }
                let (size, needed) = claimed.unwrap_or((Size::new(0, 0), 0));
                if size.texels() == 0 {
                    return Err(Error::invalid(format!(
                        "the PNG header says {size} texels: expected at least 1 x 1; export the file again"
                    )));
                }
                return plausible::check("PNG", size, needed, data, plausible::DEFLATE);
            }
            _ => {}
        }
        at = end;
    }
}

/// The size of a PNG picture, and how many bytes its samples take at least.
fn png_header(data: &[u8]) -> Option<(Size, u64)> {
    let (sides, rest) = data.split_at_checked(8)?;
    let (&[w0, w1, w2, w3, h0, h1, h2, h3], &[bits, color, ..]) = (sides, rest) else { return None };
    let (width, height) = (u32::from_be_bytes([w0, w1, w2, w3]), u32::from_be_bytes([h0, h1, h2, h3]));
    let samples = [1, 1, 3, 1, 2, 1, 4][usize::from(color).min(6)];
    let texels = u64::from(width) * u64::from(height);
    let needed = u128::from(texels) * u128::from(bits) * samples / 8;
    Some((Size::new(width as usize, height as usize), u64::try_from(needed).unwrap_or(u64::MAX)))
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

    #[test]
    fn what_is_not_read_of_a_png_file_is_said() {
        let chunk = |kind: &[u8; 4], data: &[u8]| {
            [&(data.len() as u32).to_be_bytes()[..], kind, data, &[0; 4]].concat()
        };
        let head = |width: u8| chunk(b"IHDR", &[0, 0, 0, width, 0, 0, 0, 1, 8, 2, 0, 0, 0]);
        let file = |width, more: &[u8]| {
            let animation = chunk(b"acTL", &[0, 0, 0, 3, 0, 0, 0, 0]);
            [&b"12345678"[..], &head(width), &animation, &chunk(b"IDAT", &[0; 8]), &chunk(b"IEND", &[]), more]
                .concat()
        };
        let job = Job::default();
        check_png(&file(1, b"more"), &job).unwrap();
        for words in ["an animation of 3 frames", "4 bytes after the end"] {
            assert!(job.remarks().iter().any(|remark| remark.contains(words)), "{:?}", job.remarks());
        }
        let error = check_png(&file(0, &[]), &Job::default()).unwrap_err().to_string();
        assert!(error.contains("says 0 x 1 texels: expected at least 1 x 1"), "{error}");
    }
}
