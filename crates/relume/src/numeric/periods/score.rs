//! The share of the variance that repeats with a lattice, and the evidence for it.
//!
//! With the mean correlation m at the points of a lattice and the mean b over the cells between them, the share
//! is (m - b) / (1 - b): slow changes raise both and cancel, and a purely periodic texture has share 1. Means
//! are weighted by the texels of the overlap, which makes the share the part of the variance explained by
//! the mean of the copies of each place. Points of a lattice that is too dense lower the mean, and a lattice
//! that is too sparse has fewer points: the primitive one is the most certain.

use super::background::Background;
use crate::numeric::autocorrelation::Autocorrelation;
use crate::numeric::lattice::{Lattice, length};

/// Cells are sampled in steps of a quarter of each vector.
const STEPS: u8 = 4;
/// The farthest multiples of the vectors of a basis that are used: the lattice is known to a few hundredths of
/// a texel, and farther points would be missed.
pub const FARTHEST: i32 = 12;
/// The least number of visible lattice points: the two vectors, their sum and their difference.
const LEAST_POINTS: usize = 4;
/// The least number of times that a period fits into the texture, apart from the rounding of its length.
const LEAST_REPEATS: f64 = 1.9;
/// The least drop of the correlation between lattice points along both vectors and their sum, as a fraction of
/// the share, and in deviations. Stripes show it along two of them at most: counted in stripes, one of any two
/// integers and their sum is even, so one of the three half-way positions lies on a stripe.
const LEAST_CONTRAST: (f64, f64) = (0.04, 2.5);
/// The number of deviations by which a share may be too large: shares of few points are lucky.
const CAUTION: f64 = 2.5;

/// A weighted mean correlation.
#[derive(Debug, Clone, Copy, Default)]
pub struct WeightedMean {
    sum: f64,
    /// The sum of the overlaps, in texels.
    pub texels: f64,
    /// The number of shifts.
    pub count: usize,
}

impl WeightedMean {
    /// Adds the correlation at a shift.
    pub fn add(&mut self, correlation: &Autocorrelation, shift: [f64; 2]) {
        let overlap = correlation.overlap(shift);
        self.sum += overlap * correlation.sample(shift);
        self.texels += overlap;
        self.count += 1;
    }

    /// The mean; 0 of nothing.
    pub fn mean(&self) -> f64 {
        if self.texels > 0.0 { self.sum / self.texels } else { 0.0 }
    }
}

/// A lattice with its measurements.
#[derive(Debug, Clone, Copy)]
pub struct Judged {
    /// The lattice.
    pub lattice: Lattice,
    /// The share of the variance that repeats with it.
    pub share: f64,
    /// How often its longer period fits into the texture.
    pub repeats: f64,
    /// The overlaps of its points.
    points: WeightedMean,
    /// The deviation of its share from that of a similar lattice.
    deviation: f64,
    /// The mean drop of the correlation half-way to the next lattice point, along each vector and their sum.
    contrast: [f64; 3],
}

impl Judged {
    /// Measures a lattice.
    pub fn new(correlation: &Autocorrelation, background: &Background, lattice: Lattice) -> Self {
        let sample = |ij: [f64; 2]| correlation.sample(lattice.point(ij));
        let (mut points, mut contrast) = (WeightedMean::default(), [0.0; 3]);
        for [i, j] in visible(correlation, &lattice, FARTHEST) {
            let place = lattice.point([i, j]);
            points.add(correlation, place);
            let (here, weight) = (correlation.sample(place), correlation.overlap(place));
            // Steps point towards the origin, so that they stay within reach.
            let left = if i < 0.0 { -1.0 } else { 1.0 };
            contrast[0] += weight * (here - sample([i - 0.5 * left, j]));
            contrast[1] += weight * (here - sample([i, j - 0.5]));
            contrast[2] += weight * (here - sample([i - 0.5 * left, j - 0.5]));
        }
        let share = share_of(points.mean(), between(correlation, &lattice));
        Self {
            lattice,
            share,
            repeats: repeats(correlation, &lattice),
            points,
            deviation: background.near_deviation(points.texels, reach_of_cell(&lattice)),
            contrast: contrast.map(|c| c / points.texels.max(1.0)),
        }
    }

    /// Whether the correlation is that of a lattice.
    pub fn is_lattice(&self) -> bool {
        let (fraction, deviations) = LEAST_CONTRAST;
        let noise = deviations * self.deviation * (1.0 - self.share).max(0.0);
        let least = (fraction * self.share).max(noise);
        let is_seen = self.points.count >= LEAST_POINTS && self.repeats >= LEAST_REPEATS;
        is_seen && self.share > 0.0 && self.contrast.iter().all(|&fall| fall >= least)
    }

    /// The share that is sure: what does not repeat changes it by chance.
    pub fn sure_share(&self) -> f64 {
        sure(self.share, self.deviation)
    }

    /// The share of what is not grain, times the share in standard deviations.
    pub fn evidence(&self, background: &Background) -> f64 {
        background.of_smooth(self.share) * self.share / background.deviation(self.points.texels)
    }
}

fn sure(share: f64, deviation: f64) -> f64 {
    // Of exact repeats, those of fewer points are less sure as well.
    share - CAUTION * deviation * (1.0 - share).max(0.05)
}

fn share_of(points: f64, between: f64) -> f64 {
    (points - between) / (1.0 - between).max(1e-9)
}

/// The share of the variance that repeats with a lattice; 0 where none of its points is visible.
pub fn share(correlation: &Autocorrelation, lattice: &Lattice) -> f64 {
    let mut points = WeightedMean::default();
    visible(correlation, lattice, FARTHEST).for_each(|ij| points.add(correlation, lattice.point(ij)));
    if points.count == 0 { 0.0 } else { share_of(points.mean(), between(correlation, lattice)) }
}

/// The sure share by the mean at the nearest points alone, which is quick.
pub fn quick_share(
    correlation: &Autocorrelation,
    background: &Background,
    lattice: &Lattice,
    span: i32,
) -> f64 {
    let mut points = WeightedMean::default();
    visible(correlation, lattice, span).for_each(|ij| points.add(correlation, lattice.point(ij)));
    if points.count < LEAST_POINTS {
        return 0.0;
    }
    sure(points.mean(), background.near_deviation(points.texels, reach_of_cell(lattice)))
}

/// The mean correlation between the points of a lattice.
fn between(correlation: &Autocorrelation, lattice: &Lattice) -> f64 {
    let centre = 0.3 * lattice.basis().map(length).into_iter().fold(f64::INFINITY, f64::min);
    let mut mean = WeightedMean::default();
    for [i, j] in visible(correlation, lattice, FARTHEST) {
        let left = if i < 0.0 { -1.0 } else { 1.0 };
        let places = steps().map(|(s, t)| lattice.point([i - s * left, j - t]));
        places.filter(|&place| length(place) > centre).for_each(|place| mean.add(correlation, place));
    }
    mean.mean()
}

/// The visible points of a lattice up to `most` multiples, one of each opposite pair.
pub fn visible(
    correlation: &Autocorrelation,
    lattice: &Lattice,
    most: i32,
) -> impl Iterator<Item = [f64; 2]> {
    let reach = (correlation.reach().width as f64).hypot(correlation.reach().height as f64);
    let shortest = lattice.basis().map(length).into_iter().fold(f64::INFINITY, f64::min);
    // No point of a reduced basis within reach has larger coefficients.
    let most = most.min((1.2 * reach / shortest.max(1.0)).ceil() as i32);
    Lattice::half(most).filter(|&ij| correlation.covers(lattice.point(ij)))
}

/// How often the vectors of a lattice fit into the texture, the least of them.
pub fn repeats(correlation: &Autocorrelation, lattice: &Lattice) -> f64 {
    let (w, h) = (correlation.size().width as f64, correlation.size().height as f64);
    let fits = |v: [f64; 2]| (w / v[0].abs()).min(h / v[1].abs());
    lattice.basis().map(fits).into_iter().fold(f64::INFINITY, f64::min)
}

/// Whether a lattice fits into the texture often enough to be seen.
pub fn is_repeated(correlation: &Autocorrelation, lattice: &Lattice) -> bool {
    repeats(correlation, lattice) >= LEAST_REPEATS
}

/// Half of the longer vector: shifts within it belong to no other point of the lattice. Of an elongated cell it
/// includes neighbours, so that a row of points counts little more than one.
pub fn reach_of_cell(lattice: &Lattice) -> f64 {
    0.5 * lattice.basis().map(length).into_iter().fold(0.0, f64::max)
}

/// The sampled positions of a cell, apart from its corner.
fn steps() -> impl Iterator<Item = (f64, f64)> {
    let step = |k: u8| f64::from(k) / f64::from(STEPS);
    (1..STEPS * STEPS).map(move |k| (step(k % STEPS), step(k / STEPS)))
}
