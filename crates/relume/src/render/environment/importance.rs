//! Directions drawn in proportion to the light that comes from them.
//!
//! The chance of a texel is its luminance times its solid angle: a row is drawn by the sums of the rows, a column by the
//! sums within the row, and a direction uniformly within the texel (M. Pharr, W. Jakob, G. Humphreys, Physically Based
//! Rendering, 3rd edition, 2016, section 14.2.4). The samples of a point are stratified: they divide the rows evenly,
//! jittered, and the columns by the radical inverse (Hammersley), shifted by a random number for each point (R.
//! Cranley, T. N. L. Patterson, Randomization of Number Theoretic Methods for Multiple Integration, 1976).

use std::f64::consts::PI;

use super::{Environment, luminance, row_cosine};
use crate::error::Result;
use crate::job::{Held, Job};
use crate::memory;
use crate::numeric::random::{Purpose, Stream};
use crate::size::Size;

use super::super::vector::Vec3;

/// The sums by which directions are drawn.
#[derive(Debug)]
pub struct ImportanceTable {
    environment: Environment,
    /// The sum of the rows before each, and of all.
    rows: Vec<f64>,
    /// For each row, the sum of its columns up to and with each, as fractions.
    columns: Vec<f32>,
    _held: Held,
}

/// The samples of a point: their number, a seed, and the place of the point.
#[derive(Debug, Clone, Copy)]
pub struct PlacedSamples {
    pub samples: usize,
    pub seed: u64,
    pub place: [u64; 2],
}

impl ImportanceTable {
    pub fn new(environment: &Environment, job: &Job) -> Result<Self> {
        let Size { width, height } = environment.size();
        let held = job.hold("the table of the environment map", 4 * environment.size().texels() as u64)?;
        let mut columns: Vec<f32> =
            memory::with_capacity("the table of the environment map", width * height)?;
        let mut rows = vec![0.0];
        for y in 0..height {
            let solid_angle = row_cosine(y, height) - row_cosine(y + 1, height);
            let mut sum = 0.0;
            let sums: Vec<f64> = (0..width)
                .map(|x| {
                    sum += luminance(environment.texel(x, y));
                    sum
                })
                .collect();
            columns.extend(sums.iter().map(|s| if sum > 0.0 { (s / sum) as f32 } else { 0.0 }));
            rows.push(rows[y] + sum * solid_angle);
        }
        Ok(Self { environment: environment.clone(), rows, columns, _held: held })
    }

    /// Gives `take` the directions of a point, and their radiance divided by pi, by the density of the choice, and by
    /// the number of samples: the colours of lights that add up to the environment.
    pub fn for_each(&self, point: PlacedSamples, mut take: impl FnMut(Vec3, [f64; 3])) {
        let total = self.rows[self.rows.len() - 1];
        if total <= 0.0 {
            return;
        }
        let mut stream = Stream::new(point.seed, Purpose::EnvironmentSamples, point.place);
        let shift = stream.unit();
        let count = point.samples as f64;
        for i in 0..point.samples {
            let along = total * ((i as f64 + stream.unit()) / count);
            let across = (radical_inverse(i as u32) + shift).fract();
            if let Some((direction, light)) = self.drawn(along, across) {
                take(direction, light.map(|v| v / (PI * count)));
            }
        }
    }

    /// The direction at a fraction of the sums, and its radiance over its density.
    fn drawn(&self, along: f64, across: f64) -> Option<(Vec3, [f64; 3])> {
        let Size { width, height } = self.environment.size();
        let y = self.rows.partition_point(|&sum| sum <= along).checked_sub(1)?.min(height - 1);
        let row = &self.columns[y * width..][..width];
        let x = row.partition_point(|&sum| f64::from(sum) <= across).min(width - 1);
        let before = if x == 0 { 0.0 } else { f64::from(row[x - 1]) };
        let share = f64::from(row[x]) - before;
        let row_share = self.rows[y + 1] - self.rows[y];
        if share <= 0.0 || row_share <= 0.0 {
            return None;
        }
        let part = |place: f64, low: f64, length: f64| ((place - low) / length).clamp(0.0, 1.0);
        let (top, bottom) = (row_cosine(y, height), row_cosine(y + 1, height));
        let cosine = top + (bottom - top) * part(along, self.rows[y], row_share);
        let u = (x as f64 + part(across, before, share)) / width as f64;
        let chance = share * row_share / self.rows[height];
        let solid_angle = 2.0 * PI * (top - bottom) / width as f64;
        let light = self.environment.texel(x, y).map(|v| v * solid_angle / chance);
        Some((self.environment.direction(u, cosine), light))
    }
}

/// The bits of i in reverse order behind the binary point.
fn radical_inverse(i: u32) -> f64 {
    f64::from(i.reverse_bits()) / (1u64 << 32) as f64
}
