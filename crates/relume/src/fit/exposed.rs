//! Photographs that are black, or white over most of the surface: how bright it was cannot be told there.

use super::stream::PhotographStream;
use crate::error::{Error, Result};
use crate::raster::{Raster, Samples};
use crate::words::listed;

/// The numbers of photographs that are black, and of those that are white over half of the surface.
#[derive(Debug, Default)]
pub(super) struct Exposed {
    black: Vec<usize>,
    white: Vec<usize>,
}

impl Exposed {
    /// Looks at photograph `i`, and at what a grid picks of it.
    pub fn look(&mut self, i: usize, photograph: &Raster, picked: &Raster) {
        self.black.extend(is_black(photograph).then_some(i));
        self.white.extend(is_white(picked).then_some(i));
    }

    /// What is to be said of them.
    ///
    /// # Errors
    /// When all are black.
    pub fn warnings(&self, stream: &PhotographStream) -> Result<Vec<String>> {
        Ok(in_the_dark(stream, &self.black)?.into_iter().chain(overexposed(stream, &self.white)).collect())
    }
}

/// Whether half of the samples are saturated.
fn is_white(picked: &Raster) -> bool {
    2 * picked.samples().saturated() >= picked.samples().len()
}

/// Whether all samples are black.
fn is_black(photograph: &Raster) -> bool {
    match photograph.samples() {
        Samples::U8(samples) => samples.iter().all(|sample| *sample == 0),
        Samples::U16(samples) => samples.iter().all(|sample| *sample == 0),
        Samples::F32(samples) => samples.iter().all(|sample| *sample <= 0.0),
    }
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
    let names: Vec<&str> = black.iter().map(|i| stream.name(*i)).collect();
    Ok(Some(format!(
        "{} of {} photographs are black, as if their lamps had not been lit: leave them out of the light file ({})",
        black.len(),
        stream.len(),
        listed(&names, 6, ", ")
    )))
}

/// Names the photographs of which [`is_white`] is true.
fn overexposed(stream: &PhotographStream, white: &[usize]) -> Option<String> {
    let names: Vec<&str> = white.iter().map(|i| stream.name(*i)).collect();
    (!white.is_empty()).then(|| {
        format!(
            "{} of {} photographs are saturated over half of the surface or more, where no texture can be fitted: expose them \
             shorter ({})",
            white.len(),
            stream.len(),
            listed(&names, 6, ", ")
        )
    })
}
