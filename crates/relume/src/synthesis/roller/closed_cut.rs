//! The closed cut of least error around the border of a tile, inside which another part of the exemplar
//! replaces the first tile.
//!
//! A closed cut goes once around through adjacent or diagonal texels that lie 1 to `band` texels inside the
//! tile, which may be oblique; its own texels are new, the outermost texels always old. Its error is the sum
//! of the squared differences of old and new on it. A closed cut crosses the column in the middle of the
//! upper band, so the least one is the least, over the texels of that column, of the shortest path from the
//! texel once around to itself: Dijkstra's algorithm ("A note on two problems in connexion with graphs",
//! 1959) on the unrolled band, where each turn has its own copy of the texels (the covering of the annulus).
//! Paths may turn back by a whole turn. The result is exact; [`least_of_all`] tries all sets of texels.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::numeric::cells::Cells;

/// A closed cut of least error.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ClosedCut {
    /// For each texel of the bounding rectangle of the tile, whether it is on or inside the cut.
    pub inside: Vec<bool>,
    /// The sum of the errors along the cut.
    pub error: u64,
    /// The number of its texels.
    pub length: usize,
}

/// The least side of a tile with texels inside its band.
pub fn least_side(band: usize) -> usize {
    2 * band + 3
}

/// Whether tiles that fill these cells have texels inside their band.
pub fn has_room(cells: &Cells, band: usize) -> bool {
    let free = |along: i64, aside: i64| along - aside.abs() >= least_side(band) as i64;
    free(cells.right()[0], cells.down()[0]) && free(cells.down()[1], cells.right()[1])
}

/// The closed cut of least error; `errors` are those of the texels of the rectangle of the tile, row by row.
///
/// # Panics
/// When `band` is zero, leaves nothing inside ([`has_room`]), or there is not one error for each texel.
pub fn least_closed_cut(cells: &Cells, band: usize, errors: &[u64]) -> ClosedCut {
    assert!(band > 0 && has_room(cells, band), "a band of the tile");
    assert_eq!(errors.len(), cells.bounds().texels(), "one error for each texel");
    let annulus = Annulus { cells, band, errors };
    let mut best: Option<(u64, Vec<usize>)> = None;
    for below in 1..=band as i64 {
        let limit = best.as_ref().map_or(u64::MAX, |(error, _)| *error);
        let middle = annulus.middle();
        let start = cells.index([middle, cells.upper_side(middle) + below]);
        best = annulus.once_around(start, limit).or(best);
    }
    let (error, path) = best.expect("the band has a closed cut");
    ClosedCut { inside: annulus.inside(&path), error, length: path.len() }
}

/// The turns of paths: one back, the one they begin in, and the one they end in.
const TURNS: usize = 3;

struct Annulus<'a> {
    cells: &'a Cells,
    band: usize,
    errors: &'a [u64],
}

impl Annulus<'_> {
    /// The column in which a closed cut crosses the upper band.
    fn middle(&self) -> i64 {
        self.cells.right()[0] / 2
    }

    /// The number of texels of the rectangle of the tile.
    fn texels(&self) -> usize {
        self.errors.len()
    }

    /// The coordinates of a texel of the rectangle.
    fn place(&self, texel: usize) -> [i64; 2] {
        let ([left, top], width) = (self.cells.origin(), self.cells.bounds().width);
        [left + (texel % width) as i64, top + (texel / width) as i64]
    }

    /// Whether a closed cut may go through a texel.
    fn is_band(&self, place: [i64; 2]) -> bool {
        self.cells.depth(place).is_some_and(|depth| (1..=self.band).contains(&depth))
    }

    /// The shortest path from a texel of the middle column once around to itself, if its error is below the
    /// limit.
    fn once_around(&self, start: usize, limit: u64) -> Option<(u64, Vec<usize>)> {
        let texels = self.texels();
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
        steps.map(|node| node % self.texels()).collect()
    }

    /// The texels of the band around a texel, each in its turn.
    fn neighbours(&self, node: usize) -> impl Iterator<Item = usize> {
        let (turn, here @ [x, y]) = (node / self.texels(), self.place(node % self.texels()));
        let around = (y - 1..=y + 1).flat_map(move |ny| (x - 1..=x + 1).map(move |nx| [nx, ny]));
        around.filter(move |&next| next != here && self.is_band(next)).filter_map(move |next| {
            let turn = self.turn_after(turn, here, next)?;
            Some(turn * self.texels() + self.cells.index(next))
        })
    }

    /// The turn after a step: it changes where the middle of the upper band is crossed.
    fn turn_after(&self, turn: usize, from: [i64; 2], to: [i64; 2]) -> Option<usize> {
        let (middle, below) = (self.middle(), |[x, y]: [i64; 2]| y - self.cells.upper_side(x));
        let is_above = below(from).min(below(to)) <= self.band as i64;
        match (is_above, from[0] < middle, to[0] < middle) {
            (true, true, false) => Some(turn + 1).filter(|&next| next < TURNS),
            (true, false, true) => turn.checked_sub(1),
            _ => Some(turn),
        }
    }

    /// The texels that cannot be reached from outside without crossing the cut.
    fn inside(&self, cut: &[usize]) -> Vec<bool> {
        let mut inside = vec![true; self.texels()];
        let mut is_cut = vec![false; inside.len()];
        cut.iter().for_each(|&texel| is_cut[texel] = true);
        let is_inner = |place: [i64; 2]| self.cells.depth(place).is_some_and(|depth| depth > 0);
        let mut waiting: Vec<[i64; 2]> = self.cells.rectangle().filter(|&place| !is_inner(place)).collect();
        waiting.iter().for_each(|&place| inside[self.cells.index(place)] = false);
        while let Some([x, y]) = waiting.pop() {
            for next in [[x + 1, y], [x, y + 1], [x - 1, y], [x, y - 1]].into_iter().filter(|&p| is_inner(p))
            {
                let texel = self.cells.index(next);
                if !is_cut[texel] && std::mem::take(&mut inside[texel]) {
                    waiting.push(next);
                }
            }
        }
        inside
    }
}

/// The least error of any closed cut, by trying every set of texels of the band together with all texels
/// farther inside: the errors of those with an outside neighbour. The slow truth of [`least_closed_cut`], for
/// bands of up to 24 texels.
pub fn least_of_all(cells: &Cells, band: usize, errors: &[u64]) -> u64 {
    let annulus = Annulus { cells, band, errors };
    let width = cells.bounds().width;
    let depth = |texel: usize| cells.depth(annulus.place(texel)).unwrap_or(0);
    let free: Vec<usize> = (0..errors.len()).filter(|&t| (1..=band).contains(&depth(t))).collect();
    let place = |texel: usize| free.iter().position(|&t| t == texel);
    // For each texel on or inside the band: its own bit if it has one, those of its neighbours, and whether a
    // neighbour is always outside.
    let ways: Vec<(Option<usize>, u32, bool, u64)> = (0..errors.len())
        .filter(|&texel| depth(texel) > 0)
        .map(|texel| {
            let beside = [texel - 1, texel + 1, texel - width, texel + width];
            let bits = beside.into_iter().filter_map(place).fold(0, |bits, place| bits | 1 << place);
            (place(texel), bits, beside.into_iter().any(|t| depth(t) == 0), errors[texel])
        })
        .collect();
    let error = |set: u32| -> u64 {
        let on_cut = |(own, beside, is_outermost, _): &&(Option<usize>, u32, bool, u64)| {
            own.is_none_or(|place| set >> place & 1 == 1) && (*is_outermost || set & beside != *beside)
        };
        ways.iter().filter(on_cut).map(|(.., error)| error).sum()
    };
    // A cut cannot go through texels farther inside.
    let allowed = |set: &u32| {
        let inner = ways.iter().filter(|(own, ..)| own.is_none());
        inner.into_iter().all(|(_, beside, ..)| set & beside == *beside)
    };
    (0..1u32 << free.len()).filter(allowed).map(error).min().expect("the whole band is such a set")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};
    use crate::size::Size;

    fn upright(width: usize, height: usize) -> Cells {
        Cells::upright(Size::new(width, height)).unwrap()
    }

    fn random(cells: &Cells, most: usize, seed: u64) -> Vec<u64> {
        let mut stream = Stream::new(seed, Purpose::Sample, [0]);
        (0..cells.bounds().texels()).map(|_| stream.below(most) as u64).collect()
    }

    #[test]
    fn no_closed_cut_has_less_error() {
        let oblique = Cells::new([7, 1], [-1, 6]).unwrap();
        for seed in 0..60 {
            for cells in [upright(5, 5), upright(6, 7), upright(5, 9), oblique] {
                let errors = random(&cells, 1 + 9 * seed as usize, seed);
                let cut = least_closed_cut(&cells, 1, &errors);
                assert_eq!(cut.error, least_of_all(&cells, 1, &errors), "{cells:?}, seed {seed}");
            }
        }
    }

    #[test]
    fn no_closed_cut_of_a_wider_band_has_less_error() {
        let cells = upright(7, 7);
        for seed in 0..3 {
            let errors = random(&cells, 20, 100 + seed);
            assert_eq!(
                least_closed_cut(&cells, 2, &errors).error,
                least_of_all(&cells, 2, &errors),
                "seed {seed}"
            );
        }
    }

    #[test]
    fn a_closed_cut_keeps_the_border_old_and_the_middle_new() {
        for seed in 0..80 {
            let mut stream = Stream::new(seed, Purpose::Sample, [9]);
            let band = 1 + stream.below(5);
            let aside = |s: &mut Stream| s.below(7) as i64 - 3;
            let side = |s: &mut Stream| (least_side(band) + 3 + s.below(12)) as i64;
            let (right, down) = (side(&mut stream), side(&mut stream));
            let cells = Cells::new([right, aside(&mut stream)], [aside(&mut stream), down]).unwrap();
            let errors = random(&cells, 50, seed);
            let cut = least_closed_cut(&cells, band, &errors);
            for (place, &inside) in cells.rectangle().zip(&cut.inside) {
                let depth = cells.depth(place).unwrap_or(0);
                assert!(if depth == 0 { !inside } else { depth <= band || inside }, "{cells:?}, band {band}");
            }
            // The texels of the closed cut are those inside with an old neighbour, except for corners that it
            // cuts.
            let width = cells.bounds().width;
            let beside = |t: usize| [t - 1, t + 1, t - width, t + width];
            let is_edge = |t: &usize| cut.inside[*t] && beside(*t).into_iter().any(|n| !cut.inside[n]);
            let edge: u64 = (0..errors.len()).filter(is_edge).map(|t| errors[t]).sum();
            assert!(edge <= cut.error);
        }
    }

    #[test]
    fn a_free_way_is_found_around_every_bend() {
        let cells = upright(15, 13);
        let free = |x: usize, y: usize| {
            let wave = |along: usize| 2 + usize::from((along / 2).is_multiple_of(2));
            (y == wave(x) && (2..13).contains(&x))
                || (y == 12 - wave(x) && (2..13).contains(&x))
                || (x == 2 && (2..11).contains(&y))
                || (x == 12 && (2..11).contains(&y))
        };
        let errors: Vec<u64> = (0..15 * 13).map(|t| u64::from(!free(t % 15, t / 15))).collect();
        assert_eq!(least_closed_cut(&cells, 4, &errors).error, 0);
    }
}
