//! The head of a Radiance picture: lines of text up to an empty one, and the resolution line.

use crate::error::{Error, Result};
use crate::job::Job;
use crate::size::Size;

/// The longest head that is read.
const MAX_HEAD: usize = 1 << 16;
/// The only format of texels that is read.
pub(super) const RGBE: &str = "32-bit_rle_rgbe";
/// CIE 1931 XYZ instead of red, green and blue.
const XYZE: &str = "32-bit_rle_xyze";
/// Chromaticities of red, green, blue and white: those of sRGB, and those that Radiance takes without a record.
const KNOWN_PRIMARIES: [[f64; 8]; 2] = [
    [0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290],
    [0.64, 0.33, 0.29, 0.60, 0.15, 0.06, 0.3333, 0.3333],
];

/// What the head says, and where the scanlines begin.
#[derive(Debug)]
pub(super) struct RadianceHead {
    pub order: ScanOrder,
    /// The values of the file are those of the scene times these.
    pub factors: [f64; 3],
    pub start: usize,
}

/// The order of texels: scanlines along one axis, texels along the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct ScanOrder {
    pub size: Size,
    /// Whether scanlines are columns of the picture.
    pub by_columns: bool,
    /// Whether x decreases, and whether rows run from the bottom.
    pub from_right: bool,
    pub from_bottom: bool,
}

impl ScanOrder {
    /// The number of scanlines, and of texels in each.
    pub fn lines(&self) -> (usize, usize) {
        let Size { width, height } = self.size;
        if self.by_columns { (width, height) } else { (height, width) }
    }

    /// The texel at a place of a scanline, as an index by rows from the top.
    pub fn texel(&self, line: usize, place: usize) -> usize {
        let (x, y) = if self.by_columns { (line, place) } else { (place, line) };
        let x = if self.from_right { self.size.width - 1 - x } else { x };
        let y = if self.from_bottom { self.size.height - 1 - y } else { y };
        self.size.index(x, y)
    }
}

/// Reads the head; what is not applied becomes a remark.
pub(super) fn read(bytes: &[u8], job: &Job) -> Result<RadianceHead> {
    let mut at = 0;
    let mut line = || -> Result<&str> {
        let rest = &bytes[at..bytes.len().min(MAX_HEAD)];
        let length = rest.iter().position(|&byte| byte == b'\n').ok_or_else(|| {
            Error::invalid(format!(
                "the head of the Radiance file does not end: no end of line from byte {at} on"
            ))
        })?;
        at += length + 1;
        let text = std::str::from_utf8(&rest[..length]).unwrap_or_default();
        Ok(text.trim_end_matches('\r'))
    };
    line()?;
    let mut factors = [1.0; 3];
    let mut format = None;
    loop {
        let text = line()?;
        if text.is_empty() {
            break;
        }
        let Some((name, value)) = text.split_once('=') else { continue };
        match name.trim() {
            "FORMAT" => format = Some(checked_format(value.trim())?),
            "EXPOSURE" => multiply(&mut factors, [numbers::<1>(name, value)?[0]; 3], name)?,
            "COLORCORR" => multiply(&mut factors, numbers(name, value)?, name)?,
            "PRIMARIES" => check_primaries(numbers(name, value)?, job),
            _ => {}
        }
    }
    if format.is_none() {
        job.remark(format!("the Radiance file does not say its FORMAT: taken as {RGBE}"));
    }
    let order = scan_order(line()?)?;
    Ok(RadianceHead { order, factors, start: at })
}

fn checked_format(value: &str) -> Result<()> {
    match value {
        RGBE => Ok(()),
        XYZE => Err(Error::unsupported(format!(
            "the Radiance file holds CIE XYZ ({XYZE}), which is not read: convert it to RGB, for example by `ra_xyze -r`"
        ))),
        other => Err(Error::unsupported(format!(
            "the Radiance file holds the format '{}': expected {RGBE}",
            other.escape_default()
        ))),
    }
}

/// `N` numbers of a line.
fn numbers<const N: usize>(name: &str, value: &str) -> Result<[f64; N]> {
    let found: Option<Vec<f64>> = value.split_whitespace().map(|word| word.parse::<f64>().ok()).collect();
    found.and_then(|found| found.try_into().ok()).ok_or_else(|| {
        Error::invalid(format!(
            "the {name} of the Radiance file is not {N} numbers: '{}'",
            value.escape_default()
        ))
    })
}

fn multiply(factors: &mut [f64; 3], by: [f64; 3], name: &str) -> Result<()> {
    if !by.iter().all(|factor| factor.is_finite() && *factor > 0.0) {
        return Err(Error::invalid(format!(
            "the {name} of the Radiance file is {by:?}: expected positive numbers"
        )));
    }
    factors.iter_mut().zip(by).for_each(|(factor, by)| *factor *= by);
    Ok(())
}

fn check_primaries(found: [f64; 8], job: &Job) {
    let near = |known: &[f64; 8]| known.iter().zip(found).all(|(a, b)| (a - b).abs() < 2e-3);
    if !KNOWN_PRIMARIES.iter().any(near) {
        job.remark("the PRIMARIES of the Radiance file are not applied: its colours are taken as those of linear sRGB");
    }
}

/// The resolution line, such as `-Y 512 +X 1024`.
fn scan_order(text: &str) -> Result<ScanOrder> {
    let broken = || {
        Error::invalid(format!(
            "the resolution line of the Radiance file is '{}': expected two axes with their lengths, such as -Y 512 \
             +X 1024",
            text.chars().take(60).collect::<String>().escape_default()
        ))
    };
    let words: Vec<&str> = text.split_whitespace().collect();
    let &[first, lines, second, places] = &words[..] else { return Err(broken()) };
    let length = |word: &str| word.parse::<usize>().map_err(|_| broken());
    let (lines, places) = (length(lines)?, length(places)?);
    // The file's y points up, so rows from the top have a falling y.
    let axis = |word: &str| match word {
        "+X" => Some((true, false)),
        "-X" => Some((true, true)),
        "-Y" => Some((false, false)),
        "+Y" => Some((false, true)),
        _ => None,
    };
    match (axis(first), axis(second)) {
        (Some((false, from_bottom)), Some((true, from_right))) => {
            Ok(ScanOrder { size: Size::new(places, lines), by_columns: false, from_right, from_bottom })
        }
        (Some((true, from_right)), Some((false, from_bottom))) => {
            Ok(ScanOrder { size: Size::new(lines, places), by_columns: true, from_right, from_bottom })
        }
        _ => Err(broken()),
    }
}
