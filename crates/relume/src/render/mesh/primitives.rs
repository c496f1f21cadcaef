//! Built-in objects, as grids over their two texture coordinates.

use std::f64::consts::{PI, TAU};

use super::super::vector::Vec3;
use super::Mesh;

/// An object that needs no file. All have a size of about one around the origin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Primitive {
    /// The unit sphere; s runs around the y axis eastwards, t from the south pole to the north.
    Sphere,
    /// A rectangle that faces +z, [-1, 1] along its longer side; it shows the texture as a picture does.
    Plane,
    /// A ring around the z axis with radii 0.7 and 0.3, tilted towards the viewer; s runs around the axis, t
    /// around the tube.
    Torus,
    /// A square of cloth in gentle folds, facing +z.
    Cloth,
}

/// Radii of the torus: of the ring and of the tube.
const TORUS_RADII: (f64, f64) = (0.7, 0.3);
/// The tilt of the torus about the x axis, so that the inside of the ring is visible.
const TORUS_TILT_RAD: f64 = -0.6;

impl Primitive {
    /// All members.
    pub const ALL: [Self; 4] = [Self::Sphere, Self::Plane, Self::Torus, Self::Cloth];

    /// The name used in options and messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sphere => "sphere",
            Self::Plane => "plane",
            Self::Torus => "torus",
            Self::Cloth => "cloth",
        }
    }

    /// The primitive of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|primitive| primitive.name() == name)
    }

    /// The default number of repetitions of the texture along s and t, for which texels are about square.
    pub fn default_tiling(self) -> [f64; 2] {
        match self {
            Self::Sphere => [4.0, 2.0],
            Self::Plane => [1.0, 1.0],
            Self::Torus => [6.0, 2.0],
            Self::Cloth => [2.0, 2.0],
        }
    }

    /// The triangles, for a square texture.
    pub fn mesh(self) -> Mesh {
        self.mesh_with_aspect(1.0)
    }

    /// The triangles. `aspect` is the width of what the texture coordinates span, as a multiple of its height:
    /// the proportions of a plane.
    pub fn mesh_with_aspect(self, aspect: f64) -> Mesh {
        match self {
            Self::Sphere => grid(192, 96, sphere, sphere),
            Self::Plane => {
                let (x, y) = (aspect.min(1.0), (1.0 / aspect).min(1.0));
                grid(
                    1,
                    1,
                    |s, t| Vec3::new((2.0 * s - 1.0) * x, (2.0 * t - 1.0) * y, 0.0),
                    |_, _| Vec3::new(0.0, 0.0, 1.0),
                )
            }
            Self::Torus => grid(192, 96, torus, torus_normal),
            Self::Cloth => grid(160, 160, cloth, cloth_normal),
        }
    }
}

/// A grid of `columns` x `rows` cells over (s, t) in 0..1, seams not shared.
fn grid(
    columns: u32,
    rows: u32,
    position: impl Fn(f64, f64) -> Vec3,
    normal: impl Fn(f64, f64) -> Vec3,
) -> Mesh {
    let places = (0..=rows).flat_map(|j| (0..=columns).map(move |i| (i, j)));
    let places: Vec<(f64, f64)> =
        places.map(|(i, j)| (f64::from(i) / f64::from(columns), f64::from(j) / f64::from(rows))).collect();
    let positions: Vec<[f32; 3]> = places.iter().map(|&(s, t)| position(s, t).into()).collect();
    let normals = places.iter().map(|&(s, t)| normal(s, t).into()).collect();
    let texcoords = places.iter().map(|&(s, t)| [s as f32, t as f32]).collect();
    let index = |i: u32, j: u32| j * (columns + 1) + i;
    let cells = (0..rows).flat_map(|j| (0..columns).map(move |i| (i, j)));
    let halves = cells.flat_map(|(i, j)| {
        let [a, b, c, d] = [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)];
        [[a, b, c], [a, c, d]]
    });
    // At the poles one half of each cell is a line.
    let apart = |a: u32, b: u32| {
        let [p, q] = [a, b].map(|i| Vec3::from(positions[i as usize]));
        (p - q).dot(p - q) > 1e-12
    };
    let triangles = halves.filter(|&[a, b, c]| apart(a, b) && apart(b, c) && apart(c, a)).collect();
    Mesh::new(positions, Some(normals), texcoords, triangles).expect("grids are whole")
}

fn sphere(s: f64, t: f64) -> Vec3 {
    // s = 1/2 faces the viewer.
    let (longitude, latitude) = (TAU * (s - 0.5), PI * (t - 0.5));
    Vec3::new(latitude.cos() * longitude.sin(), latitude.sin(), latitude.cos() * longitude.cos())
}

fn tipped(v: Vec3) -> Vec3 {
    let (sin, cos) = TORUS_TILT_RAD.sin_cos();
    Vec3::new(v.x, cos * v.y - sin * v.z, sin * v.y + cos * v.z)
}

fn torus(s: f64, t: f64) -> Vec3 {
    let (ring, tube) = TORUS_RADII;
    let (sin, cos) = (TAU * s).sin_cos();
    let center = tipped(Vec3::new(ring * cos, ring * sin, 0.0));
    center + torus_normal(s, t) * tube
}

fn torus_normal(s: f64, t: f64) -> Vec3 {
    let ((sin_s, cos_s), (sin_t, cos_t)) = ((TAU * s).sin_cos(), (TAU * t).sin_cos());
    tipped(Vec3::new(cos_t * cos_s, cos_t * sin_s, sin_t))
}

/// Height of the cloth over (x, y) and its slopes: a fold along a diagonal and a shallower one
/// across.
fn folds(x: f64, y: f64) -> (f64, f64, f64) {
    let (a, b) = (2.6 * x + 1.3 * y, 0.9 * x - 3.4 * y + 0.8);
    let height = 0.16 * a.sin() + 0.07 * b.sin();
    let (da, db) = (0.16 * a.cos(), 0.07 * b.cos());
    (height, 2.6 * da + 0.9 * db, 1.3 * da - 3.4 * db)
}

fn cloth(s: f64, t: f64) -> Vec3 {
    let (x, y) = (2.0 * s - 1.0, 2.0 * t - 1.0);
    Vec3::new(x, y, folds(x, y).0)
}

fn cloth_normal(s: f64, t: f64) -> Vec3 {
    let (_, dx, dy) = folds(2.0 * s - 1.0, 2.0 * t - 1.0);
    Vec3::new(-dx, -dy, 1.0).unit().expect("z is one")
}

#[cfg(test)]
mod tests {
    use super::super::super::vector::length;
    use super::*;

    #[test]
    fn triangles_face_outwards_as_their_normals_say() {
        for primitive in Primitive::ALL {
            let mesh = primitive.mesh();
            for &triangle in mesh.triangles() {
                let [a, b, c] = mesh.corners(triangle);
                let face = (b - a).cross(c - a).unit().unwrap();
                for i in triangle {
                    let normal = Vec3::from(mesh.normals()[i as usize]);
                    assert!((length(normal) - 1.0).abs() < 1e-6);
                    assert!(normal.dot(face) > 0.98, "{primitive:?}: {}", normal.dot(face));
                }
            }
        }
    }

    #[test]
    fn names_lead_back_and_sizes_are_about_one() {
        for primitive in Primitive::ALL {
            assert_eq!(Primitive::from_name(primitive.name()), Some(primitive));
            let (center, radius) = primitive.mesh().bounding_sphere();
            assert!(
                length(center) < 0.1 && (0.9..1.6).contains(&radius),
                "{primitive:?} {center:?} {radius}"
            );
        }
    }
}
