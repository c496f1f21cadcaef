//! Gradient noise in space, cut by the plane of the picture: textures "carved out of" a block of solid
//! material (K. Perlin, An image synthesizer, SIGGRAPH 1985; the noise itself as in Improving noise, SIGGRAPH
//! 2002, with unit gradients).
//!
//! Coordinates are those of the picture and a depth behind it. Depth is counted in feature sizes, positive
//! towards the viewer. On the torus the noise closes along both sides of the picture, and along the depth if
//! a period is given, after a whole number of cells and therefore exactly.
//!
//! Octave i is n(2^i x, 2^i y, 2^i z) on its own lattice. On a common lattice the finer octaves would repeat
//! 2^i times within a tile, and all would vanish together at its corner.

use super::noise::{Canvas, NoiseLattice, fade, lerp};

/// A block of solid material and the position of the picture in it.
#[derive(Debug, Clone, Copy)]
pub struct SolidBlock {
    /// The lattices of the picture.
    pub canvas: Canvas,
    /// The unit of depth, in texels.
    pub feature: f64,
    /// Depth of the plane of the picture, in feature sizes.
    pub depth: f64,
    /// Feature sizes after which the solid repeats along the depth.
    pub depth_period: Option<u32>,
}

/// A lattice of cells in space over the texels.
#[derive(Debug, Clone, Copy)]
pub struct SolidLattice {
    plane: NoiseLattice,
    depth: f64,
    depth_period: Option<i64>,
}

/// Octaves i = `first`, `first` + 1, ... of solid noise, octave i of weight 2^-i.
#[derive(Debug, Clone)]
pub struct SolidFractal {
    octaves: Vec<(f64, SolidLattice)>,
}

impl SolidBlock {
    /// A lattice of cells of about `cell` texels along x, y and the depth.
    pub fn lattice(&self, cell: [f64; 3], layer: u64) -> SolidLattice {
        let plane = self.canvas.stretched_lattice([cell[0], cell[1]], layer);
        let cells = |features: f64| features * self.feature / cell[2];
        match self.depth_period {
            Some(period) => {
                let whole = cells(f64::from(period)).round().max(1.0);
                let depth = self.depth / f64::from(period) * whole;
                SolidLattice { plane, depth, depth_period: Some(whole as i64) }
            }
            None => SolidLattice { plane, depth: cells(self.depth), depth_period: None },
        }
    }

    /// The octaves from `first` to `last` over cells of about `cell` texels.
    pub fn fractal(&self, cell: [f64; 3], (first, last): (u32, u32), layer: u64) -> SolidFractal {
        let base = self.lattice(cell, layer);
        let octave = |i: u32| (0.5f64.powi(i as i32), base.finer(i));
        SolidFractal { octaves: (first..=last).map(octave).collect() }
    }
}

impl SolidLattice {
    /// The position of a texel in cells: along x, along y downwards, and the depth.
    pub fn cells(&self, texel: [f64; 2]) -> [f64; 3] {
        let [x, y] = self.plane.cells(texel);
        [x, y, self.depth]
    }

    /// Gradient noise at a position in cells: smooth, zero on average and on the lattice, within [-1, 1].
    pub fn noise(&self, [x, y, z]: [f64; 3]) -> f64 {
        let (i, j, k) = (x.floor(), y.floor(), z.floor());
        let (r, s, t) = (x - i, y - j, z - k);
        let (fade_r, fade_s, fade_t) = (fade(r), fade(s), fade(t));
        let corner = |di: i64, dj: i64, dk: i64| {
            let g = self.gradient(i as i64 + di, j as i64 + dj, k as i64 + dk);
            g[0] * (r - di as f64) + g[1] * (s - dj as f64) + g[2] * (t - dk as f64)
        };
        let edge = |dj, dk| lerp(corner(0, dj, dk), corner(1, dj, dk), fade_r);
        let face = |dk| lerp(edge(0, dk), edge(1, dk), fade_s);
        // Unit gradients reach half the diagonal of the cell.
        lerp(face(0), face(1), fade_t) * (2.0 / 3f64.sqrt())
    }

    /// The unit gradient of a lattice point: a point of the cube (never its centre, because the numbers are
    /// odd) projected to the sphere.
    fn gradient(&self, i: i64, j: i64, k: i64) -> [f64; 3] {
        let k = self.depth_period.map_or(k, |period| k.rem_euclid(period));
        let hash = self.plane.solid_hash(i, j, k);
        let odd = |bits: u64| f64::from((bits & 0xffff) as i32 * 2 - 0xffff);
        let [x, y, z] = [odd(hash), odd(hash >> 16), odd(hash >> 32)];
        let length = (x * x + y * y + z * z).sqrt();
        [x / length, y / length, z / length]
    }

    fn finer(&self, octave: u32) -> Self {
        Self {
            plane: self.plane.finer(octave),
            depth: self.depth * f64::from(octave).exp2(),
            depth_period: self.depth_period.map(|period| period << octave),
        }
    }
}

impl SolidFractal {
    /// Sum of 2^-i n at a texel.
    pub fn at(&self, texel: [f64; 2]) -> f64 {
        self.octaves.iter().map(|(weight, lattice)| weight * lattice.noise(lattice.cells(texel))).sum()
    }

    /// Turbulence: sum of 2^-i |n| at a texel, never negative.
    pub fn turbulence(&self, texel: [f64; 2]) -> f64 {
        self.octaves.iter().map(|(weight, lattice)| weight * lattice.noise(lattice.cells(texel)).abs()).sum()
    }

    /// The octaves with their weights.
    pub fn octaves(&self) -> impl Iterator<Item = (f64, SolidLattice)> + '_ {
        self.octaves.iter().copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::procedural::Tiling;
    use crate::size::Size;

    pub fn block(tiling: Tiling, depth: f64, depth_period: Option<u32>) -> SolidBlock {
        SolidBlock {
            canvas: Canvas { size: Size::new(50, 30), tiling, seed: 3 },
            feature: 7.0,
            depth,
            depth_period,
        }
    }

    fn places() -> impl Iterator<Item = [f64; 2]> {
        (0..400).map(|k| [f64::from(k * 37 % 401) * 0.21 - 9.0, f64::from(k * 53 % 397) * 0.13 - 4.0])
    }

    /// The sum over the eight corners of (weight of the corner) x (gradient . vector from it).
    fn plain_noise(lattice: &SolidLattice, place: [f64; 3]) -> f64 {
        let corners = (0..8).map(|c| [c & 1, c >> 1 & 1, c >> 2]);
        let term = |corner: [i64; 3]| {
            let at: [f64; 3] = std::array::from_fn(|a| place[a].floor() + corner[a] as f64);
            let way: [f64; 3] = std::array::from_fn(|a| place[a] - at[a]);
            let weight: f64 = way
                .iter()
                .map(|w| 1.0 - w.abs())
                .map(|t| 6.0 * t.powi(5) - 15.0 * t.powi(4) + 10.0 * t.powi(3))
                .product();
            let gradient = lattice.gradient(at[0] as i64, at[1] as i64, at[2] as i64);
            weight * gradient.iter().zip(way).map(|(g, w)| g * w).sum::<f64>()
        };
        corners.map(term).sum::<f64>() * 2.0 / 3f64.sqrt()
    }

    #[test]
    fn noise_is_the_weighted_sum_over_the_corners() {
        let lattice = block(Tiling::Free, 0.37, None).lattice([5.0, 3.0, 4.0], 2);
        for place in places().map(|p| lattice.cells(p)) {
            let (found, truth) = (lattice.noise(place), plain_noise(&lattice, place));
            assert!((found - truth).abs() < 1e-12, "{place:?}: {found} instead of {truth}");
        }
    }

    #[test]
    fn noise_is_bounded_vanishes_on_the_lattice_and_averages_to_zero() {
        let lattice = block(Tiling::Free, 0.0, None).lattice([1.0; 3], 0);
        let values: Vec<f64> =
            places().map(|p| lattice.noise([3.1 * p[0], 2.7 * p[1], 1.9 * p[0] - p[1]])).collect();
        assert!(values.iter().all(|v| v.abs() <= 1.0));
        assert!(values.iter().any(|v| *v > 0.4) && values.iter().any(|v| *v < -0.4));
        assert!(values.iter().sum::<f64>().abs() / (values.len() as f64) < 0.06);
        assert_eq!(lattice.noise([4.0, -7.0, 2.0]), 0.0);
    }

    #[test]
    fn octaves_close_on_the_torus_and_along_the_depth_exactly() {
        let shifted = |p: [f64; 2]| [p[0] + 50.0, p[1] - 30.0];
        let differs = |tiling, period, later| {
            let here = block(tiling, 0.4, period).fractal([9.0, 5.0, 6.0], (1, 4), 8);
            let there = block(tiling, 0.4 + later, period).fractal([9.0, 5.0, 6.0], (1, 4), 8);
            let difference = |p| (here.at(p) - there.at(shifted(p))).abs();
            places().map(difference).fold(0.0, f64::max)
        };
        assert!(differs(Tiling::Torus, None, 0.0) < 1e-9);
        assert!(differs(Tiling::Torus, Some(3), 3.0) < 1e-9);
        assert!(differs(Tiling::Torus, None, 3.0) > 0.1);
        assert!(differs(Tiling::Free, None, 0.0) > 0.1);
    }

    #[test]
    fn octave_i_has_cells_of_a_2_to_the_i_th_and_that_weight() {
        let fractal = block(Tiling::Torus, 0.3, Some(2)).fractal([9.0, 5.0, 6.0], (1, 3), 8);
        let base = block(Tiling::Torus, 0.3, Some(2)).lattice([9.0, 5.0, 6.0], 8);
        for ((weight, lattice), i) in fractal.octaves().zip(1..) {
            let factor = 2f64.powi(i);
            assert_eq!(weight, 1.0 / factor);
            assert_eq!(lattice.cells([3.0, 4.0]), base.cells([3.0, 4.0]).map(|c| c * factor));
        }
    }
}
