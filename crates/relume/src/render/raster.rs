//! Visibility at each sample, by a depth buffer.
//!
//! Triangles are set up in homogeneous coordinates (Olano, Greer, "Triangle Scan Conversion using 2D
//! Homogeneous Coordinates", Graphics Hardware 1997): with (x w, y w, w) of the corners as the columns of M,
//! a = M^-1 (x, y, 1) are the barycentric coordinates divided by the depth w. They interpolate with correct
//! perspective, need no clipping at the plane of the eye, and are independent of the orientation of the
//! triangle: both sides are visible. A sample on an edge belongs to both neighbours; the nearer triangle
//! wins, and of equally near ones the first in the mesh.

use super::mesh::Mesh;
use super::vector::Vec3;
use super::view::{View, ViewProjection};
use crate::parallel;

/// Barycentric coordinates down to this far below zero count as inside, so that rounding leaves no gaps
/// between neighbours.
const EDGE_TOLERANCE: f64 = 1e-9;
/// The relative volume below which a triangle is seen edge-on and invisible.
const FLAT: f64 = 1e-14;
/// Triangles that one thread sets up together.
const TOGETHER: usize = 1 << 12;

/// A triangle prepared for scan conversion.
#[derive(Debug, Clone)]
pub struct Setup {
    /// Its number in the mesh.
    pub triangle: u32,
    /// The rows of M^-1.
    rows: [Vec3; 3],
    /// Nearness as a function of (x, y, 1): 1 / w for a camera, the height for a light.
    nearness: Vec3,
    /// The samples it may touch: first and one past the last.
    columns: (usize, usize),
    lines: (usize, usize),
}

/// The visible triangle at a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Larger is nearer.
    pub nearness: f64,
    /// The index in the list of set-up triangles, or that of [`Hit::NOTHING`].
    pub setup: u32,
}

impl Hit {
    /// No triangle.
    pub const NOTHING: Self = Self { nearness: f64::NEG_INFINITY, setup: u32::MAX };
}

impl Setup {
    /// The set-up of every potentially visible triangle, in the order of the mesh.
    pub fn all(mesh: &Mesh, view: &View) -> Vec<Self> {
        let parts = mesh.triangles().chunks(TOGETHER).enumerate();
        let of_parts = parallel::map(parts, |(part, triangles)| {
            let each = (part * TOGETHER..).zip(triangles);
            each.filter_map(|(i, &t)| Self::new(i as u32, mesh.corners(t), view)).collect::<Vec<_>>()
        });
        of_parts.into_iter().flatten().collect()
    }

    fn new(triangle: u32, corners: [Vec3; 3], view: &View) -> Option<Self> {
        let [a, b, c] = corners.map(|p| view.project(p));
        let volume = a.dot(b.cross(c));
        let scale = [a, b, c].iter().map(|v| v.dot(*v).sqrt()).product::<f64>();
        if !volume.is_finite() || volume.abs() <= FLAT * scale {
            return None;
        }
        let (columns, lines) = bounds([a, b, c], view)?;
        let rows = [b.cross(c), c.cross(a), a.cross(b)].map(|row| row * (1.0 / volume));
        let nearness = match view.projection() {
            ViewProjection::Perspective { .. } => rows[0] + rows[1] + rows[2],
            ViewProjection::Parallel => {
                let heights = corners.map(|p| view.height(p));
                rows[0] * heights[0] + rows[1] * heights[1] + rows[2] * heights[2]
            }
        };
        Some(Self { triangle, rows, nearness, columns, lines })
    }

    /// Barycentric coordinates of the point of the plane seen at (x, y), which may lie outside the triangle;
    /// `None` where the plane is not in front of the viewer.
    pub fn barycentric(&self, x: f64, y: f64) -> Option<[f64; 3]> {
        let a = self.rows.map(|row| row.dot(Vec3::new(x, y, 1.0)));
        let sum = a[0] + a[1] + a[2];
        (sum > 0.0).then(|| a.map(|v| v / sum))
    }

    /// Whether the triangle covers (x, y), and how near it is there.
    fn nearness_at(&self, x: f64, y: f64, most: f64) -> Option<f64> {
        let place = Vec3::new(x, y, 1.0);
        let a = self.rows.map(|row| row.dot(place));
        let least = -EDGE_TOLERANCE * (a[0] + a[1] + a[2]);
        if !(least <= 0.0 && a[0] >= least && a[1] >= least && a[2] >= least) {
            return None;
        }
        let nearness = self.nearness.dot(place);
        (nearness <= most).then_some(nearness)
    }
}

/// The samples around a projected triangle; all of them if it extends behind the eye.
fn bounds(corners: [Vec3; 3], view: &View) -> Option<((usize, usize), (usize, usize))> {
    let size = view.size();
    let near = match view.projection() {
        ViewProjection::Perspective { near } => near,
        ViewProjection::Parallel => 0.0,
    };
    if corners.iter().all(|c| c.z < near) {
        return None;
    }
    if corners.iter().any(|c| c.z < near) {
        return Some(((0, size.width), (0, size.height)));
    }
    let range = |values: [f64; 3], end: usize| {
        let least = values.iter().fold(f64::INFINITY, |m, v| m.min(*v));
        let most = values.iter().fold(f64::NEG_INFINITY, |m, v| m.max(*v));
        // Casts saturate, so anything off the picture gives an empty range.
        let range = ((least - 0.5).floor() as usize, ((most + 0.5).ceil().max(0.0) as usize).min(end));
        (range.0 < range.1).then_some(range)
    };
    Some((range(corners.map(|c| c.x / c.z), size.width)?, range(corners.map(|c| c.y / c.z), size.height)?))
}

/// For each band of `band` lines, the set-up triangles that may touch it, in order.
pub fn by_band(setups: &[Setup], view: &View, band: usize) -> Vec<Vec<u32>> {
    let mut bands = vec![Vec::new(); view.size().height.div_ceil(band)];
    for (index, setup) in setups.iter().enumerate() {
        let (first, end) = setup.lines;
        bands[first / band..end.div_ceil(band)].iter_mut().for_each(|list| list.push(index as u32));
    }
    bands
}

/// The visible triangles of `chosen` at the samples of `lines` (first and one past the last), row by row.
pub fn scan(setups: &[Setup], chosen: &[u32], view: &View, lines: (usize, usize)) -> Vec<Hit> {
    let width = view.size().width;
    let mut hits = vec![Hit::NOTHING; width * (lines.1 - lines.0)];
    let most = match view.projection() {
        ViewProjection::Perspective { near } => 1.0 / near,
        ViewProjection::Parallel => f64::INFINITY,
    };
    for &index in chosen {
        let setup = &setups[index as usize];
        for line in setup.lines.0.max(lines.0)..setup.lines.1.min(lines.1) {
            let row = &mut hits[(line - lines.0) * width..][..width];
            let (first, end) = setup.columns;
            for (column, hit) in (first..end).zip(&mut row[first..end]) {
                let nearness = setup.nearness_at(column as f64 + 0.5, line as f64 + 0.5, most);
                if let Some(nearness) = nearness.filter(|&found| found > hit.nearness) {
                    *hit = Hit { nearness, setup: index };
                }
            }
        }
    }
    hits
}

#[cfg(test)]
mod tests {
    use super::super::mesh::Primitive;
    use super::super::scene::Camera;
    use super::super::vector::length;
    use super::*;
    use crate::size::Size;

    const SIZE: Size = Size::new(64, 48);

    fn all(setups: &[Setup]) -> Vec<u32> {
        (0..setups.len() as u32).collect()
    }

    fn camera(distance_radii: f64) -> Camera {
        Camera { azimuth_rad: 0.7, elevation_rad: 0.4, distance_radii, ..Camera::default() }
    }

    /// The eye and the ray through a sample, from the angles of the camera alone.
    fn ray(camera: &Camera, radius: f64, x: f64, y: f64) -> (Vec3, Vec3) {
        let (az, el) = (camera.azimuth_rad, camera.elevation_rad);
        let back = Vec3::new(az.sin() * el.cos(), el.sin(), az.cos() * el.cos());
        let right = Vec3::new(az.cos(), 0.0, -az.sin());
        let up = back.cross(right);
        let half = (0.5 * camera.field_of_view_rad).tan();
        let across = (x - 0.5 * SIZE.width as f64) / (0.5 * SIZE.height as f64) * half;
        let upwards = (0.5 * SIZE.height as f64 - y) / (0.5 * SIZE.height as f64) * half;
        (back * (camera.distance_radii * radius), right * across + up * upwards - back)
    }

    #[test]
    fn texture_coordinates_are_those_where_the_ray_meets_the_plane() {
        let mesh = Primitive::Plane.mesh();
        // At close range, so that the plane extends behind the eye and perspective is strong.
        for (distance, least_hits) in [(4.0, 300), (0.35, 1500)] {
            let camera = camera(distance);
            let radius = mesh.bounding_sphere().1;
            let view = View::of_camera(&camera, mesh.bounding_sphere(), SIZE);
            let setups = Setup::all(&mesh, &view);
            let hits = scan(&setups, &all(&setups), &view, (0, SIZE.height));
            let mut count = 0;
            for (i, hit) in hits.iter().enumerate() {
                let (x, y) = ((i % SIZE.width) as f64 + 0.5, (i / SIZE.width) as f64 + 0.5);
                let (eye, along) = ray(&camera, radius, x, y);
                let steps = -eye.z / along.z;
                let place = eye + along * steps;
                let inside = steps > 0.0 && place.x.abs().max(place.y.abs()) < 1.0;
                if place.x.abs().max(place.y.abs()) - 1.0 < -1e-6 || *hit != Hit::NOTHING {
                    assert_eq!(inside, *hit != Hit::NOTHING, "sample ({x}, {y})");
                }
                if *hit == Hit::NOTHING {
                    continue;
                }
                count += 1;
                let setup = &setups[hit.setup as usize];
                let barycentric = setup.barycentric(x, y).unwrap();
                let corners = mesh.triangles()[setup.triangle as usize].map(|i| mesh.texcoords()[i as usize]);
                for (k, expected) in [0.5 * (place.x + 1.0), 0.5 * (place.y + 1.0)].into_iter().enumerate() {
                    let found: f64 = (0..3).map(|c| f64::from(corners[c][k]) * barycentric[c]).sum();
                    assert!(
                        (found - expected).abs() < 1e-9,
                        "sample ({x}, {y}): {found} instead of {expected}"
                    );
                }
                assert!((1.0 / hit.nearness - steps).abs() < 1e-9 * steps);
            }
            assert!(count > least_hits, "{count} samples at distance {distance}");
        }
    }

    #[test]
    fn spheres_have_no_gaps_and_normals_that_point_outwards() {
        let mesh = Primitive::Sphere.mesh();
        let camera = camera(6.0);
        let view = View::of_camera(&camera, mesh.bounding_sphere(), SIZE);
        let setups = Setup::all(&mesh, &view);
        for (i, hit) in scan(&setups, &all(&setups), &view, (0, SIZE.height)).iter().enumerate() {
            let (x, y) = ((i % SIZE.width) as f64 + 0.5, (i / SIZE.width) as f64 + 0.5);
            let (eye, along) = ray(&camera, mesh.bounding_sphere().1, x, y);
            let nearest = length(eye.cross(along)) / length(along);
            if nearest > 1.0 {
                assert_eq!(*hit, Hit::NOTHING);
                continue;
            }
            // The mesh lies inside the sphere by up to 1 - cos(pi / 192 + pi / 192).
            if nearest > 0.999 {
                continue;
            }
            let setup = &setups[hit.setup as usize];
            let weights = setup.barycentric(x, y).unwrap();
            let triangle = mesh.triangles()[setup.triangle as usize];
            let mix = |v: &[[f32; 3]]| {
                let [a, b, c] = triangle.map(|i| Vec3::from(v[i as usize]));
                (a * weights[0] + b * weights[1] + c * weights[2]).unit().unwrap()
            };
            let normal = mix(mesh.normals());
            assert!(normal.dot(mix(mesh.positions())) > 0.999_999);
            assert!(normal.dot(along) < 0.05, "the near side is seen");
        }
    }

    #[test]
    fn bands_give_what_the_whole_gives() {
        let mesh = Primitive::Torus.mesh();
        let view = View::of_camera(&camera(5.0), mesh.bounding_sphere(), SIZE);
        let setups = Setup::all(&mesh, &view);
        let whole = scan(&setups, &all(&setups), &view, (0, SIZE.height));
        let bands: Vec<Hit> = [(0, 7), (7, 8), (8, 48)]
            .into_iter()
            .flat_map(|lines| scan(&setups, &all(&setups), &view, lines))
            .collect();
        assert_eq!(whole, bands);
        for band in [1, 7, 48, 100] {
            let lists = by_band(&setups, &view, band).into_iter().enumerate();
            let lines = |b: usize| (b * band, ((b + 1) * band).min(SIZE.height));
            let binned: Vec<Hit> =
                lists.flat_map(|(b, list)| scan(&setups, &list, &view, lines(b))).collect();
            assert_eq!(whole, binned);
        }
    }
}
