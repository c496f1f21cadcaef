//! The order in which texels grow: rounds of the texels that touch known ones, those with the most known
//! texels around them first (Efros, Leung 1999), ties in an order drawn from the seed.
//!
//! Texels outside each other's windows can be decided in parallel. [`batches`] splits a round so that each
//! texel comes after those before it in the order that lie in its window, and before those after it: the
//! result is that of sequential growth, at any number of threads.

use std::cmp::Reverse;

use super::canvas::PixelCanvas;
use crate::numeric::random::{Purpose, Stream};

/// The unknown texels that touch known ones.
pub fn first(canvas: &PixelCanvas) -> Vec<usize> {
    let touches = |&texel: &usize| around(canvas, texel, 1).any(|there| canvas.is_known(there));
    canvas.unknown().filter(touches).collect()
}

/// The unknown texels that touch those made known by the last round.
pub fn next(canvas: &PixelCanvas, made: &[usize]) -> Vec<usize> {
    let touched = made.iter().flat_map(|&texel| around(canvas, texel, 1));
    let mut front: Vec<usize> = touched.filter(|&texel| !canvas.is_known(texel)).collect();
    front.sort_unstable();
    front.dedup();
    front
}

/// The texels of a round in the order of growth.
pub fn ordered(canvas: &PixelCanvas, front: Vec<usize>, radius: usize, seed: u64) -> Vec<usize> {
    let key = |&texel: &usize| {
        let known = match canvas.inner_rows(texel, radius) {
            Some(mut rows) => canvas.known_in(&mut rows),
            None => around(canvas, texel, radius).filter(|&there| canvas.is_known(there)).count(),
        };
        (Reverse(known), Stream::new(seed, Purpose::GrowthOrder, [texel as u64]).below(1 << 32), texel)
    };
    let mut order = front;
    order.sort_by_cached_key(key);
    order
}

/// The order split into batches of texels outside each other's windows. `batch_of` holds a zero for each
/// texel of the canvas, before and after.
pub fn batches(
    canvas: &PixelCanvas,
    order: &[usize],
    radius: usize,
    batch_of: &mut [usize],
) -> Vec<Vec<usize>> {
    let mut batches: Vec<Vec<usize>> = Vec::new();
    for &texel in order {
        let batch = match canvas.inner_rows(texel, radius) {
            Some(rows) => rows.flat_map(|row| &batch_of[row]).fold(0, |most, &batch| most.max(batch)),
            None => around(canvas, texel, radius).map(|there| batch_of[there]).max().unwrap_or(0),
        };
        batch_of[texel] = batch + 1;
        if batch == batches.len() {
            batches.push(Vec::new());
        }
        batches[batch].push(texel);
    }
    order.iter().for_each(|&texel| batch_of[texel] = 0);
    batches
}

/// The texels within `radius` columns and rows of one, without itself.
fn around(canvas: &PixelCanvas, texel: usize, radius: usize) -> impl Iterator<Item = usize> {
    let (place, radius) = (canvas.place(texel), radius.cast_signed());
    let places = (-radius..=radius).flat_map(move |dy| (-radius..=radius).map(move |dx| (dx, dy)));
    let others = places.filter(|place| *place != (0, 0));
    others.filter_map(move |(dx, dy)| canvas.beside(place, dx, dy))
}
