//! The range map of a texture of light and view: heights from the photographs seen from straight above, and their model.
//!
//! Photometric stereo over all lights takes the place of shape from shading under one, whose Lambertian reflectance map is
//! that of each of them (Haindl, Filip, Arnold 2004, section 2, after R. T. Frankot, R. Chellappa, "A Method for Enforcing
//! Integrability in Shape from Shading Algorithms", IEEE PAMI 10, 1988): it does not need an albedo that is the same
//! everywhere. Integrability is enforced as there, in the Fourier domain.

use crate::direction::{Direction, Directions};
use crate::error::Result;
use crate::field::ReflectanceField;
use crate::job::Job;
use crate::picture::Picture;
use crate::random_field::{Fields, Model, character};
use crate::raster::LoadRaster;
use crate::space::Space;
use crate::surface::integrate::{IntegrateOptions, integrate, project};
use crate::surface::photometric_stereo::{StereoInput, StereoOptions, photometric_stereo};
use crate::surface::{STEEPEST, Slopes};
use crate::workflow::model::{ModelRequest, StructureSource};

/// The cosine above which a view is that from straight above.
const FRONTAL_COSINE: f64 = 0.999_847;
/// The fewest lights from which heights are found.
const LEAST_LIGHTS: usize = 6;

/// A model of heights, and what is said of it.
pub(super) struct RangeModel {
    pub model: Model,
    pub report: RangeReport,
}

/// The heights and how they are modelled.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct RangeReport {
    /// Photographs from which the heights are found.
    pub photographs: usize,
    /// The lowest and the highest height, in texels.
    pub range: [f32; 2],
    /// The peak of the autocorrelation of the heights: near 1 for exact repetition.
    pub regularity: f64,
    /// The tile that repeats, where the heights are regular: columns and rows.
    pub tile: Option<[usize; 2]>,
}

/// The range map, unless there are too few photographs from above to find it.
pub(super) fn range_model(
    pairs: &[(String, Directions)],
    load: &LoadRaster,
    request: &ModelRequest,
    job: &Job,
) -> Result<Option<RangeModel>> {
    let frontal: Vec<usize> = (0..pairs.len()).filter(|&i| pairs[i].1.view.z() > FRONTAL_COSINE).collect();
    if frontal.len() < LEAST_LIGHTS {
        job.remark(format!(
            "{} photographs are seen from straight above, too few for heights: the model has no range map",
            frontal.len()
        ));
        return Ok(None);
    }
    let lights: Vec<(String, Direction)> =
        frontal.iter().map(|&i| (pairs[i].0.clone(), pairs[i].1.light)).collect();
    let load = |i: usize| load(frontal[i]);
    let input = StereoInput { lights: &lights, lamps: None, load: &load };
    let normals = photometric_stereo(input, &StereoOptions::default(), job)?.normals;
    let slopes = Slopes::from_normals(&normals, STEEPEST)?;
    let longest = slopes.size().width.min(slopes.size().height) as f64 / 2.0;
    let slopes = project(&slopes, longest, job)?;
    let heights = integrate(&slopes, &IntegrateOptions::default(), job)?;
    let (low, high) = heights.range(0);
    let field = ReflectanceField::from_picture(Picture { planes: heights, space: Space::Linear });
    let kind = character(&field, job)?;
    let fitted = request.fit(&field, &kind, job)?;
    let tile = fitted.structure.map(|source| match source {
        StructureSource::Roller { tile, .. } | StructureSource::Blocks { tile, .. } => {
            [tile.width, tile.height]
        }
    });
    let Fields::Joint(model) = fitted.model.fields else { return Ok(None) };
    let report =
        RangeReport { photographs: frontal.len(), range: [low, high], regularity: kind.regularity, tile };
    Ok(Some(RangeModel { model: *model, report }))
}
