//! Pictures as their files store them: PNG, JPEG and TIFF by the `image` crate, EXR by ours.

use std::io::Cursor;

use image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader};

use super::kind::{Kind, complaint, unknown};
use super::{complete, exr};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::planes::Size;
use crate::raster::{Raster, Samples};

/// The picture in the bytes of a file: PNG or TIFF of 8 or 16 bits, TIFF or EXR of floats, JPEG.
///
/// Samples keep their depth. Alpha is dropped, palettes are expanded, EXIF orientation is applied.
///
/// # Errors
/// A file that is truncated, is of another kind or exceeds the job.
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
            complete::check_jpeg(bytes)?;
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

/// A decoder's complaint as one of our sentences.
fn explain(format: ImageFormat, error: &ImageError) -> Error {
    let kind = match format {
        ImageFormat::Png => Kind::Png,
        ImageFormat::Jpeg => Kind::Jpeg,
        _ => Kind::Tiff,
    };
    let sentence = complaint(kind, error);
    match error {
        ImageError::Unsupported(_) => Error::unsupported(sentence),
        ImageError::Limits(_) => Error::limit(sentence),
        _ => Error::invalid(sentence),
    }
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
            return Err(Error::unsupported(format!(
                "pictures of samples {:?} are not read: expected grey or RGB of 8 or 16 bits",
                other.color()
            )));
        }
    };
    Raster::new(size, channels, samples)
}

/// The samples of texels of `channels` + 1 samples without the last.
fn without_alpha<T: Copy>(samples: &[T], channels: usize) -> Vec<T> {
    samples.chunks_exact(channels + 1).flat_map(|texel| &texel[..channels]).copied().collect()
}
