//! Inner products of shifted planes, the sufficient statistics of the estimation.
//!
//! A regressor is a plane seen through an offset. The sum over a window of the product of two regressors
//! depends on their offsets only through their difference and, at the borders of the window, through its
//! position. So each product of two planes at one lag is summed row by row once, for all pairs of regressors
//! that share it. Pairs differ only in the ends of rows and in the rows included. The sums are exact, take a
//! fraction of the work of a Gram matrix, and avoid the periodic continuation of a Fourier transform.

use std::collections::BTreeMap;

use super::neighbourhood::{Offset, Reach};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::numeric::Matrix;
use crate::parallel;
use crate::planes::Planes;
use crate::rect::Rect;
use crate::size::Size;

/// A plane seen through an offset: its value at texel r is that of the plane at r + offset.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Regressor {
    /// The number of the plane.
    pub plane: usize,
    /// The offset.
    pub offset: Offset,
}

/// The texels of a plane whose neighbours within `reach` are all inside it.
///
/// # Errors
/// When there are none.
pub fn inside(size: Size, reach: Reach) -> Result<Rect<usize>> {
    let width = size.width.saturating_sub(reach.left + reach.right);
    let height = size.height.saturating_sub(reach.up + reach.down);
    if width == 0 || height == 0 {
        return Err(Error::invalid(format!(
            "planes of {size} texels are smaller than the neighbourhood, which spans {} x {}: take a larger \
             texture, fewer levels or a smaller neighbourhood",
            reach.left + reach.right + 1,
            reach.up + reach.down + 1
        )));
    }
    Ok(Rect::new(reach.left, reach.up, Size::new(width, height)))
}

/// The sums over the window of the products of all pairs of regressors.
///
/// # Errors
/// When the job is cancelled.
///
/// # Panics
/// When a regressor leaves the planes for a texel of the window.
pub fn inner_products(
    planes: &Planes,
    regressors: &[Regressor],
    window: Rect<usize>,
    job: &Job,
) -> Result<Matrix> {
    let rows = SummedRows::new(planes, window);
    let groups: Vec<(Lag, Vec<RegressorPair>)> = grouped(regressors).into_iter().collect();
    let sums_of = |(lag, pairs): &(Lag, Vec<RegressorPair>)| {
        job.proceed()?;
        Ok(rows.sums(*lag, pairs))
    };
    let sums: Vec<Vec<f64>> = parallel::try_map(groups.iter(), sums_of)?;
    let mut gram = Matrix::zeros(regressors.len(), regressors.len());
    for ((_, pairs), sums) in groups.iter().zip(sums) {
        for (pair, sum) in pairs.iter().zip(sums) {
            gram[(pair.a, pair.b)] = sum;
            gram[(pair.b, pair.a)] = sum;
        }
    }
    Ok(gram)
}

/// The same sums, product by product: the slow truth.
pub fn inner_products_slow(planes: &Planes, regressors: &[Regressor], window: Rect<usize>) -> Matrix {
    let value = |r: Regressor, x: usize, y: usize| {
        let (x, y) = (x as i64 + i64::from(r.offset.dx), y as i64 + i64::from(r.offset.dy));
        f64::from(planes.at(r.plane, x as usize, y as usize))
    };
    Matrix::from_fn(regressors.len(), regressors.len(), |a, b| {
        let texels = (0..window.size.texels())
            .map(|i| (window.x + i % window.size.width, window.y + i / window.size.width));
        texels.map(|(x, y)| value(regressors[a], x, y) * value(regressors[b], x, y)).sum()
    })
}

/// Two planes and the offset of the second from the first.
type Lag = (usize, usize, Offset);

/// Two regressors, and the offset of the first.
struct RegressorPair {
    a: usize,
    b: usize,
    shift: Offset,
}

/// All pairs of regressors by lag. A product is symmetric: the smaller plane comes first, and within one
/// plane the lag that points down or right.
fn grouped(regressors: &[Regressor]) -> BTreeMap<Lag, Vec<RegressorPair>> {
    let mut groups: BTreeMap<Lag, Vec<RegressorPair>> = BTreeMap::new();
    for a in 0..regressors.len() {
        for b in a..regressors.len() {
            let (mut p, mut q) = (regressors[a], regressors[b]);
            let lag = |p: Regressor, q: Regressor| {
                Offset::new(q.offset.dx - p.offset.dx, q.offset.dy - p.offset.dy)
            };
            if p.plane > q.plane || (p.plane == q.plane && lag(p, q).is_causal()) {
                (p, q) = (q, p);
            }
            groups.entry((p.plane, q.plane, lag(p, q))).or_default().push(RegressorPair {
                a,
                b,
                shift: p.offset,
            });
        }
    }
    groups
}

/// Planes in double precision, and the window over them.
struct SummedRows {
    size: Size,
    planes: Vec<Vec<f64>>,
    window: Rect<usize>,
}

impl SummedRows {
    fn new(planes: &Planes, window: Rect<usize>) -> Self {
        let planes64 = planes.iter().map(|p| p.iter().map(|&v| f64::from(v)).collect()).collect();
        Self { size: planes.size(), planes: planes64, window }
    }

    /// For each pair the sum of products at the common lag.
    fn sums(&self, (p, q, lag): Lag, pairs: &[RegressorPair]) -> Vec<f64> {
        let mut shifts: Vec<i32> = pairs.iter().map(|pair| pair.shift.dx).collect();
        shifts.sort_unstable();
        shifts.dedup();
        let (top, bottom) = pairs.iter().fold((i32::MAX, i32::MIN), |(low, high), pair| {
            (low.min(pair.shift.dy), high.max(pair.shift.dy))
        });
        let first = self.window.y.checked_add_signed(top as isize).expect("offsets stay inside the planes");
        let rows = self.window.size.height + (bottom - top) as usize;
        // cumulative[s][i]: the first i rows of the products of the lag as seen through shift s.
        let mut cumulative = vec![vec![0.0f64; rows + 1]; shifts.len()];
        for i in 0..rows {
            let row = self.row_sums(p, q, lag, first + i, &shifts);
            cumulative.iter_mut().zip(row).for_each(|(c, sum)| c[i + 1] = c[i] + sum);
        }
        let sum = |pair: &RegressorPair| {
            let s = shifts.binary_search(&pair.shift.dx).expect("every shift was listed");
            let skipped = (pair.shift.dy - top) as usize;
            cumulative[s][skipped + self.window.size.height] - cumulative[s][skipped]
        };
        pairs.iter().map(sum).collect()
    }

    /// Sums along row y of plane p times the row of plane q at the lag, over the columns of the window
    /// shifted by each of `shifts`, in increasing order: the common part once, the ends for each.
    fn row_sums(&self, p: usize, q: usize, lag: Offset, y: usize, shifts: &[i32]) -> Vec<f64> {
        let line = |plane: usize, y: usize| &self.planes[plane][y * self.size.width..][..self.size.width];
        let other = y.checked_add_signed(lag.dy as isize).expect("offsets stay inside the planes");
        let (a, b) = (line(p, y), line(q, other));
        let sum = |from: i64, to: i64| {
            let second = (from + i64::from(lag.dx)) as usize;
            let length = (to - from).max(0) as usize;
            if length == 0 { 0.0 } else { dot(&a[from as usize..][..length], &b[second..][..length]) }
        };
        let start = self.window.x as i64;
        let end = start + self.window.size.width as i64;
        let (least, most) = (i64::from(shifts[0]), i64::from(shifts[shifts.len() - 1]));
        let (from, to) = (start + most, end + least);
        if to <= from {
            return shifts.iter().map(|&s| sum(start + i64::from(s), end + i64::from(s))).collect();
        }
        let shared = sum(from, to);
        let ends = |s: i64| sum(start + s, from) + sum(to, end + s);
        shifts.iter().map(|&s| shared + ends(i64::from(s))).collect()
    }
}

/// The inner product of two rows, in an order that does not depend on the processor.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = pulp::x86::V3::try_new() {
        return simd.vectorize(
            #[inline(always)]
            || dot_lanes(a, b),
        );
    }
    dot_lanes(a, b)
}

#[inline(always)]
fn dot_lanes(a: &[f64], b: &[f64]) -> f64 {
    const LANES: usize = 16;
    let mut sums = [0.0f64; LANES];
    let (a, b) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let rest: f64 = a.remainder().iter().zip(b.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a.zip(b) {
        for i in 0..LANES {
            sums[i] = a[i].mul_add(b[i], sums[i]);
        }
    }
    sums.iter().sum::<f64>() + rest
}

#[cfg(test)]
mod tests {
    use super::super::neighbourhood::{all_around, causal};
    use super::*;
    use crate::numeric::random::{Purpose, Stream};
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]
        #[test]
        fn shared_lags_give_the_sums_of_all_products(
            width in 1usize..40, height in 1usize..30, near in 1usize..24, around in 0usize..10, seed: u64,
        ) {
            let mut stream = Stream::new(seed, Purpose::Sample, [0]);
            let (near, around) = (causal(near), all_around(around));
            let regressors: Vec<Regressor> = [Offset::new(0, 0)].iter().chain(&near)
                .flat_map(|&offset| (0..2).map(move |plane| Regressor { plane, offset }))
                .chain(around.iter().map(|&offset| Regressor { plane: 2, offset }))
                .collect();
            let offsets: Vec<Offset> = regressors.iter().map(|r| r.offset).collect();
            let reach = Reach::of(&offsets);
            let size = Size::new(width + reach.left + reach.right, height + reach.up + reach.down);
            let data = (0..3 * size.texels()).map(|_| stream.unit() as f32 - 0.4).collect();
            let planes = Planes::from_vec(size, 3, data).unwrap();
            let window = inside(size, reach).unwrap();
            prop_assert_eq!(window.size, Size::new(width, height));
            let fast = inner_products(&planes, &regressors, window, &Job::default()).unwrap();
            let slow = inner_products_slow(&planes, &regressors, window);
            for a in 0..regressors.len() {
                for b in 0..regressors.len() {
                    prop_assert!((fast[(a, b)] - slow[(a, b)]).abs() < 1e-10 * (1.0 + slow[(a, a)].abs() + slow[(b, b)].abs()));
                }
            }
        }
    }

    #[test]
    fn planes_smaller_than_the_neighbourhood_are_refused() {
        let error = inside(Size::new(8, 3), Reach::of(&causal(40))).unwrap_err();
        assert!(error.message().contains("10 x 6"), "{error}");
    }
}
