//! The lattice that explains the autocorrelation best.

use super::background::Background;
use super::score::{Judged, is_repeated, quick_share};
use super::{peaks, primitive, refine};
use crate::numeric::autocorrelation::Autocorrelation;
use crate::numeric::lattice::{Lattice, length};

/// Multiples of each basis vector that are examined first: enough for a mean, and few enough that the error of
/// the position of a peak, a tenth of a texel, does not grow beyond its width.
const SPAN: i32 = 3;
/// The number of lattices that are fitted and judged by all of their points.
const SHORTLIST: usize = 24;
/// Bases that differ by less, in texels, are of one lattice.
const ALIKE: f64 = 1.5;
/// Lattices with at least this fraction of the best share are equivalent: the densest of them is taken.
const NEARLY_BEST: f64 = 0.9;

/// The best lattice from pairs of peaks, if there is one.
pub fn best(correlation: &Autocorrelation, background: &Background) -> Option<Judged> {
    let shortlist = shortlist(correlation, background, &peaks::candidates(correlation));
    let fitted = shortlist.into_iter().map(|lattice| refine::lattice(correlation, lattice));
    let judged = fitted.map(|lattice| Judged::new(correlation, background, lattice));
    let good: Vec<Judged> = judged.filter(Judged::is_lattice).collect();
    let surest = good.iter().max_by(|a, b| a.sure_share().total_cmp(&b.sure_share()))?.share;
    let dense = good
        .into_iter()
        .filter(|judged| judged.share >= NEARLY_BEST * surest)
        .min_by(|a, b| a.lattice.cell_area().total_cmp(&b.lattice.cell_area()))?;
    Some(primitive::of(correlation, background, dense))
}

/// The different lattices of pairs of candidates that have the largest sure share by their nearest points.
fn shortlist(
    correlation: &Autocorrelation,
    background: &Background,
    candidates: &[[f64; 2]],
) -> Vec<Lattice> {
    let pairs = (0..candidates.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    let mut all: Vec<(f64, Lattice)> = pairs
        .filter_map(|(i, j)| Lattice::new(candidates[j], candidates[i]))
        .filter(|lattice| is_repeated(correlation, lattice))
        .map(|lattice| (quick_share(correlation, background, &lattice, SPAN), lattice))
        .collect();
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut kept: Vec<Lattice> = Vec::new();
    for (_, lattice) in all {
        if kept.len() == SHORTLIST {
            break;
        }
        if !kept.iter().any(|other| are_alike(other, &lattice)) {
            kept.push(lattice);
        }
    }
    kept
}

fn are_alike(a: &Lattice, b: &Lattice) -> bool {
    let pairs = a.basis().into_iter().zip(b.basis());
    pairs.into_iter().all(|(p, q)| length([p[0] - q[0], p[1] - q[1]]) < ALIKE)
}
