//! Models of reflectance fields: one joint model over all index planes.

use serde::Serialize;

use super::estimate::{LevelReport, ModelOptions, estimate};
use super::model::{Model, SheetOptions};
use crate::error::Result;
use crate::field::{Basis, ColorModel, Domain, IndexSpace, Metric, ReflectanceField};
use crate::limits::Limits;
use crate::planes::{Planes, Size};
use crate::progress::Progress;
use crate::space::Space;

/// A model and what its planes mean.
#[derive(Debug, Clone, PartialEq)]
pub struct FieldModel {
    /// The functions of light direction.
    pub basis: Basis,
    /// How planes make colours.
    pub color: ColorModel,
    /// What values mean.
    pub space: Space,
    /// What was modelled.
    pub source: Source,
    /// The random field of the index planes.
    pub model: Model,
}

/// What a model was made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Source {
    /// Texels along x.
    pub width: u32,
    /// Texels along y.
    pub height: u32,
    /// Photographs that the texture was fitted to; 1 for a picture.
    pub photographs: u32,
    /// Channels of each.
    pub channels: u32,
}

impl Source {
    /// The bytes of the photographs, one a sample: the base of compression ratios.
    pub fn bytes(&self) -> u64 {
        [self.width, self.height, self.photographs, self.channels].iter().map(|&v| u64::from(v)).product()
    }
}

/// Fits a model to the index planes of a field; see [`estimate`].
///
/// # Errors
/// As [`estimate`].
pub fn model_field(
    field: &ReflectanceField,
    options: &ModelOptions,
    limits: &Limits,
    progress: &dyn Progress,
) -> Result<(FieldModel, Vec<LevelReport>)> {
    let space = index_space(field)?;
    limits.check("the index planes to model", field.size(), 4 * space.planes() as u64)?;
    let (model, reports) = estimate(&space.index_planes(field), options, limits, progress)?;
    let Size { width, height } = field.size();
    // Planes within the limits have sides below 2^32.
    let source = Source {
        width: width as u32,
        height: height as u32,
        photographs: field.lights().len().max(1) as u32,
        channels: field.color().channels() as u32,
    };
    let model =
        FieldModel { basis: field.basis(), color: field.color(), space: field.space(), source, model };
    Ok((model, reports))
}

/// The index planes that are modelled: the functions' coordinates over the hemisphere, and of LRGB
/// fields the luminance's and the colour, so that what is made is LRGB again.
pub fn index_space(field: &ReflectanceField) -> Result<IndexSpace> {
    let metric = if field.color() == ColorModel::Lrgb { Metric::Legendre9 } else { Metric::Function };
    IndexSpace::new(field, metric, Domain::Hemisphere)
}

impl FieldModel {
    /// A part of the model's endless field.
    ///
    /// # Errors
    /// As [`Model::synthesize`].
    pub fn synthesize(&self, options: &SheetOptions, limits: &Limits) -> Result<ReflectanceField> {
        let planes = self.model.synthesize(options, limits)?;
        limits.check("the texture of the model", options.size, 8 * planes.count() as u64)?;
        let like = self.texel()?;
        index_space(&like)?.field(&like, &planes)
    }

    /// A field of one texel of the same kind.
    fn texel(&self) -> Result<ReflectanceField> {
        let planes = Planes::zeros(Size::new(1, 1), self.color.planes(self.basis.len()));
        ReflectanceField::new(self.basis, self.color, self.space, planes)
    }

    /// Whether the model has as many planes as fields of its kind have.
    pub fn is_whole(&self) -> bool {
        let space = self.texel().and_then(|texel| index_space(&texel));
        space.is_ok_and(|space| space.planes() == self.model.planes())
    }
}
