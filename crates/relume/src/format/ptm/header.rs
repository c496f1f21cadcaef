//! The text before the coefficients of a `.ptm` file.
//!
//! Sixteen words: version, format, width, height, six scales, six biases. The format specifies five or six
//! lines; any white space between the words is accepted. `LUM` adds the sixteen numbers of a matrix, and the
//! compressed formats one line of quality and seven of a number for each plane. The coefficients follow the newline that
//! ends the last line.

use super::PtmEncoding;
use super::jpeg::JpegPlanes;
use super::words::Words;
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
    /// A block of six bytes of luminance per texel, then one of two bytes, Cr and Cb.
    LumBlocks,
    /// Eight bytes per texel: luminance, then Cr and Cb.
    LumInterleaved,
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
            Self::LumBlocks | Self::LumInterleaved => 8,
        }
    }

    /// The planes of bytes: of coefficients, and of colours.
    pub(super) fn planes(self) -> usize {
        self.bytes_per_texel()
    }

    /// Whether plane `k` holds colours, not coefficients.
    pub(super) fn is_color(self, k: usize) -> bool {
        self != Self::Rgb && k >= 6
    }

    /// The positions of plane `k` of bytes in the payload of `texels` texels.
    pub(super) fn comb(self, k: usize, texels: usize) -> Comb {
        match self {
            Self::Rgb => Comb { start: (k / 6) * 6 * texels + k % 6, stride: 6 },
            Self::LrgbBlocks if k < 6 => Comb { start: k, stride: 6 },
            Self::LrgbBlocks => Comb { start: 6 * texels + k - 6, stride: 3 },
            Self::LrgbInterleaved => Comb { start: k, stride: 9 },
            Self::LumBlocks if k < 6 => Comb { start: k, stride: 6 },
            Self::LumBlocks => Comb { start: 6 * texels + k - 6, stride: 2 },
            Self::LumInterleaved => Comb { start: k, stride: 8 },
        }
    }
}

/// The contents of the header.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Header {
    /// The arrangement, if need be after decompression.
    pub layout: Layout,
    pub size: Size,
    pub encoding: PtmEncoding,
    /// Where planes are compressed, how.
    pub jpeg: Option<JpegPlanes>,
    /// Of `LUM` files: red, green and blue from luminance, Cr, Cb and 1, row after row.
    pub matrix: Option<[f32; 16]>,
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

/// What the header of a file of a format goes on with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum More {
    Nothing,
    Jpeg,
    Matrix,
}

impl Header {
    pub(super) fn parse(bytes: &[u8]) -> Result<Self> {
        let mut words = Words::of(bytes);
        let (layout, more) = format(&mut words)?;
        let size = Size::new(words.side("the width")?, words.side("the height")?);
        let scale = words.numbers("scale", check_scale)?;
        let bias = words.numbers("bias", check_bias)?;
        let jpeg =
            (more == More::Jpeg).then(|| JpegPlanes::parse(&mut words, layout.planes())).transpose()?;
        let entry = |n: f32| if n.abs() <= 1e6 { Ok(()) } else { Err("expected a number of at most 1e6") };
        let matrix = (more == More::Matrix).then(|| words.numbers("matrix entry", entry)).transpose()?;
        let payload = words.end_of_line(match more {
            More::Nothing => "the sixth bias",
            More::Jpeg => "the last size of side information",
            More::Matrix => "the last matrix entry",
        })?;
        Ok(Self { layout, size, encoding: PtmEncoding { scale, bias }, jpeg, matrix, payload })
    }
}

/// The arrangement named by version and format.
fn format(words: &mut Words<'_>) -> Result<(Layout, More)> {
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
    match (format.as_str(), interleaved) {
        ("PTM_FORMAT_RGB", _) => Ok((Layout::Rgb, More::Nothing)),
        ("PTM_FORMAT_LRGB", false) => Ok((Layout::LrgbBlocks, More::Nothing)),
        ("PTM_FORMAT_LRGB", true) => Ok((Layout::LrgbInterleaved, More::Nothing)),
        ("PTM_FORMAT_LUM", false) => Ok((Layout::LumBlocks, More::Matrix)),
        ("PTM_FORMAT_LUM", true) => Ok((Layout::LumInterleaved, More::Matrix)),
        ("PTM_FORMAT_JPEG_RGB", _) => Ok((Layout::Rgb, More::Jpeg)),
        ("PTM_FORMAT_JPEG_LRGB", _) => Ok((Layout::LrgbBlocks, More::Jpeg)),
        (other, _) => Err(other_format(other)),
    }
}

fn other_format(name: &str) -> Error {
    const KNOWN: [&str; 4] = ["PTM_FORMAT_", "PTM_C_LUT", "PTM_LUT", "JPEGLS_"];
    if KNOWN.iter().any(|prefix| name.starts_with(prefix)) {
        return Error::unsupported(format!(
            "texture maps of the format {name} are not read: convert the file to PTM_FORMAT_RGB or \
             PTM_FORMAT_LRGB"
        ));
    }
    Error::invalid(format!(
        "the format of the texture map is '{name}': expected PTM_FORMAT_RGB or PTM_FORMAT_LRGB, plain or as JPEG, \
         or PTM_FORMAT_LUM"
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
