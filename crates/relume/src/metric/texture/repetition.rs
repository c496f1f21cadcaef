//! Repetition: the share of a texture that recurs nearby.
//!
//! Windows at random places are searched for in their surroundings. One recurs if its mean squared difference
//! to another place, at least half a window away, is below a small fraction of what independent windows of its
//! contrast would have. Unlike an autocorrelation, which averages over the texture, this shows a single block
//! laid several times in a row. A regular texture recurs by nature: it is the excess over the reference that
//! counts.

use crate::numeric::random::{Purpose, Stream};
use crate::parallel;
use crate::planes::Planes;
use crate::size::Size;

/// The side of the windows in texels.
const WINDOW: usize = 16;
/// The number of windows.
const WINDOWS: usize = 512;
/// Mean squared differences below this fraction of twice the variance of a window are recurrences.
const ALIKE: f64 = 0.05;
/// Steps between the texels of a window that are compared first.
const SPARSE: usize = 5;
/// Windows of less than this fraction of the median variance have nothing to recognise.
const PLAIN: f64 = 0.25;

/// The windows of a texture that recur.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Repetition {
    /// Their share, 0 to 1; 0 for textures with a side of less than two windows.
    pub(super) share: f64,
    /// Its standard error, since only some windows are examined.
    error: f64,
}

impl Repetition {
    /// Those that recur within `reach` texels along x and y.
    pub(super) fn new(planes: &Planes, reach: usize, seed: u64) -> Self {
        let size = planes.size();
        if size.width.min(size.height) < 2 * WINDOW {
            return Self { share: 0.0, error: 0.0 };
        }
        let windows = windows(planes, seed);
        let count = windows.len().max(1) as f64;
        let recur = parallel::map(windows.iter(), |window| window.recurs(planes, reach));
        let share = recur.into_iter().filter(|recurs| *recurs).count() as f64 / count;
        Self { share, error: (share * (1.0 - share) / count).sqrt() }
    }

    /// How much larger the share of another texture is, as far as it exceeds what is not looked at, `least`, and the chance
    /// of the windows.
    pub(super) fn excess(&self, other: &Self, least: f64) -> f64 {
        let chance = self.error.hypot(other.error);
        (other.share - self.share).max(0.0) * least / least.hypot(chance)
    }
}

/// A window by its left column and top row, and its variance over all planes.
#[derive(Debug, Clone, Copy)]
struct ProbedWindow {
    x: usize,
    y: usize,
    variance: f64,
}

/// Random windows, the plainest of them left out.
fn windows(planes: &Planes, seed: u64) -> Vec<ProbedWindow> {
    let Size { width, height } = planes.size();
    let mut random = Stream::new(seed, Purpose::MeasuredWindows, []);
    let mut place = || (random.below(width - WINDOW + 1), random.below(height - WINDOW + 1));
    let all: Vec<ProbedWindow> =
        (0..2 * WINDOWS).map(|_| place()).map(|(x, y)| ProbedWindow::new(planes, x, y)).collect();
    let mut variances: Vec<f64> = all.iter().map(|window| window.variance).collect();
    variances.sort_unstable_by(f64::total_cmp);
    let least = PLAIN * variances[WINDOWS];
    all.into_iter().filter(|window| window.variance > least).take(WINDOWS).collect()
}

impl ProbedWindow {
    fn new(planes: &Planes, x: usize, y: usize) -> Self {
        let size = planes.size();
        let count = (WINDOW * WINDOW) as f64;
        let variance = planes.iter().map(|plane| {
            let rows = || (y..y + WINDOW).flat_map(|row| &plane[size.index(x, row)..][..WINDOW]);
            let mean = rows().map(|&v| f64::from(v)).sum::<f64>() / count;
            rows().map(|&v| (f64::from(v) - mean).powi(2)).sum::<f64>() / count
        });
        Self { x, y, variance: variance.sum() }
    }

    fn recurs(&self, planes: &Planes, reach: usize) -> bool {
        let Size { width, height } = planes.size();
        let range = |at: usize, side: usize| at.saturating_sub(reach)..=(at + reach).min(side - WINDOW);
        let columns = range(self.x, width);
        let (limit, mut sums) = (self.limit(SPARSE), vec![0.0f32; columns.clone().count()]);
        range(self.y, height).any(|y| {
            self.first_row(planes, (*columns.start(), y), &mut sums);
            columns.clone().zip(&sums).any(|(x, &sum)| {
                let apart = self.x.abs_diff(x).max(self.y.abs_diff(y));
                sum <= limit
                    && apart >= WINDOW / 2
                    && self.is_like(planes, (x, y), SPARSE)
                    && self.is_like(planes, (x, y), 1)
            })
        })
    }

    /// The squared differences of every [`SPARSE`]-th texel of the first row, side by side for the places from (x, y) to the
    /// right: most places are too far by them alone.
    fn first_row(&self, planes: &Planes, (x, y): (usize, usize), sums: &mut [f32]) {
        let size = planes.size();
        sums.fill(0.0);
        for (plane, column) in
            planes.iter().flat_map(|plane| (0..WINDOW).step_by(SPARSE).map(move |c| (plane, c)))
        {
            let here = plane[size.index(self.x + column, self.y)];
            let there = &plane[size.index(x + column, y)..][..sums.len()];
            sums.iter_mut().zip(there).for_each(|(sum, value)| *sum += (here - value).powi(2));
        }
    }

    /// The sum of the squared differences of texels at every `step`-th column and row up to which windows are alike.
    fn limit(&self, step: usize) -> f32 {
        let count = WINDOW.div_ceil(step).pow(2) as f64;
        // A few texels may differ by chance more than the whole window does.
        let slack = if step > 1 { 4.0 } else { 1.0 };
        (slack * ALIKE * 2.0 * self.variance * count) as f32
    }

    /// Whether the texels at every `step`-th column and row are those of another place, nearly.
    fn is_like(&self, planes: &Planes, (x, y): (usize, usize), step: usize) -> bool {
        let size = planes.size();
        let limit = self.limit(step);
        let mut sum = 0.0;
        for row in (0..WINDOW).step_by(step) {
            for plane in planes.iter() {
                let here = &plane[size.index(self.x, self.y + row)..][..WINDOW];
                let there = &plane[size.index(x, y + row)..][..WINDOW];
                for column in (0..WINDOW).step_by(step) {
                    sum += (here[column] - there[column]).powi(2);
                }
                if sum > limit {
                    return false;
                }
            }
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(size: Size, seed: u64) -> Planes {
        let mut random = Stream::new(seed, Purpose::Sample, [0]);
        Planes::from_vec(size, 1, (0..size.texels()).map(|_| random.unit() as f32).collect()).unwrap()
    }

    fn share(planes: &Planes, reach: usize, seed: u64) -> f64 {
        Repetition::new(planes, reach, seed).share
    }

    /// A former fault: a part of a facade, whose panes are alike, repeated more than the facade by the chance of a few windows.
    #[test]
    fn shares_that_differ_by_chance_are_alike_and_others_keep_their_difference() {
        let shares =
            |share: f64| Repetition { share, error: (share * (1.0 - share) / WINDOWS as f64).sqrt() };
        let excess = |a: f64, b: f64| shares(a).excess(&shares(b), 0.025) / 0.025;
        assert!(excess(0.6, 0.63) < 1.0 && excess(0.6, 0.5) == 0.0, "{}", excess(0.6, 0.63));
        assert!((excess(0.0, 0.05) - 2.0).abs() < 0.4 && excess(0.5, 1.0) > 8.0, "{}", excess(0.0, 0.05));
    }

    #[test]
    fn noise_does_not_recur_and_tiles_do_within_reach() {
        let planes = noise(Size::new(96, 80), 1);
        assert_eq!(share(&planes, 40, 0), 0.0);
        let tiled = noise(Size::new(24, 20), 2).repeated(4, 4);
        assert_eq!(share(&tiled, 24, 0), 1.0);
        assert_eq!(share(&tiled, 19, 0), 0.0);
    }

    #[test]
    fn a_block_laid_twice_in_a_row_is_its_share() {
        let mut planes = noise(Size::new(128, 128), 3);
        let copy: Vec<f32> = planes.as_slice().to_vec();
        for y in 0..64 {
            for x in 32..64 {
                planes.as_mut_slice()[y * 128 + x] = copy[y * 128 + x - 32];
            }
        }
        // Windows within the two blocks of 32 x 64: 2 x 17 x 49 of 113 x 113 places.
        let found = share(&planes, 40, 0);
        assert!((found - 0.13).abs() < 0.06, "{found}");
    }

    #[test]
    fn small_and_flat_textures_do_not_recur() {
        assert_eq!(share(&noise(Size::new(31, 200), 4), 40, 0), 0.0);
        assert_eq!(share(&Planes::zeros(Size::new(64, 64), 3), 40, 0), 0.0);
    }
}
