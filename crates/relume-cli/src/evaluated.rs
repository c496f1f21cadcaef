//! Models as textures: where a texture is shown or measured, a model stands for a seamless tile of it.

use std::path::Path;

use relume::field::{Basis, PlaneLayout};
use relume::format::{HeightMap, HeightScale};
use relume::random_field::{FieldModel, RealisationOptions};
use relume::{Error, Job, ReflectanceField, Result, Size};

use crate::{args, input};

/// What to make of a model.
#[derive(Debug, clap::Args)]
#[group(skip)]
#[command(next_help_heading = "Of a .rlm model")]
pub struct Args {
    /// Texels of the seamless tile that is made of the model [default: as many as it is made of,
    /// rounded up until the tile closes]
    #[arg(long, value_name = "WxH", value_parser = args::size)]
    model_size: Option<Size>,
    /// Another seed makes another texture of the model [default: 0]
    #[arg(long, value_name = "N")]
    model_seed: Option<u64>,
}

impl Args {
    /// Reads a texture, or a model and makes one of it.
    pub fn texture(&self, path: &Path, job: &Job) -> Result<ReflectanceField> {
        Ok(self.texture_of(path, job)?.0)
    }

    /// A texture, and the size of what a model of it was made of, else its own.
    pub fn texture_of(&self, path: &Path, job: &Job) -> Result<(ReflectanceField, Size)> {
        let Some(model) = input::model(path, job)? else {
            let field = input::field(path, job)?.field;
            let size = field.size();
            return Ok((field, size));
        };
        let field = self.tile(&model, job).map_err(|e| e.at(path))?;
        Ok((field, Size::new(model.source.width as usize, model.source.height as usize)))
    }

    /// Reads a height map, or the model of one.
    pub fn height(&self, path: &Path, job: &Job) -> Result<HeightMap> {
        let Some(model) = input::model(path, job)? else { return input::height(path, job) };
        if model.basis != Basis::Constant || model.layout != PlaneLayout::LUMINANCE {
            return Err(Error::usage("is not the model of a height map, which has one plane").at(path));
        }
        let samples = self.tile(&model, job).map_err(|e| e.at(path))?.coefficients().clone();
        let mm_per_texel = model.heights.and_then(|heights| heights.mm_per_texel);
        Ok(HeightMap { samples, scale: Some(HeightScale { offset: 0.0, step: 1.0, mm_per_texel }) })
    }

    /// Refuses options of models where none of the inputs is one.
    pub fn check(&self, inputs: &[&Path], job: &Job) -> Result<()> {
        if self.model_size.is_none() && self.model_seed.is_none() {
            return Ok(());
        }
        for path in inputs {
            if input::model(path, job)?.is_some() {
                return Ok(());
            }
        }
        Err(Error::usage("--model-size and --model-seed are for .rlm models, and no input is one"))
    }

    fn tile(&self, model: &FieldModel, job: &Job) -> Result<ReflectanceField> {
        let size = self.model_size.unwrap_or(model.tile_size());
        let seed = self.model_seed.unwrap_or_default();
        model.synthesize(&RealisationOptions { origin: [0, 0], size, seed, period: Some(size) }, job)
    }
}
