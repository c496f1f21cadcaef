//! A search from coarse to fine for large exemplars: all positions at a fraction of the resolution, and the best of them at
//! ever finer ones.
//!
//! Codes are averaged over squares of 2 x 2 texels, again and again; a block at a position that is a multiple of the
//! square's side has exactly the averages of its texels. At the coarsest level all positions are compared by correlation
//! ([`super::fft`]), the nearest are kept by their exact integer distances, and at each finer level their neighbours are
//! compared in full. Unlike the other searches this one may miss the nearest block, so it is used only where it is
//! asked for; its candidates depend on the exemplars and the query alone.

use std::collections::BTreeSet;

use super::distance::BlockTarget;
use super::fft::Spectra;
use super::{Avoided, BlockQuery, Candidates, Effort, Found, Search};
use crate::parallel;
use crate::size::Size;
use crate::synthesis::neighbourhood::{Margins, Neighbourhood};
use crate::synthesis::positions::Positions;
use crate::synthesis::quantise::{Quantised, mean};
use crate::synthesis::source_map::Texel;

/// The least longer side of the coarsest exemplar, which still shows what a texture consists of.
const LEAST_SIDE: usize = 512;
/// The largest reduction.
const MOST: usize = 8;
/// Positions that are kept at the coarsest level, and at finer ones.
const KEPT_COARSEST: usize = 48;
const KEPT: usize = 8;

/// The reduction for exemplars of some sizes and blocks with some overlap: a power of two, 1 for none.
pub fn reduction(sizes: impl Iterator<Item = Size>, overlap: usize) -> usize {
    let side = sizes.map(|size| size.width.max(size.height)).min().unwrap_or(0);
    let fits = |factor: &usize| side / factor >= LEAST_SIDE && overlap >= 2 * factor;
    [MOST, 4, 2].into_iter().find(fits).unwrap_or(1)
}

/// The memory for codes and spectra of reduced exemplars.
pub fn bytes(exemplars: &Quantised, factor: usize) -> u64 {
    let texels: usize = exemplars.texels().iter().map(|texels| texels.size().texels()).sum();
    let planes = exemplars.planes() as u64;
    let coarsest = (texels / factor.pow(2)) as u64;
    let threads = rayon::current_num_threads() as u64;
    texels as u64 * planes + coarsest * (8 * planes + 8 + 32 * threads)
}

/// The search.
pub struct CoarseToFine<'a> {
    exemplars: &'a Quantised,
    positions: &'a Positions,
    /// The exemplars halved once, twice and so on.
    reduced: Vec<Quantised>,
    /// The positions at the coarsest level.
    coarsest: Positions,
    spectra: Vec<Spectra>,
}

impl<'a> CoarseToFine<'a> {
    /// Reduces the exemplars by a power of two; `None` where masks leave no position that is a multiple of it.
    pub fn new(exemplars: &'a Quantised, positions: &'a Positions, factor: usize) -> Option<Self> {
        let coarsest = positions.every(factor)?;
        let mut reduced: Vec<Quantised> = Vec::new();
        for _ in 0..factor.ilog2() {
            reduced.push(reduced.last().unwrap_or(exemplars).averaged());
        }
        let last = reduced.last()?;
        let spectra = last.texels().iter().map(|texels| Spectra::new(texels, last.planes())).collect();
        Some(Self { exemplars, positions, reduced, coarsest, spectra })
    }

    fn look(&self, query: &BlockQuery) -> Found {
        let planes = self.exemplars.planes();
        let mut queries = vec![query.clone()];
        for _ in &self.reduced {
            queries.push(averaged(queries.last().expect("the query itself"), planes));
        }
        let levels = self.reduced.len();
        if self.coarsest.iter().all(|at| queries[levels].avoided.contains(at)) {
            queries.iter_mut().for_each(|query| query.avoided = Avoided::default());
        }
        let mut effort = Effort { examined: self.coarsest.count() as u64, verified: 0 };
        let mut kept = self.nearest(&queries[levels], &mut effort);
        for level in (0..levels).rev() {
            let mut near = self.refined(&kept, &queries[level], level, &mut effort);
            if level == 0 {
                return Found { candidates: Candidates::within(near, query.acceptance), effort };
            }
            near.sort_unstable_by_key(|(position, distance)| (*distance, *position));
            near.truncate(KEPT);
            kept = near.into_iter().map(|(position, _)| position).collect();
        }
        unreachable!("there is a reduced level")
    }

    /// The nearest positions at the coarsest level.
    fn nearest(&self, query: &BlockQuery, effort: &mut Effort) -> Vec<Texel> {
        let exemplars = self.reduced.last().expect("a reduced level");
        let approximate: Vec<(Vec<f64>, f64)> =
            self.spectra.iter().map(|spectra| spectra.distances(query, exemplars.planes())).collect();
        let mut all: Vec<(f64, f64, Texel)> = Vec::with_capacity(self.coarsest.count());
        for run in self.coarsest.runs() {
            let e = run.first.exemplar as usize;
            let (distances, error) = &approximate[e];
            let start = self.spectra[e].size().index(run.first.x as usize, run.first.y as usize);
            let values = distances[start..start + run.length].iter().enumerate();
            let values = values.map(|(i, value)| (value - error, value + error, run.first.offset(i, 0)));
            all.extend(values.filter(|(.., at)| !query.avoided.contains(*at)));
        }
        let last = KEPT_COARSEST.min(all.len()) - 1;
        // All that may be among the nearest, decided by exact integers.
        let (_, (_, limit, _), _) = all.select_nth_unstable_by(last, |a, b| a.1.total_cmp(&b.1));
        let limit = *limit;
        let targets = BlockTarget::all(query, exemplars);
        let within = all.iter().filter(|(least, ..)| *least <= limit).map(|(.., position)| *position);
        let mut exact: Vec<(u64, Texel)> = within.map(|at| (distance(&targets, at), at)).collect();
        effort.verified += exact.len() as u64;
        exact.sort_unstable();
        exact.truncate(KEPT_COARSEST);
        exact.into_iter().map(|(_, position)| position).collect()
    }

    /// The positions around those of the next coarser level, and at the finest also the likely ones, with distances, as far
    /// as they can be accepted or kept.
    fn refined(
        &self,
        kept: &[Texel],
        query: &BlockQuery,
        level: usize,
        effort: &mut Effort,
    ) -> Vec<(Texel, u64)> {
        let exemplars = level.checked_sub(1).map_or(self.exemplars, |reduced| &self.reduced[reduced]);
        let around = kept.iter().flat_map(|at| {
            (0..9u32).filter_map(|i| {
                let (x, y) = ((2 * at.x + i % 3).checked_sub(1)?, (2 * at.y + i / 3).checked_sub(1)?);
                Some(Texel { exemplar: at.exemplar, y, x })
            })
        });
        let likely = query.likely.iter().copied().filter(|_| level == 0);
        let valid = |at: &Texel| {
            !query.avoided.contains(*at)
                && self.positions.contains(Texel { x: at.x << level, y: at.y << level, ..*at })
        };
        let positions: BTreeSet<Texel> = around.chain(likely).filter(valid).collect();
        let targets = BlockTarget::all(query, exemplars);
        effort.verified += positions.len() as u64;
        let mut near: Vec<(Texel, u64)> = Vec::new();
        let mut nearest: Vec<u64> = Vec::new();
        for at in positions {
            // A farther one is neither among those that are kept, nor accepted beside the nearest so far.
            let limit = match (level, nearest.first(), nearest.get(KEPT - 1)) {
                (0, Some(best), _) => query.acceptance.limit(*best),
                (1.., _, Some(last)) => *last,
                _ => u64::MAX,
            };
            let target = &targets[at.exemplar as usize];
            if let Some(distance) = target.distance_within(at.x as usize, at.y as usize, limit) {
                near.push((at, distance));
                nearest.insert(nearest.partition_point(|other| *other <= distance), distance);
                nearest.truncate(KEPT);
            }
        }
        near
    }
}

impl Search for CoarseToFine<'_> {
    fn candidates(&self, queries: &[BlockQuery]) -> Vec<Found> {
        parallel::map(queries.iter(), |query| self.look(query))
    }
}

fn distance(targets: &[BlockTarget<'_>], at: Texel) -> u64 {
    let whole = targets[at.exemplar as usize].distance_within(at.x as usize, at.y as usize, u64::MAX);
    whole.expect("no limit")
}

/// The query at half the resolution: squares of texels that are filled.
fn averaged(query: &BlockQuery, planes: usize) -> BlockQuery {
    let Neighbourhood { extent, margins } = query.neighbourhood;
    let half = Size::new(extent.width / 2, extent.height / 2);
    let beyond = |length: usize, margin: usize| (length / 2).saturating_sub((length - margin).div_ceil(2));
    let margins = Margins {
        left: margins.left / 2,
        top: margins.top / 2,
        right: beyond(extent.width, margins.right),
        bottom: beyond(extent.height, margins.bottom),
    };
    let mut codes = Vec::with_capacity(half.texels() * planes);
    for (x, y) in (0..half.height).flat_map(|y| (0..half.width).map(move |x| (x, y))) {
        let corner = |i: usize| extent.index(2 * x + i % 2, 2 * y + i / 2) * planes;
        codes.extend((0..planes).map(|k| mean([0, 1, 2, 3].map(|i| query.codes[corner(i) + k]))));
    }
    BlockQuery {
        neighbourhood: Neighbourhood { extent: half, margins },
        codes,
        place: query.place.map(|at| at / 2),
        acceptance: query.acceptance,
        likely: Vec::new(),
        avoided: query.avoided.halved(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::Job;
    use crate::numeric::random::{Purpose, Stream};
    use crate::planes::Planes;
    use crate::synthesis::options::Tolerance;
    use crate::synthesis::quantise::Exemplar;
    use crate::synthesis::search::Acceptance;
    use crate::synthesis::search::plain::Plain;

    /// Waves of all lengths, so that half the resolution still shows most of the texture.
    fn smooth(size: Size) -> Planes {
        let mut stream = Stream::new(7, Purpose::Sample, [0]);
        let waves: Vec<[f64; 4]> = (0..12)
            .map(|_| std::array::from_fn(|k| if k < 2 { stream.unit() - 0.5 } else { 6.3 * stream.unit() }))
            .collect();
        let value = |at: usize| {
            let (x, y) = ((at % size.width) as f64, (at / size.width) as f64);
            waves.iter().map(|[a, b, p, _]| (0.6 * (a * x + b * y) + p).sin()).sum::<f64>() as f32
        };
        Planes::from_vec(size, 1, (0..size.texels()).map(value).collect()).unwrap()
    }

    fn query(exemplars: &Quantised, at: [usize; 2], margins: Margins) -> BlockQuery {
        let extent = Size::new(24, 24);
        let texels = &exemplars.texels()[0];
        let codes = (0..24).flat_map(|y| texels.run(at[0], at[1] + y, 24).to_vec()).collect();
        let neighbourhood = Neighbourhood { extent, margins };
        let acceptance = Acceptance::new(Tolerance::Relative(0.1), neighbourhood.texels(), exemplars.step());
        BlockQuery::alone(neighbourhood, codes, acceptance)
    }

    #[test]
    fn a_block_of_the_exemplar_itself_is_found_wherever_it_lies() {
        let index = smooth(Size::new(120, 90));
        let exemplar = [Exemplar { index: &index, excluded: None }];
        let exemplars = Quantised::new(&exemplar, &Job::default()).unwrap();
        let positions = Positions::new(&exemplar, 24).unwrap();
        for factor in [2, 4] {
            let search = CoarseToFine::new(&exemplars, &positions, factor).unwrap();
            for (at, margins) in [
                ([17, 33], Margins { left: 8, top: 8, right: 0, bottom: 0 }),
                ([64, 12], Margins { left: 0, top: 9, right: 8, bottom: 0 }),
                ([96, 66], Margins { left: 8, top: 9, right: 9, bottom: 8 }),
            ] {
                let query = query(&exemplars, at, margins);
                let found = search.candidates(std::slice::from_ref(&query)).swap_remove(0).candidates;
                let truth = Plain { exemplars: &exemplars, positions: &positions };
                let truth = truth.candidates(&[query]).swap_remove(0).candidates;
                assert_eq!(found.best, 0, "{factor} {at:?}");
                assert!(found.positions.iter().all(|position| truth.positions.contains(position)));
            }
        }
    }

    #[test]
    fn masked_positions_are_never_found() {
        let index = smooth(Size::new(96, 64));
        let mask: Vec<bool> = (0..index.size().texels()).map(|at| at % 96 >= 48).collect();
        let exemplar = [Exemplar { index: &index, excluded: Some(&mask) }];
        let exemplars = Quantised::new(&exemplar, &Job::default()).unwrap();
        let positions = Positions::new(&exemplar, 24).unwrap();
        let search = CoarseToFine::new(&exemplars, &positions, 2).unwrap();
        let query = query(&exemplars, [60, 20], Margins { left: 8, top: 8, right: 0, bottom: 0 });
        let found = search.candidates(&[query]).swap_remove(0).candidates;
        assert!(found.positions.iter().all(|at| positions.contains(*at)));
    }

    #[test]
    fn only_large_exemplars_with_wide_overlaps_are_reduced() {
        let of = |side: usize, overlap: usize| reduction([Size::new(side, side)].into_iter(), overlap);
        assert_eq!([of(500, 80), of(1024, 80), of(2048, 80), of(4096, 170), of(4096, 9)], [1, 2, 4, 8, 4]);
    }
}
