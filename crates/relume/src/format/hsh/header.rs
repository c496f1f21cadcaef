//! The heads of both kinds of files, and the recognition of files without a signature.
//!
//! `.rti`: lines of comments beginning with `#`, then three lines of text (type; width, height and 3; terms, kind of
//! colour and bytes of a number), then floats. `.hsh`: comments, then four integers and floats.

use super::{HshEncoding, MOST_TERMS};
use crate::error::{Error, Result};
use crate::size::Size;

/// How the bytes of a texel make its colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum TexelColor {
    /// The terms of red, those of green, those of blue.
    Rgb,
    /// The terms of luminance, then red, green and blue.
    Lrgb,
}

impl TexelColor {
    pub(super) fn texel_bytes(self, terms: usize) -> usize {
        match self {
            Self::Rgb => 3 * terms,
            Self::Lrgb => terms + 3,
        }
    }
}

/// What a head says.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct HshHeader {
    pub size: Size,
    pub color: TexelColor,
    pub encoding: HshEncoding,
    /// The first byte of the texels.
    pub payload: usize,
}

/// The longest side that is believed of a file without a signature.
const LONGEST_SIDE: u32 = 1 << 17;

/// Whether bytes are the beginning of a file of either kind.
pub(in crate::format) fn is_hsh(bytes: &[u8]) -> bool {
    let at = after_comments(bytes);
    (at > 0 && text_head(bytes, at).is_ok()) || binary_head(bytes, at).is_some()
}

/// The place after the lines that begin with `#`.
fn after_comments(bytes: &[u8]) -> usize {
    let mut at = 0;
    while bytes.get(at) == Some(&b'#') {
        match bytes[at..].iter().position(|&b| b == b'\n') {
            Some(end) => at += end + 1,
            None => return bytes.len(),
        }
    }
    at
}

impl HshHeader {
    pub(super) fn parse(bytes: &[u8]) -> Result<Self> {
        let at = after_comments(bytes);
        match binary_head(bytes, at) {
            Some(head) => old(bytes, at, head),
            None => rti(bytes, at),
        }
    }
}

/// Width, height and order of an old file.
fn binary_head(bytes: &[u8], at: usize) -> Option<(u32, u32, u32)> {
    let head = bytes.get(at..at + 16)?;
    let number =
        |k: usize| u32::from_le_bytes([head[4 * k], head[4 * k + 1], head[4 * k + 2], head[4 * k + 3]]);
    let (width, height, bands, order) = (number(0), number(1), number(2), number(3));
    let side = 1..LONGEST_SIDE;
    let fits = side.contains(&width) && side.contains(&height) && bands == 3 && (1..=5).contains(&order);
    fits.then_some((width, height, order))
}

fn old(bytes: &[u8], at: usize, (width, height, order): (u32, u32, u32)) -> Result<HshHeader> {
    let terms = (order * order) as usize;
    let [low, high] = floats(bytes, at + 16, terms)?;
    let range: Vec<f32> = low.iter().zip(&high).map(|(low, high)| high - low).collect();
    let size = Size::new(width as usize, height as usize);
    let payload = at + 16 + 8 * terms;
    Ok(HshHeader { size, color: TexelColor::Rgb, encoding: HshEncoding::new(&range, &low), payload })
}

/// The numbers of the three lines of text, and the place after them.
fn text_head(bytes: &[u8], at: usize) -> Result<(Vec<u64>, usize)> {
    let (mut numbers, mut at) = (Vec::new(), at);
    for (line, count) in [("the type", 1), ("the size", 3), ("the terms", 3)] {
        let rest = bytes.get(at..).unwrap_or_default();
        let end = rest.iter().take(200).position(|&b| b == b'\n');
        let words = end.map(|end| String::from_utf8_lossy(&rest[..end]));
        let found: Option<Vec<u64>> =
            words.as_ref().and_then(|text| text.split_whitespace().map(|word| word.parse().ok()).collect());
        match found.filter(|found| found.len() == count) {
            Some(found) => numbers.extend(found),
            None => {
                return Err(Error::invalid(format!(
                    "the RTI file has no line of {count} whole numbers, {line}, at byte {at}: the file is damaged or \
                     truncated"
                )));
            }
        }
        at += end.unwrap_or_default() + 1;
    }
    Ok((numbers, at))
}

fn rti(bytes: &[u8], at: usize) -> Result<HshHeader> {
    let (numbers, at) = text_head(bytes, at)?;
    let &[kind, width, height, channels, terms, color, element] = &numbers[..] else {
        return Err(Error::invalid("the RTI file has a head of other than seven numbers"));
    };
    let other = |what: &str| {
        Error::unsupported(format!("RTI files of {what} are not read: expected harmonics (type 3)"))
    };
    match kind {
        3 => {}
        1 => return Err(other("polynomials (type 1)")),
        2 => return Err(other("spherical harmonics (type 2)")),
        4 => return Err(other("an adaptive basis (type 4)")),
        n => {
            return Err(Error::invalid(format!(
                "the RTI file has the type {n}: expected 3, hemispherical harmonics"
            )));
        }
    }
    if (channels, element) != (3, 1) {
        return Err(Error::unsupported(format!(
            "the RTI file has {channels} channels of {element} bytes a number: expected 3 of 1"
        )));
    }
    let color = match color {
        2 => TexelColor::Rgb,
        1 => TexelColor::Lrgb,
        n => {
            return Err(Error::unsupported(format!(
                "the RTI file has colours of kind {n}: expected 2 (red, green and blue apart) or 1 (luminance times colour)"
            )));
        }
    };
    let side = |n: u64| usize::try_from(n).ok().filter(|n| *n > 0);
    let Some((width, height)) = side(width).zip(side(height)) else {
        return Err(Error::invalid(format!(
            "the RTI file has {width} x {height} texels: expected at least one"
        )));
    };
    let size = Size::new(width, height);
    let terms = terms_of(terms, size, color, bytes.len() - at)?;
    let [scale, bias] = floats(bytes, at, terms)?;
    Ok(HshHeader { size, color, encoding: HshEncoding::new(&scale, &bias), payload: at + 8 * terms })
}

/// The number of terms, where some writers give the order instead, which is one less than the number of bands: of both
/// readings the one that fits the length of the file.
fn terms_of(said: u64, size: Size, color: TexelColor, length: usize) -> Result<usize> {
    let bands = said.saturating_add(1);
    let readings = [said, bands.saturating_mul(bands)];
    let possible = |terms: &u64| [1, 4, 9, 16, 25].contains(terms);
    let texels = size.width as u128 * size.height as u128;
    let needed = |terms: u64| 8 * u128::from(terms) + texels * color.texel_bytes(terms as usize) as u128;
    let mut possible = readings.into_iter().filter(possible);
    let first = possible.clone().next();
    match possible.find(|&terms| needed(terms) == length as u128).or(first) {
        Some(terms) if needed(terms) == length as u128 => Ok(terms as usize),
        Some(terms) => Err(Error::invalid(format!(
            "{size} texels of {terms} terms need {} bytes, found {length}: the file is truncated, or its head is wrong",
            needed(terms)
        ))),
        None => Err(Error::unsupported(format!(
            "the RTI file has {said} terms: expected 4, 9, 16 or 25 (at most {MOST_TERMS})"
        ))),
    }
}

/// Two lists of `count` floats.
fn floats(bytes: &[u8], at: usize, count: usize) -> Result<[Vec<f32>; 2]> {
    let list = |from: usize| -> Result<Vec<f32>> {
        let numbers = bytes.get(from..from + 4 * count).ok_or_else(|| {
            Error::invalid(format!(
                "the file ends at byte {} inside its scales: it is truncated",
                bytes.len()
            ))
        })?;
        let numbers = numbers.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        let numbers: Vec<f32> = numbers.collect();
        match numbers.iter().position(|n| !n.is_finite() || n.abs() > 1e20) {
            None => Ok(numbers),
            Some(k) => Err(Error::invalid(format!(
                "number {} of {count} at byte {from} is {}: expected one below 1e20 in size",
                k + 1,
                numbers[k]
            ))),
        }
    };
    Ok([list(at)?, list(at + 4 * count)?])
}
