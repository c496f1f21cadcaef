//! The lattice that explains the autocorrelation best.

use super::share::Tally;
use super::{NEARLY_BEST, least_share};
use crate::numeric::autocorrelation::Autocorrelation;
use crate::numeric::lattice::{Lattice, length};

/// Multiples of each basis vector that are examined: enough for a mean, and few enough that the error of the
/// position of a peak, a tenth of a texel, does not grow beyond its width.
const SPAN: i32 = 3;
/// Cells are sampled in steps of a quarter of each vector.
const STEPS: u8 = 4;
/// The least number of visible lattice points: the two vectors, their sum and their difference.
const LEAST_POINTS: usize = 4;
/// The least drop of the correlation between lattice points along both vectors and their sum, as a fraction
/// of the share. Stripes show it along two of them at most: counted in stripes, one of any two integers and
/// their sum is even, so one of the three half-way positions lies on a stripe.
const LEAST_CONTRAST: f64 = 0.25;

/// A lattice and the share of the variance that repeats with it.
#[derive(Debug, Clone, Copy)]
pub struct Judged {
    pub lattice: Lattice,
    pub share: f64,
    points: usize,
    /// The mean drop of the correlation half-way to the next lattice point, along each vector and their sum.
    contrast: [f64; 3],
}

/// The best lattice from pairs of candidates, if there is one.
pub fn best(correlation: &Autocorrelation, candidates: &[[f64; 2]]) -> Option<Judged> {
    let pairs = (0..candidates.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    let lattices = pairs.filter_map(|(i, j)| Lattice::new(candidates[j], candidates[i]));
    let judged: Vec<Judged> =
        lattices.map(|lattice| judge(correlation, lattice)).filter(Judged::is_period).collect();
    let best = judged.iter().map(|j| j.share).fold(0.0, f64::max);
    let good = judged.into_iter().filter(|j| j.share >= NEARLY_BEST * best);
    // The best of the bases of one lattice, whose areas differ by the errors of their peaks.
    let densest = good.clone().map(|j| j.lattice.cell_area()).fold(f64::INFINITY, f64::min);
    good.filter(|j| j.lattice.cell_area() < 1.2 * densest).max_by(|a, b| a.share.total_cmp(&b.share))
}

impl Judged {
    fn is_period(&self) -> bool {
        self.points >= LEAST_POINTS
            && self.share >= least_share(self.points)
            && self.contrast.iter().all(|&fall| fall >= LEAST_CONTRAST * self.share)
    }
}

fn judge(correlation: &Autocorrelation, lattice: Lattice) -> Judged {
    let sample = |ij: [f64; 2]| correlation.sample(lattice.point(ij));
    let centre = 0.3 * lattice.basis().map(length).into_iter().fold(f64::INFINITY, f64::min);
    let (mut tally, mut contrast) = (Tally::default(), [0.0; 3]);
    for [i, j] in Lattice::half(SPAN).filter(|&ij| correlation.covers(lattice.point(ij))) {
        let here = sample([i, j]);
        tally.add_point(here);
        // Steps point towards the origin, so that they stay within reach.
        let left = if i < 0.0 { -1.0 } else { 1.0 };
        contrast[0] += here - sample([i - 0.5 * left, j]);
        contrast[1] += here - sample([i, j - 0.5]);
        contrast[2] += here - sample([i - 0.5 * left, j - 0.5]);
        for (s, t) in steps() {
            let place = lattice.point([i - s * left, j - t]);
            if length(place) > centre {
                tally.add_between(correlation.sample(place));
            }
        }
    }
    let points = tally.points();
    Judged { lattice, share: tally.share(), points, contrast: contrast.map(|c| c / points.max(1) as f64) }
}

/// The sampled positions of a cell, apart from its corner.
fn steps() -> impl Iterator<Item = (f64, f64)> {
    let step = |k: u8| f64::from(k) / f64::from(STEPS);
    (1..STEPS * STEPS).map(move |k| (step(k % STEPS), step(k / STEPS)))
}
