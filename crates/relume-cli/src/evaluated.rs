//! Models as textures: where a texture is shown or measured, a model is evaluated to a seamless tile, or to a window of its
//! plane.

use std::path::Path;
use std::str::FromStr;

use relume::direction::Directions;
use relume::field::{Basis, ParametricField, PlaneLayout};
use relume::format::{Content, HeightMap, HeightScale, Opened};
use relume::random_field::{FieldModel, Fields, RealisationOptions};
use relume::render::{Pictures, ShownForm};
use relume::workflow::endless::PlaneWindow;
use relume::workflow::model_surface::SurfaceForm;
use relume::{Error, Job, Picture, ReflectanceField, Result, Size};

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
    /// Instead of a seamless tile, this window of the endless plane of the model: left, top, width and height in texels.
    /// Windows agree where they overlap
    #[arg(long, value_name = "X,Y,W,H", value_parser = <PlaneWindow as FromStr>::from_str, allow_hyphen_values = true,
          conflicts_with = "model_size")]
    model_window: Option<PlaneWindow>,
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

/// A texture to compare.
pub enum ComparedTexture {
    /// Functions, or the tile made from a random-field model.
    Field(Texture),
    /// Reflectance models.
    Models(ParametricField),
}

impl ComparedTexture {
    /// What is shown of it.
    pub fn shown(&self) -> ShownForm<'_> {
        match self {
            Self::Field(texture) => (&texture.field).into(),
            Self::Models(models) => models.into(),
        }
    }

    /// Whether it was made from a random-field model.
    pub fn is_made(&self) -> bool {
        matches!(self, Self::Field(texture) if texture.of_model)
    }
}

/// A texture that has a picture for each light and view.
pub enum ShownTexture {
    /// Functions, or the tile made from a random-field model.
    Field(ReflectanceField),
    /// Reflectance models.
    Models(ParametricField),
    /// A random-field model of clusters of photographs, of which a picture takes a few.
    Clusters(Box<FieldModel>, RealisationOptions),
}

impl ShownTexture {
    /// Width and height.
    pub fn size(&self) -> Size {
        match self {
            Self::Field(field) => field.size(),
            Self::Models(models) => models.size(),
            Self::Clusters(_, window) => window.size,
        }
    }

    /// The channels of a picture.
    pub fn channels(&self) -> usize {
        match self {
            Self::Field(field) => field.layout().channels(),
            Self::Models(models) => models.channels(),
            Self::Clusters(model, _) => model.layout.channels(),
        }
    }

    /// The basis of a texture that is the same from all views.
    pub fn basis_of_one_view(&self) -> Option<&Basis> {
        match self {
            Self::Field(field) => Some(field.basis()).filter(|basis| !basis.depends_on_view()),
            Self::Models(_) | Self::Clusters(..) => None,
        }
    }

    /// What makes pictures of it for many lights and views.
    pub fn pictures(&self, job: &Job) -> Result<ShownPictures<'_>> {
        Ok(match self {
            Self::Field(field) => ShownPictures::Texture(ShownForm::from(field).pictures(job)?),
            Self::Models(models) => ShownPictures::Texture(ShownForm::from(models).pictures(job)?),
            Self::Clusters(model, window) => ShownPictures::Clusters(model, *window),
        })
    }

    /// What its normals and colours come from.
    pub fn into_surface(self, job: &Job) -> Result<SurfaceForm> {
        Ok(match self {
            Self::Field(field) => SurfaceForm::Functions(field),
            Self::Models(models) => SurfaceForm::of_models(&models, job)?,
            Self::Clusters(model, window) => SurfaceForm::Functions(model.synthesize(&window, job)?),
        })
    }
}

/// Pictures of a texture.
pub enum ShownPictures<'a> {
    Texture(Pictures<'a>),
    Clusters(&'a FieldModel, RealisationOptions),
}

impl ShownPictures<'_> {
    /// The picture for a light and a view.
    pub fn picture(&self, directions: Directions, job: &Job) -> Result<Picture> {
        match self {
            Self::Texture(pictures) => pictures.picture(directions, job),
            Self::Clusters(model, window) => {
                let picture = model.cluster_picture(directions, window, job)?;
                picture.ok_or_else(|| Error::invalid("the model has no clusters of photographs"))
            }
        }
    }
}

impl Args {
    /// Reads the only texture of a command, evaluating a model.
    pub fn texture(&self, path: &Path, job: &Job) -> Result<ReflectanceField> {
        let texture = self.texture_of(path, job)?;
        self.check(texture.of_model)?;
        Ok(texture.field)
    }

    /// Reads the only texture of a command that shows it for lights and views: reflectance models as they are.
    pub fn shown(&self, path: &Path, job: &Job) -> Result<ShownTexture> {
        let opened = input::open(path, job)?;
        if let Some(models) = opened.parametric()? {
            self.check(false)?;
            return Ok(ShownTexture::Models(models));
        }
        if opened.content() == Content::Model {
            let model = opened.into_model()?;
            let window = self.window(&model);
            if let Fields::Clusters(_) = &model.fields {
                return Ok(ShownTexture::Clusters(Box::new(model), window));
            }
            return self.tile(&model, job).map(ShownTexture::Field).map_err(|e| e.at(path));
        }
        let texture = self.texture_in(opened, path, job)?;
        self.check(texture.of_model)?;
        Ok(ShownTexture::Field(texture.field))
    }

    /// Reads a texture to compare: reflectance models as they are; [`Args::check`] follows.
    pub fn compared(&self, path: &Path, job: &Job) -> Result<ComparedTexture> {
        let opened = input::open(path, job)?;
        match opened.parametric()? {
            Some(models) => Ok(ComparedTexture::Models(models)),
            None => self.texture_in(opened, path, job).map(ComparedTexture::Field),
        }
    }

    /// Reads a texture, evaluating a model; [`Args::check`] follows.
    pub fn texture_of(&self, path: &Path, job: &Job) -> Result<Texture> {
        self.texture_in(input::open(path, job)?, path, job)
    }

    fn texture_in(&self, opened: Opened, path: &Path, job: &Job) -> Result<Texture> {
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
        if let Some(samples) = model.range_map(&self.window(&model), job).map_err(|e| e.at(path))? {
            let scale = HeightScale { offset: 0.0, step: 1.0, mm_per_texel: None };
            return Ok((HeightMap { samples, scale: Some(scale) }, true));
        }
        if model.basis != Basis::Constant || model.layout != PlaneLayout::LUMINANCE {
            return Err(Error::usage("is not the model of a height map, which has one plane").at(path));
        }
        let samples = self.tile(&model, job).map_err(|e| e.at(path))?.coefficients().clone();
        let mm_per_texel = model.heights.and_then(|heights| heights.mm_per_texel);
        Ok((HeightMap { samples, scale: Some(HeightScale { offset: 0.0, step: 1.0, mm_per_texel }) }, true))
    }

    /// Refuses options of models where none of the inputs was one.
    pub fn check(&self, any_model: bool) -> Result<()> {
        let is_given = self.has_size() || self.model_seed.is_some();
        if any_model || !is_given {
            return Ok(());
        }
        Err(Error::usage(
            "--model-size, --model-window and --model-seed are for .rlm models, and no input is one",
        ))
    }

    /// Whether a part of the plane was asked for.
    pub fn has_size(&self) -> bool {
        self.model_size.is_some() || self.model_window.is_some()
    }

    /// The seed of the texture made from a model.
    pub fn seed(&self) -> u64 {
        self.model_seed.unwrap_or_default()
    }

    /// What is made of a model: a seamless tile, unless a window is asked for.
    pub fn tile(&self, model: &FieldModel, job: &Job) -> Result<ReflectanceField> {
        model.synthesize(&self.window(model), job)
    }

    /// What is made of a model.
    fn window(&self, model: &FieldModel) -> RealisationOptions {
        let seed = self.seed();
        if let Some(PlaneWindow { x, y, size }) = self.model_window {
            return RealisationOptions { origin: [x, y], size, seed, period: None };
        }
        let size = self.model_size.unwrap_or(model.tile_size());
        RealisationOptions { origin: [0, 0], size, seed, period: Some(size) }
    }
}
