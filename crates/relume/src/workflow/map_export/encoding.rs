//! The bytes of each file of a set.

use serde::Serialize;

use super::MaterialMaps;
use super::presets::{DataMap, MapContent};
use crate::error::Result;
use crate::field::ReflectanceField;
use crate::format::ktx2::{self, KtxContent, TextureFormat};
use crate::format::{
    Depth, FieldFormat, HeightFormat, NormalY, PictureFormat, encode_data_map, encode_height_with,
    encode_normals, encode_translucent,
};
use crate::job::Job;
use crate::picture::Picture;
use crate::planes::Planes;
use crate::space::Space;

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
    /// Of KTX2 files, how texels are stored.
    pub texture: Option<TextureFormat>,
}

impl WrittenMap {
    fn named(file: &str) -> Self {
        Self {
            file: file.to_owned(),
            channels: Vec::new(),
            bits: 8,
            encoding: "data",
            normal_y: None,
            range: None,
            unit: None,
            texture: None,
        }
    }
}

impl MaterialMaps {
    /// The bytes of a file and what is said of it.
    pub(super) fn encoded(
        &self,
        file: &str,
        content: MapContent,
        textures: TextureFormat,
        mm_per_texel: Option<f64>,
        job: &Job,
    ) -> Result<(Vec<u8>, WrittenMap)> {
        if let MapContent::Height(format) = content {
            return self.encoded_height(file, format, mm_per_texel, job);
        }
        let mut entry = WrittenMap::named(file);
        (entry.channels, entry.encoding) = (self.channels(content), content.encoding());
        if let MapContent::Normal(y) = content {
            (entry.normal_y, entry.bits) = (Some(y), 16);
        }
        if textures != TextureFormat::Png {
            (entry.texture, entry.bits) = (Some(textures), 8);
            let planes = self.stored(content, job)?;
            return Ok((ktx2::encode(&planes, content.in_texture(), textures, job)?, entry));
        }
        let bytes = match content {
            MapContent::Color { .. } => self.encoded_color(content, job)?,
            MapContent::Normal(y) => {
                encode_normals(&self.normals, y, PictureFormat::Png(Depth::Sixteen), job)?
            }
            _ => encode_data_map(&self.stored(content, job)?, Depth::Eight, job)?,
        };
        Ok((bytes, entry))
    }

    fn encoded_color(&self, content: MapContent, job: &Job) -> Result<Vec<u8>> {
        let picture = self.encoded_albedo(job)?;
        let field = ReflectanceField::from_picture(picture);
        let format = FieldFormat::Picture(PictureFormat::Png(Depth::Eight));
        let opacity =
            self.opacity.as_ref().filter(|_| matches!(content, MapContent::Color { translucent: true }));
        encode_translucent(&field, opacity, format, None, job)
    }

    /// The colours as displays take them.
    fn encoded_albedo(&self, job: &Job) -> Result<Picture> {
        job.check("the encoded colours", self.maps.size(), 24)?;
        Ok(Picture { planes: self.maps.albedo.clone(), space: Space::Linear }.to_space(Space::Srgb))
    }

    fn encoded_height(
        &self,
        file: &str,
        format: HeightFormat,
        mm_per_texel: Option<f64>,
        job: &Job,
    ) -> Result<(Vec<u8>, WrittenMap)> {
        let (low, high) = self.maps.height.range(0);
        let unit = mm_per_texel.unwrap_or(1.0);
        let entry = WrittenMap {
            channels: vec!["height"],
            bits: if format == HeightFormat::Png { 16 } else { 32 },
            range: Some([f64::from(low) * unit, f64::from(high) * unit]),
            unit: Some(if mm_per_texel.is_some() { "mm" } else { "texels" }),
            ..WrittenMap::named(file)
        };
        Ok((encode_height_with(&self.maps.height, mm_per_texel, format, job)?, entry))
    }

    fn channels(&self, content: MapContent) -> Vec<&'static str> {
        match content {
            MapContent::Color { translucent: true } if self.opacity.is_some() => {
                vec!["red", "green", "blue", "opacity"]
            }
            MapContent::Color { .. } => vec!["red", "green", "blue"],
            MapContent::Normal(_) => vec!["x", "y", "z"],
            MapContent::Height(_) => vec!["height"],
            MapContent::Single(map) => vec![map.name()],
            MapContent::Packed(maps) => maps.iter().map(|map| map.name()).collect(),
        }
    }

    /// The planes of a texture from 0 to 1: colours encoded, normals packed.
    pub(super) fn stored(&self, content: MapContent, job: &Job) -> Result<Planes> {
        let count = self.channels(content).len();
        let mut planes = Planes::zeros_within(job, "the channels of a map", self.maps.size(), count)?;
        match content {
            MapContent::Color { .. } => {
                let encoded = self.encoded_albedo(job)?.planes;
                let opacity = self.opacity.iter().flat_map(Planes::iter);
                let from = encoded.iter().chain(opacity);
                planes.iter_mut().zip(from).for_each(|(to, from)| to.copy_from_slice(from));
            }
            MapContent::Normal(y) => {
                for (k, (to, from)) in planes.iter_mut().zip(self.normals.iter()).enumerate() {
                    let sign = if k == 1 && y == NormalY::Down { -0.5 } else { 0.5 };
                    to.iter_mut().zip(from).for_each(|(to, v)| *to = sign * v + 0.5);
                }
            }
            MapContent::Height(_) => planes.plane_mut(0).copy_from_slice(self.maps.height.plane(0)),
            MapContent::Single(map) => self.values(map, planes.plane_mut(0)),
            MapContent::Packed(maps) => {
                planes.iter_mut().zip(maps).for_each(|(plane, map)| self.values(*map, plane));
            }
        }
        Ok(planes)
    }
}

impl MapContent {
    fn encoding(self) -> &'static str {
        if matches!(self, Self::Color { .. }) { "srgb" } else { "data" }
    }

    fn in_texture(self) -> KtxContent {
        match self {
            Self::Color { .. } => KtxContent::Color,
            Self::Normal(_) => KtxContent::Normals,
            _ => KtxContent::Data,
        }
    }

    /// Where a plane of data is in a file: the channel, and whether it holds one minus the value.
    pub(super) fn place_of(self, wanted: DataMap) -> Option<(usize, bool)> {
        let single = [match self {
            Self::Single(map) => map,
            _ => DataMap::Detail,
        }];
        let maps = if let Self::Packed(maps) = self { maps } else { &single };
        let is =
            |map: &DataMap| *map == wanted || (*map == DataMap::Smoothness && wanted == DataMap::Roughness);
        maps.iter().position(is).map(|k| (k, maps[k] != wanted))
    }
}
