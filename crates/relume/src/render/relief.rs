//! The height map of a texture on an object: bump and displacement.
//!
//! *Bump* (J. F. Blinn, Simulation of wrinkled surfaces, SIGGRAPH 1978) tilts the frame of the light look-up
//! by the slopes of the height map and leaves the shape unchanged. *Displacement* (R. L. Cook, Shade trees,
//! SIGGRAPH 1984) moves the surface itself along its normal: the mesh is subdivided to about one vertex per
//! texel, so outlines, cast shadows and occlusion change too.
//!
//! Functions measured on a relief contain its shading already: displacement alone does not tilt their frame.
//! A conventional texture ([`super::Shading::Plain`]) contains none, and is shaded with the slopes of its
//! displacement. Heights are in texels; the size of a texel on the object is the root of the area of the
//! object divided by that of its texture, the same everywhere.

use super::mesh::Mesh;
use super::mip_map::MipMap;
use super::vector::{Vec3, length};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::planes::Planes;
use crate::size::Size;

/// The most triangles after subdivision.
const MOST_TRIANGLES: usize = 2_000_000;
/// The memory of a triangle: its set-up for the picture and for a shadow map, vertices, indices.
pub(super) const TRIANGLE_BYTES: u64 = 512;

/// A height map and its use.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshRelief {
    /// One plane with the proportions of the texture: heights in texels above the surface of the object.
    pub height: Planes,
    /// The factor by which the surface is displaced; 0 for none.
    pub displacement: f64,
    /// The factor of the slopes by which frames are tilted; 0 for none.
    pub bump: f64,
}

impl MeshRelief {
    /// Checks the heights and both factors.
    ///
    /// # Errors
    /// When there is not exactly one plane of finite heights, or a factor is out of range.
    pub fn validate(&self) -> Result<()> {
        if self.height.count() != 1 || !self.height.as_slice().iter().all(|h| h.is_finite() && h.abs() < 1e6)
        {
            return Err(Error::invalid("a relief is one plane of finite heights below a million texels"));
        }
        for (name, factor) in [("displacement", self.displacement), ("bump", self.bump)] {
            if !(-1e4..=1e4).contains(&factor) {
                return Err(Error::usage(format!("the {name} factor is {factor}: expected -10000 to 10000")));
            }
        }
        Ok(())
    }

    /// Heights and their slopes dh/dx, dh/dy (y up), prepared for look-ups; the texture repeats.
    pub(super) fn lookups(&self, job: &Job) -> Result<MipMap> {
        let size @ Size { width, height } = self.height.size();
        let mut planes = Planes::zeros_within(job, "the relief", size, 3)?;
        planes.plane_mut(0).copy_from_slice(self.height.plane(0));
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let at = |x: usize, y: usize| self.height.at(0, x % width, y % height);
            let (texel, left, up) = (size.index(x, y), x + width - 1, y + height - 1);
            planes.plane_mut(1)[texel] = 0.5 * (at(x + 1, y) - at(left, y));
            planes.plane_mut(2)[texel] = 0.5 * (at(x, up) - at(x, y + 1));
        }
        MipMap::of_planes("the pyramid of the relief", &planes, job)
    }
}

/// A mesh with every triangle divided into `per_side`^2 equal ones.
#[derive(Debug)]
pub(super) struct Subdivided {
    /// The small triangles, those of one triangle together and in the order of `pattern`.
    pub mesh: Mesh,
    /// For each small triangle the barycentric coordinates of its corners in the large one.
    pub pattern: Vec<[[f64; 3]; 3]>,
}

impl Subdivided {
    /// The large triangle of a small one, and the position in it of a point of the small one.
    pub fn origin(&self, triangle: u32, barycentric: [f64; 3]) -> (usize, [f64; 3]) {
        let corners = &self.pattern[triangle as usize % self.pattern.len()];
        let place = |k: usize| (0..3).map(|c| corners[c][k] * barycentric[c]).sum();
        (triangle as usize / self.pattern.len(), std::array::from_fn(place))
    }
}

/// The mesh moved along its normals by the relief, repeated `tiling` times.
pub(super) fn displaced(
    mesh: &Mesh,
    relief: &MeshRelief,
    heights: &MipMap,
    tiling: [f64; 2],
    job: &Job,
) -> Result<Subdivided> {
    let size = relief.height.size();
    let texels = [tiling[0] * size.width as f64, tiling[1] * size.height as f64];
    let longest = edges(mesh).map(|(_, s, t)| (s * texels[0]).hypot(t * texels[1])).fold(0.0, f64::max);
    let most = ((MOST_TRIANGLES / mesh.triangles().len()) as f64).sqrt().floor().max(1.0);
    let per_side = longest.ceil().clamp(1.0, most) as usize;
    let count = mesh.triangles().len() as u64 * (per_side * per_side) as u64;
    job.check_bytes("the displaced mesh", count * TRIANGLE_BYTES)?;
    let lift = Lift {
        heights,
        tiling,
        footprint: longest / per_side as f64,
        scale: relief.displacement * texel_size(mesh, texels),
    };
    subdivide(mesh, per_side, &lift)
}

/// Edges as length in space and extent along s and t.
fn edges(mesh: &Mesh) -> impl Iterator<Item = (f64, f64, f64)> + '_ {
    mesh.triangles()
        .iter()
        .flat_map(|triangle| [(0, 1), (1, 2), (2, 0)].map(|(a, b)| (triangle[a], triangle[b])))
        .map(|(a, b)| {
            let [p, q] = [a, b].map(|i| Vec3::from(mesh.positions()[i as usize]));
            let [s, t] = [a, b].map(|i| mesh.texcoords()[i as usize].map(f64::from));
            (length(p - q), s[0] - t[0], s[1] - t[1])
        })
}

/// The size of a texel on the object.
fn texel_size(mesh: &Mesh, texels: [f64; 2]) -> f64 {
    let (mut area, mut texture) = (0.0, 0.0);
    for &triangle in mesh.triangles() {
        let [a, b, c] = mesh.corners(triangle);
        area += length((b - a).cross(c - a));
        let [a, b, c] = triangle.map(|i| mesh.texcoords()[i as usize].map(f64::from));
        texture += ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs();
    }
    let texture = texture * texels[0] * texels[1];
    if texture > 0.0 { (area / texture).sqrt() } else { 0.0 }
}

/// The lift of positions of the texture.
struct Lift<'a> {
    heights: &'a MipMap,
    tiling: [f64; 2],
    /// Texels between neighbouring vertices.
    footprint: f64,
    /// Units of space per texel of height.
    scale: f64,
}

impl Lift<'_> {
    fn at(&self, texcoord: [f64; 2]) -> f64 {
        let mut values = Vec::new();
        let place = [texcoord[0] * self.tiling[0], texcoord[1] * self.tiling[1]];
        self.heights.fetch(place, self.footprint, &mut values);
        self.scale * f64::from(values[0])
    }

    /// The lift of each vertex. Vertices at the same position, at the poles and seams of a mesh, share the
    /// mean, so that the surface does not tear there.
    fn of_vertices(&self, mesh: &Mesh) -> Vec<f64> {
        let key = |p: &[f32; 3]| p.map(|c| (f64::from(c) * 1e5).round() as i64);
        let mut shared = std::collections::HashMap::new();
        for (position, texcoord) in mesh.positions().iter().zip(mesh.texcoords()) {
            let (sum, count) = shared.entry(key(position)).or_insert((0.0, 0.0));
            *sum += self.at(texcoord.map(f64::from));
            *count += 1.0;
        }
        let mean = |position: &[f32; 3]| {
            let (sum, count) = shared[&key(position)];
            sum / count
        };
        mesh.positions().iter().map(mean).collect()
    }
}

/// Divides each triangle and lifts the vertices. Neighbours compute their common vertices from the same two
/// products in either order, so they agree to the bit.
fn subdivide(mesh: &Mesh, per_side: usize, lift: &Lift) -> Result<Subdivided> {
    let n = per_side as f64;
    let grid: Vec<[f64; 3]> = (0..=per_side)
        .flat_map(|j| (0..=per_side - j).map(move |i| [(per_side - i - j) as f64, i as f64, j as f64]))
        .collect();
    let index = |i: usize, j: usize| j * (per_side + 1) - j * (j.max(1) - 1) / 2 + i;
    let up = (0..per_side)
        .flat_map(|j| (0..per_side - j).map(move |i| [index(i, j), index(i + 1, j), index(i, j + 1)]));
    let down = (0..per_side.saturating_sub(1)).flat_map(|j| {
        (0..per_side - j - 1).map(move |i| [index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)])
    });
    let cells: Vec<[usize; 3]> = up.chain(down).collect();

    let corner_lifts = lift.of_vertices(mesh);
    let count = mesh.triangles().len() * grid.len();
    let (mut positions, mut normals) = (Vec::with_capacity(count), Vec::with_capacity(count));
    let (mut texcoords, mut triangles) = (Vec::with_capacity(count), Vec::new());
    for corners in mesh.triangles() {
        let first = positions.len() as u32;
        triangles.extend(cells.iter().map(|cell| cell.map(|v| first + v as u32)));
        for weights in &grid {
            let mix3 = |list: &[[f32; 3]]| blended(corners.map(|i| list[i as usize]), weights, n);
            let texcoord = blended(corners.map(|i| mesh.texcoords()[i as usize]), weights, n);
            let [x, y, z] = mix3(mesh.normals());
            let normal = Vec3::new(x, y, z).unit().unwrap_or(Vec3::new(0.0, 0.0, 1.0));
            let up = match weights.iter().position(|w| *w == n) {
                Some(corner) => corner_lifts[corners[corner] as usize],
                None => lift.at(texcoord),
            };
            let [x, y, z] = mix3(mesh.positions());
            positions.push((Vec3::new(x, y, z) + normal * up).into());
            normals.push(normal.into());
            texcoords.push(texcoord.map(|c| c as f32));
        }
    }
    let pattern = cells.iter().map(|cell| cell.map(|v| grid[v].map(|w| w / n))).collect();
    Ok(Subdivided { mesh: Mesh::new(positions, Some(normals), texcoords, triangles)?, pattern })
}

/// The weighted mean of three corners; weights add up to `n`.
fn blended<const N: usize>(corners: [[f32; N]; 3], weights: &[f64; 3], n: f64) -> [f64; N] {
    std::array::from_fn(|k| (0..3).map(|c| f64::from(corners[c][k]) * weights[c]).sum::<f64>() / n)
}

#[cfg(test)]
mod tests {
    use super::super::mesh::Primitive;
    use super::*;
    use crate::limits::Limits;

    fn relief(size: Size, height: impl Fn(usize, usize) -> f32) -> MeshRelief {
        let data = (0..size.texels()).map(|i| height(i % size.width, i / size.width)).collect();
        MeshRelief { height: Planes::from_vec(size, 1, data).unwrap(), displacement: 1.0, bump: 0.0 }
    }

    fn displace(mesh: &Mesh, relief: &MeshRelief, tiling: [f64; 2]) -> Subdivided {
        let heights = relief.lookups(&Job::default()).unwrap();
        displaced(mesh, relief, &heights, tiling, &Job::default()).unwrap()
    }

    #[test]
    fn a_level_relief_makes_a_larger_sphere_without_gaps() {
        let flat = relief(Size::new(8, 8), |_, _| 2.0);
        let sphere = Primitive::Sphere.mesh();
        let moved = displace(&sphere, &flat, [4.0, 2.0]);
        // The texture has 32 x 16 texels on an area of almost 4 pi.
        let size = (4.0 * std::f64::consts::PI / 512.0f64).sqrt();
        for p in moved.mesh.positions() {
            let radius = length(Vec3::from(*p));
            assert!((radius - 1.0 - 2.0 * size).abs() < 2e-3, "{radius} {size}");
        }
    }

    #[test]
    fn the_plane_takes_the_shape_of_the_relief() {
        let bumps = relief(Size::new(16, 16), |x, y| ((x * 5 + y * 3) % 7) as f32);
        let moved = displace(&Primitive::Plane.mesh(), &bumps, [1.0, 1.0]);
        let texel = 2.0 / 16.0;
        let mut found = 0;
        for (p, t) in moved.mesh.positions().iter().zip(moved.mesh.texcoords()) {
            assert!((p[0] - (2.0 * t[0] - 1.0)).abs() < 1e-6 && p[2] >= -1e-6 && p[2] <= 6.0 * texel + 1e-6);
            found += usize::from(p[2] > 5.0 * texel);
        }
        assert!(found > 5, "{found} vertices near the top");
    }

    #[test]
    fn neighbouring_triangles_meet_in_the_same_bits() {
        let bumps = relief(Size::new(32, 32), |x, y| ((x * 7 + y * 11) % 13) as f32 / 3.0);
        for primitive in [Primitive::Sphere, Primitive::Torus, Primitive::Cloth] {
            let moved = displace(&primitive.mesh(), &bumps, primitive.default_tiling());
            let key = |i: u32| moved.mesh.positions()[i as usize].map(|c| (c * 1e6).round() as i64);
            let mut sides = std::collections::HashMap::new();
            for t in moved.mesh.triangles() {
                for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                    *sides.entry((key(a).min(key(b)), key(a).max(key(b)))).or_insert(0) += 1;
                }
            }
            let open = sides.values().filter(|&&n| n == 1).count();
            // The cloth ends at its four sides; the others are closed.
            let allowed = if primitive == Primitive::Cloth { sides.len() / 100 } else { 0 };
            assert!(open <= allowed, "{primitive:?}: {open} of {}", sides.len());
        }
    }

    #[test]
    fn small_triangles_know_where_they_are_in_the_large_one() {
        let bumps = relief(Size::new(9, 9), |_, _| 0.0);
        let cloth = Primitive::Cloth.mesh();
        let moved = displace(&cloth, &bumps, [40.0, 40.0]);
        assert!(moved.pattern.len() > 1);
        for (i, &triangle) in moved.mesh.triangles().iter().enumerate().step_by(37) {
            let (large, place) = moved.origin(i as u32, [0.2, 0.5, 0.3]);
            let corners = cloth.corners(cloth.triangles()[large]);
            let expected = corners[0] * place[0] + corners[1] * place[1] + corners[2] * place[2];
            let own = moved.mesh.corners(triangle);
            let found = own[0] * 0.2 + own[1] * 0.5 + own[2] * 0.3;
            assert!(length(found - expected) < 1e-6, "triangle {i}");
        }
    }

    #[test]
    fn what_is_no_relief_is_refused() {
        let good = relief(Size::new(3, 2), |x, _| x as f32);
        assert!(good.validate().is_ok());
        assert!(MeshRelief { bump: f64::NAN, ..good.clone() }.validate().is_err());
        assert!(MeshRelief { height: Planes::zeros(Size::new(2, 2), 3), ..good.clone() }.validate().is_err());
        assert!(relief(Size::new(2, 2), |_, _| f32::INFINITY).validate().is_err());
        let tight = Job::new(Limits { max_bytes: 5000, ..Limits::default() });
        let heights = good.lookups(&tight).unwrap();
        assert!(displaced(&Primitive::Plane.mesh(), &good, &heights, [9.0, 9.0], &tight).is_err());
    }
}
