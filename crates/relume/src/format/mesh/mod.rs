//! Meshes from files: Wavefront OBJ and binary glTF 2.0.
//!
//! Texture coordinates are converted to an origin at the bottom left, as in [`crate::render::mesh`]; OBJ has
//! it there, glTF at the top left. Missing normals are computed; texture coordinates are required, because
//! any choice of them would be a guess.

#[cfg(feature = "mesh")]
mod glb;
mod obj;
mod polygon;

use super::foreign;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::render::Mesh;

/// The mesh in the bytes of a file: binary glTF is recognised by its first bytes, anything else is read as
/// OBJ.
///
/// # Errors
/// A file that violates its format, has no triangles or no texture coordinates, or exceeds the limits.
pub fn decode_mesh(bytes: &[u8], job: &Job) -> Result<Mesh> {
    if bytes.starts_with(b"glTF") {
        return glb::decode(bytes, job);
    }
    match other_kind(bytes) {
        Some(kind) => Err(Error::unsupported(format!(
            "{kind} is not read: export the mesh as binary glTF (.glb) or OBJ"
        ))),
        None if bytes.contains(&0) => Err(Error::invalid(
            "the file is no mesh: it is neither binary glTF, which begins with the letters glTF, nor OBJ, which is text",
        )),
        None => obj::decode(bytes, job),
    }
}

/// What the file is, where it is certainly no OBJ.
fn other_kind(bytes: &[u8]) -> Option<&'static str> {
    const SIGNATURES: [(&[u8], &str); 9] = [
        (b"{", "text glTF (.gltf)"),
        (b"solid ", "STL"),
        (b"; FBX", "FBX"),
        (b"BLENDER", "a Blender file"),
        (b"PXR-USDC", "USD"),
        (b"#usda", "USD"),
        (b"PK\x03\x04", "an archive (zip, USDZ, 3MF)"),
        (b"<", "XML (COLLADA, X3D)"),
        (&[0xff, 0xfe], "UTF-16 text"),
    ];
    let start = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    let found =
        || SIGNATURES.iter().find(|(signature, _)| start.starts_with(signature)).map(|&(_, kind)| kind);
    found().or_else(|| foreign::of(start).map(|of| of.name))
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
struct MeshParts {
    positions: Vec<[f32; 3]>,
    /// As many as positions; zero where the file has none.
    normals: Vec<[f32; 3]>,
    texcoords: Vec<[f32; 2]>,
    triangles: Vec<[u32; 3]>,
}

impl MeshParts {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_kinds_of_meshes_are_named() {
        for (bytes, name) in [
            (
                &b"\n{\"asset\":{\"version\":\"2.0\"}}"[..],
                "text glTF (.gltf) is not read: export the mesh as binary glTF",
            ),
            (b"ply\nformat ascii 1.0\n", "a PLY mesh is not read"),
            (b"solid cube\n", "STL is not read"),
            (b"Kaydara FBX Binary  \0", "an FBX scene is not read"),
            (
                b"v 0 0 0\n\0\0",
                "neither binary glTF, which begins with the letters glTF, nor OBJ, which is text",
            ),
            (b"\xff\xfev\0", "UTF-16 text is not read"),
        ] {
            let error = decode_mesh(bytes, &Job::default()).unwrap_err().to_string();
            assert!(error.contains(name), "{error}");
        }
        let empty = decode_mesh(b"", &Job::default()).unwrap_err().to_string();
        assert!(empty.contains("neither binary glTF nor OBJ"), "{empty}");
    }
}
