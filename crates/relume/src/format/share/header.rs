//! The header of a shared texture.

use serde::{Deserialize, Serialize};

use crate::format::TileSetFile;
use crate::render::LampKind;

/// The version of the format; readers refuse others.
pub const VERSION: u32 = 1;
/// The version of textures in tiles.
pub const TILED_VERSION: u32 = 2;

/// Everything about a shared texture but its planes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ShareHeader {
    /// Always `share`: the mark of the format.
    pub relume: String,
    /// The version of the format.
    pub version: u32,
    /// A name for people.
    pub title: String,
    /// Width and height in texels.
    pub size: [usize; 2],
    /// The encoding of the function values: `linear`, or `srgb`.
    pub space: String,
    /// The arrangement of the planes: `luminance`, `rgb`, `lrgb` or `shared`.
    pub layout: String,
    /// The number of channels of a relit texel: 1 or 3.
    pub channels: usize,
    /// The functions.
    pub basis: ShareBasis,
    /// The planes in groups, in the order of the layout.
    pub planes: Vec<PlaneGroup>,
    /// The largest difference of a stored coefficient from that of the field.
    pub error: f32,
    /// Pictures of what is shown beside the functions.
    pub maps: Vec<ShareMap>,
    /// The side of a texel in millimetres, where known.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub mm_per_texel: Option<f64>,
    /// How tiles that lie one below the other cover a plane.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub cells: Option<ShareCells>,
    /// How noise is made from the planes, which are normal values instead of coefficients.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub noise: Option<ShareNoise>,
    /// How an endless plane is divided into files; there are no planes then.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub blocks: Option<ShareBlocks>,
    /// Light from all around, prepared for the functions.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub environment: Option<ShareEnvironment>,
    /// Boundaries of shadows and highlights that move between the lights.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub shapes: Option<ShareShapes>,
    /// Of a large texture: its planes and maps as tiles of several levels, instead of `planes` and `maps`.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub pyramid: Option<SharePyramid>,
}

/// A large texture as tiles ([`super::pyramid`]).
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct SharePyramid {
    /// The side of a tile without its border.
    pub side: usize,
    /// Texels of its neighbours on each side of a tile.
    pub border: usize,
    /// The maps whose planes follow those of the coefficients, in their order.
    pub maps: Vec<String>,
    /// The least and the greatest height, where there are heights.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub height_range: Option<[f32; 2]>,
    /// The finest first.
    pub levels: Vec<ShareLevel>,
}

/// A level of a large texture.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ShareLevel {
    /// Width and height in texels.
    pub size: [usize; 2],
    /// The arrangement of the planes of coefficients.
    pub layout: String,
    /// How the numbers of its tiles are stored.
    pub storage: PlaneStorage,
    /// The number of planes of coefficients.
    pub planes: usize,
    /// For codes: the difference between two of them, for each plane of coefficients and maps.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub scale: Vec<f32>,
    /// For codes: the value of code 0.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub offset: Vec<f32>,
}

/// The functions of a shared texture.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ShareBasis {
    /// Its name.
    pub name: String,
    /// The number of functions.
    pub functions: usize,
    /// The number of values of a function: 1, or one for each channel.
    pub channels: usize,
    /// Whether the functions differ between views.
    pub depends_on_view: bool,
    /// The cosine of the polar angle of the lowest lights, where functions are below them those of the nearest ones: from there on
    /// light fades out in proportion to the cosine.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub lowest_light: Option<f64>,
    /// Their values over directions, unless readers have formulas for the name, or they were measured on a grid.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub table: Option<ShareTable>,
    /// Their values at the directions of a grid.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub measured: Option<ShareMeasured>,
}

/// Functions measured for all of some lights with all of some views ([`super::measured`]).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ShareMeasured {
    /// The compressed half floats of the values.
    pub file: String,
    /// The compressed indices of the directions around each node of the maps of lights and views.
    pub corners: String,
    /// Nodes along a side of these maps.
    pub map_nodes: usize,
    /// The lights in the stereographic projection.
    pub lights: Vec<[f32; 2]>,
    /// The views.
    pub views: Vec<[f32; 2]>,
    /// As of a table.
    pub error_rms: f64,
    /// As of a table.
    pub error_max: f64,
}

/// A table of functions over lights and views ([`super::table`]).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ShareTable {
    /// The compressed half floats.
    pub file: String,
    /// Nodes along a side of the map of lights.
    pub light_nodes: usize,
    /// Nodes along a side of the map of views; 1 if they make no difference.
    pub view_nodes: usize,
    /// The root of the mean squared difference from the functions at directions spread evenly, over that of the functions.
    pub error_rms: f64,
    /// The largest difference there, over the root of the functions' mean square.
    pub error_max: f64,
}

/// Light from all around as lamps of each normal ([`super::environment`]).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ShareEnvironment {
    /// The compressed numbers.
    pub file: String,
    /// The number of lamps of a normal.
    pub nodes: usize,
    /// The number of moments from which their light follows.
    pub functions: usize,
    /// In which frame the lamps are: in that of a normal, from which they are turned, or in that of the texture, into which the
    /// moments are turned; there they may be the measured lights of the basis.
    #[serde(default)]
    pub lamps: LampKind,
    /// Normals along a side of the grid of each half of the sphere.
    pub side: usize,
    /// By which the halves of the moments are multiplied.
    pub scale: f32,
}

/// Boundaries that move between the lights ; pairs are of shadows and of highlights.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ShareShapes {
    /// The compressed numbers.
    pub file: String,
    /// The shares of the corrections that are made.
    pub strengths: [f32; 2],
    /// Codes for a distance of one texel.
    pub steps: [f32; 2],
    /// The largest contrasts.
    pub most: [f32; 2],
    /// Half the width of a boundary in texels.
    pub softness: f32,
}

/// How numbers are stored in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PlaneStorage {
    /// PNG of 8 bits, grey or red, green and blue: value = scale x code + offset.
    Png,
    /// Half floats, little-endian, plane after plane, compressed (RFC 1952, gzip): value = the half.
    Half,
}

/// One to three consecutive planes in a file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlaneGroup {
    /// Its file.
    pub file: String,
    /// How the numbers are stored.
    pub storage: PlaneStorage,
    /// The first plane.
    pub first: usize,
    /// The number of planes.
    pub count: usize,
    /// For codes: the difference between two of them, a number for each plane.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub scale: Vec<f32>,
    /// For codes: the value of code 0, a number for each plane.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub offset: Vec<f32>,
}

/// A map of what is shown beside the functions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ShareMap {
    /// `normals` (x right, y up, z to the viewer), `height` (in texels) or `albedo` (sRGB).
    pub role: String,
    /// Its file.
    pub file: String,
    /// How the numbers are stored.
    pub storage: PlaneStorage,
    /// For codes: the difference between two of them.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub scale: Option<f32>,
    /// For codes: the value of code 0.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub offset: Option<f32>,
    /// The least and the greatest value.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub range: Option<[f32; 2]>,
}

impl ShareMap {
    pub(super) fn codes(role: &str, file: &str, [scale, offset]: [f32; 2]) -> Self {
        let (scale, offset) = (Some(scale), Some(offset));
        Self { role: role.into(), file: file.into(), storage: PlaneStorage::Png, scale, offset, range: None }
    }

    pub(super) fn halves(role: &str, file: &str, range: [f32; 2]) -> Self {
        let (scale, offset) = (None, None);
        Self {
            role: role.into(),
            file: file.into(),
            storage: PlaneStorage::Half,
            scale,
            offset,
            range: Some(range),
        }
    }
}

/// How tiles cover a plane without end: `numeric::cells` of the library.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ShareCells {
    /// The number of tiles, one below the other in the planes.
    pub tiles: usize,
    /// The step to the cell on the right, in texels: x right, y *down*.
    pub right: [i64; 2],
    /// The step to the cell below.
    pub down: [i64; 2],
    /// The corner of a tile's rectangle relative to its cell.
    pub origin: [i64; 2],
    /// The number of colours of corners; 1 if any tile fits anywhere.
    pub corners: usize,
}

/// By-example noise: [`crate::synthesis::noise`] of the library.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ShareNoise {
    /// The number of planes of normal values.
    pub planes: usize,
    /// The side of a triangle in texels.
    pub side: f64,
    /// The key under which the vertices are hashed, the low half first.
    pub key: [u32; 2],
    /// The largest normal value of a table.
    pub reach: f32,
    /// The entries of a table.
    pub entries: usize,
    /// The file of the tables: compressed floats, a table for each plane.
    pub tables: String,
    /// The file of the coefficients of the mean and of each plane: compressed floats.
    pub functions: String,
}

/// An endless plane in files of squares of texels, made as they are asked for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ShareBlocks {
    /// The side of a square in texels.
    pub side: usize,
}

impl ShareCells {
    pub(super) fn of(set: &TileSetFile) -> Self {
        let cells = &set.cells;
        Self {
            tiles: set.count,
            right: cells.right(),
            down: cells.down(),
            origin: cells.origin(),
            corners: set.corners.count(),
        }
    }
}
