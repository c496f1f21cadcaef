//! The maps of textures of light and view.
//!
//! What is seen from straight above does not move with the light, whatever the depth of the surface: colours and normals are those of
//! photometric stereo of these pictures. Roughness needs the other views as well: it is that of the facets fitted to all pairs, in
//! which depth and shadows blur what is steep.

use super::{MaterialMaps, heights_of_normals};
use crate::capture::dome::ReliefBorder;
use crate::direction::{Direction, Directions};
use crate::error::Result;
use crate::field::{Learned, ReflectanceField};
use crate::fit::parametric::{self, FacetAim, ParametricForm, ParametricOptions};
use crate::job::Job;
use crate::maps::SurfaceMaps;
use crate::planes::Planes;
use crate::raster::{LoadRaster, Raster, Samples};
use crate::render::relight;
use crate::space::Space;
use crate::surface::photometric_stereo::{StereoInput, StereoOptions, photometric_stereo};
use crate::workflow::btf::{Btf, FRONTAL_COSINE};

/// The least pictures from straight above from which normals are found: fewer do not show which are in shadow.
const LEAST_LIGHTS: usize = 8;

impl MaterialMaps {
    /// The maps of a texture of light and view: colours and normals by photometric stereo of the photographs seen from straight
    /// above, roughness and specular reflectance by fitting a facet (GGX) to each texel under pairs spread evenly over all
    /// ([`FacetAim::Maps`]), and heights integrated from the normals. With fewer than eight photographs from above all are those of the facets.
    ///
    /// # Errors
    /// As [`MaterialMaps::of_maps`], [`parametric::fit`] and [`photometric_stereo`].
    pub fn of_btf(btf: &Btf, border: ReliefBorder, job: &Job) -> Result<Self> {
        let pairs = btf.pairs();
        let load = |i: usize| btf.photograph(i, job);
        let usual = ParametricOptions::of(ParametricForm::Ggx);
        let options = ParametricOptions { report_texels: 1, aim: FacetAim::Maps, ..usual };
        let fit = parametric::fit(&pairs, &load, &options, job).map_err(|e| e.at(btf.path()))?;
        let facets = Self::of_facets(&fit.field, border, job)?;
        let frontal = btf.frontal().unwrap_or_default();
        if frontal.len() < LEAST_LIGHTS {
            return Ok(facets);
        }
        let lights: Vec<(String, Direction)> =
            frontal.iter().map(|&i| (pairs[i].0.clone(), pairs[i].1.light)).collect();
        let load = |i: usize| btf.photograph(frontal[i], job);
        let seen =
            stereo(&lights, &load, facets.maps.roughness, border, job).map_err(|e| e.at(btf.path()))?;
        Ok(Self { specular: facets.specular, ..seen })
    }
}

/// The maps of a texture of learned functions, by photometric stereo of its pictures under the lights that were measured from
/// straight above; `None` where these are few.
pub(super) fn of_learned(
    field: &ReflectanceField,
    learned: &Learned,
    border: ReliefBorder,
    job: &Job,
) -> Result<Option<MaterialMaps>> {
    let frontal = learned.pairs().iter().filter(|pair| pair.view.z() > FRONTAL_COSINE);
    let lights: Vec<(String, Direction)> = frontal.map(|pair| (String::new(), pair.light)).collect();
    if lights.len() < LEAST_LIGHTS {
        return Ok(None);
    }
    let load = |i: usize| {
        let picture = relight(field, Directions::lit_from(lights[i].1)).to_space(Space::Linear);
        let (size, channels) = (picture.planes.size(), picture.planes.count());
        let texels = 0..size.texels();
        let samples =
            texels.flat_map(|t| (0..channels).map(|k| picture.planes.plane(k)[t]).collect::<Vec<_>>());
        Raster::new(size, channels, Samples::F32(samples.collect()))
    };
    stereo(&lights, &load, None, border, job).map(Some)
}

fn stereo(
    lights: &[(String, Direction)],
    load: &LoadRaster<'_>,
    roughness: Option<Planes>,
    border: ReliefBorder,
    job: &Job,
) -> Result<MaterialMaps> {
    let input = StereoInput { lights, lamps: None, load };
    let found = photometric_stereo(input, &StereoOptions::default(), job)?;
    let size = found.normals.size();
    let mut albedo = Planes::zeros_within(job, "the colours", size, 3)?;
    for (k, plane) in albedo.iter_mut().enumerate() {
        let from = found.albedo.planes.plane(k.min(found.albedo.planes.count() - 1));
        plane.iter_mut().zip(from).for_each(|(out, v)| *out = v.clamp(0.0, 1.0));
    }
    let height = heights_of_normals(&found.normals, border, job)?;
    let maps = SurfaceMaps { height, albedo, normal: Some(found.normals), roughness, metallic: None };
    MaterialMaps::of_maps(maps, border, job)
}
