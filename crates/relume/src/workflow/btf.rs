//! Textures of light and view (bidirectional texture functions) as they are on disk: a folder or a zip archive of
//! photographs whose names hold the angles of light and view, a `.btf` file, or a measured reflectance, which is the
//! texture of a single texel. Photographs stream: only one a thread is in memory.

use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::brdf::BrdfSamples;
use crate::capture::dome::sampling::{DirectionSampling, all_pairs};
use crate::capture::pairs::{PairList, files_below, first_names, is_set};
use crate::direction::{Direction, Directions};
use crate::error::{Error, Result};
use crate::format::bonn::{BonnBtf, StoredBtf};
use crate::format::{ImageArchive, open, read_raster};
use crate::job::Job;
use crate::names::named;
use crate::numeric::between::Between;
use crate::picture::Picture;
use crate::planes::Planes;
use crate::raster::{Raster, Samples};
use crate::space::Space;

/// The cosine above which a view is that from straight above, within a degree.
pub(super) const FRONTAL_COSINE: f64 = 0.999_847;

/// Shares below this are those of rounding errors: a measured pair is its photograph.
const LEAST_SHARE: f64 = 1e-9;

/// What is done about photographs missing from a grid of lights and views.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Missing {
    /// The set is refused.
    #[default]
    Refuse,
    /// Their values are interpolated from those of the others.
    Fill,
}

named!(Missing { Refuse => "refuse", Fill => "fill" });

/// A texture of light and view on disk.
#[derive(Debug)]
pub struct Btf {
    path: PathBuf,
    list: PairList,
    source: ImageSource,
    /// How photographs that do not exist are made.
    filling: Option<Filling>,
}

/// Interpolation between the photographs that exist, and their numbers.
#[derive(Debug)]
struct Filling {
    between: Between,
    measured: Vec<usize>,
}

#[derive(Debug)]
enum ImageSource {
    /// The path of each photograph.
    Folder(Vec<PathBuf>),
    Archive(ImageArchive),
    Bonn(Box<BonnBtf>),
    Reflectance(Box<BrdfSamples>),
}

/// The extensions of files that are opened as textures of light and view.
const EXTENSIONS: [&str; 5] = ["zip", "btf", "binary", "bin", "bsdf"];

impl Btf {
    /// Whether a path is to be opened as such a texture: a file by its extension (`zip`, `btf`; `binary`, `bin` and `bsdf` of
    /// reflectances), or a folder without a light file that holds photographs with angles in their names.
    pub fn is_at(path: &Path) -> bool {
        if path.is_dir() {
            return is_set(path);
        }
        EXTENSIONS.iter().any(|of| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(of)))
    }

    /// Opens a folder, an archive or a file. Photographs are located, not read; factors of a `.btf` file are read. A
    /// reflectance is taken at the 81 lights and 81 views of the usual measurements.
    ///
    /// # Errors
    /// A `.btf` file or reflectance that is damaged; a folder or archive that cannot be read or holds no photograph with angles in its name, angles that are not
    /// those of a hemisphere, two photographs of one pair, missing ones, unless they are to be filled, and pipes, which can be read only once.
    pub fn open(path: impl AsRef<Path>, missing: Missing, job: &Job) -> Result<Self> {
        let path = path.as_ref();
        check_plain(path)?;
        match path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).as_deref() {
            Some("btf") if !path.is_dir() => Self::of_bonn(path, job),
            Some("binary" | "bin" | "bsdf") if !path.is_dir() => Self::of_reflectance(path, job),
            _ => Self::of_photographs(path, missing, job),
        }
    }

    fn of_bonn(path: &Path, job: &Job) -> Result<Self> {
        let btf = BonnBtf::open(path, job)?;
        let list = PairList::of_directions(btf.pairs());
        Ok(Self::new(path, list, ImageSource::Bonn(Box::new(btf))))
    }

    fn of_reflectance(path: &Path, job: &Job) -> Result<Self> {
        let brdf = open(path, job)?.into_brdf()?;
        let directions = DirectionSampling::Bonn.directions();
        let samples = BrdfSamples::new(brdf, all_pairs(&directions, &directions));
        let list = PairList::of_directions(samples.pairs());
        Ok(Self::new(path, list, ImageSource::Reflectance(Box::new(samples))))
    }

    fn of_photographs(path: &Path, missing: Missing, job: &Job) -> Result<Self> {
        let (names, source) = if path.is_dir() {
            let (names, paths) = files_below(path)?.into_iter().unzip();
            (names, ImageSource::Folder(paths))
        } else {
            let archive = ImageArchive::open(path)?;
            (archive.names().to_vec(), ImageSource::Archive(archive))
        };
        let list = PairList::of_paths(names.iter().map(String::as_str)).map_err(|e| e.at(path))?;
        let list = list.ok_or_else(|| {
            Error::invalid(format!(
                "no photograph has the angles of light and view in its name (found {}): expected names such as \
                 `00008 tl015 pl060 tv030 pv000.jpg`",
                if names.is_empty() { "no file".to_owned() } else { first_names(&names) }
            ))
            .at(path)
        })?;
        if let Some(remark) = list.left_out() {
            job.about(path).remark(remark);
        }
        if missing == Missing::Refuse {
            list.check_complete().map_err(|e| e.at(path))?;
        }
        let btf = Self::new(path, list, source);
        btf.paths().into_iter().try_for_each(check_plain)?;
        Ok(btf)
    }

    fn new(path: &Path, list: PairList, source: ImageSource) -> Self {
        Self { path: path.to_path_buf(), list, source, filling: None }
    }

    /// With the photographs that are missing from a grid made of those around them, by the rule of [`Btf::relit`], in linear
    /// light: no pair is missing then.
    #[must_use]
    pub fn filled(self) -> Self {
        let between = self.between();
        let list = self.list.filled();
        let measured = (0..list.entries.len()).filter(|&i| list.entries[i].index.is_some()).collect();
        Self { list, filling: Some(Filling { between, measured }), ..self }
    }

    /// The folder or archive.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// How a `.btf` file stores it.
    pub fn stored(&self) -> Option<StoredBtf> {
        match &self.source {
            ImageSource::Bonn(btf) => Some(btf.stored()),
            ImageSource::Folder(_) | ImageSource::Archive(_) | ImageSource::Reflectance(_) => None,
        }
    }

    /// The photographs and how they form a grid.
    pub fn list(&self) -> &PairList {
        &self.list
    }

    /// The name and the directions of each photograph, as needed for a fit.
    pub fn pairs(&self) -> Vec<(String, Directions)> {
        self.list.entries.iter().map(|entry| (entry.name.clone(), entry.directions)).collect()
    }

    /// The numbers of the photographs seen from straight above.
    ///
    /// # Errors
    /// When there are none.
    pub fn frontal(&self) -> Result<Vec<usize>> {
        let entries = self.list.entries.iter().enumerate();
        let frontal: Vec<usize> =
            entries.filter(|(_, e)| e.directions.view.z() > FRONTAL_COSINE).map(|(i, _)| i).collect();
        if frontal.is_empty() {
            return Err(Error::usage(
                "no photograph is seen from straight above, as functions of light alone need: fit the basis learned",
            )
            .at(&self.path));
        }
        Ok(frontal)
    }

    /// The paths of the photographs of a folder.
    pub fn paths(&self) -> Vec<&Path> {
        match &self.source {
            ImageSource::Folder(paths) => {
                self.list.entries.iter().filter_map(|e| Some(paths[e.index?].as_path())).collect()
            }
            ImageSource::Archive(_) | ImageSource::Bonn(_) | ImageSource::Reflectance(_) => Vec::new(),
        }
    }

    /// The texture for a light and a view, in linear light: a photograph where the pair is measured, and otherwise a mean of
    /// those around it, weighted as learned functions are between pairs.
    ///
    /// # Errors
    /// As [`Btf::photograph`], and photographs of different sizes or channels.
    pub fn relit(&self, directions: Directions, job: &Job) -> Result<Picture> {
        let picture = self.relit_by(&self.between(), directions, job)?;
        Ok(picture.to_space(Space::Linear))
    }

    /// The rule of interpolation between its pairs, for many pictures.
    pub(super) fn between(&self) -> Between {
        let pairs: Vec<Directions> = self.list.entries.iter().map(|entry| entry.directions).collect();
        Between::new(&pairs)
    }

    /// As [`Btf::relit`], by the rule of [`Btf::between`]; a measured pair is its photograph in the space in which that is
    /// stored, so that no value is rounded.
    pub(super) fn relit_by(&self, between: &Between, directions: Directions, job: &Job) -> Result<Picture> {
        let shares = between.shares(directions);
        let shares = shares.as_slice().iter().filter(|(_, share)| share.abs() > LEAST_SHARE);
        let shares: Vec<(usize, f64)> = shares.copied().collect();
        match shares[..] {
            [(only, _)] => {
                let photograph = self.photograph(only, job)?;
                let space = photograph.samples().space();
                Ok(Picture { planes: photograph.to_planes(space, job)?, space })
            }
            _ => self.mean(&shares, job),
        }
    }

    /// The sum of shares of photographs, in linear light.
    fn mean(&self, shares: &[(usize, f64)], job: &Job) -> Result<Picture> {
        let mut sum: Option<Planes> = None;
        for &(i, share) in shares {
            let photograph = self.photograph(i, job)?;
            let (size, channels) = (photograph.size(), photograph.channels());
            let what = "the pictures around the directions";
            job.check(what, size, 12 * channels as u64)?;
            let planes = photograph.to_picture(Space::Linear).planes;
            let sum = sum.get_or_insert_with(|| Planes::zeros(size, channels));
            if (sum.size(), sum.count()) != (size, channels) {
                return Err(Error::invalid(format!(
                    "the photograph {} is {size} with {channels} channels, others {} with {}: all must be alike",
                    self.list.entries[i].name,
                    sum.size(),
                    sum.count()
                ))
                .at(&self.path));
            }
            let values = sum.as_mut_slice().iter_mut().zip(planes.as_slice());
            values.for_each(|(sum, value)| *sum += share as f32 * value);
        }
        let planes = sum.ok_or_else(|| Error::invalid("there is no photograph").at(&self.path))?;
        Ok(Picture { planes, space: Space::Linear })
    }

    /// Photograph `i`.
    ///
    /// # Errors
    /// The error names the file: one that cannot be read or decoded, or exceeds the limits.
    pub fn photograph(&self, i: usize, job: &Job) -> Result<Raster> {
        let Some(index) = self.list.entries[i].index else { return self.made(i, job) };
        match &self.source {
            ImageSource::Folder(paths) => read_raster(&paths[index], job),
            ImageSource::Archive(archive) => archive.raster(index, job),
            ImageSource::Bonn(btf) => {
                let image = btf.image(index, job).map_err(|e| e.at(&self.path))?;
                let light = self.list.entries[i].directions.light;
                if btf.has_cosine() { Ok(image) } else { lit(&image, light) }
            }
            ImageSource::Reflectance(samples) => {
                let image = samples.image(index, job).map_err(|e| e.at(&self.path))?;
                lit(&image, self.list.entries[i].directions.light)
            }
        }
    }

    /// A photograph that does not exist, of those that do.
    fn made(&self, i: usize, job: &Job) -> Result<Raster> {
        let filling = self.filling.as_ref().ok_or_else(|| Error::invalid("the photograph is missing"))?;
        let shares = filling.between.shares(self.list.entries[i].directions);
        let shares = shares.as_slice().iter().map(|(k, share)| (filling.measured[*k], *share));
        let planes = self.mean(&shares.collect::<Vec<_>>(), job)?.planes;
        let texels = 0..planes.size().texels();
        let samples = texels.flat_map(|t| planes.iter().map(move |plane| plane[t])).collect();
        Raster::new(planes.size(), planes.count(), Samples::F32(samples))
    }
}

/// Refuses what can be read only once, such as a pipe.
fn check_plain(path: &Path) -> Result<()> {
    if !path.exists() || path.is_file() || path.is_dir() {
        return Ok(());
    }
    Err(Error::usage(
        "is a pipe or a device, and photographs under light and view are read more than once: copy it to a file",
    )
    .at(path))
}

/// An image of reflectances as a photograph, which holds the cosine between light and surface.
fn lit(image: &Raster, light: Direction) -> Result<Raster> {
    let values = (0..image.samples().len()).map(|i| image.samples().value(i) * light.z() as f32);
    Raster::new(image.size(), image.channels(), Samples::F32(values.collect()))
}
