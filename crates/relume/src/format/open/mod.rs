//! The entry point for files: each is opened and read once, recognised by its content, and converted to what
//! a caller needs.

mod forms;
mod pictures;

use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::bonn::BonnBtf;
use super::brdf::decode_brdf;
use super::content::{Content, content, is_known};
use super::field_file::{self, FieldFile};
use super::height::HeightMap;
use super::kind::{Kind, of_light_and_view, unknown};
use super::meaning::Meaning;
use super::mesh::decode_mesh;
use super::npy::{self, Array};
use super::opacity::OPACITY_UNUSED;
use super::tile_set::{self, Said, TileSetFile};
use super::whole::{read_bytes, read_file};
use super::{exr, multires, rlm, web};
use crate::brdf::MeasuredBrdf;
use crate::error::{Error, Result};
use crate::job::{Held, Job};
use crate::planes::Planes;
use crate::random_field::FieldModel;
use crate::raster::Raster;
use crate::render::Mesh;
use crate::stamp::Stamp;

/// A file that has been read, and its content.
#[derive(Debug, Clone)]
pub struct Opened {
    name: PathBuf,
    /// Shared, so that a copy of an opened file takes no more memory.
    bytes: Arc<Vec<u8>>,
    /// The bytes count against the budget for as long as any copy lives.
    _held: Arc<Held>,
    content: Content,
    tiles: Option<Said>,
    job: Job,
}

/// Reads a file, once and from its beginning to its end, and recognises it by its content. A folder is a
/// capture, or a texture by its `info.json` or `info.xml`, which may be named in its place.
///
/// # Errors
/// The error names the file: one that cannot be read or exceeds the limits, or has a damaged record of tiles.
pub fn open(path: &Path, job: &Job) -> Result<Opened> {
    if let Some(folder) = web::folder_of(path)
        && info_of(folder, job)?.is_some()
    {
        return open(folder, job);
    }
    if path.is_dir() {
        if let Some(info) = info_of(path, job)? {
            return opened(info, path, (Content::Field, None), job);
        }
        return opened(Vec::new(), path, (Content::Capture, None), job);
    }
    let opened = recognise(read_file(path, is_known, job)?, path, job)?;
    match (opened.content, tile_set::beside(path, &opened.bytes)?) {
        (Content::Picture | Content::Field, tiles @ Some(_)) => {
            Ok(Opened { content: Content::Tiles, tiles, ..opened })
        }
        _ => Ok(opened),
    }
}

/// The description of a folder that is a texture.
fn info_of(folder: &Path, job: &Job) -> Result<Option<Vec<u8>>> {
    match web::info_of(folder, job)? {
        Some(info) => Ok(Some(info)),
        None => multires::info_of(folder, job),
    }
}

/// As [`open`], from a reader such as standard input. `name` identifies it in messages.
///
/// # Errors
/// As [`open`].
pub fn read(source: impl Read, name: impl AsRef<Path>, job: &Job) -> Result<Opened> {
    let bytes = read_bytes(source, 0, is_known, job).map_err(|e| e.at(&name))?;
    recognise(bytes, name.as_ref(), job)
}

fn recognise(bytes: Vec<u8>, name: &Path, job: &Job) -> Result<Opened> {
    let content = content(&bytes).map_err(|e| e.at(name))?;
    opened(bytes, name, content, job)
}

fn opened(
    bytes: Vec<u8>,
    name: &Path,
    (content, tiles): (Content, Option<Said>),
    job: &Job,
) -> Result<Opened> {
    let held = job.hold("the file", bytes.len() as u64).map_err(|e| e.at(name))?;
    Ok(Opened {
        name: name.to_path_buf(),
        bytes: Arc::new(bytes),
        _held: Arc::new(held),
        content,
        tiles,
        job: job.about(name),
    })
}

impl Opened {
    /// The content of the file.
    pub fn content(&self) -> Content {
        self.content
    }

    /// The name it was opened by.
    pub fn name(&self) -> &Path {
        &self.name
    }

    /// The number of bytes in the file.
    pub fn length(&self) -> u64 {
        self.bytes.len() as u64
    }

    /// The stamp of the file's bytes.
    pub fn stamp(&self) -> Stamp {
        Stamp::of(&self.bytes)
    }

    /// The texture: functions, or a picture as constant functions. An opacity is left out, with a remark of
    /// the job.
    ///
    /// # Errors
    /// The error names the file: one that holds no texture, is damaged or exceeds the limits.
    pub fn into_field(self) -> Result<FieldFile> {
        let job = self.job.clone();
        let file = self.field_of(Meaning::Colors)?;
        file.linear_remark().into_iter().for_each(|remark| job.remark(remark));
        if file.opacity.is_some() {
            job.remark(OPACITY_UNUSED);
        }
        Ok(FieldFile { opacity: None, ..file })
    }

    /// As [`Opened::into_field`], with the opacity, of a texture whose texels are copied.
    ///
    /// # Errors
    /// As [`Opened::into_field`].
    pub fn into_exemplar(self) -> Result<FieldFile> {
        let job = self.job.clone();
        let file = self.field_of(Meaning::Colors)?;
        file.comparison_remark().into_iter().for_each(|remark| job.remark(remark));
        Ok(file)
    }

    /// As [`Opened::into_exemplar`], of an image that is registered with an exemplar and may hold data: its
    /// values are those of the file, whatever space that names.
    ///
    /// # Errors
    /// As [`Opened::into_field`].
    pub fn into_registered(self) -> Result<FieldFile> {
        self.field_of(Meaning::Copies)
    }

    fn field_of(self, meaning: Meaning) -> Result<FieldFile> {
        let hint = match self.content {
            Content::Model => "; `relume synth MODEL -o FILE` makes one of it",
            Content::Capture if !self.name.is_dir() || holds_light_file(&self.name) => {
                "; `relume fit` makes one of it"
            }
            _ => "",
        };
        self.decoded("a texture", hint, |opened| match opened.name.is_dir() {
            true => field_file::decode_folder(&opened.name, &opened.job),
            false => field_file::decode_as(&opened.bytes, meaning, &opened.job),
        })
    }

    /// The set of tiles.
    ///
    /// # Errors
    /// As [`Opened::into_field`], for a file that holds no tiles, or others than declared.
    pub fn into_tiles(self) -> Result<TileSetFile> {
        let Some(tiles) = self.tiles else {
            return Err(self.refused("a set of tiles", "; `relume roll` makes one"));
        };
        let name = self.name.clone();
        TileSetFile::new(self.into_field()?, tiles).map_err(|e| e.at(name))
    }

    /// The random-field model.
    ///
    /// # Errors
    /// As [`Opened::into_field`], for a file that holds no model.
    pub fn into_model(self) -> Result<FieldModel> {
        if self.content != Content::Model {
            return Err(self.refused("a random-field model", "; `relume model` makes one"));
        }
        rlm::decode(&self.bytes, &self.job).map_err(|e| e.at(self.name))
    }

    /// The mesh: binary glTF, or OBJ.
    ///
    /// # Errors
    /// As [`Opened::into_field`], for a file that holds no mesh.
    pub fn into_mesh(self) -> Result<Mesh> {
        if !matches!(self.content, Content::Mesh | Content::Unknown) {
            return Err(self.refused("a mesh, .obj or .glb", ""));
        }
        decode_mesh(&self.bytes, &self.job).map_err(|e| e.at(self.name))
    }

    /// The texture of light and view of a `.btf` file. A file of images that is larger than memory is read by
    /// [`BonnBtf::open`].
    ///
    /// # Errors
    /// As [`Opened::into_field`], for a file that is not of this kind.
    pub fn into_btf(self) -> Result<BonnBtf> {
        if self.content != Content::Btf {
            return Err(self.refused("a texture of light and view, .btf", ""));
        }
        BonnBtf::decode(self.bytes, &self.job).map_err(|e| e.at(self.name))
    }

    /// The measured reflectance.
    ///
    /// # Errors
    /// As [`Opened::into_field`], for a file that holds no BRDF.
    pub fn into_brdf(self) -> Result<MeasuredBrdf> {
        if self.content != Content::Brdf {
            return Err(self.refused("a measured reflectance (BRDF)", ""));
        }
        decode_brdf(&self.bytes, &self.job).map_err(|e| e.at(self.name))
    }

    /// The array of numbers.
    ///
    /// # Errors
    /// As [`Opened::into_field`], for a file that holds no array.
    pub fn into_array(self) -> Result<Array> {
        if self.content != Content::Array {
            return Err(self.refused("a NumPy array", ""));
        }
        npy::decode_i32(&self.bytes, &self.job).map_err(|e| e.at(self.name))
    }

    /// The named channels of an EXR file, in alphabetical order.
    ///
    /// # Errors
    /// As [`Opened::into_field`], for a file that is not an EXR file.
    pub fn into_labelled(self) -> Result<(Vec<String>, Planes)> {
        if Kind::of(&self.bytes) != Some(Kind::Exr) {
            return Err(self.refused("an EXR file of named channels", ""));
        }
        exr::decode_labelled(&self.bytes, &self.job).map_err(|e| e.at(self.name))
    }

    /// The result of `decode` on a file of texels.
    fn decoded<T>(self, expected: &str, hint: &str, decode: impl Fn(&Self) -> Result<T>) -> Result<T> {
        match self.content {
            Content::Picture | Content::Field | Content::Tiles | Content::Heights => {
                decode(&self).map_err(|e| e.at(&self.name))
            }
            Content::Unknown if forms::is_description(&self.name) => {
                Err(forms::describes_nothing(&self.name).at(&self.name))
            }
            Content::Unknown => Err(unknown(&self.bytes).at(&self.name)),
            _ => Err(self.refused(expected, hint)),
        }
    }

    /// The error for a file with another content than needed.
    fn refused(&self, expected: &str, hint: &str) -> Error {
        if self.content == Content::Capture && self.name.is_dir() {
            if let Some(description) = forms::description_in(&self.name) {
                return forms::describes_nothing(&description).at(description);
            }
            let hint = if hint.is_empty() { forms::hint_of_folder(&self.name) } else { hint };
            return Error::usage(format!("this is a folder: expected {expected}{hint}")).at(&self.name);
        }
        if self.bytes.is_empty() {
            return Error::invalid(format!("the file is empty: expected {expected}")).at(&self.name);
        }
        if matches!(self.content, Content::Btf | Content::Brdf) {
            return of_light_and_view(self.content).at(&self.name);
        }
        Error::unsupported(format!("the file is {}: expected {expected}{hint}", self.content)).at(&self.name)
    }
}

/// Whether a folder holds the light file of a capture.
fn holds_light_file(folder: &Path) -> bool {
    let is_light_file = |path: &Path| path.extension().is_some_and(|e| e.eq_ignore_ascii_case("lp"));
    std::fs::read_dir(folder).into_iter().flatten().flatten().any(|entry| is_light_file(&entry.path()))
}

/// The texture in a file; see [`Opened::into_field`].
///
/// # Errors
/// As [`open`] and [`Opened::into_field`].
pub fn read_field(path: &Path, job: &Job) -> Result<FieldFile> {
    open(path, job)?.into_field()
}

/// The picture in a file; see [`Opened::into_raster`].
///
/// # Errors
/// As [`open`] and [`Opened::into_raster`].
pub fn read_raster(path: &Path, job: &Job) -> Result<Raster> {
    open(path, job)?.into_raster()
}

/// The height map in a file; see [`Opened::into_height`].
///
/// # Errors
/// As [`open`] and [`Opened::into_height`].
pub fn read_height(path: &Path, job: &Job) -> Result<HeightMap> {
    open(path, job)?.into_height()
}

/// The mesh in a file; see [`Opened::into_mesh`].
///
/// # Errors
/// As [`open`] and [`Opened::into_mesh`].
pub fn read_mesh(path: &Path, job: &Job) -> Result<Mesh> {
    open(path, job)?.into_mesh()
}
