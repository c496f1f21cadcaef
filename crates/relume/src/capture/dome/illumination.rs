//! The light that arrives at each texel under one lamp, whoever looks at it.

use super::{Bounce, Dome, shadow};
use crate::direction::Direction;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::memory::Footprint;
use crate::parallel;
use crate::size::Size;
/// The least sine of the elevation of a lamp, or of a viewer.
pub(super) const LEAST_DIRECTION_Z: f64 = 0.01;

/// Bytes per texel of an [`Illumination`].
const BYTES: u64 = 16;

/// The light that arrives under one lamp.
#[derive(Debug, Clone)]
pub struct Illumination {
    pub(super) light: Direction,
    /// For each texel the share of the lamp that it sees, and the irradiance from its surroundings as RGB.
    pub(super) texels: Vec<[f32; 4]>,
}

impl Illumination {
    /// The direction of the lamp.
    pub fn light(&self) -> Direction {
        self.light
    }

    /// The memory of the illumination of maps of `size`: shares and irradiance of the lamp, the light that texels
    /// pass on, and the result.
    pub fn footprint(size: Size) -> Footprint {
        Footprint::of_texels(size, 4 + 4 + 16 + BYTES, BYTES)
    }
}

impl Dome {
    /// The light that arrives from a distant lamp, from the sky, and after one bounce. Its memory is
    /// [`Illumination::footprint`].
    ///
    /// # Errors
    /// A lamp less than about half a degree above the surface, or below it; a cancelled job.
    pub fn illumination(&self, light: Direction, job: &Job) -> Result<Illumination> {
        if light.z() < LEAST_DIRECTION_Z {
            return Err(Error::usage(format!(
                "a lamp at ({}, {}, {}) does not shine onto the surface: expected z of at least {LEAST_DIRECTION_Z}",
                light.x(),
                light.y(),
                light.z()
            )));
        }
        let shares = shadow::lamp_share(&self.relief, light, self.options.lamp_radius_rad, job)?;
        let texels = match self.options.bounce {
            Bounce::None => {
                let lit = |(texel, share)| {
                    let sky = self.sky(texel);
                    [share, sky, sky, sky]
                };
                shares.into_iter().enumerate().map(lit).collect()
            }
            Bounce::Once => {
                let lamp = self.lamp_irradiance(&shares, light);
                self.bounced_irradiance(
                    &lamp,
                    |texel, [r, g, b]| {
                        let sky = self.sky(texel);
                        [shares[texel], r + sky, g + sky, b + sky]
                    },
                    job,
                )?
            }
        };
        Ok(Illumination { light, texels })
    }

    /// Irradiance from the lamp for each texel; 1 if facing the lamp and unshadowed.
    pub(super) fn lamp_irradiance(&self, shares: &[f32], light: Direction) -> Vec<f32> {
        let mut lamp = shares.to_vec();
        parallel::for_each_value(&mut lamp, |texel, share| *share *= self.point(texel).cosine(light));
        lamp
    }

    /// Irradiance from the sky.
    fn sky(&self, texel: usize) -> f32 {
        self.options.ambient as f32 * self.surroundings.sky[texel]
    }

    /// For each texel what `keep` makes of its number and the irradiance from the surface that it sees, lit by the
    /// lamp and the sky.
    pub(super) fn bounced_irradiance<T: Clone + Default + Send>(
        &self,
        lamp: &[f32],
        keep: impl Fn(usize, [f32; 3]) -> T + Sync,
        job: &Job,
    ) -> Result<Vec<T>> {
        let mut radiosity = vec![[0.0f32; 4]; lamp.len()];
        parallel::for_each_value(&mut radiosity, |texel, radiosity| {
            let received = lamp[texel] + self.sky(texel);
            let [r, g, b] = self.point(texel).albedo.map(|albedo| albedo * received);
            *radiosity = [r, g, b, 0.0];
        });
        let gathered = |(texel, kept): (usize, &mut T)| {
            job.proceed()?;
            let mut sum = [0.0f32; 4];
            for links in &self.surroundings.links {
                let link = links[texel];
                let from = &radiosity[link.texel as usize];
                sum.iter_mut().zip(from).for_each(|(s, r)| *s += link.share * r);
            }
            *kept = keep(texel, [sum[0], sum[1], sum[2]]);
            Ok(())
        };
        let mut all = vec![T::default(); lamp.len()];
        let width = self.size().width;
        parallel::try_for_each(all.chunks_mut(width).enumerate(), |(y, row)| {
            (y * width..).zip(row).try_for_each(gathered)
        })?;
        Ok(all)
    }
}
