//! Textures whose texels hold the parameters of a reflectance model: lobes, facets, functions of the light for each
//! measured view, or products of functions of the view and of the light.
//!
//! They are not linear in the numbers of a texel, so stages take their linear form, learned from their pictures
//! (`fit::parametric::linear_form`; docs/decisions/0013). Pictures for a light and a view come from the numbers
//! themselves ([`ParametricField::picture`]).

#[cfg(test)]
pub(crate) mod examples;
mod ggx;
mod lobes;
mod per_view;
mod separable;

pub(crate) use ggx::{FacetShares, radiance as ggx_radiance};
pub use lobes::MOST_LOBES;
pub use per_view::{PerViewModel, ViewFunction};
use separable::SeparableShares;
pub use separable::{MOST_PRODUCTS, SeparableModel};

use super::{PlaneLayout, ReflectanceField};
use crate::direction::{Direction, Directions};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::numeric::between::Shares;
use crate::parallel;
use crate::picture::Picture;
use crate::planes::Planes;
use crate::size::Size;
use crate::space::Space;

/// Texels evaluated by one task.
const PART: usize = 1 << 11;

/// The numbers of a texel, for one view.
pub(crate) type TexelNumbers = [f64];

/// What the numbers of a texel mean.
#[derive(Debug, Clone, PartialEq)]
pub enum TexelModel {
    /// A diffuse part and lobes of light and view.
    Lafortune {
        /// The number of lobes.
        lobes: usize,
    },
    /// A glossy dielectric on a tilted facet.
    Ggx,
    /// Functions of the light for each view.
    PerView(PerViewModel),
    /// A sum of products of a function of the view and one of the light.
    Separable(SeparableModel),
}

impl TexelModel {
    /// The numbers of a texel of so many channels.
    pub fn numbers(&self, channels: usize) -> usize {
        match self {
            Self::Lafortune { lobes } => lobes::count(channels, *lobes),
            Self::Ggx => channels + ggx::BESIDE,
            Self::PerView(model) => model.views().len() * model.function().numbers(channels),
            Self::Separable(model) => model.numbers(channels),
        }
    }

    /// The space of the values.
    pub fn space(&self) -> Space {
        match self {
            Self::PerView(model) => match model.function() {
                ViewFunction::Basis(_, space) => *space,
                ViewFunction::Lobes(_) => Space::Linear,
            },
            Self::Separable(model) => model.space(),
            Self::Lafortune { .. } | Self::Ggx => Space::Linear,
        }
    }

    /// The kind of model, in files, options and messages: `lafortune2`, `ggx`, `views-ptm`, `separable4`.
    pub fn name(&self) -> String {
        match self {
            Self::Lafortune { lobes } => format!("lafortune{lobes}"),
            Self::Ggx => "ggx".to_owned(),
            Self::PerView(model) => match model.function() {
                ViewFunction::Basis(basis, _) => format!("views-{}", basis.name()),
                ViewFunction::Lobes(lobes) => format!("views-lafortune{lobes}"),
            },
            Self::Separable(model) => format!("separable{}", model.products()),
        }
    }

    /// The name of each number of a texel of so many channels.
    ///
    /// # Errors
    /// Other channels than 1 or 3, and no lobe or too many.
    pub fn number_names(&self, channels: usize) -> Result<Vec<String>> {
        self.check(channels)?;
        let channels: &[&str] = if channels == 1 { &["Y"] } else { &["R", "G", "B"] };
        Ok(match self {
            Self::Lafortune { lobes } => lobes::names(channels, *lobes),
            Self::Ggx => ggx::names(channels),
            Self::PerView(model) => {
                let names = model.function().names(channels);
                let of_view = |v: usize| names.iter().map(move |name| format!("view{v}.{name}"));
                (0..model.views().len()).flat_map(of_view).collect()
            }
            Self::Separable(model) => model.names(channels),
        })
    }

    fn check(&self, channels: usize) -> Result<()> {
        if channels != 1 && channels != 3 {
            return Err(Error::invalid(format!(
                "a texel of a reflectance model is grey or red, green and blue: 1 or 3 channels, not {channels}"
            )));
        }
        match self {
            Self::Lafortune { lobes } if *lobes == 0 || *lobes > MOST_LOBES => {
                Err(Error::invalid(format!("a texel has 1 to {MOST_LOBES} lobes, not {lobes}")))
            }
            Self::Lafortune { .. } | Self::Ggx | Self::PerView(_) | Self::Separable(_) => Ok(()),
        }
    }
}

/// A texture of the numbers of a reflectance model: one plane for each number.
#[derive(Debug, Clone, PartialEq)]
pub struct ParametricField {
    model: TexelModel,
    channels: usize,
    planes: Planes,
}

/// What pictures for a light and a view have in common at all texels.
struct PreparedDirections {
    directions: Directions,
    around: Around,
}

/// What is measured around a light and a view.
enum Around {
    /// Nothing: of lobes and facets.
    Nothing,
    /// The views, and the values of the functions of the light, if they are linear.
    Views(Shares, Vec<f64>),
    /// The views and the lights.
    Pair(SeparableShares),
}

impl ParametricField {
    /// A field from its parts.
    ///
    /// # Errors
    /// Other channels than 1 or 3, no lobe or too many, and another number of planes than that of the numbers of a texel.
    pub fn new(model: TexelModel, channels: usize, planes: Planes) -> Result<Self> {
        model.check(channels)?;
        let expected = model.numbers(channels);
        if planes.count() != expected || planes.size().texels() == 0 {
            return Err(Error::invalid(format!(
                "a texture of the model {} has {expected} planes, found {} of {} texels",
                model.name(),
                planes.count(),
                planes.size()
            )));
        }
        if let Some(i) = planes.as_slice().iter().position(|value| !value.is_finite()) {
            let (plane, texel) = (i / planes.size().texels(), i % planes.size().texels());
            let width = planes.size().width;
            return Err(Error::invalid(format!(
                "the number {} of texel ({}, {}) is {}: expected finite numbers",
                model.number_names(channels)?[plane],
                texel % width,
                texel / width,
                planes.as_slice()[i]
            )));
        }
        Ok(Self { model, channels, planes })
    }

    /// What the numbers mean.
    pub fn model(&self) -> &TexelModel {
        &self.model
    }

    /// The channels of a texel.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// The numbers, a plane for each.
    pub fn planes(&self) -> &Planes {
        &self.planes
    }

    /// The name of each plane.
    pub fn plane_names(&self) -> Vec<String> {
        self.model.number_names(self.channels).expect("checked when it was made")
    }

    /// Width and height.
    pub fn size(&self) -> Size {
        self.planes.size()
    }

    /// The same model with other planes, such as rearranged ones.
    ///
    /// # Errors
    /// As [`ParametricField::new`].
    pub fn with_planes(&self, planes: Planes) -> Result<Self> {
        Self::new(self.model.clone(), self.channels, planes)
    }

    /// The channels of one texel for a light and a view, in the space of the model.
    pub fn evaluate(&self, x: usize, y: usize, directions: impl Into<Directions>) -> Vec<f32> {
        let prepared = self.prepared(directions.into());
        let mut out = vec![0.0; self.channels];
        self.rows_into(&prepared, self.size().index(x, y), &mut out.chunks_mut(1).collect::<Vec<_>>());
        out
    }

    /// The picture for a light and a view, in the space of the model.
    ///
    /// # Errors
    /// Limits exceeded, and a cancelled job.
    pub fn picture(&self, directions: impl Into<Directions>, job: &Job) -> Result<Picture> {
        let prepared = self.prepared(directions.into());
        let mut planes = Planes::zeros_within(job, "the picture", self.size(), self.channels)?;
        parallel::try_for_each(planes.bands_mut(PART).into_iter().enumerate(), |(part, mut band)| {
            job.proceed()?;
            self.rows_into(&prepared, part * PART, &mut band);
            Ok(())
        })?;
        Ok(Picture { planes, space: self.model.space() })
    }

    /// The functions of the light of what is seen from straight above, which are exact: of functions of the light for each
    /// view, and of products. Lobes and facets are no such functions.
    ///
    /// # Errors
    /// Limits exceeded.
    pub fn from_above(&self, job: &Job) -> Result<Option<ReflectanceField>> {
        if let TexelModel::Separable(model) = &self.model {
            return model.seen_from(Direction::ZENITH, &self.planes, self.channels, job).map(Some);
        }
        let TexelModel::PerView(model) = &self.model else { return Ok(None) };
        let ViewFunction::Basis(basis, space) = model.function() else { return Ok(None) };
        let count = model.function().numbers(self.channels);
        let mut planes = Planes::zeros_within(job, "the functions seen from above", self.size(), count)?;
        for (view, share) in model.shares(Direction::ZENITH).into_iter().filter(|(_, share)| *share != 0.0) {
            for (k, plane) in planes.iter_mut().enumerate() {
                let from = self.planes.plane(view * count + k);
                plane.iter_mut().zip(from).for_each(|(out, v)| *out += share as f32 * v);
            }
        }
        let layout = if self.channels == 1 { PlaneLayout::LUMINANCE } else { PlaneLayout::RGB };
        ReflectanceField::new(basis.clone(), layout, *space, planes).map(Some)
    }

    fn scratch(&self) -> Vec<f64> {
        match &self.model {
            TexelModel::PerView(model) => vec![0.0; model.function().numbers(self.channels)],
            TexelModel::Separable(_) => Vec::new(),
            TexelModel::Lafortune { .. } | TexelModel::Ggx => vec![0.0; self.planes.count()],
        }
    }

    fn prepared(&self, directions: Directions) -> PreparedDirections {
        let around = match &self.model {
            TexelModel::Lafortune { .. } | TexelModel::Ggx => Around::Nothing,
            TexelModel::PerView(model) => {
                let weights = match model.function() {
                    ViewFunction::Basis(basis, _) => basis.weights(directions.light),
                    ViewFunction::Lobes(_) => Vec::new(),
                };
                Around::Views(model.shares(directions.view), weights)
            }
            TexelModel::Separable(model) => Around::Pair(model.shares(directions)),
        };
        PreparedDirections { directions, around }
    }

    /// The values of adjacent texels from `first` on, a row for each channel.
    fn rows_into(&self, prepared: &PreparedDirections, first: usize, rows: &mut [&mut [f32]]) {
        if let (TexelModel::Separable(model), Around::Pair(shares)) = (&self.model, &prepared.around) {
            return model.rows_into(shares, &self.planes, first, rows);
        }
        let (mut out, mut scratch) = ([0.0; 3], self.scratch());
        for i in 0..rows[0].len() {
            self.value_into(prepared, first + i, &mut scratch, &mut out[..self.channels]);
            rows.iter_mut().zip(out).for_each(|(row, value)| row[i] = value as f32);
        }
    }

    /// The channels of a texel of lobes, facets or functions for each view; `numbers` is scratch for the numbers of one view.
    fn value_into(&self, prepared: &PreparedDirections, texel: usize, numbers: &mut [f64], out: &mut [f64]) {
        let texels = self.size().texels();
        let number = |plane: usize| f64::from(self.planes.as_slice()[plane * texels + texel]);
        let take = |first: usize, numbers: &mut [f64]| {
            numbers.iter_mut().enumerate().for_each(|(k, value)| *value = number(first + k));
        };
        let ([a, b, c], [d, e, f]) =
            (prepared.directions.light.to_array(), prepared.directions.view.to_array());
        match (&self.model, &prepared.around) {
            (TexelModel::PerView(model), Around::Views(shares, weights)) => {
                let mut one = [0.0; 3];
                let one = &mut one[..out.len()];
                out.fill(0.0);
                for &(view, share) in shares.iter().filter(|(_, share)| *share != 0.0) {
                    take(view * numbers.len(), numbers);
                    match model.function() {
                        ViewFunction::Basis(..) => combine(numbers, weights, one),
                        ViewFunction::Lobes(_) => lobes::radiance(numbers, [a, b, c], c.max(0.0), one),
                    }
                    out.iter_mut().zip(&*one).for_each(|(o, v)| *o += share * v);
                }
            }
            (TexelModel::Ggx, _) => {
                take(0, numbers);
                ggx::radiance(numbers, prepared.directions, out);
            }
            _ => {
                take(0, numbers);
                lobes::radiance(numbers, [a * d, b * e, c * f], c.max(0.0), out);
            }
        }
    }
}

/// The sum of functions in each channel.
fn combine(numbers: &TexelNumbers, weights: &[f64], out: &mut [f64]) {
    for (o, own) in out.iter_mut().zip(numbers.chunks_exact(weights.len())) {
        *o = own.iter().zip(weights).map(|(n, w)| n * w).sum();
    }
}

#[cfg(test)]
mod tests;
