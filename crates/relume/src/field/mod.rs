//! The central type: a texture of functions of light and view.
//!
//! R(x, w) = sum_k c_k(x) b_k(w): a [`Basis`] of functions b_k, and planes of coefficients c_k. Photographs,
//! polynomial texture maps and plain pictures all have this form; a picture is a field of constants. Every
//! stage maps a field to a field or to a picture.

pub mod basis;
mod clustered;
mod coordinates;
mod index;
mod layout;
pub mod lrgb;
mod nonlinear;
pub mod parametric;
pub mod refit;
mod shapes;

pub(crate) use basis::RadialSum;
pub use basis::{
    Bands, Basis, Domain, Gram, Interpolated, Interpolation, Learned, PackedFunctions, PolynomialDegree,
};
#[cfg(test)]
pub(crate) use clustered::clustered_example;
pub use clustered::{ClusterSpaces, ClusteredField, MOST_CLUSTERS};
pub use index::{IndexSpace, Metric};
pub use layout::{PlaneLayout, PlaneRole};
pub use nonlinear::NonlinearField;
pub use parametric::{
    MOST_LOBES, MOST_PRODUCTS, ParametricField, PerViewModel, SeparableModel, TexelModel, ViewFunction,
};
#[cfg(test)]
pub(crate) use shapes::tests::shapes_example;
pub use shapes::{ShapeLookup, Shapes};

use crate::direction::{Direction, Directions};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::picture::Picture;
use crate::planes::Planes;
use crate::size::Size;
use crate::space::Space;

/// A texture of functions: basis, layout of planes, space, and coefficient planes.
///
/// Values are 1 at white. The order of the planes is that of [`PlaneLayout`].
#[derive(Debug, Clone, PartialEq)]
pub struct ReflectanceField {
    basis: Basis,
    layout: PlaneLayout,
    space: Space,
    coefficients: Planes,
    lights: Vec<Direction>,
}

impl ReflectanceField {
    /// Checks that the texels of another field may lie in one texture with those of this one: that both have the same functions,
    /// colours and space. `first` names this one.
    ///
    /// # Errors
    /// What differs, with `other` as the subject.
    pub fn check_kind(&self, other: &Self, first: &str) -> Result<()> {
        let names = |field: &Self| {
            format!("{} {} in {} values", field.layout.name(), field.basis.name(), field.space)
        };
        let (found, expected) = (names(other), names(self));
        if found != expected {
            return Err(Error::usage(format!(
                "holds {found} and {first} {expected}: they must be of one kind"
            )));
        }
        if (&other.basis, &other.layout) != (&self.basis, &self.layout) {
            return Err(Error::usage(format!(
                "holds {found} as {first} does, but other functions: those that are learned from photographs or interpolated between \
                 them belong to these photographs, so that both must come from one fit"
            )));
        }
        Ok(())
    }

    /// A field from its parts.
    ///
    /// # Errors
    /// When the number of planes does not match the basis and the layout, or the basis has values for other
    /// channels than those of a [shared](PlaneLayout::shared) layout.
    pub fn new(basis: Basis, layout: PlaneLayout, space: Space, coefficients: Planes) -> Result<Self> {
        if !layout.takes(basis.channels()) {
            return Err(Error::invalid(format!(
                "a {} field of {} channels cannot have the basis {} with {} values of a function",
                layout.name(),
                layout.channels(),
                basis.name(),
                basis.channels()
            )));
        }
        let expected = layout.planes(basis.len());
        if coefficients.count() != expected || coefficients.size().texels() == 0 {
            return Err(Error::invalid(format!(
                "a {} field of basis {} has {expected} planes, found {} of {} texels",
                layout.name(),
                basis.name(),
                coefficients.count(),
                coefficients.size()
            )));
        }
        Ok(Self { basis, layout, space, coefficients, lights: Vec::new() })
    }

    /// A picture as a field of constants: grey becomes luminance, colour RGB.
    pub fn from_picture(picture: Picture) -> Self {
        let layout = if picture.planes.count() == 1 { PlaneLayout::LUMINANCE } else { PlaneLayout::RGB };
        Self::new(Basis::Constant, layout, picture.space, picture.planes)
            .expect("a picture has one or three planes")
    }

    /// The same field, with the light directions it was fitted from.
    #[must_use]
    pub fn with_lights(mut self, lights: Vec<Direction>) -> Self {
        self.lights = lights;
        self
    }

    /// The same basis, layout and space with other coefficient planes, of any size.
    ///
    /// # Errors
    /// When the number of planes differs.
    pub fn with_coefficients(&self, coefficients: Planes) -> Result<Self> {
        let field = Self::new(self.basis.clone(), self.layout.clone(), self.space, coefficients)?;
        Ok(field.with_lights(self.lights.clone()))
    }

    /// The same field with coefficients rounded to multiples of a step, one for each of the first planes.
    #[must_use]
    pub fn rounded(mut self, steps: &[f32]) -> Self {
        steps.iter().enumerate().for_each(|(k, step)| self.coefficients.round(k, *step));
        self
    }

    /// The same field, whose coefficients count against the job's budget; `what` names it in a refusal.
    ///
    /// # Errors
    /// When they do not fit beside the memory held.
    pub fn held(mut self, job: &Job, what: &str) -> Result<Self> {
        self.coefficients = self.coefficients.held(job, what)?;
        Ok(self)
    }

    /// The functions b_k.
    pub fn basis(&self) -> &Basis {
        &self.basis
    }

    /// The layout of the planes.
    pub fn layout(&self) -> &PlaneLayout {
        &self.layout
    }

    /// The encoding of the function values.
    pub fn space(&self) -> Space {
        self.space
    }

    /// The coefficient planes.
    pub fn coefficients(&self) -> &Planes {
        &self.coefficients
    }

    /// The directions of the photographs it was fitted from, where known.
    pub fn lights(&self) -> &[Direction] {
        &self.lights
    }

    /// Width and height.
    pub fn size(&self) -> Size {
        self.coefficients.size()
    }

    /// A name for each coefficient plane, in order: `L.u2`, `G.1`, and `R`, `G`, `B` for the
    /// unscaled colour of an LRGB field.
    pub fn plane_names(&self) -> Vec<String> {
        let functions = self.basis.function_names();
        let name = |role: PlaneRole<'_>| match role {
            PlaneRole::Coefficient { channel, function } => format!("{channel}.{}", functions[function]),
            PlaneRole::Shared { function } => functions[function].clone(),
            PlaneRole::Color { channel } => channel.to_owned(),
        };
        self.layout.roles(functions.len()).into_iter().map(name).collect()
    }

    /// A channel of one texel, given the values of the functions ([`Basis::weights`]): the slow truth of
    /// relighting.
    ///
    /// # Panics
    /// When the layout has no such `channel`.
    pub fn channel_value(&self, channel: usize, x: usize, y: usize, weights: &[f64]) -> f32 {
        assert!(channel < self.layout.channels(), "a channel of the layout");
        let n = self.basis.len();
        let weights = self.layout.weights(channel, n, weights);
        let coefficient = |k: usize| f64::from(self.coefficients.at(k, x, y));
        let first = self.layout.function_plane(channel, n);
        let function: f64 = (0..n).map(|k| weights[k] * coefficient(first + k)).sum();
        (function * self.layout.color_plane(channel, n).map_or(1.0, coefficient)) as f32
    }

    /// The channels of one texel under a light, or for a light and a view, in the space of the field.
    pub fn values(&self, x: usize, y: usize, directions: impl Into<Directions>) -> Vec<f32> {
        let weights = self.basis.weights(directions);
        (0..self.layout.channels()).map(|c| self.channel_value(c, x, y, &weights)).collect()
    }

    /// The colour of one texel under a light, or for a light and a view, in the space of the field. Grey
    /// fields give three equal channels.
    ///
    /// # Panics
    /// When the channels have names that do not form a colour.
    pub fn value(&self, x: usize, y: usize, directions: impl Into<Directions>) -> [f32; 3] {
        assert!(!self.layout.is_named(), "named channels make no colour");
        let values = self.values(x, y, directions);
        std::array::from_fn(|c| values[c.min(values.len() - 1)])
    }

    /// The field of some of the channels, in the order given; for a colour, `L`, or `R`, `G` and `B` for a
    /// picture. The functions of the channels of LRGB fields are multiplied out.
    ///
    /// # Errors
    /// A channel that the field does not have, or one named twice; channels with common coefficients.
    pub fn of_channels(&self, names: &[&str], job: &Job) -> Result<Self> {
        let channels = self.layout.channel_names();
        if self.layout.is_shared() {
            return Err(Error::usage(format!(
                "the channels {} of the texture have common coefficients and cannot be separated: relight it",
                channels.join(", ")
            )));
        }
        let layout = PlaneLayout::of_channels(names.iter().copied())?;
        let n = self.basis.len();
        let mut planes = Planes::zeros_within(job, "the channels", self.size(), layout.planes(n))?;
        for (name, out) in names.iter().zip(planes.as_mut_slice().chunks_exact_mut(n * self.size().texels()))
        {
            let channel = channels.iter().position(|channel| channel == name).ok_or_else(|| {
                Error::usage(format!("the texture has no channel '{name}': it has {}", channels.join(", ")))
            })?;
            let first = self.layout.function_plane(channel, n) * self.size().texels();
            out.copy_from_slice(&self.coefficients.as_slice()[first..][..out.len()]);
            if let Some(color) = self.layout.color_plane(channel, n) {
                let colors = self.coefficients.plane(color);
                out.iter_mut().zip(colors.iter().cycle()).for_each(|(value, color)| *value *= color);
            }
        }
        Ok(Self::new(self.basis.clone(), layout, self.space, planes)?.with_lights(self.lights.clone()))
    }
}
