//! Meshes as graphics cards draw them: one list of vertices with everything that is interpolated.

use std::collections::HashMap;

use super::Mesh;
use super::tangents::{Handedness, Tangents};

/// Vertices and triangles. A vertex between triangles that show the texture unmirrored and mirrored appears twice, since
/// its tangents differ ([`Mesh`] keeps them apart while it is rendered).
#[derive(Debug, Clone, PartialEq)]
pub struct MeshVertices {
    /// In world space.
    pub positions: Vec<[f32; 3]>,
    /// Of unit length.
    pub normals: Vec<[f32; 3]>,
    /// The sum of dP/ds around the vertex, of any length, and the sign of the bitangent relative to normal x tangent.
    pub tangents: Vec<[f32; 4]>,
    /// With their origin at the bottom left.
    pub texcoords: Vec<[f32; 2]>,
    /// Three vertices each.
    pub triangles: Vec<[u32; 3]>,
}

impl MeshVertices {
    /// The vertices of a mesh, in the order in which its triangles name them.
    pub fn new(mesh: &Mesh) -> Self {
        let tangents = Tangents::new(mesh);
        let mut made = Self {
            positions: Vec::new(),
            normals: Vec::new(),
            tangents: Vec::new(),
            texcoords: Vec::new(),
            triangles: Vec::with_capacity(mesh.triangles().len()),
        };
        let mut known = HashMap::new();
        for (index, &triangle) in mesh.triangles().iter().enumerate() {
            let (along, handedness) = tangents.of_triangle(index, triangle);
            made.triangles.push(std::array::from_fn(|k| {
                let vertex = triangle[k];
                *known.entry((vertex, handedness == Handedness::Mirrored)).or_insert_with(|| {
                    let at = vertex as usize;
                    let [x, y, z] = [along[k].x, along[k].y, along[k].z].map(|v| v as f32);
                    made.positions.push(mesh.positions()[at]);
                    made.normals.push(mesh.normals()[at]);
                    made.texcoords.push(mesh.texcoords()[at]);
                    made.tangents.push([x, y, z, handedness.sign() as f32]);
                    made.positions.len() as u32 - 1
                })
            }));
        }
        made
    }
}

#[cfg(test)]
mod tests {
    use super::super::Primitive;
    use super::*;

    #[test]
    fn vertices_of_primitives_stay_and_those_of_mirrored_seams_are_doubled() {
        for primitive in Primitive::ALL {
            let mesh = primitive.mesh();
            let made = MeshVertices::new(&mesh);
            for (found, truth) in made.triangles.iter().zip(mesh.triangles()) {
                for (a, b) in found.iter().zip(truth) {
                    assert_eq!(made.positions[*a as usize], mesh.positions()[*b as usize]);
                    assert_eq!(made.texcoords[*a as usize], mesh.texcoords()[*b as usize]);
                }
            }
            assert!(made.tangents.iter().all(|t| t[3] == 1.0), "{primitive:?}");
            assert!(made.positions.len() <= mesh.positions().len());
        }
        // A square on either side of x = 0, with s growing away from it.
        let positions = [-1.0, 0.0, 1.0].map(|x| [[x, 0.0, 0.0], [x, 1.0, 0.0]]).concat();
        let texcoords = positions.iter().map(|p: &[f32; 3]| [p[0].abs(), p[1]]).collect();
        let triangles = vec![[0, 2, 3], [0, 3, 1], [2, 4, 5], [2, 5, 3]];
        let mesh = Mesh::new(positions, None, texcoords, triangles).unwrap();
        let made = MeshVertices::new(&mesh);
        assert_eq!(made.positions.len(), 8);
        for (position, tangent) in made.positions.iter().zip(&made.tangents) {
            assert!(tangent[0] * tangent[3] > 0.0, "{position:?}: {tangent:?}");
        }
    }
}
