//! Pictures in the depth of their files: PNG and TIFF of CMYK colours by the `image` crate, others by readers of ours.

use std::io::Cursor;

use image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader};

use super::color::ColorTag;
use super::jpeg_read::JpegReader;
use super::kind::{Kind, damaged, unknown};
use super::meaning::Meaning;
use super::tiff::{self, TiffPicture};
use super::turned::turned;
use super::{color, complete, exr, finite, opacity, pfm, plausible, radiance};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::raster::{Raster, Samples};
use crate::size::Size;

/// The picture in the bytes of a file: PNG or TIFF of 8 or 16 bits, TIFF or EXR of floats, JPEG.
///
/// Samples keep their depth, and opacity is kept beside them. Palettes are expanded, EXIF orientation is
/// applied. What could not be taken as stored becomes a remark of the job.
///
/// # Errors
/// A file that is truncated, is of another kind or exceeds the limits.
pub fn decode_raster(bytes: &[u8], job: &Job) -> Result<Raster> {
    decode_as(bytes, Meaning::Colors, job)
}

/// What is said of inks: no profile of them is applied.
const PLAIN_CMYK: &str = "colours of four inks (CMYK) became RGB by the plain formula, without a profile: export the picture as RGB for \
                          true colours";

/// As [`decode_raster`], for values of a given meaning.
pub(super) fn decode_as(bytes: &[u8], meaning: Meaning, job: &Job) -> Result<Raster> {
    Ok(opacity::kept(decode_whole(bytes, meaning, job)?, meaning, job))
}

/// The picture with whatever alpha it has.
fn decode_whole(bytes: &[u8], meaning: Meaning, job: &Job) -> Result<Raster> {
    match Kind::of_texels(bytes)? {
        Kind::Ptm => Err(Error::unsupported(
            "the file is a polynomial texture map: expected a picture; relight it to make one",
        )),
        Kind::Hsh => Err(Error::unsupported(
            "the file is a texture of hemispherical harmonics: expected a picture; relight it to make one",
        )),
        Kind::Exr => exr::decode_picture(bytes, meaning, job),
        Kind::Png => {
            complete::check_png(bytes, job)?;
            decode_with(bytes, ImageFormat::Png, meaning, job)
        }
        Kind::Jpeg => {
            let frame = complete::check_jpeg(bytes)?;
            job.check_bytes("decoding the JPEG picture", frame.map_or(0, |frame| frame.working_bytes()))?;
            if frame.is_some_and(|frame| frame.is_cmyk()) {
                job.remark(PLAIN_CMYK);
            }
            let mut decoder = JpegReader::new(bytes).map_err(|error| explain(ImageFormat::Jpeg, &error))?;
            let fits = decoder.set_limits(decoder_limits(job));
            fits.map_err(|error| explain(ImageFormat::Jpeg, &error))?;
            picture(decoder, bytes, ImageFormat::Jpeg, meaning, job)
        }
        Kind::Tiff => match tiff::decode(bytes, job)? {
            Some(TiffPicture { raster, profile }) => {
                let tag = profile.map_or(ColorTag::Silent, |profile| ColorTag::of_icc(&profile));
                Ok(color::in_srgb(raster, &tag, meaning, job))
            }
            None => {
                job.remark(PLAIN_CMYK);
                decode_with(bytes, ImageFormat::Tiff, meaning, job)
            }
        },
        Kind::Pfm => pfm::decode(bytes, job),
        Kind::Radiance => radiance::decode(bytes, job),
        Kind::Rlm | Kind::Npy | Kind::Glb | Kind::Btf | Kind::Bsdf | Kind::Merl => Err(unknown(bytes)),
    }
}

fn decode_with(bytes: &[u8], format: ImageFormat, meaning: Meaning, job: &Job) -> Result<Raster> {
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    reader.limits(decoder_limits(job));
    let decoder = reader.into_decoder().map_err(|error| explain(format, &error))?;
    picture(decoder, bytes, format, meaning, job)
}

/// The picture that a decoder reads from the bytes of a file.
fn picture(
    mut decoder: impl ImageDecoder,
    bytes: &[u8],
    format: ImageFormat,
    meaning: Meaning,
    job: &Job,
) -> Result<Raster> {
    let explain = |error| explain(format, &error);
    let (width, height) = decoder.dimensions();
    let bytes_per_texel = u64::from(decoder.color_type().bytes_per_pixel());
    let size = Size::new(width as usize, height as usize);
    job.check("the picture", size, bytes_per_texel)?;
    if format == ImageFormat::Png {
        let rows = png_working_bytes(u64::from(width) * bytes_per_texel);
        job.check_bytes("decoding the PNG picture", size.texels() as u64 * bytes_per_texel + rows)?;
    }
    if format == ImageFormat::Tiff {
        let found = bytes.len() as u64;
        plausible::check("TIFF", size, size.texels() as u64 * bytes_per_texel, found, plausible::LZW)?;
    }
    let orientation = decoder.orientation().map_err(explain)?;
    let tag = match format {
        ImageFormat::Png => color::tag_of_png(bytes),
        _ => decoder.icc_profile().ok().flatten().map_or(ColorTag::Silent, |icc| ColorTag::of_icc(&icc)),
    };
    let image = DynamicImage::from_decoder(decoder).map_err(explain)?;
    let raster = turned(raster_from(image)?, orientation.to_exif().into())?;
    Ok(color::in_srgb(raster, &tag, meaning, job))
}

/// The most that the decoder of PNG holds of inflated rows: it moves them to the start of its buffer after four
/// rows or 128 KiB, and doubles a buffer that is too small.
fn png_working_bytes(row_bytes: u64) -> u64 {
    3 * ((4 * row_bytes).max(128 << 10) + 3 * row_bytes + (16 << 10))
}

/// What the header of a picture claims.
pub(super) struct PictureHead {
    pub size: Size,
    pub channels: u64,
    /// Bytes of a texel as stored.
    pub texel_bytes: u64,
}

/// The head of a PNG, JPEG or TIFF file, so that one that is too large is refused before it is decoded; `None` where
/// it cannot be read, which decoding explains.
pub(super) fn head(bytes: &[u8]) -> Option<PictureHead> {
    let format = match Kind::of(bytes)? {
        Kind::Png => ImageFormat::Png,
        Kind::Jpeg => ImageFormat::Jpeg,
        Kind::Tiff => ImageFormat::Tiff,
        _ => return None,
    };
    let decoder = ImageReader::with_format(Cursor::new(bytes), format).into_decoder().ok()?;
    let (width, height) = decoder.dimensions();
    let color = decoder.color_type();
    Some(PictureHead {
        size: Size::new(width as usize, height as usize),
        channels: if color.has_color() { 3 } else { 1 },
        texel_bytes: u64::from(color.bytes_per_pixel()),
    })
}

/// The orientation that a camera recorded (EXIF tag 0x0112), 1 where it recorded none.
pub(super) fn orientation(bytes: &[u8]) -> u16 {
    let format = match Kind::of(bytes) {
        Some(Kind::Png) => ImageFormat::Png,
        Some(Kind::Jpeg) => ImageFormat::Jpeg,
        Some(Kind::Tiff) => ImageFormat::Tiff,
        _ => return 1,
    };
    let decoder = ImageReader::with_format(Cursor::new(bytes), format).into_decoder();
    let recorded = decoder.ok().and_then(|mut decoder| decoder.orientation().ok());
    recorded.map_or(1, |orientation| u16::from(orientation.to_exif()))
}

fn decoder_limits(job: &Job) -> image::Limits {
    let side = u32::try_from(job.limits().max_side).unwrap_or(u32::MAX);
    let mut bounds = image::Limits::default();
    bounds.max_image_width = Some(side);
    bounds.max_image_height = Some(side);
    bounds.max_alloc = Some(job.limits().max_bytes);
    bounds
}

/// A decoder's error in the user's terms.
fn explain(format: ImageFormat, error: &ImageError) -> Error {
    let kind = match format {
        ImageFormat::Png => Kind::Png,
        ImageFormat::Jpeg => Kind::Jpeg,
        _ => Kind::Tiff,
    };
    match error {
        ImageError::Unsupported(error) => unsupported(kind, &error.to_string()),
        ImageError::Limits(_) => Error::limit(format!(
            "the {} picture needs more memory or longer sides than the limits allow",
            kind.name()
        )),
        _ => damaged(kind),
    }
}

/// What is not read, by the words that the decoders have for it.
fn unsupported(kind: Kind, words: &str) -> Error {
    let known = [
        ("CMYK", "CMYK colours in planes"),
        ("ycck", "YCCK colours"),
        ("rithmetic", "arithmetic coding"),
        ("ossless", "lossless JPEG"),
    ];
    let what = known.iter().find(|(word, _)| words.contains(word));
    let what = what.map_or("samples stored in this way", |(_, what)| what);
    Error::unsupported(format!(
        "{what} are not read from {} files: export the picture as grey or RGB of 8 or 16 bits",
        kind.name()
    ))
}

fn raster_from(image: DynamicImage) -> Result<Raster> {
    let size = Size::new(image.width() as usize, image.height() as usize);
    fn opaque(samples: Samples) -> (Samples, Option<Samples>) {
        (samples, None)
    }
    fn translucent<T: Copy>(
        texels: &[T],
        channels: usize,
        kind: fn(Vec<T>) -> Samples,
    ) -> (Samples, Option<Samples>) {
        let (samples, alphas) = opacity::split(texels, channels);
        (kind(samples), Some(kind(alphas)))
    }
    let channels = if image.color().has_color() { 3 } else { 1 };
    let (samples, alphas) = match image {
        DynamicImage::ImageLuma8(b) => opaque(Samples::U8(b.into_raw())),
        DynamicImage::ImageLumaA8(b) => translucent(&b, 1, Samples::U8),
        DynamicImage::ImageRgb8(b) => opaque(Samples::U8(b.into_raw())),
        DynamicImage::ImageRgba8(b) => translucent(&b, 3, Samples::U8),
        DynamicImage::ImageLuma16(b) => opaque(Samples::U16(b.into_raw())),
        DynamicImage::ImageLumaA16(b) => translucent(&b, 1, Samples::U16),
        DynamicImage::ImageRgb16(b) => opaque(Samples::U16(b.into_raw())),
        DynamicImage::ImageRgba16(b) => translucent(&b, 3, Samples::U16),
        DynamicImage::ImageRgb32F(b) => opaque(Samples::F32(b.into_raw())),
        DynamicImage::ImageRgba32F(b) => translucent(&b, 3, Samples::F32),
        _ => {
            return Err(Error::unsupported(
                "samples of this kind are not read: export the picture as grey or RGB of 8 or 16 bits",
            ));
        }
    };
    if let Samples::F32(samples) = &samples {
        let names: &[&str] = if channels == 1 { &["Y"] } else { &["R", "G", "B"] };
        finite::check(samples, size, |i| names[i % channels], |i| i / channels)?;
    }
    let raster = Raster::new(size, channels, samples)?;
    match alphas {
        Some(alphas) => raster.with_opacity(alphas),
        None => Ok(raster),
    }
}
