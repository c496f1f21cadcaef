//! Search for the blocks of the exemplars that fit the filled texels.
//!
//! - [`brute`]: every position, many codes at a time;
//! - [`projection`]: lower bounds from a few projections reject most positions;
//! - [`fft`]: all distances at once by correlation;
//! - [`plain`]: every position, texel by texel: the slow truth;
//! - [`coarse`]: the best positions of a reduced resolution, for large exemplars, where it is asked for;
//! - [`guided`]: every position, for blocks that also follow a guide.
//!
//! All but the last two give identical candidates: distances are exact integers ([`distance`]), thresholds are
//! integers, and candidates are in the order of exemplar, row, column. [`plan`] chooses.

mod avoided;
pub mod brute;
pub mod coarse;
pub mod distance;
pub mod fft;
pub mod guided;
mod options;
pub mod plain;
pub mod plan;
pub mod projection;

pub use avoided::Avoided;
pub use options::{KernelBasis, SearchMethod, SearchOptions};

use serde::Serialize;

use super::neighbourhood::Neighbourhood;
use super::options::Tolerance;
use super::source_map::Texel;

/// The query of a block.
#[derive(Debug, Clone, PartialEq)]
pub struct BlockQuery {
    /// Its filled texels.
    pub neighbourhood: Neighbourhood,
    /// The column and row of its first texel in the output, where a guide applies.
    pub place: [usize; 2],
    /// The codes of the whole extent, the planes of a texel adjacent, row by row; those of texels that are
    /// not filled have no meaning.
    pub codes: Vec<i16>,
    /// The accepted distances.
    pub acceptance: Acceptance,
    /// Hints: valid positions among them are expected to be near; they affect speed only.
    pub likely: Vec<Texel>,
    /// Positions that are no candidates; some others are left.
    pub avoided: Avoided,
}

#[cfg(test)]
impl BlockQuery {
    /// A query at the top left, without hints and positions to leave out.
    fn alone(neighbourhood: Neighbourhood, codes: Vec<i16>, acceptance: Acceptance) -> Self {
        Self {
            neighbourhood,
            place: [0, 0],
            codes,
            acceptance,
            likely: Vec::new(),
            avoided: Avoided::default(),
        }
    }
}

/// The positions of candidate blocks.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Candidates {
    /// The smallest squared distance over all positions.
    pub best: u64,
    /// All positions within the acceptance of it, in order.
    pub positions: Vec<Texel>,
}

impl Candidates {
    /// The accepted positions, given with their distances and including the nearest of all.
    pub fn within(near: Vec<(Texel, u64)>, acceptance: Acceptance) -> Self {
        let best = near.iter().map(|(_, distance)| *distance).min().unwrap_or(0);
        let limit = acceptance.limit(best);
        let accepted = near.into_iter().filter(|(_, distance)| *distance <= limit);
        Self { best, positions: accepted.map(|(position, _)| position).collect() }
    }
}

/// The effort of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Effort {
    /// Positions examined.
    pub examined: u64,
    /// Positions compared in full, or until they were too far; bounds rejected or accepted the others.
    pub verified: u64,
}

impl Effort {
    /// Adds the effort of another search.
    pub fn add(&mut self, other: &Self) {
        self.examined += other.examined;
        self.verified += other.verified;
    }
}

/// The result of a search.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Found {
    /// The same for every search.
    pub candidates: Candidates,
    /// The effort of this one.
    pub effort: Effort,
}

/// Which squared distances are accepted, given the smallest one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Acceptance {
    factor: f64,
    always: u64,
}

impl Acceptance {
    /// The acceptance of a tolerance for neighbourhoods of `texels` texels in codes of `step`.
    pub fn new(tolerance: Tolerance, texels: usize, step: f64) -> Self {
        match tolerance {
            Tolerance::Relative(amount) => Self { factor: (1.0 + amount).powi(2), always: 0 },
            Tolerance::Absolute(delta) => {
                Self { factor: 1.0, always: ((delta / step).powi(2) * texels as f64) as u64 }
            }
        }
    }

    /// The largest accepted squared distance when `best` is the smallest. It increases with `best`, so the
    /// limit of a part of the positions never rejects a candidate of the whole.
    pub fn limit(self, best: u64) -> u64 {
        best.max(self.always).max((best as f64 * self.factor) as u64)
    }

    /// The numbers of the squared distances accepted of some, and those; the largest number stands for a position that is
    /// left out.
    fn near(self, distances: Vec<u64>) -> impl Iterator<Item = (usize, u64)> {
        let limit = self.limit(distances.iter().copied().min().unwrap_or(u64::MAX)).min(u64::MAX - 1);
        distances.into_iter().enumerate().filter(move |(_, distance)| *distance <= limit)
    }
}

/// A method of finding candidates.
pub trait Search: Sync {
    /// For each query all positions whose squared distance is accepted, and the smallest distance.
    fn candidates(&self, queries: &[BlockQuery]) -> Vec<Found>;

    /// The number of positions that remain after each projection of a query whose smallest distance is
    /// `best`; `None` for a search without projections.
    fn rejection_curve(&self, _query: &BlockQuery, _best: u64) -> Option<Vec<u64>> {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::plain::Plain;
    use super::plan::Recipe;
    use super::projection::cells;
    use super::*;
    use crate::job::Job;
    use crate::numeric::random::{Purpose, Stream};
    use crate::planes::Planes;
    use crate::size::Size;
    use crate::synthesis::neighbourhood::Margins;
    use crate::synthesis::positions::Positions;
    use crate::synthesis::quantise::{Exemplar, MAX_CODE, Quantised};
    use proptest::prelude::*;

    #[test]
    fn acceptance_is_the_tolerance_squared() {
        let relative = Acceptance::new(Tolerance::Relative(0.1), 100, 0.5);
        assert_eq!((relative.limit(0), relative.limit(100), relative.limit(1000)), (0, 121, 1210));
        assert_eq!(Acceptance::new(Tolerance::Relative(0.0), 1, 1.0).limit(7), 7);
        let absolute = Acceptance::new(Tolerance::Absolute(2.0), 10, 0.5);
        assert_eq!((absolute.limit(3), absolute.limit(500)), (160, 500));
    }

    /// Every member of the family for blocks whose margins are 0 or at least `narrow`.
    fn recipes(block: usize, narrow: usize) -> Vec<Recipe> {
        let side = cells::side(narrow);
        let bases = [KernelBasis::Svd, KernelBasis::Dct, KernelBasis::WalshHadamard];
        let kernels = [1, 3, 9];
        let projections = bases.into_iter().zip(kernels);
        let projections =
            projections.map(|(basis, kernels)| Recipe::Projection { block, side, basis, kernels });
        projections.chain([Recipe::Fft, Recipe::Brute]).collect()
    }

    fn smooth_noise(size: Size, planes: usize, stream: &mut Stream) -> Planes {
        let mut planes = Planes::zeros(size, planes);
        for plane in planes.iter_mut() {
            let mut value = 0.0;
            plane.iter_mut().for_each(|v| {
                value = 0.8 * value + stream.unit() as f32 - 0.5;
                *v = value;
            });
        }
        planes
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(60))]
        #[test]
        fn every_search_equals_the_plain_one(
            (block, planes, seed) in (3usize..14, 1usize..19, any::<u64>()),
            (extra_x, extra_y, several) in (0usize..17, 0usize..13, 1usize..4),
            (narrow, widths) in (1usize..7, [0usize..3, 0usize..3, 0usize..3, 0usize..3]),
            tolerance in prop_oneof![Just(Tolerance::Relative(0.0)), Just(Tolerance::Relative(0.1)), Just(Tolerance::Absolute(0.6))],
            (masked, copied, count) in (any::<bool>(), any::<bool>(), 1usize..12),
        ) {
            let mut stream = Stream::new(seed, Purpose::Sample, [0]);
            let fields: Vec<Planes> = (0..several)
                .map(|e| smooth_noise(Size::new(block + extra_x + e, block + extra_y), planes, &mut stream))
                .collect();
            let masks: Vec<Vec<bool>> = fields
                .iter()
                .map(|f| (0..f.size().texels()).map(|_| masked && stream.below(200) == 0).collect())
                .collect();
            let exemplars: Vec<Exemplar<'_>> =
                fields.iter().zip(&masks).map(|(index, mask)| Exemplar { index, excluded: Some(mask) }).collect();
            let quantised = Quantised::new(&exemplars, &Job::default()).unwrap();
            let Ok(positions) = Positions::new(&exemplars, block) else { return Ok(()) };
            let narrow = narrow.min(block / 2);
            let wide = (narrow + 1).min(block / 2);
            let [left, top, right, bottom] = widths.map(|w| [0, narrow, wide][w]);
            let margins = Margins { left, top, right, bottom };
            let neighbourhood = Neighbourhood { extent: Size::new(block, block), margins };
            let codes = if copied {
                let place = positions.nth(stream.below(positions.count()));
                let from = &quantised.texels()[place.exemplar as usize];
                (0..block).flat_map(|y| from.run(place.x as usize, place.y as usize + y, block).to_vec()).collect()
            } else {
                (0..block * block * planes).map(|_| stream.below(4096) as i16).collect()
            };
            let acceptance = Acceptance::new(tolerance, neighbourhood.texels(), quantised.step());
            let likely = vec![Texel { exemplar: 0, y: 1, x: 2 }, Texel { exemplar: 7, y: 0, x: 0 }];
            let mut avoided = Avoided::default();
            if copied {
                avoided.add(positions.nth(stream.below(positions.count())), (seed % 4) as u32, positions.count() / 2);
            }
            let query = BlockQuery { neighbourhood, place: [0, 0], codes, acceptance, likely, avoided };
            // Further queries: some of its shape, one of another.
            let mut queries = vec![query; count];
            for (i, query) in queries.iter_mut().enumerate().skip(1) {
                query.codes.iter_mut().for_each(|code| *code = (*code / 2 + stream.below(2048) as i16) % 4096);
                query.neighbourhood.margins.left = if i == 4 { 0 } else { left };
            }
            let truth = Plain { exemplars: &quantised, positions: &positions }.candidates(&queries);
            for recipe in recipes(block, narrow) {
                let found = recipe.prepare(&quantised, &positions, None, &Job::default()).unwrap().candidates(&queries);
                prop_assert_eq!(found.len(), count);
                for (found, truth) in found.iter().zip(&truth) {
                    prop_assert_eq!(&found.candidates, &truth.candidates, "{:?}", recipe);
                }
            }
        }
    }

    #[test]
    fn the_largest_differences_do_not_overflow() {
        let (block, planes) = (60, 18);
        let size = Size::new(90, 60);
        let values = (0..size.texels() * planes).map(|i| if i == 0 { 0.0 } else { 1.0 });
        let field = Planes::from_vec(size, planes, values.collect()).unwrap();
        let exemplars = [Exemplar { index: &field, excluded: None }];
        let mut quantised = Quantised::new(&exemplars, &Job::default()).unwrap();
        quantised.fill_for_tests(MAX_CODE);
        let positions = Positions::new(&exemplars, block).unwrap();
        let margins = Margins { left: 30, top: 30, right: 30, bottom: 30 };
        let neighbourhood = Neighbourhood { extent: Size::new(block, block), margins };
        let acceptance = Acceptance::new(Tolerance::Relative(0.0), block * block, 1.0);
        let codes = vec![0; block * block * planes];
        let query = [BlockQuery::alone(neighbourhood, codes, acceptance)];
        for recipe in recipes(block, 29) {
            let found =
                &recipe.prepare(&quantised, &positions, None, &Job::default()).unwrap().candidates(&query)[0]
                    .candidates;
            assert_eq!(found.best, 3600 * planes as u64 * 4095 * 4095, "{recipe:?}");
            assert_eq!(found.positions.len(), 31, "{recipe:?}");
        }
    }
}
