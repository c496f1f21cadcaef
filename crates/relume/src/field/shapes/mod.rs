//! Boundaries of shadows and highlights that move between the lights: what linear interpolation of photographs loses.
//!
//! Between two lights a linear interpolation fades the shadow of one out while that of the other fades in; a real one
//! moves. So the parts in shadow are interpolated by their shapes ("shape-based interpolation": S. P. Raya, J. K. Udupa,
//! IEEE Transactions on Medical Imaging 9, 1990): for each light i the signed distance s_i(x) of a texel to the boundary of
//! the shadow is known, in between it is interpolated by the functions b_i of the lights, and the texel is lit by
//!
//! ```text
//! lit(x, w) = f(sum_i b_i(w) s_i(x)),  f(s) = 1/2 + s / (2 sqrt(s² + 1.7²)).
//! ```
//!
//! The linear interpolation of the photographs has sum_i b_i(w) f(s_i(x)) in place of it, and the difference times the
//! contrast of lit and dark corrects the value:
//!
//! ```text
//! R(x, w) = sum_i b_i(w) p_i(x) + a (lit(x, w) - sum_i b_i(w) f(s_i(x))) contrast(x, w)
//! ```
//!
//! and likewise, with another reach and strength, for highlights. At the lights of the photographs the correction is zero.
//! The strengths are those by which each photograph is best predicted from the others ([`strength`]): on glossy surfaces,
//! where gloss passes for light and shadow, they are near zero.
//!
//! Which texels are in shadow is judged by a matt surface fitted to the photographs of each texel ([`texel`]). Everything
//! follows from the photographs, which are the coefficients of a field of the basis `shapes`: so files, synthesis and all
//! other stages have the numbers of the linear field, and the shapes are found again in whatever they make of it. What
//! stages that know no shapes show is the linear form, exact at the lights (docs/decisions/0016).
//!
//! The constants are those that did best on the capture synthrti of the test data (docs/quality.md tells how other
//! captures do).

mod lookup;
mod strength;
mod texel;

use super::{Basis, Interpolation, PlaneLayout, ReflectanceField};
use crate::direction::Direction;
use crate::error::Result;
use crate::job::Job;
use crate::numeric::signed_distance::signed_distances;
use crate::parallel;
use crate::planes::Planes;
use crate::size::Size;
pub use lookup::ShapeLookup;
use texel::{LEVELS, TexelJudge};

/// Half the width of the step from dark to lit, in texels: lights and penumbrae are not points.
const SOFTNESS: f32 = 1.7;

/// Texels of one task.
const PART: usize = 1 << 12;

/// A kind of boundary.
#[derive(Debug, Clone, Copy)]
struct ShapeEdge {
    /// The bit of a texel's flag.
    bit: u8,
    /// The farthest distance that counts, in texels.
    reach: usize,
    /// Stored steps a texel, so that the reach fits into a signed byte.
    steps: f32,
    /// The largest contrast.
    most: f32,
}

/// Between lit and dark.
const SHADOW: ShapeEdge = ShapeEdge { bit: texel::LIT, reach: 12, steps: 10.0, most: 1.0 };

/// Between a highlight and what is around it.
const HIGHLIGHT: ShapeEdge = ShapeEdge { bit: texel::BRIGHT, reach: 3, steps: 40.0, most: 0.6 };

/// The boundaries of shadows and highlights in the photographs of a field of the basis `shapes`.
#[derive(Debug)]
pub struct Shapes<'a> {
    field: &'a ReflectanceField,
    /// For each light, for each texel, the distance in steps: of shadows, then of highlights.
    distances: [Vec<i8>; 2],
    /// For each texel and channel the value where lit, as a polynomial of first degree in the direction, and the means
    /// in shadow and in highlights.
    levels: Vec<f32>,
    /// The shares of the corrections that are made.
    strengths: [f32; 2],
}

impl<'a> Shapes<'a> {
    /// The boundaries in the photographs of a field; `None` if its basis is another, or its channels have no brightness.
    ///
    /// # Errors
    /// Limits exceeded, and a cancelled job.
    pub fn of(field: &'a ReflectanceField, job: &Job) -> Result<Option<Self>> {
        let Basis::Interpolated(lights) = field.basis() else { return Ok(None) };
        let layout = field.layout();
        let is_bright = *layout == PlaneLayout::RGB || *layout == PlaneLayout::LUMINANCE;
        if lights.interpolation() != Interpolation::Shapes || !is_bright {
            return Ok(None);
        }
        let (size, count) = (field.size(), lights.lights().len());
        let bytes = size.texels() * (3 * count + 4 * LEVELS * layout.channels());
        job.check_bytes("the shapes of shadows", bytes as u64)?;
        let (flags, levels) = judged(field, lights.lights(), job)?;
        let distances = [SHADOW, HIGHLIGHT].map(|edge| {
            let of_light = |i: usize| {
                job.proceed()?;
                Ok(distances(size, &flags[i..], count, edge))
            };
            let all: Result<Vec<Vec<i8>>> = parallel::try_map(0..count, of_light);
            all.map(|all| all.concat())
        });
        let [shadows, highlights] = distances;
        let mut shapes = Self { field, distances: [shadows?, highlights?], levels, strengths: [0.0; 2] };
        shapes.strengths = strength::by_leaving_out(&shapes, lights, job)?;
        Ok(Some(shapes))
    }

    /// The shares of the corrections of shadows and of highlights that are made, 0 to 0.7 and 0 to 0.5.
    pub fn strengths(&self) -> [f32; 2] {
        self.strengths
    }

    /// Adds what moved boundaries change to a picture of the field under a light, in the space of the field.
    ///
    /// # Panics
    /// When the picture has not the size and channels of the field.
    pub fn correct(&self, light: Direction, picture: &mut Planes) {
        let channels = self.field.layout().channels();
        assert!(picture.size() == self.size() && picture.count() == channels, "a picture of the field");
        let weights: Vec<f32> = self.field.basis().weights(light).into_iter().map(|w| w as f32).collect();
        let terms = texel::terms(light);
        let bands = picture.bands_mut(PART);
        parallel::for_each(bands.into_iter().enumerate(), |(b, mut band)| {
            let (first, texels) = (b * PART, band[0].len());
            let moved = self.moved(&weights, first, texels);
            for t in 0..texels {
                for (c, plane) in band.iter_mut().enumerate() {
                    let contrasts = contrasts(self.levels_of(first + t, c), terms);
                    plane[t] += self.correction(contrasts, moved.each_ref().map(|moved| moved[t]));
                }
            }
        });
    }

    /// The channels of one texel under a light, in the space of the field: the slow truth of [`Shapes::correct`].
    pub fn value(&self, x: usize, y: usize, light: Direction) -> Vec<f32> {
        let weights: Vec<f32> = self.field.basis().weights(light).into_iter().map(|w| w as f32).collect();
        let texel = self.size().index(x, y);
        let moved = self.moved(&weights, texel, 1).map(|moved| moved[0]);
        let linear = self.field.values(x, y, light);
        let terms = texel::terms(light);
        let value = |(c, linear): (usize, f32)| {
            linear + self.correction(contrasts(self.levels_of(texel, c), terms), moved)
        };
        linear.into_iter().enumerate().map(value).collect()
    }

    fn size(&self) -> Size {
        self.field.size()
    }

    fn levels_of(&self, texel: usize, channel: usize) -> &[f32; LEVELS] {
        &self.levels.as_chunks::<LEVELS>().0[texel * self.field.layout().channels() + channel]
    }

    fn correction(&self, contrasts: [f32; 2], moved: [f32; 2]) -> f32 {
        (0..2).map(|k| self.strengths[k] * moved[k] * contrasts[k]).sum()
    }

    /// How much more of texels is inside of shadows' and of highlights' boundaries than linear interpolation has.
    fn moved(&self, weights: &[f32], first: usize, texels: usize) -> [Vec<f32>; 2] {
        [(0, SHADOW), (1, HIGHLIGHT)]
            .map(|(k, edge)| self.moved_of(edge, &self.distances[k], weights, first, texels))
    }

    fn moved_of(
        &self,
        edge: ShapeEdge,
        distances: &[i8],
        weights: &[f32],
        first: usize,
        texels: usize,
    ) -> Vec<f32> {
        let insides: [f32; 256] =
            std::array::from_fn(|code| inside(f32::from(code as u8 as i8) / edge.steps));
        let (mut mixed, mut linear) = (vec![0.0f32; texels], vec![0.0f32; texels]);
        for (weight, distances) in weights.iter().zip(distances.chunks_exact(self.size().texels())) {
            let distances = distances[first..][..texels].iter();
            for ((mixed, linear), code) in mixed.iter_mut().zip(&mut linear).zip(distances) {
                *mixed += weight * f32::from(*code);
                *linear += weight * insides[usize::from(*code as u8)];
            }
        }
        mixed.iter().zip(linear).map(|(mixed, linear)| inside(mixed / edge.steps) - linear).collect()
    }
}

/// How far a texel at a signed distance is inside, 0 to 1.
fn inside(distance: f32) -> f32 {
    inside_of(distance, SOFTNESS)
}

/// The same with a step of another half width.
fn inside_of(distance: f32, softness: f32) -> f32 {
    0.5 + 0.5 * distance / (distance * distance + softness * softness).sqrt()
}

/// The contrasts of lit and dark, and of a highlight and what is around it, under a light.
fn contrasts(levels: &[f32; LEVELS], terms: [f32; 4]) -> [f32; 2] {
    let lit: f32 = levels.iter().zip(terms).map(|(level, term)| level * term).sum();
    let [.., dark, bright] = *levels;
    [(lit - dark).clamp(0.0, SHADOW.most), (bright - lit).clamp(0.0, HIGHLIGHT.most)]
}

/// Flags of the photographs of each texel, and its levels.
fn judged(field: &ReflectanceField, lights: &[Direction], job: &Job) -> Result<(Vec<u8>, Vec<f32>)> {
    let (count, channels, texels) = (lights.len(), field.layout().channels(), field.size().texels());
    let mut flags = vec![0u8; count * texels];
    let mut levels = vec![0.0f32; LEVELS * channels * texels];
    let parts = flags.chunks_mut(count * PART).zip(levels.chunks_mut(LEVELS * channels * PART));
    parallel::try_for_each(parts.enumerate(), |(part, (flags, levels))| {
        job.proceed()?;
        let mut fit = TexelJudge::new(lights, channels, field.space());
        let texels = flags.chunks_exact_mut(count).zip(levels.chunks_exact_mut(LEVELS * channels));
        for (t, (flags, levels)) in texels.enumerate() {
            let texel = part * PART + t;
            fit.judge(|plane| field.coefficients().plane(plane)[texel], flags, levels);
        }
        Ok(())
    })?;
    Ok((flags, levels))
}

/// The distances of one light in steps, from flags of which every `count`-th is of this light.
fn distances(size: Size, flags: &[u8], count: usize, edge: ShapeEdge) -> Vec<i8> {
    let inside: Vec<bool> = flags.iter().step_by(count).map(|flag| flag & edge.bit != 0).collect();
    let distances = signed_distances(size, &inside, edge.reach);
    distances.into_iter().map(|distance| (distance * edge.steps).round() as i8).collect()
}

#[cfg(test)]
pub(super) mod tests;
