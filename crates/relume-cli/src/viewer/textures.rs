//! Files as the page loads them.

use std::path::{Path, PathBuf};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use relume::format::share::planes::PlaneDepth;
use relume::format::share::{HEADER_NAME, ShareFiles, ShareHeader};
use relume::format::{Content, Encoding, ExrDepth, FieldFile, MapRecord};
use relume::random_field::FieldModel;
use relume::render::Environment;
use relume::synthesis::noise::NoiseOptions;
use relume::workflow::endless::ModelPlane;
use relume::workflow::share::{ShareOptions, block, share, share_model, share_tiles, thumbnail};
use relume::workflow::shared_noise::NoiseFunctions;
use relume::{Error, Job, Named, ReflectanceField, Result};
use serde_json::{Map, Value, json};

use super::annotations::AnnotationFile;
use super::titles::titles;
use crate::{args, evaluated, input};

/// How textures are stored for the page.
#[derive(Debug, Default, clap::Args)]
pub struct PlaneArgs {
    /// Storage of coefficients: kept (8-bit codes of .ptm files and pictures as they are, half floats for others), 8
    /// (bits), or half (floats)
    #[arg(long, value_name = "DEPTH", value_parser = args::named::<PlaneDepth>(), default_value = PlaneDepth::default().name())]
    planes: PlaneDepth,
    /// Show an endless plane of noise made from each texture, as relume synth --method noise does
    #[arg(long)]
    noise: bool,
    /// Side of a texel in millimetres, for the scale bar and the ruler: of all textures, or one for each in the order of the
    /// files, such as 0.05,0.1
    #[arg(long, value_name = "MM", value_parser = args::texel_mm, value_delimiter = ',')]
    mm_per_texel: Vec<f64>,
}

impl PlaneArgs {
    /// The customary storage, of a texture or of noise made from it.
    pub fn usual(noise: bool) -> Self {
        Self { noise, ..Self::default() }
    }

    /// The side of a texel of each of so many textures, where it is given: one for all, or one for each.
    fn texel_sizes(&self, textures: usize) -> Result<Vec<Option<f64>>> {
        match &self.mm_per_texel[..] {
            [] => Ok(vec![None; textures]),
            [of_all] => Ok(vec![Some(*of_all); textures]),
            of_each if of_each.len() == textures => Ok(of_each.iter().copied().map(Some).collect()),
            others => {
                let (given, files) = (others.len(), if textures == 1 { "texture" } else { "textures" });
                Err(Error::usage(format!(
                    "--mm-per-texel has {given} numbers for {textures} {files}: give one for all, or one for each"
                )))
            }
        }
    }
}

/// A texture, ready for the page.
#[derive(Debug)]
pub struct Prepared {
    /// A name for people.
    pub title: String,
    /// The header of its files.
    pub header: ShareHeader,
    /// Its files by name, with the header.
    pub files: Vec<(String, Vec<u8>)>,
    /// A small picture as a JPEG file.
    pub thumbnail: Vec<u8>,
    /// The plane of which a server makes further files.
    pub plane: Option<ServedPlane>,
    /// What was written about it.
    pub annotations: Option<AnnotationFile>,
}

/// Whether there is a server that makes parts of endless planes when they are asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Delivery {
    /// There is one.
    Served,
    /// Everything is in files.
    Stored,
}

/// The endless plane of a model.
#[derive(Debug)]
pub struct ServedPlane {
    model: FieldModel,
    seed: u64,
}

impl ServedPlane {
    /// The file of a square of the plane, by its column and row.
    pub fn block(&self, place: [i64; 2], job: &Job) -> Result<Vec<u8>> {
        block(&ModelPlane { model: &self.model, seed: self.seed, period: None }, place, job)
    }
}

impl Prepared {
    /// What the page is told of it, with fields of its own for the place of its files and annotations.
    pub fn entry(&self, own: Value) -> Value {
        let mut entry = json!({ "title": self.title, "environment": self.header.environment.is_some() });
        if let (Value::Object(all), Value::Object(own)) = (&mut entry, own) {
            all.extend(own);
        }
        entry
    }

    /// The files in base64 by their names.
    pub fn in_base64(&self) -> Value {
        let files = self.files.iter().map(|(name, bytes)| (name.clone(), STANDARD.encode(bytes).into()));
        Value::Object(files.collect::<Map<String, Value>>())
    }
}

/// A file that is to be shown.
#[derive(Debug)]
pub struct TextureSource<'a> {
    /// Where it is.
    pub path: &'a Path,
    /// A name for people.
    pub title: String,
    /// The side of a texel, where it is given.
    pub mm_per_texel: Option<f64>,
}

/// The files of a page, with their titles and the sizes of their texels.
///
/// # Errors
/// More files than a page shows, and another number of sizes than one for all or one for each.
pub fn sources<'a>(files: &'a [PathBuf], planes: &PlaneArgs) -> Result<Vec<TextureSource<'a>>> {
    let named = files.iter().zip(titles(files)?).zip(planes.texel_sizes(files.len())?);
    Ok(named.map(|((path, title), mm_per_texel)| TextureSource { path, title, mm_per_texel }).collect())
}

/// How files are prepared.
#[derive(Debug, Clone, Copy)]
pub struct Preparation<'a> {
    /// The storage of coefficients.
    pub planes: &'a PlaneArgs,
    /// How models are evaluated.
    pub evaluated: &'a evaluated::Args,
    /// Light from all around.
    pub environment: Option<&'a Environment>,
    /// What becomes of endless planes.
    pub delivery: Delivery,
}

impl Preparation<'_> {
    /// Reads a file: a texture, tiles, a picture, or a model; a model is shown as an endless plane where it is served, and as
    /// a seamless tile otherwise or if its size is given.
    pub fn prepared(&self, source: TextureSource, job: &Job) -> Result<Prepared> {
        let TextureSource { path, title, mm_per_texel } = source;
        let options = ShareOptions {
            title: title.clone(),
            depth: self.planes.planes,
            mm_per_texel,
            environment: self.environment.cloned(),
        };
        let annotations = AnnotationFile::beside(path).unwrap_or_else(|error| {
            job.remark(format!(
                "{error}; the texture is shown without annotations, and none are saved over the file"
            ));
            None
        });
        let opened = input::open(path, job)?;
        let (shared, thumbnail, plane) = match opened.content() {
            Content::Tiles if !self.planes.noise => {
                let set = opened.into_tiles()?;
                (share_tiles(&set, &options, job), thumbnail(&set.file.field, job), None)
            }
            Content::Model => {
                let model = opened.into_model()?;
                let field = self.evaluated.tile(&model, job).map_err(|e| e.at(path))?;
                let small = thumbnail(&field, job);
                match self.delivery {
                    Delivery::Served if !self.planes.noise && !self.evaluated.has_size() => {
                        let shared = share_model(&model, &options, job);
                        (shared, small, Some(ServedPlane { model, seed: self.evaluated.seed() }))
                    }
                    _ => (share_field(of_floats(field), self.planes, &options, job), small, None),
                }
            }
            _ => {
                let file = opened.into_field()?;
                let small = thumbnail(&file.field, job);
                (share_field(file, self.planes, &options, job), small, None)
            }
        };
        let shared: ShareFiles = shared.map_err(|e| e.at(path))?;
        let header = (HEADER_NAME.to_owned(), shared.header_bytes());
        let files = std::iter::once(header).chain(shared.files).collect();
        let thumbnail = thumbnail.map_err(|e| e.at(path))?;
        Ok(Prepared { title, header: shared.header, files, thumbnail, plane, annotations })
    }
}

/// The files of a texture, or of noise made from it.
fn share_field(file: FieldFile, planes: &PlaneArgs, options: &ShareOptions, job: &Job) -> Result<ShareFiles> {
    if planes.noise {
        return NoiseFunctions::new(&file.field, &NoiseOptions::default(), job)?.share(options, job);
    }
    share(&file, options, job)
}

/// A computed texture as a file holds it.
fn of_floats(field: ReflectanceField) -> FieldFile {
    let (encoding, record) = (Encoding::Exr(ExrDepth::Float), MapRecord::default());
    FieldFile { field, opacity: None, encoding, record, models: None }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn textures_have_one_size_of_texels_or_each_its_own() {
        let sizes = |given: &[f64], textures| {
            let planes = PlaneArgs { mm_per_texel: given.to_vec(), ..PlaneArgs::default() };
            planes.texel_sizes(textures).map_err(|error| error.to_string())
        };
        assert_eq!(sizes(&[], 2), Ok(vec![None, None]));
        assert_eq!(sizes(&[0.5], 2), Ok(vec![Some(0.5), Some(0.5)]));
        assert_eq!(sizes(&[0.5, 0.1], 2), Ok(vec![Some(0.5), Some(0.1)]));
        let said = |given, textures| {
            format!("--mm-per-texel has {given} numbers for {textures}: give one for all, or one for each")
        };
        assert_eq!(sizes(&[0.5, 0.1, 0.2], 2), Err(said(3, "2 textures")));
        assert_eq!(sizes(&[0.5, 0.1], 1), Err(said(2, "1 texture")));
    }
}
