//! Local maxima of the autocorrelation.

use crate::numeric::autocorrelation::Autocorrelation;

/// Candidates kept: the number of pairs grows with the square.
const CANDIDATES: usize = 48;
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

/// The peaks that are most likely periods, best first. Multiples of a period are peaks and lie between
/// valleys: candidates are ranked by the mean rise from half-way to each multiple, times the root of the
/// number of multiples, because means of more values are more certain.
pub fn candidates(correlation: &Autocorrelation) -> Vec<[f64; 2]> {
    let mut ranked: Vec<([f64; 2], f64)> =
        all(correlation).into_iter().map(|peak| followed(correlation, peak.shift)).collect();
    ranked.sort_by(|a, b| b.1.total_cmp(&a.1));
    ranked.into_iter().take(CANDIDATES).map(|(shift, _)| shift).collect()
}

/// A candidate refined by the peaks at its multiples, and its rank. The position of a peak is known to one or
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
