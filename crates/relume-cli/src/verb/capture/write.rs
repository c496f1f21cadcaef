//! The files of a capture: photographs with their lights, and the truth.

use rayon::prelude::*;
use relume::capture::dome::Dome;
use relume::capture::lp;
use relume::format::{Depth, ExrDepth, PictureFormat, encode_picture};
use relume::{Direction, Picture, Planes, Result, Space};

use crate::context::Context;
use crate::normals;
use crate::output::Folder;

/// Files of photographs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PhotographFormat {
    /// 8 bits, sRGB-encoded.
    Png,
    /// 16 bits, sRGB-encoded.
    Png16,
    /// 16-bit floats, linear.
    Exr,
}

impl PhotographFormat {
    fn picture_format(self) -> PictureFormat {
        match self {
            Self::Png => PictureFormat::Png(Depth::Eight),
            Self::Png16 => PictureFormat::Png(Depth::Sixteen),
            Self::Exr => PictureFormat::Exr(ExrDepth::Half),
        }
    }

    fn extension(self) -> &'static str {
        match self {
            Self::Png | Self::Png16 => "png",
            Self::Exr => "exr",
        }
    }
}

/// The name of photograph `number`.
pub fn photograph_name(number: usize, format: PhotographFormat) -> String {
    format!("light_{number:03}.{}", format.extension())
}

/// Takes and writes a photograph for every lamp, and `lights.lp`. Returns the fraction of values
/// that the files cannot hold because they are brighter than white.
pub fn photographs(
    dome: &Dome,
    lamps: &[Direction],
    format: PhotographFormat,
    folder: &mut Folder,
    context: &Context,
) -> Result<f64> {
    let photograph = |lamp: &Direction| {
        let picture = dome.photograph(*lamp)?;
        let bright = picture.planes.as_slice().iter().filter(|v| **v > 1.0).count();
        let bytes = encode_picture(&picture, format.picture_format())?;
        context.job.advance(1)?;
        Ok((bytes, bright))
    };
    let mut clipped = 0;
    // A batch at a time, so that memory holds as many photographs as there are threads.
    let batch = rayon::current_num_threads();
    for (number, lamps) in lamps.chunks(batch).enumerate() {
        let taken: Result<Vec<(Vec<u8>, usize)>> = lamps.par_iter().map(photograph).collect();
        for (k, (bytes, bright)) in taken?.into_iter().enumerate() {
            clipped += bright;
            folder.add(photograph_name(number * batch + k, format), &bytes)?;
        }
    }
    let named: Vec<(String, Direction)> =
        lamps.iter().enumerate().map(|(k, lamp)| (photograph_name(k, format), *lamp)).collect();
    folder.add("lights.lp", lp::format(&named).as_bytes())?;
    let values = (lamps.len() * dome.size().texels() * 3) as f64;
    Ok(if format == PhotographFormat::Exr { 0.0 } else { clipped as f64 / values })
}

/// Writes the true normals, albedo and height.
pub fn truth(dome: &Dome, folder: &mut Folder) -> Result<()> {
    let exr = |planes: &Planes| {
        let picture = Picture { planes: planes.clone(), space: Space::Linear };
        encode_picture(&picture, PictureFormat::Exr(ExrDepth::Float))
    };
    folder.add("truth/normals.exr", &exr(dome.normals())?)?;
    folder.add("truth/albedo.exr", &exr(&dome.maps().albedo)?)?;
    folder.add("truth/height.exr", &exr(&dome.maps().height)?)?;
    let packed = normals::encode(dome.normals(), PictureFormat::Png(Depth::Sixteen))?;
    folder.add("truth/normals_gl.png", &packed)
}
