//! Models of a texture as a random field: of its functions jointly, of structure and detail if it is regular,
//! or of the pictures under several lights.

use std::fmt;

use super::likeness::{Likeness, LikenessReference};
use super::packed::packed_field;
use crate::capture::dome;
use crate::direction::Direction;
use crate::error::{Error, Result};
use crate::field::{Basis, Domain, IndexSpace, Metric, ReflectanceField};
use crate::job::Job;
use crate::names::named;
use crate::numeric::lattice::Lattice;
use crate::random_field::{
    Character, FieldModel, LevelReport, ModelOptions, model_field, model_lights, realisation_bytes,
};
use crate::render::relight;
use crate::size::Size;

/// The least side of a texture with enough periods to cut tiles from.
const LEAST_SIDE: usize = 64;

/// The default number of lights: twice the number of functions of a polynomial texture map.
const CUSTOMARY_LIGHTS: usize = 12;

/// The default number of learned functions.
pub const CUSTOMARY_FUNCTIONS: usize = 12;

/// The default bytes of learned functions.
const CUSTOMARY_FUNCTION_BYTES: usize = 48 << 10;

/// The bytes of a model of a picture, which those of its structure are chosen to keep to where the request does
/// not name them.
pub const PICTURE_BYTES: usize = 2000;

/// The excess of a sample of a random field alone up to which no structure is tried: at 1 a sample still passes
/// whose bands or stones are lost, if the halves of the texture differ much.
const NEAR_ENOUGH: f64 = 0.7;

/// When the structure is modelled by compressed tiles and only the detail by the random field.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Combine {
    /// For materials at least 64 texels wide that are regular, or of which a sample of structure and detail is
    /// nearer than a sample of the random field alone that hardly looks like the material.
    #[default]
    Auto,
    /// Always.
    Always,
    /// Never.
    Never,
}

named!(Combine { Auto => "auto", Always => "always", Never => "never" });

/// How functions of light direction are modelled.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum LightModels {
    /// Jointly.
    #[default]
    Joint,
    /// As the pictures under each of these lights; if none are given, under twelve spread over the
    /// hemisphere.
    PerLight(Vec<Direction>),
}

/// The request for a model.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelRequest {
    /// Options of the random field.
    pub options: ModelOptions,
    /// When to combine structure and detail.
    pub combine: Combine,
    /// The most bytes of the structure; `None` for 3000 plus 900 for each plane of the index, and for pictures
    /// that are not regular as many as keep the model to [`PICTURE_BYTES`].
    pub structure_bytes: Option<usize>,
    /// The number of tiles of the structure.
    pub tiles: usize,
    /// The lattice of the texture, if known: the tiles of the structure are whole numbers of its periods. Otherwise
    /// it is measured.
    pub period: Option<Lattice>,
    /// How functions of light direction are modelled.
    pub lights: LightModels,
    /// The most functions of those that a learned basis has.
    pub functions: usize,
    /// The most bytes of these functions.
    pub function_bytes: usize,
}

impl Default for ModelRequest {
    /// The default options: the nearest number of levels, structure from one tile where it helps, functions
    /// jointly.
    fn default() -> Self {
        Self {
            options: ModelOptions { fewer: true, ..ModelOptions::default() },
            combine: Combine::default(),
            structure_bytes: None,
            tiles: 1,
            period: None,
            lights: LightModels::default(),
            functions: CUSTOMARY_FUNCTIONS,
            function_bytes: CUSTOMARY_FUNCTION_BYTES,
        }
    }
}

/// A model and how it was made.
#[derive(Debug, Clone)]
pub struct FittedModel {
    /// The model.
    pub model: FieldModel,
    /// How the levels for each light were chosen; for a joint model, those of the one.
    pub levels: Vec<Vec<LevelReport>>,
    /// The origin of the structure.
    pub structure: Option<StructureSource>,
    /// Whether a made sample looks like the material; `None` for textures that are too small to tell.
    pub likeness: Option<Likeness>,
}

/// The origin of the tiles of a structure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StructureSource {
    /// Tiles of whole periods.
    Roller {
        /// The number of tiles.
        count: usize,
        /// The size of each.
        tile: Size,
    },
    /// One tile synthesised from blocks on a torus, where the seams of the Roller would show.
    Blocks {
        /// The size of the tile.
        tile: Size,
        /// The side of the blocks.
        block: usize,
    },
}

impl StructureSource {
    /// The size of a tile.
    pub(super) fn tile(self) -> Size {
        match self {
            Self::Roller { tile, .. } | Self::Blocks { tile, .. } => tile,
        }
    }
}

impl fmt::Display for StructureSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Roller { count, tile } => write!(f, "{count} x {tile} texels by the Roller"),
            Self::Blocks { tile, block } => write!(f, "{tile} texels of blocks of {block}"),
        }
    }
}

impl ModelRequest {
    /// Models a field of this character.
    ///
    /// # Errors
    /// Options without meaning, per-light models of pictures or with a structure, textures that are too
    /// small, and limits exceeded.
    pub fn fit(&self, field: &ReflectanceField, kind: &Character, job: &Job) -> Result<FittedModel> {
        if self.period.is_some() && (self.combine == Combine::Never || self.lights != LightModels::Joint) {
            return Err(Error::usage(
                "periods are those of the structure: models without a structure, or per light, have none",
            ));
        }
        let packed = packed_field(field, self.functions, self.function_bytes, job)?;
        let field = packed.as_ref().unwrap_or(field);
        let index = IndexSpace::new(field, Metric::Function, Domain::Hemisphere)?.planes();
        self.foresee(field.size(), index, field.coefficients().count(), job)?;
        let reference = LikenessReference::of(field, job)?;
        let compared = |mut fitted: FittedModel| -> Result<FittedModel> {
            let likeness = reference.as_ref().map(|reference| reference.likeness(&fitted.model, job));
            fitted.likeness = likeness.transpose()?;
            Ok(fitted)
        };
        if let Some(lights) = self.chosen_lights(field)? {
            let picture = |light| relight(field, light).planes;
            let (model, levels) = model_lights(field, &lights, &picture, &self.options, job)?;
            return compared(FittedModel { model, levels, structure: None, likeness: None });
        }
        let Size { width, height } = field.size();
        let may_combine = self.combine == Combine::Auto && width.min(height) >= LEAST_SIDE;
        let is_periodic = self.combine == Combine::Always || self.period.is_some();
        if !is_periodic && may_combine && kind.is_regular() {
            let small = self.combined_of_few_periods(field, job)?.map(&compared).transpose()?;
            if let Some(small) = small.filter(|small| small.likeness.is_some_and(|likeness| likeness.alike)) {
                return Ok(small);
            }
        }
        if is_periodic || may_combine && kind.is_regular() {
            return compared(self.combined(field, job)?);
        }
        let (model, levels) = model_field(field, &self.options, job)?;
        let plain = compared(FittedModel { model, levels: vec![levels], structure: None, likeness: None })?;
        if !may_combine || plain.likeness.is_none_or(|likeness| likeness.excess <= NEAR_ENOUGH) {
            return Ok(plain);
        }
        // A limit of the memory refuses the request: it must not choose the model.
        let combined = compared(self.combined_within(field, &plain, job)?)?;
        let distance =
            |fitted: &FittedModel| fitted.likeness.map_or(f64::INFINITY, |likeness| likeness.appearance);
        Ok(if distance(&combined) < distance(&plain) { combined } else { plain })
    }

    /// Refuses a joint model of a texture of that size that could be fitted, but not judged by a sample within the memory;
    /// `index` is the number of its index planes, and `planes` that of its coefficients.
    ///
    /// # Errors
    /// Limits exceeded.
    pub fn foresee(&self, size: Size, index: usize, planes: usize, job: &Job) -> Result<()> {
        let Some(sample) = LikenessReference::sample_size(size) else { return Ok(()) };
        if self.lights != LightModels::Joint {
            return Ok(());
        }
        // What a model takes that has as many components as planes, and the sample itself.
        let texel = 4 * (6 * index + planes) as u64;
        job.check_bytes("the sample by which the model is judged", realisation_bytes(sample, texel))
    }

    /// The lights under which pictures of a field are modelled; `None` for a joint model.
    fn chosen_lights(&self, field: &ReflectanceField) -> Result<Option<Vec<Direction>>> {
        let LightModels::PerLight(lights) = &self.lights else { return Ok(None) };
        if field.basis().len() == 1 {
            return Err(Error::usage(
                "models per light are for functions of light direction, and this is a picture",
            ));
        }
        if let Basis::Learned(_) = field.basis() {
            return Err(Error::usage(
                "models per light are of functions of light alone, and these are learned, of light and view: leave out the lights",
            ));
        }
        if self.combine == Combine::Always {
            return Err(Error::usage(
                "a structure cannot be combined with models per light: models of single lights have none",
            ));
        }
        Ok(Some(if lights.is_empty() { dome::lights(CUSTOMARY_LIGHTS) } else { lights.clone() }))
    }
}
