//! The light of highlights: the environment blurred by the lobe of a roughness, times the share of light that the
//! surface reflects (B. Karis, Real Shading in Unreal Engine 4, SIGGRAPH courses 2013: the split sum).
//!
//! The blur is that of the lobe seen along its normal, so towards the horizon highlights are rounder than they should
//! be. Lobes narrower than the grid and the cells are blurred to about six degrees.

use std::f64::consts::PI;

use super::super::highlight::Specular;
use super::super::vector::Vec3;
use super::cells::LightCell;
use super::grid::{Covered, OctahedralGrid};
use crate::microfacet;
use crate::numeric::quadrature::integrate_hemisphere;
use crate::parallel;

/// Directions of reflection: three degrees apart.
const GRID: OctahedralGrid = OctahedralGrid::new(64, Covered::Sphere);
/// The narrowest lobe, as roughness: alpha 0.1.
const NARROWEST: f64 = 0.316;
/// Steps of the cosine between normal and viewer.
const COSINES: usize = 32;
/// Nodes of the integral over a lobe.
const NODES: usize = 96;

/// Blurred light for directions of reflection, and the share that is reflected.
#[derive(Debug)]
pub(super) struct ReflectionMap {
    light: Vec<[f32; 3]>,
    /// For cosines from 0 to 1 between normal and viewer.
    shares: Vec<f64>,
}

impl ReflectionMap {
    pub fn new(cells: &[LightCell], specular: &Specular) -> Self {
        let specular = Specular { roughness: specular.roughness.max(NARROWEST), ..*specular };
        let alpha = microfacet::alpha(specular.roughness);
        let whole = integrate_hemisphere(NODES, |light| lobe_weight(light.z(), alpha));
        let light =
            parallel::map(0..GRID.len(), |vertex| blurred(cells, GRID.direction(vertex), (alpha, whole)));
        let up = Vec3::new(0.0, 0.0, 1.0);
        let share = |i: usize| {
            let cosine = i as f64 / COSINES as f64;
            let viewer = Vec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
            integrate_hemisphere(NODES, |light| specular.lobe(up, light.into(), viewer)) / PI
        };
        Self { light, shares: parallel::map(0..=COSINES, share) }
    }

    /// The highlight of a normal seen by a viewer, both in world space.
    pub fn highlight(&self, normal: Vec3, to_viewer: Vec3) -> [f64; 3] {
        let cosine = normal.dot(to_viewer);
        if cosine <= 0.0 {
            return [0.0; 3];
        }
        let mirrored = normal * (2.0 * cosine) - to_viewer;
        let place = cosine.min(1.0) * COSINES as f64;
        let low = (place as usize).min(COSINES - 1);
        let share = self.shares[low] + (self.shares[low + 1] - self.shares[low]) * (place - low as f64);
        let mut sum = [0.0; 3];
        for (vertex, weight) in GRID.around(mirrored) {
            (0..3).for_each(|c| sum[c] += share * weight * f64::from(self.light[vertex][c]));
        }
        sum
    }
}

/// The mean radiance over the lobe around a direction; `whole` is the integral of the lobe.
fn blurred(cells: &[LightCell], direction: Vec3, (alpha, whole): (f64, f64)) -> [f32; 3] {
    let mut sum = [0.0; 3];
    for cell in cells {
        let cosine = cell.direction.dot(direction);
        if cosine <= 0.0 {
            continue;
        }
        let weight = lobe_weight(cosine, alpha) / whole;
        (0..3).for_each(|c| sum[c] += weight * cell.power[c]);
    }
    sum.map(|s| s as f32)
}

/// The lobe at a cosine from its axis, seen along the normal: half the angle lies between normal and half vector.
fn lobe_weight(cosine: f64, alpha: f64) -> f64 {
    microfacet::distribution((0.5 * (1.0 + cosine)).sqrt(), alpha) * cosine
}
