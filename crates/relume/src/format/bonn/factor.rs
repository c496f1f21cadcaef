//! A factored matrix of a `.btf` file: the value at a row and a column is the product of a row of U and a row of S
//! V, each of some components.

use super::BtfScalar;
use super::source::BtfCursor;
use crate::error::{Error, Result};
use crate::job::Held;
use crate::numeric::dot;
use crate::parallel;

/// U and S V with one row of components for each row and column of the matrix.
#[derive(Debug)]
pub(super) struct FactorMatrix {
    pub(super) scalar: BtfScalar,
    pub(super) components: usize,
    pub(super) rows: usize,
    pub(super) columns: usize,
    pub(super) singular: Vec<f32>,
    pub(super) u: Vec<f32>,
    pub(super) sxv: Vec<f32>,
    _held: Held,
}

impl FactorMatrix {
    /// Reads the size of a scalar, the numbers of components, rows and columns, and the three matrices; `named`
    /// names it in messages.
    pub(super) fn read(cursor: &mut BtfCursor, named: &str) -> Result<Self> {
        let scalar = BtfScalar::of_size(cursor.u8(named)?, named)?;
        let components = u64::from(cursor.u32(named)?);
        let (rows, columns) = (u64::from(cursor.u32(named)?), u64::from(cursor.u32(named)?));
        if components == 0 || components > rows.max(columns) {
            return Err(Error::invalid(format!(
                "{named} in the BTF file has {components} components and {rows} x {columns} values: expected 1 to {}",
                rows.max(columns)
            )));
        }
        // 32-bit numbers: neither the sum nor the product overflows.
        let numbers = (rows + columns + 1).saturating_mul(components);
        cursor.expect(named, numbers.saturating_mul(scalar.bytes()))?;
        let held = cursor.job().hold(named, numbers.saturating_mul(4))?;
        let mut matrix = |what: &str, count| cursor.numbers(&format!("{what} of {named}"), count, scalar);
        Ok(Self {
            scalar,
            singular: matrix("S", components)?,
            u: matrix("U", rows * components)?,
            sxv: matrix("SxV", columns * components)?,
            components: components as usize,
            rows: rows as usize,
            columns: columns as usize,
            _held: held,
        })
    }

    /// The components of a row of the matrix.
    pub(super) fn row(&self, row: usize) -> &[f32] {
        &self.u[row * self.components..][..self.components]
    }

    /// The components of a column of the matrix.
    pub(super) fn column(&self, column: usize) -> &[f32] {
        &self.sxv[column * self.components..][..self.components]
    }

    /// The matrix in its row `row`, for all columns.
    pub(super) fn along_row(&self, row: usize, out: &mut [f32]) {
        products(self.row(row), &self.sxv, self.components, out);
    }

    /// The matrix in its column `column`, for rows `first`, `first + step` and so on.
    pub(super) fn along_column(&self, column: usize, first: usize, step: usize, out: &mut [f32]) {
        let from = &self.u[first * self.components..];
        products(self.column(column), from, step * self.components, out);
    }
}

/// Texels in one piece of parallel work.
const PIECE: usize = 1 << 12;

/// The products of `weights` with the rows of `matrix` that begin at multiples of `stride`.
pub(super) fn products(weights: &[f32], matrix: &[f32], stride: usize, out: &mut [f32]) {
    parallel::for_each(out.chunks_mut(PIECE).enumerate(), |(piece, out)| {
        for (i, value) in out.iter_mut().enumerate() {
            *value = dot(weights, &matrix[(piece * PIECE + i) * stride..][..weights.len()]);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_are_those_of_the_sums_in_order() {
        let value = |i: usize| ((i * 37) % 101) as f32 / 16.0 - 3.0;
        for components in [1, 7, 8, 9, 31] {
            let weights: Vec<f32> = (0..components).map(value).collect();
            let stride = components + 3;
            let matrix: Vec<f32> = (0..stride * (PIECE + 5)).map(|i| value(i + 11)).collect();
            let mut out = vec![0.0; PIECE + 5];
            products(&weights, &matrix, stride, &mut out);
            for (row, found) in out.iter().enumerate() {
                let truth: f64 = (0..components)
                    .map(|k| f64::from(weights[k]) * f64::from(matrix[row * stride + k]))
                    .sum();
                assert!((f64::from(*found) - truth).abs() < 1e-3, "{components} {row}");
            }
        }
    }
}
