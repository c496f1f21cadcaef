//! Surface properties read off a field: normals and albedo.

pub mod argmax;
mod normals;

pub use normals::{albedo, normals};
