//! Models as textures: where a texture is shown or measured, a model is evaluated to a seamless tile.

use std::path::Path;

use relume::field::{Basis, PlaneLayout};
use relume::format::{Content, HeightMap, HeightScale};
use relume::random_field::{FieldModel, RealisationOptions};
use relume::{Error, Job, ReflectanceField, Result, Size};

use crate::{args, input};

/// Options of the evaluation.
#[derive(Debug, Default, clap::Args)]
#[group(skip)]
#[command(next_help_heading = "Of a .rlm model")]
pub struct Args {
    /// Size in texels of the seamless tile made from the model [default: that of its source, rounded up until
    /// the tile closes]
    #[arg(long, value_name = "WxH", value_parser = args::size)]
    model_size: Option<Size>,
    /// Another seed makes another texture from the model [default: 0]
    #[arg(long, value_name = "N")]
    model_seed: Option<u64>,
}

/// A texture to show or measure.
pub struct Texture {
    /// The texture, or the tile made from its model.
    pub field: ReflectanceField,
    /// The size of the source of a model, otherwise that of the texture.
    pub source: Size,
    /// Whether it was made from a model.
    pub of_model: bool,
}

impl Args {
    /// Reads the only texture of a command, evaluating a model.
    pub fn texture(&self, path: &Path, job: &Job) -> Result<ReflectanceField> {
        let texture = self.texture_of(path, job)?;
        self.check(texture.of_model)?;
        Ok(texture.field)
    }

    /// Reads a texture, evaluating a model; [`Args::check`] follows.
    pub fn texture_of(&self, path: &Path, job: &Job) -> Result<Texture> {
        let opened = input::open(path, job)?;
        if opened.content() != Content::Model {
            let field = opened.into_field()?.field;
            return Ok(Texture { source: field.size(), field, of_model: false });
        }
        let model = opened.into_model()?;
        let field = self.tile(&model, job).map_err(|e| e.at(path))?;
        let source = Size::new(model.source.width as usize, model.source.height as usize);
        Ok(Texture { field, source, of_model: true })
    }

    /// Reads a height map, or the model of one, and tells which it was.
    pub fn height(&self, path: &Path, job: &Job) -> Result<(HeightMap, bool)> {
        let opened = input::open(path, job)?;
        if opened.content() != Content::Model {
            return Ok((opened.into_height()?, false));
        }
        let model = opened.into_model()?;
        if model.basis != Basis::Constant || model.layout != PlaneLayout::LUMINANCE {
            return Err(Error::usage("is not the model of a height map, which has one plane").at(path));
        }
        let samples = self.tile(&model, job).map_err(|e| e.at(path))?.coefficients().clone();
        let mm_per_texel = model.heights.and_then(|heights| heights.mm_per_texel);
        Ok((HeightMap { samples, scale: Some(HeightScale { offset: 0.0, step: 1.0, mm_per_texel }) }, true))
    }

    /// Refuses options of models where none of the inputs was one.
    pub fn check(&self, any_model: bool) -> Result<()> {
        if any_model || (self.model_size.is_none() && self.model_seed.is_none()) {
            return Ok(());
        }
        Err(Error::usage("--model-size and --model-seed are for .rlm models, and no input is one"))
    }

    /// Whether the size of the tile was given.
    pub fn has_size(&self) -> bool {
        self.model_size.is_some()
    }

    /// The seed of the texture made from a model.
    pub fn seed(&self) -> u64 {
        self.model_seed.unwrap_or_default()
    }

    /// A seamless tile of a model.
    pub fn tile(&self, model: &FieldModel, job: &Job) -> Result<ReflectanceField> {
        let size = self.model_size.unwrap_or(model.tile_size());
        let seed = self.seed();
        model.synthesize(&RealisationOptions { origin: [0, 0], size, seed, period: Some(size) }, job)
    }
}
