//! The light under which a function of any basis is largest, by a table and shrinking steps.
//!
//! The values of the functions over a grid of the unit disk and its rim are computed once. The best grid
//! point of a texel is then improved by pattern search (Hooke, Jeeves, "Direct Search Solution of Numerical
//! and Statistical Problems", Journal of the ACM 8, 1961): a move to the best of eight neighbours, or half
//! the step. Limits: a peak narrower than a step of the grid may be missed, and of two peaks of nearly equal
//! height the lower may be found. The view is the zenith.

use crate::direction::{Direction, Directions};
use crate::field::Basis;

/// Steps of the grid from the middle of the disk to its rim.
const STEPS: i32 = 16;

/// Points of the rim, with the spacing of the grid.
const RIM: i32 = 100;

/// The step at which the search ends.
const LEAST_STEP: f64 = 1e-7;

/// Moves and halvings at most: 20 halvings, and moves along a curved ridge.
const MOST_ROUNDS: usize = 200;

/// The values of the functions over a grid of lights.
pub(super) struct Search<'a> {
    basis: &'a Basis,
    /// Points of the unit disk, the nearest to the middle first.
    points: Vec<(f64, f64)>,
    /// The values of the functions, point after point.
    values: Vec<f64>,
}

impl<'a> Search<'a> {
    pub fn new(basis: &'a Basis) -> Self {
        let grid = (-STEPS..=STEPS).flat_map(|j| (-STEPS..=STEPS).map(move |i| (i, j)));
        let mut inside: Vec<(i32, i32)> = grid.filter(|(i, j)| i * i + j * j <= STEPS * STEPS).collect();
        inside.sort_by_key(|(i, j)| (i * i + j * j, *j, *i));
        let at = |k: i32| f64::from(k) / f64::from(STEPS);
        let rim = (0..RIM).map(|i| {
            let (y, x) = (std::f64::consts::TAU * f64::from(i) / f64::from(RIM)).sin_cos();
            (x, y)
        });
        let points: Vec<_> = inside.into_iter().map(|(i, j)| (at(i), at(j))).chain(rim).collect();
        let n = basis.len();
        let mut values = vec![0.0; points.len() * n];
        for (&(u, v), row) in points.iter().zip(values.chunks_exact_mut(n)) {
            basis.weights_into(Directions::lit_from(Direction::from_disk(u, v)), row);
        }
        Self { basis, points, values }
    }

    /// The point (u, v) of the unit disk at which the function with these coefficients is largest; among
    /// equal grid points, the nearest to the zenith. `weights` is scratch memory of the length of the basis.
    pub fn maximum(&self, coefficients: &[f64], weights: &mut [f64]) -> (f64, f64) {
        let dot = |row: &[f64]| -> f64 { row.iter().zip(coefficients).map(|(w, c)| w * c).sum() };
        let (mut place, mut best) = (self.points[0], f64::NEG_INFINITY);
        for (&point, row) in self.points.iter().zip(self.values.chunks_exact(coefficients.len())) {
            let value = dot(row);
            if value > best {
                (place, best) = (point, value);
            }
        }
        let mut step = 1.0 / f64::from(STEPS);
        for _ in 0..MOST_ROUNDS {
            if step < LEAST_STEP {
                break;
            }
            let middle = place;
            for (i, j) in [(1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1)] {
                let (u, v) = (middle.0 + step * f64::from(i), middle.1 + step * f64::from(j));
                // Points outside are projected onto the rim.
                let light = Direction::from_disk(u, v);
                self.basis.weights_into(Directions::lit_from(light), weights);
                let value = dot(weights);
                if value > best {
                    (place, best) = ((light.x(), light.y()), value);
                }
            }
            if place == middle {
                step *= 0.5;
            }
        }
        place
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};
    use crate::surface::argmax::{maximum_by_search, ptm_maximum};

    #[test]
    fn no_light_is_brighter_than_the_one_found() {
        let mut stream = Stream::new(9, Purpose::Sample, [0]);
        for basis in Basis::NAMED {
            let search = Search::new(&basis);
            let mut scratch = vec![0.0; basis.len()];
            for _ in 0..60 {
                let coefficients: Vec<f64> = (0..basis.len()).map(|_| 2.0 * stream.unit() - 1.0).collect();
                let value = |u: f64, v: f64| -> f64 {
                    let weights = basis.weights(Direction::from_disk(u, v));
                    weights.iter().zip(&coefficients).map(|(w, c)| w * c).sum()
                };
                let (u, v) = search.maximum(&coefficients, &mut scratch);
                assert!(u.hypot(v) <= 1.0 + 1e-12);
                let (a, b) = maximum_by_search(value);
                let (found, truth) = (value(u, v), value(a, b));
                assert!(found >= truth - 1e-3, "{}: {found} below {truth}", basis.name());
            }
        }
    }

    #[test]
    fn polynomials_have_the_maximum_of_the_closed_form() {
        let coefficients = [-1.0, -2.0, 1.0, 1.0, -1.9, 0.0];
        let (u, v) = Search::new(&Basis::Ptm).maximum(&coefficients, &mut [0.0; 6]);
        let (a, b) = ptm_maximum(coefficients);
        assert!((u - a).hypot(v - b) < 1e-5, "({u}, {v}) and ({a}, {b})");
    }
}
