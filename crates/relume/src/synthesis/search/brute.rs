//! Every position, with the processor's vector instructions and all threads.

use rayon::prelude::*;

use super::distance::Target;
use super::{Acceptance, Candidates, Query, Search};
use crate::synthesis::positions::{Positions, Run};
use crate::synthesis::quantise::Quantised;
use crate::synthesis::source_map::Texel;

/// Looks at every position.
#[derive(Debug, Clone, Copy)]
pub struct Brute<'a> {
    /// The exemplars.
    pub exemplars: &'a Quantised,
    /// Where blocks may come from.
    pub positions: &'a Positions,
}

impl Search for Brute<'_> {
    fn candidates(&self, query: &Query, acceptance: Acceptance) -> Candidates {
        let ready = |exemplar| Target::new(query, exemplar, self.exemplars.planes());
        let targets: Vec<Target<'_>> = self.exemplars.texels().iter().map(ready).collect();
        let near = |run: &Run| {
            let Texel { exemplar, y, x } = run.first;
            let distances = targets[exemplar as usize].distances(x as usize, y as usize, run.length);
            let best = distances.iter().copied().min().unwrap_or(u64::MAX);
            let limit = acceptance.limit(best);
            let accepted = distances.into_iter().enumerate().filter(|(_, distance)| *distance <= limit);
            (best, accepted.map(|(i, distance)| (run.first.offset(i, 0), distance)).collect())
        };
        let runs: Vec<(u64, Vec<(Texel, u64)>)> = self.positions.runs().par_iter().map(near).collect();
        let best = runs.iter().map(|(best, _)| *best).min().unwrap_or(0);
        let limit = acceptance.limit(best);
        let accepted = runs.into_iter().flat_map(|(_, near)| near).filter(|(_, distance)| *distance <= limit);
        Candidates { best, positions: accepted.map(|(position, _)| position).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::Limits;
    use crate::numeric::random::Stream;
    use crate::planes::{Planes, Size};
    use crate::synthesis::neighbourhood::{Margins, Neighbourhood};
    use crate::synthesis::options::Tolerance;
    use crate::synthesis::quantise::Exemplar;
    use crate::synthesis::search::plain::Plain;
    use proptest::prelude::*;

    fn noise(size: Size, planes: usize, stream: &mut Stream) -> Planes {
        let data = (0..size.texels() * planes).map(|_| stream.unit() as f32).collect();
        Planes::from_vec(size, planes, data).unwrap()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(60))]
        #[test]
        fn equals_the_plain_search(
            (block, planes, seed) in (2usize..14, 1usize..19, any::<u64>()),
            (extra_x, extra_y, several) in (0usize..17, 0usize..13, 1usize..4),
            (left, top, right, bottom) in (0usize..8, 0usize..8, 0usize..8, 0usize..8),
            tolerance in prop_oneof![Just(Tolerance::Relative(0.0)), Just(Tolerance::Relative(0.1)), Just(Tolerance::Absolute(0.6))],
            masked in any::<bool>(),
        ) {
            let mut stream = Stream::new(seed, 0);
            let fields: Vec<Planes> = (0..several)
                .map(|e| noise(Size::new(block + extra_x + e, block + extra_y), planes, &mut stream))
                .collect();
            let masks: Vec<Vec<bool>> = fields
                .iter()
                .map(|f| (0..f.size().texels()).map(|t| t != 0 && masked && stream.below(200) == 0).collect())
                .collect();
            let exemplars: Vec<Exemplar<'_>> =
                fields.iter().zip(&masks).map(|(index, mask)| Exemplar { index, excluded: Some(mask) }).collect();
            let quantised = Quantised::new(&exemplars, &Limits::default()).unwrap();
            let Ok(positions) = Positions::new(&exemplars, block) else { return Ok(()) };
            let half = |margin: usize| margin.min(block / 2);
            let margins =
                Margins { left: half(left), top: half(top), right: half(right), bottom: half(bottom) };
            let neighbourhood = Neighbourhood { extent: Size::new(block, block), margins };
            let codes = (0..block * block * planes).map(|_| stream.below(4096) as i16).collect();
            let query = Query { neighbourhood, codes };
            let acceptance = Acceptance::new(tolerance, neighbourhood.texels(), quantised.step());
            let (exemplars, positions) = (&quantised, &positions);
            prop_assert_eq!(
                Brute { exemplars, positions }.candidates(&query, acceptance),
                Plain { exemplars, positions }.candidates(&query, acceptance)
            );
        }
    }
}
