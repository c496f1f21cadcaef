//! The text before the coefficients of a `.ptm` file.
//!
//! Sixteen words: version, format, width, height, six scales, six biases. The format specifies five or six
//! lines; any white space between the words is accepted. The coefficients follow the newline that ends the
//! last line.

use super::PtmEncoding;
use crate::error::{Error, Result};
use crate::size::Size;

/// The arrangement of the bytes of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Layout {
    /// Three blocks of six bytes per texel.
    Rgb,
    /// A block of six bytes of luminance per texel, then one of three bytes of colour.
    LrgbBlocks,
    /// Nine bytes per texel: luminance, then colour, as in versions before 1.2.
    LrgbInterleaved,
}

/// The positions of the bytes of one plane in the payload: `start`, `start + stride`, ...
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Comb {
    pub start: usize,
    pub stride: usize,
}

impl Layout {
    pub(super) fn bytes_per_texel(self) -> usize {
        match self {
            Self::Rgb => 18,
            Self::LrgbBlocks | Self::LrgbInterleaved => 9,
        }
    }

    /// The positions of plane `k` of the field in the payload of `texels` texels.
    pub(super) fn comb(self, k: usize, texels: usize) -> Comb {
        match self {
            Self::Rgb => Comb { start: (k / 6) * 6 * texels + k % 6, stride: 6 },
            Self::LrgbBlocks if k < 6 => Comb { start: k, stride: 6 },
            Self::LrgbBlocks => Comb { start: 6 * texels + k - 6, stride: 3 },
            Self::LrgbInterleaved => Comb { start: k, stride: 9 },
        }
    }
}

/// The contents of the header.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Header {
    pub layout: Layout,
    pub size: Size,
    pub encoding: PtmEncoding,
    /// The first byte of the coefficients.
    pub payload: usize,
}

/// The header of a file of version 1.2, with width and height on separate lines, which old viewers need.
pub(super) fn to_text(format: &str, size: Size, encoding: &PtmEncoding) -> String {
    let line = |numbers: [f32; 6]| numbers.map(|n| n.to_string()).join(" ");
    let Size { width, height } = size;
    let (scale, bias) = (line(encoding.scale), line(encoding.bias));
    format!("PTM_1.2\n{format}\n{width}\n{height}\n{scale}\n{bias}\n")
}

impl Header {
    pub(super) fn parse(bytes: &[u8]) -> Result<Self> {
        let mut words = Words { bytes, at: 0 };
        let (version, _) = words.next("the version")?;
        let interleaved = match version.as_str() {
            "PTM_1.2" => false,
            "PTM_1.1" | "PTM_1.0" => true,
            other => {
                return Err(Error::unsupported(format!(
                    "the texture map has version '{other}': expected PTM_1.0, PTM_1.1 or PTM_1.2"
                )));
            }
        };
        let (format, _) = words.next("the format")?;
        let layout = match (format.as_str(), interleaved) {
            ("PTM_FORMAT_RGB", _) => Layout::Rgb,
            ("PTM_FORMAT_LRGB", false) => Layout::LrgbBlocks,
            ("PTM_FORMAT_LRGB", true) => Layout::LrgbInterleaved,
            (other, _) => return Err(other_format(other)),
        };
        let size = Size::new(words.side("the width")?, words.side("the height")?);
        let scale = words.six("scale", check_scale)?;
        let bias = words.six("bias", check_bias)?;
        let payload = words.end_of_line()?;
        Ok(Self { layout, size, encoding: PtmEncoding { scale, bias }, payload })
    }
}

fn other_format(name: &str) -> Error {
    const KNOWN: [&str; 3] = ["PTM_FORMAT_", "PTM_C_LUT", "JPEGLS_"];
    if KNOWN.iter().any(|prefix| name.starts_with(prefix)) {
        return Error::unsupported(format!(
            "texture maps of the format {name} are not read: convert the file to PTM_FORMAT_RGB or \
             PTM_FORMAT_LRGB"
        ));
    }
    Error::invalid(format!(
        "the format of the texture map is '{name}': expected PTM_FORMAT_RGB or PTM_FORMAT_LRGB"
    ))
}

/// Refuses scales for which single precision cannot restore a byte.
fn check_scale(scale: f32) -> Result<(), &'static str> {
    match scale.abs() {
        0.0 => Err("a scale of zero leaves nothing of the coefficient, so the file is broken"),
        s if (1e-20..=1e20).contains(&s) => Ok(()),
        _ => Err("expected a number between 1e-20 and 1e20 in size"),
    }
}

fn check_bias(bias: f32) -> Result<(), &'static str> {
    match bias.abs() {
        b if b <= 1_048_576.0 => Ok(()),
        _ => Err("expected a number between -1048576 and 1048576"),
    }
}

/// Words separated by white space.
struct Words<'a> {
    bytes: &'a [u8],
    at: usize,
}

/// The longest word of a header; numbers and names are far shorter.
const LONGEST_WORD: usize = 64;

impl Words<'_> {
    /// The next word and its first byte position.
    fn next(&mut self, what: &str) -> Result<(String, usize)> {
        let rest = &self.bytes[self.at..];
        let blank = rest.iter().take_while(|byte| byte.is_ascii_whitespace()).count();
        let word = rest[blank..].iter().take_while(|byte| !byte.is_ascii_whitespace());
        let word: Vec<u8> = word.copied().take(LONGEST_WORD).collect();
        let start = self.at + blank;
        self.at = start + word.len();
        if word.is_empty() {
            return Err(Error::invalid(format!(
                "the texture map ends at byte {start}, where {what} was expected: the file is truncated"
            )));
        }
        Ok((String::from_utf8_lossy(&word).escape_debug().to_string(), start))
    }

    fn side(&mut self, what: &str) -> Result<usize> {
        let (word, at) = self.next(what)?;
        match word.parse() {
            Ok(side) if side > 0 => Ok(side),
            _ => Err(Error::invalid(format!(
                "{what} of the texture map, at byte {at}, is '{word}': expected a whole number above 0"
            ))),
        }
    }

    /// Six numbers that `check` accepts.
    fn six(&mut self, what: &str, check: impl Fn(f32) -> Result<(), &'static str>) -> Result<[f32; 6]> {
        let mut numbers = [0.0; 6];
        for (k, number) in numbers.iter_mut().enumerate() {
            let which = format!("{what} {} of 6", k + 1);
            let (word, at) = self.next(&which)?;
            let parsed = word.parse::<f32>().map_err(|_| "expected a number");
            *number = parsed.and_then(|n| check(n).map(|()| n)).map_err(|reason| {
                Error::invalid(format!("{which} of the texture map, at byte {at}, is '{word}': {reason}"))
            })?;
        }
        Ok(numbers)
    }

    /// The byte after the newline that ends the last line.
    fn end_of_line(&self) -> Result<usize> {
        let rest = &self.bytes[self.at..];
        let blank = rest.iter().take_while(|byte| matches!(byte, b' ' | b'\t' | b'\r')).count();
        match rest.get(blank) {
            Some(b'\n') => Ok(self.at + blank + 1),
            _ => Err(Error::invalid(format!(
                "the texture map has no end of line at byte {}, after the sixth bias",
                self.at + blank
            ))),
        }
    }
}
