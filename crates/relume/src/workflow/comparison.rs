//! Textures compared as pictures under several lights, texel by texel or statistically.

use std::f64::consts::FRAC_PI_4;

use crate::direction::{Direction, Directions};
use crate::error::Result;
use crate::job::Job;
use crate::memory::Footprint;
use crate::metric::texture::copying::{Copying, copying};
use crate::metric::texture::seams::{Seams, seams};
use crate::metric::texture::wrap::{Wrap, wrap};
use crate::metric::texture::{Distances, SlicedOptions, Sources, distances};
use crate::metric::{psnr, rmse};
use crate::planes::Planes;
use crate::render::{Pictures, ShownForm, Sweep};
use crate::space::Space;

/// Two textures and the lights under which they are compared.
#[derive(Debug)]
pub struct Comparison<'a> {
    reference: ShownForm<'a>,
    other: ShownForm<'a>,
    directions: Vec<Directions>,
}

/// Errors of texels over all lights.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TexelErrors {
    /// Mean peak signal-to-noise ratio in decibels; infinite where the textures are equal.
    pub psnr_db: f64,
    /// Mean root mean square error, with white at 1.
    pub rmse: f64,
    /// The least ratio of all lights.
    pub worst_psnr_db: f64,
    /// The largest error of all lights.
    pub worst_rmse: f64,
}

/// Statistical distances; of several lights the worst wrap and seam.
#[derive(Debug, Clone)]
pub struct TextureMeasures {
    /// The distances under each light.
    pub distances: Vec<Distances>,
    /// Steps from the right edge to the left, and from the bottom to the top.
    pub wraps: [Wrap; 2],
    /// Steps across cuts, if the sources are known.
    pub seams: Option<Seams>,
    /// The use of the exemplar, if the sources are known.
    pub copying: Option<Copying>,
}

impl<'a> Comparison<'a> {
    /// Compares under the given number of lights, at least one: at the zenith, and on a circle 45 degrees
    /// from it. One is enough for two pictures. Textures whose functions depend on the view are seen from straight above
    /// under the first light, and then in turns from 45 degrees, a quarter of a circle on, and from straight above.
    pub fn new(reference: impl Into<ShownForm<'a>>, other: impl Into<ShownForm<'a>>, lights: usize) -> Self {
        let (reference, other) = (reference.into(), other.into());
        let are_pictures = reference.is_constant() && other.is_constant();
        let ring = Sweep::Orbit { lights: lights.saturating_sub(1), polar_rad: FRAC_PI_4 };
        let ring = if are_pictures { Vec::new() } else { ring.directions() };
        let depends_on_view = reference.depends_on_view() || other.depends_on_view();
        let pair = |(i, light): (usize, Direction)| match depends_on_view && i % 2 == 0 {
            true => Directions { light, view: a_quarter_on(light) },
            false => Directions::lit_from(light),
        };
        let ring = ring.into_iter().enumerate().map(pair);
        Self {
            reference,
            other,
            directions: [Directions::lit_from(Direction::ZENITH)].into_iter().chain(ring).collect(),
        }
    }

    /// The lights and views.
    pub fn directions(&self) -> &[Directions] {
        &self.directions
    }

    /// Both, prepared for pictures under lights.
    fn pictures(&self, job: &Job) -> Result<[Pictures<'a>; 2]> {
        Ok([self.reference.pictures(job)?, self.other.pictures(job)?])
    }

    /// The memory of both under one light: their planes, and those of one of them in its own space.
    fn footprint(&self) -> Footprint {
        let bytes = |form: ShownForm<'_>| 4 * (form.channels() * form.size().texels()) as u64;
        let (a, b) = (bytes(self.reference), bytes(self.other));
        Footprint { peak: a + b + a.max(b), kept: a + b }
    }

    /// Errors texel by texel.
    ///
    /// # Errors
    /// Textures of different sizes or channels, limits exceeded, and a cancelled job.
    pub fn texel_errors(&self, job: &Job) -> Result<TexelErrors> {
        job.check_bytes("the textures under a light", self.footprint().peak)?;
        let [reference, other] = self.pictures(job)?;
        let error = |directions: &Directions| {
            let (a, b) = (encoded(&reference, *directions, job)?, encoded(&other, *directions, job)?);
            Ok((psnr(&a, &b)?, rmse(&a, &b)?))
        };
        let errors = self.directions.iter().map(error).collect::<Result<Vec<(f64, f64)>>>()?;
        let count = errors.len() as f64;
        Ok(TexelErrors {
            psnr_db: errors.iter().map(|e| e.0).sum::<f64>() / count,
            rmse: errors.iter().map(|e| e.1).sum::<f64>() / count,
            worst_psnr_db: errors.iter().map(|e| e.0).fold(f64::INFINITY, f64::min),
            worst_rmse: errors.iter().map(|e| e.1).fold(0.0, f64::max),
        })
    }

    /// All measures of textures of any size; `seed` draws the patches of the patch distance, and `sources`
    /// are those of the other texture in the reference.
    ///
    /// # Errors
    /// Textures that are too small, sources of another size, limits exceeded, and a cancelled job.
    pub fn texture_measures(
        &self,
        sources: Option<&Sources<'_>>,
        seed: u64,
        job: &Job,
    ) -> Result<TextureMeasures> {
        let options = SlicedOptions { seed, ..SlicedOptions::default() };
        let mut found = TextureMeasures {
            distances: Vec::new(),
            wraps: [Wrap { ratio: 0.0, rank: 0.0 }; 2],
            seams: None,
            copying: sources.map(copying),
        };
        let footprint = self.footprint();
        job.check_bytes("the textures under a light", footprint.peak)?;
        let _pictures = job.hold("the textures under a light", footprint.kept)?;
        let [reference, other] = self.pictures(job)?;
        job.start("comparing", self.directions.len() as u64);
        for &directions in &self.directions {
            let (a, b) = (encoded(&reference, directions, job)?, encoded(&other, directions, job)?);
            // The quick one first: it refuses the map of another texture.
            if let Some(sources) = sources {
                let seams = seams(&b, sources)?;
                found.seams = found.seams.filter(|worst| worst.ratio >= seams.ratio).or(Some(seams));
            }
            found.distances.push(distances(&a, &b, &options, job)?);
            for (worst, wrap) in found.wraps.iter_mut().zip(wrap(&b)) {
                *worst = if wrap.ratio > worst.ratio { wrap } else { *worst };
            }
            job.advance(1)?;
        }
        Ok(found)
    }
}

/// A texture under a light, sRGB-encoded.
fn encoded(pictures: &Pictures<'_>, directions: Directions, job: &Job) -> Result<Planes> {
    Ok(pictures.picture(directions, job)?.to_space(Space::Srgb).planes)
}

/// The direction turned by a quarter of a circle around the zenith.
fn a_quarter_on(direction: Direction) -> Direction {
    Direction::from_disk(-direction.y(), direction.x())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{Basis, Interpolated, Interpolation, PlaneLayout, ReflectanceField, shapes_example};
    use crate::fit::parametric::linear_form;

    #[test]
    fn boundaries_that_move_between_the_lights_are_compared() {
        let moved = shapes_example(PlaneLayout::RGB);
        let Basis::Interpolated(lights) = moved.basis() else { panic!("the basis of the example") };
        let faded = Interpolated::new(lights.lights(), Interpolation::RadialBasis).unwrap();
        let planes = moved.coefficients().clone();
        let faded =
            ReflectanceField::new(Basis::Interpolated(faded), PlaneLayout::RGB, moved.space(), planes)
                .unwrap();
        let compared = |a, b| Comparison::new(a, b, 9).texel_errors(&Job::default()).unwrap().worst_rmse;
        assert_eq!(compared(&moved, &moved), 0.0);
        assert!(compared(&moved, &faded) > 0.02, "{}", compared(&moved, &faded));
    }

    #[test]
    fn models_are_compared_as_they_are() {
        let job = Job::default();
        for models in crate::field::parametric::examples::all() {
            let linear = linear_form(&models, &job).unwrap().0;
            let own = Comparison::new(&models, &models, 5).texel_errors(&job).unwrap();
            assert_eq!(own.worst_rmse, 0.0);
            let comparison = Comparison::new(&models, &linear, 5);
            let expected = comparison.directions().iter().map(|pair| {
                let [a, b] = [models.picture(*pair, &job).unwrap(), crate::render::relight(&linear, *pair)];
                rmse(&a.to_space(Space::Srgb).planes, &b.to_space(Space::Srgb).planes).unwrap()
            });
            let expected = expected.fold(0.0, f64::max);
            assert_eq!(comparison.texel_errors(&job).unwrap().worst_rmse, expected);
        }
    }
}
