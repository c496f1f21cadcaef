//! Height maps with a recorded range: nothing is normalised silently.
//!
//! - **PNG**, 16 bits, grey, data (not sRGB): code 0 is the lowest height, 65,535 the highest. A text
//!   chunk `Height-Range` before the image holds `LOW HIGH texels`, or `LOW HIGH mm` with a second
//!   one, `Millimetres-Per-Texel`.
//! - **EXR**, one 32-bit channel `Y`: heights unchanged, in texels; or in millimetres with the text
//!   attributes `heightUnit` (`mm`) and `millimetresPerTexel`.
//!
//! Integer files of other programs have no record; the reader has to supply their scale. Floating-point files
//! without a record are assumed to be in texels.

use std::collections::BTreeMap;
use std::ops::{Range, RangeInclusive};
use std::path::Path;

use super::exr::{self, ExrDepth};
use super::kind::Kind;
use super::meaning::Meaning;
use super::opacity::OPACITY_UNUSED;
use super::picture::extension;
use super::raster::decode_as;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::planes::Planes;
use crate::raster::{Raster, Samples};
use crate::size::Size;

const RANGE: &str = "Height-Range";
const PIXEL: &str = "Millimetres-Per-Texel";
const EXR_UNIT: &str = "heightUnit";
const EXR_PIXEL: &str = "millimetresPerTexel";

/// File formats of height maps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HeightFormat {
    /// 16-bit grey with the range recorded.
    Png,
    /// 32-bit floats.
    Exr,
}

impl HeightFormat {
    /// The format of an extension.
    ///
    /// # Errors
    /// When the extension is neither `png` nor `exr`.
    pub fn from_path(path: &Path) -> Result<Self> {
        match extension(path).as_str() {
            "png" => Ok(Self::Png),
            "exr" => Ok(Self::Exr),
            other => Err(Error::usage(format!(
                "no height map has the extension '{other}': name the file .png (16 bits, range recorded) or .exr (floats)"
            ))
            .at(path)),
        }
    }
}

/// The sizes of texels in millimetres that height maps are written with: from a picometre to a thousand
/// kilometres.
pub const TEXEL_MM: RangeInclusive<f64> = 1e-9..=1e9;

/// The scale of the samples of a file: height = offset + step x sample, in texels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeightScale {
    /// The height of sample 0, in texels.
    pub offset: f64,
    /// Texels from sample 0 to sample 1.
    pub step: f64,
    /// The size of a texel, if recorded.
    pub mm_per_texel: Option<f64>,
}

/// A height map as stored.
#[derive(Debug, Clone, PartialEq)]
pub struct HeightMap {
    /// One plane: integer codes from 0 to 1, or floats.
    pub samples: Planes,
    /// Their scale; `None` for integer files without a record.
    pub scale: Option<HeightScale>,
}

impl HeightMap {
    /// Heights in texels: by the recorded scale, otherwise with `otherwise` texels from sample 0 to 1.
    pub fn texels(&self, otherwise: f64) -> Planes {
        let unrecorded = HeightScale { offset: 0.0, step: otherwise, mm_per_texel: None };
        let HeightScale { offset, step, .. } = self.scale.unwrap_or(unrecorded);
        let mut heights = self.samples.clone();
        heights.as_mut_slice().iter_mut().for_each(|h| *h = (offset + step * f64::from(*h)) as f32);
        heights
    }
}

/// The bytes of a height map given in texels; in millimetres if the size of a texel is known.
///
/// # Errors
/// When there is not exactly one plane, the size of a texel is not one of [`TEXEL_MM`], or heights are not finite, as
/// given or in millimetres.
pub fn encode_height(height: &Planes, mm_per_texel: Option<f64>, format: HeightFormat) -> Result<Vec<u8>> {
    encode_height_with(height, mm_per_texel, format, &Job::unlimited())
}

/// [`encode_height`] as a part of a job.
///
/// # Errors
/// As [`encode_height`]; limits exceeded, and a cancelled job.
pub fn encode_height_with(
    height: &Planes,
    mm_per_texel: Option<f64>,
    format: HeightFormat,
    job: &Job,
) -> Result<Vec<u8>> {
    if height.count() != 1 || !height.as_slice().iter().all(|h| h.is_finite()) {
        return Err(Error::invalid("a height map is one plane of finite numbers"));
    }
    job.check_bytes("writing the height map", format.footprint(height.size()).peak)?;
    let mut scaled = height.clone();
    if let Some(mm) = mm_per_texel {
        if !TEXEL_MM.contains(&mm) {
            return Err(Error::usage(format!(
                "a texel of {mm:e} mm: expected {:e} to {:e} mm",
                TEXEL_MM.start(),
                TEXEL_MM.end()
            )));
        }
        scaled.as_mut_slice().iter_mut().for_each(|h| *h = (f64::from(*h) * mm) as f32);
        if !scaled.as_slice().iter().all(|h| h.is_finite()) {
            return Err(Error::usage(format!(
                "texels of {mm:e} mm make these heights larger than floats hold: choose a smaller size"
            )));
        }
    }
    job.proceed()?;
    match format {
        HeightFormat::Png => encode_png(&scaled, mm_per_texel),
        HeightFormat::Exr => {
            let pixel = mm_per_texel.map(|mm| (EXR_PIXEL, mm.to_string()));
            let unit = (EXR_UNIT, unit(mm_per_texel).to_owned());
            let texts: Vec<_> = std::iter::once(unit).chain(pixel).collect();
            exr::encode_with_texts(&["Y"], &scaled, ExrDepth::Float, &texts, job)
        }
    }
}

fn unit(mm_per_texel: Option<f64>) -> &'static str {
    if mm_per_texel.is_some() { "mm" } else { "texels" }
}

fn encode_png(height: &Planes, mm_per_texel: Option<f64>) -> Result<Vec<u8>> {
    let (low, high) = height.range(0);
    let span = f64::from(high) - f64::from(low);
    let code = |h: f32| match span > 0.0 {
        true => ((f64::from(h) - f64::from(low)) / span * 65535.0).round() as u16,
        false => 0,
    };
    let codes = height.as_slice().iter().map(|&h| code(h));
    data16(height.size(), codes, f64::from(low)..f64::from(high), mm_per_texel)
}

/// A PNG file of codes from the lowest to the highest height, in the unit of the record.
fn data16(
    size: Size,
    codes: impl Iterator<Item = u16>,
    range: Range<f64>,
    mm_per_texel: Option<f64>,
) -> Result<Vec<u8>> {
    let samples: Vec<u8> = codes.flat_map(u16::to_be_bytes).collect();
    let mut texts = vec![(RANGE, format!("{} {} {}", range.start, range.end, unit(mm_per_texel)))];
    texts.extend(mm_per_texel.map(|mm| (PIXEL, mm.to_string())));
    super::png::encode_data(size, 1, (::png::BitDepth::Sixteen, &samples), &texts)
}

/// The bytes of a height map of which the samples are given as stored, with their scale: the record and the codes
/// stay what they were, so that copies are exact. Samples of a PNG file outside 0..1 widen its range.
///
/// # Errors
/// As [`encode_height`].
pub fn encode_scaled_height(map: &HeightMap, format: HeightFormat, job: &Job) -> Result<Vec<u8>> {
    let HeightScale { offset, step, mm_per_texel } =
        map.scale.ok_or_else(|| Error::invalid("the scale of the heights is not known"))?;
    let (low, high) = map.samples.range(0);
    if format == HeightFormat::Exr || low < 0.0 || high > 1.0 || map.samples.count() != 1 {
        return encode_height_with(&map.texels(1.0), mm_per_texel, format, job);
    }
    job.proceed()?;
    let codes = map.samples.as_slice().iter().map(|&v| (f64::from(v) * 65535.0).round() as u16);
    let mm = mm_per_texel.unwrap_or(1.0);
    data16(map.samples.size(), codes, mm * offset..mm * (offset + step), mm_per_texel)
}

/// The texts of a picture that may record the meaning of its values.
pub(super) fn texts(bytes: &[u8]) -> Result<BTreeMap<String, String>> {
    match Kind::of(bytes) {
        Some(Kind::Png) => super::png::texts(bytes),
        Some(Kind::Exr) => Ok(exr::head(bytes)?.1),
        _ => Ok(BTreeMap::new()),
    }
}

/// Whether a file records its heights.
pub(super) fn is_recorded(bytes: &[u8]) -> bool {
    texts(bytes).is_ok_and(|texts| texts.contains_key(RANGE) || texts.contains_key(EXR_UNIT))
}

/// The height map in the bytes of a file; for a colour picture, the first channel.
///
/// # Errors
/// A file that is not a picture, or has an invalid record.
pub fn decode_height(bytes: &[u8], job: &Job) -> Result<HeightMap> {
    let raster = decode_as(bytes, Meaning::Data, job)?;
    if raster.opacity().is_some() {
        job.remark(OPACITY_UNUSED);
    }
    if raster.channels() > 1 && !is_grey(&raster) {
        job.remark("the height map is in colour: its first channel, red, is used");
    }
    let recorded = recorded(&texts(bytes)?)?;
    let floats = matches!(raster.samples(), Samples::F32(_));
    let texels = floats.then_some(HeightScale { offset: 0.0, step: 1.0, mm_per_texel: None });
    let samples = raster.to_planes(raster.samples().space(), job)?.truncated(1);
    Ok(HeightMap { samples, scale: recorded.or(texels) })
}

/// Whether the channels of all texels are equal.
fn is_grey(raster: &Raster) -> bool {
    let samples = raster.samples();
    (0..samples.len()).all(|i| samples.value(i) == samples.value(i - i % raster.channels()))
}

/// The scale that the texts of a file record.
///
/// # Errors
/// An invalid record.
pub(super) fn recorded(texts: &BTreeMap<String, String>) -> Result<Option<HeightScale>> {
    if let Some(unit) = texts.get(EXR_UNIT) {
        return scale(0.0, 1.0, unit, texts.get(EXR_PIXEL).map(String::as_str));
    }
    let Some(range) = texts.get(RANGE) else { return Ok(None) };
    let broken =
        || Error::invalid(format!("the height map's record '{range}' is not LOW HIGH texels or LOW HIGH mm"));
    let words: Vec<&str> = range.split(' ').collect();
    let [low, high, unit] = words[..] else { return Err(broken()) };
    let number = |text: &str| text.parse::<f64>().ok().filter(|v| v.is_finite()).ok_or_else(broken);
    scale(number(low)?, number(high)?, unit, texts.get(PIXEL).map(String::as_str))
}

/// The scale of a record: the heights of samples 0 and 1, and their unit.
fn scale(low: f64, high: f64, unit: &str, pixel: Option<&str>) -> Result<Option<HeightScale>> {
    let mm = match pixel.map(|text| text.parse::<f64>().ok().filter(|mm| *mm > 0.0 && mm.is_finite())) {
        None => None,
        Some(Some(mm)) => Some(mm),
        Some(None) => return Err(Error::invalid("the height map's size of a texel is not a number above 0")),
    };
    match (unit, mm) {
        ("texels", _) => Ok(Some(HeightScale { offset: low, step: high - low, mm_per_texel: mm })),
        ("mm", Some(mm)) => {
            Ok(Some(HeightScale { offset: low / mm, step: (high - low) / mm, mm_per_texel: Some(mm) }))
        }
        ("mm", None) => {
            Err(Error::invalid("the height map is in millimetres and does not say how large a texel is"))
        }
        (other, _) => {
            Err(Error::unsupported(format!("the height map's unit is '{other}': expected texels or mm")))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn heights() -> Planes {
        Planes::from_vec(Size::new(4, 3), 1, (0..12).map(|i| -3.25 + 0.5 * ((i * 7) % 12) as f32).collect())
            .unwrap()
    }

    #[test]
    fn heights_come_back_in_texels_whatever_the_unit_and_file() {
        for (format, tolerance) in [(HeightFormat::Png, 5.5 / 65535.0), (HeightFormat::Exr, 1e-6)] {
            for mm in [None, Some(0.125)] {
                let bytes = encode_height(&heights(), mm, format).unwrap();
                let map = decode_height(&bytes, &Job::default()).unwrap();
                assert_eq!(map.scale.unwrap().mm_per_texel, mm);
                for (found, truth) in map.texels(99.0).as_slice().iter().zip(heights().as_slice()) {
                    assert!(
                        (found - truth).abs() <= tolerance,
                        "{format:?} {mm:?}: {found} instead of {truth}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_level_map_and_one_without_a_record() {
        let level = Planes::from_vec(Size::new(2, 1), 1, vec![4.5; 2]).unwrap();
        let bytes = encode_height(&level, None, HeightFormat::Png).unwrap();
        assert_eq!(decode_height(&bytes, &Job::default()).unwrap().texels(1.0), level);
        let plain = super::super::png::encode(Size::new(2, 1), 1, ::png::BitDepth::Eight, &[0, 255]).unwrap();
        let map = decode_height(&plain, &Job::default()).unwrap();
        assert_eq!((map.scale, map.texels(8.0).as_slice()), (None, &[0.0, 8.0][..]));
    }

    #[test]
    fn broken_records_are_refused() {
        let with = |range: &str, pixel: Option<&str>| {
            let mut texts = vec![(RANGE, range.to_owned())];
            texts.extend(pixel.map(|p| (PIXEL, p.to_owned())));
            let bytes = super::super::png::encode_data(
                Size::new(1, 1),
                1,
                (::png::BitDepth::Sixteen, &[0, 7]),
                &texts,
            )
            .unwrap();
            decode_height(&bytes, &Job::default())
        };
        assert!(with("0 1 texels", None).is_ok());
        for (range, pixel) in [
            ("", None),
            ("0 1", None),
            ("0 nan texels", None),
            ("0 1 mm", None),
            ("0 1 mm", Some("0")),
            ("0 1 inches", Some("1")),
        ] {
            assert!(with(range, pixel).is_err(), "{range} {pixel:?}");
        }
        assert!(encode_height(&Planes::zeros(Size::new(2, 2), 3), None, HeightFormat::Png).is_err());
    }
}
