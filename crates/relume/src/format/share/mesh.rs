//! Meshes as readers put them on a graphics card: vertices with normals and tangents.
//!
//! A gzip file of little-endian numbers: the numbers of vertices v and of triangles (32-bit integers); then floats: v positions
//! (x right, y up, z to the viewer), v normals, v tangents (along the s of texture coordinates, and the sign of the bitangent
//! relative to normal x tangent), v pairs of texture coordinates (origin at the bottom left); then three 32-bit indices for
//! each triangle, counter-clockwise.

use super::planes::compressed;
use crate::render::{Mesh, MeshVertices};

/// The file of a mesh.
pub fn encode(mesh: &Mesh) -> Vec<u8> {
    let made = MeshVertices::new(mesh);
    let counts = [made.positions.len() as u32, made.triangles.len() as u32];
    let mut bytes: Vec<u8> = counts.iter().flat_map(|n| n.to_le_bytes()).collect();
    let mut floats = |values: &[f32]| bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
    floats(made.positions.as_flattened());
    floats(made.normals.as_flattened());
    floats(made.tangents.as_flattened());
    floats(made.texcoords.as_flattened());
    bytes.extend(made.triangles.iter().flatten().flat_map(|i| i.to_le_bytes()));
    compressed(&bytes)
}
