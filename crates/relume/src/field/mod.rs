//! The central type: a texture of functions of light direction.
//!
//! R(x, w) = sum_k c_k(x) b_k(w): a [`Basis`] of functions b_k, and planes of coefficients c_k.
//! Photographs, polynomial texture maps and plain pictures are all of this form; a picture is a
//! field of constants. Every stage maps a field to a field or to a picture.

pub mod basis;
mod color;
mod index;
pub mod lrgb;

pub use basis::{Basis, Domain};
pub use color::ColorModel;
pub use index::{IndexSpace, Metric};

use crate::direction::Direction;
use crate::error::{Error, Result};
use crate::picture::Picture;
use crate::planes::{Planes, Size};
use crate::space::Space;

/// A texture of functions: basis, colour model, space, and coefficient planes.
///
/// Values are 1 at white. The order of the planes is that of [`ColorModel`].
#[derive(Debug, Clone, PartialEq)]
pub struct ReflectanceField {
    basis: Basis,
    color: ColorModel,
    space: Space,
    coefficients: Planes,
    lights: Vec<Direction>,
}

impl ReflectanceField {
    /// A field from its parts.
    ///
    /// # Errors
    /// When the number of planes is not what the basis and the colour model need.
    pub fn new(basis: Basis, color: ColorModel, space: Space, coefficients: Planes) -> Result<Self> {
        let expected = color.planes(basis.len());
        if coefficients.count() != expected || coefficients.size().texels() == 0 {
            return Err(Error::invalid(format!(
                "a {} field of basis {} has {expected} planes, found {} of {} texels",
                color.name(),
                basis.name(),
                coefficients.count(),
                coefficients.size()
            )));
        }
        Ok(Self { basis, color, space, coefficients, lights: Vec::new() })
    }

    /// A picture as a field of constants: grey becomes luminance, colour RGB.
    pub fn from_picture(picture: Picture) -> Self {
        let color = if picture.planes.count() == 1 { ColorModel::Luminance } else { ColorModel::Rgb };
        Self::new(Basis::Constant, color, picture.space, picture.planes)
            .expect("a picture has one or three planes")
    }

    /// The same field, with the light directions it was fitted from.
    #[must_use]
    pub fn with_lights(mut self, lights: Vec<Direction>) -> Self {
        self.lights = lights;
        self
    }

    /// The same functions' description with other coefficient planes, of any size.
    ///
    /// # Errors
    /// When the number of planes differs.
    pub fn with_coefficients(&self, coefficients: Planes) -> Result<Self> {
        let field = Self::new(self.basis, self.color, self.space, coefficients)?;
        Ok(field.with_lights(self.lights.clone()))
    }

    /// The functions b_k.
    pub fn basis(&self) -> Basis {
        self.basis
    }

    /// How the planes make colours.
    pub fn color(&self) -> ColorModel {
        self.color
    }

    /// What the function values mean.
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
        let functions = |channel: &'static str| {
            self.basis.function_names().iter().map(move |function| format!("{channel}.{function}"))
        };
        match self.color {
            ColorModel::Luminance => functions("L").collect(),
            ColorModel::Rgb => ["R", "G", "B"].into_iter().flat_map(functions).collect(),
            ColorModel::Lrgb => functions("L").chain(["R", "G", "B"].map(str::to_owned)).collect(),
        }
    }

    /// The colour of one texel under one light, in the field's space: the slow truth of relighting.
    /// Grey fields give three equal channels.
    pub fn value(&self, x: usize, y: usize, light: Direction) -> [f32; 3] {
        let weights = self.basis.weights(light);
        let n = weights.len();
        let coefficient = |k: usize| f64::from(self.coefficients.at(k, x, y));
        let function = |first: usize| -> f64 { (0..n).map(|k| weights[k] * coefficient(first + k)).sum() };
        match self.color {
            ColorModel::Luminance => [function(0) as f32; 3],
            ColorModel::Rgb => std::array::from_fn(|c| function(c * n) as f32),
            ColorModel::Lrgb => std::array::from_fn(|c| (function(0) * coefficient(n + c)) as f32),
        }
    }
}
