//! Noise that closes on the torus: gradient noise (K. Perlin, Improving noise, SIGGRAPH 2002),
//! sums of its octaves, and feature points (S. Worley, A cellular texture basis function,
//! SIGGRAPH 1996).
//!
//! Written here because seamless materials need lattices that wrap at a whole number of cells in both
//! directions, for any size and number of cells; the usual crates tile only by blending or through four
//! dimensions, which changes the look of the noise.
//!
//! Lattice cells are hashed with the finaliser of SplitMix64 (G. Steele, D. Lea, C. Flood, Fast splittable
//! pseudorandom number generators, OOPSLA 2014), so a value depends only on position and seed. Only sums,
//! products and square roots are used: every machine gives the same numbers.

use crate::size::Size;

/// Whether noise closes on the torus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tiling {
    /// Opposite borders continue each other; features are stretched slightly so that a whole
    /// number of them fits.
    Torus,
    /// Features have exactly the requested size and are cut off at the borders.
    Free,
}

/// The common parameters of all noise of one material.
#[derive(Debug, Clone, Copy)]
pub struct Canvas {
    /// Texels, and the period on the torus.
    pub size: Size,
    /// Whether noise closes on the torus.
    pub tiling: Tiling,
    /// The material's seed.
    pub seed: u64,
}

impl Canvas {
    /// A lattice of cells of about `cell` x `cell` texels; `layer` separates its random numbers
    /// from those of the material's other lattices.
    pub fn lattice(&self, cell: f64, layer: u64) -> NoiseLattice {
        self.stretched_lattice([cell, cell], layer)
    }

    /// A lattice of cells of about `cell[0]` x `cell[1]` texels.
    pub fn stretched_lattice(&self, cell: [f64; 2], layer: u64) -> NoiseLattice {
        let sides = [self.size.width as f64, self.size.height as f64];
        let whole = |i: usize| (sides[i] / cell[i]).round().max(1.0);
        let (cells_per_texel, period) = match self.tiling {
            Tiling::Torus => {
                let cells = [whole(0), whole(1)];
                ([cells[0] / sides[0], cells[1] / sides[1]], Some([cells[0] as i64, cells[1] as i64]))
            }
            Tiling::Free => ([1.0 / cell[0], 1.0 / cell[1]], None),
        };
        NoiseLattice { cells_per_texel, period, seed: mix(self.seed ^ mix(layer)) }
    }

    /// Random number `k`, in [0, 1), of the object numbered `index`.
    pub fn random(&self, layer: u64, index: i64, k: i64) -> f64 {
        unit(mix(mix(self.seed ^ mix(layer)) ^ mix(index as u64 ^ mix(k as u64))))
    }

    /// `octaves` octaves of gradient noise, the coarsest in cells of `cell` texels.
    pub fn fractal(&self, cell: f64, octaves: u32, layer: u64) -> Fractal {
        self.stretched_fractal([cell, cell], octaves, layer)
    }

    /// `octaves` octaves of gradient noise, the coarsest in cells of `cell[0]` x `cell[1]` texels.
    pub fn stretched_fractal(&self, cell: [f64; 2], octaves: u32, layer: u64) -> Fractal {
        let octave = |k: u32| {
            let finer = 0.5f64.powi(k as i32);
            self.stretched_lattice([cell[0] * finer, cell[1] * finer], layer ^ (u64::from(k + 1) << 32))
        };
        Fractal { octaves: (0..octaves).map(octave).collect() }
    }
}

/// A lattice of cells over the texels, periodic on the torus.
#[derive(Debug, Clone, Copy)]
pub struct NoiseLattice {
    cells_per_texel: [f64; 2],
    period: Option<[i64; 2]>,
    seed: u64,
}

/// A feature point near a position.
#[derive(Debug, Clone, Copy)]
pub struct Site {
    /// The vector from the position to the point, in cells.
    pub offset: [f64; 2],
    /// The number of the point; periodic copies share it.
    pub id: u64,
}

impl Site {
    /// The distance from the position to the point, in cells.
    pub fn distance(&self) -> f64 {
        (self.offset[0] * self.offset[0] + self.offset[1] * self.offset[1]).sqrt()
    }

    /// Random number `k` of the point, in [0, 1).
    pub fn random(&self, k: u64) -> f64 {
        unit(mix(self.id ^ mix(k)))
    }
}

/// The two feature points nearest to a position.
#[derive(Debug, Clone, Copy)]
pub struct Nearest {
    /// The nearest.
    pub first: Site,
    /// The distance to the border of the Voronoi cell of the nearest point, in cells: the distance from the
    /// position to the nearest bisector with another point.
    pub border: f64,
}

impl NoiseLattice {
    /// The position in cells.
    pub fn cells(&self, texel: [f64; 2]) -> [f64; 2] {
        [texel[0] * self.cells_per_texel[0], texel[1] * self.cells_per_texel[1]]
    }

    fn cell_hash(&self, i: i64, j: i64) -> u64 {
        let [i, j] = self.wrapped(i, j);
        mix(self.seed ^ mix(i as u64 ^ mix(j as u64)))
    }

    /// The representative of cell (i, j): itself, or the cell of the first period.
    fn wrapped(&self, i: i64, j: i64) -> [i64; 2] {
        match self.period {
            Some([columns, rows]) => [i.rem_euclid(columns), j.rem_euclid(rows)],
            None => [i, j],
        }
    }

    /// The random number of a cell of the solid lattice over this one.
    pub(super) fn solid_hash(&self, i: i64, j: i64, k: i64) -> u64 {
        let [i, j] = self.wrapped(i, j);
        mix(self.seed ^ mix(i as u64 ^ mix(j as u64 ^ mix(k as u64))))
    }

    /// The lattice with cells smaller by 2^`octave`, with its own random numbers.
    pub(super) fn finer(&self, octave: u32) -> Self {
        let factor = 1i64 << octave;
        Self {
            cells_per_texel: self.cells_per_texel.map(|c| c * factor as f64),
            period: self.period.map(|period| period.map(|cells| cells * factor)),
            seed: mix(self.seed ^ mix(u64::from(octave))),
        }
    }

    /// Gradient noise at a texel: smooth, zero on average, within [-1, 1].
    pub fn gradient(&self, texel: [f64; 2]) -> f64 {
        let [u, v] = self.cells(texel);
        let (i, j) = (u.floor(), v.floor());
        let (s, t) = (u - i, v - j);
        let corner = |di: i64, dj: i64| {
            let [gx, gy] = unit_gradient(self.cell_hash(i as i64 + di, j as i64 + dj));
            gx * (s - di as f64) + gy * (t - dj as f64)
        };
        let (fade_s, fade_t) = (fade(s), fade(t));
        let top = lerp(corner(0, 0), corner(1, 0), fade_s);
        let bottom = lerp(corner(0, 1), corner(1, 1), fade_s);
        lerp(top, bottom, fade_t) * std::f64::consts::SQRT_2
    }

    /// The feature points of the nine cells around a texel: all that lie within one side of a cell.
    pub fn sites(&self, texel: [f64; 2]) -> impl Iterator<Item = Site> + '_ {
        self.sites_within(texel, 1)
    }

    fn sites_within(&self, texel: [f64; 2], reach: i64) -> impl Iterator<Item = Site> + '_ {
        let [u, v] = self.cells(texel);
        let (i, j) = (u.floor() as i64, v.floor() as i64);
        let cells = (-reach..=reach).flat_map(move |dj| (-reach..=reach).map(move |di| (i + di, j + dj)));
        cells.map(move |(ci, cj)| {
            let id = self.cell_hash(ci, cj);
            let jitter = |k: u64| 0.1 + 0.8 * unit(mix(id.wrapping_add(k)));
            Site { offset: [ci as f64 + jitter(1) - u, cj as f64 + jitter(2) - v], id }
        })
    }

    /// The nearest feature point and the distance to the border of its cell.
    pub fn nearest(&self, texel: [f64; 2]) -> Nearest {
        let mut first = Site { offset: [f64::INFINITY; 2], id: 0 };
        for site in self.sites_within(texel, 1) {
            if site.distance() < first.distance() {
                first = site;
            }
        }
        let mut border = f64::INFINITY;
        for site in self.sites_within(texel, 2) {
            let between = [site.offset[0] - first.offset[0], site.offset[1] - first.offset[1]];
            let length = (between[0] * between[0] + between[1] * between[1]).sqrt();
            if length > 1e-9 {
                let middle = [site.offset[0] + first.offset[0], site.offset[1] + first.offset[1]];
                border = border.min(0.5 * (middle[0] * between[0] + middle[1] * between[1]) / length);
            }
        }
        Nearest { first, border }
    }
}

/// Octaves of gradient noise, each with half the cell size and half the amplitude of the one before.
#[derive(Debug, Clone)]
pub struct Fractal {
    octaves: Vec<NoiseLattice>,
}

impl Fractal {
    /// The sum of the octaves at a texel, within [-2, 2] and mostly within [-1, 1].
    pub fn at(&self, texel: [f64; 2]) -> f64 {
        self.sum(texel, |noise| noise)
    }

    /// The sum of the octaves' creases, 1 - |noise|: sharp ridges, within [0, 2] (F. K. Musgrave,
    /// in Texturing and Modeling, 1994, ridged multifractal without feedback).
    pub fn ridges(&self, texel: [f64; 2]) -> f64 {
        self.sum(texel, |noise| 1.0 - noise.abs())
    }

    fn sum(&self, texel: [f64; 2], shape: impl Fn(f64) -> f64) -> f64 {
        let mut amplitude = 1.0;
        let mut sum = 0.0;
        for octave in &self.octaves {
            sum += amplitude * shape(octave.gradient(texel));
            amplitude *= 0.5;
        }
        sum
    }
}

/// The finaliser of SplitMix64.
fn mix(value: u64) -> u64 {
    let z = value.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

fn unit(hash: u64) -> f64 {
    (hash >> 11) as f64 / (1u64 << 53) as f64
}

/// A unit vector: a point of the square (never its centre, because the numbers are odd) projected to the
/// circle.
fn unit_gradient(hash: u64) -> [f64; 2] {
    let odd = |bits: u64| f64::from((bits & 0xffff) as i32 * 2 - 0xffff);
    let (x, y) = (odd(hash), odd(hash >> 16));
    let length = (x * x + y * y).sqrt();
    [x / length, y / length]
}

pub(super) fn fade(t: f64) -> f64 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

pub(super) fn lerp(a: f64, b: f64, t: f64) -> f64 {
    a + (b - a) * t
}

#[cfg(test)]
mod tests {
    use super::*;

    fn canvas(tiling: Tiling) -> Canvas {
        Canvas { size: Size::new(50, 30), tiling, seed: 3 }
    }

    fn places() -> impl Iterator<Item = [f64; 2]> {
        (0..400).map(|k| [f64::from(k * 37 % 401) * 0.21 - 9.0, f64::from(k * 53 % 397) * 0.13 - 4.0])
    }

    #[test]
    fn noise_has_the_period_of_the_torus_and_only_there() {
        let shifted = |p: [f64; 2]| [p[0] + 50.0, p[1] - 30.0];
        let differs = |tiling| {
            let lattice = canvas(tiling).lattice(7.0, 1);
            let fractal = canvas(tiling).fractal(13.0, 4, 2);
            let difference = |p| {
                let noise = (lattice.gradient(p) - lattice.gradient(shifted(p))).abs();
                let sum = (fractal.at(p) - fractal.at(shifted(p))).abs();
                let border = (lattice.nearest(p).border - lattice.nearest(shifted(p)).border).abs();
                noise.max(sum).max(border)
            };
            places().map(difference).fold(0.0, f64::max)
        };
        assert!(differs(Tiling::Torus) < 1e-9);
        assert!(differs(Tiling::Free) > 0.1);
    }

    #[test]
    fn gradient_noise_is_bounded_vanishes_on_the_lattice_and_averages_to_zero() {
        let lattice = canvas(Tiling::Free).lattice(1.0, 0);
        let values: Vec<f64> = places().map(|p| lattice.gradient([p[0] * 3.1, p[1] * 2.7])).collect();
        assert!(values.iter().all(|v| v.abs() <= 1.0));
        assert!(values.iter().any(|v| *v > 0.5) && values.iter().any(|v| *v < -0.5));
        assert!(values.iter().sum::<f64>().abs() / (values.len() as f64) < 0.06);
        assert!(lattice.gradient([4.0, -7.0]).abs() < 1e-12);
    }

    #[test]
    fn the_border_distance_is_that_of_a_dense_search() {
        let lattice = canvas(Tiling::Torus).lattice(6.0, 5);
        for place in places().take(60) {
            let nearest = lattice.nearest(place);
            let cell = lattice.cells_per_texel;
            let crosses = |angle: f64, radius: f64| {
                let step = [radius * angle.cos() / cell[0], radius * angle.sin() / cell[1]];
                let there = lattice.nearest([place[0] + step[0], place[1] + step[1]]).first;
                let moved = [there.offset[0] + radius * angle.cos(), there.offset[1] + radius * angle.sin()];
                (moved[0] - nearest.first.offset[0]).hypot(moved[1] - nearest.first.offset[1]) > 1e-6
            };
            let angles = || (0..720).map(|k| f64::from(k) * std::f64::consts::PI / 360.0);
            assert!(!angles().any(|a| crosses(a, 0.999 * nearest.border - 1e-4)));
            assert!(angles().any(|a| crosses(a, 1.001 * nearest.border + 1e-4)));
        }
    }
}
