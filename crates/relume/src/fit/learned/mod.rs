//! Functions of light and view learned from photographs: factorisation of a bidirectional texture function.
//!
//! The photographs of a texture, one for each pair of light and view, are the columns of a matrix B of texels by
//! pairs and channels. The nearest matrix of rank C is U S V' of its singular value decomposition: the texel's
//! coefficients (eigen-textures) are rows of U S, the functions (eigen-ABRDFs) columns of V (Koudelka, Magda,
//! Belhumeur, Kriegman, "Acquisition, Compression, and Synthesis of Bidirectional Texture Functions", Texture
//! 2003; "full BTF-matrix factorization" in the survey of Filip, Haindl, "Bidirectional Texture Function Modeling:
//! A State of the Art Survey", IEEE PAMI 31, 2009).
//!
//! Photographs are streamed twice, never all in memory. With a random matrix O, the first pass sums Y = B O
//! and Q is an orthonormal basis of Y; the second finds Z = B' Q and Y2 = B Z together. The columns of Z span
//! nearly the functions with the largest singular values (one and a half power iterations: Halko, Martinsson,
//! Tropp, "Finding Structure with Randomness", SIAM Review 53, 2011, algorithm 4.4), and with Z = W R, W
//! orthonormal, B W = Y2 R^-1 is known without a third pass.
//!
//! The product of coefficients and functions is that of the unweighted decomposition. Its factors are chosen
//! such that the functions are orthonormal by solid angle, and coefficients uncorrelated, largest first: so
//! coefficients are index planes.
//!
//! Texels may then be put into clusters with axes of their own ([`ClusterOptions`]): fewer numbers a texel for the same
//! common functions.

mod clipped;
mod clusters;
mod dots;
mod finish;
mod packing;
mod point_axes;
mod reference;
mod report;
mod rounding;
mod sketch;
mod solid_angles;

pub use super::pair_errors::{PairsReport, PolarReport};
pub use clusters::{ClusterOptions, cluster};
pub use packing::{deviations, in_packed};
pub use reference::exact;
pub use report::LearnedReport;
pub use solid_angles::pair_weights;

use serde::Serialize;

use super::held_out::HeldOut;
use super::levels::SampleLevels;
use super::pair_errors::Measurement;
use super::sample::Grid;
use super::stream::PhotographStream;
use crate::direction::Directions;
use crate::error::{Error, Result};
use crate::field::{Basis, ClusteredField, Learned, PackedFunctions, PlaneLayout, ReflectanceField};
use crate::job::Job;
use crate::raster::LoadRaster;
use crate::size::Size;
use crate::space::Space;
use crate::words::counted;
use rounding::FactorRounding;
use sketch::Sketch;

/// The most functions; more are neither compact nor fast.
pub const MOST_FUNCTIONS: usize = 256;

/// Columns of the first sketch where an error is given.
const FIRST_SKETCH: usize = 104;

/// How many functions are learned.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Rank {
    /// That many.
    Functions(usize),
    /// As few as give this root mean square error or less, of values with white at 1.
    Error(f64),
}

/// The options of a factorisation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LearnedOptions {
    /// How many functions are learned.
    pub rank: Rank,
    /// The space of the fitted values, as in [`FitOptions`](super::FitOptions).
    pub space: Space,
    /// Every so-manieth light and view is left out of the fit, and its photographs are predicted; `None` leaves
    /// none out.
    pub hold_out: Option<usize>,
    /// At most this many texels, on a regular grid, are compared with the photographs.
    pub report_texels: usize,
    /// Clusters of texels with axes of their own; `None` keeps a number for each function.
    pub clusters: Option<ClusterOptions>,
    /// The root mean square error, of values with white at 1, by which numbers and functions may be rounded so that files
    /// are small; `None` rounds nothing. Pairs must be all of some lights with all of some views.
    pub rounding: Option<f64>,
    /// The texels that belong to the surface: others are not measured. Photographs are black there.
    #[serde(skip)]
    pub mask: Option<Vec<bool>>,
    /// The seed of the random matrix, whose influence is below the error of the factorisation, and of the clusters.
    pub seed: u64,
}

impl Default for LearnedOptions {
    fn default() -> Self {
        Self {
            rank: Rank::Functions(32),
            space: Space::Srgb,
            hold_out: None,
            report_texels: 1024,
            clusters: None,
            rounding: None,
            mask: None,
            seed: 0,
        }
    }
}

impl LearnedOptions {
    /// Checks the options before a photograph is read.
    ///
    /// # Errors
    /// No function or more than [`MOST_FUNCTIONS`], an error that is not between 0 and 1, or one that rounding alone
    /// passes, no texel to compare, a step of less than 2 of what is left out, and a rounding of nothing or of a quarter
    /// of the range and more.
    pub fn validate(&self) -> Result<()> {
        match self.rank {
            Rank::Functions(n) if n == 0 || n > MOST_FUNCTIONS => {
                return Err(Error::usage(format!("1 to {MOST_FUNCTIONS} functions are learned, not {n}")));
            }
            Rank::Error(error) if !(error > 0.0 && error < 1.0) => {
                return Err(Error::usage(format!(
                    "the error is that of values with white at 1, between 0 and 1, not {error}"
                )));
            }
            Rank::Functions(_) | Rank::Error(_) => {}
        }
        if self.report_texels == 0 {
            return Err(Error::usage("the error report needs at least 1 texel, found 0"));
        }
        if self.hold_out.is_some_and(|step| step < 2) {
            return Err(Error::usage("leaving out every first light and view leaves none: give 2 or more"));
        }
        if let Some(rounding) = self.rounding {
            rounding::validate(rounding)?;
            if matches!(self.rank, Rank::Error(error) if error <= rounding) {
                return Err(Error::usage(format!(
                    "the error asked for holds that of rounding, {rounding}: give a larger error or a finer rounding"
                )));
            }
        }
        Ok(())
    }
}

/// The most functions that some photographs determine: of each pair that takes part one for each channel, and no more than
/// there are texels.
///
/// # Errors
/// As [`fit`] where pairs are left out.
pub fn most_functions(
    pairs: &[(String, Directions)],
    hold_out: Option<usize>,
    (size, channels): (Size, usize),
) -> Result<usize> {
    let directions: Vec<Directions> = pairs.iter().map(|(_, pair)| *pair).collect();
    let kept = HeldOut::new(&directions, hold_out)?.kept();
    Ok((kept * channels).min(size.texels()))
}

/// A factorised texture of light and view, and its errors.
#[derive(Debug, Clone)]
pub struct LearnedFit {
    /// The result; of clusters the expanded form.
    pub field: ReflectanceField,
    /// The result in clusters, if asked for.
    pub clustered: Option<ClusteredField>,
    /// Its errors.
    pub report: LearnedReport,
}

/// Learns functions of light and view: `pairs` names each photograph and its directions, and `load(i)` reads
/// the i-th, twice or more. The result is the same at any number of threads.
///
/// # Errors
/// Options without meaning; more functions than pairs and channels, or than texels; an error that no
/// [`MOST_FUNCTIONS`] functions reach; too few pairs left where some are left out; errors of `load`, photographs that
/// differ in size or channels, samples that are not finite, and sizes beyond the limits of the job.
pub fn fit(
    pairs: &[(String, Directions)],
    load: &LoadRaster,
    options: &LearnedOptions,
    job: &Job,
) -> Result<LearnedFit> {
    options.validate()?;
    let directions: Vec<Directions> = pairs.iter().map(|(_, pair)| *pair).collect();
    let held_out = HeldOut::new(&directions, options.hold_out)?;
    let names = pairs.iter().map(|(name, _)| name.as_str()).collect();
    if options.rounding.is_some() {
        PackedFunctions::check(&held_out.pairs())?;
    }
    let asked = rank_of_factors(options);
    let first = first_width(asked);
    let stream = PhotographStream::open(names, load, |_| 3 * first, job)?;
    let columns = held_out.kept() * stream.channels();
    let most = columns.min(stream.size().texels());
    check_rank(asked, columns, stream.size().texels())?;
    if let (Some(clusters), Rank::Functions(functions)) = (&options.clusters, asked) {
        clusters.validate(functions, stream.size().texels())?;
    }
    let grid = Grid::within(stream.size(), options.report_texels, options.mask.as_deref())?;
    let _sample = job.hold("the sample for the error report", stream.sample_bytes(&grid) + grid.bytes())?;
    let levels = SampleLevels::new(options.space);
    let setting =
        sketch::Setting { stream: &stream, levels: &levels, held_out: &held_out, seed: options.seed };

    let mut width = first.min(most);
    loop {
        let sketched = Sketch::new(&setting, width, &grid, job)?;
        let factors = finish::Factors::new(&sketched, job)?;
        let found = factors.rank(asked);
        let enough = with_margin(found.unwrap_or(MOST_FUNCTIONS)).min(most);
        if width < enough {
            width = (2 * width).min(enough);
            continue;
        }
        let Some(rank) = found else { return Err(not_reached(asked, &factors)) };
        let (values, weights, mut planes) = factors.finish(rank, &held_out, job)?;
        if directions.iter().all(|pair| pair.view == directions[0].view) {
            clipped::refine(&mut planes, &values, &stream, &held_out, &levels, job)?;
        }
        let basis = Learned::of_channels(stream.channels(), held_out.pairs(), weights, values)?;
        let layout = PlaneLayout::shared(channel_names(stream.channels()))?;
        let field = ReflectanceField::new(Basis::Learned(basis.clone()), layout, options.space, planes)?;
        let formed = formed(&field, &basis, options, job)?;
        let more =
            formed.as_ref().map_or(Ok(0.0), |(formed, _)| sketched.mean_square(&field, formed, job))?;
        let (field, clustered) = formed.unwrap_or((field, None));
        let error = (factors.error(rank).powi(2) + more).sqrt();
        let measured = Measurement { pairs, grid: &grid, levels: &levels, held_out: &held_out };
        let singular_values = &factors.singular_values[..rank];
        let mut report = report::report(&measured, &field, &sketched.kept, singular_values, error, job)?;
        report.warnings = sketched.exposed.warnings(&stream)?;
        return Ok(LearnedFit { field, clustered, report });
    }
}

/// A factorised texture rounded, in clusters, or both; of clusters the expanded form as well. `None` where neither is
/// asked for.
fn formed(
    field: &ReflectanceField,
    learned: &Learned,
    options: &LearnedOptions,
    job: &Job,
) -> Result<Option<(ReflectanceField, Option<ClusteredField>)>> {
    let rounding = options.rounding.map(|rmse| FactorRounding::new(field, learned, rmse));
    let rounded = rounding.as_ref().map(|rounding| rounding.of_functions(field, learned, job)).transpose()?;
    let Some(clusters) = &options.clusters else {
        let rounded = rounded.zip(rounding);
        return Ok(rounded.map(|(field, rounding)| (field.rounded(rounding.number_steps()), None)));
    };
    let mut clustered = cluster(rounded.as_ref().unwrap_or(field), clusters, options.seed, job)?;
    if let Some(rounding) = rounding {
        clustered = clustered.rounded(rounding.step_of_axes(clusters.axes, learned));
    }
    Ok(Some((clustered.expanded(job)?, Some(clustered))))
}

/// The rank asked for of the factors alone: rounding adds its own error.
fn rank_of_factors(options: &LearnedOptions) -> Rank {
    match (options.rank, options.rounding) {
        (Rank::Error(error), Some(rounding)) => Rank::Error((error * error - rounding * rounding).sqrt()),
        (rank, _) => rank,
    }
}

/// The columns of the first sketch.
fn first_width(asked: Rank) -> usize {
    match asked {
        Rank::Functions(n) => with_margin(n),
        Rank::Error(_) => FIRST_SKETCH,
    }
}

/// More columns of the sketch than functions, so that the last ones are found as well as the first: with three times as
/// many, the error of measured fabrics is that of the exact decomposition within 0.6 %; with twice as many 1.9 %.
fn with_margin(functions: usize) -> usize {
    (3 * functions + 8).min(functions + MOST_FUNCTIONS)
}

fn check_rank(rank: Rank, columns: usize, texels: usize) -> Result<()> {
    match rank {
        Rank::Functions(n) if n > columns || n > texels => Err(Error::usage(format!(
            "{} cannot be learned from {} (pairs and channels) of {}: ask for at most {}",
            counted(n, "function"),
            counted(columns, "value"),
            counted(texels, "texel"),
            columns.min(texels)
        ))),
        Rank::Functions(_) | Rank::Error(_) => Ok(()),
    }
}

fn not_reached(rank: Rank, factors: &finish::Factors<'_>) -> Error {
    let asked = if let Rank::Error(error) = rank { error } else { 0.0 };
    let most = factors.singular_values.len().min(MOST_FUNCTIONS);
    Error::usage(format!(
        "{}, the most that are learned, leave an error of {:.5} where {asked} was asked for: ask for a larger one",
        counted(most, "function"),
        factors.error(most)
    ))
}

fn channel_names(channels: usize) -> Vec<String> {
    match channels {
        1 => vec!["L".to_owned()],
        3 => ["R", "G", "B"].map(str::to_owned).to_vec(),
        n => (0..n).map(|c| format!("band {c}")).collect(),
    }
}

#[cfg(test)]
mod tests;
