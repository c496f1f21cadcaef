//! Weighted sums of rows of texels, added to planes: the kernel of every fit.
//!
//! The sums of six planes are kept in registers while the rows pass. The sum of each texel is a chain of plain
//! multiplications and additions in the order of the rows, so the result depends neither on threads nor, without
//! fused operations, on the vector width.

use pulp::{Arch, Simd, WithSimd};

use super::stream::BATCH;

/// Texels per band.
pub(super) const BAND: usize = 1024;

/// Planes whose sums share the registers: with the sample and a weight, eight of the sixteen registers that
/// every x86-64 has.
pub(super) const FUNCTIONS: usize = 6;

/// planes_k += sum_i share(k, i) row_i, six functions at once or one after another.
pub(super) fn add_products(
    arch: Arch,
    planes: &mut [&mut [f32]],
    rows: &[f32],
    share: impl Fn(usize, usize) -> f32,
) {
    if let Ok(sums) = <&mut [&mut [f32]; FUNCTIONS]>::try_from(&mut *planes) {
        let shares = rows.chunks(BAND).enumerate().map(|(i, _)| std::array::from_fn(|k| share(k, i)));
        return arch.dispatch(Products { sums, rows, shares: &shares.collect::<Vec<_>>() });
    }
    for (k, plane) in planes.iter_mut().enumerate() {
        let shares = rows.chunks(BAND).enumerate().map(|(i, _)| [share(k, i)]);
        let sums = std::array::from_mut(plane);
        arch.dispatch(Products { sums, rows, shares: &shares.collect::<Vec<_>>() });
    }
}

/// sums_k += sum_i shares_i_k row_i, with one row of [`BAND`] samples per photograph.
struct Products<'a, 'b, const K: usize> {
    sums: &'a mut [&'b mut [f32]; K],
    rows: &'a [f32],
    shares: &'a [[f32; K]],
}

impl<const K: usize> WithSimd for Products<'_, '_, K> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let texels = self.sums[0].len();
        let mut rows: [(&[S::f32s], &[f32]); BATCH] = [(&[], &[]); BATCH];
        for (row, samples) in rows.iter_mut().zip(self.rows.chunks_exact(BAND)) {
            *row = S::as_simd_f32s(&samples[..texels]);
        }
        let rows = &rows[..self.shares.len()];
        let mut sums = self.sums.each_mut().map(|plane| S::as_mut_simd_f32s(plane));
        for t in 0..sums[0].0.len() {
            let mut held: [S::f32s; K] = std::array::from_fn(|k| sums[k].0[t]);
            for ((row, _), shares) in rows.iter().zip(self.shares) {
                let sample = row[t];
                for k in 0..K {
                    held[k] = simd.add_f32s(held[k], simd.mul_f32s(simd.splat_f32s(shares[k]), sample));
                }
            }
            (0..K).for_each(|k| sums[k].0[t] = held[k]);
        }
        for t in 0..sums[0].1.len() {
            for ((_, row), shares) in rows.iter().zip(self.shares) {
                (0..K).for_each(|k| sums[k].1[t] += shares[k] * row[t]);
            }
        }
    }
}
