//! Pictures in the depth of their files: PNG, JPEG and TIFF by the `image` crate, EXR by ours.

use std::io::Cursor;

use image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader};

use super::kind::{Kind, damaged, unknown};
use super::{complete, exr, finite, plausible};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::raster::{Raster, Samples};
use crate::size::Size;

/// The picture in the bytes of a file: PNG or TIFF of 8 or 16 bits, TIFF or EXR of floats, JPEG.
///
/// Samples keep their depth. Alpha is dropped, palettes are expanded, EXIF orientation is applied.
///
/// # Errors
/// A file that is truncated, is of another kind or exceeds the limits.
pub fn decode_raster(bytes: &[u8], job: &Job) -> Result<Raster> {
    match Kind::of_texels(bytes)? {
        Kind::Ptm => Err(Error::unsupported(
            "the file is a polynomial texture map: expected a picture; relight it to make one",
        )),
        Kind::Exr => exr::decode_picture(bytes, job),
        Kind::Png => {
            complete::check_png(bytes)?;
            decode_with(bytes, ImageFormat::Png, job)
        }
        Kind::Jpeg => {
            let frame = complete::check_jpeg(bytes)?;
            job.check_bytes("decoding the JPEG picture", frame.map_or(0, |frame| frame.working_bytes()))?;
            decode_with(bytes, ImageFormat::Jpeg, job)
        }
        Kind::Tiff => decode_with(bytes, ImageFormat::Tiff, job),
        Kind::Rlm | Kind::Npy | Kind::Glb => Err(unknown(bytes)),
    }
}

fn decode_with(bytes: &[u8], format: ImageFormat, job: &Job) -> Result<Raster> {
    let explain = |error| explain(format, &error);
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    reader.limits(decoder_limits(job));
    let mut decoder = reader.into_decoder().map_err(explain)?;
    let (width, height) = decoder.dimensions();
    let bytes_per_texel = u64::from(decoder.color_type().bytes_per_pixel());
    job.check("the picture", Size::new(width as usize, height as usize), bytes_per_texel)?;
    if format == ImageFormat::Tiff {
        let (size, found) = (Size::new(width as usize, height as usize), bytes.len() as u64);
        plausible::check("TIFF", size, size.texels() as u64 * bytes_per_texel, found, plausible::LZW)?;
    }
    let orientation = decoder.orientation().map_err(explain)?;
    let mut image = DynamicImage::from_decoder(decoder).map_err(explain)?;
    image.apply_orientation(orientation);
    raster_from(image)
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
        ("YCbCr", "colours stored as YCbCr"),
        ("Palette", "palettes"),
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
    let (channels, samples) = match image {
        DynamicImage::ImageLuma8(b) => (1, Samples::U8(b.into_raw())),
        DynamicImage::ImageLumaA8(b) => (1, Samples::U8(without_alpha(&b.into_raw(), 1))),
        DynamicImage::ImageRgb8(b) => (3, Samples::U8(b.into_raw())),
        DynamicImage::ImageRgba8(b) => (3, Samples::U8(without_alpha(&b.into_raw(), 3))),
        DynamicImage::ImageLuma16(b) => (1, Samples::U16(b.into_raw())),
        DynamicImage::ImageLumaA16(b) => (1, Samples::U16(without_alpha(&b.into_raw(), 1))),
        DynamicImage::ImageRgb16(b) => (3, Samples::U16(b.into_raw())),
        DynamicImage::ImageRgba16(b) => (3, Samples::U16(without_alpha(&b.into_raw(), 3))),
        DynamicImage::ImageRgb32F(b) => (3, Samples::F32(b.into_raw())),
        DynamicImage::ImageRgba32F(b) => (3, Samples::F32(without_alpha(&b.into_raw(), 3))),
        other => {
            let channels = other.color().channel_count();
            return Err(Error::unsupported(format!(
                "pictures of {channels} channels stored in this way are not read: expected grey or RGB of 8 or 16 bits"
            )));
        }
    };
    if let Samples::F32(samples) = &samples {
        let names: &[&str] = if channels == 1 { &["Y"] } else { &["R", "G", "B"] };
        finite::check(samples, size, |i| names[i % channels], |i| i / channels)?;
    }
    Raster::new(size, channels, samples)
}

/// The samples of texels of `channels` + 1 samples without the last of each.
fn without_alpha<T: Copy>(samples: &[T], channels: usize) -> Vec<T> {
    samples.chunks_exact(channels + 1).flat_map(|texel| &texel[..channels]).copied().collect()
}
