//! The elements that an exemplar shows whole.

use super::agreement::{CellGrid, texel_at};
use super::outline::Outline;
use crate::size::Size;

/// The largest part of an element that may lie outside of the exemplar, by its height: the remains of a
/// joint, and no stone.
const MOST_MISSING: f64 = 0.03;

/// The elements whose texels lie in the exemplar, in the order of their cells.
pub fn elements(
    size: Size,
    excluded: Option<&[bool]>,
    grid: &CellGrid,
    outline: &Outline,
    height: &[f64],
) -> Vec<[i64; 2]> {
    let is_usable = |position: [f64; 2]| {
        let texel = texel_at(size, position);
        texel.is_some_and(|(x, y)| excluded.is_none_or(|mask| !mask[size.index(x, y)]))
    };
    let total: f64 = height.iter().sum();
    let missing = |cell: [i64; 2]| -> f64 {
        let outside = |&place: &usize| {
            let owner = outline.owner[place];
            !is_usable(grid.position(place, [cell[0] - owner[0], cell[1] - owner[1]]))
        };
        (0..height.len()).filter(outside).map(|place| height[place]).sum()
    };
    let all = grid.cells_over(size, outline.reach()).into_iter();
    all.filter(|&cell| missing(cell) <= MOST_MISSING * total).collect()
}
