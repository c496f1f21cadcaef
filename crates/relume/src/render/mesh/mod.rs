//! Triangle meshes with normals and texture coordinates.
//!
//! World space is that of a texture seen from the front: x right, y up, z to the viewer. Texture coordinate
//! (0, 0) is the **bottom-left** corner of the texture and (1, 1) the top-right one, so s grows with the x of
//! the texture and t with its y (up); readers of files with another origin convert t. Coordinates outside
//! 0..1 repeat the texture.

mod primitives;
mod tangents;
mod vertices;

pub use primitives::Primitive;
pub(super) use tangents::Tangents;
pub use vertices::MeshVertices;

use super::vector::{Vec3, length};
use crate::error::{Error, Result};

/// Smaller objects are nothing that cameras can be placed around.
const LEAST_EXTENT: f64 = 1e-6;

/// Twice the area of the largest triangle of a mesh of extent 1 is at least this.
const LEAST_AREA: f64 = 1e-10;

/// Triangles over shared vertices. All vertex lists have the same length.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    texcoords: Vec<[f32; 2]>,
    triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// A mesh from its parts. Normals may have any length; one without a direction is replaced by that of the
    /// triangles around its vertex.
    ///
    /// # Errors
    /// When lists differ in length, there is no triangle, an index is out of range, a
    /// position or texture coordinate is not finite, all positions are one, or all triangles are lines.
    pub fn new(
        positions: Vec<[f32; 3]>,
        normals: Option<Vec<[f32; 3]>>,
        texcoords: Vec<[f32; 2]>,
        triangles: Vec<[u32; 3]>,
    ) -> Result<Self> {
        let count = positions.len();
        let given = normals.as_ref().map_or(count, Vec::len);
        if texcoords.len() != count || given != count {
            return Err(Error::invalid(format!(
                "a mesh of {count} vertices needs as many normals and texture coordinates, found {given} and {}",
                texcoords.len()
            )));
        }
        if triangles.is_empty() {
            return Err(Error::invalid("the mesh has no triangles"));
        }
        if let Some(i) = triangles.iter().flatten().find(|&&i| i as usize >= count) {
            return Err(Error::invalid(format!("a triangle refers to vertex {i}, but there are {count}")));
        }
        let finite = |v: &f32| v.is_finite() && v.abs() < 1e18;
        if !positions.iter().flatten().all(finite) || !texcoords.iter().flatten().all(finite) {
            return Err(Error::invalid(
                "a position or texture coordinate of the mesh is not a number below 1e18: export the mesh in other units",
            ));
        }
        if extent(&positions) < LEAST_EXTENT {
            return Err(Error::invalid(format!(
                "all points of the mesh lie within {LEAST_EXTENT:e} of one another: export the mesh in other units"
            )));
        }
        let area = |&triangle: &[u32; 3]| length(area_vector(&positions, triangle));
        if triangles.iter().map(area).fold(0.0, f64::max) < LEAST_AREA * extent(&positions).powi(2) {
            return Err(Error::invalid(
                "no triangle of the mesh has an area: all its corners lie on lines, and nothing of it would be seen",
            ));
        }
        let computed = smooth_normals(&positions, &triangles);
        let normals = match normals {
            Some(given) => given.into_iter().zip(computed).map(|(n, own)| unit_or(n, own)).collect(),
            None => computed,
        };
        Ok(Self { positions, normals, texcoords, triangles })
    }

    /// Vertex positions.
    pub fn positions(&self) -> &[[f32; 3]] {
        &self.positions
    }

    /// Unit vertex normals.
    pub fn normals(&self) -> &[[f32; 3]] {
        &self.normals
    }

    /// Vertex texture coordinates; see the module for their origin.
    pub fn texcoords(&self) -> &[[f32; 2]] {
        &self.texcoords
    }

    /// Three vertex indices per triangle, counter-clockwise seen from outside.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Centre and radius of a sphere around all vertices: that of the bounding box.
    pub fn bounding_sphere(&self) -> (Vec3, f64) {
        let (least, most) = bounding_box(&self.positions);
        let center = (least + most) * 0.5;
        let radius = self.positions.iter().map(|&p| length(Vec3::from(p) - center)).fold(0.0, f64::max);
        (center, radius.max(1e-9))
    }

    /// The corners of a triangle.
    pub(super) fn corners(&self, triangle: [u32; 3]) -> [Vec3; 3] {
        triangle.map(|i| Vec3::from(self.positions[i as usize]))
    }
}

/// The least and the greatest coordinates.
fn bounding_box(positions: &[[f32; 3]]) -> (Vec3, Vec3) {
    let (mut least, mut most) = (Vec3::splat(f64::INFINITY), Vec3::splat(f64::NEG_INFINITY));
    for p in positions.iter().map(|&p| Vec3::from(p)) {
        (least, most) = (least.min(p), most.max(p));
    }
    (least, most)
}

/// The longest side of the box around all positions.
fn extent(positions: &[[f32; 3]]) -> f64 {
    let (least, most) = bounding_box(positions);
    let sides = most - least;
    sides.x.max(sides.y).max(sides.z)
}

/// The normal of a triangle with twice its area as its length.
fn area_vector(positions: &[[f32; 3]], triangle: [u32; 3]) -> Vec3 {
    let [a, b, c] = triangle.map(|i| Vec3::from(positions[i as usize]));
    (b - a).cross(c - a)
}

/// Normals of vertices as the sum of the area vectors of their triangles.
fn smooth_normals(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<[f32; 3]> {
    let mut sums = vec![Vec3::splat(0.0); positions.len()];
    for triangle in triangles {
        let area = area_vector(positions, *triangle);
        triangle.iter().for_each(|&i| sums[i as usize] = sums[i as usize] + area);
    }
    sums.into_iter().map(|sum| unit_or(sum.into(), [0.0, 0.0, 1.0])).collect()
}

fn unit_or(vector: [f32; 3], fallback: [f32; 3]) -> [f32; 3] {
    let v = Vec3::from(vector);
    let size = length(v);
    if size.is_finite() && size > 1e-30 { (v * (1.0 / size)).into() } else { fallback }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meshes_that_do_not_hang_together_are_refused() {
        let p = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let t = vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        let new = |p: &[[f32; 3]], t: &[[f32; 2]], i: &[[u32; 3]]| {
            Mesh::new(p.to_vec(), None, t.to_vec(), i.to_vec())
        };
        assert_eq!(new(&p, &t, &[[0, 1, 2]]).unwrap().normals(), [[0.0, 0.0, 1.0]; 3]);
        assert!(new(&p, &t, &[]).is_err());
        assert!(new(&p, &t, &[[0, 1, 3]]).is_err());
        assert!(new(&p, &t[..2], &[[0, 1, 2]]).is_err());
        assert!(new(&[[f32::NAN, 0.0, 0.0]; 3], &t, &[[0, 1, 2]]).is_err());
        let tiny = p.iter().map(|p| p.map(|v| 1e-30 * v)).collect::<Vec<_>>();
        assert!(
            new(&tiny, &t, &[[0, 1, 2]]).unwrap_err().to_string().contains("export the mesh in other units")
        );
        let line = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
        assert!(new(&line, &t, &[[0, 1, 2]]).unwrap_err().to_string().contains("has an area"));
        let odd = Some(vec![[f32::NAN, 0.0, 0.0], [0.0; 3], [0.0, 0.0, 9.0]]);
        assert_eq!(Mesh::new(p, odd, t, vec![[0, 1, 2]]).unwrap().normals(), [[0.0, 0.0, 1.0]; 3]);
    }
}
