//! A BRDF as the images of a texture with a single texel.

use std::f64::consts::PI;

use super::MeasuredBrdf;
use crate::direction::Directions;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::raster::{Raster, Samples};
use crate::size::Size;

/// A BRDF sampled over pairs of directions.
#[derive(Debug, Clone)]
pub struct BrdfSamples {
    brdf: MeasuredBrdf,
    pairs: Vec<Directions>,
}

impl BrdfSamples {
    /// The samples of a BRDF over pairs of light and view.
    pub fn new(brdf: MeasuredBrdf, pairs: Vec<Directions>) -> Self {
        Self { brdf, pairs }
    }

    /// The BRDF.
    pub fn brdf(&self) -> &MeasuredBrdf {
        &self.brdf
    }

    /// The pairs in their order.
    pub fn pairs(&self) -> &[Directions] {
        &self.pairs
    }

    /// One texel.
    pub fn size(&self) -> Size {
        Size::new(1, 1)
    }

    /// Red, green and blue.
    pub fn channels(&self) -> [&'static str; 3] {
        ["R", "G", "B"]
    }

    /// The values do not contain the cosine between light and normal.
    pub fn has_cosine(&self) -> bool {
        false
    }

    /// The image of pair `i`: the BRDF times pi, so that a white Lambertian surface is 1; linear and not clamped.
    ///
    /// # Errors
    /// Values beyond the range of `f32`, and cancellation.
    ///
    /// # Panics
    /// When `i` is not below the number of pairs.
    pub fn image(&self, i: usize, job: &Job) -> Result<Raster> {
        job.proceed()?;
        let values = self.brdf.evaluate(self.pairs[i]).map(|value| (value * PI) as f32);
        if values.iter().any(|value| !value.is_finite()) {
            return Err(Error::invalid(format!("the BRDF for pair {i} of light and view is not finite")));
        }
        Raster::new(self.size(), values.len(), Samples::F32(values.to_vec()))
    }
}
