//! Homogeneity of a texture: statistics of blocks, and their drift across the picture.
//!
//! For each block of a grid two numbers are measured: the contrast, its root mean square value, and the
//! frequency, the share of neighbours on different sides of the mean of the block (S. O. Rice, Mathematical
//! analysis of random noise, 1944, on the rate of zeros). Magnified by m, a texture has 1 / m times as many
//! of these crossings per texel, whatever its spectrum and edges, so their drift is that of the scale, that
//! is, perspective. Planes fitted to the logarithms by least squares give the drift from one side to the
//! other, and its standard error. Blocks hold several features each, so that they are nearly independent;
//! fine noise is averaged away first, by halving the resolution until features are a few texels large.

use serde::Serialize;

use crate::planes::Planes;
use crate::size::Size;

/// The most and the fewest blocks along a side.
const GRID: (usize, usize) = (8, 3);
/// The least width of a block, in features.
const FEATURES: f64 = 1.5;
/// Features are reduced to at most this many texels.
const FINEST: f64 = 10.0;
/// A drift is significant from this factor on, and from this many standard errors.
const PLAIN: (f64, f64) = (1.2, 4.5);

/// A change across the picture.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Drift {
    /// The value at the right (lower) border divided by that at the left (upper) one.
    pub factor: f64,
    /// Its logarithm in standard errors.
    pub errors: f64,
}

impl Drift {
    const NONE: Self = Self { factor: 1.0, errors: 0.0 };

    /// Whether it is large, and larger than expected by chance.
    pub fn is_plain(&self) -> bool {
        self.factor.ln().abs() >= PLAIN.0.ln() && self.errors.abs() >= PLAIN.1
    }
}

/// The drifts of scale and of contrast, each along x and y; no drift where the picture holds too few
/// features.
pub fn drifts(planes: &Planes, feature: Option<f64>) -> [[Drift; 2]; 2] {
    let Some(mut feature) = feature else { return [[Drift::NONE; 2]; 2] };
    let mut planes = planes.clone();
    while feature > FINEST && planes.size().width.min(planes.size().height) >= 48 {
        planes = halved(&planes);
        feature /= 2.0;
    }
    let shortest = planes.size().width.min(planes.size().height) as f64;
    let grid = ((shortest / (FEATURES * feature).max(4.0)) as usize).min(GRID.0);
    if grid < GRID.1 {
        return [[Drift::NONE; 2]; 2];
    }
    let blocks = (0..grid * grid).map(|i| MeasuredBlock::of(&planes, grid, i % grid, i / grid));
    let Some(blocks) = blocks.collect::<Option<Vec<_>>>() else { return [[Drift::NONE; 2]; 2] };
    let scale: Vec<f64> = blocks.iter().map(|b| -b.frequency.ln()).collect();
    let contrast: Vec<f64> = blocks.iter().map(|b| b.contrast.ln()).collect();
    [scale, contrast].map(|values| fitted(&values, grid))
}

struct MeasuredBlock {
    contrast: f64,
    frequency: f64,
}

impl MeasuredBlock {
    /// The block in column i and row j; `None` where it has no contrast.
    fn of(planes: &Planes, grid: usize, i: usize, j: usize) -> Option<Self> {
        let size = planes.size();
        let bounds = |k: usize, side: usize| (k * side / grid, (k + 1) * side / grid);
        let ((left, right), (top, bottom)) = (bounds(i, size.width), bounds(j, size.height));
        let count = ((right - left) * (bottom - top)) as f64;
        let (mut squares, mut crossings) = (0.0, 0.0);
        for plane in planes.iter() {
            let at = |x: usize, y: usize| f64::from(plane[size.index(x, y)]);
            let places = || (top..bottom).flat_map(|y| (left..right).map(move |x| (x, y)));
            let mean = places().map(|(x, y)| at(x, y)).sum::<f64>() / count;
            let variance = places().map(|(x, y)| (at(x, y) - mean).powi(2)).sum::<f64>() / count;
            let above = |x: usize, y: usize| at(x, y) > mean;
            let inner = places().filter(|(x, y)| x + 1 < right && y + 1 < bottom);
            let crossed = |(x, y)| {
                let here = above(x, y);
                u32::from(above(x + 1, y) != here) + u32::from(above(x, y + 1) != here)
            };
            squares += variance;
            crossings += variance * f64::from(inner.map(crossed).sum::<u32>());
        }
        let (contrast, frequency) = (squares.sqrt(), crossings / (squares * count));
        (contrast > 0.0 && frequency > 0.0).then_some(Self { contrast, frequency })
    }
}

/// The drifts along x and y of the logarithms on a grid: a plane fitted by least squares.
fn fitted(values: &[f64], grid: usize) -> [Drift; 2] {
    let place = |k: usize| (2 * k + 1) as f64 / grid as f64 - 1.0;
    let (x, y) = (|i: usize| place(i % grid), |i: usize| place(i / grid));
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    // Columns and rows are orthogonal on a grid, and have the same sum of squares.
    let squares: f64 = (0..values.len()).map(|i| x(i).powi(2)).sum();
    let slope =
        |at: &dyn Fn(usize) -> f64| values.iter().enumerate().map(|(i, v)| at(i) * v).sum::<f64>() / squares;
    let slopes = [slope(&x), slope(&y)];
    let rest: f64 = values
        .iter()
        .enumerate()
        .map(|(i, v)| (v - mean - slopes[0] * x(i) - slopes[1] * y(i)).powi(2))
        .sum();
    let error = (rest / (count - 3.0) / squares).sqrt().max(1e-9);
    slopes.map(|slope| Drift { factor: (2.0 * slope).exp(), errors: slope / error })
}

/// Means of two by two texels; an odd last row or column is left out.
pub(super) fn halved(planes: &Planes) -> Planes {
    let (from, to) = (planes.size(), Size::new(planes.size().width / 2, planes.size().height / 2));
    let mut out = Planes::zeros(to, planes.count());
    for (plane, half) in planes.iter().zip(out.iter_mut()) {
        for (i, value) in half.iter_mut().enumerate() {
            let (x, y) = (2 * (i % to.width), 2 * (i / to.width));
            let at = |dx: usize, dy: usize| plane[from.index(x + dx, y + dy)];
            *value = 0.25 * (at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1));
        }
    }
    out
}
