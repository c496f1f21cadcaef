//! The luminance of few texels in all photographs, as stored.

use crate::direction::Direction;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::parallel;
use crate::raster::LoadRaster;
use crate::size::Size;

/// Values with white at 1, in the space of their files: `values[texel * photographs + i]`.
#[derive(Debug, Clone, PartialEq)]
pub struct TexelSample {
    /// The directions of the lamps.
    pub lights: Vec<[f64; 3]>,
    /// Texel after texel, all photographs of each.
    pub values: Vec<f64>,
}

/// About this many texels are looked at.
const TEXELS: usize = 2000;

impl TexelSample {
    /// The values of each texel.
    pub(super) fn texels(&self) -> impl Iterator<Item = &[f64]> {
        self.values.chunks_exact(self.lights.len())
    }

    /// The same values, each passed through a function.
    #[must_use]
    pub fn mapped(&self, through: impl Fn(f64) -> f64) -> Self {
        Self { lights: self.lights.clone(), values: self.values.iter().map(|v| through(*v)).collect() }
    }
}

/// Reads every photograph and keeps a regular grid of texels, of those that a mask leaves where there is one.
///
/// # Errors
/// Errors of `load`, and photographs that differ in size.
pub fn sample_texels(
    lights: &[(String, Direction)],
    load: &LoadRaster,
    mask: Option<&[bool]>,
    job: &Job,
) -> Result<TexelSample> {
    job.start("looking at the photographs", lights.len() as u64);
    let of = |i: usize| {
        let photograph = load(i)?;
        let (size, channels) = (photograph.size(), photograph.channels());
        let values = grid(size, mask).map(|texel| {
            let value = |c: usize| f64::from(photograph.samples().value(texel * channels + c));
            if channels == 1 { value(0) } else { super::luminance_of([value(0), value(1), value(2)]) }
        });
        let values: Vec<f64> = values.collect();
        job.advance(1)?;
        Ok((size, values))
    };
    let columns = parallel::try_map(0..lights.len(), of)?;
    let first = columns.first().map(|column| column.0);
    if let Some((i, (size, _))) = columns.iter().enumerate().find(|(_, column)| Some(column.0) != first) {
        let name = &lights[i].0;
        return Err(Error::invalid(format!(
            "the photograph {name} is {size} texels and the first {}: all must have the same size",
            columns[0].0
        )));
    }
    let texels = columns.first().map_or(0, |column| column.1.len());
    let values = (0..texels).flat_map(|texel| columns.iter().map(move |column| column.1[texel])).collect();
    Ok(TexelSample { lights: lights.iter().map(|(_, light)| light.to_array()).collect(), values })
}

/// The texels of a regular grid, finer where a mask leaves few.
fn grid(size: Size, mask: Option<&[bool]>) -> impl Iterator<Item = usize> {
    let is_inside = move |texel: usize| mask.is_none_or(|mask| mask.get(texel) == Some(&true));
    let inside = mask.map_or(size.texels(), |mask| mask.iter().filter(|inside| **inside).count());
    let step = ((inside as f64 / TEXELS as f64).sqrt().ceil() as usize).max(1);
    let (x, y) = ((step / 2).min(size.width - 1), (step / 2).min(size.height - 1));
    (y..size.height)
        .step_by(step)
        .flat_map(move |y| (x..size.width).step_by(step).map(move |x| size.index(x, y)))
        .filter(move |texel| is_inside(*texel))
}
