//! Captures of a virtual dome: photographs under all lamps as files, one batch at a time.

use std::path::Path;

use crate::capture::dome::Dome;
use crate::capture::dome::mirror_balls::BallStrip;
use crate::capture::lp;
use crate::direction::Direction;
use crate::error::{Error, Result};
use crate::format::{Depth, ExrDepth, JPEG_QUALITY, PictureFormat, encode_picture_with};
use crate::job::Job;
use crate::memory::Footprint;
use crate::names::named;
use crate::parallel;
use crate::size::Size;
use crate::space::Space;

/// File formats of photographs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PhotographFormat {
    /// 8 bits, sRGB-encoded.
    #[default]
    Png,
    /// 16 bits, sRGB-encoded.
    Png16,
    /// 16-bit floats, linear.
    Exr,
    /// 8 bits, sRGB-encoded, compressed with loss.
    Jpeg,
}

named!(PhotographFormat { Png => "png", Png16 => "png16", Exr => "exr", Jpeg => "jpg" });

impl PhotographFormat {
    pub(super) fn picture_format(self) -> PictureFormat {
        match self {
            Self::Jpeg => PictureFormat::Jpeg { quality: JPEG_QUALITY },
            Self::Png => PictureFormat::Png(Depth::Eight),
            Self::Png16 => PictureFormat::Png(Depth::Sixteen),
            Self::Exr => PictureFormat::Exr(ExrDepth::Half),
        }
    }

    /// The name of photograph `number`.
    pub fn file_name(self, number: usize) -> String {
        format!("light_{number:03}.{}", self.extension())
    }

    /// The extension of the files.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Png | Self::Png16 => "png",
            Self::Exr => "exr",
            Self::Jpeg => "jpg",
        }
    }

    /// The space of the values in the files.
    pub fn space(self) -> Space {
        match self {
            Self::Png | Self::Png16 | Self::Jpeg => Space::Srgb,
            Self::Exr => Space::Linear,
        }
    }
}

/// The name of the light file.
pub const LIGHT_FILE: &str = "lights.lp";

/// The memory of one photograph and its file, beside the dome.
pub fn footprint(size: Size, format: PhotographFormat) -> Footprint {
    Dome::photograph_footprint(size).then(format.picture_format().footprint(size, 3))
}

/// What is photographed, and with what.
#[derive(Debug, Clone, Copy)]
pub struct Shoot<'a> {
    /// The surface under the dome.
    pub dome: &'a Dome,
    /// The lamps, one photograph each.
    pub lamps: &'a [Direction],
    /// Mirror balls at the right of every photograph.
    pub balls: Option<&'a BallStrip>,
    /// The format of the files.
    pub format: PhotographFormat,
}

/// Takes a photograph for every lamp and passes its name and bytes to `keep`, in order, and the light file
/// last. Returns the fraction of values brighter than white, which the files cannot hold. Memory holds as
/// many photographs as there are threads, or as fit.
///
/// # Errors
/// No lamps, errors of the dome or of `keep`, and a cancelled job.
pub fn photographs(shoot: Shoot, job: &Job, keep: &mut dyn FnMut(&str, &[u8]) -> Result<()>) -> Result<f64> {
    let Shoot { dome, lamps, balls, format } = shoot;
    if lamps.is_empty() {
        return Err(Error::usage("a capture needs at least one lamp, found none"));
    }
    // What is brighter than white is returned instead.
    let unheard = job.unheard();
    let photograph = |lamp: &Direction| {
        let surface = dome.photograph_within(*lamp, job)?;
        let picture = match balls {
            Some(strip) => strip.beside(&surface, *lamp, dome.options().lamp_radius_rad),
            None => surface,
        };
        let bright = picture.planes.as_slice().iter().filter(|v| **v > 1.0).count();
        let bytes = encode_picture_with(&picture, format.picture_format(), &unheard)?;
        job.advance(1)?;
        Ok((bytes, bright))
    };
    job.start("photographing", lamps.len() as u64);
    let mut clipped = 0;
    let size = balls.map_or(dome.size(), BallStrip::size);
    let one = footprint(size, format).peak;
    let fitting = usize::try_from(job.free_bytes() / one.max(1)).unwrap_or(usize::MAX);
    let batch = rayon::current_num_threads().min(lamps.len()).min(fitting).max(1);
    job.check_bytes("the photographs taken at a time", one * batch as u64)?;
    for (number, lamps) in lamps.chunks(batch).enumerate() {
        let taken: Result<Vec<(Vec<u8>, usize)>> = parallel::try_map(lamps.iter(), photograph);
        for (k, (bytes, bright)) in taken?.into_iter().enumerate() {
            clipped += bright;
            keep(&format.file_name(number * batch + k), &bytes)?;
        }
    }
    let named: Vec<(String, Direction)> =
        lamps.iter().enumerate().map(|(k, lamp)| (format.file_name(k), *lamp)).collect();
    keep(LIGHT_FILE, lp::format(&named)?.as_bytes())?;
    let values = (lamps.len() * size.texels() * 3) as f64;
    Ok(if format == PhotographFormat::Exr { 0.0 } else { clipped as f64 / values })
}

/// Writes photographs under every lamp into a folder, which is created if missing, with their light file.
///
/// # Errors
/// As [`photographs`], and errors of the system.
pub fn save(dome: &Dome, lamps: &[Direction], folder: impl AsRef<Path>, job: &Job) -> Result<()> {
    let folder = folder.as_ref();
    std::fs::create_dir_all(folder).map_err(|e| Error::io("cannot make the folder", &e).at(folder))?;
    let mut keep = |name: &str, bytes: &[u8]| {
        let path = folder.join(name);
        std::fs::write(&path, bytes).map_err(|e| Error::io("cannot write the file", &e).at(&path))
    };
    let shoot = Shoot { dome, lamps, balls: None, format: PhotographFormat::default() };
    photographs(shoot, job, &mut keep).map(|_| ())
}
