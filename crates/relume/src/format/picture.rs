//! Pictures to files. Integer formats are sRGB-encoded, EXR, PFM and Radiance are linear.

use std::io::Cursor;
use std::path::Path;

use image::codecs::tiff::TiffEncoder;
use image::{ExtendedColorType, ImageEncoder};

use super::exr::{self, ExrDepth};
use super::jpeg::{self, JPEG_QUALITY};
use super::{codes, pfm, png, radiance};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::memory;
use crate::picture::Picture;
use crate::planes::Planes;
use crate::size::Size;
use crate::space::Space;

/// Bits of an integer sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Depth {
    /// 8 bits.
    Eight,
    /// 16 bits.
    Sixteen,
}

/// A file format of pictures, with its depth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PictureFormat {
    /// PNG, marked as sRGB.
    Png(Depth),
    /// JPEG of full colour resolution; the quality is 1 to 100.
    Jpeg {
        /// 1 (smallest file) to 100.
        quality: u8,
    },
    /// TIFF, not compressed.
    Tiff(Depth),
    /// EXR, linear.
    Exr(ExrDepth),
    /// Portable FloatMap, linear.
    Pfm,
    /// Radiance RGBE, linear, always of three channels.
    Radiance,
}

/// Room for the tags of a TIFF file, and the places of its strips, for any picture of usual shape.
const TIFF_HEAD_BYTES: usize = 1 << 14;

impl PictureFormat {
    /// The format of an extension: 8 bits if there is a choice, floats for EXR.
    ///
    /// # Errors
    /// When the extension is none of `png`, `jpg`, `jpeg`, `tif`, `tiff`, `exr`, `pfm`, `hdr`, `pic`.
    pub fn from_path(path: &Path) -> Result<Self> {
        match extension(path).as_str() {
            "png" => Ok(Self::Png(Depth::Eight)),
            "jpg" | "jpeg" => Ok(Self::Jpeg { quality: JPEG_QUALITY }),
            "tif" | "tiff" => Ok(Self::Tiff(Depth::Eight)),
            "exr" => Ok(Self::Exr(ExrDepth::Float)),
            "pfm" => Ok(Self::Pfm),
            "hdr" | "pic" => Ok(Self::Radiance),
            other => Err(Error::usage(format!(
                "no picture format has the extension '{other}': name the file .png, .jpg, .tif, .exr, .pfm or .hdr"
            ))
            .at(path)),
        }
    }

    /// The same format with the given depth, if it has a choice.
    #[must_use]
    pub fn with_depth(self, depth: Depth) -> Self {
        match self {
            Self::Png(_) => Self::Png(depth),
            Self::Tiff(_) => Self::Tiff(depth),
            Self::Jpeg { .. } | Self::Exr(_) | Self::Pfm | Self::Radiance => self,
        }
    }
}

/// The extension of a path in lower case; empty if there is none.
pub(super) fn extension(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
}

/// The bytes of a picture file. Integer codes are sRGB-encoded, rounded to nearest without
/// dithering and clamped, NaN is 0; EXR, PFM and Radiance files get linear values.
///
/// # Errors
/// When the picture does not fit the format: neither one nor three channels, a JPEG with a side
/// over 65,535 texels, a quality outside 1 to 100.
pub fn encode_picture(picture: &Picture, format: PictureFormat) -> Result<Vec<u8>> {
    encode_picture_with(picture, format, &Job::unlimited())
}

/// [`encode_picture`] as a part of a job.
///
/// # Errors
/// As [`encode_picture`]; limits exceeded, and a cancelled job.
pub fn encode_picture_with(picture: &Picture, format: PictureFormat, job: &Job) -> Result<Vec<u8>> {
    encode_with(picture, None, format, job)
}

/// As [`encode_picture_with`], with an opacity of one plane from 0 to 1, which JPEG, PFM, Radiance and EXR
/// pictures leave out.
pub(super) fn encode_with(
    picture: &Picture,
    opacity: Option<&Planes>,
    format: PictureFormat,
    job: &Job,
) -> Result<Vec<u8>> {
    let (size, channels) = (picture.size(), picture.planes.count());
    if !matches!(channels, 1 | 3) {
        return Err(Error::invalid(format!("a picture has 1 or 3 channels, not {channels}")));
    }
    job.check_bytes("writing the picture", format.footprint(size, channels).peak)?;
    match format {
        PictureFormat::Png(depth) => {
            let (channels, samples) = samples(picture, opacity, depth, u16::to_be_bytes, job)?;
            png::encode(size, channels, bit_depth(depth), &samples)
        }
        PictureFormat::Jpeg { quality } => encode_jpeg(picture, quality, job),
        PictureFormat::Tiff(depth) => encode_tiff(picture, opacity, depth, job),
        PictureFormat::Pfm => Ok(pfm::encode(&picture.to_space(Space::Linear))),
        PictureFormat::Radiance => Ok(radiance::encode(&picture.to_space(Space::Linear))),
        PictureFormat::Exr(depth) => exr::encode_picture(&picture.to_space(Space::Linear), depth, job),
    }
}

/// The samples of a PNG file of an opaque picture.
pub(super) fn png_samples(picture: &Picture, depth: Depth, job: &Job) -> Result<(::png::BitDepth, Vec<u8>)> {
    Ok((bit_depth(depth), samples(picture, None, depth, u16::to_be_bytes, job)?.1))
}

fn bit_depth(depth: Depth) -> ::png::BitDepth {
    match depth {
        Depth::Eight => ::png::BitDepth::Eight,
        Depth::Sixteen => ::png::BitDepth::Sixteen,
    }
}

/// The number of channels, the opacity among them, and the bytes of interleaved codes.
fn samples(
    picture: &Picture,
    opacity: Option<&Planes>,
    depth: Depth,
    order: fn(u16) -> [u8; 2],
    job: &Job,
) -> Result<(usize, Vec<u8>)> {
    let channels = picture.planes.count();
    let alphas = opacity.map(|opacity| opacity.plane(0));
    Ok(match depth {
        Depth::Eight => {
            let codes = codes::interleaved8(picture, job)?;
            let Some(alphas) = alphas else { return Ok((channels, codes)) };
            let joined = codes.chunks_exact(channels).zip(alphas).flat_map(|(texel, &alpha)| {
                texel.iter().copied().chain(std::iter::once(codes::code8(alpha)))
            });
            (channels + 1, joined.collect())
        }
        Depth::Sixteen => {
            let codes = codes::interleaved16(picture, job)?;
            let Some(alphas) = alphas else { return Ok((channels, bytes_of(&codes, order))) };
            let joined = codes.chunks_exact(channels).zip(alphas).flat_map(|(texel, &alpha)| {
                texel.iter().copied().chain(std::iter::once(codes::code16(alpha)))
            });
            (channels + 1, bytes_of(&joined.collect::<Vec<_>>(), order))
        }
    })
}

fn encode_jpeg(picture: &Picture, quality: u8, job: &Job) -> Result<Vec<u8>> {
    jpeg::check(picture.size(), quality)?;
    jpeg::encode(&codes::interleaved8(picture, job)?, picture.size(), picture.planes.count(), quality)
}

fn encode_tiff(picture: &Picture, opacity: Option<&Planes>, depth: Depth, job: &Job) -> Result<Vec<u8>> {
    let Size { width, height } = picture.size();
    let sides = u32::try_from(width).ok().zip(u32::try_from(height).ok());
    let (width, height) = sides.ok_or_else(|| {
        Error::usage(format!("a TIFF picture has sides up to 4294967295 texels, not {width} x {height}"))
    })?;
    // The encoder knows no grey with an opacity.
    let in_color = (opacity.is_some() && picture.planes.count() == 1).then(|| colored(picture));
    let shown = in_color.as_ref().unwrap_or(picture);
    let (channels, samples) = samples(shown, opacity, depth, u16::to_ne_bytes, job)?;
    let mut out = Cursor::new(memory::with_capacity("the TIFF file", samples.len() + TIFF_HEAD_BYTES)?);
    TiffEncoder::new(&mut out)
        .write_image(&samples, width, height, color_type(channels, depth))
        .map_err(|_| unwritable("TIFF", picture.size()))?;
    Ok(out.into_inner())
}

/// A grey picture as RGB.
fn colored(grey: &Picture) -> Picture {
    let samples = [grey.planes.plane(0); 3].concat();
    let planes = Planes::from_vec(grey.size(), 3, samples).expect("three planes of one size");
    Picture { planes, space: grey.space }
}

/// The error of an encoder that writes to memory: only a size can be at fault.
pub(super) fn unwritable(kind: &str, size: Size) -> Error {
    Error::limit(format!("a {kind} file cannot hold a picture of {size} texels: write EXR, or a smaller one"))
}

fn color_type(channels: usize, depth: Depth) -> ExtendedColorType {
    match (channels, depth) {
        (1, Depth::Eight) => ExtendedColorType::L8,
        (1, Depth::Sixteen) => ExtendedColorType::L16,
        (4, Depth::Eight) => ExtendedColorType::Rgba8,
        (4, Depth::Sixteen) => ExtendedColorType::Rgba16,
        (_, Depth::Eight) => ExtendedColorType::Rgb8,
        (_, Depth::Sixteen) => ExtendedColorType::Rgb16,
    }
}

fn bytes_of(samples: &[u16], order: impl Fn(u16) -> [u8; 2]) -> Vec<u8> {
    samples.iter().flat_map(|&sample| order(sample)).collect()
}
