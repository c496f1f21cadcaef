//! The product of a fit, sums += pseudo-inverse x photographs, blocked and vectorised.
//!
//! Bands of texels are processed in parallel. For each band and channel, the samples of a batch are converted
//! into a buffer of 64 KiB that stays in the second-level cache, and the sums of six functions are kept in
//! registers while the batch passes. The sum of each texel is a chain of plain multiplications and additions
//! in the order of the photographs, so the result depends neither on threads and batches nor, without fused
//! operations, on the vector width.

use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use super::design::Design;
use super::levels::SampleLevels;
use super::stream::BATCH;
use crate::planes::Planes;
use crate::raster::Raster;

/// Texels per band.
const BAND: usize = 1024;

/// Functions whose sums share the registers: with the sample and a weight, eight of the sixteen registers
/// that every x86-64 has.
const FUNCTIONS: usize = 6;

/// Adds a batch of photographs, starting with number `first`, to the coefficients: plane c n + k is function
/// k of channel c.
///
/// # Panics
/// When the batch has more than [`BATCH`] photographs.
pub(super) fn accumulate(
    sums: &mut Planes,
    design: &Design,
    first: usize,
    batch: &[Raster],
    levels: &SampleLevels,
) {
    assert!(batch.len() <= BATCH, "a batch larger than promised");
    let Some(channels) = batch.first().map(Raster::channels) else { return };
    let (functions, arch) = (design.functions(), Arch::new());
    let bands = sums.bands_mut(BAND);
    let scratch = || vec![0.0f32; batch.len() * BAND];
    bands.into_par_iter().enumerate().for_each_init(scratch, |scratch, (b, mut band)| {
        for (channel, planes) in band.chunks_mut(functions).take(channels).enumerate() {
            let texels = planes[0].len();
            for (row, photograph) in scratch.chunks_exact_mut(BAND).zip(batch) {
                levels.channel(photograph, channel, b * BAND, &mut row[..texels]);
            }
            for (group, planes) in planes.chunks_mut(FUNCTIONS).enumerate() {
                let share = |k: usize, i: usize| design.share(group * FUNCTIONS + k, first + i) as f32;
                add_products(arch, planes, scratch, share);
            }
        }
    });
}

/// planes_k += sum_i share(k, i) row_i, six functions at once or one after another.
fn add_products(arch: Arch, planes: &mut [&mut [f32]], rows: &[f32], share: impl Fn(usize, usize) -> f32) {
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
