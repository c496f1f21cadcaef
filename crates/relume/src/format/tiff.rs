//! TIFF pictures (TIFF 6.0, Adobe 1992, and BigTIFF): grey and RGB, with an opacity, as integers or floats,
//! interleaved or in planes.
//!
//! Other colour models are left to the `image` crate, or refused by name.

use std::io::Cursor;

use ::tiff::decoder::{BufferLayoutPreference, Decoder, DecodingResult, Limits};
use ::tiff::tags::Tag;
use ::tiff::{ColorType, TiffError, TiffUnsupportedError};

use super::kind::{Kind, damaged};
use super::turned::turned;
use super::{finite, opacity, plausible};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::raster::{Raster, Samples};
use crate::size::Size;

/// A picture and the ICC profile beside it.
pub(super) struct TiffPicture {
    pub raster: Raster,
    pub profile: Option<Vec<u8>>,
}

/// The photometric interpretation of palettes.
const PALETTE: u16 = 3;

type TiffReader<'a> = Decoder<Cursor<&'a [u8]>>;

/// The picture in a file; `None` if its colours are CMYK, which another reader converts.
pub(super) fn decode(bytes: &[u8], job: &Job) -> Result<Option<TiffPicture>> {
    let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(explain)?;
    let (width, height) = decoder.dimensions().map_err(explain)?;
    let size = Size::new(width as usize, height as usize);
    let Some(form) = Form::of(&mut decoder)? else { return Ok(None) };
    // The samples of the decoder and ours are held at the same time.
    let stored = u64::from(form.stored) * u64::from(form.bits.max(8)) / 8;
    job.check("the picture", size, 2 * stored)?;
    let packed = size.texels() as u64 * u64::from(form.stored) * u64::from(form.bits) / 8;
    plausible::check("TIFF", size, packed, bytes.len() as u64, plausible::LZW)?;
    let mut decoder = decoder.with_limits(limits(job));
    let mut read = DecodingResult::U8(Vec::new());
    let layout = decoder.read_image_to_buffer(&mut read).map_err(explain)?;
    let samples = interleaved(samples(read, &form, size, job)?, &layout, &form, size)?;
    if decoder.more_images() {
        job.remark("the TIFF file has several pages: the first is used");
    }
    let orientation = decoder.find_tag_unsigned::<u16>(Tag::Orientation).ok().flatten().unwrap_or(1);
    let raster = turned(form.raster(samples, size, job)?, orientation)?;
    Ok(Some(TiffPicture { raster, profile: decoder.get_tag_u8_vec(Tag::IccProfile).ok() }))
}

fn limits(job: &Job) -> Limits {
    let most = usize::try_from(job.free_bytes()).unwrap_or(usize::MAX);
    let mut limits = Limits::default();
    (limits.decoding_buffer_size, limits.intermediate_buffer_size, limits.ifd_value_size) =
        (most, most, most);
    limits
}

/// The form of the texels of a file.
struct Form {
    /// Samples of a texel as decoded.
    stored: u16,
    /// Samples of a texel in the file, some of which the decoder may leave out.
    in_file: u16,
    bits: u8,
    /// 1 or 3.
    channels: usize,
    alpha: Option<Alpha>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Alpha {
    /// The colours are multiplied by it.
    Associated,
    Unassociated,
}

impl Form {
    /// `None` for CMYK.
    fn of(decoder: &mut TiffReader<'_>) -> Result<Option<Self>> {
        if decoder.find_tag_unsigned(Tag::PhotometricInterpretation).ok().flatten() == Some(PALETTE) {
            return Err(refused("palettes"));
        }
        let color = decoder.colortype().map_err(explain)?;
        let (channels, stored) = match color {
            ColorType::Gray(_) => (1, 1),
            ColorType::GrayA(_) => (1, 2),
            ColorType::RGB(_) => (3, 3),
            ColorType::RGBA(_) => (3, 4),
            ColorType::Multiband { num_samples, .. } => (1, num_samples),
            ColorType::CMYK(_) => return Ok(None),
            ColorType::YCbCr(_) => return Err(refused("colours stored as YCbCr")),
            ColorType::CMYKA(_) => return Err(refused("CMYK colours with opacity")),
            _ => return Err(refused("samples stored in this way")),
        };
        // ExtraSamples: 1 is an associated and 2 an unassociated alpha, 0 says nothing.
        let extra =
            decoder.find_tag_unsigned_vec::<u16>(Tag::ExtraSamples).ok().flatten().unwrap_or_default();
        let alpha = match extra.first() {
            Some(1) => Some(Alpha::Associated),
            Some(2) => Some(Alpha::Unassociated),
            None if matches!(color, ColorType::RGBA(_) | ColorType::GrayA(_)) => Some(Alpha::Unassociated),
            _ => None,
        };
        let alpha = alpha.filter(|_| usize::from(stored) > channels);
        let in_file = decoder.find_tag_unsigned::<u16>(Tag::SamplesPerPixel).ok().flatten().unwrap_or(1);
        Ok(Some(Self { stored, in_file, bits: color.bit_depth(), channels, alpha }))
    }

    /// The picture of interleaved samples.
    fn raster(&self, samples: Samples, size: Size, job: &Job) -> Result<Raster> {
        let stored = usize::from(self.stored);
        let taken = self.channels + usize::from(self.alpha.is_some());
        if usize::from(self.in_file) > taken {
            let more = usize::from(self.in_file) - taken;
            job.remark(format!("TIFF channels beyond grey, RGB and opacity are not used: {more} of them"));
        }
        let picked = |channels: std::ops::Range<usize>| picked(&samples, stored, channels);
        let mut colors = picked(0..self.channels);
        if let Samples::F32(values) = &samples {
            let names = if self.channels == 1 { &["Y"][..] } else { &["R", "G", "B"][..] };
            let name = |i: usize| names.get(i % stored).copied().unwrap_or("A");
            finite::check(values, size, name, |i| i / stored)?;
        }
        let Some(alpha) = self.alpha else { return Raster::new(size, self.channels, colors) };
        let alphas = picked(self.channels..self.channels + 1);
        if alpha == Alpha::Associated {
            opacity::divide(&mut colors, &alphas);
        }
        Raster::new(size, self.channels, colors)?.with_opacity(alphas)
    }
}

/// The samples of some channels of texels of `stored` samples.
fn picked(samples: &Samples, stored: usize, channels: std::ops::Range<usize>) -> Samples {
    fn of<T: Copy>(samples: &[T], stored: usize, channels: std::ops::Range<usize>) -> Vec<T> {
        samples.chunks_exact(stored).flat_map(|texel| &texel[channels.clone()]).copied().collect()
    }
    match samples {
        Samples::U8(s) => Samples::U8(of(s, stored, channels)),
        Samples::U16(s) => Samples::U16(of(s, stored, channels)),
        Samples::F32(s) => Samples::F32(of(s, stored, channels)),
    }
}

/// The decoder's numbers as samples, in its order. Numbers of 32 bits are rounded to 16.
fn samples(read: DecodingResult, form: &Form, size: Size, job: &Job) -> Result<Samples> {
    Ok(match read {
        DecodingResult::U8(s) if form.bits < 8 => Samples::U8(unpacked(&s, form, size)?),
        DecodingResult::U8(s) => Samples::U8(s),
        DecodingResult::U16(s) => Samples::U16(s),
        DecodingResult::U32(s) => {
            job.remark("its integers of 32 bits are rounded to 16 bits");
            let rounded =
                |v: u32| ((u64::from(v) * 65535 + u64::from(u32::MAX / 2)) / u64::from(u32::MAX)) as u16;
            Samples::U16(s.into_iter().map(rounded).collect())
        }
        DecodingResult::F16(s) => Samples::F32(s.into_iter().map(f32::from).collect()),
        DecodingResult::F32(s) => Samples::F32(s),
        DecodingResult::F64(s) => Samples::F32(s.into_iter().map(|v| v as f32).collect()),
        _ => return Err(refused("signed integers and integers of 64 bits")),
    })
}

/// Samples of 1, 2 or 4 bits as codes of 8; rows begin at whole bytes.
fn unpacked(packed: &[u8], form: &Form, size: Size) -> Result<Vec<u8>> {
    let bits = usize::from(form.bits);
    if form.stored != 1 || !matches!(bits, 1 | 2 | 4) {
        return Err(refused("several channels of less than 8 bits"));
    }
    let most = (1u16 << bits) - 1;
    let row_bytes = (size.width * bits).div_ceil(8);
    let sample = |row: &[u8], x: usize| {
        let value = u16::from(row[x * bits / 8] >> (8 - bits - x * bits % 8)) & most;
        (value * 255 / most) as u8
    };
    let rows = packed.chunks_exact(row_bytes).take(size.height);
    Ok(rows.flat_map(|row| (0..size.width).map(move |x| sample(row, x))).collect())
}

/// Samples in planes, one after the other, as interleaved ones.
fn interleaved(
    samples: Samples,
    layout: &BufferLayoutPreference,
    form: &Form,
    size: Size,
) -> Result<Samples> {
    let stored = usize::from(form.stored);
    if samples.len() < size.texels() * stored {
        return Err(Error::limit("the TIFF picture needs more memory than the limits allow"));
    }
    if layout.planes <= 1 || stored == 1 {
        return Ok(samples);
    }
    fn joined<T: Copy>(samples: &[T], texels: usize, planes: usize) -> Vec<T> {
        (0..texels).flat_map(|texel| (0..planes).map(move |k| samples[k * texels + texel])).collect()
    }
    let texels = size.texels();
    Ok(match samples {
        Samples::U8(s) => Samples::U8(joined(&s, texels, stored)),
        Samples::U16(s) => Samples::U16(joined(&s, texels, stored)),
        Samples::F32(s) => Samples::F32(joined(&s, texels, stored)),
    })
}

fn refused(what: &str) -> Error {
    Error::unsupported(format!(
        "{what} are not read from TIFF files: export the picture as grey or RGB of 8 or 16 bits, or of floats"
    ))
}

/// A decoder's error in the user's terms.
fn explain(error: TiffError) -> Error {
    match error {
        TiffError::UnsupportedError(TiffUnsupportedError::UnsupportedCompressionMethod(_)) => {
            Error::unsupported("the TIFF file's compression is not read: export it with LZW, Deflate or none")
        }
        TiffError::UnsupportedError(_) => refused("samples stored in this way"),
        TiffError::LimitsExceeded => {
            Error::limit("the TIFF picture needs more memory or longer sides than the limits allow")
        }
        _ => damaged(Kind::Tiff),
    }
}
