//! Reading and writing fields in files of every kind, with the storage of their values.

use std::fmt;
use std::path::Path;

use serde::Serialize;

use super::exr::{self, ExrDepth, ExrField};
use super::folder::files_of;
use super::height::{self, HeightScale};
use super::hsh::{self, HshEncoding};
use super::kind::{Kind, unknown};
use super::map_role::NormalY;
use super::meaning::Meaning;
use super::multires;
use super::normal_map;
use super::picture::{Depth, PictureFormat, encode_with, extension};
use super::ptm::{self, PtmEncoding, Under};
use super::raster;
use super::texel_models::TexelModels;
use super::web;
use crate::error::{Error, Result};
use crate::field::{Basis, ReflectanceField};
use crate::job::Job;
use crate::memory::Footprint;
use crate::picture::Picture;
use crate::planes::Planes;
use crate::raster::Samples;

/// A field read from a file.
#[derive(Debug, Clone, PartialEq)]
pub struct FieldFile {
    /// The field.
    pub field: ReflectanceField,
    /// The opacity of its texels where it varies, and any alpha of a registered image: one plane, from 0 (transparent) to 1.
    pub opacity: Option<Planes>,
    /// The storage of the values in the file.
    pub encoding: Encoding,
    /// What the file records of the meaning of its values.
    pub record: MapRecord,
    /// The reflectance models of the texels, of which the field is the linear form.
    pub models: Option<TexelModels>,
}

/// What a picture records of the meaning of its values, so that copies of them can be stored with it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MapRecord {
    /// The scale of heights.
    pub heights: Option<HeightScale>,
    /// The direction of Y of normals.
    pub normal_y: Option<NormalY>,
}

impl FieldFile {
    /// Which texels are fully transparent, if any is.
    pub fn transparent(&self) -> Option<Vec<bool>> {
        let opacity = self.opacity.as_ref()?.plane(0);
        opacity.contains(&0.0).then(|| opacity.iter().map(|&opacity| opacity == 0.0).collect())
    }
}

/// The storage of values in a file, so that copies of them can be stored in the same way.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Encoding {
    /// Bytes with scale and bias.
    Ptm(PtmEncoding),
    /// Bytes of harmonics with scale and bias.
    Hsh(HshEncoding),
    /// Codes of an integer picture.
    Picture(Depth),
    /// Floats.
    Exr(ExrDepth),
}

impl From<multires::TileEncoding> for Encoding {
    fn from(encoding: multires::TileEncoding) -> Self {
        match encoding {
            multires::TileEncoding::Ptm(encoding) => Self::Ptm(encoding),
            multires::TileEncoding::Hsh(encoding) => Self::Hsh(encoding),
            multires::TileEncoding::Image => Self::Picture(Depth::Eight),
        }
    }
}

impl MapRecord {
    /// The record in the bytes of a picture.
    pub(super) fn of(bytes: &[u8]) -> Result<Self> {
        let texts = height::texts(bytes)?;
        Ok(Self { heights: height::recorded(&texts)?, normal_y: normal_map::recorded(&texts)? })
    }
}

impl fmt::Display for Encoding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Ptm(_) | Self::Hsh(_) => "8 bits a coefficient with scale and bias",
            Self::Picture(Depth::Eight) => "8 bits a sample",
            Self::Picture(Depth::Sixteen) => "16 bits a sample",
            Self::Exr(ExrDepth::Half) => "16-bit floats",
            Self::Exr(ExrDepth::Float) => "32-bit floats",
        })
    }
}

/// A file format of fields.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FieldFormat {
    /// Polynomial texture map: 8 bits a coefficient.
    Ptm,
    /// Polynomial texture map whose planes are JPEG files.
    PtmJpeg {
        /// 1 (smallest file) to 100.
        quality: u8,
    },
    /// `.rti` of hemispherical harmonics: 8 bits a coefficient.
    Rti,
    /// The older `.hsh` of hemispherical harmonics.
    Hsh,
    /// Any field, as floats.
    Exr(ExrDepth),
    /// Fields of constants only.
    Picture(PictureFormat),
}

impl FieldFormat {
    /// The format an extension stands for: floats for EXR, 8 bits for pictures; see
    /// [`FieldFormat::in_depth_of`].
    ///
    /// # Errors
    /// When no format has the extension.
    pub fn from_path(path: &Path) -> Result<Self> {
        match extension(path).as_str() {
            "ptm" => Ok(Self::Ptm),
            "rti" => Ok(Self::Rti),
            "hsh" => Ok(Self::Hsh),
            "exr" => Ok(Self::Exr(ExrDepth::Float)),
            "png" | "jpg" | "jpeg" | "tif" | "tiff" | "pfm" | "hdr" | "pic" => {
                PictureFormat::from_path(path).map(Self::Picture)
            }
            "btf" => Err(Error::usage(
                "a .btf file is written by `relume fit PHOTOGRAPHS -o FILE.btf` alone: name an .exr here",
            )
            .at(path)),
            other => Err(Error::usage(format!(
                "no format of textures has the extension '{other}': name the file .ptm, .rti or .exr, or .png, \
                 .jpg, .tif, .pfm or .hdr for a texture of constants"
            ))
            .at(path)),
        }
    }

    /// The same format in the depth of another file, where possible: a 16-bit picture stays one, halves stay
    /// halves.
    #[must_use]
    pub fn in_depth_of(self, encoding: &Encoding) -> Self {
        match (self, encoding) {
            (Self::Exr(_), Encoding::Exr(depth)) => Self::Exr(*depth),
            (Self::Picture(format), Encoding::Picture(depth)) => Self::Picture(format.with_depth(*depth)),
            _ => self,
        }
    }

    /// Whether files of this format hold all values as they are, without rounding.
    pub fn is_exact(self) -> bool {
        self == Self::Exr(ExrDepth::Float)
    }

    /// Whether values are sRGB-encoded by convention, so that fields of linear values are refused.
    pub fn is_encoded(self) -> bool {
        matches!(self, Self::Ptm | Self::PtmJpeg { .. } | Self::Rti | Self::Hsh)
    }

    /// Refuses a basis, by its name, that files of this format cannot hold.
    ///
    /// # Errors
    /// The sentence says which they hold.
    pub fn check_basis(self, name: &str) -> Result<()> {
        let (fits, holds) = match self {
            Self::Ptm | Self::PtmJpeg { .. } => {
                (name == "ptm", "a .ptm file holds functions of the basis ptm")
            }
            Self::Rti => (name.starts_with("hsh"), "a .rti file holds hemispherical harmonics, such as hsh9"),
            Self::Hsh => (name.starts_with("hsh"), "a .hsh file holds hemispherical harmonics, such as hsh9"),
            Self::Exr(_) => (true, ""),
            Self::Picture(_) => (name == "constant", "a picture holds constants"),
        };
        match fits {
            true => Ok(()),
            false => Err(Error::usage(format!("{holds}, not {name}: name an .exr to write"))),
        }
    }

    /// Whether files of this format hold the opacity of texels.
    pub fn holds_opacity(self) -> bool {
        let lacks = |format: &PictureFormat| {
            matches!(format, PictureFormat::Jpeg { .. } | PictureFormat::Pfm | PictureFormat::Radiance)
        };
        !self.is_encoded() && !matches!(self, Self::Picture(format) if lacks(&format))
    }
}

/// The field in the bytes of a file: a `.ptm`, an EXR field, or any picture as a field of constants.
/// Integer pictures and `.ptm` give sRGB-encoded values, EXR pictures linear ones.
///
/// # Errors
/// A file that is truncated, is of another kind or exceeds the limits.
pub fn decode_field(bytes: &[u8], job: &Job) -> Result<FieldFile> {
    let file = decode_as(bytes, Meaning::Colors, job)?;
    file.linear_remark().into_iter().for_each(|remark| job.remark(remark));
    Ok(file)
}

/// As [`decode_field`], for values of a given meaning.
pub(super) fn decode_as(bytes: &[u8], meaning: Meaning, job: &Job) -> Result<FieldFile> {
    let file = decode_any(bytes, meaning, job)?;
    let opacity = file.opacity.map(|opacity| opacity.held(job, "the opacity")).transpose()?;
    Ok(FieldFile { field: file.field.held(job, "the texture")?, opacity, ..file })
}

/// The field of a web folder.
pub(super) fn decode_folder(folder: &Path, job: &Job) -> Result<FieldFile> {
    let read = files_of(folder, job);
    let (field, encoding) = match web::info_of(folder, job)? {
        Some(_) => (web::decode(&read, job)?, Encoding::Picture(Depth::Eight)),
        None => {
            let (field, encoding) = multires::decode(&read, job)?;
            (field, encoding.into())
        }
    };
    let field = field.held(job, "the texture")?;
    Ok(FieldFile { field, opacity: None, encoding, record: MapRecord::default(), models: None })
}

fn decode_any(bytes: &[u8], meaning: Meaning, job: &Job) -> Result<FieldFile> {
    let _file = job.hold("the file", bytes.len() as u64)?;
    match Kind::of_texels(bytes)? {
        Kind::Ptm => {
            let (field, encoding) = ptm::decode(bytes, job)?;
            let record = MapRecord::default();
            Ok(FieldFile { field, opacity: None, encoding: Encoding::Ptm(encoding), record, models: None })
        }
        Kind::Hsh => {
            let (field, encoding) = hsh::decode(bytes, job)?;
            let record = MapRecord::default();
            Ok(FieldFile { field, opacity: None, encoding: Encoding::Hsh(encoding), record, models: None })
        }
        Kind::Exr => {
            let ExrField { field, opacity, depth, models } = exr::decode_field(bytes, meaning, job)?;
            let (encoding, record) = (Encoding::Exr(depth), MapRecord::of(bytes)?);
            Ok(FieldFile { field, opacity, encoding, record, models })
        }
        Kind::Png | Kind::Jpeg | Kind::Tiff | Kind::Pfm | Kind::Radiance => {
            decode_constants(bytes, meaning, job)
        }
        Kind::Rlm | Kind::Npy | Kind::Glb | Kind::Btf | Kind::Bsdf | Kind::Merl => Err(unknown(bytes)),
    }
}

fn decode_constants(bytes: &[u8], meaning: Meaning, job: &Job) -> Result<FieldFile> {
    if let Some(head) = raster::head(bytes) {
        job.check("the picture as a field", head.size, head.texel_bytes + 8 * head.channels)?;
    }
    let raster = raster::decode_as(bytes, meaning, job)?;
    job.check("the picture as a field", raster.size(), 8 * raster.channels() as u64)?;
    let encoding = match raster.samples() {
        Samples::U8(_) => Encoding::Picture(Depth::Eight),
        Samples::U16(_) => Encoding::Picture(Depth::Sixteen),
        Samples::F32(_) => Encoding::Exr(ExrDepth::Float),
    };
    let picture = raster.to_picture(raster.samples().space());
    let (opacity, record) = (raster.opacity_plane(), MapRecord::of(bytes)?);
    Ok(FieldFile { field: ReflectanceField::from_picture(picture), opacity, encoding, record, models: None })
}

/// The bytes of the file of a field.
///
/// With the `encoding` of the file from which the values of the field were copied, a `.ptm` stores them in
/// the same bytes; without it, or with that of another kind, scale and bias are chosen for the least error of
/// relit values. Pictures and EXR files give exact copies in the depth they were read in; see
/// [`FieldFormat::in_depth_of`].
///
/// # Errors
/// When the format cannot hold the field, which the message explains, or the limits are exceeded.
pub fn encode_field(
    field: &ReflectanceField,
    format: FieldFormat,
    encoding: Option<&Encoding>,
    job: &Job,
) -> Result<Vec<u8>> {
    encode_translucent(field, None, format, encoding, job)
}

/// As [`encode_field`], with an opacity of one plane from 0 to 1; see [`FieldFormat::holds_opacity`].
///
/// # Errors
/// As [`encode_field`], and for an opacity that the format cannot hold.
pub fn encode_translucent(
    field: &ReflectanceField,
    opacity: Option<&Planes>,
    format: FieldFormat,
    encoding: Option<&Encoding>,
    job: &Job,
) -> Result<Vec<u8>> {
    let footprint = format.footprint(field.size(), field.coefficients().count());
    let joined = if opacity.is_some() { format.opacity_footprint(field) } else { Footprint::default() };
    job.check_bytes("writing the texture", footprint.peak.saturating_add(joined.peak))?;
    if opacity.is_some() && !format.holds_opacity() {
        return Err(Error::usage(
            "JPEG, PFM, Radiance, PTM and RTI files hold no opacity: write PNG, TIFF or EXR",
        ));
    }
    let under = match encoding {
        Some(Encoding::Ptm(stored)) => Under::Stored(stored),
        _ => Under::Chosen,
    };
    let harmonics = match encoding {
        Some(Encoding::Hsh(stored)) => Some(stored),
        _ => None,
    };
    match format {
        FieldFormat::Rti => hsh::encode_rti(field, harmonics, job),
        FieldFormat::Hsh => hsh::encode_hsh(field, harmonics, job),
        FieldFormat::Ptm => ptm::encode(field, under, job),
        FieldFormat::PtmJpeg { quality } => ptm::encode_compressed(field, under, quality, job),
        FieldFormat::Exr(depth) => exr::encode_field(field, opacity, depth, job),
        FieldFormat::Picture(format) => encode_with(&constants(field)?, opacity, format, job),
    }
}

/// A field of constants as a picture.
pub(super) fn constants(field: &ReflectanceField) -> Result<Picture> {
    if *field.basis() == Basis::Constant && field.layout().is_product() {
        return Err(Error::usage(
            "a constant for each texel times its colour is not a picture: make plain colours of it (--color rgb)",
        ));
    }
    if *field.basis() != Basis::Constant || !field.layout().is_picture() {
        return Err(Error::usage(format!(
            "a texture of {} {} functions is not a picture: write .ptm or .exr, or relight it",
            field.layout().name(),
            field.basis().name()
        )));
    }
    Ok(Picture { planes: field.coefficients().clone(), space: field.space() })
}
