//! The photographs of a fit, with their directions: a capture, or a texture of light and view.

use std::path::{Path, PathBuf};

use relume::capture::Capture;
use relume::direction::Directions;
use relume::workflow::{Btf, Missing};
use relume::{Job, Raster, Result};

use super::{Args, BasisChoice, Rectangle};
use crate::context::Context;
use crate::output::{self, CaptureFiles};

/// Photographs that are read one at a time.
pub(super) struct Inputs {
    place: PathBuf,
    pairs: Vec<(String, Directions)>,
    warnings: Vec<String>,
    crop: Option<Rectangle>,
    source: PhotographSource,
}

enum PhotographSource {
    Capture {
        paths: Vec<PathBuf>,
        files: CaptureFiles,
    },
    /// The numbers of its photographs that take part.
    Btf {
        btf: Btf,
        chosen: Vec<usize>,
    },
}

impl Inputs {
    /// Locates the photographs, and refuses an output that is one of them.
    pub(super) fn open(args: &Args, is_btf: bool, basis: &BasisChoice, context: &Context) -> Result<Self> {
        if is_btf { Self::of_btf(args, basis, context) } else { Self::of_capture(args) }
    }

    fn of_capture(args: &Args) -> Result<Self> {
        let capture = Capture::open_paired(&args.capture, args.pair)?;
        let paths: Vec<PathBuf> = capture.photographs.iter().map(|p| p.path.clone()).collect();
        let photographs: Vec<&Path> = paths.iter().map(PathBuf::as_path).collect();
        for written in std::iter::once(&args.output).chain(&args.report) {
            output::refuse_input(written, &photographs)?;
        }
        let pairs = capture.lights().into_iter().map(|(name, light)| (name, light.into())).collect();
        let source = PhotographSource::Capture { paths, files: CaptureFiles::of(&capture)? };
        let place = capture.light_file.clone();
        Ok(Self { place, pairs, warnings: capture.warnings, crop: args.crop, source })
    }

    fn of_btf(args: &Args, basis: &BasisChoice, context: &Context) -> Result<Self> {
        let btf = Btf::open(&args.capture, args.missing.unwrap_or_default(), &context.job)?;
        output::refuse_input(&args.output, &btf.paths())?;
        let (mut pairs, mut warnings) = (btf.pairs(), Vec::new());
        let list = btf.list();
        if list.missing_count > 0 && args.missing == Some(Missing::Fill) {
            warnings.push(format!(
                "{} of {} photographs are missing: their values are interpolated from the others",
                list.missing_count,
                list.lights * list.views
            ));
        }
        let mut chosen: Vec<usize> = (0..pairs.len()).collect();
        if *basis != BasisChoice::Learned {
            chosen = btf.frontal()?;
            warnings.push(format!(
                "the functions of {} depend on the light alone: the {} of {} photographs seen from straight above are \
                 fitted; the basis learned holds all",
                basis.name(),
                chosen.len(),
                pairs.len()
            ));
            pairs = chosen.iter().map(|&i| pairs[i].clone()).collect();
        }
        context.job.check_bytes("the list of photographs", 256 * pairs.len() as u64)?;
        let place = btf.path().to_path_buf();
        Ok(Self { place, pairs, warnings, crop: args.crop, source: PhotographSource::Btf { btf, chosen } })
    }

    /// What errors of the whole are about.
    pub(super) fn place(&self) -> &Path {
        &self.place
    }

    /// The name and directions of each photograph.
    pub(super) fn pairs(&self) -> &[(String, Directions)] {
        &self.pairs
    }

    /// What is to be said of them.
    pub(super) fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Photograph `i`, or the part of it that was asked for.
    pub(super) fn photograph(&self, i: usize, job: &Job) -> Result<Raster> {
        let photograph = match &self.source {
            PhotographSource::Capture { paths, files } => files.raster(&paths[i], job)?,
            PhotographSource::Btf { btf, chosen } => btf.photograph(chosen[i], job)?,
        };
        let cropped = self.crop.map(|r| photograph.crop(r.x, r.y, r.size));
        cropped.unwrap_or(Ok(photograph)).map_err(|e| match &self.source {
            PhotographSource::Capture { paths, .. } => e.at(&paths[i]),
            PhotographSource::Btf { .. } => e.at(&self.place),
        })
    }
}
