//! The wavelet transform of planes on a torus, any size.
//!
//! The biorthogonal 9/7 wavelets of A. Cohen, I. Daubechies, J.-C. Feauveau, "Biorthogonal Bases of Compactly
//! Supported Wavelets", Comm. Pure and Applied Mathematics 45 (1992), as the four lifting steps of I.
//! Daubechies, W. Sweldens, "Factoring Wavelet Transforms into Lifting Steps", J. Fourier Analysis and
//! Applications 4 (1998), scaled so that the transform is nearly orthonormal: an error of coefficients is
//! about as large in the plane.
//!
//! A line of n values becomes ceil(n/2) averages followed by floor(n/2) differences. The line is periodic. If
//! n is odd, two averages are adjacent at its end, and a step uses the neighbour on the other side instead.
//! Each step is exactly invertible.

use crate::planes::Planes;
use crate::size::Size;

/// Factors of the lifting steps: differences, averages, differences, averages.
const STEPS: [f32; 4] = [-1.586_134_3, -0.052_980_12, 0.882_911_1, 0.443_506_85];

/// The factor of the averages, and the divisor of the differences, at the end: sqrt(2) / 1.2301741.
const SCALE: f32 = 1.149_604_4;

/// The sizes of the averages at each scale, from the plane itself on.
pub fn sizes(size: Size, scales: usize) -> Vec<Size> {
    let half = |s: Size| Size::new(s.width.div_ceil(2), s.height.div_ceil(2));
    std::iter::successors(Some(size), |&s| Some(half(s))).take(scales + 1).collect()
}

/// Coefficients of each plane: the averages of the last scale in the upper left corner, around them its
/// differences along x, along y and along both, and so on outwards.
pub fn forward(planes: &mut Planes, scales: usize) {
    for size in &sizes(planes.size(), scales)[..scales] {
        transform(planes, *size, forward_line);
    }
}

/// The planes of given coefficients.
pub fn inverse(planes: &mut Planes, scales: usize) {
    for size in sizes(planes.size(), scales)[..scales].iter().rev() {
        transform(planes, *size, inverse_line);
    }
}

/// Transforms all rows, then all columns, of the upper left part of each plane. Both commute, so one order
/// serves both directions.
fn transform(planes: &mut Planes, part: Size, change: fn(&mut [f32], &mut [f32])) {
    let width = planes.size().width;
    let (mut line, mut buffer) = (vec![0.0; part.height], vec![0.0; part.width.max(part.height)]);
    for plane in planes.iter_mut() {
        for row in plane.chunks_exact_mut(width).take(part.height) {
            change(&mut row[..part.width], &mut buffer[..part.width]);
        }
        for x in 0..part.width {
            line.iter_mut().zip(plane[x..].iter().step_by(width)).for_each(|(to, from)| *to = *from);
            change(&mut line, &mut buffer[..part.height]);
            plane[x..].iter_mut().step_by(width).zip(&line).for_each(|(to, from)| *to = *from);
        }
    }
}

/// The neighbours of value `i`, of the other parity.
fn neighbours(i: usize, n: usize) -> [usize; 2] {
    let [left, right] = [(i + n - 1) % n, (i + 1) % n];
    let other = |at: usize, instead: usize| if at % 2 == i % 2 { instead } else { at };
    [other(left, right), other(right, left)]
}

/// Adds to every second value the sum of its neighbours times a factor.
fn lift(line: &mut [f32], first: usize, factor: f32) {
    let n = line.len();
    for i in (first..n).step_by(2) {
        let [left, right] = neighbours(i, n);
        line[i] += factor * (line[left] + line[right]);
    }
}

fn forward_line(line: &mut [f32], buffer: &mut [f32]) {
    let n = line.len();
    if n < 2 {
        return;
    }
    STEPS.iter().enumerate().for_each(|(k, &factor)| lift(line, 1 - k % 2, factor));
    buffer.copy_from_slice(line);
    let averages = n.div_ceil(2);
    for (i, &value) in buffer.iter().enumerate() {
        let (place, scale) = if i % 2 == 0 { (i / 2, SCALE) } else { (averages + i / 2, 1.0 / SCALE) };
        line[place] = scale * value;
    }
}

fn inverse_line(line: &mut [f32], buffer: &mut [f32]) {
    let n = line.len();
    if n < 2 {
        return;
    }
    let averages = n.div_ceil(2);
    buffer.copy_from_slice(line);
    for (i, value) in line.iter_mut().enumerate() {
        *value = if i % 2 == 0 { buffer[i / 2] / SCALE } else { buffer[averages + i / 2] * SCALE };
    }
    STEPS.iter().enumerate().rev().for_each(|(k, &factor)| lift(line, 1 - k % 2, -factor));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};
    use proptest::prelude::*;

    fn random(size: Size, seed: u64) -> Planes {
        let mut stream = Stream::new(seed, Purpose::Sample, [0]);
        Planes::from_vec(size, 2, (0..2 * size.texels()).map(|_| stream.unit() as f32 - 0.5).collect())
            .unwrap()
    }

    fn energy(planes: &Planes) -> f64 {
        planes.as_slice().iter().map(|&v| f64::from(v).powi(2)).sum()
    }

    proptest! {
        #[test]
        fn planes_come_back_and_keep_their_energy(
            width in 1usize..50, height in 1usize..40, scales in 0usize..5, seed: u64,
        ) {
            let planes = random(Size::new(width, height), seed);
            let mut changed = planes.clone();
            forward(&mut changed, scales);
            if width.min(height) > 24 {
                let ratio = energy(&changed) / energy(&planes);
                prop_assert!((0.8..1.25).contains(&ratio), "{ratio}");
            }
            inverse(&mut changed, scales);
            for (a, b) in planes.as_slice().iter().zip(changed.as_slice()) {
                prop_assert!((a - b).abs() < 1e-5, "{a} {b}");
            }
        }

        /// On a torus of a multiple of 2^scales texels a shift by as many shifts the coefficients.
        #[test]
        fn even_planes_continue_themselves(columns in 1usize..6, rows in 1usize..6, seed: u64) {
            let size = Size::new(4 * columns, 4 * rows);
            let planes = random(size, seed);
            let mut shifted = Planes::zeros(size, 2);
            for (k, y, x) in (0..2).flat_map(|k| (0..size.height).flat_map(move |y| (0..size.width).map(move |x| (k, y, x)))) {
                let to = size.index((x + 4) % size.width, y);
                shifted.plane_mut(k)[to] = planes.at(k, x, y);
            }
            let (mut a, mut b) = (planes, shifted);
            forward(&mut a, 2);
            forward(&mut b, 2);
            for y in 0..rows {
                for x in 0..columns {
                    prop_assert!((a.at(0, x, y) - b.at(0, (x + 1) % columns, y)).abs() < 1e-4);
                }
            }
        }
    }

    #[test]
    fn smooth_planes_have_small_differences() {
        let size = Size::new(64, 48);
        let wave = |i: usize| {
            let (x, y) = ((i % 64) as f32 / 64.0, (i / 64) as f32 / 48.0);
            (std::f32::consts::TAU * (2.0 * x + y)).sin()
        };
        let mut planes = Planes::from_vec(size, 1, (0..size.texels()).map(wave).collect()).unwrap();
        let whole = energy(&planes);
        forward(&mut planes, 2);
        let averages = planes.crop(0, 0, Size::new(16, 12)).unwrap();
        let differences = energy(&planes) - energy(&averages);
        assert!(differences < 1e-3 * whole, "{differences} of {whole}");
    }

    #[test]
    fn sizes_halve_upwards() {
        assert_eq!(
            sizes(Size::new(13, 2), 3),
            [Size::new(13, 2), Size::new(7, 1), Size::new(4, 1), Size::new(2, 1)]
        );
    }
}
