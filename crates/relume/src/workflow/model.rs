//! Models of a texture as a random field: of its functions jointly, of structure and detail if it is regular,
//! or of the pictures under several lights.

use std::fmt;

use crate::capture::dome;
use crate::direction::Direction;
use crate::error::{Error, Result};
use crate::field::{Domain, IndexSpace, Metric, ReflectanceField};
use crate::format::rlm;
use crate::job::Job;
use crate::names::named;
use crate::planes::Planes;
use crate::random_field::{
    Budget, Character, FieldModel, LevelReport, ModelOptions, Tiles, combine_field, model_field, model_lights,
};
use crate::render::relight;
use crate::size::Size;
use crate::synthesis::roller::{RollerOptions, roll};
use crate::synthesis::{BlockOptions, Boundary, Exemplar, SourceMap, gather, synthesize};

/// The least side of a texture with enough periods to cut tiles from.
const LEAST_SIDE: usize = 64;

/// The default number of lights: twice the number of functions of a polynomial texture map.
const CUSTOMARY_LIGHTS: usize = 12;

/// When the structure is modelled by compressed tiles and only the detail by the random field.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Combine {
    /// For regular materials at least 64 texels wide.
    #[default]
    Auto,
    /// Always.
    Always,
    /// Never.
    Never,
}

named!(Combine { Auto => "auto", Always => "always", Never => "never" });

impl Combine {
    /// Whether a material of this kind and size is modelled by structure and detail.
    pub fn applies(self, kind: &Character, size: Size) -> bool {
        match self {
            Self::Auto => kind.is_regular() && size.width.min(size.height) >= LEAST_SIDE,
            Self::Always => true,
            Self::Never => false,
        }
    }
}

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
    /// The most bytes of the structure; `None` for 3000 plus 900 for each plane of the index.
    pub structure_bytes: Option<usize>,
    /// The number of tiles of the structure.
    pub tiles: usize,
    /// How functions of light direction are modelled.
    pub lights: LightModels,
}

impl Default for ModelRequest {
    /// The default options: structure from one tile if the material is regular, functions jointly.
    fn default() -> Self {
        Self {
            options: ModelOptions::default(),
            combine: Combine::default(),
            structure_bytes: None,
            tiles: 1,
            lights: LightModels::default(),
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
    fn tile(self) -> Size {
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
        if let Some(lights) = self.chosen_lights(field)? {
            let picture = |light| relight(field, light).planes;
            let (model, levels) = model_lights(field, &lights, &picture, &self.options, job)?;
            return Ok(FittedModel { model, levels, structure: None });
        }
        if self.combine.applies(kind, field.size()) {
            return self.combined(field, job);
        }
        let (model, levels) = model_field(field, &self.options, job)?;
        Ok(FittedModel { model, levels: vec![levels], structure: None })
    }

    /// The lights under which pictures of a field are modelled; `None` for a joint model.
    fn chosen_lights(&self, field: &ReflectanceField) -> Result<Option<Vec<Direction>>> {
        let LightModels::PerLight(lights) = &self.lights else { return Ok(None) };
        if field.basis().len() == 1 {
            return Err(Error::usage(
                "models per light are for functions of light direction, and this is a picture",
            ));
        }
        if self.combine == Combine::Always {
            return Err(Error::usage(
                "a structure cannot be combined with models per light: models of single lights have none",
            ));
        }
        Ok(Some(if lights.is_empty() { dome::lights(CUSTOMARY_LIGHTS) } else { lights.clone() }))
    }

    fn combined(&self, field: &ReflectanceField, job: &Job) -> Result<FittedModel> {
        let space = IndexSpace::new(field, Metric::Function, Domain::Hemisphere)?;
        job.check("the index of the exemplar", field.size(), 4 * space.planes() as u64)?;
        let (map, source) = self.structure(&space.index_planes(field), job)?;
        let texels = gather(&map, &[field], job)?;
        let tiles = Tiles { texels: &texels, size: source.tile() };
        let bytes = self.structure_bytes.unwrap_or_else(|| 3000 + 900 * space.planes());
        let budget = Budget { bytes, cost: &rlm::structure_bytes };
        let (model, levels) = combine_field(field, tiles, &budget, &self.options, job)?;
        Ok(FittedModel { model, levels: vec![levels], structure: Some(source) })
    }

    /// Tiles by the Roller, or, where their seams would show, one synthesised from blocks on a torus.
    fn structure(&self, index: &Planes, job: &Job) -> Result<(SourceMap, StructureSource)> {
        let exemplar = Exemplar { index, excluded: None };
        let options = RollerOptions { tiles: self.tiles, ..RollerOptions::default() };
        let rolled = roll(&exemplar, &options, job)?;
        if rolled.report.is_acceptable() || self.tiles > 1 {
            let (tile, count) = (rolled.tiles.tile(), rolled.tiles.count());
            return Ok((rolled.tiles.map().clone(), StructureSource::Roller { count, tile }));
        }
        let size = index.size();
        let block = (size.width.min(size.height) / 4).max(8);
        let options = BlockOptions {
            size,
            block,
            overlap: BlockOptions::customary_overlap(block),
            boundary: Boundary::Torus,
            ..BlockOptions::default()
        };
        let made = synthesize(&[exemplar], &options, job)?;
        Ok((made.map, StructureSource::Blocks { tile: size, block }))
    }
}
