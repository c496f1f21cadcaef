//! The outputs of verbs with a source map besides the texture: the map itself, and other registered images
//! rearranged in the same way.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use relume::format::{FieldFile, FieldFormat, Opened};
use relume::synthesis::SourceMap;
use relume::{Error, Job, ReflectanceField, Result};

use crate::context::Context;
use crate::output::Outputs;
use crate::{gathered, input, output};

/// Options for source maps and registered images.
#[derive(Debug, clap::Args)]
#[group(skip)]
pub struct Args {
    /// Also write the source of each texel, as x, y and exemplar: .npy or .exr
    #[arg(long, value_name = "FILE")]
    source_map: Option<PathBuf>,
    /// Also rearrange these registered images in the same way; with several exemplars, one image for
    /// each in turn. OUTPUT_IMAGE beside the output, or IMAGE in --apply-dir
    #[arg(long, value_name = "IMAGE", num_args = 1..)]
    apply: Vec<PathBuf>,
    /// The folder for the images of --apply
    #[arg(long, value_name = "DIR", requires = "apply")]
    apply_dir: Option<PathBuf>,
}

/// Images to rearrange into one output, one for each exemplar.
pub struct Applied<'a> {
    images: &'a [PathBuf],
    /// The file to write.
    pub output: PathBuf,
}

impl Args {
    /// Whether a source map and whether rearranged images are requested.
    pub fn given(&self) -> [(&'static str, bool); 2] {
        [("--source-map", self.source_map.is_some()), ("--apply", !self.apply.is_empty())]
    }

    /// Claims all outputs of a command before the work; it reads `inputs` and also writes `named`, of which
    /// the first is the texture.
    pub fn claim(
        &self,
        inputs: &[&Path],
        named: &[&Path],
        exemplars: usize,
        outputs: &mut Outputs,
    ) -> Result<Vec<Applied<'_>>> {
        let inputs: Vec<&Path> = inputs.iter().copied().chain(self.apply.iter().map(|p| &**p)).collect();
        if inputs.iter().filter(|path| output::is_stream(path)).count() > 1 {
            return Err(Error::usage("standard input can be read only once: give - for one input at most"));
        }
        let jobs = self.jobs(named[0], exemplars)?;
        let all = named.iter().copied().chain(self.source_map.as_deref());
        for path in all.chain(jobs.iter().map(|job| job.output.as_path())) {
            outputs.file(path, &inputs)?;
        }
        if let Some(path) = &self.source_map {
            gathered::check_map(path)?;
        }
        let textures = jobs.iter().map(|job| job.output.as_path()).chain([named[0]]);
        for path in textures.filter(|path| !output::is_stream(path)) {
            FieldFormat::from_path(path)?;
        }
        Ok(jobs)
    }

    fn jobs(&self, output: &Path, exemplars: usize) -> Result<Vec<Applied<'_>>> {
        if !self.apply.len().is_multiple_of(exemplars) {
            return Err(Error::usage(format!(
                "--apply has {} images for {exemplars} exemplars: give one for each exemplar in turn",
                self.apply.len()
            )));
        }
        let job = |images| Ok(Applied { images, output: self.output_of(&images[0], output)? });
        self.apply.chunks(exemplars).map(job).collect()
    }

    /// The path of a rearranged image.
    fn output_of(&self, image: &Path, output: &Path) -> Result<PathBuf> {
        let name = image.file_name().filter(|_| !output::is_stream(image));
        let name = name.ok_or_else(|| Error::usage("has no file name to call its output by").at(image))?;
        if let Some(folder) = &self.apply_dir {
            return Ok(folder.join(name));
        }
        let stem = output.file_stem().filter(|_| !output::is_stream(output)).ok_or_else(|| {
            Error::usage("--apply names its outputs after the output file: give a file or --apply-dir")
        })?;
        let mut joined = OsString::from(stem);
        joined.push("_");
        joined.push(name);
        Ok(output.with_file_name(joined))
    }

    /// The file of the source map, if requested.
    pub fn source_map(&self, map: &SourceMap, context: &Context) -> Result<Option<(PathBuf, Vec<u8>)>> {
        let encode = |path: &PathBuf| Ok((path.clone(), gathered::source_map(map, path, context)?));
        self.source_map.as_ref().map(encode).transpose()
    }
}

impl Applied<'_> {
    /// Reads the images, which must have the sizes of the exemplars.
    pub fn read(&self, exemplars: &[FieldFile], context: &Context) -> Result<Vec<FieldFile>> {
        let images = read_all(self.images, None, context, input::registered)?;
        for ((image, exemplar), path) in images.iter().zip(exemplars).zip(self.images) {
            let (found, expected) = (image.field.size(), exemplar.field.size());
            if found != expected {
                return Err(Error::usage(format!(
                    "is {found} texels and its exemplar {expected}: it must be registered with the exemplar, \
                     texel by texel"
                ))
                .at(path));
            }
        }
        Ok(images)
    }
}

/// The images of all jobs.
pub fn read_registered(
    jobs: &[Applied<'_>],
    exemplars: &[FieldFile],
    context: &Context,
) -> Result<Vec<Vec<FieldFile>>> {
    jobs.iter().map(|job| job.read(exemplars, context)).collect()
}

/// Reads fields that must be of one kind; the first may have been opened already, as an exemplar.
pub fn read_all(
    paths: &[PathBuf],
    mut first: Option<Opened>,
    context: &Context,
    read: fn(&Path, &Job) -> Result<FieldFile>,
) -> Result<Vec<FieldFile>> {
    let kind = |field: &ReflectanceField| {
        format!("{} {} in {} values", field.layout().name(), field.basis().name(), field.space())
    };
    let read_one = |path: &PathBuf| match first.take() {
        Some(opened) => opened.into_exemplar(),
        None => read(path, &context.job),
    };
    let files = paths.iter().map(read_one).collect::<Result<Vec<_>>>()?;
    for (file, path) in files.iter().zip(paths) {
        let (found, expected) = (kind(&file.field), kind(&files[0].field));
        if found != expected {
            return Err(Error::usage(format!(
                "holds {found} and {} {expected}: they must be of one kind",
                paths[0].display()
            ))
            .at(path));
        }
    }
    Ok(files)
}
