//! The maps of a material under the names, in the packings and in the bit depths that other programs expect.
//!
//! Colours are sRGB-encoded and marked so; all other maps are data and name no space. Normals and heights have 16 bits.
//! Heights record their range, in texels or millimetres. What is not known is left out of presets of single files, and
//! in packed files is rough (1), not metallic (0), and not occluded (1), with a remark.

mod encoding;
mod light_view;
mod materialx;
mod presets;
mod preview;
mod slots;
mod usd;

pub use encoding::WrittenMap;
pub use presets::MapPreset;
pub use preview::{PreviewObject, encode_preview};

use std::cell::LazyCell;

use super::model_surface::{SurfaceForm, facet_normals, no_normals};
use crate::capture::dome::ReliefBorder;
use crate::capture::dome::open_sky::open_sky;
use crate::capture::dome::relief::Relief;
use crate::error::{Error, Result};
use crate::field::{Basis, ParametricField, ReflectanceField, TexelModel};
use crate::format::ktx2::{self, TextureFormat};
use crate::job::Job;
use crate::maps::SurfaceMaps;
use crate::memory::Footprint;
use crate::planes::Planes;
use crate::size::Size;
use crate::space::Space;
use crate::surface::integrate::{IntegrateOptions, SurfaceBorder, integrate};
use crate::surface::{STEEPEST, Slopes};
use presets::{DataMap, MapContent, files};
use slots::MaterialSlots;

/// The reflectance at normal incidence that a specular map shows as white, as Disney's principled shader has it (B. Burley,
/// "Physically-Based Shading at Disney", SIGGRAPH 2012 course notes) and with it Blender and Unreal: 0.5 is the 0.04 of most materials.
const SPECULAR_WHITE: f32 = 0.08;

/// The maps of a material, complete but for what is not known.
#[derive(Debug, Clone)]
pub struct MaterialMaps {
    maps: SurfaceMaps,
    normals: Planes,
    occlusion: Planes,
    opacity: Option<Planes>,
    /// In units of [`SPECULAR_WHITE`].
    specular: Option<Planes>,
}

impl MaterialMaps {
    /// Completes maps: normals from the heights where there are none, and ambient occlusion as the share of open sky.
    ///
    /// # Errors
    /// Maps of differing sizes, the limits, and a cancelled job.
    pub fn of_maps(maps: SurfaceMaps, border: ReliefBorder, job: &Job) -> Result<Self> {
        Self::of_known(maps, None, None, border, job)
    }

    /// As [`MaterialMaps::of_maps`], with the occlusion where it is known, and the opacity.
    ///
    /// # Errors
    /// As [`MaterialMaps::of_maps`].
    pub fn of_known(
        maps: SurfaceMaps,
        occlusion: Option<Planes>,
        opacity: Option<Planes>,
        border: ReliefBorder,
        job: &Job,
    ) -> Result<Self> {
        maps.validate()?;
        let size = maps.size();
        for (name, planes) in [("occlusion", &occlusion), ("opacity", &opacity)] {
            if let Some(found) = planes.as_ref().map(Planes::size).filter(|found| *found != size) {
                return Err(Error::invalid(format!(
                    "the {name} has {found} texels, and the other maps {size}"
                )));
            }
        }
        let relief = LazyCell::new(|| Relief::new(&maps.height, border));
        let normals = maps.normal.clone().unwrap_or_else(|| relief.normals());
        let occlusion = match occlusion {
            Some(occlusion) => occlusion,
            None => open_sky(&relief, &normals, job)?,
        };
        Ok(Self { maps, normals, occlusion, opacity, specular: None })
    }

    /// The maps of a texture of functions: each texel at its brightest is the colour, the direction of that light the
    /// normal, and heights are integrated from the normals. Roughness is not known. Colours and normals of learned functions of light
    /// and view are those of photometric stereo of what is seen from straight above, where enough lights were measured.
    ///
    /// # Errors
    /// As [`MaterialMaps::of_maps`], and channels that do not form a colour.
    pub fn of_field(field: &ReflectanceField, border: ReliefBorder, job: &Job) -> Result<Self> {
        if field.layout().is_named() {
            return Err(Error::usage("maps of a material need colours, and the texture has named channels"));
        }
        if let Basis::Learned(learned) = field.basis()
            && let Some(maps) = light_view::of_learned(field, learned, border, job)?
        {
            return Ok(maps);
        }
        // Of each texel the direction at which it is brightest, its normal, and its colour twice.
        job.check("the normals and colours", field.size(), 24 + 12 + 24)?;
        let (normals, picture) = crate::surface::normals_and_albedo(field);
        let (normals, picture) = (normals.held(job, "the normals")?, picture.to_space(Space::Linear));
        let mut albedo = Planes::zeros_within(job, "the colours", field.size(), 3)?;
        for (k, plane) in albedo.iter_mut().enumerate() {
            let from = picture.planes.plane(k.min(picture.planes.count() - 1));
            plane.iter_mut().zip(from).for_each(|(out, v)| *out = v.clamp(0.0, 1.0));
        }
        let height = heights_of_normals(&normals, border, job)?;
        let maps = SurfaceMaps { height, albedo, normal: Some(normals), roughness: None, metallic: None };
        Self::of_maps(maps, border, job)
    }

    /// The maps of reflectance models: those that facets hold, and of functions of the light for each view those of what is seen
    /// from straight above.
    ///
    /// # Errors
    /// As [`MaterialMaps::of_facets`], and lobes, which have no normals.
    pub fn of_models(models: &ParametricField, border: ReliefBorder, job: &Job) -> Result<Self> {
        match SurfaceForm::of_models(models, job)? {
            SurfaceForm::Functions(field) => Self::of_field(&field, border, job),
            SurfaceForm::Facets { .. } => Self::of_facets(models, border, job),
            SurfaceForm::Lobes { .. } => Err(no_normals()),
        }
    }

    /// The maps that the texels of a texture of facets hold ([`TexelModel::Ggx`]): base colour, normals, roughness and specular
    /// reflectance; heights are integrated from the normals.
    ///
    /// # Errors
    /// As [`MaterialMaps::of_maps`], and a texture of another model.
    pub fn of_facets(models: &ParametricField, border: ReliefBorder, job: &Job) -> Result<Self> {
        if *models.model() != TexelModel::Ggx {
            return Err(Error::usage(format!(
                "maps of facets are of the model ggx, not of {}",
                models.model().name()
            )));
        }
        let (size, channels, from) = (models.size(), models.channels(), models.planes());
        let mut albedo = Planes::zeros_within(job, "the colours", size, 3)?;
        for (k, plane) in albedo.iter_mut().enumerate() {
            let base = from.plane(k.min(channels - 1));
            plane.iter_mut().zip(base).for_each(|(out, v)| *out = v.clamp(0.0, 1.0));
        }
        let normals = facet_normals(models, job)?;
        let rough = from.plane(channels + 2).iter().map(|v| v.clamp(0.0, 1.0)).collect();
        let roughness = Some(Planes::from_vec(size, 1, rough)?);
        let specular = from.plane(channels + 3).iter().map(|v| v / SPECULAR_WHITE).collect();
        let height = heights_of_normals(&normals, border, job)?;
        let maps = SurfaceMaps { height, albedo, normal: Some(normals), roughness, metallic: None };
        let specular = Some(Planes::from_vec(size, 1, specular)?);
        Ok(Self { specular, ..Self::of_maps(maps, border, job)? })
    }

    /// The size of all maps.
    pub fn size(&self) -> Size {
        self.maps.size()
    }

    /// The planes by which tiling is judged, with their names.
    pub fn planes(&self) -> Vec<(&'static str, &Planes)> {
        let known = [
            ("roughness", &self.maps.roughness),
            ("metallic", &self.maps.metallic),
            ("opacity", &self.opacity),
            ("specular", &self.specular),
        ];
        let all = [
            ("color", &self.maps.albedo),
            ("normal", &self.normals),
            ("height", &self.maps.height),
            ("occlusion", &self.occlusion),
        ];
        all.into_iter()
            .chain(known.into_iter().filter_map(|(name, map)| Some((name, map.as_ref()?))))
            .collect()
    }

    fn data(&self, map: DataMap) -> Option<&Planes> {
        match map {
            DataMap::Occlusion => Some(&self.occlusion),
            DataMap::Roughness | DataMap::Smoothness => self.maps.roughness.as_ref(),
            DataMap::Metallic => self.maps.metallic.as_ref(),
            DataMap::Detail => None,
            DataMap::Opacity => self.opacity.as_ref(),
            DataMap::Specular => self.specular.as_ref(),
        }
    }

    /// A plane of data, or what stands for it where it is not known.
    fn values(&self, map: DataMap, out: &mut [f32]) {
        let known = self.data(map).map(|planes| planes.plane(0));
        match (known, map) {
            (Some(plane), DataMap::Smoothness) => out.iter_mut().zip(plane).for_each(|(o, v)| *o = 1.0 - v),
            (Some(plane), DataMap::Specular) => out.iter_mut().zip(plane).for_each(|(o, v)| *o = v.min(1.0)),
            (Some(plane), _) => out.copy_from_slice(plane),
            (None, DataMap::Smoothness | DataMap::Metallic) => out.fill(0.0),
            (None, _) => out.fill(1.0),
        }
    }
}

/// Heights in texels from normals: the surface whose slopes are nearest to theirs.
///
/// # Errors
/// The limits, and a cancelled job.
pub fn heights_of_normals(normals: &Planes, border: ReliefBorder, job: &Job) -> Result<Planes> {
    let border = match border {
        ReliefBorder::Wrap => SurfaceBorder::Periodic,
        ReliefBorder::Clamp => SurfaceBorder::Open,
    };
    let options = IntegrateOptions { border, ..IntegrateOptions::default() };
    integrate(&Slopes::from_normals(normals, STEEPEST)?, &options, job)
}

/// What is written of a material.
#[derive(Debug, Clone)]
pub struct ExportOptions {
    /// Whose names and packings.
    pub preset: MapPreset,
    /// The name of the material in file names: letters, digits, - and _.
    pub name: String,
    /// The side of a texel, where known: heights are then in millimetres.
    pub mm_per_texel: Option<f64>,
    /// How colours, normals and data are stored. Heights are PNG or EXR in any case, since they need their range.
    pub textures: TextureFormat,
    /// Also a MaterialX document.
    pub materialx: bool,
    /// Also a USD layer.
    pub usd: bool,
}

impl ExportOptions {
    /// The memory of completing maps of `size` by normals and occlusion and making the largest file, beside the maps: four
    /// channels, their levels or samples.
    pub fn footprint(&self, size: Size) -> Footprint {
        let channels = 4;
        let peak = match self.textures {
            TextureFormat::Png => 4 * channels + 6 * channels,
            TextureFormat::Ktx2 | TextureFormat::Bc7 => 4 * channels + ktx2::bytes_per_texel(4),
        };
        Footprint::of_texels(size, 16 + peak, 0)
    }

    /// PNG files alone, in texels.
    pub fn new(preset: MapPreset, name: &str) -> Self {
        Self {
            preset,
            name: name.to_owned(),
            mm_per_texel: None,
            textures: TextureFormat::Png,
            materialx: false,
            usd: false,
        }
    }

    /// Refuses what no set can be.
    ///
    /// # Errors
    /// A name that is empty or no part of a file name, and documents that programs could not follow.
    pub fn validate(&self) -> Result<()> {
        if self.name.is_empty() || !self.name.chars().all(|c| c.is_ascii_alphanumeric() || "_-".contains(c)) {
            return Err(Error::usage(format!(
                "the name of a material is letters, digits, - and _, not '{}'",
                self.name.escape_debug()
            )));
        }
        if self.textures != TextureFormat::Png && (self.materialx || self.usd) {
            return Err(Error::usage(
                "MaterialX and USD documents name pictures that all programs read: write the textures as png",
            ));
        }
        if self.usd && self.preset == MapPreset::Unreal {
            return Err(Error::usage(
                "USD needs normals with +Y, and the preset unreal has -Y: choose another preset for the USD layer",
            ));
        }
        Ok(())
    }
}

/// Says of a specular map that was left out, or cut off.
fn remark_specular(maps: &MaterialMaps, slots: &MaterialSlots<'_>, job: &Job) {
    let Some(specular) = &maps.specular else { return };
    let bright = specular.plane(0).iter().filter(|v| **v > 1.0).count();
    if slots.data(DataMap::Specular).is_none() {
        job.remark("the preset has no map of specular reflectance: it was left out");
    } else if bright * 100 > specular.size().texels() {
        let percent = 100.0 * bright as f64 / specular.size().texels() as f64;
        job.remark(format!(
            "{percent:.0} % of the specular reflectances are above {SPECULAR_WHITE} and were cut off: white is {SPECULAR_WHITE} in the map"
        ));
    }
}

/// Writes maps under a preset: `store` gets the files by name.
///
/// # Errors
/// As [`ExportOptions::validate`], the limits, and those of `store`.
pub fn export_maps(
    maps: &MaterialMaps,
    options: &ExportOptions,
    job: &Job,
    store: &mut dyn FnMut(&str, &[u8]) -> Result<()>,
) -> Result<Vec<WrittenMap>> {
    options.validate()?;
    let side = maps.maps.size().width.max(maps.maps.size().height);
    let (mut written, mut slots) = (Vec::new(), Vec::new());
    for (file, content) in files(options.preset, &options.name, side, options.textures) {
        job.proceed()?;
        if let MapContent::Single(map) = content
            && maps.data(map).is_none()
        {
            continue;
        }
        let (bytes, entry) = maps.encoded(&file, content, options.textures, options.mm_per_texel, job)?;
        store(&file, &bytes)?;
        written.push(entry);
        slots.push((file, content));
    }
    let slots = MaterialSlots { files: slots, has_opacity: maps.opacity.is_some(), maps };
    if options.materialx {
        store(&format!("{}.mtlx", options.name), materialx::document(&options.name, &slots).as_bytes())?;
    }
    if options.usd {
        store(&format!("{}.usda", options.name), usd::layer(&options.name, &slots).as_bytes())?;
    }
    remark_specular(maps, &slots, job);
    if maps.maps.roughness.is_none() {
        job.remark("no roughness is known: single files leave it out, and packed files have 1");
    }
    Ok(written)
}
