//! The search of the pixel methods: 16 neighbouring positions at a time, given up together as soon
//! as none of them can be near enough.
//!
//! Index planes are stored in pairs, so that one instruction multiplies and adds the differences of
//! both. Texels are compared in the order of falling weight, which lets most positions go after a
//! few; a known good position gives the first limit. Sums are exact: 32 bits for as many terms as
//! the exemplars' largest code allows, then 64. The result is that of [`super::plain`].

use super::plain::{Matches, distance, limit};
use super::window::{MAX_FACTOR, Query};
use crate::error::Result;
use crate::limits::Limits;
use crate::synthesis::positions::Positions;
use crate::synthesis::quantise::{IndexTexels, MAX_CODE, Quantised};
use crate::synthesis::source_map::Texel;

/// Neighbouring positions compared at a time.
const LANES: usize = 16;

/// Terms between two looks at the limit.
const PATIENCE: usize = 8;

const _: () = assert!(PATIENCE as u64 * largest_term(MAX_CODE) <= u32::MAX as u64);

/// The largest weighted square of two planes whose codes are at most `peak`, before its shift.
const fn largest_term(peak: i16) -> u64 {
    MAX_FACTOR as u64 * 2 * (peak as u64).pow(2)
}

/// More than any distance, and far from overflowing: marks lanes that hold no position.
const NOWHERE: u64 = 1 << 62;

/// Two planes' codes of one texel.
type Pair = [i16; 2];

/// Exemplars made ready to be searched.
#[derive(Debug)]
pub struct Scan<'a> {
    exemplars: &'a Quantised,
    positions: &'a Positions,
    paired: Vec<Vec<Pair>>,
    /// The last planes, which are guides.
    guides: usize,
    /// The largest code.
    peak: i16,
}

impl<'a> Scan<'a> {
    /// Prepares exemplars.
    ///
    /// # Errors
    /// When that exceeds the limits.
    pub fn new(exemplars: &'a Quantised, positions: &'a Positions, limits: &Limits) -> Result<Self> {
        Self::guided(exemplars, positions, 0, limits)
    }

    /// Prepares exemplars whose last `guides` planes are guides.
    ///
    /// # Errors
    /// When that exceeds the limits.
    pub fn guided(
        exemplars: &'a Quantised,
        positions: &'a Positions,
        guides: usize,
        limits: &Limits,
    ) -> Result<Self> {
        let copied = exemplars.planes() - guides;
        let count = copied.div_ceil(2) + guides.div_ceil(2);
        let length = |texels: &IndexTexels| texels.size().texels() * count + LANES;
        let pairs: usize = exemplars.texels().iter().map(length).sum();
        limits.check_bytes("preparing the search", (pairs * size_of::<Pair>()) as u64)?;
        let paired = exemplars.texels().iter().map(|texels| pair_up(texels, copied, guides)).collect();
        let codes = exemplars.texels().iter().flat_map(|texels| texels.codes());
        let peak = codes.copied().max().unwrap_or(0);
        Ok(Self { exemplars, positions, paired, guides, peak })
    }

    /// All positions within (1 + `epsilon`) of the nearest; `hints` are positions that are likely
    /// to be near, whatever they are they change the time only.
    pub fn matches(&self, query: &Query, epsilon: f64, hints: &[Texel]) -> Matches {
        let known = hints.iter().map(|&hint| distance(self.exemplars, query, hint)).min();
        let mut near = Near { best: known.unwrap_or(NOWHERE / 2), epsilon, found: Vec::new() };
        let targets: Vec<Target<'_>> = self.targets(query);
        for run in self.positions.runs() {
            let target = &targets[run.first.exemplar as usize];
            target.scan(run.first, run.length, &mut near);
        }
        Matches::within(&near.found, epsilon)
    }

    fn targets(&'a self, query: &Query) -> Vec<Target<'a>> {
        let codes = query.codes.iter().chain(&query.guide_codes);
        let peak = codes.fold(self.peak, |peak, &code| peak.max(code)).max(1);
        let capacity = (u64::from(u32::MAX) / largest_term(peak)) as usize / PATIENCE;
        let texels = self.exemplars.texels().iter().zip(&self.paired);
        let target = |(texels, pairs): (&'a IndexTexels, &'a Vec<Pair>)| {
            let planes = (self.exemplars.planes() - self.guides, self.guides);
            Target::new(query, texels, planes, pairs, capacity)
        };
        texels.map(target).collect()
    }
}

/// The copied planes of an exemplar in pairs, the last one alone where their number is odd, and those
/// of its guides likewise; pair after pair, followed by [`LANES`] that are read and not used.
fn pair_up(texels: &IndexTexels, copied: usize, guides: usize) -> Vec<Pair> {
    let (size, planes) = (texels.size(), copied + guides);
    let codes = &texels.codes()[..size.texels() * planes];
    let mut pairs = Vec::with_capacity(size.texels() * (copied.div_ceil(2) + guides.div_ceil(2)) + LANES);
    let firsts =
        (0..copied).step_by(2).map(|k| (k, copied)).chain((copied..planes).step_by(2).map(|k| (k, planes)));
    for (k, end) in firsts {
        let pair = |texel: &[i16]| [texel[k], texel[..end].get(k + 1).copied().unwrap_or(0)];
        pairs.extend(codes.chunks_exact(planes).map(pair));
    }
    pairs.extend([[0; 2]; LANES]);
    pairs
}

/// What has been found near enough so far.
struct Near {
    best: u64,
    epsilon: f64,
    found: Vec<(Texel, u64)>,
}

impl Near {
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

/// Two planes of one known texel.
#[derive(Debug, Clone, Copy)]
struct Term {
    /// Where they are compared, counted from the pair of the position.
    offset: usize,
    codes: Pair,
    factor: i16,
}

/// Terms whose factors count 2 to the power of `shift`.
struct Group {
    shift: u32,
    terms: Vec<Term>,
}

/// A query made ready for one exemplar.
struct Target<'a> {
    width: usize,
    pairs: &'a [Pair],
    groups: Vec<Group>,
    /// The first groups, of one shift, whose sum fits 32 bits.
    light: usize,
}

impl<'a> Target<'a> {
    fn new(
        query: &Query,
        exemplar: &IndexTexels,
        (copied, guides): (usize, usize),
        pairs: &'a [Pair],
        capacity: usize,
    ) -> Self {
        let size = exemplar.size();
        let mut groups: Vec<Group> = Vec::new();
        let known = query.taps.iter().zip(query.codes.chunks_exact(copied)).map(|(t, c)| (t, c, 0));
        let guided = query.guide_taps.iter().zip(query.guide_codes.chunks_exact(guides.max(1)));
        let guided = guided.map(|(tap, codes)| (tap, codes, copied.div_ceil(2)));
        for (tap, codes, first_pair) in known.chain(guided) {
            let (x, y) = query.place(tap);
            for (p, pair) in codes.chunks(2).enumerate() {
                let codes = [pair[0], pair.get(1).copied().unwrap_or(0)];
                let offset = (first_pair + p) * size.texels() + size.index(x, y);
                let term = Term { offset, codes, factor: tap.weight.factor };
                let open =
                    |group: &&mut Group| group.shift == tap.weight.shift && group.terms.len() < PATIENCE;
                match groups.last_mut().filter(open) {
                    Some(group) => group.terms.push(term),
                    None => groups.push(Group { shift: tap.weight.shift, terms: vec![term] }),
                }
            }
        }
        let same = groups.iter().take_while(|group| group.shift == groups[0].shift).count();
        let light = same.min(capacity);
        Self { width: size.width, pairs, groups, light }
    }

    /// Looks at `length` positions from `first` to the right.
    fn scan(&self, first: Texel, length: usize, near: &mut Near) {
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = pulp::x86::V3::try_new() {
            return simd.vectorize(
                #[inline(always)]
                || self.scan_with(first, length, near, |sums, terms, pairs| avx2(simd, sums, terms, pairs)),
            );
        }
        self.scan_with(first, length, near, portable);
    }

    #[inline(always)]
    fn scan_with(
        &self,
        first: Texel,
        length: usize,
        near: &mut Near,
        add: impl Fn(&mut [u32; LANES], &[Term], &[Pair]),
    ) {
        let start = first.y as usize * self.width + first.x as usize;
        let shift = self.groups.first().map_or(0, |group| group.shift);
        let mut most = near.limit();
        for done in (0..length).step_by(LANES) {
            let pairs = &self.pairs[start + done..];
            let light = u32::try_from(most >> shift).unwrap_or(u32::MAX);
            let mut sums = [0; LANES];
            let near_so_far = self.groups[..self.light].iter().all(|group| {
                add(&mut sums, &group.terms, pairs);
                sums.iter().any(|&sum| sum <= light)
            });
            if !near_so_far {
                continue;
            }
            let mut distances = sums.map(|sum| u64::from(sum) << shift);
            distances[LANES.min(length - done)..].fill(NOWHERE);
            if self.add_rest(&mut distances, pairs, most, &add) {
                near.keep(first.offset(done, 0), distances);
                most = near.limit();
            }
        }
    }

    /// Adds the groups that are not light; false when no distance can be at most `most`.
    #[inline(always)]
    fn add_rest(
        &self,
        distances: &mut [u64; LANES],
        pairs: &[Pair],
        most: u64,
        add: impl Fn(&mut [u32; LANES], &[Term], &[Pair]),
    ) -> bool {
        self.groups[self.light..].iter().all(|group| {
            let mut sums = [0; LANES];
            add(&mut sums, &group.terms, pairs);
            distances.iter_mut().zip(sums).for_each(|(d, sum)| *d += u64::from(sum) << group.shift);
            distances.iter().any(|&d| d <= most)
        })
    }
}

/// Adds the weighted squares of terms at [`LANES`] positions, in AVX2 instructions.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn avx2(simd: pulp::x86::V3, sums: &mut [u32; LANES], terms: &[Term], pairs: &[Pair]) {
    use std::arch::x86_64::__m256i;
    let mut totals: [__m256i; 2] = pulp::cast(*sums);
    for term in terms {
        let mut there = [[0i16; 2]; LANES];
        there.copy_from_slice(&pairs[term.offset..][..LANES]);
        let there: [__m256i; 2] = pulp::cast(there);
        let (codes, factor) = (pulp::cast([term.codes; LANES / 2]), pulp::cast([term.factor; LANES]));
        for (there, total) in there.into_iter().zip(&mut totals) {
            let difference = simd.avx2._mm256_sub_epi16(there, codes);
            let weighted = simd.avx2._mm256_mullo_epi16(difference, factor);
            *total = simd.avx2._mm256_add_epi32(*total, simd.avx2._mm256_madd_epi16(difference, weighted));
        }
    }
    *sums = pulp::cast(totals);
}

/// The same without particular instructions.
fn portable(sums: &mut [u32; LANES], terms: &[Term], pairs: &[Pair]) {
    for term in terms {
        for (sum, there) in sums.iter_mut().zip(&pairs[term.offset..][..LANES]) {
            for (a, b) in there.iter().zip(term.codes) {
                let difference = i32::from(a - b);
                *sum += (difference * difference * i32::from(term.factor)).unsigned_abs();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::Stream;
    use crate::planes::{Planes, Size};
    use crate::synthesis::pixel::plain;
    use crate::synthesis::pixel::window::Window;
    use crate::synthesis::quantise::Exemplar;
    use proptest::prelude::*;

    fn noise(size: Size, planes: usize, levels: usize, stream: &mut Stream) -> Planes {
        let data = (0..size.texels() * planes).map(|_| stream.below(levels) as f32).collect();
        Planes::from_vec(size, planes, data).unwrap()
    }

    /// A query of the window's taps, some left out, of random codes or of a window of the exemplar.
    fn query(window: &Window, q: &Quantised, positions: &Positions, stream: &mut Stream) -> Query {
        let copied = (stream.below(2) == 0).then(|| positions.nth(stream.below(positions.count())));
        let share = 1 + stream.below(4);
        let mut query = Query { radius: window.radius(), ..Query::default() };
        for tap in window.taps() {
            if stream.below(4) >= share {
                continue;
            }
            let (x, y) = query.place(tap);
            query.taps.push(*tap);
            match copied {
                Some(at) => {
                    let from = &q.texels()[at.exemplar as usize];
                    query.codes.extend_from_slice(from.run(at.x as usize + x, at.y as usize + y, 1));
                }
                None => query.codes.extend((0..q.planes()).map(|_| stream.below(4096) as i16)),
            }
        }
        query
    }

    proptest! {
        #[test]
        fn equals_the_plain_search(
            (half, planes, seed) in (1usize..7, 1usize..8, any::<u64>()),
            (extra_x, extra_y, several) in (0usize..37, 0usize..9, 1usize..3),
            (gaussian, masked, few) in (any::<bool>(), any::<bool>(), any::<bool>()),
            epsilon in prop_oneof![Just(0.0), Just(0.1), Just(3.0)],
        ) {
            let side = 2 * half + 1;
            let mut stream = Stream::new(seed, 0);
            let levels = if few { 3 } else { 100_000 };
            let fields: Vec<Planes> = (0..several)
                .map(|e| noise(Size::new(side + extra_x + e, side + extra_y), planes, levels, &mut stream))
                .collect();
            let masks: Vec<Vec<bool>> = fields
                .iter()
                .map(|f| (0..f.size().texels()).map(|_| masked && stream.below(150) == 0).collect())
                .collect();
            let exemplars: Vec<Exemplar<'_>> =
                fields.iter().zip(&masks).map(|(index, mask)| Exemplar { index, excluded: Some(mask) }).collect();
            let limits = Limits::default();
            let quantised = Quantised::new(&exemplars, &limits).unwrap();
            let Ok(positions) = Positions::new(&exemplars, side) else { return Ok(()) };
            let window = if gaussian { Window::gaussian(side) } else { Window::uniform(side) };
            let scan = Scan::new(&quantised, &positions, &limits).unwrap();
            for _ in 0..4 {
                let query = query(&window, &quantised, &positions, &mut stream);
                let hints: Vec<Texel> =
                    (0..stream.below(3)).map(|_| positions.nth(stream.below(positions.count()))).collect();
                let truth = plain::matches(&quantised, &positions, &query, epsilon);
                prop_assert_eq!(scan.matches(&query, epsilon, &hints), truth);
            }
        }
    }

    #[test]
    fn processors_without_these_instructions_get_the_same_sums() {
        let mut stream = Stream::new(3, 0);
        let mut code = || stream.below(4096) as i16;
        let pairs: Vec<Pair> = (0..200).map(|_| [code(), code()]).collect();
        let terms: Vec<Term> =
            (0..PATIENCE).map(|i| Term { offset: i * 20, codes: [code(), code()], factor: 8 }).collect();
        let (far, near) = ([[MAX_CODE; 2]; LANES], Term { offset: 0, codes: [0; 2], factor: MAX_FACTOR });
        let mut slow = [7; LANES];
        portable(&mut slow, &terms, &pairs);
        let mut largest = [0; LANES];
        portable(&mut largest, &[near; PATIENCE], &far);
        assert_eq!(largest, [PATIENCE as u32 * largest_term(MAX_CODE) as u32; LANES]);
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = pulp::x86::V3::try_new() {
            let (mut fast, mut fast_largest) = ([7; LANES], [0; LANES]);
            avx2(simd, &mut fast, &terms, &pairs);
            avx2(simd, &mut fast_largest, &[near; PATIENCE], &far);
            assert_eq!((fast, fast_largest), (slow, largest));
        }
    }
}
