//! The share of open sky over each texel of a relief, in a time that does not grow with its heights.
//!
//! As in [`Surroundings`](super::horizon::Surroundings), the sky is divided into sectors of azimuth, of which the horizon is
//! found. Here the headings are those of whole steps of the grid, so that lines of one heading pass through all texels, and the
//! horizons of a line are found together: from its end to its start, the points that can still be seen are the upper convex hull
//! of those passed, and a texel sees the point where its tangent touches the hull (V. Timonen, J. Westerholm, Scalable height
//! field self-shadowing, Computer Graphics Forum 29(2), 2010). Each point enters and leaves the hull once.
//!
//! Limits: one horizon a sector; lines end at a clamped border, beyond which nothing hides the sky; a periodic relief is followed
//! as far as its heights matter, but not beyond its sides together.

use std::f64::consts::{PI, TAU};

use super::horizon::{Facet, NEGLIGIBLE_SLOPE};
use super::relief::{Relief, ReliefBorder};
use crate::error::Result;
use crate::job::Job;
use crate::parallel;
use crate::planes::Planes;
use crate::size::Size;

/// Headings of an octant as steps along an axis and across it, at nearly equal angles.
const HEADINGS: [[usize; 2]; 3] = [[8, 1], [5, 2], [4, 3]];

/// Octants times headings.
const SECTORS: usize = 8 * HEADINGS.len();

/// Bytes for each texel: the sum, and on each thread a grid and its horizons.
fn bytes_per_texel() -> u64 {
    4 + 8 * rayon::current_num_threads().min(SECTORS) as u64
}

/// The cosine-weighted share of the hemisphere that is open sky, for each texel: 1 on a plane.
///
/// # Errors
/// The limits, and a cancelled job.
pub fn open_sky(relief: &Relief, normals: &Planes, job: &Job) -> Result<Planes> {
    let size = relief.size();
    job.check("the ambient occlusion", size, bytes_per_texel())?;
    job.start("ambient occlusion", SECTORS as u64);
    let mut sky = Planes::zeros_within(job, "the ambient occlusion", size, 1)?;
    let headings = headings();
    // As many at a time as there are threads; sums in the order of the headings.
    for together in headings.chunks(rayon::current_num_threads().max(1)) {
        let horizons = parallel::try_map(together.iter(), |heading| horizons(relief, heading, job))?;
        for (heading, horizons) in together.iter().zip(horizons) {
            let (azimuth, share) = (heading.azimuth_rad(), heading.width_rad() / PI);
            parallel::for_each_value(sky.as_mut_slice(), |texel, sum| {
                let (x, y) = (texel % size.width, texel / size.width);
                let slope = f64::from(horizons[heading.place(x, y, size)]);
                *sum += (Facet::new(normals, texel, azimuth).sky(slope) * share) as f32;
            });
            job.advance(1)?;
        }
    }
    sky.as_mut_slice().iter_mut().for_each(|share| *share = share.clamp(0.0, 1.0));
    Ok(sky)
}

/// A heading and the grid in which it leads along the rows, towards larger columns and rows: the relief mirrored and transposed.
#[derive(Debug, Clone, Copy)]
struct GridHeading {
    /// One of [`HEADINGS`].
    number: usize,
    mirrored: [bool; 2],
    transposed: bool,
}

fn headings() -> Vec<GridHeading> {
    let of = |octant: usize, number| GridHeading {
        number,
        mirrored: [octant & 1 == 1, octant & 2 == 2],
        transposed: octant & 4 == 4,
    };
    (0..8).flat_map(|octant| (0..HEADINGS.len()).map(move |number| of(octant, number))).collect()
}

/// The angle between the axis and a heading of an octant.
fn angle_rad(number: usize) -> f64 {
    let [along, across] = HEADINGS[number];
    (across as f64).atan2(along as f64)
}

impl GridHeading {
    /// From x towards y, which points up.
    fn azimuth_rad(self) -> f64 {
        let [along, across] = HEADINGS[self.number].map(|steps| steps as f64);
        let [x, row] = if self.transposed { [across, along] } else { [along, across] };
        let sign = |mirrored: bool| if mirrored { -1.0 } else { 1.0 };
        (-sign(self.mirrored[1]) * row).atan2(sign(self.mirrored[0]) * x)
    }

    /// The azimuths that are nearer to this heading than to any other.
    fn width_rad(self) -> f64 {
        let between = |a: usize| 0.5 * (angle_rad(a) + angle_rad(a + 1));
        let low = if self.number == 0 { 0.0 } else { between(self.number - 1) };
        let high = if self.number + 1 == HEADINGS.len() { TAU / 8.0 } else { between(self.number) };
        high - low
    }

    /// Columns and rows of the grid.
    fn grid(self, size: Size) -> Size {
        if self.transposed { Size::new(size.height, size.width) } else { size }
    }

    /// The index in the grid of a texel.
    fn place(self, x: usize, y: usize, size: Size) -> usize {
        let turn = |at: usize, side: usize, mirrored: bool| if mirrored { side - 1 - at } else { at };
        let (x, y) = (turn(x, size.width, self.mirrored[0]), turn(y, size.height, self.mirrored[1]));
        if self.transposed { x * size.height + y } else { y * size.width + x }
    }
}

/// The steepest slope, at least 0, at which each texel of the grid of a heading sees the relief.
fn horizons(relief: &Relief, heading: &GridHeading, job: &Job) -> Result<Vec<f32>> {
    let size = relief.size();
    let mut heights = vec![0.0; size.texels()];
    for y in 0..size.height {
        let row = relief.row(y as isize, 0);
        row.iter().enumerate().for_each(|(x, h)| heights[heading.place(x, y, size)] = *h);
    }
    let grid = HeightGrid { size: heading.grid(size), heights, wraps: relief.border() == ReliefBorder::Wrap };
    let [along, across] = HEADINGS[heading.number];
    let mut horizons = vec![0.0f32; size.texels()];
    let mut hull = Vec::new();
    for line in grid.lines([along, across], relief) {
        job.proceed()?;
        grid.follow(line, [along, across], &mut hull, &mut horizons);
    }
    Ok(horizons)
}

/// Heights along a heading.
struct HeightGrid {
    size: Size,
    heights: Vec<f32>,
    wraps: bool,
}

/// A line of a heading of `along` by `across` steps: at step s it is in column s / across and row (offset + s) / along.
#[derive(Debug, Clone, Copy)]
struct GridLine {
    offset: isize,
    first: usize,
    last: usize,
}

/// A point of a line.
#[derive(Debug, Clone, Copy)]
struct Point {
    step: usize,
    height: f32,
}

impl Point {
    /// The rise for each step to a point farther on.
    fn slope(self, to: Self) -> f32 {
        (to.height - self.height) / (to.step - self.step) as f32
    }
}

impl HeightGrid {
    /// Lines that pass each texel once, those of a periodic grid with what lies before them beyond the border.
    fn lines(&self, [along, across]: [usize; 2], relief: &Relief) -> Vec<GridLine> {
        let Size { width, height } = self.size;
        let (columns, rows) = (across * (width - 1), along * (height - 1));
        if self.wraps {
            let sides = (width + height) as f64;
            let reach = sides.min(f64::from(relief.range() / NEGLIGIBLE_SLOPE)).ceil() as usize;
            let of = |offset: usize| GridLine {
                offset: offset as isize,
                first: 0,
                last: columns + across * reach,
            };
            return (0..along * height).map(of).collect();
        }
        let (columns, rows) = (columns as isize, rows as isize);
        let of = |offset: isize| GridLine {
            offset,
            first: (-offset).max(0) as usize,
            last: columns.min(rows - offset) as usize,
        };
        (-columns..=rows).map(of).collect()
    }

    /// Follows a line from its end to its start, and sets the horizons of the texels on it.
    fn follow(
        &self,
        line: GridLine,
        [along, across]: [usize; 2],
        hull: &mut Vec<Point>,
        horizons: &mut [f32],
    ) {
        let Size { width, height } = self.size;
        let to_slope = (1.0 / (1.0 / along as f64).hypot(1.0 / across as f64)) as f32;
        let back = |(at, part): (usize, usize), side: usize, parts: usize| match (at, part) {
            (0, 0) => (side - 1, parts - 1),
            (at, 0) => (at - 1, parts - 1),
            (at, part) => (at, part - 1),
        };
        let row_step = line.offset + line.last as isize;
        let mut column = (line.last / across % width, line.last % across);
        let mut row = (row_step as usize / along % height, row_step as usize % along);
        hull.clear();
        for step in (line.first..=line.last).rev() {
            let height_here = match (column.1, row.1) {
                (0, part) => Some(self.below(column.0, row.0, part as f32 / along as f32)),
                (part, 0) => Some(self.beside(column.0, row.0, part as f32 / across as f32)),
                _ => None,
            };
            if let Some(point) = height_here.map(|height| Point { step, height }) {
                let slope = tangent(hull, point);
                if column.1 == 0 && row.1 == 0 && step <= across * (width - 1) {
                    horizons[row.0 * width + column.0] = (slope * to_slope).max(0.0);
                }
                hull.push(point);
            }
            column = back(column, width, across);
            row = back(row, height, along);
        }
    }

    /// The height between a texel and that of the next row.
    fn below(&self, column: usize, row: usize, share: f32) -> f32 {
        self.between([column, row], [column, self.next(row, self.size.height)], share)
    }

    /// The height between a texel and that of the next column.
    fn beside(&self, column: usize, row: usize, share: f32) -> f32 {
        self.between([column, row], [self.next(column, self.size.width), row], share)
    }

    fn between(&self, near: [usize; 2], far: [usize; 2], share: f32) -> f32 {
        let [a, b] = [near, far].map(|[column, row]| self.heights[row * self.size.width + column]);
        a + (b - a) * share
    }

    fn next(&self, at: usize, side: usize) -> usize {
        match at + 1 < side {
            true => at + 1,
            false if self.wraps => 0,
            false => at,
        }
    }
}

/// The slope at which a point sees the hull of all points farther on, which loses those that the point hides.
fn tangent(hull: &mut Vec<Point>, from: Point) -> f32 {
    while let [.., farther, nearest] = hull[..]
        && from.slope(nearest) <= from.slope(farther)
    {
        hull.pop();
    }
    hull.last().map_or(0.0, |seen| from.slope(*seen))
}

#[cfg(test)]
mod tests {
    use super::super::horizon::Surroundings;
    use super::super::march::{Heading, crossings, steepest_slopes};
    use super::*;

    fn relief(size: Size, border: ReliefBorder, height: impl Fn(f32, f32) -> f32) -> Relief {
        let value = |i: usize| height((i % size.width) as f32, (i / size.width) as f32);
        Relief::new(&Planes::from_vec(size, 1, (0..size.texels()).map(value).collect()).unwrap(), border)
    }

    fn bumps(x: f32, y: f32) -> f32 {
        3.0 * (x * 0.61).sin() * (y * 0.37).cos() + ((x * 12.9898 + y * 78.233).sin() * 43758.55).fract()
    }

    #[test]
    fn headings_go_around() {
        let mut all: Vec<f64> = headings().iter().map(|h| h.azimuth_rad().rem_euclid(TAU)).collect();
        all.sort_by(f64::total_cmp);
        assert!(all.windows(2).all(|pair| (0.2..0.3).contains(&(pair[1] - pair[0]))), "{all:?}");
        assert!((headings().iter().map(|h| h.width_rad()).sum::<f64>() - TAU).abs() < 1e-12);
    }

    /// The slow truth marches from each texel by itself.
    #[test]
    fn horizons_of_lines_are_those_of_the_march() {
        let size = Size::new(23, 31);
        for border in [ReliefBorder::Wrap, ReliefBorder::Clamp] {
            // The march goes on beyond a clamped border, where this relief is lower than anywhere inside.
            let is_inside = |at: f32, side: usize| (0.5..side as f32 - 1.5).contains(&at);
            let relief = relief(size, border, |x, y| {
                let is_high = is_inside(x, size.width) && is_inside(y, size.height);
                if border == ReliefBorder::Wrap || is_high { bumps(x, y) } else { -20.0 }
            });
            for heading in headings() {
                let azimuth = heading.azimuth_rad();
                let path = crossings(Heading::from_azimuth(azimuth), (size.width + size.height) as f64);
                let found = horizons(&relief, &heading, &Job::default()).unwrap();
                for y in 0..size.height {
                    let mut truth = vec![0.0; size.width];
                    steepest_slopes(&relief, &path, y, 0.0, &mut truth);
                    for x in 0..size.width {
                        // What is farther than the sides together may be missed by either.
                        let far = relief.range() / (size.width + size.height) as f32;
                        let [slope, truth] = [found[heading.place(x, y, size)], truth[x]].map(|s| s.max(far));
                        let is_same = (slope - truth).abs() < 1e-4 * (1.0 + truth);
                        assert!(is_same, "{border:?} {azimuth}: ({x}, {y}) {slope} {truth}");
                    }
                }
            }
        }
    }

    #[test]
    fn the_sky_is_that_of_many_marched_sectors() {
        let relief = relief(Size::new(40, 33), ReliefBorder::Wrap, |x, y| {
            4.0 * (x * std::f32::consts::TAU / 20.0).sin() * (y * std::f32::consts::TAU / 11.0).cos()
        });
        let normals = relief.normals();
        let truth = Surroundings::new(&relief, &normals, 256, &Job::default()).unwrap().sky;
        let found = open_sky(&relief, &normals, &Job::default()).unwrap();
        for (found, truth) in found.as_slice().iter().zip(&truth) {
            assert!((found - truth).abs() < 0.02, "{found} {truth}");
        }
        let plane = Relief::new(&Planes::zeros(Size::new(1, 3), 1), ReliefBorder::Clamp);
        let flat = open_sky(&plane, &plane.normals(), &Job::default()).unwrap();
        assert!(flat.as_slice().iter().all(|share| (share - 1.0).abs() < 1e-6));
    }
}
