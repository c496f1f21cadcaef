//! A query prepared for the search: its coordinates, and the bounds they imply.

use super::coordinates::{Coordinates, FurtherFactors};
use super::table::Table;
use crate::synthesis::quantise::Quantised;
use crate::synthesis::search::BlockQuery;
use crate::synthesis::search::distance::BlockTarget;
use crate::synthesis::source_map::Texel;

/// A query with everything known about it before positions are examined.
///
/// The *nearness* of a position is, up to a constant, half the squared length of the first coordinates of the
/// query minus half that of their difference from those of the position: the sum computed by a product.
pub struct PreparedQuery<'a> {
    /// The query it was prepared from.
    pub query: &'a BlockQuery,
    /// The positions of the cells in the block.
    pub cells: Vec<(usize, usize)>,
    /// Their coordinates.
    pub coordinates: Coordinates,
    /// The first coordinates as factors, cell after cell.
    pub factors: Vec<i32>,
    /// The further ones as factors, cell after cell.
    pub further: Vec<FurtherFactors>,
    /// Their squared length.
    pub further_square: i32,
    /// The excess of their product, because the coordinates of positions are stored with an offset of 128.
    pub further_bias: i32,
    /// The squared length of the first coordinates.
    square: f64,
    /// The excess of a nearness.
    bias: f64,
    /// The largest excess length of the difference of first coordinates, in codes.
    first_error: f64,
    /// The same for all coordinates.
    error: f64,
    /// Squared codes per squared unit of the first coordinates, and of the further ones.
    codes: [f64; 2],
    /// The query for exact distances, for each exemplar.
    targets: Vec<BlockTarget<'a>>,
    /// The smallest distance of the positions expected to be near.
    pub near: u64,
}

impl<'a> PreparedQuery<'a> {
    /// Prepares a query whose neighbourhood has cells at these positions of its block.
    pub fn new(
        query: &'a BlockQuery,
        cells: Vec<(usize, usize)>,
        table: &Table,
        exemplars: &'a Quantised,
    ) -> Self {
        let coordinates = table.project(query, &cells);
        let factors = (0..cells.len()).flat_map(|cell| table.factors(&coordinates, cell)).collect();
        let further: Vec<FurtherFactors> =
            coordinates.further.iter().map(|further| further.factors()).collect();
        let sum = |factors: &FurtherFactors| factors.0.iter().map(|&f| i32::from(f)).sum::<i32>();
        let units = table.units();
        let codes = [units.first, units.further].map(|unit| unit.powi(-2));
        let [first, residual] = table.largest_errors().map(|error| error * cells.len() as f64);
        let own =
            [&coordinates.first_errors, &coordinates.further_errors].map(|errors| errors.iter().sum::<f64>());
        Self {
            further_square: coordinates.further.iter().map(|further| further.square()).sum(),
            further_bias: 128 * further.iter().map(sum).sum::<i32>(),
            square: coordinates.first_squares.iter().map(|&square| f64::from(square)).sum(),
            bias: f64::from(table.bias(&coordinates)),
            first_error: (own[0] * codes[0]).sqrt() + (first * codes[0]).sqrt(),
            error: (own[0] * codes[0] + own[1] * codes[1]).sqrt()
                + (first * codes[0] + residual * codes[1]).sqrt(),
            codes,
            targets: BlockTarget::all(query, exemplars),
            near: u64::MAX,
            query,
            cells,
            coordinates,
            factors,
            further,
        }
    }

    /// The squared distance of a position, if it is at most `limit` and not left out.
    pub fn distance(&self, position: Texel, limit: u64) -> Option<u64> {
        if self.query.avoided.contains(position) {
            return None;
        }
        let Texel { exemplar, y, x } = position;
        self.targets[exemplar as usize].distance_within(x as usize, y as usize, limit)
    }

    /// The distance of a position if it is smaller than `best`, otherwise `best`.
    pub fn nearer(&self, position: Texel, best: u64) -> u64 {
        self.distance(position, best).map_or(best, |distance| distance.min(best))
    }

    /// The squared length, in codes, of the difference of all rounded coordinates.
    #[inline(always)]
    pub fn length(&self, nearness: i32, further: i32) -> f64 {
        let first = self.square - 2.0 * (f64::from(nearness) - self.bias);
        first * self.codes[0] + f64::from(further) * self.codes[1]
    }

    /// The squared length beyond which no difference of all rounded coordinates can belong to a squared
    /// distance of at most `limit`.
    pub fn longest(&self, limit: u64) -> f64 {
        widened(limit, self.error)
    }

    /// The nearness below which no position can have a squared distance of at most `limit`; the
    /// smallest number, which keeps everything, where it would overflow.
    pub fn least_nearness(&self, limit: u64) -> i32 {
        let longest = widened(limit, self.first_error) / self.codes[0] + 1.0;
        ((self.square - longest) / 2.0 + self.bias).floor() as i32
    }

    /// The largest accepted distance when `best` is the smallest.
    pub fn limit(&self, best: u64) -> u64 {
        self.query.acceptance.limit(best)
    }
}

/// The square of a length that may be too small by `error`, with a margin for the rounding of everything
/// computed from it.
fn widened(square: u64, error: f64) -> f64 {
    ((square as f64).sqrt() + error * (1.0 + 1e-6)).powi(2) * (1.0 + 1e-9)
}
