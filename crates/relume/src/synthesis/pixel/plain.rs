//! The slow truth of the search: every position, tap by tap, plane by plane.

use super::window::WindowQuery;
use crate::synthesis::positions::Positions;
use crate::synthesis::quantise::Quantised;
use crate::synthesis::source_map::Texel;

/// More than any distance, and far from overflowing: marks lanes that hold no position.
pub const NOWHERE: u64 = 1 << 62;

/// The positions of candidate windows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Matches {
    /// The smallest weighted squared distance over all positions.
    pub best: u64,
    /// The top-left texels of all windows within (1 + epsilon) times it, in order.
    pub positions: Vec<Texel>,
}

impl Matches {
    /// The positions, given with their distances, within (1 + `epsilon`) of the nearest.
    pub fn within(near: &[(Texel, u64)], epsilon: f64) -> Self {
        let best = near.iter().map(|(_, distance)| *distance).min().unwrap_or(0);
        let limit = limit(best, epsilon);
        let fitting = near.iter().filter(|(_, distance)| *distance <= limit);
        Self { best, positions: fitting.map(|(position, _)| *position).collect() }
    }
}

/// The largest accepted distance when `best` is the smallest; it increases with `best`.
pub fn limit(best: u64, epsilon: f64) -> u64 {
    best.saturating_add((best as f64 * epsilon) as u64).min(NOWHERE - 1)
}

/// Compares every position.
pub fn matches(exemplars: &Quantised, positions: &Positions, query: &WindowQuery, epsilon: f64) -> Matches {
    let all = (0..positions.count()).map(|number| positions.nth(number));
    let near: Vec<(Texel, u64)> =
        all.map(|position| (position, distance(exemplars, query, position))).collect();
    Matches::within(&near, epsilon)
}

/// The weighted squared distance, in codes, of a query and the window whose top-left texel is
/// `position`.
pub fn distance(exemplars: &Quantised, query: &WindowQuery, position: Texel) -> u64 {
    let exemplar = &exemplars.texels()[position.exemplar as usize];
    let guides = query.guide_codes.len() / query.guide_taps.len().max(1);
    let copied = exemplars.planes() - guides;
    let known = query.taps.iter().zip(query.codes.chunks_exact(copied)).map(|(t, c)| (t, c, 0..copied));
    let guided = query.guide_taps.iter().zip(query.guide_codes.chunks_exact(guides.max(1)));
    known
        .chain(guided.map(|(t, c)| (t, c, copied..copied + guides)))
        .map(|(tap, codes, planes)| {
            let (x, y) = query.place(tap);
            let there = &exemplar.run(position.x as usize + x, position.y as usize + y, 1)[planes];
            let squares = there.iter().zip(codes).map(|(a, b)| u64::from(a.abs_diff(*b)).pow(2));
            tap.weight.value() * squares.sum::<u64>()
        })
        .sum()
}
