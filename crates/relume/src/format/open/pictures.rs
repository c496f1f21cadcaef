//! The pictures in files: of colours, data, heights and normals.

use super::Opened;
use crate::error::Result;
use crate::field::Basis;
use crate::format::content::Content;
use crate::format::field_file::MapRecord;
use crate::format::height::{HeightMap, decode_height};
use crate::format::kind::Kind;
use crate::format::map_role::NormalY;
use crate::format::mask::{Mask, decode_mask};
use crate::format::meaning::Meaning;
use crate::format::normal_map::{NormalMap, decode_normals};
use crate::format::opacity::OPACITY_UNUSED;
use crate::format::raster;
use crate::format::turned::turned_back;
use crate::raster::{Raster, Samples};
use crate::space::Space;

impl Opened {
    /// How a camera recorded that a picture is to be turned: 1 to 8 as in EXIF, 1 for as it is.
    pub fn orientation(&self) -> u16 {
        raster::orientation(&self.bytes)
    }

    /// What a picture records of the meaning of its values, which are not decoded.
    ///
    /// # Errors
    /// An invalid record.
    pub fn record(&self) -> Result<MapRecord> {
        MapRecord::of(&self.bytes).map_err(|e| e.at(&self.name))
    }

    /// A picture of colours as it is stored, whatever orientation is recorded.
    ///
    /// # Errors
    /// As [`Opened::into_raster`].
    pub fn into_unturned_raster(self) -> Result<Raster> {
        let (orientation, name) = (self.orientation(), self.name.clone());
        turned_back(self.into_raster()?, orientation).map_err(|e| e.at(name))
    }

    /// The picture as stored, in colours. An opacity is left out, with a remark of the job.
    ///
    /// # Errors
    /// As [`Opened::into_field`], for a file that holds no picture.
    pub fn into_raster(self) -> Result<Raster> {
        self.opaque_raster(Meaning::Colors)
    }

    /// As [`Opened::into_raster`], of data such as normals or roughness: values are those of the file, whatever
    /// space that names.
    ///
    /// # Errors
    /// As [`Opened::into_raster`].
    pub fn into_data(self) -> Result<Raster> {
        self.opaque_raster(Meaning::Data)
    }

    /// The mask; see [`decode_mask`].
    ///
    /// # Errors
    /// As [`Opened::into_raster`].
    pub fn into_mask(self) -> Result<Mask> {
        self.decoded("a mask", "", |opened| decode_mask(&opened.bytes, &opened.job))
    }

    /// The picture of colours with its opacity.
    ///
    /// # Errors
    /// As [`Opened::into_raster`].
    pub fn into_translucent_raster(self) -> Result<Raster> {
        self.raster_of(Meaning::Colors)
    }

    fn opaque_raster(self, meaning: Meaning) -> Result<Raster> {
        let job = self.job.clone();
        let raster = self.raster_of(meaning)?;
        if raster.opacity().is_some() {
            job.remark(OPACITY_UNUSED);
        }
        Ok(raster.without_opacity())
    }

    fn raster_of(self, meaning: Meaning) -> Result<Raster> {
        let hint = if self.content == Content::Field { "; relight it to make one" } else { "" };
        if self.content == Content::Field {
            return match self.constant_raster(meaning)? {
                Some(raster) => Ok(raster),
                None => Err(self.refused("a picture", hint)),
            };
        }
        self.decoded("a picture", hint, |opened| raster::decode_as(&opened.bytes, meaning, &opened.job))
    }

    /// The picture in an EXR file of constant functions, whose values may be sRGB-encoded; `None` of other functions.
    fn constant_raster(&self, meaning: Meaning) -> Result<Option<Raster>> {
        if Kind::of(&self.bytes) != Some(Kind::Exr) {
            return Ok(None);
        }
        let file = self.clone().into_field()?;
        let (field, channels) = (&file.field, file.field.layout().channels());
        if *field.basis() != Basis::Constant || ![1, 3].contains(&channels) || field.layout().is_named() {
            return Ok(None);
        }
        let space = if meaning == Meaning::Colors { field.space() } else { Space::Linear };
        let planes = field.coefficients();
        let texels = (0..planes.size().texels()).flat_map(|t| (0..channels).map(move |c| planes.plane(c)[t]));
        let samples = texels.map(|value| space.to_linear(value)).collect();
        let raster = Raster::new(planes.size(), channels, Samples::F32(samples))?;
        Ok(Some(match file.opacity {
            Some(opacity) => raster.with_opacity(Samples::F32(opacity.plane(0).to_vec()))?,
            None => raster,
        }))
    }

    /// The height map, with its scale if recorded; for a colour picture, the first channel.
    ///
    /// # Errors
    /// As [`Opened::into_field`], for a file that holds no heights, or has an invalid record.
    pub fn into_height(self) -> Result<HeightMap> {
        if self.content == Content::Field {
            return Err(self.refused("a height map", ""));
        }
        self.decoded("a height map", "", |opened| decode_height(&opened.bytes, &opened.job))
    }

    /// The normal map, y up; `asked` is the direction of y in the file where it is known otherwise.
    ///
    /// # Errors
    /// As [`Opened::into_field`], for a file that holds no picture of three channels, or has an invalid record.
    pub fn into_normals(self, asked: Option<NormalY>) -> Result<NormalMap> {
        if self.content == Content::Field {
            return Err(self.refused("a normal map", "; `relume relight --normals` makes one"));
        }
        self.decoded("a normal map", "", |opened| {
            decode_normals(&opened.bytes, &opened.name, asked, &opened.job)
        })
    }
}
