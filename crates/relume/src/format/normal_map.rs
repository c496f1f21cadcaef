//! Normal maps: unit vectors as three channels, and the record of the direction of Y.
//!
//! Integer files hold packed components, v = (n + 1) / 2, as data: PNG files are not marked as sRGB. Floats hold
//! components as they are, except in Radiance files, which have no negative numbers; a float file without a negative one and without a record is taken as packed. Whether the second channel
//! grows to the top (OpenGL) or to the bottom of the picture (DirectX) is recorded as the text `Normal-Y` in PNG and
//! as the attribute `normalY` in EXR, `up` or `down`; files of other programs say it in their names at best.

use std::collections::BTreeMap;
use std::path::Path;

use super::map_role::NormalY;
use super::meaning::Meaning;
use super::picture::{Depth, PictureFormat, encode_picture_with, png_samples};
use super::raster::decode_as;
use super::{exr, height, png};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::names::Named;
use crate::picture::Picture;
use crate::planes::Planes;
use crate::raster::{Raster, Samples};
use crate::space::Space;

const PNG_RECORD: &str = "Normal-Y";
const EXR_RECORD: &str = "normalY";

/// A normal map read from a file.
#[derive(Debug, Clone, PartialEq)]
pub struct NormalMap {
    /// Three planes: x right, y up (whatever the file has), z out of the surface.
    pub normals: Planes,
    /// The direction of the second channel in the file.
    pub y: NormalY,
}

/// The bytes of a map of normals given with y up: packed to 16 bits where the format has them, or floats.
///
/// # Errors
/// When there are not three planes, and as [`encode_picture`](super::encode_picture).
pub fn encode_normals(normals: &Planes, y: NormalY, format: PictureFormat, job: &Job) -> Result<Vec<u8>> {
    encode_stored_normals(&stored(normals, y, format), y, format.with_depth(Depth::Sixteen), job)
}

/// The bytes of a normal map of which the values are given as stored in the file, with its record.
///
/// # Errors
/// As [`encode_normals`].
pub fn encode_stored_normals(
    picture: &Picture,
    y: NormalY,
    format: PictureFormat,
    job: &Job,
) -> Result<Vec<u8>> {
    job.proceed()?;
    if picture.planes.count() != 3 {
        return Err(Error::invalid(format!(
            "a normal map has three channels, found {}",
            picture.planes.count()
        )));
    }
    let record = y.name().to_owned();
    match format {
        PictureFormat::Png(depth) => {
            let (depth, samples) = png_samples(picture, depth, &Job::unlimited())?;
            png::encode_data(picture.size(), 3, (depth, &samples), &[(PNG_RECORD, record)])
        }
        PictureFormat::Exr(depth) => {
            exr::encode_with_texts(&["R", "G", "B"], &picture.planes, depth, &[(EXR_RECORD, record)], job)
        }
        PictureFormat::Pfm
        | PictureFormat::Radiance
        | PictureFormat::Jpeg { .. }
        | PictureFormat::Tiff(_) => encode_picture_with(picture, format, job),
    }
}

/// The values stored for normals given with y up.
fn stored(normals: &Planes, y: NormalY, format: PictureFormat) -> Picture {
    let mut planes = normals.clone();
    if y == NormalY::Down && planes.count() > 1 {
        planes.plane_mut(1).iter_mut().for_each(|v| *v = -*v);
    }
    if matches!(format, PictureFormat::Exr(_) | PictureFormat::Pfm) {
        return Picture { planes, space: Space::Linear };
    }
    planes.as_mut_slice().iter_mut().for_each(|v| *v = 0.5 * *v + 0.5);
    // In the space of the file, so that it holds the packed components themselves.
    let space = if format == PictureFormat::Radiance { Space::Linear } else { Space::Srgb };
    Picture { planes, space }
}

/// The normal map in the bytes of a file. The direction of Y is the one `asked` for, else that of the record, else
/// that of the file's name, else up.
///
/// # Errors
/// A file that is no picture of three channels, or has an invalid record.
pub fn decode_normals(bytes: &[u8], name: &Path, asked: Option<NormalY>, job: &Job) -> Result<NormalMap> {
    let raster = decode_as(bytes, Meaning::Data, job)?;
    let recorded = recorded(&height::texts(bytes)?)?;
    let y = asked.or(recorded).or(NormalY::of_name(name)).unwrap_or_default();
    let normals = normals_of(&raster, y, recorded.is_some(), job)?;
    let odd = share_of_other_lengths(&normals);
    if odd > LARGEST_ODD_SHARE {
        job.remark(format!(
            "{:.0} % of its vectors are far from length 1 or point down, so it may be no normal map",
            100.0 * odd
        ));
    }
    Ok(NormalMap { normals, y })
}

/// The direction of Y that the texts of a file record.
///
/// # Errors
/// A record of another word.
pub(super) fn recorded(texts: &BTreeMap<String, String>) -> Result<Option<NormalY>> {
    let Some(word) = texts.get(PNG_RECORD).or(texts.get(EXR_RECORD)) else { return Ok(None) };
    NormalY::from_name(word).map(Some).ok_or_else(|| {
        Error::invalid(format!(
            "the normal map's record of Y is '{}': expected up or down",
            word.escape_default()
        ))
    })
}

/// Normal maps of tools are filtered and compressed, which shortens some vectors.
const LARGEST_ODD_SHARE: f64 = 0.1;

/// The share of vectors that no normal map has: shorter or longer than 1 by a third, or below the surface.
fn share_of_other_lengths(normals: &Planes) -> f64 {
    let texels = normals.size().texels();
    let is_odd = |&texel: &usize| {
        let [x, y, z] = [0, 1, 2].map(|k| f64::from(normals.plane(k)[texel]));
        let length = (x * x + y * y + z * z).sqrt();
        !(0.67..=1.33).contains(&length) || z < 0.0
    };
    (0..texels).filter(is_odd).count() as f64 / texels as f64
}

/// The normals in a picture, y up. Floats of a file with a record are never packed.
fn normals_of(raster: &Raster, y: NormalY, is_recorded: bool, job: &Job) -> Result<Planes> {
    if raster.channels() != 3 {
        return Err(Error::invalid("is grey: a normal map needs three channels"));
    }
    let mut normals = raster.to_planes(raster.samples().space(), job)?;
    let is_packed = match raster.samples() {
        Samples::F32(_) => !is_recorded && normals.as_slice().iter().all(|v| *v >= 0.0),
        _ => true,
    };
    if is_packed {
        normals.as_mut_slice().iter_mut().for_each(|v| *v = 2.0 * *v - 1.0);
    }
    if y == NormalY::Down {
        normals.plane_mut(1).iter_mut().for_each(|v| *v = -*v);
    }
    Ok(normals)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::{ExrDepth, encode_picture};
    use crate::size::Size;

    fn normals() -> Planes {
        Planes::from_vec(Size::new(2, 1), 3, vec![0.6, 0.0, 0.0, -0.28, 0.8, 0.96]).unwrap()
    }

    #[test]
    fn normals_come_back_with_y_up_whatever_the_file_has() {
        let formats = [
            PictureFormat::Png(Depth::Eight),
            PictureFormat::Tiff(Depth::Eight),
            PictureFormat::Exr(ExrDepth::Float),
        ];
        for format in formats {
            for y in [NormalY::Up, NormalY::Down] {
                let bytes = encode_normals(&normals(), y, format, &Job::default()).unwrap();
                let asked = matches!(format, PictureFormat::Tiff(_)).then_some(y);
                let map = decode_normals(&bytes, Path::new("n"), asked, &Job::default()).unwrap();
                assert_eq!(map.y, y);
                for (found, truth) in map.normals.as_slice().iter().zip(normals().as_slice()) {
                    assert!((found - truth).abs() < 1e-4, "{format:?} {y:?}: {found}, {truth}");
                }
            }
        }
    }

    #[test]
    fn what_is_asked_decides_then_the_record_then_the_name() {
        let y = |bytes: &[u8], name: &str, asked| {
            decode_normals(bytes, Path::new(name), asked, &Job::default()).unwrap().y
        };
        let png = PictureFormat::Png(Depth::Eight);
        let recorded = encode_normals(&normals(), NormalY::Up, png, &Job::default()).unwrap();
        let plain = encode_picture(&stored(&normals(), NormalY::Up, png), png).unwrap();
        assert_eq!(y(&plain, "a_normal.png", None), NormalY::Up);
        assert_eq!(y(&plain, "a_nor_dx.png", None), NormalY::Down);
        assert_eq!(y(&recorded, "a_nor_dx.png", None), NormalY::Up);
        assert_eq!(y(&recorded, "a_nor_dx.png", Some(NormalY::Down)), NormalY::Down);
    }

    #[test]
    fn floats_are_packed_only_if_none_is_negative() {
        let of = |values: Vec<f32>| {
            normals_of(
                &Raster::new(Size::new(1, 1), 3, Samples::F32(values)).unwrap(),
                NormalY::Up,
                false,
                &Job::default(),
            )
            .unwrap()
        };
        assert_eq!(of(vec![0.0, -0.6, 0.8]).as_slice(), [0.0, -0.6, 0.8]);
        assert_eq!(of(vec![0.5, 0.5, 1.0]).as_slice(), [0.0, 0.0, 1.0]);
        let grey = Raster::new(Size::new(2, 1), 1, Samples::U8(vec![1, 2])).unwrap();
        assert!(normals_of(&grey, NormalY::Up, false, &Job::default()).is_err());
    }
}
