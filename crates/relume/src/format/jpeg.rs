//! Samples of 8 bits in JPEG files (ITU-T T.81), grey or RGB of full colour resolution, without a meaning: planes of
//! coefficients, as well as pictures.

use image::codecs::jpeg::JpegEncoder;
use image::{ColorType, ExtendedColorType, ImageDecoder};

use super::complete;
use super::jpeg_read::JpegReader;
use super::kind::{Kind, damaged};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::memory;
use crate::size::Size;

/// The quality of files where nothing is said: 1 (smallest) to 100.
pub(crate) const JPEG_QUALITY: u8 = 92;

/// The longest side of a JPEG picture (ITU-T T.81, B.2.2).
pub(super) const JPEG_MAX_SIDE: usize = 65535;

/// The samples of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct JpegSamples {
    pub size: Size,
    /// 1, or 3 interleaved.
    pub channels: usize,
    pub samples: Vec<u8>,
}

/// Reads a grey or colour file of any size.
pub(super) fn decode(bytes: &[u8], job: &Job) -> Result<JpegSamples> {
    if Kind::of(bytes) != Some(Kind::Jpeg) {
        return Err(Error::invalid("the data is not a JPEG picture"));
    }
    let frame = complete::check_jpeg(bytes)?;
    job.check_bytes("decoding the JPEG picture", frame.map_or(0, |frame| frame.working_bytes()))?;
    let broken = |_| damaged(Kind::Jpeg);
    let decoder = JpegReader::new(bytes).map_err(broken)?;
    let (width, height) = decoder.dimensions();
    let channels = match decoder.color_type() {
        ColorType::L8 => 1,
        ColorType::Rgb8 => 3,
        _ => return Err(Error::unsupported("the JPEG picture is neither grey nor RGB")),
    };
    let size = Size::new(width as usize, height as usize);
    job.check("the JPEG picture", size, channels as u64)?;
    let mut samples = memory::zeros("the JPEG picture", size.texels() * channels)?;
    decoder.read_image(&mut samples).map_err(broken)?;
    Ok(JpegSamples { size, channels, samples })
}

/// The file of samples of one channel, or of three interleaved ones.
///
/// # Errors
/// Sides that no JPEG file has, and a quality outside 1 to 100.
pub(super) fn encode(samples: &[u8], size: Size, channels: usize, quality: u8) -> Result<Vec<u8>> {
    check(size, quality)?;
    let Size { width, height } = size;
    let color = if channels == 1 { ExtendedColorType::L8 } else { ExtendedColorType::Rgb8 };
    let mut out = Vec::new();
    JpegEncoder::new_with_quality(&mut out, quality)
        .encode(samples, width as u32, height as u32, color)
        .map_err(|_| Error::limit(format!("a JPEG file cannot hold a picture of {size} texels")))?;
    Ok(out)
}

/// Refuses sides that no JPEG file has, and a quality outside 1 to 100.
pub(super) fn check(size: Size, quality: u8) -> Result<()> {
    let Size { width, height } = size;
    if width.max(height) > JPEG_MAX_SIDE {
        return Err(Error::usage(format!(
            "a JPEG picture has sides up to {JPEG_MAX_SIDE} texels, not {width} x {height}: write PNG instead"
        )));
    }
    if !(1..=100).contains(&quality) {
        return Err(Error::usage(format!("the quality of a JPEG is 1 to 100, not {quality}")));
    }
    Ok(())
}
