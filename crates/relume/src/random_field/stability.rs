//! Whether a fitted field decays or grows without bound, and how long its memory is.
//!
//! Along x a plane is a sum of waves e^(i w x), and for each of them the row recursion is a matrix recursion
//! over rows: (I - A_0(w)) y_t = sum_k A_k(w) y_(t-k), where A_k collects the weights of the neighbours k
//! rows up. By Huang's theorem ("Stability of Two-Dimensional Recursive Filters", IEEE Trans. Audio and
//! Electroacoustics 20, 1972) the field is stable when for every w the spectral radius of that recursion is
//! below one, as well as that of the recursion within the row over left neighbours. ||M^p||^(1/p) is never
//! below the spectral radius of M and converges to it, so a value below one proves stability at that
//! frequency; frequencies are tried on a grid.

use rustfft::num_complex::Complex64;

use super::level::Level;
use super::neighbourhood::Offset;
use super::recursion::{LANES, Recursion, RecursionRun};
use crate::parallel;
use crate::size::Size;

/// Frequencies tried between 0 and pi; narrower resonances show in [`burn_in`].
const FREQUENCIES: usize = 48;

/// The number of squarings of a matrix: the bound is that of its 1024th power.
const SQUARINGS: usize = 10;

/// Margins tried, in texels. A field with a longer memory counts as unstable.
pub const BURN_INS: [usize; 5] = [8, 16, 32, 64, 128];

/// The largest effect of the zero initial state after the margin, as a fraction of the deviation of the
/// field: a seventh of an 8-bit code for a texture of deviation 0.15.
pub const BURN_IN_ERROR: f64 = 1.0 / 256.0;

/// Upper bounds of the spectral radii of the recursions of a level.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stability {
    /// Within a row, over left neighbours.
    pub left: f64,
    /// From row to row, the largest over all frequencies.
    pub rows: f64,
}

impl Stability {
    /// The bounds for a level.
    pub fn of(level: &Level) -> Self {
        let (m, reach) = (level.planes(), level.reach());
        let weights: Vec<f64> = level.weights.values(false).iter().map(|&w| f64::from(w)).collect();
        let matrix = |wanted: &dyn Fn(Offset) -> Option<Complex64>| {
            let mut sum = Square::zeros(m);
            for (t, &offset) in level.neighbours.iter().enumerate() {
                let Some(factor) = wanted(offset) else { continue };
                for (i, j) in (0..m).flat_map(|i| (0..m).map(move |j| (i, j))) {
                    sum.data[j * m + i] += factor * weights[(t * m + i) * m + j];
                }
            }
            sum
        };
        let own =
            |dx: usize| matrix(&|o| (o.dy == 0 && o.dx == -(dx as i32)).then_some(Complex64::new(1.0, 0.0)));
        let left: Vec<Square> = (1..=reach.left).map(own).collect();
        let radius_at = |k: usize| {
            let w = std::f64::consts::PI * k as f64 / FREQUENCIES as f64;
            let row = |up: usize| {
                matrix(&|o| (o.dy == -(up as i32)).then(|| Complex64::from_polar(1.0, w * f64::from(o.dx))))
            };
            let solve = row(0).one_minus().inverse();
            let above: Option<Vec<Square>> =
                solve.map(|inverse| (1..=reach.up).map(|up| inverse.times(&row(up))).collect());
            above.map_or(f64::INFINITY, |above| radius_bound(&above))
        };
        let rows = parallel::map(0..=FREQUENCIES, radius_at).into_iter().fold(0.0, f64::max);
        Self { left: radius_bound(&left), rows }
    }

    /// Whether both bounds are below one.
    pub fn is_stable(self) -> bool {
        self.left < 1.0 && self.rows < 1.0
    }
}

/// An upper bound of the spectral radius of y_t = sum_k A_k y_(t-k).
fn radius_bound(matrices: &[Square]) -> f64 {
    let Some(first) = matrices.first() else { return 0.0 };
    let (m, n) = (first.n, first.n * matrices.len());
    let mut companion = Square::zeros(n);
    for i in 0..n {
        for (k, a) in matrices.iter().enumerate().filter(|_| i < m) {
            companion.data[i * n + k * m..][..m].copy_from_slice(&a.data[i * m..(i + 1) * m]);
        }
        if i >= m {
            companion.data[i * n + i - m] = Complex64::new(1.0, 0.0);
        }
    }
    companion.radius_bound()
}

/// A square matrix of complex numbers, row by row.
#[derive(Debug, Clone)]
struct Square {
    n: usize,
    data: Vec<Complex64>,
}

impl Square {
    fn zeros(n: usize) -> Self {
        Self { n, data: vec![Complex64::default(); n * n] }
    }

    fn times(&self, other: &Self) -> Self {
        let n = self.n;
        let mut product = Self::zeros(n);
        for (row, out) in self.data.chunks_exact(n).zip(product.data.chunks_exact_mut(n)) {
            for (factor, line) in row.iter().zip(other.data.chunks_exact(n)) {
                out.iter_mut().zip(line).for_each(|(o, v)| *o += factor * v);
            }
        }
        product
    }

    fn one_minus(mut self) -> Self {
        self.data.iter_mut().for_each(|v| *v = -*v);
        (0..self.n).for_each(|i| self.data[i * self.n + i] += 1.0);
        self
    }

    /// By Gauss-Jordan elimination with row pivots; `None` where it is singular.
    fn inverse(mut self) -> Option<Self> {
        let n = self.n;
        let mut inverse = Self::zeros(n).one_minus();
        for c in 0..n {
            let pivot = (c..n)
                .max_by(|&a, &b| self.data[a * n + c].norm().total_cmp(&self.data[b * n + c].norm()))?;
            let scale = self.data[pivot * n + c].inv();
            if !scale.is_finite() {
                return None;
            }
            for matrix in [&mut self, &mut inverse] {
                (0..n).for_each(|k| matrix.data.swap(c * n + k, pivot * n + k));
                (0..n).for_each(|k| matrix.data[c * n + k] *= scale);
            }
            for r in (0..n).filter(|&r| r != c) {
                let factor = self.data[r * n + c];
                for matrix in [&mut self, &mut inverse] {
                    (0..n).for_each(|k| {
                        let part = factor * matrix.data[c * n + k];
                        matrix.data[r * n + k] -= part;
                    });
                }
            }
        }
        Some(inverse)
    }

    /// ||M^p||^(1/p) for a high p, in the Frobenius norm: never below the spectral radius.
    fn radius_bound(mut self) -> f64 {
        let mut log_norm = 0.0;
        for k in 0..=SQUARINGS {
            let norm = self.data.iter().map(|v| v.norm_sqr()).sum::<f64>().sqrt();
            if norm == 0.0 || !norm.is_finite() {
                return if norm == 0.0 { 0.0 } else { f64::INFINITY };
            }
            // M^(2^k) = e^(2^k log_norm) times the stored matrix, whose norm is one.
            log_norm += norm.ln() / f64::from(1u32 << k);
            self.data.iter_mut().for_each(|v| *v /= norm);
            if k < SQUARINGS {
                self = self.times(&self);
            }
        }
        log_norm.exp()
    }
}

/// The first of [`BURN_INS`] after which a zero start differs from one twice as far away by less than
/// [`BURN_IN_ERROR`] of the deviation, in root mean square over the first texels after the margins; `None` if
/// even the last does not suffice.
pub fn burn_in(level: &Level) -> Option<usize> {
    let recursion = Recursion::new(level, 0);
    // Margins double: what is far from one is near to the next.
    let mut far = corner(&recursion, BURN_INS[0]);
    BURN_INS.into_iter().find(|&margin| {
        let near = std::mem::replace(&mut far, corner(&recursion, 2 * margin));
        let difference: f64 = near.iter().zip(&far).map(|(a, b)| (a - b).powi(2)).sum();
        let square: f64 = far.iter().map(|v| v * v).sum();
        // A field of zeros, or one that overflows, gives NaN here.
        difference <= BURN_IN_ERROR * BURN_IN_ERROR * square
    })
}

/// Values around the corners of rectangles after a margin: a frame of a few texels of sixteen squares.
fn corner(recursion: &Recursion, margin: usize) -> Vec<f64> {
    const SIDE: usize = 8;
    let start = margin as i64;
    // Squares far from one another, so that their noise is independent; the same for every margin.
    let origins: [[i64; 2]; LANES] = std::array::from_fn(|l| [1000 * l as i64 - start, -start]);
    let size = Size::new(SIDE + margin + margin, SIDE + margin);
    let run = RecursionRun { size, drive: None, strength: None, seed: 0, period: None };
    let mut values = Vec::new();
    recursion.run(&origins, &run, |y, row| {
        if y >= margin {
            let texel = row.len() / size.width;
            values.extend(row[margin * texel..(margin + SIDE) * texel].iter().map(|&v| f64::from(v)));
        }
    });
    values
}

#[cfg(test)]
mod tests {
    use super::super::level::Weights;
    use super::super::recursion::tests::random_level;
    use super::*;

    /// A level of one plane with the given neighbours and weights.
    fn level(parts: &[(i32, i32, f64)]) -> Level {
        let weights: Vec<f64> = parts.iter().map(|p| p.2).collect();
        Level {
            neighbours: parts.iter().map(|p| Offset::new(p.0, p.1)).collect(),
            weights: Weights::nearest(&weights, parts.len(), vec![1e-3; 2], vec![1e-3]),
            ..random_level(1, 0, 1)
        }
    }

    #[test]
    fn radii_of_simple_recursions_are_known() {
        // Over the left neighbour alone, over the upper alone, and a product of both, each with one pole.
        let cases = [
            (vec![(-1, 0, 0.9)], 0.9, 0.0),
            (vec![(0, -1, -0.95)], 0.0, 0.95),
            (vec![(-1, 0, 0.7), (0, -1, 0.8), (-1, -1, -0.56)], 0.7, 0.8),
            // Roots 0.5 +- 0.5 i of z^2 - z + 0.5.
            (vec![(0, -1, 1.0), (0, -2, -0.5)], 0.0, 0.5f64.sqrt()),
        ];
        for (parts, left, rows) in cases {
            let bound = Stability::of(&level(&parts));
            assert!(bound.left >= left - 1e-6 && bound.left < left + 0.01, "{parts:?} {bound:?}");
            assert!(bound.rows >= rows - 1e-6 && bound.rows < rows + 0.01, "{parts:?} {bound:?}");
            assert!(bound.is_stable());
        }
    }

    #[test]
    fn unstable_fields_are_told_from_stable_ones() {
        // Each weight alone is harmless; together they are not.
        assert!(!Stability::of(&level(&[(-1, 0, 0.7), (0, -1, 0.7)])).is_stable());
        assert!(!Stability::of(&level(&[(-1, 0, 1.01)])).is_stable());
        assert!(!Stability::of(&level(&[(-1, -1, 0.6), (1, -1, -0.6)])).is_stable());
        assert!(Stability::of(&level(&[(-1, 0, 0.5), (0, -1, 0.45)])).is_stable());
        for seed in 0..20 {
            assert!(Stability::of(&random_level(3, 6, seed)).is_stable(), "sizes add to less than one");
        }
    }

    #[test]
    fn margins_grow_with_memory_and_end() {
        // 0.5^8 is about 1/256, and so is 0.9^53; 0.999 has a memory of thousands of texels.
        let margins = [0.3, 0.9, 0.999].map(|pole| burn_in(&level(&[(-1, 0, pole)])));
        assert_eq!(margins, [Some(8), Some(64), None]);
        assert_eq!(burn_in(&level(&[(1, -1, 0.9)])), Some(64), "memory runs to the right as well");
    }
}
