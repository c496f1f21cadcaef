//! The product of a fit, sums += pseudo-inverse x photographs, blocked and vectorised.
//!
//! Bands of texels are processed in parallel. For each band and channel, the samples of a batch are converted
//! into a buffer of 64 KiB that stays in the second-level cache, and the sums of six functions are kept in
//! registers while the batch passes. The sum of each texel is a chain of plain multiplications and additions
//! in the order of the photographs, so the result depends neither on threads and batches nor, without fused
//! operations, on the vector width.

use super::design::Design;
use super::levels::SampleLevels;
use super::products::{BAND, FUNCTIONS, add_products};
use super::stream::BATCH;
use crate::parallel::{self, Spares};
use crate::planes::Planes;
use crate::raster::Raster;
use pulp::Arch;

/// Adds a batch of photographs, starting with number `first`, to the coefficients: plane c n + k is function
/// k of channel c. Where photographs are interpolated, they are the coefficients.
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
    let scratch = Spares::new(|| vec![0.0f32; batch.len() * BAND]);
    parallel::for_each(sums.bands_mut(BAND).into_iter().enumerate(), |(b, mut band)| {
        let mut scratch = scratch.take();
        for (channel, planes) in band.chunks_mut(functions).take(channels).enumerate() {
            let texels = planes[0].len();
            if design.interpolated().is_some() {
                for (plane, photograph) in planes[first..].iter_mut().zip(batch) {
                    levels.channel(photograph, channel, b * BAND, plane);
                }
                continue;
            }
            for (row, photograph) in scratch.chunks_exact_mut(BAND).zip(batch) {
                levels.channel(photograph, channel, b * BAND, &mut row[..texels]);
            }
            for (group, planes) in planes.chunks_mut(FUNCTIONS).enumerate() {
                let share = |k: usize, i: usize| design.share(group * FUNCTIONS + k, first + i) as f32;
                add_products(arch, planes, &scratch, share);
            }
        }
    });
}
