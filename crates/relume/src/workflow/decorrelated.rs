//! Factorisation of a texture of light and view for each channel of a decorrelated colour: of the logarithm of the luminance,
//! and of two colour differences over the luminance ("DFMF", decorrelated full matrix factorisation; M. Weinmann, J. Gall,
//! R. Klein, "Material Classification Based on Training Data Synthesized Using a BTF Database", ECCV 2014, whose database
//! stores textures so). Errors of logarithms are relative ones, so dark parts are kept as well as bright ones, and colours
//! need few functions.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::direction::Directions;
use crate::error::{Error, Result};
use crate::field::{Basis, ReflectanceField};
use crate::fit::learned::{LearnedOptions, Rank, fit};
use crate::format::bonn::{BtfColorModel, BtfFactors, FactorShape};
use crate::job::Job;
use crate::planes::Planes;
use crate::raster::{LoadRaster, Raster, Samples};
use crate::space::Space;

/// The colour model of the factors.
pub const DECORRELATED: BtfColorModel = BtfColorModel::LogYRatios;

/// The functions of each channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct DecorrelatedRanks {
    /// Of the logarithm of the luminance.
    pub luminance: usize,
    /// Of each colour difference.
    pub color: usize,
}

impl DecorrelatedRanks {
    /// So many functions of the luminance, and a quarter of that of each difference.
    pub fn of_luminance(luminance: usize) -> Self {
        Self { luminance, color: luminance.div_ceil(4) }
    }
}

/// The factors of each channel of [`DECORRELATED`], of values without the cosine between light and normal, in the order of
/// the pairs. `load(i)` reads the i-th photograph, twice for each channel.
///
/// # Errors
/// Photographs without three channels, black photographs, lights on the horizon, and as [`fit`].
pub fn decorrelated(
    pairs: &[(String, Directions)],
    load: &LoadRaster,
    ranks: DecorrelatedRanks,
    job: &Job,
) -> Result<[BtfFactors; 3]> {
    let light = AtomicBool::new(false);
    let load = |i: usize| {
        let photograph = load(i)?;
        if (0..photograph.samples().len()).any(|k| photograph.samples().value(k) > 0.0) {
            light.store(true, Ordering::Relaxed);
        }
        Ok(photograph)
    };
    let channel = |channel: usize| {
        let rank = if channel == 0 { ranks.luminance } else { ranks.color };
        one_channel(pairs, &load, channel, rank, job)
    };
    let luminance = channel(0);
    if luminance.is_ok() && !light.load(Ordering::Relaxed) {
        return Err(Error::invalid("all photographs are black: there is no function to learn"));
    }
    Ok([luminance?, channel(1)?, channel(2)?])
}

fn one_channel(
    pairs: &[(String, Directions)],
    load: &LoadRaster,
    channel: usize,
    rank: usize,
    job: &Job,
) -> Result<BtfFactors> {
    let has_values = AtomicBool::new(false);
    let load_channel = |i: usize| {
        let values = channel_of(&load(i)?, pairs[i].1, channel)?;
        if (0..values.samples().len()).any(|k| values.samples().value(k) != 0.0) {
            has_values.store(true, Ordering::Relaxed);
        }
        Ok(values)
    };
    let options =
        LearnedOptions { rank: Rank::Functions(rank), space: Space::Linear, ..LearnedOptions::default() };
    // What a fit says of light is not true of logarithms and ratios.
    match fit(pairs, &load_channel, &options, &job.unheard()) {
        Ok(fit) => factors_of(&fit.field),
        // Greys have no colour differences.
        Err(_) if channel > 0 && !has_values.load(Ordering::Relaxed) => {
            let size = load(0)?.size();
            let coefficients = Planes::zeros_within(job, "the colour differences", size, 1)?;
            let functions = vec![0.0; pairs.len()];
            Ok(BtfFactors { shape: FactorShape::Coefficients, functions, coefficients, singular: vec![0.0] })
        }
        Err(error) => Err(error),
    }
}

fn factors_of(field: &ReflectanceField) -> Result<BtfFactors> {
    let Basis::Learned(learned) = field.basis() else {
        return Err(Error::invalid("factors of other than learned functions"));
    };
    let norm = |plane: &[f32]| plane.iter().map(|v| f64::from(*v).powi(2)).sum::<f64>().sqrt() as f32;
    Ok(BtfFactors {
        shape: FactorShape::Coefficients,
        functions: learned.values().to_vec(),
        coefficients: field.coefficients().clone(),
        singular: field.coefficients().iter().map(norm).collect(),
    })
}

/// One channel of a photograph in [`DECORRELATED`], without the cosine.
fn channel_of(photograph: &Raster, pair: Directions, channel: usize) -> Result<Raster> {
    if photograph.channels() != 3 {
        return Err(Error::usage(format!(
            "a photograph has {} channels: decorrelated colours are made of red, green and blue",
            photograph.channels()
        )));
    }
    let cosine = pair.light.z() as f32;
    if cosine < 1e-6 {
        return Err(Error::unsupported(
            "a light lies on the horizon: its photograph cannot be divided by the cosine",
        ));
    }
    let picture = photograph.to_picture(Space::Linear);
    let color = |texel: usize| std::array::from_fn(|c| picture.planes.plane(c)[texel].max(0.0) / cosine);
    let values = (0..photograph.size().texels()).map(|t| BtfColorModel::log_ratios_of(color(t))[channel]);
    Raster::new(photograph.size(), 1, Samples::F32(values.collect()))
}
