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
/// How far across a step of the lattice may end beside an axis, in texels.
const BESIDE: f64 = 0.75;
/// The part of a period by which a size may differ from whole periods.
const LEFT_OVER: f64 = 0.1;

/// Lengths that a block or window has to span, in texels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Extents {
    /// The size of the features; `None` where they reach half the size of the picture.
    pub feature: Option<f64>,
    /// The longest period, where half of the variance or more repeats, and three times or more.
    pub period: Option<f64>,
    /// After how many texels along x and along y such a pattern repeats, where it does.
    pub repeats: [Option<f64>; 2],
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
            return Ok(Self { feature: None, period: None, repeats: [None; 2], is_small_sample: true });
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
        let Self { feature, period, repeats: [across, down], .. } = &mut found;
        for length in [feature, period, across, down].into_iter().flatten() {
            *length *= factor;
        }
        Ok(found)
    }

    fn new(feature: Option<f64>, periods: &Periods, size: Size) -> Self {
        let most = size.width.min(size.height) as f64 / LEAST_REPEATS;
        let period = plain(periods).filter(|period| *period <= most);
        let repeats = if period.is_some() { along_axes(periods.pattern) } else { [None; 2] };
        Self { feature, period, repeats, is_small_sample: is_too_small(feature, periods, size) }
    }

    /// The size nearest to one that holds whole repeats of the pattern, if one is given that does not.
    pub fn whole_repeats(&self, size: Size) -> Option<Size> {
        let whole = |side: usize, repeat: Option<f64>| {
            let Some(repeat) = repeat else { return side };
            let nearest = (side as f64 / repeat).round().max(1.0) * repeat;
            // What is left over is spread over all joins.
            let is_whole = (nearest - side as f64).abs() <= LEFT_OVER * repeat;
            if is_whole { side } else { nearest.round() as usize }
        };
        let [across, down] = self.repeats;
        let nearest = Size::new(whole(size.width, across), whole(size.height, down));
        (nearest != size).then_some(nearest)
    }

    /// The warning of too small a sample.
    pub fn warning(&self) -> Option<Warning> {
        self.is_small_sample.then_some(Warning::TooSmall)
    }
}

/// The steps of a pattern along the axes.
fn along_axes(pattern: Pattern) -> [Option<f64>; 2] {
    match pattern {
        Pattern::None => [None; 2],
        // Stripes along an axis repeat everywhere.
        Pattern::Stripes(period) => {
            let step = |component: f64| length(period).powi(2) / component.abs();
            period.map(|component| (component.abs() > BESIDE).then(|| step(component)))
        }
        Pattern::Lattice(lattice) => lattice.along_axes(BESIDE),
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
    use crate::numeric::lattice::Lattice;

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
    /// A former fault: a weave of 30.8 texels cracked in a tile of 512 without a word.
    #[test]
    fn sizes_of_whole_repeats_are_named_along_the_axes() {
        let extents = |repeats| Extents { feature: None, period: None, repeats, is_small_sample: false };
        let oblique = Lattice::new([15.4, 15.4], [15.4, -15.4]).unwrap();
        let [across, down] = oblique.along_axes(BESIDE).map(Option::unwrap);
        assert!((across - 30.8).abs() < 1e-9 && (down - 30.8).abs() < 1e-9, "{across} {down}");
        let weave = extents([Some(across), Some(down)]);
        assert_eq!(weave.whole_repeats(Size::new(512, 493)), Some(Size::new(524, 493)));
        assert_eq!(weave.whole_repeats(Size::new(493, 495)), None);
        assert_eq!(extents([Some(10.0), None]).whole_repeats(Size::new(74, 33)), Some(Size::new(70, 33)));
        assert_eq!(extents([None; 2]).whole_repeats(Size::new(74, 33)), None);
        assert_eq!(along_axes(Pattern::Stripes([3.0, 4.0])), [Some(25.0 / 3.0), Some(25.0 / 4.0)]);
        assert_eq!(along_axes(Pattern::Stripes([8.0, 0.0])), [Some(8.0), None]);
    }
}
