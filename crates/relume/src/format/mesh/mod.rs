//! Meshes from files: Wavefront OBJ and binary glTF 2.0.
//!
//! Texture coordinates are converted to an origin at the bottom left, as in [`crate::render::mesh`]; OBJ has
//! it there, glTF at the top left. Missing normals are computed; texture coordinates are required, because
//! any choice of them would be a guess.

#[cfg(feature = "mesh")]
mod glb;
mod obj;

use crate::error::{Error, Result};
use crate::job::Job;
use crate::render::Mesh;

/// The mesh in the bytes of a file: binary glTF is recognised by its first bytes, anything else is read as
/// OBJ.
///
/// # Errors
/// One that breaks its format, has no triangles or no texture coordinates, or exceeds the limits.
pub fn decode_mesh(bytes: &[u8], job: &Job) -> Result<Mesh> {
    if bytes.starts_with(b"glTF") { glb::decode(bytes, job) } else { obj::decode(bytes, job) }
}

/// The replacement for the reader of binary glTF in a build without it.
#[cfg(not(feature = "mesh"))]
mod glb {
    use super::{Error, Job, Mesh, Result};

    pub(super) fn decode(_bytes: &[u8], _job: &Job) -> Result<Mesh> {
        Err(Error::unsupported(
            "this build reads no binary glTF: use an OBJ file, or build with the feature 'mesh'",
        ))
    }
}

/// Vertices and triangles collected so far.
#[derive(Debug, Default)]
struct Parts {
    positions: Vec<[f32; 3]>,
    /// As many as positions; zero where the file has none.
    normals: Vec<[f32; 3]>,
    texcoords: Vec<[f32; 2]>,
    triangles: Vec<[u32; 3]>,
}

impl Parts {
    /// Refuses meshes beyond the limits or 32-bit indices.
    fn check(&self, job: &Job) -> Result<()> {
        let bytes = 32 * self.positions.len() as u64 + 12 * self.triangles.len() as u64;
        job.check_bytes("the mesh", bytes)?;
        if self.positions.len() > u32::MAX as usize {
            return Err(Error::limit("the mesh has more than 4,294,967,295 vertices"));
        }
        Ok(())
    }

    fn into_mesh(self) -> Result<Mesh> {
        Mesh::new(self.positions, Some(self.normals), self.texcoords, self.triangles)
    }
}
