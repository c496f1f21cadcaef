//! Photographs that are black, or white over most of the surface: how bright it was cannot be told there.

use super::sample::Grid;
use super::stream::PhotographStream;
use crate::error::{Error, Result};
use crate::raster::{Raster, Samples};

/// Samples from this on are at the end of their range, with white at 1: the last two codes of 8 bits, also where
/// they are decoded.
const SATURATED: f32 = 0.991;

/// Whether half of the samples at the texels of a grid are saturated. Floats above 1 are not: they go on beyond white.
pub(super) fn is_white(photograph: &Raster, grid: &Grid) -> bool {
    let picked = grid.raster(photograph);
    let count = match picked.samples() {
        Samples::U8(samples) => samples.iter().filter(|s| **s >= 254).count(),
        Samples::U16(samples) => samples.iter().filter(|s| **s >= 65_278).count(),
        Samples::F32(samples) => samples.iter().filter(|s| (SATURATED..=1.0).contains(*s)).count(),
    };
    2 * count >= grid.texels() * picked.channels()
}

/// Whether all samples are black.
pub(super) fn is_black(photograph: &Raster) -> bool {
    match photograph.samples() {
        Samples::U8(samples) => samples.iter().all(|sample| *sample == 0),
        Samples::U16(samples) => samples.iter().all(|sample| *sample == 0),
        Samples::F32(samples) => samples.iter().all(|sample| *sample <= 0.0),
    }
}

/// What is to be said of black and white photographs, whose numbers are given.
///
/// # Errors
/// When all are black.
pub(super) fn warnings(stream: &PhotographStream, black: &[usize], white: &[usize]) -> Result<Vec<String>> {
    Ok(in_the_dark(stream, black)?.into_iter().chain(overexposed(stream, white)).collect())
}

/// Refuses photographs that are all black, and says which of them are.
fn in_the_dark(stream: &PhotographStream, black: &[usize]) -> Result<Option<String>> {
    let Some(first) = black.first() else { return Ok(None) };
    if black.len() == stream.len() {
        return Err(Error::invalid(format!(
            "all {} photographs are black, from {} on: nothing is to be seen of a surface; check the exposure and the files",
            black.len(),
            stream.name(*first)
        )));
    }
    let names: Vec<&str> = black.iter().take(6).map(|i| stream.name(*i)).collect();
    Ok(Some(format!(
        "{} of {} photographs are black, as if their lamps had not been lit: leave them out of the light file ({})",
        black.len(),
        stream.len(),
        names.join(", ")
    )))
}

/// Names the photographs of which [`is_white`] is true.
fn overexposed(stream: &PhotographStream, white: &[usize]) -> Option<String> {
    let names: Vec<&str> = white.iter().take(6).map(|i| stream.name(*i)).collect();
    (!white.is_empty()).then(|| {
        format!(
            "{} of {} photographs are saturated over half of the surface or more, where no texture can be fitted: expose them \
             shorter ({})",
            white.len(),
            stream.len(),
            names.join(", ")
        )
    })
}
