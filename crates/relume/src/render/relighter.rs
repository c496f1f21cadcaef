//! Relighting of one field again and again.

use super::relight::{relight, relight_srgb8};
use crate::direction::Directions;
use crate::error::Result;
use crate::field::{ReflectanceField, Shapes};
use crate::job::Job;
use crate::picture::Picture;
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

    /// The field under a light as interleaved 8-bit sRGB; see [`relight_srgb8`].
    ///
    /// # Panics
    /// When `out` does not hold three bytes for each texel, or the channels have names that do not form a colour.
    pub fn relight_srgb8(&self, directions: impl Into<Directions>, out: &mut [u8]) {
        if self.shapes.is_none() {
            return relight_srgb8(self.field, directions, out);
        }
        let picture = self.relight(directions).to_space(Space::Srgb);
        let (planes, last) = (&picture.planes, picture.planes.count() - 1);
        for (t, texel) in out.chunks_exact_mut(3).enumerate() {
            for (c, code) in texel.iter_mut().enumerate() {
                *code = (255.0 * planes.plane(c.min(last))[t].clamp(0.0, 1.0)).round() as u8;
            }
        }
    }
}
