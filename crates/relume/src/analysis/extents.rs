//! How far a texture has to be seen to be known: the size of its features and its plain period, measured
//! quickly.
//!
//! They bound the blocks and windows of a synthesis from below, and matter only where they exceed a fraction of
//! the exemplar. So they are measured at a resolution of at most `FINEST` texels along the shorter side, at a
//! hundredth of the cost of a whole analysis of a large picture. Lengths are those of [`super::analyze`] to
//! about a texel of that resolution.

use serde::Serialize;

use super::{Analysis, LEAST_SIDE, Warning, blocks, check, feature, is_too_small, trend};
use crate::error::Result;
use crate::job::Job;
use crate::numeric::lattice::length;
use crate::numeric::periods::{self, Pattern, Periods};
use crate::planes::Planes;
use crate::size::Size;

/// The resolution is halved until the shorter side is below this.
const FINEST: usize = 192;
/// The share of the variance from which a texture counts as plainly regular.
const PLAINLY_REGULAR: f64 = 0.5;
/// The least number of times that a period has to fit to be taken for one.
const LEAST_REPEATS: f64 = 3.0;

/// Lengths that a block or window has to span, in texels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Extents {
    /// The size of the features; `None` where they reach half the size of the picture.
    pub feature: Option<f64>,
    /// The longest period, where half of the variance or more repeats, and three times or more.
    pub period: Option<f64>,
    /// Whether the exemplar holds too few of either to sample from.
    pub is_small_sample: bool,
}

impl Extents {
    /// Those of a whole analysis of an exemplar of the given size.
    pub fn of(found: &Analysis, size: Size) -> Self {
        Self::new(found.feature, &found.periods, size)
    }

    /// Measures planes. Exemplars too small for an analysis have features of unknown size.
    ///
    /// # Errors
    /// When a value is not finite, or the limits are exceeded.
    pub fn measure(planes: &Planes, job: &Job) -> Result<Self> {
        let size = planes.size();
        let shorter = |size: Size| size.width.min(size.height);
        if shorter(size) < LEAST_SIDE {
            return Ok(Self { feature: None, period: None, is_small_sample: true });
        }
        check(planes)?;
        job.check("the reduced texture", size, 4 * planes.count() as u64)?;
        let (mut reduced, mut factor) = (None::<Planes>, 1.0);
        while shorter(reduced.as_ref().unwrap_or(planes).size()) >= FINEST {
            reduced = Some(blocks::halved(reduced.as_ref().unwrap_or(planes)));
            factor *= 2.0;
        }
        let (even, _) = trend::removed(reduced.as_ref().unwrap_or(planes));
        let correlation = periods::correlation(&even, job)?;
        let feature = feature::size(&correlation);
        let mut found = Self::new(feature, &periods::find(&correlation, &even, job)?, even.size());
        for length in [&mut found.feature, &mut found.period].into_iter().flatten() {
            *length *= factor;
        }
        Ok(found)
    }

    fn new(feature: Option<f64>, periods: &Periods, size: Size) -> Self {
        let most = size.width.min(size.height) as f64 / LEAST_REPEATS;
        let period = plain(periods).filter(|period| *period <= most);
        Self { feature, period, is_small_sample: is_too_small(feature, periods, size) }
    }

    /// The warning of too small a sample.
    pub fn warning(&self) -> Option<Warning> {
        self.is_small_sample.then_some(Warning::TooSmall)
    }
}

/// The longest step of a plain period.
fn plain(periods: &Periods) -> Option<f64> {
    match periods.pattern {
        _ if periods.share < PLAINLY_REGULAR => None,
        Pattern::None => None,
        Pattern::Stripes(period) => Some(length(period)),
        Pattern::Lattice(lattice) => Some(lattice.basis().into_iter().map(length).fold(0.0, f64::max)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_and_flat_exemplars_have_extents() {
        let job = Job::default();
        for (width, height) in [(8, 8), (16, 16), (1, 300), (200, 16)] {
            let size = Size::new(width, height);
            let flat = Planes::from_vec(size, 1, vec![0.5; size.texels()]).unwrap();
            let found = Extents::measure(&flat, &job).unwrap();
            assert!(found.period.is_none(), "{size}: {found:?}");
        }
        let bad = Planes::from_vec(Size::new(20, 20), 1, vec![f32::NAN; 400]).unwrap();
        assert!(Extents::measure(&bad, &job).is_err());
    }
}
