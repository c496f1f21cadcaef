//! Interpolation between measured pairs of directions: the pairs around one, and their shares.
//!
//! Where the pairs are those of all of some lights with all of some views, as in usual measurements, interpolation is
//! linear in the triangles of both: nine pairs with products of barycentric coordinates; beyond the last ring of
//! directions values stay constant (`triangulated`). Between other pairs it is that of the modified inverse distances
//! of Franke, Nielson, "Smooth Interpolation of Large Sets of Scattered Data" (International Journal for Numerical
//! Methods in Engineering 15, 1980, equation 2.2), after Shepard, "A two-dimensional interpolation function for
//! irregularly-spaced data" (1968): among the 16 nearest pairs, one at distance d has the weight ((R - d) / (R d))^2,
//! where R is the distance of the 17th, and weights are divided by their sum. The distance is that of the six components
//! of both unit vectors. So measured pairs keep their values, and weights fade to zero before one pair replaces another.
//! The slope is zero at measured pairs: curves have flat spots there. Reciprocity is not used.

mod grid;
mod nearest;
mod triangulated;

use crate::direction::Directions;
pub use grid::PairGrid;
use nearest::{MOST, PairTree};
pub use triangulated::{Shares, Triangulation, barycentric, projected};

/// A pair within this squared distance of a measured one gets its values.
const SAME: f64 = 1e-18;

/// The relative excess of the radius of the weights over the distance of the first pair left out, so that
/// equidistant pairs have equal weights instead of zero weights.
const MARGIN: f64 = 1e-6;

/// Measured pairs, prepared for interpolation.
#[derive(Debug, Clone)]
pub struct Between(Arranged);

#[derive(Debug, Clone)]
enum Arranged {
    Grid(PairGrid),
    Scattered(PairTree),
}

/// The pairs around one and their shares, which sum to 1. None is zero.
#[derive(Debug, Clone, Copy)]
pub struct PairShares {
    shares: [(usize, f64); MOST],
    count: usize,
}

impl PairShares {
    /// The index of each pair among the measured ones, and its share.
    pub fn as_slice(&self) -> &[(usize, f64)] {
        &self.shares[..self.count]
    }

    fn of(shares: impl IntoIterator<Item = (usize, f64)>) -> Self {
        let mut found = Self { shares: [(0, 0.0); MOST], count: 0 };
        for share in shares.into_iter().filter(|(_, share)| *share != 0.0) {
            found.shares[found.count] = share;
            found.count += 1;
        }
        found
    }
}

impl Between {
    /// Of at least one pair.
    pub fn new(pairs: &[Directions]) -> Self {
        let scattered = || {
            let points: Vec<[f64; 6]> = pairs.iter().map(|pair| pair.to_array()).collect();
            Arranged::Scattered(PairTree::new(&points))
        };
        Self(PairGrid::new(pairs).map_or_else(scattered, Arranged::Grid))
    }

    /// The grid that the pairs form, if they do.
    pub fn grid(&self) -> Option<&PairGrid> {
        match &self.0 {
            Arranged::Grid(grid) => Some(grid),
            Arranged::Scattered(_) => None,
        }
    }

    /// The measured pairs around a pair, without an allocation.
    pub fn shares(&self, directions: Directions) -> PairShares {
        match &self.0 {
            Arranged::Grid(grid) => PairShares::of(grid.shares(directions)),
            Arranged::Scattered(tree) => inverse_distances(tree, directions),
        }
    }
}

fn inverse_distances(tree: &PairTree, directions: Directions) -> PairShares {
    let found = tree.nearest(&directions.to_array());
    let neighbours = found.neighbours();
    if neighbours[0].0 <= SAME {
        return PairShares::of([(neighbours[0].1 as usize, 1.0)]);
    }
    // If all pairs are neighbours, the radius is large and the weights are inverse squares.
    let radius = match neighbours.len() {
        MOST => neighbours[MOST - 1].0.sqrt() * (1.0 + MARGIN),
        _ => 1.0 / MARGIN,
    };
    let weight = |&(square, pair): &(f64, u32)| {
        let distance = square.sqrt();
        (pair as usize, ((radius - distance) / (radius * distance)).powi(2))
    };
    let used = &neighbours[..neighbours.len().min(MOST - 1)];
    let sum: f64 = used.iter().map(|neighbour| weight(neighbour).1).sum();
    PairShares::of(used.iter().map(weight).map(|(pair, weight)| (pair, weight / sum)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::direction::Direction;

    fn pairs(keep: impl Fn(usize) -> bool) -> Vec<Directions> {
        let direction = |i: usize| Direction::from_angles(0.15 * i as f64, 2.4 * i as f64);
        let grid = (0..9).flat_map(|v| (0..7).map(move |l| (l, v)));
        let pair = |(l, v): (usize, usize)| Directions { light: direction(l), view: direction(v + 1) };
        grid.map(pair).enumerate().filter(|(i, _)| keep(*i)).map(|(_, pair)| pair).collect()
    }

    /// The slow truth: all pairs sorted by distance.
    fn slow(pairs: &[Directions], directions: Directions) -> Vec<f64> {
        let far = |i: usize| nearest::square_distance(&pairs[i].to_array(), &directions.to_array()).sqrt();
        let mut order: Vec<usize> = (0..pairs.len()).collect();
        order.sort_by(|&a, &b| far(a).total_cmp(&far(b)));
        let radius = far(order[MOST - 1]) * (1.0 + MARGIN);
        let mut shares = vec![0.0; pairs.len()];
        order[..MOST - 1].iter().for_each(|&i| shares[i] = (1.0 / far(i) - 1.0 / radius).powi(2));
        let sum: f64 = shares.iter().sum();
        shares.into_iter().map(|share| share / sum).collect()
    }

    #[test]
    fn inverse_distances_equal_their_definition() {
        let pairs = pairs(|i| i % 5 != 2);
        let between = Between::new(&pairs);
        assert!(matches!(between.0, Arranged::Scattered(_)));
        for i in 0..100 {
            let t = f64::from(i);
            let light = Direction::from_angles(0.011 * t + 0.07, 2.1 * t);
            let directions = Directions { light, view: Direction::from_angles(1.2 - 0.009 * t, 0.7 * t) };
            let truth = slow(&pairs, directions);
            let found = between.shares(directions);
            assert!((found.as_slice().iter().map(|(_, s)| s).sum::<f64>() - 1.0).abs() < 1e-12);
            assert!(found.as_slice().iter().all(|(k, share)| (share - truth[*k]).abs() < 1e-9));
        }
    }

    #[test]
    fn measured_pairs_have_all_of_their_share_in_any_arrangement() {
        for pairs in [pairs(|_| true), pairs(|i| i % 5 != 2), pairs(|i| i == 3)] {
            let between = Between::new(&pairs);
            for (i, pair) in pairs.iter().enumerate() {
                let shares = between.shares(*pair);
                let own: f64 = shares.as_slice().iter().filter(|(k, _)| *k == i).map(|(_, s)| s).sum();
                assert!((own - 1.0).abs() < 1e-6, "{shares:?}");
            }
        }
    }
}
