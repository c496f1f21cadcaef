//! A field prepared for look-ups at any position and scale.
//!
//! Functions are interpolated, not colours, in a mip map of their coefficients. Interpolation is linear in
//! the coefficients, so LRGB texels become RGB functions first; averaging luminance and colour separately
//! would not be linear. Coefficients common to all channels stay so. Coefficients of an encoded field are averaged without decoding, which is accurate
//! only where neighbours differ little.

use super::horizon::AttachedShadow;
use super::mip_map::MipMap;
use crate::direction::Directions;
use crate::error::{Error, Result};
use crate::field::{Basis, PlaneLayout, ReflectanceField, ShapeLookup, Shapes};
use crate::job::Job;
use crate::parallel;
use crate::planes::Planes;
use crate::space::Space;

/// The appearance of the texels of an object.
#[derive(Debug)]
pub struct LitTexture {
    texels: MipMap,
    shown: Shown,
}

/// The meaning of the values of a texel.
#[derive(Debug)]
enum Shown {
    /// Coefficients of the function of each channel, or of all of them, then the numbers of moved boundaries if the basis
    /// has them, then the normal if there are normals.
    Functions {
        basis: Basis,
        layout: PlaneLayout,
        space: Space,
        shapes: Option<ShapeLookup>,
        has_normals: bool,
    },
    /// A linear colour, independent of the light.
    Colors { layout: PlaneLayout },
}

/// The result of a look-up at one position, and memory for what is computed from it.
#[derive(Debug, Default)]
pub struct Lookup {
    /// The values at the position, in the order of the values of a texel.
    pub values: Vec<f32>,
    /// The width in texels of what they are the mean of.
    pub footprint: f64,
    /// The values of the functions for the current directions.
    weights: Vec<f64>,
    /// Under an environment: the moments of its light in the current frame,
    pub moments: Vec<f32>,
    /// the functions for the current view,
    pub matrix: Vec<f32>,
    /// and their products.
    pub products: Vec<[f32; 3]>,
}

impl LitTexture {
    /// From a field and, for highlights, the normals of its texels.
    ///
    /// # Errors
    /// When the normals do not match the field, its channels form no colour, or memory does not suffice.
    pub fn of_field(field: &ReflectanceField, normals: Option<&Planes>, job: &Job) -> Result<Self> {
        if let Some(normals) = normals
            && (normals.size() != field.size() || normals.count() != 3)
        {
            return Err(Error::invalid(format!(
                "a texture of {} needs three planes of normals of its size, found {} of {}",
                field.size(),
                normals.count(),
                normals.size()
            )));
        }
        if field.layout().is_named() {
            return Err(Error::usage(format!(
                "a texture of the channels {} has no colour to render: choose red, green and blue, or one",
                field.layout().channel_names().join(", ")
            )));
        }
        let layout = linear(field.layout());
        let shapes = Shapes::of(field, job)?;
        let lookup = shapes.as_ref().map(Shapes::lookup);
        let stride = layout.planes(field.basis().len())
            + lookup.as_ref().map_or(0, ShapeLookup::len)
            + if normals.is_some() { 3 } else { 0 };
        let data = || interleaved(field, shapes.as_ref(), normals, stride);
        let texels = MipMap::new("the texture's pyramid", field.size(), stride, job, data)?;
        let (basis, space, has_normals) = (field.basis().clone(), field.space(), normals.is_some());
        Ok(Self { texels, shown: Shown::Functions { basis, layout, space, shapes: lookup, has_normals } })
    }

    /// From linear colours, one plane of grey or three planes.
    ///
    /// # Errors
    /// When memory does not suffice.
    pub fn of_colors(colors: &Planes, job: &Job) -> Result<Self> {
        let texels = MipMap::of_planes("the texture's pyramid", colors, job)?;
        let layout = if colors.count() == 1 { PlaneLayout::LUMINANCE } else { PlaneLayout::RGB };
        Ok(Self { texels, shown: Shown::Colors { layout } })
    }

    /// The texels, for look-ups.
    pub fn texels(&self) -> &MipMap {
        &self.texels
    }

    /// The linear colour of looked-up values, for a light and a view.
    pub fn color(&self, lookup: &mut Lookup, directions: Directions) -> [f64; 3] {
        let Lookup { values, weights, footprint, .. } = lookup;
        match &self.shown {
            Shown::Functions { basis, layout, space, shapes, .. } => {
                let n = basis.len();
                weights.resize(n * basis.channels(), 0.0);
                basis.weights_into(directions, weights);
                let moved = shapes.as_ref().map_or([0.0; 3], |shapes| {
                    let numbers = &values[layout.planes(n)..][..shapes.len()];
                    shapes.corrections(numbers, weights, directions.light, *footprint)
                });
                let function = |c: usize| {
                    let coefficients = &values[layout.function_plane(c, n)..];
                    let terms = layout.weights(c, n, weights).iter().zip(coefficients);
                    let value: f64 = terms.map(|(w, &v)| w * f64::from(v)).sum();
                    f64::from(space.to_linear(value as f32 + moved[c])).max(0.0)
                };
                of_channels(layout.channels(), function)
            }
            Shown::Colors { layout } => of_channels(layout.channels(), |c| f64::from(values[c]).max(0.0)),
        }
    }

    /// The functions of the texels and the space of their values; `None` for colours.
    pub fn functions(&self) -> Option<(&Basis, Space)> {
        match &self.shown {
            Shown::Functions { basis, space, .. } => Some((basis, *space)),
            Shown::Colors { .. } => None,
        }
    }

    /// How light fades out towards the horizon.
    pub fn attached_shadow(&self) -> AttachedShadow {
        self.functions().map_or(AttachedShadow::Smooth, |(basis, _)| AttachedShadow::of(basis))
    }

    /// Whether boundaries of shadows and highlights move between the lights.
    pub fn has_moved_boundaries(&self) -> bool {
        matches!(self.shown, Shown::Functions { shapes: Some(_), .. })
    }

    /// The layout of looked-up values.
    pub fn layout(&self) -> &PlaneLayout {
        match &self.shown {
            Shown::Functions { layout, .. } | Shown::Colors { layout } => layout,
        }
    }

    /// The unit normal of looked-up values, if there are normals.
    pub fn normal(&self, values: &[f32]) -> Option<[f32; 3]> {
        match &self.shown {
            Shown::Functions { has_normals: true, .. } => values[values.len() - 3..].try_into().ok(),
            Shown::Functions { .. } | Shown::Colors { .. } => None,
        }
    }
}

/// The layout without products.
pub(super) fn linear(layout: &PlaneLayout) -> PlaneLayout {
    if layout.is_product() { PlaneLayout::RGB } else { layout.clone() }
}

/// Red, green and blue of one or three channels.
fn of_channels(channels: usize, value: impl Fn(usize) -> f64) -> [f64; 3] {
    match channels {
        1 => [value(0); 3],
        _ => [value(0), value(1), value(2)],
    }
}

/// All values of each texel adjacent; LRGB texels as three functions.
fn interleaved(
    field: &ReflectanceField,
    shapes: Option<&Shapes<'_>>,
    normals: Option<&Planes>,
    stride: usize,
) -> Vec<f32> {
    let (n, layout, planes) = (field.basis().len(), field.layout(), field.coefficients());
    let functions = linear(layout).planes(n);
    let mut data = vec![0.0; field.size().texels() * stride];
    let fill = |texel: usize, out: &mut [f32]| {
        let (functions, rest) = out.split_at_mut(functions);
        let (moved, normal) = rest.split_at_mut(shapes.map_or(0, |shapes| shapes.lookup().len()));
        for (k, value) in functions.iter_mut().enumerate() {
            let function = planes.plane(layout.function_plane(k / n, n) + k % n)[texel];
            *value =
                layout.color_plane(k / n, n).map_or(function, |color| function * planes.plane(color)[texel]);
        }
        if let Some(shapes) = shapes {
            shapes.numbers_into(texel, moved);
        }
        if let Some(normals) = normals {
            normal.iter_mut().enumerate().for_each(|(k, value)| *value = normals.plane(k)[texel]);
        }
    };
    let width = field.size().width;
    parallel::for_each(data.chunks_exact_mut(width * stride).enumerate(), |(y, row)| {
        (y * width..).zip(row.chunks_exact_mut(stride)).for_each(|(texel, out)| fill(texel, out));
    });
    data
}
