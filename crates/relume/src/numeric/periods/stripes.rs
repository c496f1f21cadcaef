//! Textures that repeat in one direction only.
//!
//! The ridges of the autocorrelation of stripes are parallel to them: their direction is the one along which
//! the correlation changes least, the minor axis of its structure tensor (J. Bigun, G. H. Granlund, Optimal
//! orientation detection of linear symmetry, ICCV 1987). The mean over a stretch of the ridges is a profile
//! across the stripes, in which periods are judged in the same way as lattices.

use super::background::Background;
use super::peaks::vertex;
use crate::numeric::autocorrelation::Autocorrelation;

/// Periods with at least this fraction of the best share are equivalent: the shortest of them is taken.
const NEARLY_BEST: f64 = 0.9;
/// The least number of visible multiples.
const LEAST_MULTIPLES: usize = 3;
/// The number of multiples examined.
const MULTIPLES: usize = 8;
/// The stretch of ridges averaged on either side, as a fraction of the reach.
const STRETCH: f64 = 0.25;

/// The least share in standard deviations that counts as stripes.
const LEAST_DEVIATIONS: f64 = 1.2;

/// The least share of `multiples` mean correlations that counts as stripes. Unrelated textures of large
/// features reach 0.15 with the best of many periods of three or four multiples, and less with more; real fabrics
/// are at 0.6 and above.
fn least_share(multiples: usize) -> f64 {
    0.15 + 0.3 / (multiples as f64).sqrt()
}

/// A period across stripes.
#[derive(Debug, Clone, Copy)]
pub struct StripePeriod {
    /// The period, in texels.
    pub period: [f64; 2],
    /// Its direction.
    pub unit: [f64; 2],
    /// The share of the variance that repeats.
    pub share: f64,
    /// The number of visible multiples.
    multiples: usize,
    /// The share in standard deviations of what the correlation is elsewhere.
    deviations: f64,
}

impl StripePeriod {
    /// Whether the share is more than chance.
    pub fn is_certain(&self, background: &Background) -> bool {
        let share = background.of_smooth(self.share);
        share >= least_share(self.multiples) && self.deviations >= LEAST_DEVIATIONS
    }
}

/// The best period across the stripes, if one can be judged.
pub fn best(correlation: &Autocorrelation, background: &Background) -> Option<StripePeriod> {
    let unit @ [ux, uy] = across(correlation);
    let profile = Profile::new(correlation, unit);
    let judged: Vec<(f64, f64, usize)> = profile
        .peaks()
        .map(|at| (at, profile.share(at), profile.multiples(at).count()))
        .filter(|(.., multiples)| *multiples >= LEAST_MULTIPLES)
        .collect();
    let best = judged.iter().map(|(_, share, _)| *share).fold(f64::NEG_INFINITY, f64::max);
    // Multiples of a period are periods too: the shortest of the good ones.
    let (at, share, multiples) = judged.into_iter().find(|(_, share, _)| *share >= NEARLY_BEST * best)?;
    let length = profile.refined(at);
    let period = [length * ux, length * uy];
    let overlaps = (1..=multiples).map(|k| correlation.overlap(period.map(|c| k as f64 * c)));
    let deviations = share / background.deviation(overlaps.sum());
    Some(StripePeriod { period, unit, share, multiples, deviations })
}

/// The unit vector along which the correlation changes most, pointing right.
fn across(correlation: &Autocorrelation) -> [f64; 2] {
    let (width, height) = (correlation.reach().width as isize, correlation.reach().height as isize);
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for dy in 0..height {
        for dx in 1 - width..width {
            let gx = correlation.at(dx + 1, dy) - correlation.at(dx - 1, dy);
            let gy = correlation.at(dx, dy + 1) - correlation.at(dx, dy - 1);
            xx += gx * gx;
            xy += gx * gy;
            yy += gy * gy;
        }
    }
    let angle: f64 = 0.5 * f64::atan2(2.0 * xy, xx - yy);
    [angle.cos(), angle.sin()]
}

/// The mean correlation along a stretch of the ridges, at whole distances across them.
struct Profile(Vec<f64>);

impl Profile {
    fn new(correlation: &Autocorrelation, [ux, uy]: [f64; 2]) -> Self {
        let reach = correlation.reach();
        let stretch = (STRETCH * reach.width.min(reach.height) as f64).floor() as i32;
        let place = |s: f64, t: f64| [s * ux - t * uy, s * uy + t * ux];
        let seen =
            |s: f64| [-1.0, 1.0].iter().all(|side| correlation.covers(place(s, side * f64::from(stretch))));
        let mean = |s: f64| {
            let along = (-stretch..=stretch).map(|t| correlation.sample(place(s, f64::from(t))));
            along.sum::<f64>() / f64::from(2 * stretch + 1)
        };
        Self((0u32..).map(f64::from).take_while(|&s| seen(s)).map(mean).collect())
    }

    /// The mean at a distance between integers, by linear interpolation; beyond the end, the last one.
    fn sample(&self, s: f64) -> f64 {
        let last = self.0.len() - 1;
        let before = (s.floor() as usize).min(last);
        let t = s - s.floor();
        (1.0 - t) * self.0[before] + t * self.0[(before + 1).min(last)]
    }

    /// The distances of local maxima, to a fraction of a texel, in increasing order.
    fn peaks(&self) -> impl Iterator<Item = f64> + '_ {
        let inner = self.0.windows(3).enumerate();
        inner
            .filter(|(_, w)| w[1] > 0.0 && w[1] >= w[0] && w[1] > w[2])
            .map(|(i, w)| (i + 1) as f64 + vertex([w[0], w[1], w[2]]))
    }

    /// The share of the variance that repeats with a period: the mean at its multiples, m, and that between
    /// them, b, give (m - b) / (1 - b).
    fn share(&self, period: f64) -> f64 {
        let mean =
            |at: &[f64]| at.iter().map(|k| self.sample(k * period)).sum::<f64>() / at.len().max(1) as f64;
        let at: Vec<f64> = self.multiples(period).collect();
        let between: Vec<f64> =
            at.iter().flat_map(|k| [0.25, 0.5, 0.75].map(|t| k - t)).filter(|&t| t > 0.3).collect();
        let background = mean(&between);
        (mean(&at) - background) / (1.0 - background).max(1e-9)
    }

    fn multiples(&self, period: f64) -> impl Iterator<Item = f64> + use<> {
        let last = self.0.len().saturating_sub(1) as f64;
        (1..=MULTIPLES).map(|k| k as f64).take_while(move |k| k * period <= last)
    }

    /// The period fitted to the peaks near its multiples, by least squares.
    fn refined(&self, first: f64) -> f64 {
        let (mut period, mut kp, mut kk) = (first, 0.0, 0.0);
        for k in self.multiples(first) {
            let away = |p: &f64| (p - k * period).abs();
            let near =
                self.peaks().filter(|p| away(p) <= 0.2 * first).min_by(|a, b| away(a).total_cmp(&away(b)));
            if let Some(peak) = near {
                kp += k * peak;
                kk += k * k;
                period = kp / kk;
            }
        }
        period
    }
}
