//! Which element each cell of the output shows: a random one, unlike those around it where there are enough.

use std::collections::BTreeMap;

use crate::numeric::random::{Purpose, Stream};

/// The elements of the cells of an output.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ElementOrder {
    choices: BTreeMap<[i64; 2], usize>,
    /// The periods of the arrangement in cells, if the output tiles.
    sides: Option<[[i64; 2]; 2]>,
}

impl ElementOrder {
    /// Arranges `count` elements in cells, one after another: those that fewest of the eight cells around
    /// show, the four sides first, are drawn from.
    pub fn new(cells: &[[i64; 2]], count: usize, sides: Option<[[i64; 2]; 2]>, seed: u64) -> Self {
        let mut made = Self { choices: BTreeMap::new(), sides };
        for &cell in cells {
            let cell = made.canonical(cell);
            if !made.choices.contains_key(&cell) {
                let choice = made.drawn(cell, count, seed);
                made.choices.insert(cell, choice);
            }
        }
        made
    }

    /// The element of a cell.
    ///
    /// # Panics
    /// When the cell was not arranged.
    pub fn element(&self, cell: [i64; 2]) -> usize {
        self.choices[&self.canonical(cell)]
    }

    fn drawn(&self, cell: [i64; 2], count: usize, seed: u64) -> usize {
        // A side weighs more than the four corners together.
        let mut seen = vec![0u32; count];
        for (i, j) in (-1..=1).flat_map(|j| (-1..=1).map(move |i| (i, j))) {
            let near = self.canonical([cell[0] + i, cell[1] + j]);
            if let Some(&element) = self.choices.get(&near) {
                seen[element] += if i == 0 || j == 0 { 5 } else { 1 };
            }
        }
        let least = seen.iter().min().copied().unwrap_or(0);
        let fewest: Vec<usize> = (0..count).filter(|&element| seen[element] == least).collect();
        let place = cell.map(|c| c as u64);
        fewest[Stream::new(seed, Purpose::Elements, place).below(fewest.len())]
    }

    /// The same cell among those of one period.
    fn canonical(&self, cell: [i64; 2]) -> [i64; 2] {
        let Some([u, v]) = self.sides else { return cell };
        let cross = |a: [i64; 2], b: [i64; 2]| a[0] * b[1] - a[1] * b[0];
        let whole = cross(u, v);
        let (i, j) = (floor(cross(cell, v), whole), floor(cross(u, cell), whole));
        [cell[0] - i * u[0] - j * v[0], cell[1] - i * u[1] - j * v[1]]
    }
}

/// The largest integer that is at most a / b.
fn floor(a: i64, b: i64) -> i64 {
    if b < 0 { (-a).div_euclid(-b) } else { a.div_euclid(b) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cells(width: i64, height: i64) -> Vec<[i64; 2]> {
        (0..height).flat_map(|j| (0..width).map(move |i| [i, j])).collect()
    }

    #[test]
    fn sides_of_neighbours_differ_from_four_elements_on() {
        for seed in 0..20 {
            let made = ElementOrder::new(&cells(9, 7), 4, None, seed);
            for [i, j] in cells(8, 6) {
                assert_ne!(made.element([i, j]), made.element([i + 1, j]), "seed {seed}");
                assert_ne!(made.element([i, j]), made.element([i, j + 1]), "seed {seed}");
            }
            let shown = |element| cells(9, 7).into_iter().filter(|&c| made.element(c) == element).count();
            assert!((0..4).all(|element| shown(element) > 5), "seed {seed}: all are laid");
        }
    }

    #[test]
    fn a_tiling_arrangement_repeats_after_its_sides() {
        let sides = [[3, 1], [-1, 4]];
        let made = ElementOrder::new(&cells(12, 12), 5, Some(sides), 3);
        for [i, j] in cells(8, 7) {
            for [u, v] in sides {
                if i + u >= 0 {
                    assert_eq!(made.element([i, j]), made.element([i + u, j + v]));
                }
            }
        }
        assert_eq!(made.choices.len(), 13);
    }

    #[test]
    fn a_single_element_is_laid_everywhere() {
        let made = ElementOrder::new(&cells(3, 3), 1, None, 0);
        assert!(cells(3, 3).into_iter().all(|cell| made.element(cell) == 0));
    }
}
