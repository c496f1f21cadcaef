//! Oblique cells: steps that are vectors of an oblique lattice, to half a texel.
//!
//! Both sides of a rectangle must be whole periods along the axes, and an oblique lattice has few vectors
//! near them; the steps of an oblique cell may be any two. Of all vectors of the lattice that deviate from an
//! axis by at most a third of their length, those least changed by rounding to texels are measured. Of all
//! pairs of them for which the exemplar has room, those are tried under whose shifts the exemplar differs
//! least from itself.

use super::profile::{Axis, squared_step};
use super::region::overlapping;
use crate::numeric::cells::Cells;
use crate::numeric::lattice::{Lattice, length};
use crate::parallel;
use crate::synthesis::quantise::IndexTexels;

/// The number of vectors measured along each axis, and of pairs tried.
pub const SHORTLIST: usize = 18;

/// The largest deviation of a step from its axis, as a fraction of its length: the bounding rectangle of a
/// cell is then at most twice as large.
const MOST_OBLIQUE: f64 = 1.0 / 3.0;

/// The distance of the steps of cells from the nearest vectors of a lattice, the larger one, in texels.
pub fn misfit(cells: &Cells, lattice: &Lattice) -> f64 {
    let away = |step: [i64; 2]| rounding(step, lattice.nearest(step.map(|c| c as f64)));
    away(cells.right()).max(away(cells.down()))
}

/// The pairs of steps worth trying, best first. `lengths` are the least and the longest side along x and y;
/// `fits` tells for which cells there is room.
pub fn pairs(
    texels: &IndexTexels,
    lattice: &Lattice,
    lengths: [(usize, usize); 2],
    fits: impl Fn(&Cells) -> bool,
) -> Vec<Cells> {
    let measured = |axis: Axis, lengths| -> Vec<([i64; 2], f64)> {
        let steps = steps(lattice, axis, lengths);
        parallel::map(steps, |step| (step, difference(texels, step)))
    };
    let (right, down) = (measured(Axis::X, lengths[0]), measured(Axis::Y, lengths[1]));
    let mut pairs: Vec<(f64, Cells)> = right
        .iter()
        .flat_map(|(u, a)| down.iter().filter_map(move |(v, b)| Some((a + b, Cells::new(*u, *v)?))))
        .filter(|(_, cells)| fits(cells))
        .collect();
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.texels().cmp(&a.1.texels())));
    pairs.into_iter().map(|(_, cells)| cells).take(SHORTLIST).collect()
}

/// The vectors of a lattice along an axis, rounded to texels, with the smallest rounding.
fn steps(lattice: &Lattice, axis: Axis, (least, longest): (usize, usize)) -> Vec<[i64; 2]> {
    let shortest = lattice.basis().map(length).into_iter().fold(f64::INFINITY, f64::min);
    // No vector of up to 1.1 times the longest side has larger coefficients in a reduced basis.
    let most = (1.3 * longest as f64 / shortest.max(1.0)).ceil() as i32;
    let mut steps: Vec<(f64, [i64; 2])> = Lattice::half(most)
        .filter_map(|ij| {
            let point = lattice.point(ij);
            let along = if axis == Axis::X { point[0] } else { point[1] };
            let place = point.map(|c| c * along.signum());
            let step = place.map(|c| c.round() as i64);
            let (along, aside) = if axis == Axis::X { (step[0], step[1]) } else { (step[1], step[0]) };
            let in_reach = (least as i64..=longest as i64).contains(&along);
            (in_reach && aside.abs() as f64 <= MOST_OBLIQUE * along as f64)
                .then(|| (rounding(step, place), step))
        })
        .collect();
    steps.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    steps.dedup_by_key(|(_, step)| *step);
    steps.into_iter().map(|(_, step)| step).take(SHORTLIST).collect()
}

fn rounding(step: [i64; 2], place: [f64; 2]) -> f64 {
    length([step[0] as f64 - place[0], step[1] as f64 - place[1]])
}

/// The mean squared difference of an exemplar from itself one step farther.
fn difference(texels: &IndexTexels, step: [i64; 2]) -> f64 {
    let (mut sum, mut count) = (0, 0u64);
    for place in overlapping(texels.size(), step) {
        sum += squared_step(texels, place, step);
        count += 1;
    }
    sum as f64 / count.max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Compared with all integer vectors within reach.
        #[test]
        fn steps_are_the_lattices_nearest_vectors(
            (ax, ay) in (8.0..30.0f64, -9.0..9.0f64),
            (bx, by) in (-9.0..9.0f64, 12.0..30.0f64),
        ) {
            let lattice = Lattice::new([ax, ay], [bx, by]).unwrap();
            let found = steps(&lattice, Axis::X, (40, 90));
            let near = |v: [i64; 2]| rounding(v, lattice.nearest(v.map(|c| c as f64)));
            let all = (40..=90).flat_map(|x| (-x / 3..=x / 3).map(move |y| [x, y]));
            // Vectors obtained from the lattice by rounding to texels.
            let mut truth: Vec<[i64; 2]> = all
                .filter(|v| {
                    let p = lattice.nearest(v.map(|c| c as f64));
                    p.map(f64::round) == v.map(|c| c as f64)
                })
                .collect();
            truth.sort_by(|a, b| near(*a).total_cmp(&near(*b)));
            prop_assert_eq!(found.len(), truth.len().min(SHORTLIST));
            for (a, b) in found.iter().zip(&truth) {
                prop_assert!((near(*a) - near(*b)).abs() < 1e-9);
            }
        }
    }
}
