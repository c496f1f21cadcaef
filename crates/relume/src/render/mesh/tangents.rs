//! Tangent frames that follow the texture over a mesh.
//!
//! The dP/ds and dP/dt of each triangle follow from its corners (Lengyel, "Computing Tangent Space Basis
//! Vectors for an Arbitrary Mesh", 2001). Vertices average dP/ds over their triangles, weighted by the angle
//! of the corner, separately for triangles that show the texture unmirrored and for those that mirror it, as
//! in MikkTSpace (Mikkelsen, "Simulation of Wrinkled Surfaces Revisited", 2008), so that mirrored halves with
//! shared vertices do not cancel.

use super::super::vector::Vec3;
use super::Mesh;

/// Whether a triangle shows the texture unmirrored or mirrored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in super::super) enum Handedness {
    Plain,
    Mirrored,
}

impl Handedness {
    /// The sign of the bitangent relative to normal x tangent.
    pub(in super::super) fn sign(self) -> f64 {
        match self {
            Self::Plain => 1.0,
            Self::Mirrored => -1.0,
        }
    }
}

/// The tangents of a mesh.
#[derive(Debug)]
pub(in super::super) struct Tangents {
    /// For each vertex, the tangent in unmirrored and in mirrored triangles; zero where there is none.
    vertices: Vec<[Vec3; 2]>,
    triangles: Vec<Handedness>,
}

impl Tangents {
    pub(in super::super) fn new(mesh: &Mesh) -> Self {
        let mut vertices = vec![[Vec3::splat(0.0); 2]; mesh.positions().len()];
        let mut triangles = Vec::with_capacity(mesh.triangles().len());
        for &triangle in mesh.triangles() {
            let (tangent, handedness) = triangle_tangent(mesh, triangle);
            triangles.push(handedness);
            let corners = mesh.corners(triangle);
            for (k, &vertex) in triangle.iter().enumerate() {
                let normal = Vec3::from(mesh.normals()[vertex as usize]);
                let flat = (tangent - normal * normal.dot(tangent)).unit();
                let sum = &mut vertices[vertex as usize][handedness as usize];
                *sum = *sum + flat.unwrap_or(Vec3::splat(0.0)) * corner_angle_rad(corners, k);
            }
        }
        Self { vertices, triangles }
    }

    /// The tangents at the corners of a triangle, and its handedness.
    pub(in super::super) fn of_triangle(&self, index: usize, corners: [u32; 3]) -> ([Vec3; 3], Handedness) {
        let handedness = self.triangles[index];
        (corners.map(|i| self.vertices[i as usize][handedness as usize]), handedness)
    }
}

impl Mesh {
    /// The mesh with a tangent for each vertex: the unit vector across the normal in which the first texture coordinate
    /// grows, and the sign of the direction in which the second one grows, relative to normal x tangent. Vertices that
    /// unmirrored and mirrored triangles share are doubled. Where the texture has no direction, any tangent will do.
    pub fn with_tangents(&self) -> (Self, Vec<[f32; 4]>) {
        let found = Tangents::new(self);
        let mut mesh = self.clone();
        let mut tangents = vec![None; self.positions.len()];
        let mut doubled = std::collections::BTreeMap::new();
        for (triangle, &handedness) in mesh.triangles.iter_mut().zip(&found.triangles) {
            for vertex in triangle {
                let at = *vertex as usize;
                match tangents[at] {
                    None => tangents[at] = Some(handedness),
                    Some(other) if other == handedness => {}
                    Some(_) => {
                        *vertex = *doubled.entry(at).or_insert_with(|| {
                            mesh.positions.push(self.positions[at]);
                            mesh.normals.push(self.normals[at]);
                            mesh.texcoords.push(self.texcoords[at]);
                            mesh.positions.len() as u32 - 1
                        });
                    }
                }
            }
        }
        let mut of = vec![(0, Handedness::Plain); mesh.positions.len()];
        for (at, handedness) in tangents.iter().enumerate() {
            of[at] = (at, handedness.unwrap_or(Handedness::Plain));
        }
        for (&at, &copy) in &doubled {
            let other = if of[at].1 == Handedness::Plain { Handedness::Mirrored } else { Handedness::Plain };
            of[copy as usize] = (at, other);
        }
        let tangent = |(at, handedness): (usize, Handedness)| {
            let unit = across(found.vertices[at][handedness as usize], Vec3::from(self.normals[at]));
            let [x, y, z] = <[f32; 3]>::from(unit);
            [x, y, z, handedness.sign() as f32]
        };
        (mesh, of.into_iter().map(tangent).collect())
    }
}

/// The unit vector of `direction` across a normal, or any where it has none.
fn across(direction: Vec3, normal: Vec3) -> Vec3 {
    (direction - normal * normal.dot(direction)).unit().unwrap_or_else(|| normal.any_perpendicular())
}

/// dP/ds of a triangle, of any length; zero where the texture coordinates span no area.
fn triangle_tangent(mesh: &Mesh, triangle: [u32; 3]) -> (Vec3, Handedness) {
    let [a, b, c] = mesh.corners(triangle);
    let [ta, tb, tc] = triangle.map(|i| mesh.texcoords()[i as usize].map(f64::from));
    let (s1, t1) = (tb[0] - ta[0], tb[1] - ta[1]);
    let (s2, t2) = (tc[0] - ta[0], tc[1] - ta[1]);
    let area = s1 * t2 - s2 * t1;
    if area == 0.0 {
        return (Vec3::splat(0.0), Handedness::Plain);
    }
    let tangent = ((b - a) * t2 - (c - a) * t1) * area.signum();
    (tangent, if area > 0.0 { Handedness::Plain } else { Handedness::Mirrored })
}

fn corner_angle_rad(corners: [Vec3; 3], k: usize) -> f64 {
    let side = |other: usize| (corners[other % 3] - corners[k]).unit();
    match (side(k + 1), side(k + 2)) {
        (Some(a), Some(b)) => a.dot(b).clamp(-1.0, 1.0).acos(),
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::super::Primitive;
    use super::*;

    #[test]
    fn primitives_have_tangents_along_s_that_match_finite_differences() {
        for primitive in Primitive::ALL {
            let mesh = primitive.mesh();
            let tangents = Tangents::new(&mesh);
            for (index, &triangle) in mesh.triangles().iter().enumerate().step_by(7) {
                let (found, handedness) = tangents.of_triangle(index, triangle);
                assert_eq!(handedness, Handedness::Plain, "{primitive:?} shows the texture unmirrored");
                let truth = triangle_tangent(&mesh, triangle).0.unit().unwrap();
                let mean = (found[0] + found[1] + found[2]).unit().unwrap();
                assert!(mean.dot(truth) > 0.99, "{primitive:?}, triangle {index}");
            }
        }
    }

    #[test]
    fn mirrored_halves_that_share_vertices_keep_their_tangents() {
        // Two squares left and right of x = 0, s growing away from the middle on both sides.
        let positions = vec![
            [-1.0, 0.0, 0.0],
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [-1.0, 1.0, 0.0],
            [0.0, 1.0, 0.0],
            [1.0, 1.0, 0.0],
        ];
        let texcoords = positions.iter().map(|p: &[f32; 3]| [p[0].abs(), p[1]]).collect();
        let triangles = vec![[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]];
        let mesh = Mesh::new(positions, None, texcoords, triangles.clone()).unwrap();
        let tangents = Tangents::new(&mesh);
        for (index, triangle) in triangles.into_iter().enumerate() {
            let (found, handedness) = tangents.of_triangle(index, triangle);
            let (x, expected) =
                if index < 2 { (-1.0, Handedness::Mirrored) } else { (1.0, Handedness::Plain) };
            assert_eq!(handedness, expected);
            assert!(found.iter().all(|t| t.unit().unwrap().dot(Vec3::new(x, 0.0, 0.0)) > 0.999_999));
        }
    }
}
