//! Built-in procedural materials as height, albedo and roughness, so that the first picture needs no
//! download.
//!
//! Every material is a pure function of position, built from two kinds of noise ([`noise`]), and closes on
//! the torus unless told otherwise. Lengths are multiples of one feature size, heights included, so a
//! material looks the same at any resolution. Marble, wood, clouds and fire are the classical functions of
//! (x, y, z) with noise and turbulence; the picture is a slice through them.
//!
//! To add a material: one file here with a `sample` function, one variant and its arms in
//! [`Material`]; the tests below then run over it.

mod bark;
mod clouds;
mod fire;
mod leather;
mod marble;
pub mod noise;
mod paint;
mod parameters;
mod pebbles;
pub mod solid;
mod sponge;
mod weave;
mod wood;

pub use noise::Tiling;
pub use parameters::{Cut, Parameters};

use crate::error::{Error, Result};
use crate::job::Job;
use crate::maps::SurfaceMaps;
use crate::memory::Footprint;
use crate::size::Size;
use noise::Canvas;
use paint::{PaintedTexel, Sampler, TOGETHER, paint};
use solid::SolidBlock;

/// The built-in materials.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Material {
    /// A natural sponge: pores of several sizes, steep walls, long cast shadows.
    Sponge,
    /// A plain weave of twisted yarns in two colours.
    Weave,
    /// A bed of rounded stones over sand.
    Pebbles,
    /// Grained leather: plump cells between creases, moderately glossy.
    Leather,
    /// Upright plates of tree bark between deep fissures.
    Bark,
    /// Polished marble: veins folded by turbulence.
    Marble,
    /// Wood, as a plank or the end of a trunk: rings about the pith.
    Wood,
    /// Clouds before the sky, or their upper side.
    Clouds,
    /// Flames.
    Fire,
}

/// Options of a material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MaterialOptions {
    /// Texels.
    pub size: Size,
    /// Another seed gives another sample of the same material.
    pub seed: u64,
    /// Size of the largest features, in texels.
    pub feature: f64,
    /// Whether the maps close on the torus.
    pub tiling: Tiling,
    /// The parameters that only some materials have.
    pub parameters: Parameters,
}

impl Default for MaterialOptions {
    fn default() -> Self {
        Self {
            size: Size::new(256, 256),
            seed: 0,
            feature: 40.0,
            tiling: Tiling::Torus,
            parameters: Parameters::default(),
        }
    }
}

impl MaterialOptions {
    /// Checks that the feature size is finite and between 2 and 65,536 texels.
    pub fn validate(&self) -> Result<()> {
        if !(2.0..=65536.0).contains(&self.feature) {
            return Err(Error::usage(format!(
                "the feature size is {} texels: expected a number from 2 to 65536",
                self.feature
            )));
        }
        Ok(())
    }
}

impl MaterialOptions {
    /// The memory of [`Material::make`]: five planes, and the texels that are computed together.
    pub fn footprint(size: Size) -> Footprint {
        let planes = Footprint::of_texels(size, 20, 20);
        let together = (size_of::<PaintedTexel>() * TOGETHER.min(size.texels())) as u64;
        Footprint { peak: planes.peak.saturating_add(together), ..planes }
    }
}

impl Material {
    /// All materials.
    pub const ALL: [Self; 9] = [
        Self::Sponge,
        Self::Weave,
        Self::Pebbles,
        Self::Leather,
        Self::Bark,
        Self::Marble,
        Self::Wood,
        Self::Clouds,
        Self::Fire,
    ];

    /// The name, in lower case.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Sponge => "sponge",
            Self::Weave => "weave",
            Self::Pebbles => "pebbles",
            Self::Leather => "leather",
            Self::Bark => "bark",
            Self::Marble => "marble",
            Self::Wood => "wood",
            Self::Clouds => "clouds",
            Self::Fire => "fire",
        }
    }

    /// The names of the [`Parameters`] that it has.
    pub const fn parameters(self) -> &'static [&'static str] {
        match self {
            Self::Sponge | Self::Weave | Self::Pebbles | Self::Leather | Self::Bark => &[],
            Self::Marble => &["z", "z-period", "power", "turbulence", "octaves"],
            Self::Wood => &["z", "cut", "turbulence"],
            Self::Clouds => &["z", "z-period", "octaves"],
            Self::Fire => &["phi", "turbulence", "octaves"],
        }
    }

    /// The material of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|material| material.name() == name)
    }

    /// Makes the maps.
    ///
    /// # Errors
    /// A feature size out of range, a parameter that the material does not have or that is out of its range,
    /// or a size beyond the limits.
    pub fn make(self, options: &MaterialOptions, job: &Job) -> Result<SurfaceMaps> {
        options.validate()?;
        options.parameters.validate(self.name(), self.parameters())?;
        job.check("a material's maps", options.size, 0)?;
        job.check_bytes("a material's maps", MaterialOptions::footprint(options.size).peak)?;
        let canvas = Canvas { size: options.size, tiling: options.tiling, seed: options.seed };
        paint(options.size, self.sampler(&canvas, options.feature, &options.parameters), job)
    }

    fn sampler(self, canvas: &Canvas, feature: f64, parameters: &Parameters) -> Box<Sampler> {
        let depth = parameters.z.unwrap_or(0.0);
        let block = SolidBlock { canvas: *canvas, feature, depth, depth_period: parameters.z_period };
        match self {
            Self::Sponge => sponge::Sponge::new(canvas, feature).sampler(),
            Self::Weave => weave::Weave::new(canvas, feature).sampler(),
            Self::Pebbles => pebbles::Pebbles::new(canvas, feature).sampler(),
            Self::Leather => leather::Leather::new(canvas, feature).sampler(),
            Self::Bark => bark::Bark::new(canvas, feature).sampler(),
            Self::Marble => marble::Marble::new(&block, parameters).sampler(),
            Self::Wood => wood::Wood::new(&block, parameters).sampler(),
            Self::Clouds => clouds::Clouds::new(&block, parameters).sampler(),
            Self::Fire => fire::Fire::new(&block, parameters).sampler(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planes::Planes;

    fn options(width: usize, height: usize) -> MaterialOptions {
        MaterialOptions { size: Size::new(width, height), feature: 18.0, ..Default::default() }
    }

    fn make(material: Material, options: &MaterialOptions) -> SurfaceMaps {
        material.make(options, &Job::default()).unwrap()
    }

    fn all_planes(maps: &SurfaceMaps) -> Vec<Planes> {
        vec![maps.height.clone(), maps.albedo.clone(), maps.roughness.clone().unwrap()]
    }

    #[test]
    fn names_lead_back_to_their_material() {
        for material in Material::ALL {
            assert_eq!(Material::from_name(material.name()), Some(material));
        }
        assert_eq!(Material::from_name("Sponge "), None);
    }

    #[test]
    fn maps_are_complete_and_in_range() {
        for material in Material::ALL {
            let maps = make(material, &options(70, 45));
            maps.validate().unwrap();
            let (low, high) = maps.height.range(0);
            assert!(low.is_finite() && high - low > 2.0 && high - low < 60.0, "{material:?} {low} {high}");
            let roughness = maps.roughness.unwrap();
            let fractions = maps.albedo.as_slice().iter().chain(roughness.as_slice());
            assert!(fractions.clone().all(|v| (0.01..=1.0).contains(v)), "{material:?}");
        }
    }

    #[test]
    fn materials_have_the_period_of_the_torus_and_none_on_the_free_plane() {
        let changed = |material: Material, tiling: Tiling| {
            let canvas = Canvas { size: Size::new(96, 61), tiling, seed: 5 };
            let sample = material.sampler(&canvas, 18.0, &Parameters::default());
            let places = (0..500).map(|k| [f64::from(k * 37 % 501) * 0.37, f64::from(k * 53 % 499) * 0.29]);
            let differs = |p: &[f64; 2]| {
                let (a, b) = (sample(*p), sample([p[0] + 96.0, p[1] - 61.0]));
                let colors = a.albedo.iter().zip(b.albedo).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                (a.height - b.height).abs().max(colors) > 1e-6
            };
            places.filter(differs).count()
        };
        for material in Material::ALL {
            assert_eq!(changed(material, Tiling::Torus), 0, "{material:?}");
            assert!(changed(material, Tiling::Free) > 450, "{material:?}");
        }
    }

    #[test]
    fn a_seed_gives_the_same_maps_at_any_thread_count_and_another_seed_gives_others() {
        for material in Material::ALL {
            let first = make(material, &options(40, 33));
            let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
            assert_eq!(pool.install(|| make(material, &options(40, 33))), first, "{material:?}");
            let other = make(material, &MaterialOptions { seed: 1, ..options(40, 33) });
            for (a, b) in all_planes(&first).iter().zip(all_planes(&other)) {
                assert_ne!(a, &b, "{material:?}");
            }
        }
    }

    #[test]
    fn a_slice_at_another_depth_or_time_is_another_picture() {
        let with = |parameters| MaterialOptions { parameters, ..options(40, 33) };
        for material in Material::ALL {
            let moved = match material.parameters() {
                [] => continue,
                ["phi", ..] => Parameters { phi: Some(0.5), ..Parameters::default() },
                _ => Parameters { z: Some(0.5), ..Parameters::default() },
            };
            let (here, there) = (make(material, &options(40, 33)), make(material, &with(moved)));
            assert_ne!(here.height, there.height, "{material:?}");
        }
    }

    #[test]
    fn parameters_that_a_material_has_not_or_out_of_range_are_refused() {
        let refused = |material: Material, parameters| {
            let options = MaterialOptions { parameters, ..options(8, 8) };
            material.make(&options, &Job::default()).unwrap_err().to_string()
        };
        let text = refused(Material::Fire, Parameters { z: Some(1.0), ..Parameters::default() });
        assert_eq!(text, "fire has no parameter 'z': it has phi, turbulence, octaves");
        assert!(
            refused(Material::Weave, Parameters { power: Some(2), ..Default::default() }).contains("none")
        );
        for parameters in [
            Parameters { z: Some(f64::NAN), ..Parameters::default() },
            Parameters { z_period: Some(0), ..Parameters::default() },
            Parameters { power: Some(65), ..Parameters::default() },
            Parameters { turbulence: Some(-1.0), ..Parameters::default() },
            Parameters { octaves: Some(0), ..Parameters::default() },
        ] {
            assert!(refused(Material::Marble, parameters).contains("expected a number from"));
        }
    }

    #[test]
    fn sizes_that_cannot_be_are_refused() {
        let job = Job::default();
        let sizes = [Size::new(0, 4), Size::new(1 << 18, 4)];
        for size in sizes {
            let options = MaterialOptions { size, ..Default::default() };
            assert!(Material::Weave.make(&options, &job).is_err());
        }
        for feature in [0.0, -3.0, f64::NAN, f64::INFINITY] {
            let options = MaterialOptions { feature, ..Default::default() };
            assert!(Material::Sponge.make(&options, &job).is_err());
        }
        for (width, height) in [(1, 1), (1, 9), (3, 2)] {
            Material::ALL.into_iter().for_each(|m| make(m, &options(width, height)).validate().unwrap());
        }
    }
}
