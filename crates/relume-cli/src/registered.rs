//! Images registered with exemplars: what they mean, and what is read of them.

use std::path::{Path, PathBuf};

use relume::format::{Encoding, FieldFile, MapRole, NormalY, Opened, PictureFormat};
use relume::workflow::RegisteredMap;
use relume::workflow::map_set::is_normal_map;
use relume::{Error, Job, Result};

use crate::context::Context;
use crate::input;

/// Images to rearrange into one output, one for each exemplar.
pub struct Applied {
    pub images: Vec<PathBuf>,
    /// Whether they have a say in the choice of texels.
    pub is_compared: bool,
    /// The file to write.
    pub output: PathBuf,
}

/// The images of one output, read.
pub struct Registered {
    /// What they are and where they go.
    pub applied: Applied,
    /// One for each exemplar.
    pub files: Vec<FieldFile>,
}

impl Applied {
    /// Reads the images, which must have the sizes of the exemplars.
    fn read(self, exemplars: &[FieldFile], context: &Context) -> Result<Registered> {
        let files = read_all(&self.images, None, context, input::registered)?;
        for ((image, exemplar), path) in files.iter().zip(exemplars).zip(&self.images) {
            let (found, expected) = (image.field.size(), exemplar.field.size());
            if found != expected {
                return Err(Error::invalid(format!(
                    "is {found} texels and its exemplar {expected}: it must be registered with the exemplar, \
                     texel by texel"
                ))
                .at(path));
            }
        }
        self.check_depth(&files)?;
        Ok(Registered { applied: self, files })
    }

    /// Refuses floating-point data that would be written as colours of whole numbers.
    fn check_depth(&self, files: &[FieldFile]) -> Result<()> {
        let is_float = files.iter().any(|file| matches!(file.encoding, Encoding::Exr(_)));
        match PictureFormat::from_path(&self.output) {
            Ok(PictureFormat::Tiff(_) | PictureFormat::Jpeg { .. }) if is_float && self.role().is_data() => {
                Err(Error::usage(
                    "holds floating-point numbers, and TIFF and JPEG are written with whole ones: write .exr (--apply-format exr)",
                )
                .at(&self.images[0]))
            }
            _ => Ok(()),
        }
    }

    /// What the images mean, by the name of the first.
    pub fn role(&self) -> MapRole {
        MapRole::of_name(&self.images[0])
    }
}

impl Registered {
    /// The map for the library.
    pub fn map(&self) -> RegisteredMap<'_> {
        let fields = self.files.iter().map(|file| &file.field).collect();
        RegisteredMap { role: self.applied.role(), fields }
    }

    /// Whether the images are normals in a picture.
    pub fn is_normal_map(&self) -> bool {
        is_normal_map(&self.files[0].field, self.applied.role())
    }

    /// The direction of Y of the images, by the record or the name of the first.
    pub fn normal_y(&self) -> NormalY {
        let recorded = self.files[0].record.normal_y;
        recorded.or(NormalY::of_name(&self.applied.images[0])).unwrap_or_default()
    }
}

/// The path of a rearranged image, in the format of `extension` or its own, which is PNG for JPEG.
pub fn written_as(path: PathBuf, extension: Option<&str>) -> PathBuf {
    let is_jpeg = matches!(PictureFormat::from_path(&path), Ok(PictureFormat::Jpeg { .. }));
    match extension {
        Some(extension) => path.with_extension(extension.trim_start_matches('.')),
        None if is_jpeg => path.with_extension("png"),
        None => path,
    }
}

/// The maps that have a say in the choice of texels.
pub fn compared<'a>(registered: &'a [Registered]) -> Vec<RegisteredMap<'a>> {
    registered.iter().filter(|one| one.applied.is_compared).map(Registered::map).collect()
}

/// The images of all jobs.
pub fn read_registered(
    jobs: Vec<Applied>,
    exemplars: &[FieldFile],
    context: &Context,
) -> Result<Vec<Registered>> {
    jobs.into_iter().map(|job| job.read(exemplars, context)).collect()
}

/// Reads fields that must be of one kind; the first may have been opened already, as an exemplar.
pub fn read_all(
    paths: &[PathBuf],
    mut first: Option<Opened>,
    context: &Context,
    read: fn(&Path, &Job) -> Result<FieldFile>,
) -> Result<Vec<FieldFile>> {
    let read_one = |path: &PathBuf| match first.take() {
        Some(opened) => opened.into_exemplar(),
        None => read(path, &context.job),
    };
    let files = paths.iter().map(read_one).collect::<Result<Vec<_>>>()?;
    for (file, path) in files.iter().zip(paths) {
        let first = paths[0].display().to_string();
        files[0].field.check_kind(&file.field, &first).map_err(|e| e.at(path))?;
    }
    Ok(files)
}
