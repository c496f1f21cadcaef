//! Balls in photographs: circles found by the Hough transform of the lines across edges (P. V. C. Hough, Method and
//! means for recognizing complex patterns, US patent 3069654, 1962; with gradient directions after C. Kimme, D.
//! Ballard, J. Sklansky, Finding circles by an array of accumulators, CACM 18(2), 1975), then fitted to their edge
//! points by reweighted least squares with a tolerance that shrinks.
//!
//! Edges are those of the mean and of the maximum of all photographs, so an outline that only some lamps show counts.
//! Photographs are reduced to at most [`MOST_SIDE`] pixels for it.

use std::f64::consts::SQRT_2;
use std::sync::Mutex;

use super::outline::{EdgePoint, edges};
use super::{MirrorBall, luminance};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::numeric::small::solve_spd;
use crate::parallel;
use crate::raster::LoadRaster;
use crate::size::Size;
use crate::space::Space;

/// The longer side of the reduced photographs.
const MOST_SIDE: usize = 640;
/// The smallest radius in reduced pixels.
const LEAST_RADIUS: usize = 10;
/// Steps of the accumulator in reduced pixels: of centres, and of radii.
const STEP: usize = 4;
const RADIUS_STEP: usize = 2;
/// The most circles that are tried.
const TRIED: usize = 48;
/// The part of the circumference that must be seen.
const LEAST_SEEN: f64 = 0.5;
/// The part that must be seen of an outline around a circle, more than chance gives among all edges of a texture.
const OUTLINE_SEEN: f64 = 0.75;
/// The part of all edges that is searched: the steepest.
const KEPT: f64 = 0.4;
/// Parts of the circumference that are counted.
const SECTORS: usize = 72;
/// Tolerances of the fit, as fractions of the radius.
const TOLERANCES: [f64; 8] = [0.08, 0.06, 0.04, 0.03, 0.02, 0.015, 0.01, 0.01];
/// The cosine of the largest angle between the line across an edge and the radius.
const ALIGNED: f64 = 0.94;
/// Centres nearer to each other than this part of the radius are one.
const CONCENTRIC: f64 = 0.06;
/// What is added to luminances before their logarithm is taken: dark noise does not matter then.
const FLOOR: f64 = 0.02;

/// A circle, and how far it is seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Circle {
    x: f64,
    y: f64,
    radius: f64,
    seen: f64,
}

impl Circle {
    pub fn ball(&self) -> MirrorBall {
        MirrorBall { x: self.x, y: self.y, radius: self.radius }
    }

    /// Whether another circle has the same centre and is larger.
    fn is_ring_of(&self, other: &Self) -> bool {
        let apart = (self.x - other.x).hypot(self.y - other.y);
        apart < CONCENTRIC * other.radius && (self.radius..1.6 * self.radius).contains(&other.radius)
    }

    fn overlaps(&self, other: &Self) -> bool {
        (self.x - other.x).hypot(self.y - other.y) < self.radius.max(other.radius)
    }
}

/// The circles in photographs, from the most to the least visible.
pub(super) fn find(names: &[String], load: &LoadRaster, job: &Job) -> Result<Vec<Circle>> {
    let (stack, size, reduction) = stacked(names, load, job)?;
    let logarithms =
        [&stack.mean, &stack.most].map(|v| v.iter().map(|v| (v + FLOOR).ln()).collect::<Vec<f64>>());
    let steepest =
        |kept| -> Vec<EdgePoint> { logarithms.iter().flat_map(|v| edges(v, size, kept)).collect() };
    let lines = steepest(KEPT);
    job.proceed()?;
    let mut votes = Accumulator::of(&lines, size, job)?;
    let mut found: Vec<Circle> = Vec::new();
    for _ in 0..TRIED {
        let Some(circle) = votes.take_best().map(|start| fitted(start, &lines)) else { break };
        if circle.seen < LEAST_SEEN {
            continue;
        }
        match found.iter_mut().find(|other| other.overlaps(&circle)) {
            // A ball mirrors the ground in a ring along its outline, whose inner edge is a circle as well.
            Some(other) if other.is_ring_of(&circle) => *other = circle,
            Some(_) => {}
            None => found.push(circle),
        }
    }
    let all = steepest(1.0);
    found.iter_mut().for_each(|circle| *circle = outline_around(*circle, &all));
    let scale = reduction as f64;
    let whole = |c: Circle| Circle { x: c.x * scale, y: c.y * scale, radius: c.radius * scale, ..c };
    Ok(found.into_iter().map(whole).collect())
}

/// The outline of the ball whose mirrored horizon a circle is, if there is one: seen from afar, normals at 45 degrees
/// mirror the horizon, in a circle of the radius divided by the square root of 2. It may be fainter than the edges that
/// were searched. A circle without one is returned as it is.
fn outline_around(circle: Circle, lines: &[EdgePoint]) -> Circle {
    let outline = fitted(Circle { radius: SQRT_2 * circle.radius, ..circle }, lines);
    if outline.seen >= OUTLINE_SEEN && circle.is_ring_of(&outline) { outline } else { circle }
}

/// The mean and the maximum of the encoded luminance of all photographs, reduced.
struct Stack {
    mean: Vec<f64>,
    most: Vec<f64>,
}

fn stacked(names: &[String], load: &LoadRaster, job: &Job) -> Result<(Stack, Size, usize)> {
    if names.is_empty() {
        return Err(Error::usage("balls are found in photographs, and there are none"));
    }
    let first = load(0)?;
    let whole = first.size();
    let reduction = whole.width.max(whole.height).div_ceil(MOST_SIDE);
    let size = Size::new(whole.width / reduction, whole.height / reduction);
    if size.width.min(size.height) < 2 * LEAST_RADIUS {
        return Err(Error::invalid(format!("photographs of {whole} pixels are too small to find balls in")));
    }
    let of_threads = rayon::current_num_threads() as u64 * 4 * (first.channels() as u64 + 1);
    drop(first);
    job.check("photographs to look for balls in", whole, of_threads)?;
    job.check("looking for balls", size, BYTES)?;
    job.start("looking for balls", names.len() as u64);
    // Sums of integers, so that they do not depend on the order of the threads.
    let sums = Mutex::new((vec![0u64; size.texels()], vec![0u32; size.texels()]));
    parallel::try_for_each(names.iter().enumerate(), |(i, name)| {
        let photograph = load(i)?;
        if photograph.size() != whole {
            return Err(Error::invalid(format!(
                "the photograph {name} is {} texels and {} is {whole}: all must have the same size",
                photograph.size(),
                names[0]
            )));
        }
        let codes = reduced(luminance(&photograph.to_picture(Space::Srgb).planes).plane(0), whole, reduction);
        let mut sums = sums.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let (sum, most) = &mut *sums;
        for (texel, code) in codes.into_iter().enumerate() {
            sum[texel] += u64::from(code);
            most[texel] = most[texel].max(code);
        }
        job.advance(1)
    })?;
    let (sum, most) = sums.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
    let count = names.len() as f64;
    let stack = Stack {
        mean: sum.into_iter().map(|s| s as f64 / count / CODES).collect(),
        most: most.into_iter().map(|m| f64::from(m) / CODES).collect(),
    };
    Ok((stack, size, reduction))
}

/// For each reduced pixel: the stack and its logarithms, the blur and its differences, and edges in half of them.
const BYTES: u64 = 160;

/// The code of white.
const CODES: f64 = 65535.0;

/// The means of squares of pixels, as codes.
fn reduced(values: &[f32], whole: Size, reduction: usize) -> Vec<u32> {
    let size = Size::new(whole.width / reduction, whole.height / reduction);
    let mean = |texel: usize| {
        let (x, y) = (texel % size.width * reduction, texel / size.width * reduction);
        let rows = (y..y + reduction).flat_map(|y| &values[whole.index(x, y)..][..reduction]);
        let sum: f64 = rows.map(|v| f64::from(v.clamp(0.0, 1.0))).sum();
        (sum / (reduction * reduction) as f64 * CODES).round() as u32
    };
    (0..size.texels()).map(mean).collect()
}

/// The votes for centres and radii.
struct Accumulator {
    columns: usize,
    rows: usize,
    radii: Vec<f64>,
    votes: Vec<f32>,
}

impl Accumulator {
    fn of(lines: &[EdgePoint], size: Size, job: &Job) -> Result<Self> {
        let radii: Vec<f64> =
            (LEAST_RADIUS..=size.width.min(size.height) / 2).step_by(RADIUS_STEP).map(|r| r as f64).collect();
        let (columns, rows) = (size.width / STEP + 1, size.height / STEP + 1);
        job.check_bytes("looking for balls", (8 * columns * rows * radii.len()) as u64)?;
        let mut votes = vec![0.0f32; columns * rows * radii.len()];
        parallel::for_each(votes.chunks_exact_mut(columns * rows).zip(&radii), |(layer, radius)| {
            for line in lines {
                for side in [-1.0, 1.0] {
                    let x = (line.x + side * radius * line.across_x) / STEP as f64;
                    let y = (line.y + side * radius * line.across_y) / STEP as f64;
                    if x >= 0.0 && y >= 0.0 && x < columns as f64 && y < rows as f64 {
                        layer[y as usize * columns + x as usize] += 1.0;
                    }
                }
            }
        });
        let mut accumulator = Self { columns, rows, radii, votes };
        job.proceed()?;
        accumulator.spread();
        Ok(accumulator)
    }

    /// Sums over cubes of three cells, divided by the square root of the radius: chance gives all radii the same
    /// number of votes, and true circles votes in proportion to their radius.
    fn spread(&mut self) {
        let (columns, layer) = (self.columns, self.columns * self.rows);
        for (step, length) in [(1, columns), (columns, self.rows), (layer, self.radii.len())] {
            let at = |cell: usize| {
                let position = cell / step % length;
                let before = if position > 0 { self.votes[cell - step] } else { 0.0 };
                let after = if position + 1 < length { self.votes[cell + step] } else { 0.0 };
                before + self.votes[cell] + after
            };
            self.votes = (0..self.votes.len()).map(at).collect();
        }
        for (votes, radius) in self.votes.chunks_exact_mut(layer).zip(&self.radii) {
            votes.iter_mut().for_each(|v| *v /= radius.sqrt() as f32);
        }
    }

    /// The circle with the most votes, whose neighbourhood is then empty; `None` when there are no more.
    fn take_best(&mut self) -> Option<Circle> {
        let best = (0..self.votes.len())
            .max_by(|a, b| self.votes[*a].total_cmp(&self.votes[*b]).then(b.cmp(a)))
            .filter(|cell| self.votes[*cell] > 0.0)?;
        let layer = self.columns * self.rows;
        let (radius, cell) = (best / layer, best % layer);
        let (column, row) = (cell % self.columns, cell / self.columns);
        // Few radii, so that the outline remains where the ring in it was taken first.
        for k in radius.saturating_sub(2)..(radius + 3).min(self.radii.len()) {
            for y in row.saturating_sub(5)..(row + 6).min(self.rows) {
                for x in column.saturating_sub(5)..(column + 6).min(self.columns) {
                    self.votes[k * layer + y * self.columns + x] = 0.0;
                }
            }
        }
        let middle = |cell: usize| (cell as f64 + 0.5) * STEP as f64;
        Some(Circle { x: middle(column), y: middle(row), radius: self.radii[radius], seen: 0.0 })
    }
}

/// The circle fitted to the edge points near it.
fn fitted(mut circle: Circle, lines: &[EdgePoint]) -> Circle {
    for tolerance in TOLERANCES {
        let reach = 2.0 * (tolerance * circle.radius).max(0.7);
        for _ in 0..3 {
            let Some(better) = step(circle, lines, reach) else { return Circle { seen: 0.0, ..circle } };
            circle = better;
        }
    }
    let reach = (0.01 * circle.radius).max(1.0);
    let mut sectors = [false; SECTORS];
    for (line, off, _) in near(circle, lines, reach) {
        let turn = ((line.y - circle.y).atan2(line.x - circle.x) / std::f64::consts::TAU).rem_euclid(1.0);
        sectors[((turn * SECTORS as f64) as usize).min(SECTORS - 1)] |= off.abs() < reach;
    }
    let seen = sectors.iter().filter(|seen| **seen).count() as f64 / SECTORS as f64;
    Circle { seen, ..circle }
}

/// The edge points near a circle that run along it, how far outside they are, and their weight (J. W. Tukey's
/// biweight).
fn near(circle: Circle, lines: &[EdgePoint], reach: f64) -> impl Iterator<Item = (&EdgePoint, f64, f64)> {
    lines.iter().filter_map(move |line| {
        let (x, y) = (line.x - circle.x, line.y - circle.y);
        let distance = x.hypot(y);
        let off = distance - circle.radius;
        let aligned = (x * line.across_x + y * line.across_y).abs() > ALIGNED * distance;
        (off.abs() < reach && aligned).then(|| (line, off, (1.0 - (off / reach).powi(2)).powi(2)))
    })
}

/// One step of the algebraic fit x^2 + y^2 = 2 a x + 2 b y + c, in radii from the centre so far.
fn step(circle: Circle, lines: &[EdgePoint], reach: f64) -> Option<Circle> {
    let (mut matrix, mut right, mut count) = ([[0.0; 3]; 3], [0.0; 3], 0);
    for (line, _, weight) in near(circle, lines, reach) {
        let (x, y) = ((line.x - circle.x) / circle.radius, (line.y - circle.y) / circle.radius);
        let row = [2.0 * x, 2.0 * y, 1.0];
        for i in 0..3 {
            right[i] += weight * row[i] * (x * x + y * y);
            (0..3).for_each(|j| matrix[i][j] += weight * row[i] * row[j]);
        }
        count += 1;
    }
    if count < 12 {
        return None;
    }
    let [a, b, c] = solve_spd(&matrix, &right)?;
    let radius = (c + a * a + b * b).sqrt() * circle.radius;
    (radius.is_finite() && radius > 1.0).then_some(Circle {
        x: circle.x + a * circle.radius,
        y: circle.y + b * circle.radius,
        radius,
        ..circle
    })
}
