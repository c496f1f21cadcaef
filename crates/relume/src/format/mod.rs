//! Files: everything about encodings, quantisation and row orders.
//!
//! | file | read by | written by |
//! |---|---|---|
//! | `.ptm` | [`read_field`] | [`encode_field`] |
//! | EXR field | [`read_field`] | [`encode_field`] |
//! | PNG, JPEG, TIFF, EXR picture | [`read_raster`], [`read_field`] | [`encode_picture`], [`encode_field`] |
//! | height map, PNG or EXR | [`read_height`] | [`encode_height`] |
//! | animated PNG, GIF | | [`animation`] |
//! | `.ptm`, EXR field, PNG of any size | | [`Streamed`] |
//! | EXR with named channels | [`exr::decode_labelled`] | [`exr::encode_labelled`] |
//! | OBJ, binary glTF | [`read_mesh`] | |
//! | `.npy` | [`npy::decode_i32`] | [`npy::encode_i32`] |
//! | `.rlm` | [`rlm::decode`] | [`rlm::encode`] |
//!
//! Readers go by content, never by a file's name; writers are chosen by extension. Readers ask
//! their [`Job`](crate::Job) before they allocate. Writers return bytes: the caller decides where
//! they go. `docs/formats.md` has the layouts byte by byte.

pub mod animation;
mod codes;
mod complete;
pub mod exr;
mod field_file;
mod height;
mod input;
mod mesh;
pub mod npy;
mod picture;
mod png;
pub mod ptm;
mod raster;
pub mod rlm;
mod stream;

pub use exr::ExrDepth;
pub use field_file::{Encoding, FieldFile, FieldFormat, decode_field, encode_field, read_field};
pub use height::{
    HeightFormat, HeightMap, HeightScale, decode_height, decode_recorded_height, encode_height, read_height,
};
pub use mesh::{decode_mesh, read_mesh};
pub use picture::{Depth, PictureFormat, encode_picture};
pub use ptm::PtmEncoding;
pub use raster::{decode_raster, read_raster};
pub use stream::{Lane, Rows, Streamed};
