//! The maps of a material under the names, in the packings and in the bit depths that other programs expect.
//!
//! Colours are sRGB-encoded and marked so; all other maps are data and name no space. Normals and heights have 16 bits.
//! Heights record their range, in texels or millimetres. What is not known is left out of presets of single files, and
//! in packed files is rough (1), not metallic (0), and not occluded (1), with a remark.

use rayon::prelude::*;
use serde::Serialize;

use crate::capture::dome::ReliefBorder;
use crate::capture::dome::horizon::Surroundings;
use crate::capture::dome::relief::Relief;
use crate::error::{Error, Result};
use crate::field::{ParametricField, ReflectanceField, TexelModel};
use crate::format::{
    Depth, HeightFormat, NormalY, PictureFormat, encode_data_map, encode_height_with, encode_normals,
    encode_picture_with,
};
use crate::job::Job;
use crate::maps::SurfaceMaps;
use crate::names::named;
use crate::picture::Picture;
use crate::planes::Planes;
use crate::space::Space;
use crate::surface::integrate::{IntegrateOptions, SurfaceBorder, integrate};
use crate::surface::{STEEPEST, Slopes};

/// Sectors of azimuth of the ambient occlusion.
const SECTORS: usize = 32;

/// The program, or the library of materials, whose names and packings are used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum MapPreset {
    /// `Name_1K-PNG_Color.png` and so on, one map a file, both normal maps.
    AmbientCg,
    /// `name_diff_1k.png` and so on, one map a file and `arm`, both normal maps.
    PolyHaven,
    /// Base colour, occlusion with roughness and metallic, normal with +Y.
    Gltf,
    /// `T_Name_BC`, `N` with -Y, `ORM`, `H`.
    Unreal,
    /// Base colour, mask map (metallic, occlusion, detail, smoothness), normal with +Y, height.
    Unity,
    /// Albedo, ORM, normal with +Y, height.
    Godot,
    /// One map a file, normal with +Y, displacement as floats.
    Blender,
}

named!(MapPreset {
    AmbientCg => "ambientcg",
    PolyHaven => "polyhaven",
    Gltf => "gltf",
    Unreal => "unreal",
    Unity => "unity",
    Godot => "godot",
    Blender => "blender",
});

/// The contents of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum MapContent {
    Color,
    Normal(NormalY),
    Height(HeightFormat),
    /// One plane of data alone.
    Single(DataMap),
    /// Planes of data as channels.
    Packed(&'static [DataMap]),
}

/// A plane of data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum DataMap {
    Occlusion,
    Roughness,
    Smoothness,
    Metallic,
    /// Everything is shown of details that a program adds.
    Detail,
}

/// A file that was written.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct WrittenMap {
    /// Its name.
    pub file: String,
    /// What its channels hold, in order.
    pub channels: Vec<&'static str>,
    /// Bits of a sample.
    pub bits: u32,
    /// `srgb` for colours, `data` for all else.
    pub encoding: &'static str,
    /// Of normal maps, the direction of the second channel.
    pub normal_y: Option<NormalY>,
    /// Of heights, the lowest and the highest, in `unit`.
    pub range: Option<[f64; 2]>,
    /// `mm` or `texels`.
    pub unit: Option<&'static str>,
}

/// The maps of a material, complete but for what is not known.
#[derive(Debug, Clone)]
pub struct MaterialMaps {
    maps: SurfaceMaps,
    normals: Planes,
    occlusion: Planes,
}

impl MaterialMaps {
    /// Completes maps: normals from the heights where there are none, and ambient occlusion as the share of open sky.
    ///
    /// # Errors
    /// Maps of differing sizes, the limits, and a cancelled job.
    pub fn of_maps(maps: SurfaceMaps, border: ReliefBorder, job: &Job) -> Result<Self> {
        maps.validate()?;
        job.check("the ambient occlusion", maps.size(), 8 * SECTORS as u64 + 48)?;
        let relief = Relief::new(&maps.height, border);
        let normals = maps.normal.clone().unwrap_or_else(|| relief.normals());
        let sky = Surroundings::new(&relief, &normals, SECTORS, job)?.sky;
        let open = sky.into_par_iter().map(|share| share.clamp(0.0, 1.0)).collect();
        let occlusion = Planes::from_vec(maps.size(), 1, open)?;
        Ok(Self { maps, normals, occlusion })
    }

    /// The maps of a texture of functions: each texel at its brightest is the colour, the direction of that light the
    /// normal, and heights are integrated from the normals. Roughness is not known.
    ///
    /// # Errors
    /// As [`MaterialMaps::of_maps`], and channels that do not form a colour.
    pub fn of_field(field: &ReflectanceField, border: ReliefBorder, job: &Job) -> Result<Self> {
        if field.layout().is_named() {
            return Err(Error::usage("maps of a material need colours, and the texture has named channels"));
        }
        let normals = crate::surface::normals(field);
        let picture = crate::surface::albedo(field).to_space(Space::Linear);
        let mut albedo = Planes::zeros_within(job, "the colours", field.size(), 3)?;
        for (k, plane) in albedo.iter_mut().enumerate() {
            let from = picture.planes.plane(k.min(picture.planes.count() - 1));
            plane.iter_mut().zip(from).for_each(|(out, v)| *out = v.clamp(0.0, 1.0));
        }
        let height = integrated(&normals, border, job)?;
        let maps = SurfaceMaps { height, albedo, normal: Some(normals), roughness: None, metallic: None };
        Self::of_maps(maps, border, job)
    }

    /// The maps that the texels of a texture of facets hold ([`TexelModel::Ggx`]): base colour, normals and roughness; heights
    /// are integrated from the normals.
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
        let mut normals = Planes::zeros_within(job, "the normals", size, 3)?;
        (0..2).for_each(|axis| normals.plane_mut(axis).copy_from_slice(from.plane(channels + axis)));
        for texel in 0..size.texels() {
            let [x, y] = [0, 1].map(|axis| normals.plane(axis)[texel]);
            normals.plane_mut(2)[texel] = (1.0 - x * x - y * y).max(0.0).sqrt();
        }
        let rough = from.plane(channels + 2).iter().map(|v| v.clamp(0.0, 1.0)).collect();
        let roughness = Some(Planes::from_vec(size, 1, rough)?);
        let height = integrated(&normals, border, job)?;
        let maps = SurfaceMaps { height, albedo, normal: Some(normals), roughness, metallic: None };
        Self::of_maps(maps, border, job)
    }

    /// The planes by which tiling is judged, with their names.
    pub fn planes(&self) -> Vec<(&'static str, &Planes)> {
        let known = [("roughness", &self.maps.roughness), ("metallic", &self.maps.metallic)];
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
        }
    }

    /// A plane of data, or what stands for it where it is not known.
    fn values(&self, map: DataMap, out: &mut [f32]) {
        let known = self.data(map).map(|planes| planes.plane(0));
        match (known, map) {
            (Some(plane), DataMap::Smoothness) => out.iter_mut().zip(plane).for_each(|(o, v)| *o = 1.0 - v),
            (Some(plane), _) => out.copy_from_slice(plane),
            (None, DataMap::Smoothness | DataMap::Metallic) => out.fill(0.0),
            (None, _) => out.fill(1.0),
        }
    }
}

/// Heights in texels from normals.
fn integrated(normals: &Planes, border: ReliefBorder, job: &Job) -> Result<Planes> {
    let border = match border {
        ReliefBorder::Wrap => SurfaceBorder::Periodic,
        ReliefBorder::Clamp => SurfaceBorder::Open,
    };
    let options = IntegrateOptions { border, ..IntegrateOptions::default() };
    integrate(&Slopes::from_normals(normals, STEEPEST)?, &options, job)
}

/// Writes maps under a preset: `store` gets the files by name.
///
/// # Errors
/// A name that is empty or no part of a file name, the limits, and those of `store`.
pub fn export_maps(
    maps: &MaterialMaps,
    preset: MapPreset,
    name: &str,
    mm_per_texel: Option<f64>,
    job: &Job,
    store: &mut dyn FnMut(&str, &[u8]) -> Result<()>,
) -> Result<Vec<WrittenMap>> {
    if name.is_empty() || !name.chars().all(|c| c.is_ascii_alphanumeric() || "_-".contains(c)) {
        return Err(Error::usage(format!(
            "the name of a material is letters, digits, - and _, not '{}'",
            name.escape_debug()
        )));
    }
    let side = maps.maps.size().width.max(maps.maps.size().height);
    let mut written = Vec::new();
    for (file, content) in files(preset, name, side) {
        job.proceed()?;
        if let MapContent::Single(map) = content
            && maps.data(map).is_none()
        {
            continue;
        }
        let (bytes, entry) = maps.encoded(&file, content, mm_per_texel, job)?;
        store(&file, &bytes)?;
        written.push(entry);
    }
    if maps.maps.roughness.is_none() {
        job.remark("no roughness is known: single files leave it out, and packed files have 1");
    }
    Ok(written)
}

/// The resolution as libraries of materials write it.
fn resolution(side: usize, thousand: char) -> String {
    if side >= 1024 { format!("{}{thousand}", (side + 512) / 1024) } else { format!("{side}px") }
}

/// The files of a preset.
fn files(preset: MapPreset, name: &str, side: usize) -> Vec<(String, MapContent)> {
    use DataMap::{Detail, Metallic, Occlusion, Roughness, Smoothness};
    use MapContent::{Color, Height, Normal, Packed, Single};
    const ORM: &[DataMap] = &[Occlusion, Roughness, Metallic];
    const MASK: &[DataMap] = &[Metallic, Occlusion, Detail, Smoothness];
    let (up, down, png) = (Normal(NormalY::Up), Normal(NormalY::Down), Height(HeightFormat::Png));
    let singles = [Single(Roughness), Single(Metallic), Single(Occlusion)];
    let [rough, metal, ao] = singles;
    let lower = name.to_ascii_lowercase();
    let list: Vec<(&str, MapContent)> = match preset {
        MapPreset::AmbientCg => vec![
            ("Color", Color),
            ("NormalGL", up),
            ("NormalDX", down),
            ("Roughness", rough),
            ("Metalness", metal),
            ("Displacement", png),
            ("AmbientOcclusion", ao),
        ],
        MapPreset::PolyHaven => vec![
            ("diff", Color),
            ("nor_gl", up),
            ("nor_dx", down),
            ("rough", rough),
            ("metal", metal),
            ("disp", png),
            ("ao", ao),
            ("arm", Packed(ORM)),
        ],
        MapPreset::Gltf => {
            vec![("baseColor", Color), ("occlusionRoughnessMetallic", Packed(ORM)), ("normal", up)]
        }
        MapPreset::Unreal => vec![("BC", Color), ("N", down), ("ORM", Packed(ORM)), ("H", png)],
        MapPreset::Unity => {
            vec![("BaseColor", Color), ("MaskMap", Packed(MASK)), ("Normal", up), ("Height", png)]
        }
        MapPreset::Godot => vec![("albedo", Color), ("orm", Packed(ORM)), ("normal", up), ("height", png)],
        MapPreset::Blender => vec![
            ("BaseColor", Color),
            ("Roughness", rough),
            ("Metallic", metal),
            ("Normal_GL", up),
            ("Displacement", Height(HeightFormat::Exr)),
            ("AO", ao),
        ],
    };
    let file = |(word, content): (&str, MapContent)| {
        let extension = if content == Height(HeightFormat::Exr) { "exr" } else { "png" };
        let stem = match preset {
            MapPreset::AmbientCg => format!("{name}_{}-PNG_{word}", resolution(side, 'K')),
            MapPreset::PolyHaven => format!("{lower}_{word}_{}", resolution(side, 'k')),
            MapPreset::Unreal => format!("T_{name}_{word}"),
            _ => format!("{name}_{word}"),
        };
        (format!("{stem}.{extension}"), content)
    };
    list.into_iter().map(file).collect()
}

impl DataMap {
    fn name(self) -> &'static str {
        match self {
            Self::Occlusion => "occlusion",
            Self::Roughness => "roughness",
            Self::Smoothness => "smoothness",
            Self::Metallic => "metallic",
            Self::Detail => "detail",
        }
    }
}

impl MaterialMaps {
    fn encoded(
        &self,
        file: &str,
        content: MapContent,
        mm_per_texel: Option<f64>,
        job: &Job,
    ) -> Result<(Vec<u8>, WrittenMap)> {
        let mut entry = WrittenMap {
            file: file.to_owned(),
            channels: Vec::new(),
            bits: 8,
            encoding: "data",
            normal_y: None,
            range: None,
            unit: None,
        };
        let bytes = match content {
            MapContent::Color => {
                (entry.channels, entry.encoding) = (vec!["red", "green", "blue"], "srgb");
                let picture = Picture { planes: self.maps.albedo.clone(), space: Space::Linear };
                encode_picture_with(&picture, PictureFormat::Png(Depth::Eight), job)?
            }
            MapContent::Normal(y) => {
                (entry.channels, entry.bits, entry.normal_y) = (vec!["x", "y", "z"], 16, Some(y));
                encode_normals(&self.normals, y, PictureFormat::Png(Depth::Sixteen), job)?
            }
            MapContent::Height(format) => {
                let (low, high) = self.maps.height.range(0);
                let unit = mm_per_texel.unwrap_or(1.0);
                entry.channels = vec!["height"];
                entry.bits = if format == HeightFormat::Png { 16 } else { 32 };
                entry.range = Some([f64::from(low) * unit, f64::from(high) * unit]);
                entry.unit = Some(if mm_per_texel.is_some() { "mm" } else { "texels" });
                encode_height_with(&self.maps.height, mm_per_texel, format, job)?
            }
            MapContent::Single(map) => {
                entry.channels = vec![map.name()];
                self.packed(&[map], job)?
            }
            MapContent::Packed(maps) => {
                entry.channels = maps.iter().map(|map| map.name()).collect();
                self.packed(maps, job)?
            }
        };
        Ok((bytes, entry))
    }

    fn packed(&self, maps: &[DataMap], job: &Job) -> Result<Vec<u8>> {
        let mut planes = Planes::zeros_within(job, "the packed maps", self.maps.size(), maps.len())?;
        planes.iter_mut().zip(maps).for_each(|(plane, map)| self.values(*map, plane));
        encode_data_map(&planes, Depth::Eight, job)
    }
}
