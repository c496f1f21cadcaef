//! Textures that repeat in one direction only.
//!
//! The ridges of the autocorrelation of stripes are parallel to them: their direction is the one along which
//! the correlation changes least, the minor axis of its structure tensor (J. Bigun, G. H. Granlund, Optimal
//! orientation detection of linear symmetry, ICCV 1987). The mean over a stretch of the ridges is a profile
//! across the stripes, in which periods are judged in the same way as lattices.

use super::NEARLY_BEST;
use super::peaks::vertex;
use super::share::Tally;
use crate::numeric::autocorrelation::Autocorrelation;

/// The least number of visible multiples.
const LEAST_MULTIPLES: usize = 3;
/// The number of multiples examined.
const MULTIPLES: usize = 8;
/// The stretch of ridges averaged on either side, as a fraction of the reach.
const STRETCH: f64 = 0.25;

/// A period across stripes.
#[derive(Debug, Clone, Copy)]
pub struct StripePeriod {
    pub period: [f64; 2],
    pub share: f64,
    pub points: usize,
}

/// The best period across the stripes, if one can be judged.
pub fn best(correlation: &Autocorrelation) -> Option<StripePeriod> {
    let [ux, uy] = across(correlation);
    let profile = Profile::new(correlation, [ux, uy]);
    let judged: Vec<(f64, f64, usize)> = profile
        .peaks()
        .map(|at| (at, profile.judge(at)))
        .filter(|(_, t)| t.points() >= LEAST_MULTIPLES)
        .map(|(at, tally)| (at, tally.share(), tally.points()))
        .collect();
    let best = judged.iter().map(|(_, share, _)| *share).fold(f64::NEG_INFINITY, f64::max);
    // Multiples of a period are periods too: the shortest of the good ones.
    let (at, share, points) = judged.into_iter().find(|(_, share, _)| *share >= NEARLY_BEST * best)?;
    let length = profile.refined(at);
    Some(StripePeriod { period: [length * ux, length * uy], share, points })
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

    fn judge(&self, period: f64) -> Tally {
        let mut tally = Tally::default();
        for k in self.multiples(period) {
            tally.add_point(self.sample(k * period));
            let between = [0.25, 0.5, 0.75].map(|t| k - t).into_iter().filter(|&t| t > 0.3);
            between.for_each(|t| tally.add_between(self.sample(t * period)));
        }
        tally
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
