//! What an oblique viewer sees at each texel: the first point of the relief on the line of sight.
//!
//! The line passes through the middle of the texel at the level of the reference plane. It is followed from above the
//! highest texel down, across the lines of the grid, between which the relief is linear (as in [`super::march`]), and
//! the point where it falls below the relief is interpolated. All texels of a row share their steps. This is relief
//! mapping with an exact search (F. Policarpo, M. M. Oliveira, J. L. D. Comba, Real-time relief mapping on arbitrary
//! polygonal surfaces, I3D 2005); [`seen_by_brute_force`] is the slow truth.

use super::march::{Crossing, Heading, crossings};
use super::relief::Relief;
use crate::direction::Direction;

/// Lines of sight towards one viewer.
#[derive(Debug, Clone)]
pub struct SightLines {
    /// Towards the viewer.
    heading: Heading,
    /// The level of the reference plane.
    level: f32,
    /// The rise per texel of distance; infinite where the viewer is straight above.
    rise: f32,
    /// The places where the lines meet lines of the grid, from the viewer on.
    stations: Vec<Station>,
}

/// A place on a line of sight, between two texels relative to its own.
#[derive(Debug, Clone, Copy)]
struct Station {
    texels: [[isize; 2]; 2],
    weight: f32,
    /// The horizontal distance from the texel, negative away from the viewer.
    distance: f32,
}

impl Station {
    fn new(crossing: &Crossing, side: f32) -> Self {
        let Crossing { texels, weight, per_distance } = *crossing;
        Self { texels, weight, distance: side / per_distance }
    }
}

/// Any two lines of the grid are met within this distance.
const BETWEEN_LINES: f64 = 2.0;

impl SightLines {
    /// The lines towards a viewer above the surface, through the texels at `level`.
    pub fn new(relief: &Relief, view: Direction, level: f32) -> Self {
        let level_length = view.x().hypot(view.y());
        if level_length < 1e-9 {
            let heading = Heading { column: 0.0, row: 0.0 };
            return Self { heading, level, rise: f32::INFINITY, stations: Vec::new() };
        }
        let heading = Heading { column: view.x() / level_length, row: -view.y() / level_length };
        let rise = view.z() / level_length;
        let reach = |height: f32| (f64::from(height) / rise).clamp(0.0, relief.reach()) + BETWEEN_LINES;
        let lowest = relief.highest() - relief.range();
        let ahead = crossings(heading, reach(relief.highest() - level));
        let behind = crossings(heading.opposite(), reach(level - lowest));
        let own = Station { texels: [[0; 2]; 2], weight: 0.0, distance: 0.0 };
        let towards = ahead.iter().rev().map(|crossing| Station::new(crossing, 1.0));
        let away = behind.iter().map(|crossing| Station::new(crossing, -1.0));
        let stations = towards.chain([own]).chain(away).collect();
        Self { heading, level, rise: rise as f32, stations }
    }

    /// Towards the viewer.
    pub fn heading(&self) -> Heading {
        self.heading
    }

    /// For each texel of row `y` the distance towards the viewer of what is seen there.
    pub fn seen(&self, relief: &Relief, y: usize, distances: &mut [f32]) {
        // Straight above, or where nothing is met within reach.
        distances.fill(self.stations.last().map_or(0.0, |station| station.distance));
        let mut clearances = vec![f32::MAX; distances.len()];
        let mut from = self.stations.first().map_or(0.0, |station| station.distance);
        for (number, station) in self.stations.iter().enumerate() {
            self.descend(relief, y, from, station, &mut clearances, distances);
            from = station.distance;
            if number % 8 == 7 && clearances.iter().all(|clearance| *clearance <= 0.0) {
                break;
            }
        }
    }

    /// One step of all lines of a row, from distance `from` to a station. A clearance that is not positive stays so.
    fn descend(
        &self,
        relief: &Relief,
        y: usize,
        from: f32,
        station: &Station,
        clearances: &mut [f32],
        distances: &mut [f32],
    ) {
        let [near, far] = station.texels.map(|[column, row]| relief.row(y as isize + row, column));
        let (weight, to) = (station.weight, station.distance);
        let sight = self.level + to * self.rise;
        pulp::Arch::new().dispatch(
            #[inline(always)]
            || {
                let lines = clearances.iter_mut().zip(distances.iter_mut()).zip(near).zip(far);
                for (((clearance, distance), &a), &b) in lines {
                    let (before, after) = (*clearance, sight - (a + (b - a) * weight));
                    let met = from + (to - from) * (before / (before - after));
                    let is_met = before > 0.0 && after <= 0.0;
                    *distance = if is_met { met } else { *distance };
                    *clearance = if before > 0.0 { after } else { before };
                }
            },
        );
    }
}

/// The slow truth: the distance towards the viewer at which the line of sight of texel (x, y) meets the bilinear
/// relief, in steps of `step` texels of height or distance, whichever is less, from above the highest texel down.
pub fn seen_by_brute_force(
    relief: &Relief,
    texel: [usize; 2],
    view: Direction,
    level: f64,
    step: f64,
) -> f64 {
    let [x, y] = texel.map(|c| c as f64);
    let [along_x, along_y] = [view.x() / view.z(), -view.y() / view.z()];
    let tangent = along_x.hypot(along_y);
    let (top, drop) = (f64::from(relief.highest()) - level, step / tangent.max(1.0));
    let clearance = |height: f64| level + height - relief.between(x + height * along_x, y + height * along_y);
    let steps = (f64::from(relief.range()) / drop).ceil() as usize + 1;
    let met = (0..=steps).map(|k| top - k as f64 * drop).find(|height| clearance(*height) <= 0.0);
    met.unwrap_or(f64::from(relief.highest() - relief.range()) - level) * tangent
}

#[cfg(test)]
mod tests {
    use super::super::relief::{ReliefBorder, relief_of as relief};
    use super::*;
    use crate::size::Size;

    fn all_seen(relief: &Relief, view: Direction, level: f32) -> Vec<f32> {
        let lines = SightLines::new(relief, view, level);
        let mut distances = vec![7.0; relief.size().texels()];
        let rows = distances.chunks_exact_mut(relief.size().width).enumerate();
        rows.for_each(|(y, row)| lines.seen(relief, y, row));
        distances
    }

    #[test]
    fn a_plane_at_its_own_level_and_a_viewer_straight_above_move_nothing() {
        let flat = relief(Size::new(7, 5), ReliefBorder::Wrap, |_, _| 3.7);
        let bumps = relief(Size::new(7, 5), ReliefBorder::Wrap, |x, y| 3.0 * (x * 1.3).sin() * y);
        for azimuth in 0..24 {
            let view = Direction::from_angles(1.2, f64::from(azimuth));
            assert!(all_seen(&flat, view, 3.7).iter().all(|d| d.abs() < 1e-5));
        }
        assert!(all_seen(&bumps, Direction::ZENITH, 1.0).iter().all(|d| *d == 0.0));
    }

    #[test]
    fn a_plane_above_or_below_the_reference_moves_by_the_tangent() {
        let flat = relief(Size::new(9, 6), ReliefBorder::Wrap, |_, _| 2.0);
        for (polar, azimuth, level) in [(0.6f64, 0.3, 0.0f32), (1.1, 2.0, 5.5), (1.3, 4.4, -1.25)] {
            let seen = all_seen(&flat, Direction::from_angles(polar, azimuth), level);
            let truth = (2.0 - level) * polar.tan() as f32;
            assert!(seen.iter().all(|d| (d - truth).abs() < 1e-4), "{seen:?} {truth}");
        }
    }

    /// A step of 8 at column 20, seen at 45 degrees from either side.
    #[test]
    fn the_parallax_of_a_step_is_where_geometry_says() {
        let step = relief(Size::new(48, 3), ReliefBorder::Clamp, |x, _| if x >= 20.0 { 8.0 } else { 0.0 });
        let level = 3.0;
        let of = |azimuth: f64| {
            let seen = all_seen(&step, Direction::from_angles(std::f64::consts::FRAC_PI_4, azimuth), level);
            (0..48).map(|x| seen[48 + x]).collect::<Vec<f32>>()
        };
        // From the right, the wall is hidden behind its own edge: top and bottom, each shifted.
        for (x, distance) in of(0.0).into_iter().enumerate() {
            let truth = if x >= 15 { 5.0 } else { -3.0 };
            assert!((distance - truth).abs() < 1e-4, "texel {x}: {distance}, not {truth}");
        }
        // From the left, towards which distances count: the bottom before the wall, eight texels of wall, the top.
        for (x, distance) in of(std::f64::consts::PI).into_iter().enumerate() {
            let place = x as f32 - distance;
            match x {
                0..16 => assert!((place - (x as f32 + 3.0)).abs() < 1e-4, "texel {x}: {place}"),
                25.. => assert!((place - (x as f32 - 5.0)).abs() < 1e-4, "texel {x}: {place}"),
                _ => assert!((19.0..=20.0).contains(&place), "texel {x}: {place} is no wall"),
            }
        }
    }

    #[test]
    fn what_is_seen_agrees_with_brute_force() {
        let size = Size::new(37, 29);
        let tau = std::f64::consts::TAU;
        let bumps = |x: f64, y: f64| {
            let wave = 3.0 * (x * 3.0 * tau / 37.0).sin() * (y * 2.0 * tau / 29.0).cos();
            wave + if x > 18.0 { 4.0 } else { 0.0 }
        };
        for border in [ReliefBorder::Wrap, ReliefBorder::Clamp] {
            let relief = relief(size, border, bumps);
            for (polar, azimuth) in [(0.3, 0.1), (0.8, 2.4), (1.0, 3.2), (1.3, 5.0), (1.3, 0.7)] {
                let view = Direction::from_angles(polar, azimuth);
                let fast = all_seen(&relief, view, 2.0);
                let off = |i: usize| {
                    let slow = seen_by_brute_force(&relief, [i % 37, i / 37], view, 2.0, 1.0 / 64.0);
                    (f64::from(fast[i]) - slow).abs()
                };
                // Inside a cell the relief bulges by at most a quarter of its twist (0.06), which a grazing line
                // meets elsewhere; at silhouettes one of the two may pass where the other is stopped.
                let near = (0..size.texels()).filter(|i| off(*i) < 0.1 + 0.08 * polar.tan()).count();
                assert!(
                    near * 100 >= size.texels() * 98,
                    "{border:?} {polar} {azimuth}: {near} texels agree"
                );
            }
        }
    }
}
