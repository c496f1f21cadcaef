//! A virtual light dome: photographs of registered maps under one distant lamp after another, from straight above or
//! from any side, together with the ground truth.
//!
//! - [`mod@lights`]: positions of the lamps;
//! - [`relief`]: the height field and its borders; [`march`]: its horizons, fast and slow;
//! - [`shadow`]: cast shadows with penumbra;
//! - [`horizon`]: open sky and visible surface for each texel, shared by all lamps;
//! - [`Illumination`]: the light that arrives under one lamp, shared by all viewers;
//! - [`parallax`], [`Sight`]: what one viewer sees, shared by all lamps;
//! - [`gonioreflectometer`], [`sampling`]: images for many pairs of light and view;
//! - [`mirror_balls`]: balls beside the photographs, which show the lamps.
//!
//! The camera is orthographic. That of [`Dome::photograph`] is straight above, so a texel of the maps is a pixel; that
//! of [`Dome::image`] may be anywhere, and its image is rectified to the plane at the mean height. Light reaches a
//! point from the lamp; from a uniform sky, dimmed where the relief hides it; and after **one** diffuse bounce from the
//! surface it sees (the light which that surface receives from lamp and sky, times its albedo). Sky and bounce light
//! only the body, not the glossy surface, and metal as if it were rough. Highlights are masked only by the shadow of
//! the lamp and by what hides the point, not by the relief itself.
//!
//! Exposure is fixed: **a white Lambertian that faces the lamp is 1.0**, so photographs under all lamps are
//! comparable and nothing is normalised. Highlights may exceed 1.

pub mod gonioreflectometer;
pub mod horizon;
mod illumination;
pub mod lights;
pub mod march;
pub mod mirror_balls;
pub mod open_sky;
pub mod parallax;
mod photograph;
mod reflect;
pub mod relief;
pub mod sampling;
pub mod shadow;
mod sight;

pub use gonioreflectometer::Gonioreflectometer;
pub use illumination::Illumination;
pub use lights::lights;
pub use relief::ReliefBorder;
pub use sampling::DirectionSampling;
pub use sight::Sight;

use crate::error::{Error, Result};
use crate::job::{Held, Job};
use crate::maps::SurfaceMaps;
use crate::memory::Footprint;
use crate::microfacet;
use crate::planes::Planes;
use crate::size::Size;
use horizon::Surroundings;
use reflect::ReflectingPoint;
use relief::Relief;

/// The largest span of heights in texels: more indicates a wrong height scale.
const MAX_RELIEF_TEXELS: f32 = 65536.0;

/// Normals of a map are kept at least this far above the horizon: noise in files tilts some below it.
const LEAST_NORMAL_Z: f32 = 0.05;

/// Whether light is followed beyond its first surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bounce {
    /// Only the lamp and the sky.
    None,
    /// One diffuse reflection from the surface that each texel sees.
    Once,
}

/// What lies over the diffuse body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Surface {
    /// Nothing: a Lambertian.
    Matte,
    /// A rough dielectric with this reflectance at normal incidence; see [`crate::microfacet`].
    Ggx {
        /// Reflectance at normal incidence, 0 to 1.
        f0: f64,
    },
}

/// Options of a virtual dome.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DomeOptions {
    /// What lies beyond the borders of the maps.
    pub border: ReliefBorder,
    /// Radiance of the sky as a fraction of that of a white Lambertian facing the lamp, 0 to 1.
    pub ambient: f64,
    /// Whether light is followed beyond its first surface.
    pub bounce: Bounce,
    /// What lies over the diffuse body.
    pub surface: Surface,
    /// Half the angle subtended by a lamp, which determines the softness of shadows. 0 to 0.5.
    pub lamp_radius_rad: f64,
    /// Sectors of azimuth for sky and bounce, 4 to 256.
    pub sectors: usize,
}

impl Default for DomeOptions {
    /// A periodic material, a dim sky (a 25th of the lamp), lamps with a radius of one degree.
    fn default() -> Self {
        Self {
            border: ReliefBorder::Wrap,
            ambient: 0.04,
            bounce: Bounce::Once,
            surface: Surface::Ggx { f0: microfacet::DIELECTRIC_F0 },
            lamp_radius_rad: 1f64.to_radians(),
            sectors: 16,
        }
    }
}

impl DomeOptions {
    /// Checks every number against its range.
    pub fn validate(&self) -> Result<()> {
        let f0 = match self.surface {
            Surface::Matte => 0.0,
            Surface::Ggx { f0 } => f0,
        };
        let numbers = [
            ("the ambient light", self.ambient, 0.0, 1.0),
            ("the lamp's radius in radians", self.lamp_radius_rad, 0.0, 0.5),
            ("the reflectance at normal incidence", f0, 0.0, 1.0),
            ("the number of sectors", self.sectors as f64, 4.0, 256.0),
        ];
        for (name, value, low, high) in numbers {
            if !(low..=high).contains(&value) {
                return Err(Error::usage(format!(
                    "{name} is {value}: expected a number from {low} to {high}"
                )));
            }
        }
        Ok(())
    }
}

/// Maps under a dome, with all precomputed data shared by the lamps.
#[derive(Debug, Clone)]
pub struct Dome {
    maps: SurfaceMaps,
    normals: Planes,
    relief: Relief,
    /// The level of the reference plane of oblique views: the mean height.
    level: f32,
    surroundings: Surroundings,
    options: DomeOptions,
    _held: Held,
}

impl Dome {
    /// Puts maps under the dome and marches their horizons.
    ///
    /// # Errors
    /// Options out of range; maps of differing sizes; heights that are not finite or span more than
    /// 65,536 texels; albedo or roughness outside 0..1; normals without direction; too little memory.
    pub fn new(maps: SurfaceMaps, options: &DomeOptions, job: &Job) -> Result<Self> {
        options.validate()?;
        maps.validate()?;
        let size = maps.size();
        let footprint = Self::footprint(size, options);
        job.check("the virtual dome", size, 0)?;
        job.check_bytes("the virtual dome", footprint.peak)?;
        let held = job.hold("the virtual dome", footprint.kept)?;
        if u32::try_from(size.texels()).is_err() {
            return Err(Error::limit(format!("maps of {size} texels are too large for the virtual dome")));
        }
        check_ranges(&maps)?;
        let relief = Relief::new(&maps.height, options.border);
        if relief.range() > MAX_RELIEF_TEXELS {
            return Err(Error::invalid(format!(
                "the height map spans {} texels: expected at most {MAX_RELIEF_TEXELS}; lower the height scale",
                relief.range()
            )));
        }
        let normals = match &maps.normal {
            Some(map) => upright(map)?,
            None => relief.normals(),
        };
        let surroundings = Surroundings::new(&relief, &normals, options.sectors, job)?;
        let level = mean(&maps.height);
        Ok(Self { maps, normals, relief, level, surroundings, options: *options, _held: held })
    }

    /// The memory of a dome over maps of `size`, beside the maps: the relief with its continuation, normals,
    /// and what each texel sees.
    pub fn footprint(size: Size, options: &DomeOptions) -> Footprint {
        let seen = horizon::bytes_per_texel(options.sectors);
        Footprint::of_texels(size, seen + 12 + 12, seen - 4 + 12 + 12)
    }

    /// The memory of a photograph of maps of `size`: the light that arrives, then colours and their
    /// planes, which stay.
    pub fn photograph_footprint(size: Size) -> Footprint {
        Illumination::footprint(size).then(Footprint::of_texels(size, 12 + 12, 12))
    }

    /// Width and height of the photographs.
    pub fn size(&self) -> Size {
        self.maps.size()
    }

    /// The options it was made with.
    pub fn options(&self) -> &DomeOptions {
        &self.options
    }

    /// The maps under the dome: the true height and albedo.
    pub fn maps(&self) -> &SurfaceMaps {
        &self.maps
    }

    /// What is known of a texel.
    fn point(&self, texel: usize) -> ReflectingPoint {
        let of = |map: &Option<Planes>, default: f32| map.as_ref().map_or(default, |map| map.plane(0)[texel]);
        ReflectingPoint {
            normal: [0, 1, 2].map(|k| self.normals.plane(k)[texel]),
            albedo: [0, 1, 2].map(|k| self.maps.albedo.plane(k)[texel]),
            roughness: of(&self.maps.roughness, 1.0),
            metallic: of(&self.maps.metallic, 0.0),
        }
    }

    /// The true normals, three planes of unit vectors (x right, y up, z out): from the normal map if there is
    /// one, otherwise from the height.
    pub fn normals(&self) -> &Planes {
        &self.normals
    }
}

fn mean(height: &Planes) -> f32 {
    let heights = height.plane(0);
    (heights.iter().copied().map(f64::from).sum::<f64>() / heights.len() as f64) as f32
}

/// Refuses heights, colours and roughnesses without meaning.
fn check_ranges(maps: &SurfaceMaps) -> Result<()> {
    let limit = f32::MAX / 4.0;
    check_range("height", "a finite number", &maps.height, -limit, limit)?;
    check_range("albedo", "a reflectance from 0 to 1", &maps.albedo, 0.0, 1.0)?;
    for (name, map) in [("roughness", &maps.roughness), ("metallic", &maps.metallic)] {
        if let Some(map) = map {
            check_range(name, "a number from 0 to 1", map, 0.0, 1.0)?;
        }
    }
    Ok(())
}

fn check_range(name: &str, expected: &str, map: &Planes, low: f32, high: f32) -> Result<()> {
    let wrong = map.as_slice().iter().position(|v| !(low..=high).contains(v));
    let Some(i) = wrong else { return Ok(()) };
    let (texel, width) = (i % map.size().texels(), map.size().width);
    Err(Error::invalid(format!(
        "the {name} map holds {} at column {}, row {}: expected {expected}",
        map.as_slice()[i],
        texel % width,
        texel / width
    )))
}

/// The unit normals of a normal map, lifted above the horizon.
fn upright(map: &Planes) -> Result<Planes> {
    // The dome counts them.
    let size = map.size();
    let mut normals = Planes::zeros(size, 3);
    for texel in 0..size.texels() {
        let [x, y, z] = [0, 1, 2].map(|k| map.plane(k)[texel]);
        let length = (x * x + y * y + z * z).sqrt();
        if !(1e-6..1e6).contains(&length) {
            return Err(Error::invalid(format!(
                "the normal map holds ({x}, {y}, {z}) at column {}, row {}: expected a vector with a direction",
                texel % size.width,
                texel / size.width
            )));
        }
        let lifted = [x / length, y / length, (z / length).max(LEAST_NORMAL_Z)];
        let length = lifted.iter().map(|c| c * c).sum::<f32>().sqrt();
        (0..3).for_each(|k| normals.plane_mut(k)[texel] = lifted[k] / length);
    }
    Ok(normals)
}
