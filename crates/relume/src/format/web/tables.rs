//! The types `rbf` and `bilinear`: colours are a mean and weighted sums of tables over directions (principal
//! components of the photographs). Between the entries of the tables the types interpolate in their own ways; here the
//! functions are taken at directions spread evenly, and are interpolated between these.

use super::info::{WebColor, WebInfo, WebKind};
use crate::direction::{Direction, Directions};
use crate::error::{Error, Result};
use crate::field::Learned;
use crate::numeric::Matrix;

/// The directions at which functions are taken. The mean distance of neighbours is 4 degrees.
const DIRECTIONS: usize = 1200;

/// Weights of Gaussians below this count nothing, as in RelightLab.
const LEAST_WEIGHT: f64 = 0.001;

/// Functions that are shorter than this in the others' presence say nothing.
const LEAST_LENGTH: f64 = 1e-9;

/// Tables of colours over the entries of a type: the mean first, then one for each coefficient.
pub(super) struct Tables<'a> {
    info: &'a WebInfo,
    /// The entries of a table.
    entries: usize,
}

impl<'a> Tables<'a> {
    pub(super) fn of(info: &'a WebInfo) -> Result<Self> {
        let entries = match info.kind {
            WebKind::Bilinear(resolution) => resolution * resolution,
            _ => info.lights.len(),
        };
        let expected = (info.planes + 1) * entries * 3;
        if entries == 0 || info.basis.len() < expected {
            return Err(Error::invalid(format!(
                "the entry 'basis' of info.json has {} numbers: expected {expected}, of {} tables of {entries} colours",
                info.basis.len(),
                info.planes + 1
            )));
        }
        if let Some(k) = info.range.iter().position(|range| *range == 0.0) {
            return Err(Error::invalid(format!(
                "range {k} of info.json is zero: the table {} has no scale",
                k + 1
            )));
        }
        Ok(Self { info, entries })
    }

    /// Red, green and blue of a table at an entry, before the colours of `mycc` are converted.
    fn at(&self, table: usize, entry: usize) -> [f64; 3] {
        std::array::from_fn(|c| {
            let byte = f64::from(self.info.basis[(table * self.entries + entry) * 3 + c]);
            if table == 0 { byte / 255.0 } else { (byte - 127.0) / self.info.range[table - 1] }
        })
    }

    /// The entries that count for a direction, with their weights.
    fn shares(&self, light: Direction) -> Vec<(usize, f64)> {
        match self.info.kind {
            WebKind::Bilinear(resolution) => bilinear(resolution, light),
            WebKind::Rbf(sigma) => gaussians(&self.info.lights, sigma, light),
            _ => Vec::new(),
        }
    }

    /// The colours of the mean and of each coefficient under a light.
    pub(super) fn colors(&self, light: Direction) -> Vec<[f64; 3]> {
        let shares = self.shares(light);
        let sum = |table: usize| {
            shares.iter().fold([0.0; 3], |sum, &(entry, share)| {
                let color = self.at(table, entry);
                std::array::from_fn(|c| sum[c] + share * color[c])
            })
        };
        (0..=self.info.planes).map(|table| self.in_rgb(table, sum(table))).collect()
    }

    fn in_rgb(&self, table: usize, color: [f64; 3]) -> [f64; 3] {
        let WebColor::Mycc(triples) = self.info.color else { return color };
        let to_rgb = |[luma, first, second]: [f64; 3]| {
            let blue = luma - second / 2.0 - first / 2.0;
            [blue + first, luma + second / 2.0, blue]
        };
        match table.checked_sub(1) {
            None => to_rgb(color),
            // A coefficient of a triple weighs one of luma and chroma.
            Some(k) if k / 3 < triples => {
                let mut only = [0.0; 3];
                only[k % 3] = color[k % 3];
                to_rgb(only)
            }
            Some(_) => to_rgb([color[0], 0.0, 0.0]),
        }
    }
}

/// Bilinear shares on the grid over the octahedron, turned by 45 degrees.
fn bilinear(resolution: usize, light: Direction) -> Vec<(usize, f64)> {
    let [x, y, z] = light.to_array();
    let length = x.abs() + y.abs() + z.abs();
    let place = |v: f64| (v / length + 1.0) / 2.0 * (resolution as f64 - 1.0);
    let (across, down) = (place(x + y), place(y - x));
    let cell = |v: f64| (v.floor().max(0.0) as usize).min(resolution - 2);
    let (left, top) = (cell(across), cell(down));
    let (dx, dy) = (across - left as f64, down - top as f64);
    let at = |i: usize, k: usize| (left + i) + (top + k) * resolution;
    vec![
        (at(0, 0), (1.0 - dx) * (1.0 - dy)),
        (at(1, 0), dx * (1.0 - dy)),
        (at(0, 1), (1.0 - dx) * dy),
        (at(1, 1), dx * dy),
    ]
}

/// Normalised Gaussians of the distance to each light, as RelightLab has them.
fn gaussians(lights: &[[f64; 3]], sigma: f64, light: Direction) -> Vec<(usize, f64)> {
    let to = light.to_array();
    let weight = |from: &[f64; 3]| {
        let squared: f64 = (0..3).map(|i| (from[i] - to[i]).powi(2)).sum();
        (-squared / (sigma * sigma)).exp()
    };
    let all: Vec<(usize, f64)> = lights.iter().map(weight).enumerate().collect();
    let total: f64 = all.iter().map(|(_, weight)| weight).sum();
    let nearest = || {
        let nearest = all.iter().max_by(|a, b| a.1.total_cmp(&b.1));
        vec![(nearest.map_or(0, |(i, _)| *i), 1.0)]
    };
    if total < 1e-300 {
        return nearest();
    }
    let kept: Vec<(usize, f64)> = all.iter().copied().filter(|(_, w)| w / total > LEAST_WEIGHT).collect();
    let total: f64 = kept.iter().map(|(_, weight)| weight).sum();
    if kept.is_empty() { nearest() } else { kept.into_iter().map(|(i, w)| (i, w / total)).collect() }
}

/// The functions at even directions, made orthonormal; and the matrix that gives their coefficients from 1 and those
/// of the folder.
pub(super) fn learned(tables: &Tables<'_>) -> Result<(Learned, Matrix)> {
    let direction = Direction::fibonacci(DIRECTIONS);
    let weight = std::f64::consts::TAU / DIRECTIONS as f64;
    let rows: Vec<Vec<[f64; 3]>> = (0..DIRECTIONS).map(|i| tables.colors(direction(i))).collect();
    let count = rows[0].len();
    let product = |j: usize, k: usize| {
        let of = |row: &Vec<[f64; 3]>| (0..3).map(|c| row[j][c] * row[k][c]).sum::<f64>();
        weight * rows.iter().map(of).sum::<f64>()
    };
    let mut gram = Matrix::zeros(count, count);
    for (j, k) in (0..count).flat_map(|j| (0..=j).map(move |k| (j, k))) {
        gram.row_mut(j)[k] = product(j, k);
        gram.row_mut(k)[j] = gram[(j, k)];
    }
    // Tables that are combinations of others get a length of their own, which their coefficients never see.
    let largest = (0..count).map(|k| gram[(k, k)]).fold(0.0, f64::max);
    (0..count).for_each(|k| gram.row_mut(k)[k] += LEAST_LENGTH * largest.max(1e-12));
    let factor = gram.cholesky()?;
    let inverse = factor.lower_inverse();
    let mut values = Vec::with_capacity(DIRECTIONS * 3 * count);
    for row in &rows {
        let value = |c: usize, k: usize| (0..=k).map(|j| inverse[(k, j)] * row[j][c]).sum::<f64>() as f32;
        values.extend((0..3 * count).map(|i| value(i / count, i % count)));
    }
    let pairs = (0..DIRECTIONS).map(|i| Directions::lit_from(direction(i))).collect();
    let learned = Learned::of_channels(3, pairs, vec![weight; DIRECTIONS], values)?;
    Ok((learned, factor.transposed()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_of_both_kinds_sum_to_one() {
        let lights = [[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [0.0, -0.8, 0.6]];
        for i in 0..50 {
            let light = Direction::fibonacci(50)(i);
            for shares in [bilinear(8, light), gaussians(&lights, 0.3, light)] {
                assert!((shares.iter().map(|(_, s)| s).sum::<f64>() - 1.0).abs() < 1e-12);
                assert!(shares.iter().all(|(_, s)| *s >= -1e-12));
            }
        }
    }
}
