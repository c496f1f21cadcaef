//! Light from all around: environment maps, and what a texture reflects of them.
//!
//! A map gives the radiance L(l) of every direction. A texel reflects to the viewer R = 1/pi ∫ f(l, v) L(l) dl over the
//! hemisphere above it, where f is its function of light and view, the cosine included; so a white matt texel is 1
//! where the radiance is 1 all around, and a lamp of intensity 1 is a narrow spot whose radiance integrates to pi.
//!
//! Maps are equirectangular and belong to the world (x right, y up, z to the viewer of the default camera). The centre
//! of a map is the direction -z, into the picture; its right quarter is +x, its upper edge +y, and its left and right
//! edges meet at +z, behind the viewer.
//!
//! | file | holds |
//! |---|---|
//! | `sky` | the built-in map |
//! | `importance` | directions drawn in proportion to their light: the truth |
//! | `cells` | the map as some thousand lights |
//! | `grid` | octahedral maps of directions |
//! | `hemisphere` | orthonormal functions over a faded hemisphere |
//! | `frames` | the light of every tangent frame, projected on these functions |
//! | `lamps` | the directions that stand for a hemisphere |
//! | `response` | the functions of a texture, projected on them |
//! | `reflections` | the light of highlights |
//! | `prefiltered` | their product: the fast form |
//! | `flat` | the texture itself, as `relight` shows it |
//! | `moved` | what boundaries that move between the lights add to it |
//! | `nodes` | the lamps of every normal, for shaders |

mod cells;
mod flat;
mod frames;
mod grid;
mod hemisphere;
mod importance;
mod lamps;
mod moved;
mod nodes;
mod prefiltered;
mod reflections;
mod response;
mod sky;

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use super::vector::Vec3;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::picture::Picture;
use crate::planes::Planes;
use crate::size::Size;
use crate::space::Space;

pub use flat::relight_under;
pub(super) use frames::TangentFrame;
pub(super) use importance::{ImportanceTable, PlacedSamples};
pub use lamps::LampKind;
pub use nodes::EnvironmentNodes;
pub(super) use prefiltered::Prefiltered;

/// The most samples of one point.
const MOST_SAMPLES: usize = 1 << 16;
/// The greatest factor of the light.
const MOST_STRENGTH: f64 = 1e6;

/// An environment map, turned and scaled. Copies share the map.
#[derive(Debug, Clone, PartialEq)]
pub struct Environment {
    /// Linear red, green and blue.
    map: Arc<Planes>,
    /// By which the map is turned to the right about the vertical axis.
    rotation_rad: f64,
    strength: f64,
}

/// How the light of an environment is added up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum EnvironmentMethod {
    /// Once for all tangent frames: the light of each hemisphere projected on smooth functions.
    Prefiltered,
    /// At each point anew, from directions drawn in proportion to their light.
    Sampled {
        /// Directions for each point of a pixel, 1 to 65,536.
        samples: usize,
        /// Other seeds draw other directions.
        seed: u64,
    },
}

/// An environment as the light of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct EnvironmentLight {
    /// The map.
    pub environment: Environment,
    /// How it is added up.
    pub method: EnvironmentMethod,
}

impl EnvironmentLight {
    pub(super) fn validate(&self) -> Result<()> {
        match self.method {
            EnvironmentMethod::Sampled { samples, .. } if !(1..=MOST_SAMPLES).contains(&samples) => {
                Err(Error::usage(format!(
                    "the number of samples of the environment is {samples}: expected 1 to {MOST_SAMPLES}"
                )))
            }
            _ => Ok(()),
        }
    }
}

impl Environment {
    /// An environment from an equirectangular picture of grey or three channels. What is below zero counts as zero,
    /// and a picture that is not twice as wide as high is stretched; both become remarks of the job.
    ///
    /// # Errors
    /// A picture of other channels, one without any light, and limits exceeded.
    pub fn new(picture: &Picture, job: &Job) -> Result<Self> {
        let (size, channels) = (picture.size(), picture.planes.count());
        if !matches!(channels, 1 | 3) {
            return Err(Error::usage(format!(
                "an environment map is grey or has red, green and blue, found {channels} channels"
            )));
        }
        if size.width != 2 * size.height {
            job.remark(format!(
                "the environment map is {size} texels and stretched over all directions: an equirectangular map is twice \
                 as wide as high"
            ));
        }
        let mut map = Planes::zeros_within(job, "the environment map", size, 3)?;
        let mut negative = 0;
        for (c, plane) in map.iter_mut().enumerate() {
            for (out, &value) in plane.iter_mut().zip(picture.planes.plane(c.min(channels - 1))) {
                let value = picture.space.to_linear(value);
                negative += usize::from(value < 0.0);
                *out = value.max(0.0);
            }
        }
        if negative > 0 {
            job.remark(format!("{negative} values of the environment map are below zero and count as zero"));
        }
        if map.as_slice().iter().all(|&value| value == 0.0) {
            return Err(Error::invalid("the environment map is black: expected light from some direction"));
        }
        Ok(Self { map: Arc::new(map), rotation_rad: 0.0, strength: 1.0 })
    }

    /// The built-in environment: a sun in front of the object, to the upper left, under a clear sky over brown ground.
    /// Under it a white matt surface that faces the sun has a value of about 1.
    ///
    /// # Errors
    /// When memory is short.
    pub fn sky(job: &Job) -> Result<Self> {
        Self::new(&Picture { planes: sky::map(job)?, space: Space::Linear }, job)
    }

    /// The same environment turned to the right about the vertical axis, and its light multiplied.
    ///
    /// # Errors
    /// An angle that is not finite, a factor outside 0 to 1,000,000.
    pub fn adjusted(self, rotation_rad: f64, strength: f64) -> Result<Self> {
        if !rotation_rad.is_finite() {
            return Err(Error::usage("the rotation of the environment is not a number"));
        }
        if !(0.0..=MOST_STRENGTH).contains(&strength) {
            return Err(Error::usage(format!(
                "the strength of the environment is {strength}: expected 0 to {MOST_STRENGTH}"
            )));
        }
        Ok(Self {
            rotation_rad: self.rotation_rad + rotation_rad,
            strength: self.strength * strength,
            ..self
        })
    }

    /// Texels of the map along both sides.
    pub fn size(&self) -> Size {
        self.map.size()
    }

    /// The radiance of texel (x, y), times the strength.
    fn texel(&self, x: usize, y: usize) -> [f64; 3] {
        std::array::from_fn(|c| self.strength * f64::from(self.map.at(c, x, y)))
    }

    /// The direction at the fraction u of the width, and at a cosine from the upper edge.
    fn direction(&self, u: f64, cosine: f64) -> Vec3 {
        let (sin, cos) = (TAU * (u - 0.5) + self.rotation_rad).sin_cos();
        let ring = (1.0 - cosine * cosine).max(0.0).sqrt();
        Vec3::new(ring * sin, cosine, -ring * cos)
    }

    /// The radiance of a direction in world space, not necessarily of unit length, times the strength: that of the
    /// texel it falls on.
    pub fn radiance(&self, direction: Vec3) -> [f64; 3] {
        let Some(Vec3 { x, y, z }) = direction.unit() else { return [0.0; 3] };
        let Size { width, height } = self.size();
        let u = ((x.atan2(-z) - self.rotation_rad) / TAU + 0.5).rem_euclid(1.0);
        let v = y.clamp(-1.0, 1.0).acos() / PI;
        let place = |t: f64, side: usize| ((t * side as f64) as usize).min(side - 1);
        self.texel(place(u, width), place(v, height))
    }
}

/// The cosine from the upper edge of a map of `height` rows to the upper edge of row y.
fn row_cosine(y: usize, height: usize) -> f64 {
    (PI * y as f64 / height as f64).cos()
}

/// The weights of red, green and blue in the choice of directions: those of luminance in sRGB.
fn luminance([r, g, b]: [f64; 3]) -> f64 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

#[cfg(test)]
mod tests;
