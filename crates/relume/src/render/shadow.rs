//! Shadows of the object on itself, by shadow maps.
//!
//! Williams, "Casting Curved Shadows on Curved Surfaces", SIGGRAPH 1978: the depth buffer seen from the light
//! determines what the light reaches. Comparisons, not depths, are averaged over neighbours
//! (percentage-closer filtering: Reeves, Salesin, Cook, SIGGRAPH 1987). Points are lifted along the normal of
//! the surface before they are compared, so that a surface does not shadow itself.

use super::mesh::Mesh;
use super::raster::{self, Setup};
use super::vector::Vec3;
use super::view::View;
use crate::parallel;

/// Samples along the side of a map.
const SIDE: usize = 2048;
/// Rows of a map filled by one task.
const BAND: usize = 64;
/// The lift of points along the normal, in samples of the map; the filter extends to 1.5.
const LIFT: f64 = 3.0;

/// The surfaces reached by one light.
#[derive(Debug)]
pub struct ShadowMap {
    view: View,
    /// Height of the nearest surface towards the light, row by row.
    heights: Vec<f32>,
}

impl ShadowMap {
    /// Bytes of one map.
    pub const BYTES: u64 = 4 * (SIDE * SIDE) as u64;

    /// The map of an object seen from a light.
    pub fn new(mesh: &Mesh, towards_light: Vec3) -> Self {
        let view = View::of_light(towards_light, mesh.bounding_sphere(), SIDE);
        let setups = Setup::all(mesh, &view);
        let bands = raster::by_band(&setups, &view, BAND);
        let mut heights = vec![0.0f32; SIDE * SIDE];
        let bands = heights.chunks_mut(BAND * SIDE).zip(&bands).enumerate();
        parallel::for_each(bands, |(b, (heights, chosen))| {
            let hits = raster::scan(&setups, chosen, &view, (b * BAND, (b + 1) * BAND));
            heights.iter_mut().zip(hits).for_each(|(height, hit)| *height = hit.nearness as f32);
        });
        Self { view, heights }
    }

    /// The share of the light that reaches a point with the given surface normal, on the side of the light.
    pub fn visibility(&self, point: Vec3, normal: Vec3) -> f64 {
        let lifted = point + normal * (LIFT * self.view.sample_step());
        let place = self.view.project(lifted);
        let height = self.view.height(lifted) as f32;
        let (x, y) = (place.x - 0.5, place.y - 0.5);
        let (left, top) = (x.floor(), y.floor());
        let (fx, fy) = (x - left, y - top);
        // A 3 x 3 box of bilinear comparisons: weights over 4 x 4 samples.
        let (across, down) = ([1.0 - fx, 1.0, 1.0, fx], [1.0 - fy, 1.0, 1.0, fy]);
        let mut lit = 0.0;
        for (j, wy) in down.into_iter().enumerate() {
            for (i, wx) in across.into_iter().enumerate() {
                let (column, line) = (left + i as f64 - 1.0, top + j as f64 - 1.0);
                lit += wx * wy * f64::from(u8::from(self.height_at(column, line) <= height));
            }
        }
        (lit / 9.0).min(1.0)
    }

    /// The height at a sample; nothing outside the map casts a shadow.
    fn height_at(&self, column: f64, line: f64) -> f32 {
        let inside = 0.0..SIDE as f64;
        if !inside.contains(&column) || !inside.contains(&line) {
            return f32::NEG_INFINITY;
        }
        self.heights[line as usize * SIDE + column as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::super::mesh::Primitive;
    use super::*;

    /// A small square above a large one.
    fn two_squares() -> Mesh {
        let square =
            |half: f32, z: f32| [[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]];
        let positions: Vec<[f32; 3]> = square(1.0, 0.0).into_iter().chain(square(0.3, 0.5)).collect();
        let texcoords = positions.iter().map(|p| [p[0], p[1]]).collect();
        Mesh::new(positions, None, texcoords, vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]).unwrap()
    }

    #[test]
    fn the_small_square_shades_the_large_one_where_the_light_says() {
        let up = Vec3::new(0.0, 0.0, 1.0);
        let towards = Vec3::new(1.0, 0.0, 1.0).unit().unwrap();
        let map = ShadowMap::new(&two_squares(), towards);
        // The shadow's centre is half a unit to the left.
        for (x, expected) in [(-0.5, 0.0), (-0.25, 0.0), (-0.75, 0.0), (-0.15, 1.0), (-0.85, 1.0), (0.5, 1.0)]
        {
            let found = map.visibility(Vec3::new(x, 0.1, 0.0), up);
            assert!((found - expected).abs() < 1e-9, "x = {x}: {found}");
        }
        assert!(map.visibility(Vec3::new(0.0, 0.0, 0.5), up) > 1.0 - 1e-9);
        let shares =
            (0..400).map(|i| map.visibility(Vec3::new(-0.2 + 1e-4 * f64::from(i - 200), 0.0, 0.0), up));
        assert!(shares.clone().any(|share| share > 0.2 && share < 0.8), "edges are soft");
    }

    #[test]
    fn a_sphere_does_not_shade_its_lit_side() {
        let mesh = Primitive::Sphere.mesh();
        let towards = Vec3::new(0.3, 0.5, 0.8).unit().unwrap();
        let map = ShadowMap::new(&mesh, towards);
        for &triangle in mesh.triangles().iter().step_by(17) {
            let [a, b, c] = mesh.corners(triangle);
            let center = (a + b + c) * (1.0 / 3.0);
            let normal = (b - a).cross(c - a).unit().unwrap();
            let cosine = normal.dot(towards);
            if cosine > 0.1 {
                assert!(map.visibility(center, normal) > 1.0 - 1e-9, "at cosine {cosine}");
            } else if cosine < -0.1 {
                assert_eq!(map.visibility(center, normal), 0.0, "at cosine {cosine}");
            }
        }
    }
}
