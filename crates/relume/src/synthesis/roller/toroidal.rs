//! Two minimum error boundary cuts that close on the torus and cross in one corner.
//!
//! M. Haindl, M. Hatka, "A Roller - Fast Sampling-Based Texture Synthesis Algorithm", WSCG 2005. A part of w
//! x h texels with an overlap of d becomes periodic: within the left d columns a texel comes from its own
//! place or from w farther right, within the top d rows from h farther down. The upright cut chooses column
//! V(y) of the left strip for each row, the level one row H(x) of the top strip; left of V and above H lies
//! the continuation. On the torus a cut must end where it began, and all four corners of the tile are one
//! texel (p, q), so both cuts go through it: V(q) = V(q + h) = p and H(p) = H(p + w) = q.
//!
//! With the corner fixed the cuts are two shortest paths with fixed ends, with at most one step across per
//! step along. They meet nowhere else: from the corner the upright one stays within |dx| <= |dy| and the
//! level one within |dy| <= |dx|. So their errors add, and the least sum over all d x d corners is the least
//! over all such pairs of cuts: exact. [`least_of_all`] tries them.
//! |dx| <= |dy| and the level one within |dy| <= |dx|. So their errors add, and the least sum over
//! all d x d corners is the least of all such pairs of cuts: exact. [`least_of_all`] tries them.
//!
//! In oblique cells, positions across a strip are counted from the side of the cell in their row or column
//! ([`Cells::left_side`]). The rest is the same, except that the steps of a side add to those of a cut, so
//! near their corner cuts may meet again: the result is still periodic, and its error is at most the sum.

use crate::numeric::cells::Cells;
use crate::parallel;

/// The errors of a strip one period plus one overlap long, `width` texels across: for each position along it,
/// the errors of all positions across together.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Strip {
    width: usize,
    period: usize,
    errors: Vec<u64>,
}

/// Larger than any sum of errors, and half of what would overflow.
const NEVER: u64 = u64::MAX / 2;

impl Strip {
    /// A strip of `period` + `width` positions along, with the error of each of its texels.
    pub fn new(period: usize, width: usize, error: impl Fn(usize, usize) -> u64) -> Self {
        let places = (0..period + width).flat_map(|along| (0..width).map(move |across| (along, across)));
        Self { width, period, errors: places.map(|(along, across)| error(along, across)).collect() }
    }

    fn row(&self, along: usize) -> &[u64] {
        &self.errors[along * self.width..][..self.width]
    }

    /// The least sum of errors of a path from `across` at `start` to `across` one period farther.
    pub fn least_sum(&self, start: usize, across: usize) -> u64 {
        let mut sums = self.first_sums(start, across);
        let mut next = sums.clone();
        for along in start + 1..=start + self.period {
            self.advance(along, &sums, &mut next);
            std::mem::swap(&mut sums, &mut next);
        }
        sums[across + 1]
    }

    /// That path: its position across at each position along the period and at its end. Among equal paths the
    /// one that, going back from the end, stays nearest to the outer side of the strip.
    pub fn least_path(&self, start: usize, across: usize) -> Vec<usize> {
        let mut rows = vec![self.first_sums(start, across)];
        for along in start + 1..=start + self.period {
            let mut next = vec![NEVER; self.width + 2];
            self.advance(along, &rows[rows.len() - 1], &mut next);
            rows.push(next);
        }
        let mut path = vec![across; self.period + 1];
        for along in (0..self.period).rev() {
            let after = path[along + 1];
            let near = after.saturating_sub(1)..=(after + 1).min(self.width - 1);
            path[along] = near.min_by_key(|&c| rows[along][c + 1]).expect("the range is not empty");
        }
        path
    }

    /// The sums at the start of a path: one position on either side of the strip represents the outside.
    fn first_sums(&self, start: usize, across: usize) -> Vec<u64> {
        let mut sums = vec![NEVER; self.width + 2];
        sums[across + 1] = self.row(start)[across];
        sums
    }

    /// E(a, c) = e(a, c) + min(E(a-1, c-1), E(a-1, c), E(a-1, c+1)).
    fn advance(&self, along: usize, before: &[u64], after: &mut [u64]) {
        for ((out, near), error) in after[1..].iter_mut().zip(before.windows(3)).zip(self.row(along)) {
            *out = (error + near[0].min(near[1]).min(near[2])).min(NEVER);
        }
    }
}

/// Two closed cuts through one corner.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ClosedCuts {
    /// The cells that tiles fill.
    pub cells: Cells,
    /// The corner (p, q) at which they cross, relative to the lattice point of the cell.
    pub corner: (usize, usize),
    /// For each row of the tile, the first position from the left side that is not from the continuation at
    /// the right.
    pub left: Vec<usize>,
    /// For each column of the tile, the first position from the upper side that is not from the continuation
    /// below.
    pub top: Vec<usize>,
    /// The sum of the errors along both.
    pub error: u64,
}

/// The two closed cuts of least error through the left strip (upright) and top strip (level) of a tile; among
/// equals those of the topmost, then the leftmost corner.
pub fn closed_cuts(cells: &Cells, upright: &Strip, level: &Strip) -> ClosedCuts {
    let corners = corners(cells, upright.width);
    let sum = |c: &CellCorner| upright.least_sum(c.y, c.from_left) + level.least_sum(c.x, c.from_top);
    let sums: Vec<u64> = parallel::map(corners.iter(), sum);
    let best = (0..sums.len()).min_by_key(|&i| sums[i]).expect("a strip has corners");
    let CellCorner { x: p, y: q, from_left, from_top } = corners[best];
    let turned = |path: Vec<usize>, start: usize, period: usize| -> Vec<usize> {
        (0..period).map(|along| path[(along + period - start) % period]).collect()
    };
    ClosedCuts {
        cells: *cells,
        corner: (p, q),
        left: turned(upright.least_path(q, from_left), q, upright.period),
        top: turned(level.least_path(p, from_top), p, level.period),
        error: sums[best],
    }
}

/// A texel in both strips, and its position across each of them.
struct CellCorner {
    x: usize,
    y: usize,
    from_left: usize,
    from_top: usize,
}

/// The corners among the first `width` columns and rows of a cell.
fn corners(cells: &Cells, width: usize) -> Vec<CellCorner> {
    let across = |place: i64| usize::try_from(place).ok().filter(|&place| place < width);
    let corner = |x: usize, y: usize| {
        let from_left = across(x as i64 - cells.left_side(y as i64))?;
        let from_top = across(y as i64 - cells.upper_side(x as i64))?;
        Some(CellCorner { x, y, from_left, from_top })
    };
    (0..width * width).filter_map(|i| corner(i % width, i / width)).collect()
}

impl ClosedCuts {
    /// The shift, right and down, of the source of a texel of the tile: its own place or a continuation.
    pub fn shift(&self, [x, y]: [i64; 2]) -> [i64; 2] {
        let ([w, t], [s, h]) = (self.cells.right(), self.cells.down());
        let cut = |cut: &[usize], along: i64| cut[along.rem_euclid(cut.len() as i64) as usize] as i64;
        let right = i64::from(x - self.cells.left_side(y) < cut(&self.left, y));
        let down = i64::from(y - self.cells.upper_side(x) < cut(&self.top, x));
        [right * w + down * s, right * t + down * h]
    }
}

/// The least error of all pairs of closed cuts, found by trying them all: the slow truth of
/// [`closed_cuts`], for strips of a few texels.
pub fn least_of_all(upright: &Strip, level: &Strip) -> u64 {
    fn from(strip: &Strip, along: usize, across: usize, end: (usize, usize)) -> Option<u64> {
        let own = strip.row(along)[across];
        if along == end.0 {
            return (across == end.1).then_some(own);
        }
        let near = across.saturating_sub(1)..=(across + 1).min(strip.width - 1);
        near.filter_map(|next| from(strip, along + 1, next, end)).min().map(|rest| own + rest)
    }
    let closed = |strip: &Strip, start: usize, across: usize| {
        from(strip, start, across, (start + strip.period, across))
    };
    let width = upright.width;
    let corners = (0..width).flat_map(|q| (0..width).map(move |p| (p, q)));
    let sums = corners.filter_map(|(p, q)| Some(closed(upright, q, p)? + closed(level, p, q)?));
    sums.min().expect("a straight cut exists")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};
    use crate::size::Size;
    use proptest::prelude::*;

    fn random(period: usize, width: usize, seed: u64) -> Strip {
        let mut stream = Stream::new(seed, Purpose::Sample, [0]);
        let errors: Vec<u64> = (0..(period + width) * width).map(|_| stream.below(30) as u64).collect();
        Strip::new(period, width, |along, across| errors[along * width + across])
    }

    fn rectangle(width: usize, height: usize) -> Cells {
        Cells::upright(Size::new(width, height)).unwrap()
    }

    /// The error along a closed cut given by its position in each row of the tile.
    fn along(strip: &Strip, places: &[usize], start: usize) -> u64 {
        let period = strip.period;
        (start..=start + period).map(|a| strip.row(a)[places[a % period]]).sum()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(120))]

        #[test]
        fn no_pair_of_closed_cuts_has_less_error(
            (width, w, h, seed) in (1usize..4, 4usize..7, 4usize..7, any::<u64>()),
        ) {
            let (upright, level) = (random(h, width, seed), random(w, width, !seed));
            let cuts = closed_cuts(&rectangle(w, h), &upright, &level);
            prop_assert_eq!(cuts.error, least_of_all(&upright, &level));
            let (p, q) = cuts.corner;
            prop_assert_eq!((cuts.left[q], cuts.top[p]), (p, q));
            prop_assert_eq!(along(&upright, &cuts.left, q) + along(&level, &cuts.top, p), cuts.error);
            for places in [&cuts.left, &cuts.top] {
                let next = places.iter().cycle().skip(1);
                prop_assert!(places.iter().zip(next).all(|(a, b)| a.abs_diff(*b) <= 1), "closed: {:?}", places);
            }
        }

        /// Cuts of any size meet in the corner alone, so every texel lies on one side of each.
        #[test]
        fn cuts_meet_in_their_corner_only(
            (width, w, h, seed) in (2usize..9, 10usize..20, 10usize..20, any::<u64>()),
        ) {
            let (upright, level) = (random(h, width, seed), random(w, width, !seed));
            let cuts = closed_cuts(&rectangle(w, h), &upright, &level);
            let (p, q) = cuts.corner;
            for (y, x) in cuts.left.iter().copied().enumerate() {
                prop_assert!(cuts.top[x] != y || x.abs_diff(p) == y.abs_diff(q));
            }
        }
    }
}
