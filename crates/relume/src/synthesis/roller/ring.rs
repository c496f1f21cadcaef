//! The closed cut of least error around the border of a tile, inside which another part of the
//! exemplar takes the first tile's place.
//!
//! A ring goes through texels one beside or one diagonal of the other that lie 1 to `band` texels
//! inside the tile, once around; its own texels are new, the outermost texels always old. Its error
//! is the sum of the squared differences of old and new on it. A ring crosses the column in the
//! middle of the upper band, so the least one is the least over that column's texels of the shortest
//! path from the texel once around to itself: Dijkstra's algorithm ("A note on two problems in
//! connexion with graphs", 1959) on the band unrolled, where each turn has its own copy of the
//! texels (the covering of the annulus). Paths may turn back by a whole turn. Exact;
//! [`least_of_all`] tries all sets of texels.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::planes::Size;

/// A ring of least error.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ring {
    /// For each texel of the tile, whether it is on or inside the ring.
    pub inside: Vec<bool>,
    /// The sum of the errors along the ring.
    pub error: u64,
    /// How many texels it goes through.
    pub length: usize,
}

/// The least side of a tile whose band leaves something inside.
pub fn least_side(band: usize) -> usize {
    2 * band + 3
}

/// The ring of least error; `errors` are those of the tile's texels, row after row.
///
/// # Panics
/// When `band` is zero, a side is below [`least_side`], or there is not one error for each texel.
pub fn least_ring(tile: Size, band: usize, errors: &[u64]) -> Ring {
    assert!(band > 0 && tile.width.min(tile.height) >= least_side(band), "a band of the tile");
    assert_eq!(errors.len(), tile.texels(), "one error for each texel");
    let annulus = Annulus { tile, band, errors };
    let mut best: Option<(u64, Vec<usize>)> = None;
    for y in 1..=band {
        let limit = best.as_ref().map_or(u64::MAX, |(error, _)| *error);
        best = annulus.once_around(tile.index(tile.width / 2, y), limit).or(best);
    }
    let (error, path) = best.expect("the band has a ring");
    Ring { inside: annulus.inside(&path), error, length: path.len() }
}

/// The turns that paths know: one back, the one they begin in, and the one they end in.
const TURNS: usize = 3;

struct Annulus<'a> {
    tile: Size,
    band: usize,
    errors: &'a [u64],
}

impl Annulus<'_> {
    /// How far inside the tile a texel lies.
    fn depth(&self, x: usize, y: usize) -> usize {
        x.min(y).min(self.tile.width - 1 - x).min(self.tile.height - 1 - y)
    }

    /// The shortest path from a texel of the middle column once around to itself, when its error is
    /// below the limit.
    fn once_around(&self, start: usize, limit: u64) -> Option<(u64, Vec<usize>)> {
        let texels = self.tile.texels();
        let (from, to) = (texels + start, 2 * texels + start);
        let mut sums = vec![u64::MAX; TURNS * texels];
        let mut before = vec![from; TURNS * texels];
        let mut waiting = BinaryHeap::from([Reverse((0, from))]);
        sums[from] = 0;
        while let Some(Reverse((sum, node))) = waiting.pop() {
            if sum >= limit {
                return None;
            }
            if node == to {
                return Some((sum, self.traced(&before, from, to)));
            }
            if sum > sums[node] {
                continue;
            }
            for next in self.neighbours(node) {
                let longer = sum + self.errors[next % texels];
                if longer < sums[next] {
                    sums[next] = longer;
                    before[next] = node;
                    waiting.push(Reverse((longer, next)));
                }
            }
        }
        None
    }

    /// The texels of the path from one node to another, its end first.
    fn traced(&self, before: &[usize], from: usize, to: usize) -> Vec<usize> {
        let steps = std::iter::successors(Some(to), |&node| Some(before[node]).filter(|&n| n != from));
        steps.map(|node| node % self.tile.texels()).collect()
    }

    /// The texels of the band around a texel, each in its turn.
    fn neighbours(&self, node: usize) -> impl Iterator<Item = usize> {
        let (texels, width) = (self.tile.texels(), self.tile.width);
        let (turn, x, y) = (node / texels, node % texels % width, node % texels / width);
        let around = (y - 1..=y + 1).flat_map(move |ny| (x - 1..=x + 1).map(move |nx| (nx, ny)));
        around.filter_map(move |(nx, ny)| {
            let in_band = (1..=self.band).contains(&self.depth(nx, ny));
            let turn = self.turn_after(turn, (x, nx), y.min(ny))?;
            (in_band && (nx, ny) != (x, y)).then(|| turn * texels + self.tile.index(nx, ny))
        })
    }

    /// The turn after a step between columns whose upper end is in row `y`: it changes where the
    /// middle of the upper band is crossed.
    fn turn_after(&self, turn: usize, (from, to): (usize, usize), y: usize) -> Option<usize> {
        let middle = self.tile.width / 2;
        match (y <= self.band, from < middle, to < middle) {
            (true, true, false) => Some(turn + 1).filter(|&next| next < TURNS),
            (true, false, true) => turn.checked_sub(1),
            _ => Some(turn),
        }
    }

    /// What cannot be reached from outside without crossing the ring.
    fn inside(&self, ring: &[usize]) -> Vec<bool> {
        let Size { width, height } = self.tile;
        let mut inside = vec![true; self.tile.texels()];
        let mut is_ring = vec![false; inside.len()];
        ring.iter().for_each(|&texel| is_ring[texel] = true);
        let mut waiting: Vec<(usize, usize)> = vec![(0, 0)];
        while let Some((x, y)) = waiting.pop() {
            if x >= width || y >= height || is_ring[self.tile.index(x, y)] || !inside[self.tile.index(x, y)] {
                continue;
            }
            inside[self.tile.index(x, y)] = false;
            waiting.extend([(x + 1, y), (x, y + 1), (x.wrapping_sub(1), y), (x, y.wrapping_sub(1))]);
        }
        inside
    }
}

/// The least error of any ring, by trying every set of the band's texels together with all that lies
/// further inside: the errors of its texels that have one outside beside them. The slow truth of
/// [`least_ring`], for bands of up to 24 texels.
pub fn least_of_all(tile: Size, band: usize, errors: &[u64]) -> u64 {
    let annulus = Annulus { tile, band, errors };
    let depth = |texel: usize| annulus.depth(texel % tile.width, texel / tile.width);
    let free: Vec<usize> = (0..tile.texels()).filter(|&t| (1..=band).contains(&depth(t))).collect();
    let place = |texel: usize| free.iter().position(|&t| t == texel);
    // Of each texel on or inside the band: its own bit where it has one, those of its neighbours,
    // and whether a neighbour is always outside.
    let ways: Vec<(Option<usize>, u32, bool, u64)> = (0..tile.texels())
        .filter(|&texel| depth(texel) > 0)
        .map(|texel| {
            let beside = [texel - 1, texel + 1, texel - tile.width, texel + tile.width];
            let bits = beside.into_iter().filter_map(place).fold(0, |bits, place| bits | 1 << place);
            (place(texel), bits, beside.into_iter().any(|t| depth(t) == 0), errors[texel])
        })
        .collect();
    let error = |set: u32| -> u64 {
        let on_ring = |(own, beside, is_outermost, _): &&(Option<usize>, u32, bool, u64)| {
            own.is_none_or(|place| set >> place & 1 == 1) && (*is_outermost || set & beside != *beside)
        };
        ways.iter().filter(on_ring).map(|(.., error)| error).sum()
    };
    // Texels further inside are no place for a ring.
    let allowed = |set: &u32| {
        let inner = ways.iter().filter(|(own, ..)| own.is_none());
        inner.into_iter().all(|(_, beside, ..)| set & beside == *beside)
    };
    (0..1u32 << free.len()).filter(allowed).map(error).min().expect("the whole band is such a set")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::Stream;

    fn random(tile: Size, most: usize, seed: u64) -> Vec<u64> {
        let mut stream = Stream::new(seed, 0);
        (0..tile.texels()).map(|_| stream.below(most) as u64).collect()
    }

    #[test]
    fn no_ring_has_less_error() {
        for seed in 0..60 {
            for (width, height, band) in [(5, 5, 1), (6, 7, 1), (5, 9, 1)] {
                let tile = Size::new(width, height);
                let errors = random(tile, 1 + 9 * seed as usize, seed);
                let ring = least_ring(tile, band, &errors);
                assert_eq!(ring.error, least_of_all(tile, band, &errors), "{tile}, seed {seed}");
            }
        }
    }

    #[test]
    fn no_ring_of_a_wider_band_has_less_error() {
        let tile = Size::new(7, 7);
        for seed in 0..3 {
            let errors = random(tile, 20, 100 + seed);
            assert_eq!(least_ring(tile, 2, &errors).error, least_of_all(tile, 2, &errors), "seed {seed}");
        }
    }

    #[test]
    fn a_ring_keeps_the_border_old_and_the_middle_new() {
        for seed in 0..40 {
            let mut stream = Stream::new(seed, 9);
            let band = 1 + stream.below(5);
            let side = |s: &mut Stream| least_side(band) + s.below(12);
            let tile = Size::new(side(&mut stream), side(&mut stream));
            let errors = random(tile, 50, seed);
            let ring = least_ring(tile, band, &errors);
            let annulus = Annulus { tile, band, errors: &errors };
            for (texel, &inside) in ring.inside.iter().enumerate() {
                let depth = annulus.depth(texel % tile.width, texel / tile.width);
                assert!(if depth == 0 { !inside } else { depth <= band || inside }, "{tile}, band {band}");
            }
            // The ring's texels are those inside with an old one beside them, up to corners it cuts.
            let beside = |t: usize| [t - 1, t + 1, t - tile.width, t + tile.width];
            let is_edge = |t: &usize| ring.inside[*t] && beside(*t).into_iter().any(|n| !ring.inside[n]);
            let edge: u64 = (0..tile.texels()).filter(is_edge).map(|t| errors[t]).sum();
            assert!(edge <= ring.error);
        }
    }

    #[test]
    fn a_free_way_is_found_around_every_bend() {
        let tile = Size::new(15, 13);
        let free = |x: usize, y: usize| {
            let wave = |along: usize| 2 + usize::from((along / 2).is_multiple_of(2));
            (y == wave(x) && (2..13).contains(&x))
                || (y == 12 - wave(x) && (2..13).contains(&x))
                || (x == 2 && (2..11).contains(&y))
                || (x == 12 && (2..11).contains(&y))
        };
        let errors: Vec<u64> = (0..tile.texels()).map(|t| u64::from(!free(t % 15, t / 15))).collect();
        assert_eq!(least_ring(tile, 4, &errors).error, 0);
    }
}
