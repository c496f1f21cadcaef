//! Colours of the lattice points of a plane of tiles: a tile fits where its four corners have its colours.
//!
//! Lagae, Dutré, "An Alternative for Wang Tiles: Colored Edges versus Colored Corners", ACM Transactions on
//! Graphics 25(4), 2006. The colour of a lattice point is a hash of the seed and its place, so the tile of any
//! cell is known without those before it. Of several tiles with the same corners another hash chooses.

use serde::Serialize;

use crate::numeric::hash;

/// The number of colours of the corners of tiles, 1 if all corners are alike. Tile t has the corners of the
/// digits of t in base c: upper left, upper right, lower left, lower right, the least first, modulo c^4.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct CornerColors(usize);

impl CornerColors {
    /// All corners are alike.
    pub const ALIKE: Self = Self(1);

    /// The most colours: 256 tiles.
    const MOST: usize = 4;

    /// A number of colours with a tile for every choice of corners among `tiles`; `None` if there are too few
    /// tiles, or no or too many colours.
    pub fn new(count: usize, tiles: usize) -> Option<Self> {
        ((1..=Self::MOST).contains(&count) && count.pow(4) <= tiles).then_some(Self(count))
    }

    /// The most colours for a number of tiles.
    pub fn most(tiles: usize) -> Self {
        (1..=Self::MOST).rev().find_map(|count| Self::new(count, tiles)).unwrap_or(Self::ALIKE)
    }

    /// The number of colours.
    pub fn count(self) -> usize {
        self.0
    }

    /// Whether there is more than one.
    pub fn vary(self) -> bool {
        self.0 > 1
    }

    /// The number of choices of four corners.
    fn kinds(self) -> usize {
        self.0.pow(4)
    }

    /// The colours of the corners of a tile: upper left, upper right, lower left, lower right.
    pub fn corners(self, tile: usize) -> [usize; 4] {
        [0, 1, 2, 3].map(|corner| tile / self.0.pow(corner) % self.0)
    }

    /// The tile of a cell among `tiles`, given the hashes of places under a key.
    pub fn tile_at(
        self,
        tiles: usize,
        key: u64,
        cell: [i64; 2],
        wrapped: impl Fn([i64; 2]) -> [i64; 2],
    ) -> usize {
        let hash = |cell: [i64; 2]| {
            let [column, row] = wrapped(cell);
            hash::of_place(key, column, row)
        };
        let upper = |number: u32| (number >> 16) as usize;
        if !self.vary() {
            return upper(hash(cell)[0]) % tiles;
        }
        let [x, y] = cell;
        let color = |corner: [i64; 2]| upper(hash(corner)[0]) % self.0;
        let colors = [[x, y], [x + 1, y], [x, y + 1], [x + 1, y + 1]].map(color);
        let kind = colors.iter().rev().fold(0, |kind, color| kind * self.0 + color);
        let alike = (tiles - kind).div_ceil(self.kinds());
        kind + self.kinds() * (upper(hash(cell)[1]) % alike)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_that_meet_have_the_same_colours_at_their_corners() {
        for tiles in [16, 19, 81, 90, 256] {
            let colors = CornerColors::most(tiles);
            let corners = |x: i64, y: i64| colors.corners(colors.tile_at(tiles, 7, [x, y], |cell| cell));
            let mut seen = vec![false; tiles];
            for (x, y) in (-40..40).flat_map(|y| (-40..40).map(move |x| (x, y))) {
                let ([_, a, _, b], [c, _, d, _]) = (corners(x, y), corners(x + 1, y));
                assert_eq!((a, b), (c, d));
                let ([_, _, a, b], [c, d, _, _]) = (corners(x, y), corners(x, y + 1));
                assert_eq!((a, b), (c, d));
                seen[colors.tile_at(tiles, 7, [x, y], |cell| cell)] = true;
            }
            assert!(seen.iter().all(|seen| *seen), "every one of {tiles} tiles is laid");
        }
        assert_eq!(
            [1, 15, 16, 80, 81, 256].map(|tiles| CornerColors::most(tiles).count()),
            [1, 1, 2, 2, 3, 4]
        );
        assert_eq!(CornerColors::new(2, 15), None);
        assert_eq!(CornerColors::new(0, 15), None);
    }
}
