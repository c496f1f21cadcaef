//! The properties of an exemplar, and its suitability for synthesis: periods, direction, size of features,
//! randomness, and common causes of failure (uneven light, perspective, too small a sample).
//!
//! Works on index planes, whose distances are those of functions, or on the channels of a plain picture:
//!
//! - [`trend`]: changes of light across the picture, and the planes without them;
//! - [`crate::numeric::periods`]: lattices and stripes;
//! - [`orientation`]: the main direction, by the structure tensor;
//! - [`feature`]: the size of features, by the autocorrelation;
//! - [`blocks`]: whether scale and contrast are the same everywhere;
//! - [`extents`]: sizes of features and periods alone, quickly;
//! - [`advice`]: suitable methods;
//! - [`draw()`]: all of it in one picture.

pub mod advice;
pub mod blocks;
mod draw;
pub mod extents;
pub mod feature;
pub mod orientation;
pub mod trend;

pub use advice::{Advice, advise};
pub use draw::draw;
pub use extents::Extents;

use serde::Serialize;

use crate::error::{Error, Result};
use crate::job::Job;
use crate::numeric::lattice::length;
use crate::numeric::periods::{self, Pattern, Periods};
use crate::planes::Planes;
use crate::size::Size;
use blocks::Drift;
use orientation::Orientation;

/// The least side of a texture that is analysed.
pub const LEAST_SIDE: usize = 16;
/// Fewer features than this along a side are too small a sample: a stone or a pore is two to three of them
/// wide, by the measure of [`feature`].
const LEAST_FEATURES: f64 = 10.0;
/// Fewer periods than this along a side are too small a sample.
const LEAST_PERIODS: f64 = 4.0;
/// A trend of light is reported from this share of the variance on, if it is also this many times the share
/// expected by chance for features of this size.
const LEAST_TREND: (f64, f64) = (0.05, 5.0);

/// The results.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Analysis {
    /// The periods of the texture.
    pub periods: Periods,
    /// Its main direction.
    pub orientation: Orientation,
    /// The size of its features in texels; `None` where they reach half the size of the picture.
    pub feature: Option<f64>,
    /// The kurtosis of the steps between neighbours: 3 for random phases, higher with edges.
    pub kurtosis: f64,
    /// The share of the variance explained by a slow change of light (a polynomial of second degree).
    pub trend: f64,
    /// The change of scale across the picture, along x and y, as the factor from one side to the other.
    pub scale: [Drift; 2],
    /// The change of contrast in the same form.
    pub contrast: [Drift; 2],
    /// Possible causes of failure of a synthesis from this exemplar.
    pub warnings: Vec<Warning>,
}

/// A possible cause of failure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Warning {
    /// Light changes across the picture.
    UnevenLight,
    /// The scale changes across the picture.
    Perspective,
    /// The halves differ more than their parts.
    Unrepresentative,
    /// There are too few features to sample from.
    TooSmall,
}

impl Warning {
    /// The meaning, and what to do about it.
    pub fn sentence(self) -> &'static str {
        match self {
            Self::UnevenLight => {
                "brightness or colour changes across the picture: copies will show patches of light and dark; \
                 photograph under even light or divide the picture by a strongly blurred copy of itself"
            }
            Self::Perspective => {
                "features change in size across the picture, as in perspective: copies will mix sizes; photograph \
                 straight from above or rectify the picture"
            }
            Self::Unrepresentative => {
                "one half of the picture differs from the other more than its own parts do: it is not a sample of one \
                 texture; crop it to the part that is meant"
            }
            Self::TooSmall => {
                "the picture holds only a few features: synthesis will repeat them visibly; take a larger sample"
            }
        }
    }
}

/// Analyses planes.
///
/// # Errors
/// When a side is below [`LEAST_SIDE`], a value is not finite, or the limits are exceeded.
pub fn analyze(planes: &Planes, job: &Job) -> Result<Analysis> {
    check(planes)?;
    job.check("the texture without its trend", planes.size(), 8 * planes.count() as u64)?;
    let (even, trend) = trend::removed(planes);
    let even = even.held(job, "the texture without its trend")?;
    let correlation = periods::correlation(&even, job)?;
    job.proceed()?;
    let feature = feature::size(&correlation);
    let [scale, contrast] = blocks::drifts(&even, feature);
    job.proceed()?;
    let mut found = Analysis {
        periods: periods::find(&correlation, &even, job)?,
        orientation: orientation::of(&even),
        feature,
        kurtosis: orientation::kurtosis(&even),
        trend,
        scale,
        contrast,
        warnings: Vec::new(),
    };
    found.warnings = warnings(&found, planes.size());
    Ok(found)
}

fn check(planes: &Planes) -> Result<()> {
    let size = planes.size();
    if size.width.min(size.height) < LEAST_SIDE {
        return Err(Error::usage(format!(
            "a texture of {size} texels is too small to be analysed: both sides must be at least {LEAST_SIDE}"
        )));
    }
    match planes.as_slice().iter().position(|v| !v.is_finite()) {
        Some(at) => Err(Error::invalid(format!(
            "plane {} is not a finite number at texel ({}, {})",
            at / size.texels(),
            at % size.texels() % size.width,
            at % size.texels() / size.width
        ))),
        None => Ok(()),
    }
}

fn warnings(found: &Analysis, size: Size) -> Vec<Warning> {
    let feature = found.feature.unwrap_or(f64::INFINITY);
    // Five terms in addition to the mean, each of which explains as much as one independent feature.
    let by_chance = 5.0 * feature * feature / size.texels() as f64;
    let (least, times) = LEAST_TREND;
    let uneven = found.trend > least.max(times * by_chance.min(1.0));
    let small = is_too_small(found.feature, &found.periods, size);
    let perspective = found.scale.iter().any(Drift::is_plain);
    let unlike = !perspective && found.contrast.iter().any(Drift::is_plain);
    let all = [
        (uneven, Warning::UnevenLight),
        (perspective, Warning::Perspective),
        (unlike, Warning::Unrepresentative),
        (small, Warning::TooSmall),
    ];
    all.into_iter().filter(|(found, _)| *found).map(|(_, warning)| warning).collect()
}

/// Whether a picture holds too few features or periods to sample from.
fn is_too_small(feature: Option<f64>, periods: &Periods, size: Size) -> bool {
    let needed = match periods.pattern {
        Pattern::None => LEAST_FEATURES * feature.unwrap_or(f64::INFINITY),
        Pattern::Stripes(period) => LEAST_PERIODS * length(period),
        Pattern::Lattice(lattice) => LEAST_PERIODS * lattice.cell_area().sqrt(),
    };
    needed > size.width.min(size.height) as f64
}
