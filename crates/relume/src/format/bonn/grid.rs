//! Every view with every light: the order of pairs in the files that are written.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use crate::direction::{Direction, Directions};
use crate::error::{Error, Result};

/// Views and lights, and where each of their pairs stands in a list.
#[derive(Debug, PartialEq)]
pub(super) struct ViewLightGrid {
    pub(super) views: Vec<[f32; 2]>,
    pub(super) lights: Vec<[f32; 2]>,
    /// The number in the list of the pair of a view and a light, view after view.
    pub(super) order: Vec<usize>,
}

/// A direction by its angles, so that directions that differ by rounding only are one.
type AngleKey = (i64, i64);

impl ViewLightGrid {
    /// The grid of pairs in any order.
    ///
    /// # Errors
    /// Unless each view has each light once.
    pub(super) fn of(pairs: &[Directions]) -> Result<Self> {
        let (mut views, mut lights) = (NumberedDirections::default(), NumberedDirections::default());
        let places: Vec<(usize, usize)> =
            pairs.iter().map(|pair| (views.number(pair.view), lights.number(pair.light))).collect();
        let (views, lights) = (views.angles, lights.angles);
        let mut order = vec![usize::MAX; views.len() * lights.len()];
        for (i, (view, light)) in places.into_iter().enumerate() {
            let place = &mut order[view * lights.len() + light];
            if *place != usize::MAX {
                return Err(Error::unsupported(format!(
                    "pairs {} and {i} of light and view are the same: a .btf file has one image for each",
                    *place
                )));
            }
            *place = i;
        }
        if pairs.is_empty() || order.contains(&usize::MAX) {
            return Err(Error::unsupported(format!(
                "{} pairs of {} views and {} lights are not every view with every light, as the readers of .btf files \
                 expect",
                pairs.len(),
                views.len(),
                lights.len()
            )));
        }
        Ok(Self { views, lights, order })
    }
}

/// Directions in the order in which they occur first.
#[derive(Default)]
struct NumberedDirections {
    numbers: BTreeMap<AngleKey, usize>,
    angles: Vec<[f32; 2]>,
}

impl NumberedDirections {
    fn number(&mut self, direction: Direction) -> usize {
        let angles = angles(direction);
        let next = self.angles.len();
        let number = *self.numbers.entry(key(angles)).or_insert(next);
        if number == next {
            self.angles.push(angles.map(|angle| angle as f32));
        }
        number
    }
}

/// Polar angle and azimuth in [0, 2 pi); the azimuth of the zenith is 0.
fn angles(direction: Direction) -> [f64; 2] {
    let [x, y, z] = direction.to_array();
    let (radius, azimuth) = (x.hypot(y), y.atan2(x));
    if radius < 1e-9 {
        return [0.0, 0.0];
    }
    [radius.atan2(z), if azimuth < 0.0 { azimuth + TAU } else { azimuth }]
}

/// Angles in steps of 1e-5, in which 2 pi is 0.
fn key([polar, azimuth]: [f64; 2]) -> AngleKey {
    let step = |angle: f64| (angle * 1e5).round() as i64;
    (step(polar), step(azimuth) % step(TAU))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pair(light: (f64, f64), view: (f64, f64)) -> Directions {
        let direction = |(polar, azimuth)| Direction::from_angles(polar, azimuth);
        Directions { light: direction(light), view: direction(view) }
    }

    #[test]
    fn pairs_in_any_order_are_found_in_their_grid() {
        let (a, b, c) = ((0.0, 0.0), (0.5, 3.0), (1.2, 6.25));
        let pairs = [pair(b, a), pair(c, b), pair(a, b), pair(a, a), pair(c, a), pair(b, b)];
        let grid = ViewLightGrid::of(&pairs).unwrap();
        assert_eq!((grid.views.len(), grid.lights.len()), (2, 3));
        // Lights in the order b, c, a.
        assert_eq!(grid.order, [0, 4, 3, 5, 1, 2]);
        assert_eq!(grid.lights, [[0.5, 3.0], [1.2, 6.25], [0.0, 0.0]]);
    }

    #[test]
    fn incomplete_grids_and_double_pairs_are_refused() {
        let (a, b) = ((0.0, 0.0), (0.5, 3.0));
        let message = |pairs: &[Directions]| ViewLightGrid::of(pairs).unwrap_err().to_string();
        assert!(message(&[pair(a, a), pair(a, b), pair(b, a)]).contains("3 pairs of 2 views and 2 lights"));
        assert!(message(&[pair(a, a), pair(a, a)]).contains("pairs 0 and 1"));
        assert!(message(&[]).contains("0 pairs"));
    }
}
