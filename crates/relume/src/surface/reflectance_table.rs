//! A reflectance relative to a matt one, as a table of medians over two cosines.
//!
//! Medians over all orientations let shadows and highlights of some texels pass, and follow gloss that a polynomial does
//! not find from far away ([`super::shared_reflectance`]).

use super::bipolynomial::ShadedValue;

/// Cells of the table along each cosine.
const CELLS: usize = 24;
/// The fewest values whose median a cell takes.
const FEWEST: usize = 30;

/// The function at the middles of the cells, n . l first.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ReflectanceTable {
    cells: Vec<f64>,
}

impl ReflectanceTable {
    /// The medians of many values.
    pub fn of(values: &[ShadedValue]) -> Self {
        let mut ratios = vec![Vec::new(); CELLS * CELLS];
        let cell = |cosine: f64| ((cosine * CELLS as f64) as usize).min(CELLS - 1);
        for at in values {
            ratios[cell(at.to_light) * CELLS + cell(at.to_half)].push(at.value / at.to_light);
        }
        let median = |mut all: Vec<f64>| {
            let middle = all.len() / 2;
            (all.len() >= FEWEST).then(|| *all.select_nth_unstable_by(middle, f64::total_cmp).1)
        };
        let known: Vec<Option<f64>> = ratios.into_iter().map(median).collect();
        Self { cells: blurred(&filled(&known)) }
    }

    /// The bilinear interpolation between the middles of the cells.
    pub fn at(&self, to_light: f64, to_half: f64) -> f64 {
        let place = |cosine: f64| {
            let at = (cosine * CELLS as f64 - 0.5).clamp(0.0, (CELLS - 1) as f64);
            let low = (at as usize).min(CELLS - 2);
            (low, at - low as f64)
        };
        let ((i, s), (j, t)) = (place(to_light), place(to_half));
        let cell = |di: usize, dj: usize| self.cells[(i + di) * CELLS + j + dj];
        (1.0 - s) * ((1.0 - t) * cell(0, 0) + t * cell(0, 1)) + s * ((1.0 - t) * cell(1, 0) + t * cell(1, 1))
    }
}

/// Empty cells take the value of the nearest one that is known.
fn filled(known: &[Option<f64>]) -> Vec<f64> {
    let places: Vec<usize> = (0..known.len()).filter(|&cell| known[cell].is_some()).collect();
    let squared = |a: usize, b: usize| {
        let (i, j) = ((a / CELLS).abs_diff(b / CELLS), (a % CELLS).abs_diff(b % CELLS));
        i * i + j * j
    };
    let value = |cell: usize| {
        let nearest = places.iter().min_by_key(|&&place| (squared(cell, place), place));
        nearest.and_then(|&place| known[place]).unwrap_or(1.0)
    };
    (0..known.len()).map(value).collect()
}

/// A Gaussian blur of one cell, borders repeated.
fn blurred(cells: &[f64]) -> Vec<f64> {
    let weights: Vec<f64> = (-3i32..=3).map(|d| (-0.5 * f64::from(d * d)).exp()).collect();
    let sum: f64 = weights.iter().sum();
    let along = |cells: &[f64], step: usize| -> Vec<f64> {
        let at = |cell: usize| {
            let position = (cell / step % CELLS) as i32;
            let start = cell - position as usize * step;
            let value = |d: i32| cells[start + (position + d).clamp(0, CELLS as i32 - 1) as usize * step];
            (-3..=3).zip(&weights).map(|(d, w)| w * value(d)).sum::<f64>() / sum
        };
        (0..cells.len()).map(at).collect()
    };
    along(&along(cells, 1), CELLS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_medians_and_others_take_the_nearest() {
        let at = |to_light: f64, ratio: f64| ShadedValue { to_light, to_half: 0.5, value: ratio * to_light };
        let values: Vec<ShadedValue> =
            (0..200).flat_map(|i| [at(0.2, if i % 3 == 0 { 9.0 } else { 2.0 }), at(0.9, 0.5)]).collect();
        let table = ReflectanceTable::of(&values);
        assert!((table.at(0.2, 0.5) - 2.0).abs() < 0.05 && (table.at(0.9, 0.5) - 0.5).abs() < 0.05);
        assert!((table.at(0.05, 0.9) - 2.0).abs() < 0.05, "{}", table.at(0.05, 0.9));
        assert_eq!(ReflectanceTable::of(&[]).at(0.3, 0.3), 1.0);
    }
}
