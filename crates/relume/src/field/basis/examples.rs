//! One basis of each kind, for tests that run over the family.

use std::f64::consts::TAU;

use super::{Basis, Interpolated, Interpolation, Learned};
use crate::direction::{Direction, Directions};

/// The named bases, interpolated ones, and small learned ones with a view: of three channels, and of one.
pub(super) fn all() -> Vec<Basis> {
    let learned = [learned_of_channels(3, 9, 4, 3), learned(12, 5, 4)];
    let lights = spread(11);
    let interpolated = Interpolation::ALL.map(|rule| {
        Basis::Interpolated(Interpolated::new(&lights, rule).expect("lights in different directions"))
    });
    Basis::NAMED.into_iter().chain(interpolated).chain(learned.map(Basis::Learned)).collect()
}

/// A learned basis of smooth functions on all pairs of `lights` and `views`.
pub(crate) fn learned(lights: usize, views: usize, functions: usize) -> Learned {
    learned_of_channels(1, lights, views, functions)
}

/// As [`learned`], with a value for each channel.
pub(crate) fn learned_of_channels(channels: usize, lights: usize, views: usize, functions: usize) -> Learned {
    learned_at(grid(lights, views), channels, functions)
}

/// As [`learned`], without some of the pairs.
#[cfg(test)]
pub(super) fn scattered(lights: usize, views: usize, functions: usize) -> Learned {
    let kept = grid(lights, views).into_iter().enumerate().filter(|(i, _)| i % 5 != 2);
    learned_at(kept.map(|(_, pair)| pair).collect(), 1, functions)
}

/// All pairs of lights and views.
fn grid(lights: usize, views: usize) -> Vec<Directions> {
    spread(lights)
        .into_iter()
        .flat_map(|light| spread(views).into_iter().map(move |view| Directions { light, view }))
        .collect()
}

/// A learned basis of smooth functions at some pairs.
fn learned_at(pairs: Vec<Directions>, channels: usize, functions: usize) -> Learned {
    let weight = TAU * TAU / pairs.len() as f64;
    let smooth = |k: usize, channel: usize, pair: &Directions| {
        let [x, y, z] = pair.light.to_array();
        let half = pair.light.dot(pair.view);
        // A frequency that grows with the number of the function, each in its own direction.
        let angle = 1.3 * k as f64 + 0.4 * channel as f64;
        1.0 / (k + 1) as f64 + (0.5 * k as f64 * (x * angle.cos() + y * angle.sin()) + half + 0.2 * z).sin()
    };
    let column = |k: usize| pairs.iter().flat_map(move |pair| (0..channels).map(move |c| smooth(k, c, pair)));
    let mut columns: Vec<Vec<f64>> = (0..functions).map(|k| column(k).collect()).collect();
    make_orthonormal(&mut columns, weight);
    let rows = 0..pairs.len() * channels;
    let values = rows.flat_map(|i| columns.iter().map(move |column| column[i] as f32)).collect();
    let weights = vec![weight; pairs.len()];
    Learned::of_channels(channels, pairs, weights, values).expect("orthonormal functions are a basis")
}

/// Directions spread evenly over the hemisphere: a Fibonacci lattice.
fn spread(count: usize) -> Vec<Direction> {
    (0..count).map(Direction::fibonacci(count)).collect()
}

/// Modified Gram-Schmidt under one weight for all pairs, twice for full precision.
fn make_orthonormal(columns: &mut [Vec<f64>], weight: f64) {
    let dot = |a: &[f64], b: &[f64]| weight * a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    for k in 0..columns.len() {
        let (before, rest) = columns.split_at_mut(k);
        let column = &mut rest[0];
        for other in before.iter().chain(before.iter()) {
            let share = dot(column, other);
            column.iter_mut().zip(other).for_each(|(c, o)| *c -= share * o);
        }
        let norm = dot(column, column).sqrt();
        column.iter_mut().for_each(|c| *c /= norm);
    }
}
