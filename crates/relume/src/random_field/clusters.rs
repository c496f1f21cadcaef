//! Textures of light and view as one model for each cluster of photographs, all driven by the same noise, and a range map:
//! the scheme of Haindl, Filip, Arnold, "BTF Image Space Utmost Compression and Modelling Method" (ICPR 2004).
//!
//! A table says of each measured pair of light and view whose picture it is and how many times as bright: functions that
//! are zero at all pairs of other clusters. Between measured pairs they are interpolated with barycentric weights as all
//! learned functions are, so pictures of up to nine pairs are blended, of as many clusters at most. Levels of the same number
//! draw the same noise at the same place, so pictures that are blended show one surface instead of averaging to a blur.
//!
//! The range map is a model of heights in texels, under the same noise; what depends on direction beyond the pictures comes
//! from it by displacement or bump when a surface is rendered.
//!
//! The brightness of a pair is ours: in the original a pair has the picture of its cluster as it is.

use super::field_model::{FieldModel, Fields, ModelSource};
use super::model::{Model, RealisationOptions};
use crate::direction::Directions;
use crate::error::{Error, Result};
use crate::field::{Basis, PackedFunctions, PlaneLayout};
use crate::job::Job;
use crate::picture::Picture;
use crate::planes::Planes;
use crate::size::Size;
use crate::space::Space;

/// The most clusters: a table has a byte for each pair.
pub const MOST_IMAGE_CLUSTERS: usize = 255;

/// Functions below this share contribute nothing to a picture.
const LEAST_SHARE: f64 = 1e-9;

/// The models of clusters of photographs.
#[derive(Debug, Clone, PartialEq)]
pub struct PhotographClusters {
    /// The picture of each cluster, of as many planes as it has channels.
    pub models: Vec<Model>,
    /// Heights in texels.
    pub range: Option<Box<Model>>,
}

/// Whether each pair has one function, as the table of clusters says.
pub fn is_table(functions: &PackedFunctions) -> bool {
    let pairs = functions.lights.len() * functions.views.len();
    let owners =
        |pair: usize| functions.codes.iter().skip(pair).step_by(pairs).filter(|code| **code != 0).count();
    functions.channels == 1
        && (1..=MOST_IMAGE_CLUSTERS).contains(&functions.steps.len())
        && functions.steps.iter().all(|step| *step == functions.steps[0])
        && (0..pairs).all(|pair| owners(pair) == 1)
}

/// What a picture is multiplied by to be the coefficient of its function: functions are orthonormal.
fn norms(functions: &PackedFunctions) -> Vec<f64> {
    let lights = functions.lights.len();
    let pairs = lights * functions.views.len();
    let weight = |pair: usize| {
        f64::from(functions.views[pair / lights].weight) * f64::from(functions.lights[pair % lights].weight)
    };
    let norm = |(codes, step): (&[i32], &f32)| {
        let squares = codes.iter().enumerate();
        let value = |code: &i32| f64::from(*code) * f64::from(*step);
        squares.map(|(pair, code)| weight(pair) * value(code).powi(2)).sum::<f64>().sqrt()
    };
    functions.codes.chunks_exact(pairs).zip(&functions.steps).map(norm).collect()
}

/// The functions of a model of clusters.
fn packed(basis: &Basis) -> Result<&PackedFunctions> {
    match basis {
        Basis::Learned(learned) => learned.packed(),
        _ => None,
    }
    .ok_or_else(|| Error::invalid("clusters of photographs have a table of light and view"))
}

impl PhotographClusters {
    /// Whether there is a model for each function of a table, and one plane of heights.
    pub(super) fn is_whole(&self, basis: &Basis, layout: &PlaneLayout) -> bool {
        let fits =
            |functions: &PackedFunctions| is_table(functions) && functions.steps.len() == self.models.len();
        packed(basis).is_ok_and(fits)
            && !layout.is_shared()
            && self.models.iter().all(|model| model.planes() == layout.channels())
            && self.range.as_ref().is_none_or(|range| range.planes() == 1)
    }

    /// The coefficients of the functions over a part of the plane, channel after channel.
    pub(super) fn coefficients(
        &self,
        basis: &Basis,
        channels: usize,
        options: &RealisationOptions,
        job: &Job,
    ) -> Result<Planes> {
        let (norms, n) = (norms(packed(basis)?), self.models.len());
        let mut planes =
            Planes::zeros_within(job, "the pictures of the clusters", options.size, channels * n)?;
        for (k, (model, norm)) in self.models.iter().zip(norms).enumerate() {
            let picture = model.synthesize(options, job)?;
            for (channel, values) in picture.iter().enumerate() {
                let coefficients = planes.plane_mut(channel * n + k);
                coefficients.iter_mut().zip(values).for_each(|(c, value)| *c = norm as f32 * value);
            }
        }
        Ok(planes)
    }

    /// The sum of the pictures of the clusters at a pair: only those that it takes are made.
    pub(super) fn picture(
        &self,
        basis: &Basis,
        directions: Directions,
        options: &RealisationOptions,
        job: &Job,
    ) -> Result<Planes> {
        let (norms, weights) = (norms(packed(basis)?), basis.weights(directions));
        let channels = self.models.first().map_or(0, Model::planes);
        let mut sum = Planes::zeros_within(job, "the picture of the model", options.size, channels)?;
        for ((model, norm), weight) in self.models.iter().zip(norms).zip(weights) {
            let share = norm * weight;
            if share.abs() <= LEAST_SHARE {
                continue;
            }
            let picture = model.synthesize(options, job)?;
            let values = sum.as_mut_slice().iter_mut().zip(picture.as_slice());
            values.for_each(|(sum, value)| *sum += share as f32 * value);
        }
        Ok(sum)
    }
}

impl FieldModel {
    /// A model of clusters of photographs of a size, with a table that says of each pair of which cluster it is.
    ///
    /// # Errors
    /// A table and models that do not fit.
    pub fn of_clusters(
        table: PackedFunctions,
        space: Space,
        clusters: PhotographClusters,
        size: Size,
    ) -> Result<Self> {
        let channels = clusters.models.first().map_or(0, Model::planes);
        let source = ModelSource {
            width: size.width as u32,
            height: size.height as u32,
            photographs: (table.lights.len() * table.views.len()) as u32,
            channels: channels as u32,
        };
        let layout = if channels == 1 { PlaneLayout::LUMINANCE } else { PlaneLayout::RGB };
        let basis = Basis::Learned(table.unpacked()?);
        let fields = Fields::Clusters(clusters);
        let model = Self { basis, layout, space, source, heights: None, fields };
        if !model.is_whole() {
            return Err(Error::invalid("the pictures of clusters and their table do not fit"));
        }
        Ok(model)
    }

    /// The heights in texels of the range map over a part of the plane, where the model has one.
    ///
    /// # Errors
    /// As [`Model::synthesize`].
    pub fn range_map(&self, options: &RealisationOptions, job: &Job) -> Result<Option<Planes>> {
        let Fields::Clusters(clusters) = &self.fields else { return Ok(None) };
        clusters.range.as_ref().map(|range| range.synthesize(options, job)).transpose()
    }

    /// The picture for a light and a view of a model of clusters, without the pictures of those that it does not take;
    /// `None` for other models.
    ///
    /// # Errors
    /// As [`Model::synthesize`].
    pub fn cluster_picture(
        &self,
        directions: Directions,
        options: &RealisationOptions,
        job: &Job,
    ) -> Result<Option<Picture>> {
        let Fields::Clusters(clusters) = &self.fields else { return Ok(None) };
        let planes = clusters.picture(&self.basis, directions, options, job)?;
        Ok(Some(Picture { planes, space: self.space }))
    }
}
