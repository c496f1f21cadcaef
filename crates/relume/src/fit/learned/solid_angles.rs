//! The shares of measured directions in the hemisphere: the areas of their spherical Voronoi cells, so that
//! many directions close together do not outvote few that stand for as much.

use crate::direction::{Direction, Directions};
use crate::fit::held_out::{place, sorted};
use crate::parallel;
use std::f64::consts::TAU;

/// Points of the hemisphere whose nearest direction is found; each stands for an equal area.
const POINTS: usize = 1 << 15;

/// A grid of lights and views with less than this share of its pairs is no grid.
const LEAST_FILLED: f64 = 0.5;

/// The weight of each pair: the product of the areas of its light's and view's cells where the pairs are those
/// of a grid, and otherwise equal. The sum is (2 pi)^2 for complete grids and for pairs without one.
pub fn pair_weights(pairs: &[Directions]) -> Vec<f64> {
    let lights = sorted(pairs.iter().map(|pair| pair.light));
    let views = sorted(pairs.iter().map(|pair| pair.view));
    if (pairs.len() as f64) < LEAST_FILLED * (lights.len() * views.len()) as f64 {
        return vec![TAU * TAU / pairs.len() as f64; pairs.len()];
    }
    let (light_areas, view_areas) = (areas(&lights), areas(&views));
    let weight =
        |pair: &Directions| light_areas[place(&lights, pair.light)] * view_areas[place(&views, pair.view)];
    pairs.iter().map(weight).collect()
}

/// The area of the part of the hemisphere that is nearer to each direction than to the others, by counting the
/// points of a Fibonacci lattice; at least that of one point.
fn areas(directions: &[Direction]) -> Vec<f64> {
    let point = Direction::fibonacci(POINTS);
    let mut nearest = vec![0; POINTS];
    parallel::for_each_value(&mut nearest, |i, nearest| *nearest = place(directions, point(i)));
    let mut counts = vec![0usize; directions.len()];
    nearest.into_iter().for_each(|i| counts[i] += 1);
    counts.into_iter().map(|count| TAU * count.max(1) as f64 / POINTS as f64).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_of_rings_have_the_areas_of_their_zones() {
        let mut directions = vec![Direction::ZENITH];
        for (ring, count) in [(1, 6), (2, 12), (3, 18), (4, 20), (5, 24)] {
            let polar = (15.0 * f64::from(ring)).to_radians();
            directions.extend(
                (0..count).map(|i| Direction::from_angles(polar, TAU * f64::from(i) / f64::from(count))),
            );
        }
        let areas = areas(&directions);
        assert!((areas.iter().sum::<f64>() - TAU).abs() < 1e-9);
        // The cap within 7.5 degrees, the cell of the zenith, is a hexagon around it: a little larger.
        let cap = TAU * (1.0 - 7.5f64.to_radians().cos());
        assert!(areas[0] > cap && areas[0] < 1.2 * cap, "{} and {cap}", areas[0]);
        // Beyond the middle between the last rings: cells with curved sides, so within some percent.
        let rim = TAU * 67.5f64.to_radians().cos() / 24.0;
        assert!(areas[57..].iter().all(|a| (a / rim - 1.0).abs() < 0.05), "{:?} and {rim}", &areas[57..]);
    }

    #[test]
    fn pairs_without_a_grid_have_equal_weights() {
        let pairs: Vec<Directions> = (0..20)
            .map(|i| f64::from(i) * 0.07)
            .map(|t| Directions {
                light: Direction::from_angles(t, 5.0 * t),
                view: Direction::from_angles(1.3 - t, t),
            })
            .collect();
        let weights = pair_weights(&pairs);
        assert!(weights.iter().all(|w| (w - TAU * TAU / 20.0).abs() < 1e-12));
    }
}
