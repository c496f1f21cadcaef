//! Gaussian and Laplacian pyramids of planes, of any reduction factor.
//!
//! Burt and Adelson, "The Laplacian Pyramid as a Compact Image Code", IEEE Trans. Communications 31 (1983): a
//! level of the Gaussian pyramid is the level before, convolved with a separable kernel and sampled at every
//! n-th texel; a band of the Laplacian pyramid is a level minus the expanded next one. Coarse texel k lies on
//! fine texel n k, so the grids of all levels share the texel (0, 0), on the endless plane as well
//! ([`expand_window`]). Beyond its borders a plane is continued by reflection about its outer texels.

mod kernel;

pub use kernel::Kernel;

use crate::error::{Error, Result};
use crate::parallel;
use crate::planes::Planes;
use crate::size::Size;

/// The next level: planes convolved with the kernel and sampled at every n-th texel. A side of s texels
/// becomes ceil(s / n).
pub fn reduce(planes: &Planes, kernel: &Kernel) -> Planes {
    let size = planes.size();
    let n = kernel.factor();
    let coarse = Size::new(size.width.div_ceil(n), size.height.div_ceil(n));
    let mut out = Planes::zeros(coarse, planes.count());
    for k in 0..planes.count() {
        let source = planes.plane(k);
        parallel::for_each(out.plane_mut(k).chunks_exact_mut(coarse.width).enumerate(), |(y, row)| {
            let tall = weighted_rows(kernel, |i| {
                let fine = reflect((n * y) as i64 + i, size.height);
                &source[fine * size.width..][..size.width]
            });
            reduce_row(&tall, kernel, row);
        });
    }
    out
}

/// sum_i w_i row(i) over the reach of the kernel.
fn weighted_rows<'a>(kernel: &Kernel, row: impl Fn(i64) -> &'a [f32]) -> Vec<f32> {
    let reach = kernel.reach() as i64;
    let mut sum = vec![0.0f32; row(0).len()];
    for i in -reach..=reach {
        let weight = kernel.weight(i);
        sum.iter_mut().zip(row(i)).for_each(|(s, v)| *s += weight * v);
    }
    sum
}

fn reduce_row(row: &[f32], kernel: &Kernel, out: &mut [f32]) {
    let (n, reach) = (kernel.factor() as i64, kernel.reach() as i64);
    for (x, value) in out.iter_mut().enumerate() {
        let term = |i: i64| kernel.weight(i) * row[reflect(n * x as i64 + i, row.len())];
        *value = (-reach..=reach).map(term).sum();
    }
}

/// The index below `length` that replaces a sample beyond the border: reflection about the outer samples.
fn reflect(i: i64, length: usize) -> usize {
    let period = (2 * length as i64 - 2).max(1);
    let inside = i.rem_euclid(period);
    inside.min(period - inside) as usize % length
}

/// Planes expanded to the finer level of `size` texels: the upsampling of the pyramid.
///
/// # Panics
/// When the planes do not have the reduced size.
pub fn expand(coarse: &Planes, kernel: &Kernel, size: Size) -> Planes {
    let n = kernel.factor();
    let expected = Size::new(size.width.div_ceil(n), size.height.div_ceil(n));
    assert_eq!(coarse.size(), expected, "the size of the reduced planes");
    expand_window(coarse, kernel, [0, 0], [0, 0], size)
}

/// The part of the expanded endless plane of `size` texels whose top left texel is `fine`, from the part of
/// the coarse plane whose top left texel is `coarse_origin`. Texels outside that part are reflected;
/// [`window_for`] gives the part for which no reflection is needed.
pub fn expand_window(
    coarse: &Planes,
    kernel: &Kernel,
    coarse_origin: [i64; 2],
    fine: [i64; 2],
    size: Size,
) -> Planes {
    let (count, from) = (coarse.count(), coarse.size());
    let across = taps(kernel, fine[0], size.width, coarse_origin[0], from.width);
    let down = taps(kernel, fine[1], size.height, coarse_origin[1], from.height);
    let mut out = Planes::zeros(size, count);
    for k in 0..count {
        let source = coarse.plane(k);
        parallel::for_each(out.plane_mut(k).chunks_exact_mut(size.width).zip(&down), |(row, taps)| {
            let mut tall = vec![0.0f32; from.width];
            for &(y, weight) in taps {
                let coarse_row = &source[y * from.width..][..from.width];
                tall.iter_mut().zip(coarse_row).for_each(|(t, v)| *t += weight * v);
            }
            for (value, taps) in row.iter_mut().zip(&across) {
                *value = taps.iter().map(|&(x, weight)| weight * tall[x]).sum();
            }
        });
    }
    out
}

/// The coarse samples of a fine sample: always three, some of weight zero.
type Taps = [(usize, f32); 3];

/// For each of `length` fine samples from `fine` on, its coarse samples and weights.
fn taps(kernel: &Kernel, fine: i64, length: usize, origin: i64, available: usize) -> Vec<Taps> {
    let n = kernel.factor() as i64;
    (fine..fine + length as i64)
        .map(|x| {
            let centre = (x + n / 2).div_euclid(n);
            std::array::from_fn(|t| {
                let k = centre - 1 + t as i64;
                (reflect(k - origin, available), n as f32 * kernel.weight(x - n * k))
            })
        })
        .collect()
}

/// First texel and length of the coarse samples that `length` fine samples from `fine` on need.
pub fn window_for(kernel: &Kernel, fine: i64, length: usize) -> (i64, usize) {
    let n = kernel.factor() as i64;
    let centre = |x: i64| (x + n / 2).div_euclid(n);
    let first = centre(fine) - 1;
    let last = centre(fine + length as i64 - 1) + 1;
    (first, (last - first + 1) as usize)
}

/// The Gaussian pyramid: `levels` stacks of planes, the finest first, which is a copy.
pub fn gaussian(planes: &Planes, kernel: &Kernel, levels: usize) -> Vec<Planes> {
    let mut pyramid = vec![planes.clone()];
    while pyramid.len() < levels {
        let next = reduce(&pyramid[pyramid.len() - 1], kernel);
        pyramid.push(next);
    }
    pyramid
}

/// The Laplacian pyramid: bands from the finest on, the last of which is the coarsest Gaussian level.
pub fn laplacian(planes: &Planes, kernel: &Kernel, levels: usize) -> Vec<Planes> {
    let mut pyramid = gaussian(planes, kernel, levels);
    for k in 1..pyramid.len() {
        let expanded = expand(&pyramid[k], kernel, pyramid[k - 1].size());
        subtract(&mut pyramid[k - 1], &expanded);
    }
    pyramid
}

/// The planes of a Laplacian pyramid: exact up to one rounding per level.
///
/// # Errors
/// When there is no band, or the sizes or numbers of planes of the bands do not match.
pub fn collapse(bands: &[Planes], kernel: &Kernel) -> Result<Planes> {
    let (top, finer) =
        bands.split_last().ok_or_else(|| Error::usage("a pyramid without bands is nothing"))?;
    let mut planes = top.clone();
    for band in finer.iter().rev() {
        let n = kernel.factor();
        let expected = Size::new(band.size().width.div_ceil(n), band.size().height.div_ceil(n));
        if planes.size() != expected || planes.count() != band.count() {
            return Err(Error::invalid(format!(
                "below a band of {} planes of {} belong as many planes of {expected}, found {} of {}",
                band.count(),
                band.size(),
                planes.count(),
                planes.size()
            )));
        }
        planes = expand(&planes, kernel, band.size());
        add(&mut planes, band);
    }
    Ok(planes)
}

/// a = a + b, sample by sample.
pub fn add(a: &mut Planes, b: &Planes) {
    a.as_mut_slice().iter_mut().zip(b.as_slice()).for_each(|(a, b)| *a += b);
}

/// a = a - b, sample by sample.
pub fn subtract(a: &mut Planes, b: &Planes) {
    a.as_mut_slice().iter_mut().zip(b.as_slice()).for_each(|(a, b)| *a -= b);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};
    use proptest::prelude::*;

    fn random(size: Size, count: usize, seed: u64) -> Planes {
        let mut stream = Stream::new(seed, Purpose::Sample, [0]);
        let data = (0..size.texels() * count).map(|_| stream.unit() as f32).collect();
        Planes::from_vec(size, count, data).unwrap()
    }

    /// The published double sum, evaluated directly.
    fn slow_reduce(planes: &Planes, kernel: &Kernel, k: usize, x: usize, y: usize) -> f64 {
        let (n, reach, size) = (kernel.factor() as i64, kernel.reach() as i64, planes.size());
        let mut sum = 0.0;
        for j in -reach..=reach {
            for i in -reach..=reach {
                let fine = (reflect(n * x as i64 + i, size.width), reflect(n * y as i64 + j, size.height));
                let weight = f64::from(kernel.weight(i)) * f64::from(kernel.weight(j));
                sum += weight * f64::from(planes.at(k, fine.0, fine.1));
            }
        }
        sum
    }

    /// Zeros inserted between the coarse samples, convolved with n^2 w w.
    fn slow_expand(coarse: &Planes, kernel: &Kernel, k: usize, x: i64, y: i64) -> f64 {
        let n = kernel.factor() as i64;
        let (mut sum, size) = (0.0, coarse.size());
        for j in y / n - 2..=y / n + 2 {
            for i in x / n - 2..=x / n + 2 {
                let weight = f64::from(kernel.weight(x - n * i)) * f64::from(kernel.weight(y - n * j));
                let value = coarse.at(k, reflect(i, size.width), reflect(j, size.height));
                sum += (n * n) as f64 * weight * f64::from(value);
            }
        }
        sum
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]
        #[test]
        fn levels_are_the_documents_sums_and_collapse_exactly(
            width in 1usize..41, height in 1usize..37, factor in 2usize..6, levels in 1usize..5, seed: u64,
        ) {
            let kernel = Kernel::new(factor).unwrap();
            let planes = random(Size::new(width, height), 2, seed);
            let coarse = reduce(&planes, &kernel);
            let expanded = expand(&coarse, &kernel, planes.size());
            for k in 0..2 {
                let (x, y) = (coarse.size().width - 1, coarse.size().height / 2);
                prop_assert!((f64::from(coarse.at(k, x, y)) - slow_reduce(&planes, &kernel, k, x, y)).abs() < 1e-5);
                let (x, y) = (width / 2, height - 1);
                let slow = slow_expand(&coarse, &kernel, k, x as i64, y as i64);
                prop_assert!((f64::from(expanded.at(k, x, y)) - slow).abs() < 1e-5);
            }
            let bands = laplacian(&planes, &kernel, levels);
            let back = collapse(&bands, &kernel).unwrap();
            for (a, b) in planes.as_slice().iter().zip(back.as_slice()) {
                prop_assert!((a - b).abs() < 3e-7, "{a} {b}");
            }
        }

        #[test]
        fn a_window_of_the_endless_expansion_does_not_depend_on_where_it_is_cut(
            x in -50i64..50, y in -50i64..50, width in 1usize..30, height in 1usize..20, factor in 2usize..5,
        ) {
            let kernel = Kernel::new(factor).unwrap();
            let value = |x: i64, y: i64| ((x * 31 + y * 17).rem_euclid(97)) as f32;
            let cut = |x: i64, y: i64, size: Size| {
                let (cx, w) = window_for(&kernel, x, size.width);
                let (cy, h) = window_for(&kernel, y, size.height);
                let texels = (0..w * h).map(|i| value(cx + (i % w) as i64, cy + (i / w) as i64)).collect();
                let coarse = Planes::from_vec(Size::new(w, h), 1, texels).unwrap();
                expand_window(&coarse, &kernel, [cx, cy], [x, y], size)
            };
            let whole = cut(x, y, Size::new(width + 9, height + 7));
            let part = cut(x + 4, y + 5, Size::new(width, height));
            prop_assert_eq!(whole.crop(4, 5, Size::new(width, height)).unwrap(), part);
        }
    }

    #[test]
    fn constants_stay_constants() {
        for factor in 2..6 {
            let kernel = Kernel::new(factor).unwrap();
            let flat = Planes::from_vec(Size::new(13, 9), 1, vec![0.75; 117]).unwrap();
            let coarse = reduce(&flat, &kernel);
            let expanded = expand(&coarse, &kernel, flat.size());
            let all = coarse.as_slice().iter().chain(expanded.as_slice());
            assert!(all.clone().all(|v| (v - 0.75).abs() < 1e-6));
        }
    }

    #[test]
    fn bands_that_do_not_belong_together_are_refused() {
        let kernel = Kernel::new(2).unwrap();
        let bands = [Planes::zeros(Size::new(8, 8), 1), Planes::zeros(Size::new(5, 4), 1)];
        assert!(collapse(&bands, &kernel).is_err());
        assert!(collapse(&[], &kernel).is_err());
    }
}
