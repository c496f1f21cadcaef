//! The sieve before the exact search: lower bounds of distances from one or two numbers per texel.
//!
//! The planes of a texture are correlated: the first principal axes of the codes of its texels hold most of
//! their differences. The squared distance of two texels is at least the sum of the squared differences along
//! orthonormal axes, so a weighted sum of those is a lower bound of the distance of two windows, for a
//! fraction of the multiplications (the idea of projections, Hel-Or, Hel-Or, IEEE TPAMI 2005).
//!
//! Coordinates along an axis are rounded down to whole steps, with [`SPAN`] steps between the farthest two
//! texels. By the triangle inequality of the weighted norm, rounding shortens a length by less than the root
//! of the sum of weights, which is added to the limit. Sums have 32 bits and no floating-point number decides
//! the result: positions that pass are compared exactly.

use super::kernel::Term;
use super::window::{Tap, WindowQuery};
use crate::numeric::{Matrix, eigen};
use crate::size::Size;
use crate::synthesis::quantise::{IndexTexels, Quantised};

/// Steps between the farthest two texels along an axis.
pub const SPAN: i16 = 2047;

/// The share of the variance up to which axes are added.
const ENOUGH: f64 = 0.98;

/// The most axes.
const MOST_AXES: usize = 2;

/// A bound on the errors of floating-point sums, relative to a length.
const ROUNDING: f64 = 1e-6;

/// The principal axes of the texels of the exemplars.
#[derive(Debug)]
pub struct Sieve {
    /// Unit vectors as rows.
    axes: Matrix,
    /// The least coordinate of a texel along each axis.
    low: Vec<f64>,
    /// Steps along an axis per code.
    scale: f64,
}

impl Sieve {
    /// The axes of the first `copied` planes of all texels.
    pub fn new(exemplars: &Quantised, copied: usize) -> Self {
        let texels =
            || exemplars.texels().iter().flat_map(|t| codes(t, exemplars.planes()).map(|c| &c[..copied]));
        let axes = principal_axes(texels, copied);
        let along =
            |codes: &[i16]| -> Vec<f64> { (0..axes.rows()).map(|k| place(&axes, k, codes)).collect() };
        let first = texels().next().map(along).unwrap_or_else(|| vec![0.0; axes.rows()]);
        let (mut low, mut high) = (first.clone(), first);
        for there in texels().map(along) {
            low.iter_mut().zip(&there).for_each(|(low, &at)| *low = low.min(at));
            high.iter_mut().zip(&there).for_each(|(high, &at)| *high = high.max(at));
        }
        let widest = low.iter().zip(&high).map(|(low, high)| high - low).fold(0.0, f64::max);
        let scale = if widest > 0.0 { f64::from(SPAN) / widest } else { 1.0 };
        Self { axes, low, scale }
    }

    /// The number of axes.
    pub fn axes(&self) -> usize {
        self.axes.rows()
    }

    /// The coordinates of all texels of an exemplar of the given number of planes and of their right
    /// neighbours, axis after axis.
    pub fn pairs(&self, texels: &IndexTexels, planes: usize) -> impl Iterator<Item = [i16; 2]> {
        (0..self.axes()).flat_map(move |k| {
            let here: Vec<i16> = codes(texels, planes).map(|codes| self.step(k, codes)).collect();
            (0..here.len()).map(move |i| [here[i], here.get(i + 1).copied().unwrap_or(0)])
        })
    }

    /// The terms of a query for an exemplar of the given size: its taps with the shift of the first one, two
    /// neighbours at a time, in order of decreasing weight; all along the first axis, then along the second.
    /// Offsets are relative to the position in the first axis.
    pub(super) fn terms(&self, query: &WindowQuery, copied: usize, size: Size) -> Vec<Term> {
        let twos = neighbours(&query.taps);
        let term = |axis: usize, (left, right): (usize, Option<usize>)| {
            let (x, y) = query.place(&query.taps[left]);
            let at = |tap: usize| self.step(axis, &query.codes[tap * copied..][..copied]);
            let factor = |tap: usize| query.taps[tap].weight.factor;
            Term {
                offset: axis * size.texels() + size.index(x, y),
                codes: [at(left), right.map_or(0, at)],
                factors: [factor(left), right.map_or(0, factor)],
            }
        };
        (0..self.axes()).flat_map(|axis| twos.iter().map(move |&two| term(axis, two))).collect()
    }

    /// The largest possible sum of terms, with factors that sum to `weights`, of a window whose weighted
    /// squared distance, in units of the shift of the weights, is below `most` + 1.
    pub(super) fn limit(&self, most: u64, weights: f64) -> u32 {
        let length = self.scale * (most as f64 + 1.0).sqrt() + weights.sqrt();
        (length * (1.0 + ROUNDING)).powi(2).min(f64::from(u32::MAX)) as u32
    }

    /// The coordinate of a texel along an axis in whole steps, clamped to the range of the texels of the
    /// exemplars, which moves it nearer to all of them.
    fn step(&self, axis: usize, codes: &[i16]) -> i16 {
        let steps = self.scale * (place(&self.axes, axis, codes) - self.low[axis]);
        steps.floor().clamp(0.0, f64::from(SPAN)) as i16
    }
}

/// The taps with the shift of the first one, by their numbers, in pairs of horizontal neighbours, or alone.
fn neighbours(taps: &[Tap]) -> Vec<(usize, Option<usize>)> {
    let heavy = taps.iter().take_while(|tap| tap.weight.shift == taps[0].weight.shift).count();
    let mut used = vec![false; heavy];
    let mut twos = Vec::with_capacity(heavy);
    for one in 0..heavy {
        if std::mem::replace(&mut used[one], true) {
            continue;
        }
        let free = |by: isize| {
            let place = (taps[one].dx + by, taps[one].dy);
            (one + 1..heavy).find(|&other| !used[other] && (taps[other].dx, taps[other].dy) == place)
        };
        let (right, left) = (free(1), free(-1));
        let two = match (right, left) {
            (None, Some(left)) => (left, Some(one)),
            (right, _) => (one, right),
        };
        right.or(left).iter().for_each(|&other| used[other] = true);
        twos.push(two);
    }
    twos
}

/// The codes of all texels, the planes of a texel adjacent.
fn codes(texels: &IndexTexels, planes: usize) -> impl Iterator<Item = &[i16]> {
    texels.codes()[..texels.size().texels() * planes].chunks_exact(planes)
}

fn place(axes: &Matrix, axis: usize, codes: &[i16]) -> f64 {
    axes.row(axis).iter().zip(codes).map(|(a, &code)| a * f64::from(code)).sum()
}

/// The first principal axes of texels as rows.
fn principal_axes<'a, I: Iterator<Item = &'a [i16]>>(texels: impl Fn() -> I, planes: usize) -> Matrix {
    let mut sums = vec![0i64; planes];
    let mut products = vec![0i64; planes * planes];
    let mut count = 0.0;
    for codes in texels() {
        count += 1.0;
        for (j, &a) in codes.iter().enumerate() {
            sums[j] += i64::from(a);
            (0..=j).for_each(|k| products[j * planes + k] += i64::from(a) * i64::from(codes[k]));
        }
    }
    let covariance = Matrix::from_fn(planes, planes, |j, k| {
        let product = products[j.max(k) * planes + j.min(k)] as f64;
        product - sums[j] as f64 * sums[k] as f64 / f64::max(count, 1.0)
    });
    let (variances, axes) = eigen::symmetric(&covariance);
    let whole: f64 = variances.iter().sum();
    let held = |axes: usize| variances[..axes].iter().sum::<f64>() >= ENOUGH * whole;
    let most = MOST_AXES.min(planes);
    let axes_kept = (1..most).find(|&axes| held(axes)).unwrap_or(most);
    Matrix::from_fn(axes_kept, planes, |k, j| axes[(k, j)])
}

#[cfg(test)]
mod tests {
    use super::super::plain::distance;
    use super::super::window::ComparedWindow;
    use super::*;
    use crate::job::Job;
    use crate::numeric::random::{Purpose, Stream};
    use crate::planes::Planes;
    use crate::synthesis::quantise::Exemplar;
    use crate::synthesis::source_map::Texel;
    use proptest::prelude::*;

    /// The sum of the terms of a query at a position.
    fn sum(terms: &[Term], pairs: &[[i16; 2]], position: usize) -> u64 {
        let square = |a: i16, b: i16| u64::from(a.abs_diff(b)).pow(2);
        let of = |term: &Term| {
            let there = pairs[position + term.offset];
            (0..2).map(|i| term.factors[i] as u64 * square(there[i], term.codes[i])).sum::<u64>()
        };
        terms.iter().map(of).sum()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(60))]

        /// Queries from the exemplar itself, where bounds are tightest, and from anything else.
        #[test]
        fn no_bound_exceeds_a_distance(
            (half, planes, seed) in (1usize..5, 1usize..7, any::<u64>()),
            (extra, levels) in (0usize..14, prop_oneof![Just(1usize), Just(3), Just(100_000)]),
            (gaussian, own, share) in (any::<bool>(), any::<bool>(), 1usize..5),
        ) {
            let mut stream = Stream::new(seed, Purpose::Sample, [0]);
            let side = 2 * half + 1;
            let size = Size::new(side + extra, side + extra / 2);
            // Correlated planes, so that one axis holds most.
            let common: Vec<usize> = (0..size.texels()).map(|_| 3 * stream.below(levels)).collect();
            let data = (0..planes).flat_map(|_| common.clone()).map(|v| (v + stream.below(levels)) as f32).collect();
            let index = Planes::from_vec(size, planes, data).unwrap();
            let exemplar = [Exemplar { index: &index, excluded: None }];
            let quantised = Quantised::new(&exemplar, &Job::default()).unwrap();
            let texels = &quantised.texels()[0];
            let window = if gaussian { ComparedWindow::gaussian(side) } else { ComparedWindow::uniform(side) };
            let mut query = WindowQuery { radius: half, ..WindowQuery::default() };
            for tap in window.taps() {
                if stream.below(4) >= share {
                    continue;
                }
                let (x, y) = query.place(tap);
                query.taps.push(*tap);
                match own {
                    true => query.codes.extend_from_slice(texels.run(extra / 2 + x, extra / 4 + y, 1)),
                    false => query.codes.extend((0..planes).map(|_| stream.below(4096) as i16)),
                }
            }
            let shift = query.taps.first().map_or(0, |tap| tap.weight.shift);
            let sieve = Sieve::new(&quantised, planes);
            let pairs: Vec<[i16; 2]> = sieve.pairs(texels, planes).collect();
            let terms = sieve.terms(&query, planes, size);
            for (x, y) in (0..=extra / 2).flat_map(|y| (0..=extra).map(move |x| (x, y))) {
                let most = distance(&quantised, &query, Texel { exemplar: 0, y: y as u32, x: x as u32 }) >> shift;
                let limit = sieve.limit(most, terms.iter().flat_map(|term| term.factors).map(f64::from).sum());
                prop_assert!(sum(&terms, &pairs, size.index(x, y)) <= u64::from(limit));
            }
        }
    }

    #[test]
    fn one_axis_is_enough_where_planes_go_together() {
        let size = Size::new(9, 8);
        let mut stream = Stream::new(5, Purpose::Sample, [0]);
        let first: Vec<f32> = (0..72).map(|_| stream.below(200) as f32).collect();
        let twice = Planes::from_vec(size, 2, [&first[..], &first].concat()).unwrap();
        let apart = Planes::from_vec(size, 2, (0..144).map(|_| stream.below(200) as f32).collect()).unwrap();
        let axes = |index: &Planes| {
            let exemplar = [Exemplar { index, excluded: None }];
            Sieve::new(&Quantised::new(&exemplar, &Job::default()).unwrap(), 2).axes()
        };
        assert_eq!((axes(&twice), axes(&apart)), (1, 2));
    }
}
