//! Textures whose texels hold the parameters of a reflectance model: lobes, facets, or functions of the light for each
//! measured view.
//!
//! They are not linear in the numbers of a texel, so stages take their linear form, learned from their pictures
//! (`fit::parametric::linear_form`; docs/decisions/0013). Pictures for a light and a view come from the numbers
//! themselves ([`ParametricField::picture`]).

#[cfg(test)]
pub(crate) mod examples;
mod ggx;
mod lobes;
mod per_view;

pub(crate) use ggx::{FacetShares, radiance as ggx_radiance};
pub use lobes::MOST_LOBES;
pub use per_view::{PerViewModel, ViewFunction};

use rayon::prelude::*;

use super::{PlaneLayout, ReflectanceField};
use crate::direction::{Direction, Directions};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::numeric::between::Shares;
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
}

impl TexelModel {
    /// The numbers of a texel of so many channels.
    pub fn numbers(&self, channels: usize) -> usize {
        match self {
            Self::Lafortune { lobes } => lobes::count(channels, *lobes),
            Self::Ggx => channels + ggx::BESIDE,
            Self::PerView(model) => model.views().len() * model.function().numbers(channels),
        }
    }

    /// The space of the values.
    pub fn space(&self) -> Space {
        match self {
            Self::PerView(model) => match model.function() {
                ViewFunction::Basis(_, space) => *space,
                ViewFunction::Lobes(_) => Space::Linear,
            },
            Self::Lafortune { .. } | Self::Ggx => Space::Linear,
        }
    }

    /// The kind of model, in files, options and messages: `lafortune2`, `ggx`, `views-ptm`.
    pub fn name(&self) -> String {
        match self {
            Self::Lafortune { lobes } => format!("lafortune{lobes}"),
            Self::Ggx => "ggx".to_owned(),
            Self::PerView(model) => match model.function() {
                ViewFunction::Basis(basis, _) => format!("views-{}", basis.name()),
                ViewFunction::Lobes(lobes) => format!("views-lafortune{lobes}"),
            },
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
            Self::Lafortune { .. } | Self::Ggx | Self::PerView(_) => Ok(()),
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
    /// The views around, of functions for each view.
    shares: Shares,
    /// The values of the functions of the light, if they are linear.
    weights: Vec<f64>,
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
        let mut out = [0.0; 3];
        let mut scratch = self.scratch();
        self.value_into(&prepared, self.size().index(x, y), &mut scratch, &mut out[..self.channels]);
        out[..self.channels].iter().map(|v| *v as f32).collect()
    }

    /// The picture for a light and a view, in the space of the model.
    ///
    /// # Errors
    /// Limits exceeded, and a cancelled job.
    pub fn picture(&self, directions: impl Into<Directions>, job: &Job) -> Result<Picture> {
        let prepared = self.prepared(directions.into());
        let mut planes = Planes::zeros_within(job, "the picture", self.size(), self.channels)?;
        planes.bands_mut(PART).into_par_iter().enumerate().try_for_each(|(part, mut band)| {
            job.proceed()?;
            let (mut out, mut scratch) = ([0.0; 3], self.scratch());
            for i in 0..band[0].len() {
                self.value_into(&prepared, part * PART + i, &mut scratch, &mut out[..self.channels]);
                band.iter_mut().zip(out).for_each(|(plane, value)| plane[i] = value as f32);
            }
            Ok(())
        })?;
        Ok(Picture { planes, space: self.model.space() })
    }

    /// The functions of the light of what is seen from straight above, which are exact: of functions of the light for each
    /// view. Lobes and facets are no such functions.
    ///
    /// # Errors
    /// Limits exceeded.
    pub fn from_above(&self, job: &Job) -> Result<Option<ReflectanceField>> {
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
            TexelModel::Lafortune { .. } | TexelModel::Ggx => vec![0.0; self.planes.count()],
        }
    }

    fn prepared(&self, directions: Directions) -> PreparedDirections {
        let mut prepared =
            PreparedDirections { directions, shares: [(0, 1.0), (0, 0.0), (0, 0.0)], weights: Vec::new() };
        if let TexelModel::PerView(model) = &self.model {
            prepared.shares = model.shares(directions.view);
            if let ViewFunction::Basis(basis, _) = model.function() {
                prepared.weights = basis.weights(directions.light);
            }
        }
        prepared
    }

    /// The channels of a texel; `numbers` is scratch for the numbers of one view.
    fn value_into(&self, prepared: &PreparedDirections, texel: usize, numbers: &mut [f64], out: &mut [f64]) {
        let texels = self.size().texels();
        let take = |first: usize, numbers: &mut [f64]| {
            let planes = self.planes.as_slice()[first * texels + texel..].iter().step_by(texels);
            numbers.iter_mut().zip(planes).for_each(|(number, value)| *number = f64::from(*value));
        };
        let ([a, b, c], [d, e, f]) =
            (prepared.directions.light.to_array(), prepared.directions.view.to_array());
        let TexelModel::PerView(model) = &self.model else {
            take(0, numbers);
            match &self.model {
                TexelModel::Ggx => ggx::radiance(numbers, prepared.directions, out),
                _ => lobes::radiance(numbers, [a * d, b * e, c * f], c.max(0.0), out),
            }
            return;
        };
        let mut one = [0.0; 3];
        let one = &mut one[..out.len()];
        out.fill(0.0);
        for &(view, share) in prepared.shares.iter().filter(|(_, share)| *share != 0.0) {
            take(view * numbers.len(), numbers);
            match model.function() {
                ViewFunction::Basis(..) => combine(numbers, &prepared.weights, one),
                ViewFunction::Lobes(_) => lobes::radiance(numbers, [a, b, c], c.max(0.0), one),
            }
            out.iter_mut().zip(&*one).for_each(|(o, v)| *o += share * v);
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
mod tests {
    use super::examples::all;
    use super::*;
    use crate::direction::Direction;

    #[test]
    fn pictures_are_the_values_of_their_texels_and_planes_have_distinct_names() {
        let directions =
            Directions { light: Direction::from_angles(0.6, 1.0), view: Direction::from_angles(0.5, -2.0) };
        for field in all() {
            let picture = field.picture(directions, &Job::default()).unwrap();
            assert_eq!((picture.size(), picture.space), (field.size(), field.model().space()));
            for (x, y) in [(0, 0), (4, 2), (1, 1)] {
                let values = field.evaluate(x, y, directions);
                assert_eq!(values.len(), field.channels());
                let shown: Vec<f32> = (0..field.channels()).map(|c| picture.planes.at(c, x, y)).collect();
                assert_eq!(shown, values);
            }
            let mut names = field.plane_names();
            assert_eq!(names.len(), field.planes().count());
            names.sort();
            names.dedup();
            assert_eq!(names.len(), field.planes().count(), "{names:?}");
        }
    }

    #[test]
    fn a_measured_view_is_its_own_function_and_others_are_means() {
        for field in all() {
            let TexelModel::PerView(model) = field.model() else { continue };
            let light = Direction::from_angles(0.4, 0.3);
            let value = |view| f64::from(field.evaluate(2, 1, Directions { light, view })[0]);
            let own = value(model.views()[2]);
            let other = value(model.views()[0]);
            // Halfway along an edge of the triangles in the stereographic projection, near halfway on the sphere.
            let [a, b] = [0, 2].map(|i| model.views()[i].to_array());
            let view = Direction::new(a[0] + b[0], a[1] + b[1], a[2] + b[2]).unwrap();
            let between = value(view);
            assert!(between > own.min(other) && between < own.max(other), "{own} {between} {other}");
        }
    }

    #[test]
    fn functions_seen_from_above_are_those_of_the_models() {
        let job = Job::default();
        for field in all() {
            let Some(above) = field.from_above(&job).unwrap() else {
                assert!(
                    !field.model().name().starts_with("views-") || field.model().name().contains("lafortune")
                );
                continue;
            };
            let light = Direction::from_angles(0.7, 2.0);
            for (x, y) in [(0, 0), (4, 2), (2, 1)] {
                let (a, b) = (field.evaluate(x, y, light), above.value(x, y, light));
                assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-5), "{a:?} {b:?}");
            }
        }
    }

    #[test]
    fn fields_that_do_not_fit_are_refused_in_a_sentence() {
        let lobes = |lobes, channels, planes: usize| {
            let planes = Planes::zeros(Size::new(2, 2), planes);
            ParametricField::new(TexelModel::Lafortune { lobes }, channels, planes).unwrap_err().to_string()
        };
        assert!(lobes(0, 3, 3).contains("1 to 3 lobes"), "{}", lobes(0, 3, 3));
        assert!(lobes(9, 3, 66).contains("1 to 3 lobes"));
        assert!(lobes(1, 2, 7).contains("not 2"));
        assert!(lobes(1, 3, 9).contains("has 10 planes, found 9"));
        let mut planes = Planes::zeros(Size::new(2, 2), 7);
        planes.plane_mut(5)[3] = f32::NAN;
        let error = ParametricField::new(TexelModel::Ggx, 3, planes).unwrap_err().to_string();
        assert!(error.contains("roughness of texel (1, 1) is NaN"), "{error}");
        let views =
            |views: &[Direction], function| PerViewModel::new(views, function).unwrap_err().to_string();
        let up = Direction::ZENITH;
        assert!(views(&[], ViewFunction::Lobes(1)).contains("of 0"));
        assert!(views(&[up, up], ViewFunction::Lobes(1)).contains("given twice"));
        assert!(views(&[up], ViewFunction::Lobes(0)).contains("at least one lobe"));
        assert!(views(&[up], ViewFunction::Lobes(7)).contains("at most 3"));
    }
}
