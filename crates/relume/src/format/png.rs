//! Still PNG pictures, and the settings that animated ones share.

use std::collections::BTreeMap;
use std::io::Cursor;

use super::kind::{Kind, damaged};
use crate::error::{Error, Result};
use crate::size::Size;

/// The encoder for pictures of 1 or 3 channels, or one more for the opacity, marked as sRGB.
pub(super) fn encoder<'a, W: std::io::Write + 'a>(
    out: W,
    size: Size,
    channels: usize,
    depth: ::png::BitDepth,
) -> Result<::png::Encoder<'a, W>> {
    let mut encoder = ::png::Encoder::new(out, side(size.width)?, side(size.height)?);
    encoder.set_color(color(channels));
    encoder.set_depth(depth);
    encoder.set_source_srgb(::png::SrgbRenderingIntent::RelativeColorimetric);
    encoder.set_compression(::png::Compression::Fast);
    Ok(encoder)
}

fn color(channels: usize) -> ::png::ColorType {
    match channels {
        1 => ::png::ColorType::Grayscale,
        2 => ::png::ColorType::GrayscaleAlpha,
        3 => ::png::ColorType::Rgb,
        _ => ::png::ColorType::Rgba,
    }
}

/// A PNG file of the given samples, 16-bit ones in big-endian order.
pub(super) fn encode(size: Size, channels: usize, depth: ::png::BitDepth, samples: &[u8]) -> Result<Vec<u8>> {
    let mut out = Vec::new();
    let mut writer = encoder(&mut out, size, channels, depth)?.write_header().map_err(failed)?;
    writer.write_image_data(samples).map_err(failed)?;
    writer.finish().map_err(failed)?;
    Ok(out)
}

/// A PNG file of data, which is not marked as sRGB, with text chunks before the image.
pub(super) fn encode_data(
    size: Size,
    channels: usize,
    (depth, samples): (::png::BitDepth, &[u8]),
    texts: &[(&str, String)],
) -> Result<Vec<u8>> {
    let mut out = Vec::new();
    let mut encoder = ::png::Encoder::new(&mut out, side(size.width)?, side(size.height)?);
    encoder.set_color(color(channels));
    encoder.set_depth(depth);
    for (keyword, text) in texts {
        encoder.add_text_chunk((*keyword).to_owned(), text.clone()).map_err(failed)?;
    }
    let mut writer = encoder.write_header().map_err(failed)?;
    writer.write_image_data(samples).map_err(failed)?;
    writer.finish().map_err(failed)?;
    Ok(out)
}

/// The plain text chunks before the image of a PNG file.
pub(super) fn texts(bytes: &[u8]) -> Result<BTreeMap<String, String>> {
    let reader = ::png::Decoder::new(Cursor::new(bytes)).read_info();
    let reader = reader.map_err(|_| damaged(Kind::Png))?;
    let chunks = reader.info().uncompressed_latin1_text.iter();
    Ok(chunks.map(|chunk| (chunk.keyword.clone(), chunk.text.clone())).collect())
}

/// The error of the encoder in the user's terms: the system's, or that of a size.
pub(super) fn failed(error: ::png::EncodingError) -> Error {
    match error {
        ::png::EncodingError::IoError(error) => Error::io("cannot write the PNG picture", &error),
        ::png::EncodingError::LimitsExceeded => {
            Error::limit("the PNG picture needs more memory than the limits allow: write a smaller one")
        }
        _ => Error::limit("a PNG file cannot hold a picture of this size: write EXR, or a smaller one"),
    }
}

fn side(texels: usize) -> Result<u32> {
    u32::try_from(texels)
        .map_err(|_| Error::limit(format!("a PNG picture has sides up to 4294967295 texels, not {texels}")))
}
