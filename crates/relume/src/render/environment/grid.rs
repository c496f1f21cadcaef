//! Directions on the vertices of a square grid, by the octahedral map: the sphere is projected on an octahedron, and its
//! lower half is unfolded around the upper one (E. Praun, H. Hoppe, Spherical Parametrization and Remeshing, SIGGRAPH
//! 2003). The upper hemisphere alone fills the square turned by 45 degrees.

use super::super::vector::Vec3;

/// What the square stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Covered {
    Sphere,
    UpperHemisphere,
}

/// A grid of `side` x `side` cells.
#[derive(Debug, Clone, Copy)]
pub(super) struct OctahedralGrid {
    side: usize,
    covered: Covered,
}

impl OctahedralGrid {
    pub const fn new(side: usize, covered: Covered) -> Self {
        Self { side, covered }
    }

    /// Cells along a side.
    pub const fn side(&self) -> usize {
        self.side
    }

    /// The number of vertices.
    pub const fn len(&self) -> usize {
        (self.side + 1) * (self.side + 1)
    }

    /// The direction of a vertex.
    pub fn direction(&self, vertex: usize) -> Vec3 {
        let place = |i: usize| 2.0 * i as f64 / self.side as f64 - 1.0;
        let (a, b) = (place(vertex % (self.side + 1)), place(vertex / (self.side + 1)));
        let (x, y) = match self.covered {
            Covered::Sphere => (a, b),
            Covered::UpperHemisphere => (0.5 * (a + b), 0.5 * (a - b)),
        };
        let z = 1.0 - x.abs() - y.abs();
        let folded = if z < 0.0 { ((1.0 - y.abs()) * sign(x), (1.0 - x.abs()) * sign(y)) } else { (x, y) };
        Vec3::new(folded.0, folded.1, z).unit().expect("the octahedron does not contain the origin")
    }

    /// The vertices around a unit vector with their bilinear weights.
    pub fn around(&self, direction: Vec3) -> [(usize, f64); 4] {
        let Vec3 { x, y, z } = direction;
        let sum = x.abs() + y.abs() + z.abs();
        let (x, y) = (x / sum, y / sum);
        let (a, b) = match self.covered {
            Covered::Sphere if z < 0.0 => ((1.0 - y.abs()) * sign(x), (1.0 - x.abs()) * sign(y)),
            Covered::Sphere => (x, y),
            Covered::UpperHemisphere => (x + y, x - y),
        };
        let cell = |t: f64| {
            let place = (0.5 * (t + 1.0) * self.side as f64).clamp(0.0, self.side as f64);
            let low = (place as usize).min(self.side - 1);
            (low, place - low as f64)
        };
        let ((column, right), (row, down)) = (cell(a), cell(b));
        let vertex = |i: usize, k: usize| (row + k) * (self.side + 1) + column + i;
        [
            (vertex(0, 0), (1.0 - right) * (1.0 - down)),
            (vertex(1, 0), right * (1.0 - down)),
            (vertex(0, 1), (1.0 - right) * down),
            (vertex(1, 1), right * down),
        ]
    }
}

/// 1 for zero, too.
fn sign(v: f64) -> f64 {
    if v < 0.0 { -1.0 } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::vector::length;

    #[test]
    fn vertices_are_found_where_they_are_and_directions_between_them() {
        for covered in [Covered::Sphere, Covered::UpperHemisphere] {
            let grid = OctahedralGrid::new(24, covered);
            for vertex in 0..grid.len() {
                let direction = grid.direction(vertex);
                let found = grid.around(direction);
                let here: f64 = found
                    .iter()
                    .filter(|(other, _)| length(grid.direction(*other) - direction) < 1e-6)
                    .map(|(_, weight)| weight)
                    .sum();
                assert!((here - 1.0).abs() < 1e-6, "{covered:?} {vertex}: {found:?}");
            }
            for i in 0..500 {
                let (t, a) = (f64::from(i) / 500.0, 2.4 * f64::from(i));
                let z = if covered == Covered::Sphere { 1.0 - 2.0 * t } else { t };
                let ring = (1.0 - z * z).sqrt();
                let direction = Vec3::new(ring * a.cos(), ring * a.sin(), z);
                let found = grid.around(direction);
                let sum = found.iter().fold(Vec3::splat(0.0), |s, (v, w)| s + grid.direction(*v) * *w);
                assert!(length(sum - direction) < 0.03, "{covered:?} {direction:?}: {sum:?}");
            }
        }
    }
}
