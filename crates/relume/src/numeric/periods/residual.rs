//! What stripes leave of an autocorrelation.
//!
//! Courses of bricks are stripes and more than stripes: the joints within the courses repeat as well. The mean
//! correlation along the ridges of stripes is what a texture without anything else would have; what is left
//! is the correlation of the rest, in which a lattice must be found on its own. Noise along the stripes, or a
//! slow bend, leave no lattice.

use super::background::Background;
use super::pairs;
use super::score::{FARTHEST, Judged, WeightedMean, visible};
use crate::numeric::autocorrelation::Autocorrelation;
use crate::numeric::lattice::Lattice;

/// Places of a profile for each texel.
const FINE: f64 = 2.0;
/// Steps of the search for the direction of the ridges, in degrees, and the number of steps to either side.
const TURNS: [(f64, i32); 3] = [(0.6, 5), (0.1, 6), (0.02, 5)];
/// Distances along ridges that differ by at most this, in texels, are the same.
const SAME_DISTANCE: f64 = 1.5;
/// The least share of what is not grain that a lattice must explain beside stripes: less is left of
/// stripes by the limits of interpolation.
const LEAST_REST: f64 = 0.1;
/// The evidence along the ridges from which such a lattice is certain. Of 204 pictures of stripes, straight ones and
/// bent ones, all but one of 3.4 stayed below 2.82; that of knitted wool is 2.9.
const CERTAIN_ALONG: f64 = 2.9;
/// A denser lattice has at least this fraction of the share of another where its further points are periods too:
/// with half of them it has half the share.
const NO_DENSER: f64 = 2.0 / 3.0;

/// The certain lattice beside stripes across the unit vector, if there is one: that of what they leave, or the
/// suggested one where it is denser and repeats there as well.
pub fn lattice(
    correlation: &Autocorrelation,
    plain: &Background,
    unit: [f64; 2],
    suggested: Option<Judged>,
) -> Option<Judged> {
    let ridges = Ridges::new(correlation, straightened(correlation, unit));
    let left = 1.0 - ridges.at(0.0);
    if plain.of_smooth(left) < LEAST_REST {
        return None;
    }
    let rest = correlation
        .mapped(|shift, value| ((value - ridges.at(ridges.across(shift))) / left).clamp(-1.0, 1.0));
    let background = Background::new(&rest);
    let is_certain = |found: &Judged| {
        plain.of_smooth(left * found.share) >= LEAST_REST
            && evidence_along(&rest, &background, &found.lattice, ridges.unit) >= CERTAIN_ALONG
    };
    let suggested = suggested.map(|found| Judged::new(&rest, &background, found.lattice));
    let suggested = suggested.filter(Judged::is_lattice);
    let found = pairs::best(&rest, &background).filter(is_certain);
    let Some(found) = found else { return suggested.filter(is_certain) };
    let is_denser = |other: &Judged| {
        other.share >= NO_DENSER * found.share && other.lattice.cell_area() < found.lattice.cell_area()
    };
    Some(suggested.filter(is_denser).unwrap_or(found))
}

/// The evidence for a lattice by its distances along the ridges. The correlation across ridges is no evidence: a
/// bend of all stripes in common repeats from stripe to stripe. So points at the same distance along the ridges
/// count as one, and those on the line across them through the origin not at all.
fn evidence_along(
    rest: &Autocorrelation,
    background: &Background,
    lattice: &Lattice,
    [ux, uy]: [f64; 2],
) -> f64 {
    let along = |place: [f64; 2]| (place[0] * uy - place[1] * ux).abs();
    let places = visible(rest, lattice, FARTHEST).map(|ij| lattice.point(ij));
    let mut places: Vec<[f64; 2]> = places.filter(|&place| along(place) > SAME_DISTANCE).collect();
    places.sort_by(|a, b| along(*a).total_cmp(&along(*b)));
    let (mut sum, mut texels) = (0.0, 0.0);
    for group in places.chunk_by(|a, b| along(*b) - along(*a) <= SAME_DISTANCE) {
        let mut mean = WeightedMean::default();
        group.iter().for_each(|&place| mean.add(rest, place));
        let overlap = group.iter().map(|&place| rest.overlap(place)).fold(0.0, f64::max);
        sum += overlap * mean.mean();
        texels += overlap;
    }
    let share = sum / f64::max(texels, 1.0);
    background.of_smooth(share) * share / background.deviation(texels)
}

/// The unit vector near one whose ridges are the straightest: their profile has the largest energy.
fn straightened(correlation: &Autocorrelation, unit: [f64; 2]) -> [f64; 2] {
    let mut best = unit;
    for (step_deg, count) in TURNS {
        let turned = |k: i32| {
            let (s, c) = (step_deg * f64::from(k)).to_radians().sin_cos();
            [c * best[0] - s * best[1], s * best[0] + c * best[1]]
        };
        let energies = (-count..=count).map(|k| (Ridges::new(correlation, turned(k)).energy(), k));
        let turn = energies.max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.abs().cmp(&a.1.abs())));
        best = turned(turn.map_or(0, |(_, k)| k));
    }
    best
}

/// The mean correlation along ridges, at distances across them.
struct Ridges {
    unit: [f64; 2],
    sums: Vec<f64>,
    weights: Vec<f64>,
}

impl Ridges {
    fn new(correlation: &Autocorrelation, unit: [f64; 2]) -> Self {
        let (across, down) = (correlation.reach().width as isize, correlation.reach().height as isize);
        let longest = (across as f64).hypot(down as f64);
        let places = (FINE * longest) as usize + 3;
        let mut ridges = Self { unit, sums: vec![0.0; places], weights: vec![0.0; places] };
        for (dx, dy) in (0..=down).flat_map(|dy| (-across..=across).map(move |dx| (dx, dy))) {
            let shift = [dx as f64, dy as f64];
            let (at, overlap) = (FINE * ridges.across(shift), correlation.overlap(shift));
            let (place, after) = (at as usize, at.fract());
            for (k, part) in [(place, 1.0 - after), (place + 1, after)] {
                ridges.sums[k] += part * overlap * correlation.at(dx, dy);
                ridges.weights[k] += part * overlap;
            }
        }
        ridges
    }

    /// The distance of a shift across the ridges.
    fn across(&self, shift: [f64; 2]) -> f64 {
        (shift[0] * self.unit[0] + shift[1] * self.unit[1]).abs()
    }

    fn mean(&self, place: usize) -> f64 {
        if self.weights[place] > 0.0 { self.sums[place] / self.weights[place] } else { 0.0 }
    }

    /// The mean at a distance, by linear interpolation.
    fn at(&self, distance: f64) -> f64 {
        let (place, after) = ((FINE * distance) as usize, (FINE * distance).fract());
        (1.0 - after) * self.mean(place) + after * self.mean(place + 1)
    }

    fn energy(&self) -> f64 {
        (0..self.sums.len()).map(|place| self.weights[place] * self.mean(place).powi(2)).sum()
    }
}
