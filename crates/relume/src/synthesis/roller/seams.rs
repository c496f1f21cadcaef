//! How visible the cuts of a tile are: steps across them against those that the exemplar has there.
//!
//! A step is the distance, in index space, of two texels side by side in the tile, whose right edge
//! meets its left one and whose bottom meets its top. It crosses a cut where the two do not lie side
//! by side in the exemplar. Good cuts run along edges that the texture has anyway, such as joints, so
//! a step is compared with those that its two texels have in the exemplar: the first with what
//! follows it there, and the second with what comes before it.

use serde::Serialize;

use super::profile::squared_distance;
use crate::numeric::cells::Cells;
use crate::synthesis::quantise::IndexTexels;
use crate::synthesis::source_map::Texel;

/// Steps across the cuts of one tile, and those of the exemplar in the same places.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TileSeams {
    /// How many pairs of neighbours cross a cut.
    pub pairs: usize,
    /// Root mean square step across cuts, in index space.
    pub across: f64,
    /// Root mean square step of their texels to their own neighbours in the exemplar.
    pub natural: f64,
    /// Share of the steps across cuts that are more than twice the larger of their two natural ones,
    /// and larger than 95 in a hundred of all steps inside.
    pub large: f64,
}

impl TileSeams {
    /// The largest ratio of steps across cuts to natural ones, and the largest share of large steps,
    /// of a tile whose seams are not expected to be seen. Tiles in which no seam was seen (the
    /// built-in weave, wool, corduroy, a tiled facade, gravel) have ratios up to 1.37 and shares up to
    /// 0.026; those in which seams were seen (hand-laid bricks, a large tile of wool) 1.53 and 0.040
    /// and more.
    pub const ACCEPTABLE: (f64, f64) = (1.45, 0.05);

    /// Measures a tile given by the source of each texel of the rectangle that holds it.
    pub fn measure(exemplar: &IndexTexels, step: f64, cells: &Cells, sources: &[Texel]) -> Self {
        let (mut crossings, mut inside) = (Vec::new(), Vec::new());
        let source = |place: [i64; 2]| sources[cells.index(cells.place(place).texel)];
        for [x, y] in cells.rectangle().filter(|&p| cells.depth(p).is_some()) {
            let (here, right, below) = (source([x, y]), source([x + 1, y]), source([x, y + 1]));
            for (there, by) in [(right, (1, 0)), (below, (0, 1))] {
                if there == here.offset(by.0, by.1) {
                    inside.push(distance(exemplar, here, there));
                } else {
                    crossings.push(SeamCrossing::new(exemplar, here, there, by));
                }
            }
        }
        inside.sort_unstable();
        let usual = inside.get(inside.len() * 95 / 100).copied().unwrap_or(0);
        let pairs = crossings.len();
        let share = |count: usize| count as f64 / pairs.max(1) as f64;
        let rms = |sum: f64| (sum / pairs.max(1) as f64).sqrt() * step;
        Self {
            pairs,
            across: rms(crossings.iter().map(|c| c.step as f64).sum()),
            natural: rms(crossings.iter().map(|c| 0.5 * (c.natural[0] + c.natural[1]) as f64).sum()),
            large: share(crossings.iter().filter(|c| c.is_large(usual)).count()),
        }
    }

    /// Steps across cuts in relation to natural ones; 0 where there are none across.
    pub fn ratio(&self) -> f64 {
        if self.across > 0.0 { self.across / self.natural } else { 0.0 }
    }

    /// Whether the cuts are not expected to be seen; see [`TileSeams::ACCEPTABLE`].
    pub fn are_acceptable(&self) -> bool {
        let (ratio, large) = Self::ACCEPTABLE;
        self.ratio() <= ratio && self.large <= large
    }
}

/// Two texels on either side of a cut: their squared step and the natural ones.
struct SeamCrossing {
    step: u64,
    natural: [u64; 2],
}

impl SeamCrossing {
    /// `by` is the way from the first to the second texel. Where the exemplar ends, both natural
    /// steps are the one that there is.
    fn new(exemplar: &IndexTexels, here: Texel, there: Texel, by: (usize, usize)) -> Self {
        let size = exemplar.size();
        let next = here.offset(by.0, by.1);
        let after = ((next.x as usize) < size.width && (next.y as usize) < size.height)
            .then(|| distance(exemplar, here, next));
        let previous = (there.x as usize).checked_sub(by.0).zip((there.y as usize).checked_sub(by.1));
        let before = previous.map(|(x, y)| {
            distance(exemplar, Texel { exemplar: there.exemplar, y: y as u32, x: x as u32 }, there)
        });
        let natural = [after.or(before).unwrap_or(0), before.or(after).unwrap_or(0)];
        Self { step: distance(exemplar, here, there), natural }
    }

    fn is_large(&self, usual: u64) -> bool {
        self.step > usual && self.step > 4 * self.natural[0].max(self.natural[1])
    }
}

fn distance(exemplar: &IndexTexels, a: Texel, b: Texel) -> u64 {
    let run = |t: Texel| exemplar.run(t.x as usize, t.y as usize, 1);
    squared_distance(run(a), run(b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::Job;
    use crate::planes::Planes;
    use crate::size::Size;
    use crate::synthesis::quantise::{Exemplar, Quantised};

    fn ramp(size: Size) -> Quantised {
        let values = (0..size.texels()).map(|t| (t % size.width) as f32).collect();
        let planes = Planes::from_vec(size, 1, values).unwrap();
        Quantised::new(&[Exemplar { index: &planes, excluded: None }], &Job::default()).unwrap()
    }

    #[test]
    fn a_straight_cut_of_a_ramp_has_the_steps_it_has() {
        let ramp = ramp(Size::new(12, 8));
        let tile = Cells::upright(Size::new(6, 5)).unwrap();
        // The tile is the ramp's part at (2, 1): its wrap steps back by five, its rows are equal.
        let sources: Vec<Texel> =
            (0..30).map(|t| Texel { exemplar: 0, y: 1 + t / 6, x: 2 + t % 6 }).collect();
        let seams = TileSeams::measure(&ramp.texels()[0], ramp.step(), &tile, &sources);
        // Five rows step back across the wrap, and the lower edge meets the upper one six times.
        assert_eq!(seams.pairs, 11);
        assert!((seams.across - (5.0f64 * 25.0 / 11.0).sqrt()).abs() < 1e-6);
        // In the exemplar steps to the right are one and steps down nothing.
        assert!((seams.natural - (5.0f64 / 11.0).sqrt()).abs() < 1e-6);
        assert!((seams.large - 5.0 / 11.0).abs() < 1e-12 && !seams.are_acceptable());
    }

    #[test]
    fn a_cut_where_the_texture_has_the_same_step_anyway_is_no_seam() {
        // Steps of 3, 1, 1, 1 repeat: a tile of one period wraps where the large step is.
        let size = Size::new(13, 6);
        let heights = [0.0, 3.0, 2.0, 1.0];
        let values = (0..size.texels()).map(|t| heights[t % 13 % 4]).collect();
        let planes = Planes::from_vec(size, 1, values).unwrap();
        let exemplar = [Exemplar { index: &planes, excluded: None }];
        let quantised = Quantised::new(&exemplar, &Job::default()).unwrap();
        let sources: Vec<Texel> = (0..20).map(|t| Texel { exemplar: 0, y: t / 4, x: 1 + t % 4 }).collect();
        let tile = Cells::upright(Size::new(4, 5)).unwrap();
        let seams = TileSeams::measure(&quantised.texels()[0], quantised.step(), &tile, &sources);
        assert!((seams.ratio() - 1.0).abs() < 1e-9 && seams.are_acceptable(), "{seams:?}");
    }
}
