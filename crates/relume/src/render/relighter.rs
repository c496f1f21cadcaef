//! Relighting of one field again and again.

use super::relight::{relight, relight_by, relight_srgb8, relight_srgb8_by};
use crate::direction::Directions;
use crate::error::Result;
use crate::field::{ReflectanceField, Shapes};
use crate::job::Job;
use crate::lamps::LampPositions;
use crate::parallel;
use crate::picture::Picture;
use crate::planes::Planes;
use crate::space::Space;

/// A field prepared for pictures under many lights: the boundaries of shadows and highlights of the basis `shapes` are found
/// once. For fields of other bases its pictures are those of [`relight`].
#[derive(Debug)]
pub struct Relighter<'a> {
    field: &'a ReflectanceField,
    shapes: Option<Shapes<'a>>,
}

impl<'a> Relighter<'a> {
    /// Prepares a field.
    ///
    /// # Errors
    /// Limits exceeded, and a cancelled job.
    pub fn new(field: &'a ReflectanceField, job: &Job) -> Result<Self> {
        Ok(Self { field, shapes: Shapes::of(field, job)? })
    }

    /// The field under a light, as [`relight`], with moved boundaries where it has them.
    pub fn relight(&self, directions: impl Into<Directions>) -> Picture {
        let directions = directions.into();
        let mut picture = relight(self.field, directions);
        if let Some(shapes) = &self.shapes {
            shapes.correct(directions.light, &mut picture.planes);
        }
        picture
    }

    /// The sum of the functions with one weight for each, as [`Relighter::relight`] without moved boundaries.
    ///
    /// # Panics
    /// When there is another number of weights.
    pub fn relight_by(&self, weights: &[f64]) -> Picture {
        relight_by(self.field, weights)
    }

    /// As [`Relighter::relight_by`], as interleaved 8-bit sRGB.
    ///
    /// # Panics
    /// As [`Relighter::relight_srgb8`], and when there is another number of weights.
    pub fn relight_srgb8_by(&self, weights: &[f64], out: &mut [u8]) {
        relight_srgb8_by(self.field, weights, out);
    }

    /// The field under a near lamp, whose light has its own direction at every texel; in the space of the field and not
    /// clamped. The fall-off of the light is left out, as in the photographs of a fit.
    pub fn relight_near(&self, lamps: &LampPositions, lamp: usize) -> Picture {
        let (field, size) = (self.field, self.field.size());
        let (n, channels) = (field.basis().len(), field.layout().channels());
        let mut values = vec![0.0f32; channels * size.texels()];
        parallel::for_each(values.chunks_exact_mut(channels * size.width).enumerate(), |(y, row)| {
            let mut weights = vec![0.0; n];
            for (x, texel) in row.chunks_exact_mut(channels).enumerate() {
                field.basis().weights_into(lamps.direction_at(lamp, x, y).into(), &mut weights);
                texel.iter_mut().enumerate().for_each(|(c, v)| *v = field.channel_value(c, x, y, &weights));
            }
        });
        let plane = |c: usize| values.iter().skip(c).step_by(channels).copied();
        let planes = Planes::from_vec(size, channels, (0..channels).flat_map(plane).collect());
        Picture { planes: planes.expect("a value a channel of every texel"), space: field.space() }
    }

    /// As [`Relighter::relight_near`], as interleaved 8-bit sRGB.
    ///
    /// # Panics
    /// As [`Relighter::relight_srgb8`].
    pub fn relight_near_srgb8(&self, lamps: &LampPositions, lamp: usize, out: &mut [u8]) {
        assert_eq!(out.len(), 3 * self.field.size().texels(), "three bytes a texel");
        encode(self.relight_near(lamps, lamp), out);
    }

    /// The field under a light as interleaved 8-bit sRGB; see [`relight_srgb8`].
    ///
    /// # Panics
    /// When `out` does not hold three bytes for each texel, or the channels have names that do not form a colour.
    pub fn relight_srgb8(&self, directions: impl Into<Directions>, out: &mut [u8]) {
        if self.shapes.is_none() {
            return relight_srgb8(self.field, directions, out);
        }
        encode(self.relight(directions), out);
    }
}

/// A picture of one or three channels as interleaved 8-bit sRGB.
fn encode(picture: Picture, out: &mut [u8]) {
    let picture = picture.to_space(Space::Srgb);
    let (planes, last) = (&picture.planes, picture.planes.count() - 1);
    for (t, texel) in out.chunks_exact_mut(3).enumerate() {
        for (c, code) in texel.iter_mut().enumerate() {
            *code = (255.0 * planes.plane(c.min(last))[t].clamp(0.0, 1.0)).round() as u8;
        }
    }
}
