//! JPEG files as decoders of the `image` crate, over `zune-jpeg` directly.
//!
//! The decoder of that crate does the same, but its code of scans is compiled with that crate, which is optimised less
//! than this one (see the profiles in `Cargo.toml`): it took a fifth longer.

use image::error::{DecodingError, LimitError, LimitErrorKind, UnsupportedError, UnsupportedErrorKind};
use image::{ColorType, ImageDecoder, ImageError, ImageFormat, ImageResult, Limits};
use zune_jpeg::JpegDecoder;
use zune_jpeg::errors::DecodeErrors;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

/// The bytes of a file. A type of this crate's own: what decodes `&[u8]` is taken from the `image` crate's code.
struct JpegBytes<'a>(&'a [u8]);

impl AsRef<[u8]> for JpegBytes<'_> {
    fn as_ref(&self) -> &[u8] {
        self.0
    }
}

/// A file whose header is read.
pub(super) struct JpegReader<'a> {
    bytes: &'a [u8],
    header: JpegDecoder<ZCursor<JpegBytes<'a>>>,
    size: (u32, u32),
    /// Of the samples decoded.
    colors: ColorSpace,
}

impl<'a> JpegReader<'a> {
    /// # Errors
    /// A header that is damaged or not supported.
    pub(super) fn new(bytes: &'a [u8]) -> ImageResult<Self> {
        let mut header = decoder(bytes, options());
        header.decode_headers().map_err(|error| failure(&error))?;
        let (Some((width, height)), Some(colors)) = (header.dimensions(), header.input_colorspace()) else {
            return Err(failure(&DecodeErrors::FormatStatic("a file without a frame")));
        };
        let is_kept = matches!(colors, ColorSpace::RGB | ColorSpace::Luma);
        let colors = if is_kept { colors } else { ColorSpace::RGB };
        Ok(Self { bytes, header, size: (width as u32, height as u32), colors })
    }
}

fn decoder(bytes: &[u8], options: DecoderOptions) -> JpegDecoder<ZCursor<JpegBytes<'_>>> {
    JpegDecoder::new_with_options(ZCursor::new(JpegBytes(bytes)), options)
}

fn options() -> DecoderOptions {
    DecoderOptions::default().set_strict_mode(false).set_max_width(usize::MAX).set_max_height(usize::MAX)
}

impl ImageDecoder for JpegReader<'_> {
    fn dimensions(&self) -> (u32, u32) {
        self.size
    }

    fn color_type(&self) -> ColorType {
        if self.colors == ColorSpace::Luma { ColorType::L8 } else { ColorType::Rgb8 }
    }

    fn icc_profile(&mut self) -> ImageResult<Option<Vec<u8>>> {
        Ok(self.header.icc_profile())
    }

    fn exif_metadata(&mut self) -> ImageResult<Option<Vec<u8>>> {
        Ok(self.header.exif().cloned())
    }

    fn set_limits(&mut self, limits: Limits) -> ImageResult<()> {
        limits.check_dimensions(self.size.0, self.size.1)
    }

    fn read_image(self, samples: &mut [u8]) -> ImageResult<()> {
        let options = options().jpeg_set_out_colorspace(self.colors);
        decoder(self.bytes, options).decode_into(samples).map_err(|error| failure(&error))
    }

    fn read_image_boxed(self: Box<Self>, samples: &mut [u8]) -> ImageResult<()> {
        self.read_image(samples)
    }
}

/// An error in the kinds of the `image` crate.
fn failure(error: &DecodeErrors) -> ImageError {
    let format = ImageFormat::Jpeg.into();
    match error {
        DecodeErrors::Unsupported(what) => {
            let kind = UnsupportedErrorKind::GenericFeature(format!("{what:?}"));
            ImageError::Unsupported(UnsupportedError::from_format_and_kind(format, kind))
        }
        DecodeErrors::LargeDimensions(_) => {
            ImageError::Limits(LimitError::from_kind(LimitErrorKind::DimensionError))
        }
        error => ImageError::Decoding(DecodingError::new(format, error.to_string())),
    }
}

#[cfg(test)]
mod tests {
    use super::super::jpeg;
    use super::*;
    use crate::size::Size;
    use std::io::Cursor;

    #[test]
    fn samples_are_those_of_the_decoder_of_the_image_crate() {
        for channels in [1, 3] {
            let size = Size::new(53, 38);
            let samples: Vec<u8> = (0..size.texels() * channels).map(|i| (i * i / 7 + i) as u8).collect();
            let file = jpeg::encode(&samples, size, channels, 80).unwrap();
            let all = |decoder: &dyn Fn(&mut [u8]) -> ImageResult<()>| {
                let mut samples = vec![0; size.texels() * channels];
                decoder(&mut samples).unwrap();
                samples
            };
            let found = all(&|samples| JpegReader::new(&file).unwrap().read_image(samples));
            let theirs = image::codecs::jpeg::JpegDecoder::new(Cursor::new(&file));
            assert_eq!(JpegReader::new(&file).unwrap().color_type(), theirs.unwrap().color_type());
            let expected = all(&|samples| {
                image::codecs::jpeg::JpegDecoder::new(Cursor::new(&file)).unwrap().read_image(samples)
            });
            assert!(found == expected, "{channels} channels");
            assert!(JpegReader::new(&file[..100]).is_err());
        }
    }
}
