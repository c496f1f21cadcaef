//! Marching over a relief: the steepest slope at which a texel sees the relief in one azimuth.
//!
//! Between texels on one line of the grid the height is linear, so along a ray its slope changes only where
//! the ray crosses a grid line (inside a cell it deviates by at most a quarter of the twist of the cell,
//! which is ignored). Crossings of both families of lines are visited in order, and **all texels of a row at
//! once**: they share the offsets and weights of each crossing, so a step is a sum over contiguous rows that
//! the compiler vectorises. A row stops as soon as the highest texel of the relief could no longer rise above
//! the steepest slope so far. Heights and distances are in texels; a slope is the tangent of an elevation.
//!
//! The horizon method is N. Max, Horizon mapping: shadows for bump-mapped surfaces, The Visual Computer 4,
//! 1988; [`slope_by_brute_force`] is the slow truth.

use super::relief::Relief;

/// Where a ray crosses a grid line, relative to the texel it starts from: between two neighbours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crossing {
    /// Column and row of both neighbours.
    pub texels: [[isize; 2]; 2],
    /// Weight of the second neighbour.
    pub weight: f32,
    /// One over the horizontal distance.
    pub per_distance: f32,
}

impl Crossing {
    /// The nearer neighbour.
    pub fn nearest(&self) -> [isize; 2] {
        self.texels[usize::from(self.weight > 0.5)]
    }
}

/// A horizontal unit vector in columns to the right and rows **down**.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Heading {
    /// Columns to the right.
    pub column: f64,
    /// Rows down.
    pub row: f64,
}

impl Heading {
    /// The heading of an azimuth counted from x towards y.
    pub fn from_azimuth(azimuth_rad: f64) -> Self {
        Self { column: azimuth_rad.cos(), row: -azimuth_rad.sin() }
    }

    /// The way back.
    pub fn opposite(self) -> Self {
        Self { column: -self.column, row: -self.row }
    }
}

/// All crossings on the way out to `reach` texels, nearest first.
pub fn crossings(heading: Heading, reach: f64) -> Vec<Crossing> {
    let to_line = |component: f64, line: u32| f64::from(line) / component.abs().max(1e-12);
    let (mut column_line, mut row_line) = (1u32, 1u32);
    let mut path = Vec::new();
    loop {
        let to_column = to_line(heading.column, column_line);
        let to_row = to_line(heading.row, row_line);
        let distance = to_column.min(to_row);
        if distance > reach {
            return path;
        }
        let on_column = to_column <= distance + 1e-6;
        if on_column {
            let column = (heading.column.signum() * f64::from(column_line)) as isize;
            let (low, high, weight) = neighbours(distance * heading.row);
            path.push(crossing([[column, low], [column, high]], weight, distance));
            column_line += 1;
        } else {
            let row = (heading.row.signum() * f64::from(row_line)) as isize;
            let (low, high, weight) = neighbours(distance * heading.column);
            path.push(crossing([[low, row], [high, row]], weight, distance));
        }
        row_line += u32::from(to_row <= distance + 1e-6);
    }
}

fn crossing(texels: [[isize; 2]; 2], weight: f64, distance: f64) -> Crossing {
    Crossing { texels, weight: weight as f32, per_distance: (1.0 / distance) as f32 }
}

/// The integers on both sides of a position, and the weight of the upper one.
fn neighbours(place: f64) -> (isize, isize, f64) {
    let low = (place + 1e-6).floor();
    let weight = (place - low).max(0.0);
    (low as isize, low as isize + isize::from(weight > 1e-6), weight)
}

/// Calls `visit` with the number of each crossing on the way and the slopes at which the texels of row `y`
/// see it, until `visit` ends it or the relief ends.
#[inline(always)]
fn march(relief: &Relief, path: &[Crossing], y: usize, mut visit: impl FnMut(usize, &[f32]) -> Go) {
    let here = relief.row(y as isize, 0);
    let mut slopes = vec![0.0f32; here.len()];
    for (number, crossing) in path.iter().enumerate() {
        let [near, far] = crossing.texels.map(|[column, row]| relief.row(y as isize + row, column));
        let (weight, per_distance) = (crossing.weight, crossing.per_distance);
        for (((slope, &a), &b), &h) in slopes.iter_mut().zip(near).zip(far).zip(here) {
            *slope = (a + (b - a) * weight - h) * per_distance;
        }
        if visit(number, &slopes) == Go::Stop {
            return;
        }
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Go {
    On,
    Stop,
}

/// Raises `steepest` to the steepest slope at which each texel of row `y` sees the relief; slopes
/// below `negligible` may be missed.
pub fn steepest_slopes(relief: &Relief, path: &[Crossing], y: usize, negligible: f32, steepest: &mut [f32]) {
    let lowest = relief.row(y as isize, 0).iter().copied().fold(f32::INFINITY, f32::min);
    let rise = relief.highest() - lowest;
    pulp::Arch::new().dispatch(
        #[inline(always)]
        || {
            march(relief, path, y, |number, slopes| {
                for (best, &slope) in steepest.iter_mut().zip(slopes) {
                    *best = if slope > *best { slope } else { *best };
                }
                // The minimum of a row is computed only now and then.
                let ahead = rise * path[number].per_distance;
                if ahead < negligible || (number % 8 == 7 && ahead < least(steepest)) {
                    Go::Stop
                } else {
                    Go::On
                }
            });
        },
    );
}

/// For each texel of row `y`, the number of the first crossing seen at least as steeply as its `target`;
/// entries of `first` other than [`UNSEEN`] are kept.
pub fn first_at_least(relief: &Relief, path: &[Crossing], y: usize, targets: &[f32], first: &mut [u32]) {
    pulp::Arch::new().dispatch(
        #[inline(always)]
        || {
            march(relief, path, y, |number, slopes| {
                for ((first, &slope), &target) in first.iter_mut().zip(slopes).zip(targets) {
                    let found = if slope >= target { number as u32 } else { UNSEEN };
                    *first = found.min(*first);
                }
                let done = number % 8 == 7 && first.iter().all(|f| *f != UNSEEN);
                if done { Go::Stop } else { Go::On }
            });
        },
    );
}

/// No crossing.
pub const UNSEEN: u32 = u32::MAX;

#[inline(always)]
fn least(values: &[f32]) -> f32 {
    values.iter().copied().fold(f32::INFINITY, |a, b| if b < a { b } else { a })
}

/// The slow truth: the steepest slope at which texel (x, y) sees the bilinear relief, in steps of `step`
/// texels, from where the ray leaves the four cells around the texel out to `reach`.
pub fn slope_by_brute_force(
    relief: &Relief,
    texel: [usize; 2],
    heading: Heading,
    reach: f64,
    step: f64,
) -> f64 {
    let [x, y] = texel.map(|c| c as f64);
    let here = relief.between(x, y);
    let own = 1.0 / heading.column.abs().max(heading.row.abs());
    let distances = (1..=(reach / step) as usize).map(|k| k as f64 * step);
    let slopes = distances
        .filter(|d| *d >= own)
        .map(|d| (relief.between(x + d * heading.column, y + d * heading.row) - here) / d);
    slopes.fold(f64::NEG_INFINITY, f64::max)
}

#[cfg(test)]
mod tests {
    use super::super::relief::ReliefBorder;
    use super::*;
    use crate::planes::Planes;
    use crate::size::Size;

    /// Smooth bumps with a step across the middle.
    fn bumps(border: ReliefBorder) -> Relief {
        let size = Size::new(37, 29);
        let mut height = Planes::zeros(size, 1);
        for (i, h) in height.as_mut_slice().iter_mut().enumerate() {
            let (x, y) = ((i % 37) as f32, (i / 37) as f32);
            let tau = std::f32::consts::TAU;
            *h = 3.0 * (x * 3.0 * tau / 37.0).sin() * (y * 2.0 * tau / 29.0).cos()
                + if x > 18.0 { 4.0 } else { 0.0 };
        }
        Relief::new(&height, border)
    }

    #[test]
    fn crossings_lie_on_the_ray_and_on_grid_lines() {
        for degrees in 0..360 {
            let heading = Heading::from_azimuth(f64::from(degrees).to_radians());
            let path = crossings(heading, 20.0);
            let steps = 20.0 * (heading.column.abs() + heading.row.abs());
            assert!(
                path.len() as f64 <= steps + 1.0 && path.len() >= 14,
                "{degrees} degrees: {}",
                path.len()
            );
            for c in &path {
                let between = |k: usize| {
                    let [a, b] = c.texels.map(|t| t[k] as f64);
                    a + (b - a) * f64::from(c.weight)
                };
                let distance = 1.0 / f64::from(c.per_distance);
                assert!((between(0) - distance * heading.column).abs() < 1e-4, "{degrees} degrees");
                assert!((between(1) - distance * heading.row).abs() < 1e-4, "{degrees} degrees");
            }
            assert!(path.windows(2).all(|p| p[0].per_distance > p[1].per_distance), "{degrees} degrees");
        }
    }

    #[test]
    fn slopes_agree_with_brute_force() {
        for border in [ReliefBorder::Wrap, ReliefBorder::Clamp] {
            let relief = bumps(border);
            for degrees in [0, 17, 45, 90, 133, 180, 211, 270, 301] {
                let heading = Heading::from_azimuth(f64::from(degrees).to_radians());
                let path = crossings(heading, 60.0);
                for y in [0, 13, 28] {
                    let mut fast = vec![-10.0; 37];
                    steepest_slopes(&relief, &path, y, -10.0, &mut fast);
                    for (x, &fast) in fast.iter().enumerate() {
                        let slow = slope_by_brute_force(&relief, [x, y], heading, 60.0, 1.0 / 64.0);
                        // The bulge inside a cell: at most a quarter of the twist, here 3 * 0.51 * 0.43.
                        let near = (f64::from(fast) - slow).abs() < 0.06 + 0.02 * slow.abs();
                        assert!(near, "{border:?} {degrees} degrees ({x}, {y}): {fast} {slow}");
                    }
                }
            }
        }
    }

    #[test]
    fn stopping_early_changes_nothing_above_the_negligible() {
        let relief = bumps(ReliefBorder::Wrap);
        let path = crossings(Heading::from_azimuth(0.4), 200.0);
        for y in 0..29 {
            let mut all = vec![-100.0; 37];
            steepest_slopes(&relief, &path, y, f32::NEG_INFINITY, &mut all);
            let mut some = vec![0.1; 37];
            steepest_slopes(&relief, &path, y, 0.1, &mut some);
            assert!(some.iter().zip(&all).all(|(s, a)| *s == a.max(0.1)));
        }
    }

    #[test]
    fn the_first_crossing_is_the_first() {
        let relief = bumps(ReliefBorder::Wrap);
        let path = crossings(Heading::from_azimuth(2.0), 50.0);
        let targets: Vec<f32> = (0..37).map(|x| 0.02 * x as f32).collect();
        let mut first = vec![UNSEEN; 37];
        first_at_least(&relief, &path, 11, &targets, &mut first);
        let slope = |x: isize, c: &Crossing| {
            let [a, b] = c.texels.map(|t| relief.at(x + t[0], 11 + t[1]));
            (a + (b - a) * c.weight - relief.at(x, 11)) * c.per_distance
        };
        for x in 0..37 {
            let truth = path.iter().position(|c| slope(x as isize, c) >= targets[x]);
            assert_eq!(first[x], truth.map_or(UNSEEN, |k| k as u32), "texel {x}");
        }
        assert!(first.contains(&UNSEEN) && first.iter().any(|f| *f != UNSEEN));
    }
}
