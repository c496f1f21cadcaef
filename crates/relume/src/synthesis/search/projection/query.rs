//! A query made ready for the search: its coordinates, and what they say about distances.

use super::table::{Coordinates, Further};
use crate::synthesis::search::Query;
use crate::synthesis::search::distance::Target;
use crate::synthesis::source_map::Texel;

/// How much longer than that of the exact coordinates the length of a difference of so many rounded
/// ones can be: each is off by two halves of a unit.
pub fn rounding_error(coordinates: usize) -> f64 {
    (coordinates as f64).sqrt() * (1.0 + 1e-6)
}

/// A query with all that is known of it before positions are looked at.
pub struct Prepared<'a> {
    /// What it is prepared of.
    pub query: &'a Query,
    /// Where the cells lie in the block.
    pub cells: Vec<(usize, usize)>,
    /// The coordinates, cell after cell.
    pub coordinates: Vec<Coordinates>,
    /// Twice the first coordinates, in pairs, and [`MINUS_SQUARE`], cell after cell.
    pub factors: Vec<i32>,
    /// The further ones, cell after cell.
    pub further: Vec<Further>,
    /// The squared length of the first coordinates.
    pub square: i32,
    /// How far the length of a difference of first coordinates may be too large by rounding.
    pub first_error: f64,
    /// The same for all coordinates.
    pub error: f64,
    /// Units of the coordinates for one code.
    pub scale: f64,
    /// The query for exact distances, for each exemplar.
    pub targets: Vec<Target<'a>>,
    /// The smallest distance of the positions that were expected to be near.
    pub near: u64,
}

impl Prepared<'_> {
    /// The squared distance of a position, if it is at most `limit`.
    pub fn distance(&self, position: Texel, limit: u64) -> Option<u64> {
        let Texel { exemplar, y, x } = position;
        self.targets[exemplar as usize].distance_within(x as usize, y as usize, limit)
    }

    /// The distance of a position where it is smaller than `best`, else `best`.
    pub fn nearer(&self, position: Texel, best: u64) -> u64 {
        self.distance(position, best).map_or(best, |distance| distance.min(best))
    }

    /// The squared length beyond which no difference of coordinates that are off by `error` can stand
    /// for a squared distance of at most `limit`.
    pub fn longest_within(&self, limit: u64, error: f64) -> f64 {
        ((limit as f64).sqrt() * self.scale + error).powi(2) * (1.0 + 1e-9) + 1.0
    }

    /// The same for all coordinates; the largest number where it would overflow.
    pub fn longest(&self, limit: u64) -> i32 {
        self.longest_within(limit, self.error) as i32
    }

    /// The nearness below which no position can have a squared distance of at most `limit`; the
    /// smallest number, which keeps everything, where it would overflow.
    pub fn least_nearness(&self, limit: u64) -> i32 {
        (f64::from(self.square) - self.longest_within(limit, self.first_error)).floor() as i32
    }

    /// The least nearness of accepted positions when `best` is the smallest distance so far.
    pub fn keeps(&self, best: u64) -> i32 {
        self.least_nearness(self.query.acceptance.limit(best))
    }
}
