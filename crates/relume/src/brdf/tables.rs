//! Tables over the unit square for each of some incident directions: bilinear interpolation, and the inverse of the
//! warp that maps the uniform square to the density that a table describes (J. Dupuy, W. Jakob, "An Adaptive
//! Parameterization for Efficient Material Acquisition and Rendering", ACM Transactions on Graphics 37(6), 2018, and
//! its published implementation: a marginal over rows, then a conditional within rows).

use crate::error::{Error, Result};
use crate::job::Job;
use crate::memory;

/// The resolution of a table and the number of its slices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TableShape {
    /// Columns: nodes along the first coordinate.
    pub width: usize,
    /// Rows: nodes along the second coordinate.
    pub height: usize,
    /// One table for each incident direction, or one.
    pub slices: usize,
}

/// A slice and its weight, for the incident directions around one.
pub(super) type SliceWeights = [(usize, f64); 4];

/// The only slice of a table.
pub(super) const ONE_SLICE: SliceWeights = [(0, 1.0), (0, 0.0), (0, 0.0), (0, 0.0)];

impl TableShape {
    /// Values of a slice.
    pub fn slice(self) -> usize {
        self.width * self.height
    }

    pub(super) fn check(self, named: &str, values: &[f32]) -> Result<()> {
        let Self { width, height, slices } = self;
        let expected = width.checked_mul(height).and_then(|slice| slice.checked_mul(slices));
        if width < 2 || height < 2 || expected != Some(values.len()) {
            return Err(Error::invalid(format!(
                "the table '{named}' has {slices} slices of {width} x {height} and {} numbers: expected at least 2 x 2 \
                 and as many numbers",
                values.len()
            )));
        }
        match values.iter().position(|value| !value.is_finite()) {
            Some(i) => Err(Error::invalid(format!(
                "number {i} of the table '{named}' is not finite: the file is damaged"
            ))),
            None => Ok(()),
        }
    }

    /// The cell of a point of the unit square, and the place in it.
    fn cell(self, [x, y]: [f64; 2]) -> SquareCell {
        let along = |t: f64, nodes: usize| {
            let t = t.clamp(0.0, 1.0) * (nodes - 1) as f64;
            let node = (t as usize).min(nodes - 2);
            (node, t - node as f64)
        };
        let ((column, x), (row, y)) = (along(x, self.width), along(y, self.height));
        SquareCell { column, row, x, y }
    }
}

/// A cell between four nodes, and a place in it.
struct SquareCell {
    column: usize,
    row: usize,
    x: f64,
    y: f64,
}

impl SquareCell {
    fn index(&self, shape: TableShape) -> usize {
        self.column + shape.width * self.row
    }
}

/// The mixture of slices of `size` numbers, at number `i` of each.
fn mixed(table: &[f32], size: usize, slices: &SliceWeights, i: usize) -> f64 {
    slices.iter().map(|&(slice, weight)| weight * f64::from(table[slice * size + i])).sum()
}

/// The bilinear interpolation of a table at a point of the unit square.
pub(super) fn bilinear(table: &[f32], shape: TableShape, slices: &SliceWeights, point: [f64; 2]) -> f64 {
    let cell = shape.cell(point);
    let (index, size) = (cell.index(shape), shape.slice());
    let row = |index: usize| {
        (1.0 - cell.x) * mixed(table, size, slices, index) + cell.x * mixed(table, size, slices, index + 1)
    };
    (1.0 - cell.y) * row(index) + cell.y * row(index + shape.width)
}

/// Densities over the unit square with their integrals.
#[derive(Debug, Clone, PartialEq)]
pub struct WarpTables {
    shape: TableShape,
    /// The densities, each slice with the integral 1 over cells of side 1.
    densities: Vec<f32>,
    /// Within each row, the integral up to each node.
    conditional: Vec<f32>,
    /// The integral up to each row.
    marginal: Vec<f32>,
}

impl WarpTables {
    /// The warps to densities that need not have the integral 1, slice after slice, row after row.
    ///
    /// # Errors
    /// Numbers that are negative, not finite, or not as many as the shape says; a slice of zeros; limits.
    pub fn new(named: &str, shape: TableShape, mut densities: Vec<f32>, job: &Job) -> Result<Self> {
        shape.check(named, &densities)?;
        if let Some(i) = densities.iter().position(|&density| density < 0.0) {
            return Err(Error::invalid(format!(
                "number {i} of the table '{named}' is negative: the file is damaged"
            )));
        }
        job.check_bytes("the warps of the BRDF", 8 * densities.len() as u64)?;
        let mut conditional = memory::zeros("the warps of the BRDF", densities.len())?;
        let mut marginal = memory::zeros("the warps of the BRDF", shape.slices * shape.height)?;
        for slice in 0..shape.slices {
            let range = slice * shape.slice()..(slice + 1) * shape.slice();
            let (densities, conditional) = (&mut densities[range.clone()], &mut conditional[range]);
            let marginal = &mut marginal[slice * shape.height..][..shape.height];
            let total = integrate(densities, shape, conditional, marginal);
            if total <= 0.0 {
                return Err(Error::invalid(format!(
                    "slice {slice} of the table '{named}' has no number above 0: the file is damaged"
                )));
            }
            for values in [densities, conditional, marginal] {
                values.iter_mut().for_each(|value| *value = (f64::from(*value) / total) as f32);
            }
        }
        Ok(Self { shape, densities, conditional, marginal })
    }

    pub(super) fn slices(&self) -> usize {
        self.shape.slices
    }

    /// The point of the uniform square that the warp maps to a point.
    pub(super) fn invert(&self, slices: &SliceWeights, point: [f64; 2]) -> [f64; 2] {
        let (shape, size) = (self.shape, self.shape.slice());
        let cell = shape.cell(point);
        let between = |a: f64, b: f64| (1.0 - cell.y) * a + cell.y * b;
        let index = cell.index(shape);
        let across = |table: &[f32], i: usize| {
            between(mixed(table, size, slices, i), mixed(table, size, slices, i + shape.width))
        };
        // Along the row: the integral up to the node before, and from there.
        let (left, right) = (across(&self.densities, index), across(&self.densities, index + 1));
        let x = across(&self.conditional, index) + cell.x * (left + 0.5 * cell.x * (right - left));
        // Rows up to this one, and from there.
        let end = (cell.row + 1) * shape.width - 1;
        let above = mixed(&self.conditional, size, slices, end);
        let below = mixed(&self.conditional, size, slices, end + shape.width);
        let y = mixed(&self.marginal, shape.height, slices, cell.row)
            + cell.y * (above + 0.5 * cell.y * (below - above));
        let whole = between(above, below);
        [if whole > 0.0 { x / whole } else { 0.0 }, y]
    }
}

/// The integrals within rows and over rows, and that over all.
fn integrate(densities: &[f32], shape: TableShape, conditional: &mut [f32], marginal: &mut [f32]) -> f64 {
    let running = |values: &mut dyn Iterator<Item = f64>, out: &mut [f32]| {
        let (mut sum, mut before) = (0.0, None);
        for (value, out) in values.zip(out) {
            sum += before.map_or(0.0, |before: f64| 0.5 * (before + value));
            before = Some(value);
            *out = sum as f32;
        }
        sum
    };
    let mut sums = Vec::with_capacity(shape.height);
    for (row, out) in densities.chunks_exact(shape.width).zip(conditional.chunks_exact_mut(shape.width)) {
        sums.push(running(&mut row.iter().map(|&density| f64::from(density)), out));
    }
    running(&mut sums.into_iter(), marginal)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bumpy(shape: TableShape) -> Vec<f32> {
        (0..shape.slice() * shape.slices).map(|i| 0.2 + ((i * 37) % 11) as f32 / 5.0).collect()
    }

    /// The density of the warped points, by the definition: areas of the uniform square are integrals.
    #[test]
    fn the_inverse_warp_measures_the_integral_of_the_density() {
        let shape = TableShape { width: 4, height: 5, slices: 2 };
        let values = bumpy(shape);
        let warp = WarpTables::new("test", shape, values.clone(), &Job::default()).unwrap();
        let second: SliceWeights = [(1, 1.0), (0, 0.0), (0, 0.0), (0, 0.0)];
        let density = |x: f64, y: f64| bilinear(&values, shape, &second, [x, y]);
        // Sums over the middles of fine cells.
        let integral = |x: f64, y: f64| {
            let steps = 240;
            let at = |i: usize, end: f64| (i as f64 + 0.5) / steps as f64 * end;
            let sum: f64 = (0..steps * steps).map(|i| density(at(i % steps, x), at(i / steps, y))).sum();
            sum * x * y / (steps * steps) as f64
        };
        let row =
            |x: f64, y: f64| (0..4000).map(|i| density((i as f64 + 0.5) / 4000.0 * x, y)).sum::<f64>() * x;
        let whole = integral(1.0, 1.0);
        for (x, y) in [(0.2, 0.3), (0.77, 0.9), (0.5, 0.5), (1.0, 1.0), (0.0, 0.6)] {
            let [u, v] = warp.invert(&second, [x, y]);
            assert!((v - integral(1.0, y) / whole).abs() < 1e-4, "{x} {y}: {v}");
            assert!((u - row(x, y) / row(1.0, y)).abs() < 1e-4, "{x} {y}: {u}");
        }
    }

    #[test]
    fn tables_that_are_no_densities_are_refused() {
        let shape = TableShape { width: 2, height: 2, slices: 1 };
        let message = |values: &[f32]| {
            WarpTables::new("test", shape, values.to_vec(), &Job::default()).unwrap_err().to_string()
        };
        assert!(message(&[1.0, -1.0, 1.0, 1.0]).contains("number 1 of the table 'test' is negative"));
        assert!(message(&[0.0; 4]).contains("slice 0"));
        assert!(message(&[1.0, 1.0, f32::NAN, 1.0]).contains("number 2"));
        assert!(message(&[1.0; 3]).contains("3 numbers"));
        let thin = TableShape { width: 1, height: 4, slices: 1 };
        assert!(WarpTables::new("test", thin, vec![1.0; 4], &Job::default()).is_err());
    }
}
