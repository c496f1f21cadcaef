//! The difference of an exemplar from itself under each shift along one axis: the autocorrelation of all
//! index planes along x and along y.
//!
//! E(s) = sum |I(x) - I(x + s)|^2 over all texels that have both, by the convolution theorem row by row: sum
//! I(x)^2 + sum I(x + s)^2 - 2 sum I(x) I(x + s). [`direct`] is the slow truth.

use realfft::RealFftPlanner;
use realfft::num_complex::Complex64;

use crate::numeric::fourier::fast_length;
use crate::size::Size;
use crate::synthesis::quantise::IndexTexels;

/// The axis of a shift.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    /// To the right.
    X,
    /// Down.
    Y,
}

impl Axis {
    /// The side of `size` along the axis.
    pub fn side(self, size: Size) -> usize {
        match self {
            Self::X => size.width,
            Self::Y => size.height,
        }
    }

    /// The squared distance of the texels at (x, y) and `shift` farther along the axis.
    pub fn squared_step(self, texels: &IndexTexels, x: usize, y: usize, shift: usize) -> u64 {
        let by = match self {
            Self::X => [shift as i64, 0],
            Self::Y => [0, shift as i64],
        };
        squared_step(texels, [x as i64, y as i64], by)
    }
}

/// The squared distance of a texel and the one `by` farther to the right and down.
pub fn squared_step(texels: &IndexTexels, [x, y]: [i64; 2], by: [i64; 2]) -> u64 {
    let run = |x: i64, y: i64| texels.run(x as usize, y as usize, 1);
    squared_distance(run(x, y), run(x + by[0], y + by[1]))
}

/// The squared distance of two texels given by their codes.
pub fn squared_distance(a: &[i16], b: &[i16]) -> u64 {
    let square = |(a, b): (&i16, &i16)| i64::from(i32::from(a - b).pow(2));
    a.iter().zip(b).map(square).sum::<i64>().unsigned_abs()
}

/// The mean squared difference under the shifts 0 to the side minus one, exact up to the rounding of the
/// transforms.
pub fn profile(texels: &IndexTexels, planes: usize, axis: Axis) -> Vec<f64> {
    let size = texels.size();
    let (side, lines) = (axis.side(size), size.texels() / axis.side(size));
    let padded = fast_length(2 * side - 1);
    let mut planner = RealFftPlanner::new();
    let (forward, back) = (planner.plan_fft_forward(padded), planner.plan_fft_inverse(padded));
    let mut power = vec![0.0; padded / 2 + 1];
    let mut squares = vec![0.0; side];
    let (mut line, mut bins) = (forward.make_input_vec(), forward.make_output_vec());
    for (number, k) in (0..lines).flat_map(|number| (0..planes).map(move |k| (number, k))) {
        line.fill(0.0);
        for (along, value) in line[..side].iter_mut().enumerate() {
            let (x, y) = if axis == Axis::X { (along, number) } else { (number, along) };
            *value = f64::from(texels.run(x, y, 1)[k]);
            squares[along] += *value * *value;
        }
        forward.process(&mut line, &mut bins).expect("the plan made the buffers");
        power.iter_mut().zip(&bins).for_each(|(sum, bin)| *sum += bin.norm_sqr());
    }
    let mut spectrum: Vec<Complex64> = power.into_iter().map(Complex64::from).collect();
    back.process(&mut spectrum, &mut line).expect("the plan made the buffers");
    let total: f64 = squares.iter().sum();
    let mut lost = 0.0;
    let mean = |shift: usize| {
        if shift > 0 {
            lost += squares[shift - 1] + squares[side - shift];
        }
        let error = 2.0 * total - lost - 2.0 * line[shift] / padded as f64;
        error.max(0.0) / ((side - shift) * lines) as f64
    };
    (0..side).map(mean).collect()
}

/// The slow truth of [`profile`]: the defining sums.
pub fn direct(texels: &IndexTexels, axis: Axis) -> Vec<f64> {
    let size = texels.size();
    let mean = |shift: usize| {
        let (width, height) = match axis {
            Axis::X => (size.width - shift, size.height),
            Axis::Y => (size.width, size.height - shift),
        };
        let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let sum: u64 = places.map(|(x, y)| axis.squared_step(texels, x, y, shift)).sum();
        sum as f64 / (width * height) as f64
    };
    (0..axis.side(size)).map(mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthesis::roller::tests::noise;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(60))]

        #[test]
        fn the_fast_profile_is_the_defining_sum(
            (width, height, planes, seed) in (1usize..24, 1usize..24, 1usize..5, any::<u64>()),
        ) {
            let exemplar = noise(Size::new(width, height), planes, seed);
            let texels = &exemplar.texels()[0];
            for axis in [Axis::X, Axis::Y] {
                let (fast, slow) = (profile(texels, planes, axis), direct(texels, axis));
                prop_assert_eq!(fast.len(), slow.len());
                for (a, b) in fast.iter().zip(&slow) {
                    prop_assert!((a - b).abs() < 1e-3, "{} against {}", a, b);
                }
            }
        }
    }
}
