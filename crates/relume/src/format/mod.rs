//! File formats: everything about encodings, quantisation and row orders.
//!
//! [`open`] is the single entry point for reading: it reads a file once, recognises it by its content, and
//! returns an [`Opened`] that converts to what the caller needs.
//!
//! | file | turns into | written by |
//! |---|---|---|
//! | `.ptm` | [`Opened::into_field`] | [`encode_field`] |
//! | `.rti`, `.hsh` | [`Opened::into_field`] | [`encode_field`] |
//! | Relight web folder | [`Opened::into_field`] | [`web::encode_web`] |
//! | folder of the older web RTI viewer | [`Opened::into_field`] | [`web::encode_web`] |
//! | EXR field | [`Opened::into_field`] | [`encode_field`] |
//! | PNG, JPEG, TIFF, EXR, PFM, Radiance picture | [`Opened::into_raster`], [`Opened::into_field`], [`Opened::into_exemplar`] | [`encode_picture`], [`encode_field`] |
//! | pictures of data | [`Opened::into_data`], [`Opened::into_registered`], [`Opened::into_mask`] | |
//! | height map, PNG or EXR | [`Opened::into_height`] | [`encode_height`] |
//! | normal map | [`Opened::into_normals`] | [`encode_normals`] |
//! | set of tiles | [`Opened::into_tiles`] | [`exr::encode_tiles`], [`tile_set::sidecar`] |
//! | animated PNG, GIF | | [`animation`] |
//! | `.ptm`, EXR field, PNG of any size | | [`Streamed`] |
//! | EXR with named channels | [`Opened::into_labelled`] | [`exr::encode_labelled`] |
//! | zip of images named by their directions | | [`ZipArchive`], [`ubo2003`] |
//! | OBJ, binary glTF | [`Opened::into_mesh`] | |
//! | `.npy` | [`Opened::into_array`] | [`npy::encode_i32`] |
//! | `.npz`, `.npy` of coefficients | | [`encode_npz`], [`encode_npy`] |
//! | shared texture, for web pages | | [`share`] |
//! | `.rlm` | [`Opened::into_model`] | [`rlm::encode`] |
//! | `.btf` | [`Opened::into_btf`], [`bonn::BonnBtf::open`] | [`bonn::encode_fmf`], [`bonn::encode_dfmf`] |
//! | MERL `.binary`, UTIA `.bin`, RGL `.bsdf` | [`Opened::into_brdf`] | |
//!
//! Readers recognise files by content, never by name; writers are chosen by extension. Readers ask their
//! [`Job`](crate::Job) before they allocate. Writers return bytes: the caller decides where they go.
//! `docs/formats.md` has the layouts byte by byte.

pub mod animation;
mod archive;
pub mod bonn;
mod brdf;
mod codes;
mod color;
mod complete;
mod content;
mod data_map;
pub mod exr;
mod field_file;
mod finite;
mod folder;
mod footprint;
mod foreign;
mod glb;
mod height;
mod hsh;
mod jpeg;
mod jpeg_read;
mod jpeg_scan;
mod kind;
pub mod ktx2;
mod map_role;
mod mask;
mod meaning;
mod mesh;
mod multires;
mod normal_map;
pub mod npy;
mod npz;
mod opacity;
mod open;
mod outline;
mod pfm;
mod picture;
mod plausible;
mod png;
pub mod ptm;
mod quantise;
mod radiance;
mod raster;
pub mod rlm;
mod rows;
pub mod share;
mod stream;
mod supported;
mod texel_models;
mod tiff;
pub mod tile_set;
mod turned;
pub mod ubo2003;
pub mod web;
mod whole;
mod xml;
mod zip;

pub use archive::ImageArchive;
pub use brdf::decode_brdf;
pub use content::Content;
pub use data_map::encode_data_map;
pub use exr::ExrDepth;
pub use field_file::{
    Encoding, FieldFile, FieldFormat, MapRecord, decode_field, encode_field, encode_translucent,
};
pub use glb::{EXTENSION as GLB_EXTENSION, GlbMaterial, GlbPreview, encode_glb};
pub use height::{
    HeightFormat, HeightMap, HeightScale, TEXEL_MM, decode_height, encode_height, encode_height_with,
    encode_scaled_height,
};
pub use hsh::HshEncoding;
pub(crate) use jpeg::JPEG_QUALITY;
pub use kind::{of_light_and_view, set_ending};
pub use map_role::{MapRole, NormalY, PackedMap};
pub use mask::{Mask, decode_mask};
pub use mesh::decode_mesh;
pub use normal_map::{NormalMap, decode_normals, encode_normals, encode_stored_normals};
pub use npz::{encode_npy, encode_npz};
pub use open::{Opened, open, read, read_field, read_height, read_mesh, read_raster};
pub use outline::FileOutline;
pub use picture::{Depth, PictureFormat, encode_picture, encode_picture_with};
pub use ptm::PtmEncoding;
pub use raster::decode_raster;
pub use rows::Rows;
pub use stream::{Lane, Streamed};
pub use supported::{SUPPORTED, SupportedFormat};
pub use texel_models::TexelModels;
pub use tile_set::TileSetFile;
pub use zip::ZipArchive;
