//! The search of the pixel methods: 16 neighbouring positions at a time, abandoned together once none of them
//! can be near enough.
//!
//! Index planes are stored in pairs, so that one instruction multiplies and adds the differences of both. The
//! lower bounds of [`super::sieve`] reject most positions; the texels of the others are compared in the order
//! of decreasing weight. A known good position gives the first limit. Sums are exact: 32 bits for as many
//! terms as the largest code of the exemplars allows, then 64. The result is that of [`super::plain`].

use super::kernel::{CodePair, LANES};
use super::plain::{Matches, distance};
use super::sieve::Sieve;
use super::target::{NearWindows, WindowTarget};
use super::window::WindowQuery;
use crate::error::Result;
use crate::job::{Held, Job};
use crate::synthesis::positions::Positions;
use crate::synthesis::quantise::{IndexTexels, Quantised};
use crate::synthesis::source_map::Texel;

/// Exemplars prepared for a search.
#[derive(Debug)]
pub struct Scan<'a> {
    exemplars: &'a Quantised,
    positions: &'a Positions,
    sieve: Sieve,
    paired: Vec<Vec<CodePair>>,
    /// The number of the last planes, which are guides.
    guides: usize,
    /// The largest code.
    peak: i16,
    _held: Held,
}

impl<'a> Scan<'a> {
    /// Prepares exemplars.
    ///
    /// # Errors
    /// When that exceeds the limits.
    pub fn new(exemplars: &'a Quantised, positions: &'a Positions, job: &Job) -> Result<Self> {
        Self::guided(exemplars, positions, 0, job)
    }

    /// Prepares exemplars whose last `guides` planes are guides.
    ///
    /// # Errors
    /// When that exceeds the limits.
    pub fn guided(
        exemplars: &'a Quantised,
        positions: &'a Positions,
        guides: usize,
        job: &Job,
    ) -> Result<Self> {
        let copied = exemplars.planes() - guides;
        let sieve = Sieve::new(exemplars, copied);
        let count = copied.div_ceil(2) + guides.div_ceil(2) + sieve.axes();
        let length = |texels: &IndexTexels| texels.size().texels() * count + LANES;
        let pairs: usize = exemplars.texels().iter().map(length).sum();
        let held = job.hold("preparing the search", (pairs * size_of::<CodePair>()) as u64)?;
        let paired =
            exemplars.texels().iter().map(|texels| pair_up(texels, copied, guides, &sieve)).collect();
        let codes = exemplars.texels().iter().flat_map(|texels| texels.codes());
        let peak = codes.copied().max().unwrap_or(0);
        Ok(Self { exemplars, positions, sieve, paired, guides, peak, _held: held })
    }

    /// All positions within (1 + `epsilon`) of the nearest; `hints` are positions likely to be near: they
    /// affect speed only.
    pub fn matches(&self, query: &WindowQuery, epsilon: f64, hints: &[Texel]) -> Matches {
        let known = hints.iter().map(|&hint| distance(self.exemplars, query, hint)).min();
        let mut near = NearWindows::new(known, epsilon);
        let targets: Vec<WindowTarget<'_>> = self.targets(query);
        for runs in self.positions.runs().chunk_by(|a, b| a.first.exemplar == b.first.exemplar) {
            targets[runs[0].first.exemplar as usize].scan(runs, &mut near);
        }
        Matches::within(near.found(), epsilon)
    }

    fn targets(&'a self, query: &WindowQuery) -> Vec<WindowTarget<'a>> {
        let codes = query.codes.iter().chain(&query.guide_codes);
        let peak = codes.fold(self.peak, |peak, &code| peak.max(code)).max(1);
        let texels = self.exemplars.texels().iter().zip(&self.paired);
        let target = |(texels, pairs): (&'a IndexTexels, &'a Vec<CodePair>)| {
            let planes = (self.exemplars.planes() - self.guides, self.guides);
            WindowTarget::new(query, texels.size(), planes, pairs, (&self.sieve, peak))
        };
        texels.map(target).collect()
    }
}

/// The copied planes of an exemplar in pairs, the last one alone if their number is odd, and those of its
/// guides likewise; pair after pair, then those of the sieve, followed by [`LANES`] values that are read but
/// not used.
fn pair_up(texels: &IndexTexels, copied: usize, guides: usize, sieve: &Sieve) -> Vec<CodePair> {
    let (size, planes) = (texels.size(), copied + guides);
    let codes = &texels.codes()[..size.texels() * planes];
    let count = copied.div_ceil(2) + guides.div_ceil(2) + sieve.axes();
    let mut pairs = Vec::with_capacity(size.texels() * count + LANES);
    let firsts =
        (0..copied).step_by(2).map(|k| (k, copied)).chain((copied..planes).step_by(2).map(|k| (k, planes)));
    for (k, end) in firsts {
        let pair = |texel: &[i16]| [texel[k], texel[..end].get(k + 1).copied().unwrap_or(0)];
        pairs.extend(codes.chunks_exact(planes).map(pair));
    }
    pairs.extend(sieve.pairs(texels, planes));
    pairs.extend([[0; 2]; LANES]);
    pairs
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};
    use crate::planes::Planes;
    use crate::size::Size;
    use crate::synthesis::pixel::plain;
    use crate::synthesis::pixel::window::ComparedWindow;
    use crate::synthesis::quantise::Exemplar;
    use proptest::prelude::*;

    fn noise(size: Size, planes: usize, levels: usize, stream: &mut Stream) -> Planes {
        let data = (0..size.texels() * planes).map(|_| stream.below(levels) as f32).collect();
        Planes::from_vec(size, planes, data).unwrap()
    }

    /// A query of the taps of a window, some left out, with random codes or those of a window of the
    /// exemplar.
    fn query(
        window: &ComparedWindow,
        q: &Quantised,
        positions: &Positions,
        stream: &mut Stream,
    ) -> WindowQuery {
        let copied = (stream.below(2) == 0).then(|| positions.nth(stream.below(positions.count())));
        let share = 1 + stream.below(4);
        let mut query = WindowQuery { radius: window.radius(), ..WindowQuery::default() };
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
            let mut stream = Stream::new(seed, Purpose::Sample, [0]);
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
            let job = Job::default();
            let quantised = Quantised::new(&exemplars, &job).unwrap();
            let Ok(positions) = Positions::new(&exemplars, side) else { return Ok(()) };
            let window = if gaussian { ComparedWindow::gaussian(side) } else { ComparedWindow::uniform(side) };
            let scan = Scan::new(&quantised, &positions, &job).unwrap();
            for _ in 0..4 {
                let query = query(&window, &quantised, &positions, &mut stream);
                let hints: Vec<Texel> =
                    (0..stream.below(3)).map(|_| positions.nth(stream.below(positions.count()))).collect();
                let truth = plain::matches(&quantised, &positions, &query, epsilon);
                prop_assert_eq!(scan.matches(&query, epsilon, &hints), truth);
            }
        }
    }
}
