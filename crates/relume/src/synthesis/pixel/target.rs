//! A query prepared for one exemplar: positions pass first the sieve, then groups of terms.

use super::kernel::{CodePair, LANES, Term, add_all, largest_term, portable, reaches};
use super::plain::{NOWHERE, limit};
use super::sieve::{self, Sieve};
use super::window::WindowQuery;
use crate::size::Size;
use crate::synthesis::positions::PositionRun;
use crate::synthesis::quantise::MAX_CODE;
use crate::synthesis::source_map::Texel;

/// Terms between two checks of the limit.
const PATIENCE: usize = 8;

/// The same in the sieve, and at first: four texels, after which most positions are rejected.
const SIEVED: usize = 4;
const FIRST: usize = 2;

const _: () = assert!(PATIENCE as u64 * largest_term(MAX_CODE) <= u32::MAX as u64);

/// The number of terms of the sieve whose sum fits 32 bits.
const SIEVED_AT_MOST: usize = (u32::MAX as u64 / largest_term(sieve::SPAN)) as usize;

/// The near windows found so far.
pub struct NearWindows {
    best: u64,
    epsilon: f64,
    found: Vec<(Texel, u64)>,
}

impl NearWindows {
    /// Nothing yet, except that a position at the given distance is known.
    pub fn new(known: Option<u64>, epsilon: f64) -> Self {
        Self { best: known.unwrap_or(NOWHERE / 2), epsilon, found: Vec::new() }
    }

    /// Positions and their distances: all that are near enough, and some that seemed to be.
    pub fn found(&self) -> &[(Texel, u64)] {
        &self.found
    }

    fn limit(&self) -> u64 {
        limit(self.best, self.epsilon)
    }

    /// Keeps those of the positions from `first` to the right that are near enough.
    fn keep(&mut self, first: Texel, distances: [u64; LANES]) {
        for (i, distance) in distances.into_iter().enumerate() {
            if distance <= self.limit() {
                self.best = self.best.min(distance);
                self.found.push((first.offset(i, 0), distance));
            }
        }
    }
}

/// Terms whose factors are multiplied by 2 to the power of `shift`.
struct TapGroup {
    shift: u32,
    terms: Vec<Term>,
}

/// A query prepared for one exemplar.
pub struct WindowTarget<'a> {
    width: usize,
    pairs: &'a [CodePair],
    sieve: &'a Sieve,
    /// The first terms of the sieve, and the others.
    first_terms: [Term; FIRST],
    sieved: Vec<Term>,
    /// The sum of the factors of the sieve.
    weights: f64,
    /// The shift of the first groups and of the sieve.
    shift: u32,
    groups: Vec<TapGroup>,
    /// The number of first groups, with one shift, whose sum fits 32 bits.
    light: usize,
}

/// The terms of a query in an exemplar of the given size and numbers of copied and guide planes, in groups.
fn groups(query: &WindowQuery, size: Size, (copied, guides): (usize, usize)) -> Vec<TapGroup> {
    let mut groups: Vec<TapGroup> = Vec::new();
    let known = query.taps.iter().zip(query.codes.chunks_exact(copied)).map(|(t, c)| (t, c, 0));
    let guided = query.guide_taps.iter().zip(query.guide_codes.chunks_exact(guides.max(1)));
    let guided = guided.map(|(tap, codes)| (tap, codes, copied.div_ceil(2)));
    for (tap, codes, first_pair) in known.chain(guided) {
        let (x, y) = query.place(tap);
        for (p, pair) in codes.chunks(2).enumerate() {
            let codes = [pair[0], pair.get(1).copied().unwrap_or(0)];
            let offset = (first_pair + p) * size.texels() + size.index(x, y);
            let term = Term { offset, codes, factors: [tap.weight.factor; 2] };
            let open =
                |group: &&mut TapGroup| group.shift == tap.weight.shift && group.terms.len() < PATIENCE;
            match groups.last_mut().filter(open) {
                Some(group) => group.terms.push(term),
                None => {
                    let mut terms = Vec::with_capacity(PATIENCE);
                    terms.push(term);
                    groups.push(TapGroup { shift: tap.weight.shift, terms });
                }
            }
        }
    }
    groups
}

impl<'a> WindowTarget<'a> {
    /// A query for an exemplar of the given size and numbers of copied and guide planes, whose codes, like
    /// those of the query, are at most `peak`.
    pub fn new(
        query: &WindowQuery,
        size: Size,
        (copied, guides): (usize, usize),
        pairs: &'a [CodePair],
        (sieve, peak): (&'a Sieve, i16),
    ) -> Self {
        let groups = groups(query, size, (copied, guides));
        let shift = groups.first().map_or(0, |group| group.shift);
        let capacity = (u64::from(u32::MAX) / largest_term(peak)) as usize / PATIENCE;
        let light = groups.iter().take_while(|group| group.shift == shift).count().min(capacity);
        let first = (copied.div_ceil(2) + guides.div_ceil(2)) * size.texels();
        let mut sieved: Vec<Term> =
            sieve.terms(query, copied, size).into_iter().take(SIEVED_AT_MOST).collect();
        sieved.iter_mut().for_each(|term| term.offset += first);
        let weights = sieved.iter().flat_map(|term| term.factors).map(f64::from).sum();
        // A factor of 0 leaves the bounds as they are.
        sieved.resize(sieved.len().max(FIRST), Term::default());
        let rest = sieved.split_off(FIRST);
        let first_terms = [sieved[0], sieved[1]];
        Self { width: size.width, pairs, sieve, first_terms, sieved: rest, weights, shift, groups, light }
    }

    /// Examines all positions of runs in this exemplar.
    pub fn scan(&self, runs: &[PositionRun], near: &mut NearWindows) {
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = pulp::x86::V3::try_new() {
            return simd.vectorize(
                #[inline(always)]
                || {
                    self.scan_with(runs, near, |sums, term, there| {
                        super::kernel::avx2(simd, sums, term, there)
                    })
                },
            );
        }
        self.scan_with(runs, near, portable);
    }

    #[inline(always)]
    fn scan_with(
        &self,
        runs: &[PositionRun],
        near: &mut NearWindows,
        add: impl Fn(&mut [u32; LANES], &Term, &[CodePair; LANES]),
    ) {
        let mut most = near.limit();
        let mut bound = self.bound(most);
        // Kept in registers.
        let first_terms: [Term; FIRST] = self.first_terms;
        for &PositionRun { first, length } in runs {
            let start = first.y as usize * self.width + first.x as usize;
            let [one, two] = first_terms.map(|term| self.row(start + term.offset, length));
            for (number, (one, two)) in one.iter().zip(two).enumerate() {
                let mut bounds = [0; LANES];
                add(&mut bounds, &first_terms[0], one);
                add(&mut bounds, &first_terms[1], two);
                if !reaches(&bounds, bound) {
                    continue;
                }
                let done = number * LANES;
                let pairs = &self.pairs[start + done..];
                if !self.passes(&mut bounds, pairs, bound, &add) {
                    continue;
                }
                let lanes = LANES.min(length - done);
                if let Some(distances) = self.distances(pairs, lanes, most, &add) {
                    near.keep(first.offset(done, 0), distances);
                    most = near.limit();
                    bound = self.bound(most);
                }
            }
        }
    }

    /// The values at `length` consecutive places, [`LANES`] at a time, of which the last may be others.
    #[inline(always)]
    fn row(&self, start: usize, length: usize) -> &[[CodePair; LANES]] {
        self.pairs[start..][..length.next_multiple_of(LANES)].as_chunks().0
    }

    /// Whether any position can be near according to the rest of the sieve.
    #[inline(always)]
    fn passes(
        &self,
        bounds: &mut [u32; LANES],
        pairs: &[CodePair],
        bound: u32,
        add: impl Fn(&mut [u32; LANES], &Term, &[CodePair; LANES]),
    ) -> bool {
        self.sieved.chunks(SIEVED).all(|terms| {
            add_all(bounds, terms, pairs, &add);
            reaches(bounds, bound)
        })
    }

    /// The distances of `LANES` positions; `None` if none can be at most `most`.
    #[inline(always)]
    fn distances(
        &self,
        pairs: &[CodePair],
        lanes: usize,
        most: u64,
        add: impl Fn(&mut [u32; LANES], &Term, &[CodePair; LANES]),
    ) -> Option<[u64; LANES]> {
        let light = u32::try_from(most >> self.shift).unwrap_or(u32::MAX);
        let mut sums = [0; LANES];
        let near_so_far = self.groups[..self.light].iter().all(|group| {
            add_all(&mut sums, &group.terms, pairs, &add);
            reaches(&sums, light)
        });
        if !near_so_far {
            return None;
        }
        let mut distances = sums.map(|sum| u64::from(sum) << self.shift);
        distances[lanes..].fill(NOWHERE);
        self.add_rest(&mut distances, pairs, most, add).then_some(distances)
    }

    /// The largest sum in the sieve of a position at no more than the given distance.
    fn bound(&self, most: u64) -> u32 {
        self.sieve.limit(most >> self.shift, self.weights)
    }

    /// Adds the remaining groups; false when no distance can be at most `most`.
    #[inline(always)]
    fn add_rest(
        &self,
        distances: &mut [u64; LANES],
        pairs: &[CodePair],
        most: u64,
        add: impl Fn(&mut [u32; LANES], &Term, &[CodePair; LANES]),
    ) -> bool {
        self.groups[self.light..].iter().all(|group| {
            let mut sums = [0; LANES];
            add_all(&mut sums, &group.terms, pairs, &add);
            distances.iter_mut().zip(sums).for_each(|(d, sum)| *d += u64::from(sum) << group.shift);
            distances.iter().fold(false, |near, &d| near | (d <= most))
        })
    }
}
