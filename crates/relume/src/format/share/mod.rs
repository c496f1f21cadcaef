//! The share format: a texture of functions as web pages and game engines load it.
//!
//! A header in JSON ([`ShareHeader`]) names files beside it: coefficient planes as PNG of 8 bits or compressed half floats
//! ([`planes`]), the functions of a basis without a closed form as a [table] over directions or at those [measured], and maps of what
//! a viewer shows beside the functions (normals, heights, albedo). Values are those of the field, rows from the top;
//! errors against the field are in the header. `docs/formats.md` has it byte by byte.
//!
//! The page of `relume view` and the package `relume-three` read it.

pub mod blocks;
mod boundaries;
pub mod environment;
mod header;
pub mod measured;
pub mod mesh;
pub mod noise;
pub mod planes;
pub mod pyramid;
pub mod table;

pub use header::{
    PlaneGroup, PlaneStorage, ShareBasis, ShareBlocks, ShareCells, ShareEnvironment, ShareHeader, ShareLevel,
    ShareMap, ShareMeasured, ShareNoise, SharePyramid, ShareShapes, ShareTable, TILED_VERSION, VERSION,
};
pub use measured::MeasuredTable;
pub use noise::NoiseParts;
pub use table::BasisTable;

use std::path::Path;

use crate::error::{Error, Result};
use crate::field::ReflectanceField;
use crate::format::{FieldFile, TileSetFile};
use crate::job::Job;
use crate::names::Named;
use crate::picture::Picture;
use crate::planes::Planes;
use crate::render::Environment;
use crate::size::Size;
use planes::{LinearCodes, PlaneDepth, SharedPlanes};
use pyramid::{TILED_TEXELS, TiledTexture};

/// The name of the header's file.
pub const HEADER_NAME: &str = "share.json";

/// Bases whose functions readers compute from formulas; all others come with a table.
pub const CLOSED_FORMS: [&str; 3] = ["constant", "ptm", "hsh9"];

/// The files of a shared texture.
#[derive(Debug, Clone)]
pub struct ShareFiles {
    /// The header; its bytes are [`ShareFiles::header_bytes`].
    pub header: ShareHeader,
    /// The files that it names: name and bytes.
    pub files: Vec<(String, Vec<u8>)>,
}

/// What is shared beside the functions.
#[derive(Debug, Default)]
pub struct ShareExtras<'a> {
    /// Shown as the page's title.
    pub title: String,
    /// Three planes of unit normals.
    pub normals: Option<&'a Planes>,
    /// One plane of heights in texels.
    pub height: Option<&'a Planes>,
    /// The texture without its shading.
    pub albedo: Option<&'a Picture>,
    /// The side of a texel in millimetres, where known.
    pub mm_per_texel: Option<f64>,
    /// The cells of a set of tiles that lie one below the other, and the number of tiles.
    pub tiles: Option<&'a TileSetFile>,
    /// Light from all around.
    pub environment: Option<&'a Environment>,
}

impl ShareFiles {
    /// The files of a texture.
    ///
    /// # Errors
    /// Channels that form no colour, memory, and a cancelled job.
    pub fn new(file: &FieldFile, extras: &ShareExtras, depth: PlaneDepth, job: &Job) -> Result<Self> {
        let field = &file.field;
        check_color(field)?;
        let tiled = extras.tiles.is_none() && field.size().texels() >= TILED_TEXELS;
        let (SharedPlanes { groups, mut files, error }, pyramid) = if tiled {
            let job = about_picture("the tiles", extras, job);
            let TiledTexture { pyramid, files, error } = TiledTexture::new(file, extras, depth, &job)?;
            (SharedPlanes { groups: Vec::new(), files, error }, Some(pyramid))
        } else {
            (SharedPlanes::new(field, &file.encoding, depth, job)?, None)
        };
        let basis = shared_basis(field, &mut files, job)?;
        let maps = if tiled { Vec::new() } else { shared_maps(extras, &mut files, job)? };
        let shapes = if tiled || extras.tiles.is_some() {
            boundaries::remark_linear(field, job);
            None
        } else {
            boundaries::shared(field, &mut files, job)?
        };
        let environment = extras.environment.map(|light| environment::shared(light, field, &mut files, job));
        let header = ShareHeader {
            version: if tiled { TILED_VERSION } else { VERSION },
            size: [field.size().width, field.size().height],
            planes: groups,
            error,
            maps,
            mm_per_texel: extras.mm_per_texel,
            cells: extras.tiles.map(ShareCells::of),
            environment: environment.transpose()?,
            shapes,
            pyramid,
            ..ShareHeader::empty(&extras.title, field, basis)
        };
        Ok(Self { header, files })
    }

    /// The header's bytes.
    pub fn header_bytes(&self) -> Vec<u8> {
        serde_json::to_vec_pretty(&self.header).expect("a header is text and finite numbers")
    }
}

impl ShareHeader {
    /// The header of a texture like a field, without texels.
    fn empty(title: &str, like: &ReflectanceField, basis: ShareBasis) -> Self {
        Self {
            relume: "share".to_owned(),
            version: VERSION,
            title: title.to_owned(),
            size: [0, 0],
            space: like.space().name().to_owned(),
            layout: like.layout().name().to_owned(),
            channels: like.layout().channels(),
            basis,
            planes: Vec::new(),
            error: 0.0,
            maps: Vec::new(),
            mm_per_texel: None,
            cells: None,
            noise: None,
            blocks: None,
            environment: None,
            shapes: None,
            pyramid: None,
        }
    }
}

/// Refuses channels that form no colour.
fn check_color(field: &ReflectanceField) -> Result<()> {
    if !field.layout().is_named() {
        return Ok(());
    }
    Err(Error::usage(format!(
        "a texture of the channels {} has no colour to show: choose red, green and blue, or one",
        field.layout().channel_names().join(", ")
    )))
}

fn shared_basis(
    field: &ReflectanceField,
    files: &mut Vec<(String, Vec<u8>)>,
    job: &Job,
) -> Result<ShareBasis> {
    let basis = field.basis();
    let (mut table, mut measured) = (None, None);
    if let Some(found) = MeasuredTable::new(basis, job)? {
        let names = ["basis.f16.gz", "corners.u16.gz"].map(str::to_owned);
        files.push((names[0].clone(), planes::compressed(&found.bytes())));
        files.push((names[1].clone(), planes::compressed(&found.corner_bytes())));
        measured = Some(found.described(names, basis));
    } else if !CLOSED_FORMS.contains(&basis.name()) {
        let found = BasisTable::new(basis, job)?;
        let name = "basis.f16.gz".to_owned();
        files.push((name.clone(), planes::compressed(&found.bytes())));
        table = Some(found.described(name, basis));
    }
    Ok(ShareBasis {
        name: basis.name().to_owned(),
        functions: basis.len(),
        channels: basis.channels(),
        depends_on_view: basis.depends_on_view(),
        lowest_light: basis.lowest_light_cosine(),
        table,
        measured,
    })
}

/// Normals and albedo as pictures of 8 bits, heights as half floats.
fn shared_maps(extras: &ShareExtras, files: &mut Vec<(String, Vec<u8>)>, job: &Job) -> Result<Vec<ShareMap>> {
    let mut maps = Vec::new();
    if let Some(normals) = extras.normals {
        let stored: Vec<f32> = normals.as_slice().iter().map(|v| v * 0.5 + 0.5).collect();
        let stored = Planes::from_vec(normals.size(), 3, stored)?;
        files.push(picture("normals.png", &stored, extras, job)?);
        maps.push(ShareMap::codes("normals", "normals.png", [2.0 / 255.0, -1.0]));
    }
    if let Some(height) = extras.height {
        let (low, high) = height.range(0);
        files.push(("height.f16.gz".to_owned(), planes::halves(height.plane(0))));
        maps.push(ShareMap::halves("height", "height.f16.gz", [low, high]));
    }
    if let Some(albedo) = extras.albedo {
        let encoded = albedo.to_space(crate::space::Space::Srgb);
        files.push(picture("albedo.png", &encoded.planes, extras, job)?);
        maps.push(ShareMap::codes("albedo", "albedo.png", [1.0 / 255.0, 0.0]));
    }
    Ok(maps)
}

/// A picture of the texture under its name.
fn picture(name: &str, planes: &Planes, extras: &ShareExtras, job: &Job) -> Result<(String, Vec<u8>)> {
    Ok((name.to_owned(), planes::encode_codes(planes, &about_picture(name, extras, job))?))
}

/// The job, whose remarks concern a picture of the texture, or several.
fn about_picture(name: &str, extras: &ShareExtras, job: &Job) -> Job {
    job.about(Path::new(&format!("{name} of {}", extras.title)))
}

/// The planes of all maps with the codes of 8 bits that hold them, and their roles.
fn map_planes(extras: &ShareExtras, size: Size) -> Result<(Planes, Vec<LinearCodes>, Vec<String>)> {
    let albedo = extras.albedo.map(|albedo| albedo.to_space(crate::space::Space::Srgb));
    let unit = |planes: &Planes, scale: f32, offset: f32| vec![LinearCodes { scale, offset }; planes.count()];
    let mut maps: Vec<(&str, &Planes, Vec<LinearCodes>)> = Vec::new();
    if let Some(normals) = extras.normals {
        maps.push(("normals", normals, unit(normals, 2.0 / 255.0, -1.0)));
    }
    if let Some(albedo) = &albedo {
        maps.push(("albedo", &albedo.planes, unit(&albedo.planes, 1.0 / 255.0, 0.0)));
    }
    if let Some(height) = extras.height {
        maps.push(("height", height, vec![LinearCodes::between(height.range(0))]));
    }
    let values: Vec<&[f32]> = maps.iter().map(|(_, planes, _)| planes.as_slice()).collect();
    let count = maps.iter().map(|(_, planes, _)| planes.count()).sum();
    let planes = Planes::from_vec(size, count, values.concat())?;
    let roles = maps.iter().map(|(role, ..)| (*role).to_owned()).collect();
    Ok((planes, maps.into_iter().flat_map(|(.., codes)| codes).collect(), roles))
}
