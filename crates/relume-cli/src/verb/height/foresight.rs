//! The memory of a surface and of its files, before they are made.

use std::path::{Path, PathBuf};

use relume::format::{Depth, HeightFormat, PictureFormat};
use relume::surface::highlights;
use relume::surface::integrate::{self, SurfaceBorder};
use relume::workflow::memory::MemoryPeak;
use relume::{Footprint, Job, Result, Size};

use super::Args;
use super::compare::KnownShape;
use crate::context::Context;

/// Refuses a surface that the known one does not match, or that cannot be integrated and written within the memory;
/// `channels` are those of its albedo, 0 without one, and `lights` those of photographs.
pub(super) fn foresee(
    args: &Args,
    known: &KnownShape,
    (size, channels, lights): (Size, usize, usize),
    context: &Context,
) -> Result<()> {
    known.check(size)?;
    let files = SurfaceFiles {
        heights: &args.output,
        albedo: args.albedo_map.as_deref(),
        normals: args.normals.as_deref(),
        lobes: args.roughness_map.iter().chain(&args.specular_map).map(PathBuf::as_path).collect(),
        border: args.border,
    };
    files.check(size, channels, lights, &context.job)
}

/// The files of a surface.
pub struct SurfaceFiles<'a> {
    pub heights: &'a Path,
    pub albedo: Option<&'a Path>,
    pub normals: Option<&'a Path>,
    /// Maps of highlights.
    pub lobes: Vec<&'a Path>,
    pub border: SurfaceBorder,
}

impl SurfaceFiles<'_> {
    /// Refuses what cannot be integrated and written within the memory.
    pub fn check(&self, size: Size, channels: usize, lights: usize, job: &Job) -> Result<()> {
        // Slopes in double precision, normals, and the albedo.
        let shape = 16 + 12 + 4 * channels as u64;
        let mut stages = vec![Footprint::of_texels(size, shape, shape)];
        if !self.lobes.is_empty() {
            stages.push(highlights::footprint(size, lights));
        }
        if let (Some(path), true) = (self.albedo, channels > 0) {
            stages.push(PictureFormat::from_path(path)?.footprint(size, channels));
        }
        for path in &self.lobes {
            let format = PictureFormat::from_path(path)?.with_depth(Depth::Sixteen);
            // Beside the plane and its values as they are written.
            stages.push(Footprint::of_texels(size, 8, 8).then(format.footprint(size, 1)));
        }
        stages.push(integrate::footprint(size, self.border));
        stages.push(Footprint { kept: 0, ..HeightFormat::from_path(self.heights)?.footprint(size) });
        if let Some(path) = self.normals {
            stages.push(PictureFormat::from_path(path)?.normals_footprint(size));
        }
        MemoryPeak::of_stages("the surface and its files", stages).check(job)
    }
}
