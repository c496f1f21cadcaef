//! Local maxima of the autocorrelation.

use crate::numeric::autocorrelation::Autocorrelation;

/// Candidates kept for their multiples and for their regions: the number of pairs grows with the square.
const FOLLOWED: usize = 40;
const DOMINANT: usize = 24;
/// The highest peaks, whose regions are compared.
const HIGHEST: usize = 400;
/// Candidates at most this far apart, in texels, are one.
const SAME: f64 = 0.7;
/// Multiples of a candidate examined to rank it.
const MULTIPLES: i32 = 8;
/// The distance in texels from the predicted position of a multiple within which its peak is searched.
const NEAR: f64 = 1.0;

/// A local maximum.
#[derive(Debug, Clone, Copy)]
pub struct Peak {
    /// Its shift, to a fraction of a texel.
    pub shift: [f64; 2],
    /// The correlation at the nearest whole texel.
    pub height: f64,
}

/// The peaks that are most likely periods: those whose multiples are peaks as well, best first, then those that
/// dominate the largest regions.
pub fn candidates(correlation: &Autocorrelation) -> Vec<[f64; 2]> {
    let peaks = all(correlation);
    let mut ranked: Vec<([f64; 2], f64)> =
        peaks.iter().map(|peak| followed(correlation, peak.shift)).collect();
    ranked.sort_by(|a, b| b.1.total_cmp(&a.1));
    let mut found: Vec<[f64; 2]> = ranked.into_iter().take(FOLLOWED).map(|(shift, _)| shift).collect();
    for shift in dominant(correlation, peaks) {
        if found.iter().all(|other| distance(*other, shift) > SAME) {
            found.push(shift);
        }
    }
    found
}

/// The peaks farthest from any higher one. Heights are in deviations of unrelated texels: those of small
/// overlaps are less certain.
fn dominant(correlation: &Autocorrelation, mut peaks: Vec<Peak>) -> Vec<[f64; 2]> {
    let height = |peak: &Peak| peak.height * correlation.overlap(peak.shift).sqrt();
    peaks.sort_by(|a, b| height(b).total_cmp(&height(a)));
    peaks.truncate(HIGHEST);
    let region = |n: usize| {
        let here = peaks[n].shift;
        let higher = peaks[..n].iter().flat_map(|peak| [peak.shift, peak.shift.map(|c| -c)]);
        higher.chain([[0.0; 2]]).map(|there| distance(here, there)).fold(f64::INFINITY, f64::min)
    };
    let mut ranked: Vec<([f64; 2], f64)> = (0..peaks.len()).map(|n| (peaks[n].shift, region(n))).collect();
    ranked.sort_by(|a, b| b.1.total_cmp(&a.1));
    ranked.into_iter().take(DOMINANT).map(|(shift, _)| shift).collect()
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// A candidate refined by the peaks at its multiples, and its rank: multiples of a period are peaks and lie
/// between valleys, so it is the mean rise from half-way to each multiple, times the root of the number of
/// multiples, because means of more values are more certain. The position of a peak is known to one or
/// two tenths of a texel; each multiple divides that error.
fn followed(correlation: &Autocorrelation, first: [f64; 2]) -> ([f64; 2], f64) {
    let (mut shift, mut rise, mut count) = (first, 0.0, 0);
    for k in (1..=MULTIPLES).map(f64::from) {
        let place = |k: f64| shift.map(|c| k * c);
        if !correlation.covers(place(k)) {
            break;
        }
        rise += correlation.sample(place(k)) - correlation.sample(place(k - 0.5));
        count += 1;
        if let Some(peak) = near(correlation, place(k), NEAR) {
            shift = peak.shift.map(|c| c / k);
        }
    }
    (shift, rise / f64::from(count.max(1)).sqrt())
}

/// All positive local maxima within reach, one of each opposite pair.
fn all(correlation: &Autocorrelation) -> Vec<Peak> {
    let (across, down) = (correlation.reach().width as isize, correlation.reach().height as isize);
    let inside = (0..down).flat_map(|dy| (1 - across..across).map(move |dx| (dx, dy)));
    let half = inside.filter(|&(dx, dy)| dy > 0 || dx > 0);
    half.filter(|&(dx, dy)| is_peak(correlation, dx, dy))
        .map(|(dx, dy)| refined(correlation, dx, dy))
        .filter(|peak| correlation.covers(peak.shift))
        .collect()
}

fn is_peak(correlation: &Autocorrelation, dx: isize, dy: isize) -> bool {
    let here = correlation.at(dx, dy);
    let mut around = (-1..=1).flat_map(|j| (-1..=1).map(move |i| (i, j)));
    here > 0.0 && around.all(|(i, j)| correlation.at(dx + i, dy + j) <= here)
}

/// The vertex of the parabolas through a maximum and its neighbours, along x and along y.
fn refined(correlation: &Autocorrelation, dx: isize, dy: isize) -> Peak {
    let at = |i: isize, j: isize| correlation.at(dx + i, dy + j);
    let height = at(0, 0);
    let shift = [
        dx as f64 + vertex([at(-1, 0), height, at(1, 0)]),
        dy as f64 + vertex([at(0, -1), height, at(0, 1)]),
    ];
    Peak { shift, height }
}

/// The position of the maximum of the parabola through three values at -1, 0 and 1, within half a step.
pub fn vertex([before, here, after]: [f64; 3]) -> f64 {
    let bend = before - 2.0 * here + after;
    if bend < 0.0 { (0.5 * (before - after) / bend).clamp(-0.5, 0.5) } else { 0.0 }
}

/// The peak reached by climbing from a position, if it is at most `within` texels away.
pub fn near(correlation: &Autocorrelation, place: [f64; 2], within: f64) -> Option<Peak> {
    let inside = |x: isize, y: isize| {
        correlation.covers([x.unsigned_abs() as f64 + 1.0, y.unsigned_abs() as f64 + 1.0])
    };
    let (mut x, mut y) = (place[0].round() as isize, place[1].round() as isize);
    for _ in 0..=within.ceil() as usize {
        if !inside(x, y) {
            return None;
        }
        if is_peak(correlation, x, y) {
            let peak = refined(correlation, x, y);
            let away = (peak.shift[0] - place[0]).hypot(peak.shift[1] - place[1]);
            return (away <= within).then_some(peak);
        }
        let around = (-1..=1).flat_map(|j| (-1..=1).map(move |i| (x + i, y + j)));
        let higher = |a: &(isize, isize), b: &(isize, isize)| {
            correlation.at(a.0, a.1).total_cmp(&correlation.at(b.0, b.1))
        };
        (x, y) = around.max_by(higher)?;
    }
    None
}
