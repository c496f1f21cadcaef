//! Pairs of all of some lights with all of some views: interpolated in the triangles of both, by products of shares.

use std::cmp::Ordering;

use super::triangulated::Triangulation;
use crate::direction::{Direction, Directions};

/// The number of pairs around one.
pub(super) const AROUND: usize = 9;

/// The pairs of a grid.
#[derive(Debug, Clone)]
pub struct PairGrid {
    lights: Triangulation,
    views: Triangulation,
    /// The pair of each view and light, views first.
    pairs: Vec<u32>,
    light_count: usize,
}

impl PairGrid {
    /// The grid that pairs form, if they do: each of the lights with each of the views, once.
    pub fn new(pairs: &[Directions]) -> Option<Self> {
        let lights = distinct(pairs.iter().map(|pair| pair.light));
        let views = distinct(pairs.iter().map(|pair| pair.view));
        if lights.len().checked_mul(views.len())? != pairs.len() {
            return None;
        }
        let place = |all: &[Direction], d| all.binary_search_by(|other| order(other, &d)).ok();
        let mut table = vec![u32::MAX; pairs.len()];
        for (i, pair) in pairs.iter().enumerate() {
            let entry = &mut table[place(&views, pair.view)? * lights.len() + place(&lights, pair.light)?];
            if *entry != u32::MAX {
                return None;
            }
            *entry = i as u32;
        }
        Some(Self {
            lights: Triangulation::new(&lights),
            views: Triangulation::new(&views),
            pairs: table,
            light_count: lights.len(),
        })
    }

    /// The lights.
    pub fn lights(&self) -> &Triangulation {
        &self.lights
    }

    /// The views.
    pub fn views(&self) -> &Triangulation {
        &self.views
    }

    /// The index of a pair among the measured ones.
    pub fn pair(&self, light: usize, view: usize) -> usize {
        self.pairs[view * self.light_count + light] as usize
    }

    /// The pairs around one, and their shares.
    pub fn shares(&self, directions: Directions) -> [(usize, f64); AROUND] {
        let (lights, views) = (self.lights.shares(directions.light), self.views.shares(directions.view));
        std::array::from_fn(|i| {
            let ((view, a), (light, b)) = (views[i / 3], lights[i % 3]);
            (self.pair(light, view), a * b)
        })
    }
}

fn distinct(directions: impl Iterator<Item = Direction>) -> Vec<Direction> {
    let mut all: Vec<Direction> = directions.collect();
    all.sort_by(order);
    all.dedup();
    all
}

fn order(a: &Direction, b: &Direction) -> Ordering {
    let (a, b) = (a.to_array(), b.to_array());
    a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])).then(a[2].total_cmp(&b[2]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn direction(i: usize) -> Direction {
        Direction::from_angles(0.2 + 0.1 * i as f64, 1.7 * i as f64)
    }

    #[test]
    fn grids_are_recognised_in_any_order_and_nothing_else_is() {
        let mut pairs: Vec<Directions> = (0..5)
            .flat_map(|v| (0..7).map(move |l| Directions { light: direction(l), view: direction(v + 3) }))
            .collect();
        pairs.reverse();
        pairs.swap(3, 20);
        let grid = PairGrid::new(&pairs).unwrap();
        for (i, pair) in pairs.iter().enumerate() {
            let own: f64 = grid.shares(*pair).iter().filter(|(k, _)| *k == i).map(|(_, s)| s).sum();
            assert!((own - 1.0).abs() < 1e-9);
        }
        assert!(PairGrid::new(&pairs[1..]).is_none());
        let mut twice = pairs.clone();
        twice[0] = twice[1];
        assert!(PairGrid::new(&twice).is_none());
    }
}
