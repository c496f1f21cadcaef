//! One outline for all elements: the cell whose border runs along the joints.
//!
//! A watershed on the torus of the lattice. A flood starts at the middle of the element and always takes the
//! place next to it that is reached over the highest ground, where the ground is the higher the less a place looks
//! like a joint (`joints`); of equals, the nearest one. It meets itself, from all sides, along the lowest lines: the
//! joints. Each place of the torus is taken once, together with the cell from which the flood came, so the
//! places form a cell of the lattice, connected, and without gaps or overlaps when repeated.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::agreement::{CellGrid, smoothed};
use crate::numeric::lattice::length;

/// Levels of height: differences below a sixteenth of the highest are noise.
const LEVELS: f64 = 16.0;
/// The reach of the smoothing that finds the middle of the element, as a fraction of the side of a cell.
const MIDDLE: f64 = 0.15;

/// For each place of the grid the cell to which its flood belongs, relative to the cell of the place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Outline {
    /// The offset for each place.
    pub owner: Vec<[i64; 2]>,
}

/// The outline along the lowest lines of a ground, whose heights are squared differences.
pub fn along_joints(grid: &CellGrid, height: &[f64]) -> Outline {
    let levels = levels(height);
    let start = middle(grid, height);
    let mut owner: Vec<Option<[i64; 2]>> = vec![None; height.len()];
    let mut waiting = BinaryHeap::new();
    waiting.push(Reverse((u32::MAX - levels[start], 0u64, start, [0i64; 2])));
    while let Some(Reverse((depth, distance, place, cell))) = waiting.pop() {
        if owner[place].is_some() {
            continue;
        }
        owner[place] = Some(cell.map(|c| -c));
        for (next, next_cell, step) in neighbours(grid, place, cell) {
            if owner[next].is_none() {
                let deeper = depth.max(u32::MAX - levels[next]);
                waiting.push(Reverse((deeper, distance + step, next, next_cell)));
            }
        }
    }
    Outline { owner: owner.into_iter().map(|cell| cell.expect("the flood reaches every place")).collect() }
}

/// Heights as whole levels.
fn levels(height: &[f64]) -> Vec<u32> {
    let mut sorted = height.to_vec();
    sorted.sort_by(f64::total_cmp);
    // The highest places may be single texels: the upper quartile is the height of the elements.
    let high = sorted[3 * sorted.len() / 4].sqrt();
    let level = |v: f64| if high > 0.0 { (LEVELS * v.sqrt() / high).min(LEVELS) as u32 } else { 0 };
    height.iter().map(|&v| level(v)).collect()
}

/// The place with the highest surroundings.
fn middle(grid: &CellGrid, height: &[f64]) -> usize {
    let widest = (MIDDLE * grid.size.width.min(grid.size.height) as f64).max(1.0);
    // Steps of 1, 2, 4 and so on widen the mean to about the last of them.
    let steps = std::iter::successors(Some(1usize), |step| Some(2 * step));
    let steps = steps.take_while(|&step| step as f64 <= widest);
    let wide = steps.fold(height.to_vec(), |values, step| smoothed(&values, grid.size, step));
    (0..wide.len()).max_by(|&a, &b| wide[a].total_cmp(&wide[b]).then(b.cmp(&a))).unwrap_or(0)
}

/// The eight places around one, each with its cell and its distance in hundredths of a texel.
fn neighbours(
    grid: &CellGrid,
    place: usize,
    cell: [i64; 2],
) -> impl Iterator<Item = (usize, [i64; 2], u64)> + '_ {
    let (width, height) = (grid.size.width as i64, grid.size.height as i64);
    let (x, y) = (place as i64 % width, place as i64 / width);
    let steps = (-1..=1).flat_map(|j| (-1..=1).map(move |i| (i, j))).filter(|&step| step != (0, 0));
    steps.map(move |(i, j)| {
        let (nx, ny) = (x + i, y + j);
        let next = grid.size.index(nx.rem_euclid(width) as usize, ny.rem_euclid(height) as usize);
        let next_cell = [cell[0] + nx.div_euclid(width), cell[1] + ny.div_euclid(height)];
        let step = grid.lattice.point([i as f64 / width as f64, j as f64 / height as f64]);
        (next, next_cell, (100.0 * length(step)).round().max(1.0) as u64)
    })
}

impl Outline {
    /// How many cells the outline reaches beyond the one in which its middle lies.
    pub fn reach(&self) -> i64 {
        self.owner.iter().flatten().map(|c| c.abs()).max().unwrap_or(0)
    }

    /// The mean height of the places beside another cell, as a fraction of the mean of all: near 0 where
    /// the border runs along joints, near 1 where there are none.
    pub fn joint_contrast(&self, grid: &CellGrid, height: &[f64]) -> f64 {
        let is_border = |&place: &usize| {
            neighbours(grid, place, [0, 0]).any(|(next, cell, _)| {
                let there = self.owner[next];
                [cell[0] + there[0], cell[1] + there[1]] != self.owner[place]
            })
        };
        let border: Vec<usize> = (0..height.len()).filter(is_border).collect();
        let mean = |sum: f64, count: usize| sum / count.max(1) as f64;
        let all = mean(height.iter().sum(), height.len());
        let along = mean(border.iter().map(|&place| height[place]).sum(), border.len());
        if all > 0.0 { along / all } else { 0.0 }
    }
}
