//! The primitive lattice: the densest one of which all points are equally good.
//!
//! Every sublattice of a lattice of periods is one as well, and a denser lattice may be nearly one: the yarns
//! of a weave repeat nearly after half of its period. A sublattice of index n leaves n - 1 cosets. Where the
//! correlation is lower on them, they are no periods, and where the cosets of a denser lattice are as high, they
//! are.

use super::background::Background;
use super::refine;
use super::score::{FARTHEST, Judged, WeightedMean, is_repeated, reach_of_cell, visible};
use crate::numeric::autocorrelation::Autocorrelation;
use crate::numeric::lattice::Lattice;

/// The indices of the sublattices examined: those of products are reached in steps.
const INDICES: [i32; 4] = [2, 3, 5, 7];
/// The most steps.
const STEPS: usize = 6;
/// The correlation on the cosets is lower where it falls by more than this fraction of the mean on the lattice,
/// and by more than so many deviations; otherwise it is as high.
const LOWER: (f64, f64) = (0.1, 3.0);

/// The primitive lattice near a good one. On the way there, half-way positions may be periods as well.
pub fn of(correlation: &Autocorrelation, background: &Background, start: Judged) -> Judged {
    let step = |now: &Judged| {
        let sparser = || sparser(correlation, background, &now.lattice);
        sparser().or_else(|| denser(correlation, background, &now.lattice))
    };
    let steps = std::iter::successors(Some(start), step).take(STEPS);
    // A denser lattice may be nearly as good at each step, and the last one not.
    let is_as_good = |end: &Judged| end.is_lattice() && end.share >= (1.0 - LOWER.0) * start.share;
    steps.filter(is_as_good).last().unwrap_or(start)
}

/// The sublattice that is clearly better than its cosets, the surest of them.
fn sparser(correlation: &Autocorrelation, background: &Background, lattice: &Lattice) -> Option<Judged> {
    let all = INDICES.into_iter().flat_map(bases);
    let coarse = all.filter_map(|[m, n]| Lattice::new(lattice.point(m), lattice.point(n)));
    let better = coarse.filter(|coarse| is_repeated(correlation, coarse)).filter_map(|coarse| {
        let (own, rest) = split(correlation, lattice, &coarse);
        let reach = reach_of_cell(&coarse);
        let deviation = |mean: &WeightedMean| background.near_deviation(mean.texels, reach);
        let noise = deviation(&own).hypot(deviation(&rest)) * (1.0 - own.mean()).max(0.05);
        let gain = own.mean() - rest.mean();
        let is_clear = own.count > 2 && rest.count > 0 && gain > (LOWER.0 * own.mean()).max(LOWER.1 * noise);
        is_clear.then(|| fitted(correlation, background, coarse))
    });
    better.max_by(|a, b| a.sure_share().total_cmp(&b.sure_share()))
}

/// The denser lattice whose further points are as high.
fn denser(correlation: &Autocorrelation, background: &Background, lattice: &Lattice) -> Option<Judged> {
    let fine = |index: i32, [m, n]: [[f64; 2]; 2]| {
        let part = |ij: [f64; 2]| lattice.point(ij.map(|c| c / f64::from(index)));
        Lattice::new(part(m), part(n))
    };
    let all = INDICES.into_iter().flat_map(|index| bases(index).map(move |basis| (index, basis)));
    let is_as_high = |fine: &Lattice| {
        let (own, rest) = split(correlation, fine, lattice);
        rest.count > 0 && rest.mean() >= (1.0 - LOWER.0) * own.mean()
    };
    let fine = all.filter_map(|(index, basis)| fine(index, basis)).find(is_as_high);
    fine.map(|fine| fitted(correlation, background, fine))
}

fn fitted(correlation: &Autocorrelation, background: &Background, lattice: Lattice) -> Judged {
    Judged::new(correlation, background, refine::lattice(correlation, lattice))
}

/// The bases of all sublattices of a prime index, in terms of the basis of the lattice (Hermite normal forms).
fn bases(index: i32) -> impl Iterator<Item = [[f64; 2]; 2]> {
    let n = f64::from(index);
    let sheared = (0..index).map(move |k| [[n, 0.0], [f64::from(k), 1.0]]);
    sheared.chain(std::iter::once([[1.0, 0.0], [0.0, n]]))
}

/// The mean correlation over the points of a sublattice, and over the other points of the fine lattice.
fn split(correlation: &Autocorrelation, fine: &Lattice, coarse: &Lattice) -> (WeightedMean, WeightedMean) {
    let (mut own, mut rest) = (WeightedMean::default(), WeightedMean::default());
    for place in visible(correlation, fine, FARTHEST).map(|ij| fine.point(ij)) {
        let is_own = coarse.coordinates(place).iter().all(|c| (c - c.round()).abs() < 0.1);
        (if is_own { &mut own } else { &mut rest }).add(correlation, place);
    }
    (own, rest)
}
