//! Measures that distinguish good synthesis from bad.
//!
//! Two textures of any sizes with the same planes are compared by their statistics, not texel by texel. All
//! these are distances from a reference: 0 for the reference itself, smaller is better.
//!
//! | measure | of | unit |
//! |---|---|---|
//! | [`sliced`] | distributions of patches at several scales | the deviation inside the patches of the reference |
//! | [`histogram`] | distributions of values | the standard deviation of the reference |
//! | [`correlation`] | autocorrelations | correlation |
//! | [`detail`] | distributions of the steps between neighbours | logarithm of the magnitude |
//! | [`spectrum`] | power by frequency and direction | dB |
//! | [`steerable`] | statistics of a steerable pyramid, STSIM-2 | 1 - similarity |
//!
//! [`appearance`] weighs six kinds of statistics by how much they differ within the reference, and is what
//! textures are chosen by.
//!
//! For one texture alone: [`wrap`], the step across its borders. For a synthesised one with its sources
//! ([`sources`]): [`seams`], the steps across cuts, and [`copying`], its use of the exemplar.
//! `docs/measures.md` shows by measurement what each detects.

pub mod appearance;
mod colour;
pub mod copying;
pub mod correlation;
pub mod detail;
pub mod histogram;
mod pyramid;
mod repetition;
mod resolutions;
pub mod seams;
pub mod sliced;
pub mod sources;
pub mod spectrum;
pub mod steerable;
mod steps;
mod wasserstein;
pub mod wrap;

use serde::Serialize;

use crate::error::{Error, Result};
use crate::job::Job;
use crate::numeric::autocorrelation::Autocorrelation;
use crate::planes::Planes;
use crate::size::Size;
pub use appearance::{Appearance, Reference};
pub use sliced::SlicedOptions;
pub use sources::{Source, Sources};

/// The least side of textures that can be compared: twice a patch, and three levels of a pyramid.
pub const LEAST_SIDE: usize = 16;

/// All distances of a texture from a reference.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Distances {
    /// In appearance, in units of the differences within the reference.
    pub appearance: Appearance,
    /// Multi-scale patch distance: the mean over the levels of [`Distances::sliced_levels`].
    pub sliced: f64,
    /// The patch distance at each level, from the finest.
    pub sliced_levels: Vec<f64>,
    /// Distance of the distributions of values.
    pub histogram: f64,
    /// Distance of the autocorrelations.
    pub autocorrelation: f64,
    /// Distance of the power spectra in dB.
    pub spectrum_db: f64,
    /// 1 - STSIM-2.
    pub steerable: f64,
}

impl Distances {
    /// The mean of each measure, such as over renderings under several lights; `None` for an empty list.
    pub fn mean(all: &[Self]) -> Option<Self> {
        Self::combined(all, |values| values.iter().sum::<f64>() / values.len() as f64, Appearance::mean)
    }

    /// The largest of each measure.
    pub fn worst(all: &[Self]) -> Option<Self> {
        Self::combined(all, |values| values.iter().copied().fold(0.0, f64::max), Appearance::worst)
    }

    fn combined(
        all: &[Self],
        of: impl Fn(&[f64]) -> f64,
        appearance: fn(&[Appearance]) -> Option<Appearance>,
    ) -> Option<Self> {
        let each = |value: &dyn Fn(&Self) -> f64| of(&all.iter().map(value).collect::<Vec<_>>());
        let levels = all.iter().map(|d| d.sliced_levels.len()).min()?;
        let appearances: Vec<Appearance> = all.iter().map(|d| d.appearance).collect();
        Some(Self {
            appearance: appearance(&appearances)?,
            sliced: each(&|d| d.sliced),
            sliced_levels: (0..levels).map(|level| each(&|d| d.sliced_levels[level])).collect(),
            histogram: each(&|d| d.histogram),
            autocorrelation: each(&|d| d.autocorrelation),
            spectrum_db: each(&|d| d.spectrum_db),
            steerable: each(&|d| d.steerable),
        })
    }
}

/// Measures the distance of a texture from a reference with the same planes; sizes may differ.
///
/// # Errors
/// When the numbers of planes differ, a side is below [`LEAST_SIDE`], a value is not finite, or the
/// limits are exceeded.
pub fn distances(
    reference: &Planes,
    other: &Planes,
    options: &SlicedOptions,
    job: &Job,
) -> Result<Distances> {
    options.validate()?;
    check(reference, other)?;
    let sizes = [reference.size(), other.size()];
    job.check_bytes("the measures of the textures", bytes(sizes, reference.count(), options))?;
    let sliced_levels = sliced::levels(reference, other, options, job)?;
    Ok(Distances {
        appearance: Reference::new(reference, options.seed, job)?.distance(other, job)?,
        sliced: sliced_levels.iter().sum::<f64>() / sliced_levels.len() as f64,
        sliced_levels,
        histogram: histogram::distance(reference, other),
        autocorrelation: correlation::distance(reference, other, job)?,
        spectrum_db: spectrum::distance_db(reference, other, job)?,
        steerable: steerable::distance(reference, other, job)?,
    })
}

/// The memory of [`distances`], beside both textures: that of the measure that takes the most.
pub fn bytes(sizes: [Size; 2], planes: usize, options: &SlicedOptions) -> u64 {
    let alone = |size: Size| {
        let correlated = Autocorrelation::bytes(size, Autocorrelation::half(size));
        correlated.max(spectrum::bytes(size)).max(steerable::bytes(size))
    };
    sizes.into_iter().map(alone).fold(sliced::bytes(sizes, planes, options), u64::max)
}

fn check(reference: &Planes, other: &Planes) -> Result<()> {
    if reference.count() != other.count() {
        return Err(Error::usage(format!(
            "textures of {} and {} planes cannot be compared: both must be grey or both colour",
            reference.count(),
            other.count()
        )));
    }
    for planes in [reference, other] {
        let size = planes.size();
        if size.width.min(size.height) < LEAST_SIDE {
            return Err(Error::usage(format!(
                "a texture of {size} texels is too small to be compared: both sides must be at least {LEAST_SIDE}"
            )));
        }
        if let Some(at) = planes.as_slice().iter().position(|v| !v.is_finite()) {
            let (plane, texel) = (at / size.texels(), at % size.texels());
            return Err(Error::invalid(format!(
                "plane {plane} is not a finite number at texel ({}, {})",
                texel % size.width,
                texel / size.width
            )));
        }
    }
    Ok(())
}

/// The root of the mean variance of the planes: the unit for distances of values. 1 for constant planes.
fn deviation(planes: &Planes) -> f64 {
    let variances = planes.iter().map(variance);
    let mean = variances.sum::<f64>() / planes.count().max(1) as f64;
    if mean > 0.0 { mean.sqrt() } else { 1.0 }
}

fn variance(plane: &[f32]) -> f64 {
    let count = plane.len() as f64;
    let mean = plane.iter().map(|&v| f64::from(v)).sum::<f64>() / count;
    plane.iter().map(|&v| (f64::from(v) - mean).powi(2)).sum::<f64>() / count
}
