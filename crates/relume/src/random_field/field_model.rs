//! Models of reflectance fields: one joint model over all index planes, or one model per light.

use serde::Serialize;

use super::clusters::PhotographClusters;
use super::combine::{Budget, combine};
use super::estimate::{LevelReport, ModelOptions, estimate};
use super::levels::REFERENCE_WINDOW;
use super::model::{Model, RealisationOptions};
use super::per_light::{self, LightModel};
use super::structure::Tiles;
use crate::direction::Direction;
use crate::error::Result;
use crate::field::{Basis, Domain, IndexSpace, Metric, PlaneLayout, ReflectanceField};
use crate::job::Job;
use crate::planes::Planes;
use crate::size::Size;
use crate::space::Space;

/// The index planes of a field, in messages.
const MODELLED: &str = "the index planes to model";
/// The field made of its models, in messages.
const MADE: &str = "the texture of the models";

/// A model and the meaning of its planes.
#[derive(Debug, Clone, PartialEq)]
pub struct FieldModel {
    /// The functions of light direction.
    pub basis: Basis,
    /// The layout of the planes.
    pub layout: PlaneLayout,
    /// The encoding of the values.
    pub space: Space,
    /// The texture that was modelled.
    pub source: ModelSource,
    /// For heights in texels, the size of a texel.
    pub heights: Option<Heights>,
    /// The random fields.
    pub fields: Fields,
}

/// The size of the texels of a height map.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Heights {
    /// Millimetres, if known.
    pub mm_per_texel: Option<f64>,
}

/// The random fields of a texture.
#[derive(Debug, Clone, PartialEq)]
pub enum Fields {
    /// One of all index planes.
    Joint(Box<Model>),
    /// One of the colours under each light.
    PerLight(Vec<LightModel>),
    /// One of the colours of each cluster of photographs.
    Clusters(PhotographClusters),
}

impl Fields {
    /// The models, with their lights.
    pub fn models(&self) -> Vec<(Option<Direction>, &Model)> {
        match self {
            Self::Joint(model) => vec![(None, model)],
            Self::PerLight(lights) => {
                lights.iter().map(|light| (Some(light.light()), &light.model)).collect()
            }
            Self::Clusters(clusters) => clusters.models.iter().map(|model| (None, model)).collect(),
        }
    }
}

/// The texture that a model was made from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct ModelSource {
    /// Texels along x.
    pub width: u32,
    /// Texels along y.
    pub height: u32,
    /// The number of photographs the texture was fitted to; 1 for a picture, 0 if unknown.
    pub photographs: u32,
    /// Channels of each.
    pub channels: u32,
}

/// Fits a model to the index planes of a field; see [`estimate`].
///
/// # Errors
/// As [`estimate`].
pub fn model_field(
    field: &ReflectanceField,
    options: &ModelOptions,
    job: &Job,
) -> Result<(FieldModel, Vec<LevelReport>)> {
    let space = index_space(field)?;
    let options = ModelOptions { color: color_planes(field), ..*options };
    let (model, reports) = estimate(&space.index_planes_within(field, job, MODELLED)?, &options, job)?;
    Ok((FieldModel::of(field, Fields::Joint(Box::new(model))), reports))
}

/// The first of the three index planes that hold the colour of a texel: of pictures, and of products of a
/// luminance and a colour.
fn color_planes(field: &ReflectanceField) -> Option<usize> {
    if field.layout().is_product() {
        return Some(field.basis().len());
    }
    (field.basis().len() == 1 && *field.layout() == PlaneLayout::RGB).then_some(0)
}

/// Fits a model of structure and detail to the index planes of a field and of tiles made from it; see
/// [`combine`].
///
/// # Errors
/// As [`combine`].
pub fn combine_field(
    field: &ReflectanceField,
    tiles: Tiles<'_, ReflectanceField>,
    budget: &Budget<'_>,
    options: &ModelOptions,
    job: &Job,
) -> Result<(FieldModel, Vec<LevelReport>)> {
    let space = index_space(field)?;
    let laid = space.index_planes_within(tiles.texels, job, "the index planes of the tiles")?;
    let tiles = Tiles { texels: &laid, size: tiles.size };
    let options = ModelOptions { color: color_planes(field), ..*options };
    let (model, reports) =
        combine(&space.index_planes_within(field, job, MODELLED)?, tiles, budget, &options, job)?;
    Ok((FieldModel::of(field, Fields::Joint(Box::new(model))), reports))
}

/// The modelled index planes: the coordinates of the functions over the hemisphere, and for LRGB fields those
/// of the luminance and the colour, so that the output is LRGB again.
pub fn index_space(field: &ReflectanceField) -> Result<IndexSpace> {
    if !field.layout().is_product() {
        return IndexSpace::new(field, Metric::Function, Domain::Hemisphere);
    }
    // Models of polynomials have used the nine numbers of HPL-2003-16 from the start.
    let square = field.basis().is_defined_over(Domain::Square);
    let domain = if square { Domain::Square } else { Domain::Hemisphere };
    IndexSpace::new(field, Metric::LuminanceAndColor, domain)
}

/// The field with one function per channel; for LRGB, the nearest products of a luminance and a colour.
fn like_functions(like: &ReflectanceField, functions: Planes, job: &Job) -> Result<ReflectanceField> {
    if !like.layout().is_product() {
        return like.with_coefficients(functions);
    }
    job.check(MADE, functions.size(), 12 * functions.count() as u64)?;
    let channels = ReflectanceField::new(like.basis().clone(), PlaneLayout::RGB, like.space(), functions)?;
    let space = |field| IndexSpace::new(field, Metric::Function, Domain::Hemisphere);
    space(like)?.field(like, &space(&channels)?.index_planes_within(&channels, job, MADE)?)
}

impl FieldModel {
    /// A model of a field.
    pub(super) fn of(field: &ReflectanceField, fields: Fields) -> Self {
        let Size { width, height } = field.size();
        // Planes within the limits have sides below 2^32.
        let source = ModelSource {
            width: width as u32,
            height: height as u32,
            photographs: match field.basis() {
                Basis::Learned(learned) => learned.pairs().len() as u32,
                basis if basis.len() == 1 => 1,
                _ => field.lights().len() as u32,
            },
            channels: field.layout().channels() as u32,
        };
        let (basis, layout, space) = (field.basis().clone(), field.layout().clone(), field.space());
        Self { basis, layout, space, source, heights: None, fields }
    }

    /// A part of the endless field of the model.
    ///
    /// # Errors
    /// As [`Model::synthesize`].
    pub fn synthesize(&self, options: &RealisationOptions, job: &Job) -> Result<ReflectanceField> {
        let like = self.texel()?;
        match &self.fields {
            Fields::Joint(model) => {
                let planes = model.synthesize(options, job)?;
                job.check("the texture of the model", options.size, 8 * planes.count() as u64)?;
                index_space(&like)?.field(&like, &planes)
            }
            Fields::PerLight(lights) => {
                like_functions(&like, per_light::functions(lights, &self.basis, options, job)?, job)
            }
            Fields::Clusters(clusters) => {
                let channels = self.layout.channels();
                like.with_coefficients(clusters.coefficients(&self.basis, channels, options, job)?)
            }
        }
    }

    /// The working memory per texel, in bytes.
    pub fn bytes_per_texel(&self) -> u64 {
        let one = self.fields.models().iter().map(|(_, model)| model.bytes_per_texel()).max().unwrap_or(0);
        match &self.fields {
            Fields::Joint(_) => one,
            // The functions, their index planes and the field.
            Fields::PerLight(_) => one + 12 * (self.basis.len() * self.layout.channels()) as u64,
            Fields::Clusters(_) => one + 4 * (self.basis.len() * self.layout.channels()) as u64,
        }
    }

    /// The least tile as large as the modelled texture: its size, rounded up until a tile closes.
    pub fn tile_size(&self) -> Size {
        let range = match &self.fields {
            Fields::Clusters(clusters) => clusters.range.as_deref(),
            Fields::Joint(_) | Fields::PerLight(_) => None,
        };
        let models = self.fields.models().into_iter().map(|(_, model)| model).chain(range);
        let steps = models.map(Model::tile_steps);
        let [across, down] = steps.reduce(|a, b| [a[0].max(b[0]), a[1].max(b[1])]).unwrap_or([1; 2]);
        let ModelSource { width, height, .. } = self.source;
        Size::new((width as usize).next_multiple_of(across), (height as usize).next_multiple_of(down))
    }

    /// The bytes of the modelled texture, one per sample: of the photographs, or, if their number is unknown,
    /// of the coefficients of the functions. The base of compression ratios.
    pub fn source_bytes(&self) -> u64 {
        let ModelSource { width, height, photographs, channels } = self.source;
        let samples = match photographs {
            0 => self.layout.planes(self.basis.len()) as u64,
            _ => u64::from(photographs) * u64::from(channels),
        };
        u64::from(width) * u64::from(height) * samples
    }

    /// The reference window, a function of the model alone: whatever the windows of a plane must have in
    /// common, such as the scale of their bytes, is derived from it.
    ///
    /// # Errors
    /// More memory than the limits allow.
    pub fn reference_window(&self, job: &Job) -> Result<ReflectanceField> {
        let size = Size::new(REFERENCE_WINDOW, REFERENCE_WINDOW);
        self.synthesize(&RealisationOptions { origin: [0, 0], size, seed: 0, period: None }, job)
    }

    /// A field of one texel of the same kind.
    ///
    /// # Errors
    /// When there is none, which cannot happen for a model that was read or made.
    pub fn texel(&self) -> Result<ReflectanceField> {
        let planes = Planes::zeros(Size::new(1, 1), self.layout.planes(self.basis.len()));
        ReflectanceField::new(self.basis.clone(), self.layout.clone(), self.space, planes)
    }

    /// Whether the number of planes matches the kind of the model, and there are enough lights.
    pub fn is_whole(&self) -> bool {
        match &self.fields {
            Fields::Joint(model) => {
                let space = self.texel().and_then(|texel| index_space(&texel));
                space.is_ok_and(|space| space.planes() == model.planes())
            }
            Fields::Clusters(clusters) => clusters.is_whole(&self.basis, &self.layout),
            Fields::PerLight(lights) => {
                let disks: Vec<[f32; 2]> = lights.iter().map(|light| light.disk).collect();
                lights.iter().all(|light| light.model.planes() == self.layout.channels())
                    && per_light::determine(&disks, &self.basis)
            }
        }
    }
}
