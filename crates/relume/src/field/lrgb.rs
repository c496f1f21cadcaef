//! One function times one colour: the LRGB texel nearest to three channel functions.
//!
//! In orthonormal coordinates the three functions are the columns of an n x 3 matrix C, and the
//! nearest product l c' in the least-squares sense is its leading singular pair (Eckart, Young,
//! "The approximation of one matrix by another of lower rank", 1936). c is the leading
//! eigenvector of the 3 x 3 matrix C'C, found by squaring it repeatedly.

/// The number of squarings of C'C: the power 2^6 = 64 separates eigenvalues that differ by a few per cent;
/// closer ones give nearly equal errors for any direction between them.
const SQUARINGS: usize = 6;

/// The leading colour of a symmetric positive semi-definite 3 x 3 matrix
/// (xx, xy, xz, yy, yz, zz), not negative, its largest component 1. Black gives white.
pub fn leading_color(gram: [f32; 6]) -> [f32; 3] {
    let mut m = gram;
    for _ in 0..SQUARINGS {
        let trace = m[0] + m[3] + m[5];
        if trace <= f32::MIN_POSITIVE {
            return [1.0; 3];
        }
        let [a, b, c, d, e, f] = m.map(|v| v / trace);
        m = [
            a * a + b * b + c * c,
            a * b + b * d + c * e,
            a * c + b * e + c * f,
            b * b + d * d + e * e,
            b * c + d * e + e * f,
            c * c + e * e + f * f,
        ];
    }
    let [a, b, c, d, e, f] = m;
    let column = match (a >= d, a >= f, d >= f) {
        (true, true, _) => [a, b, c],
        (false, _, true) => [b, d, e],
        _ => [c, e, f],
    };
    normalised(column)
}

/// The colour with sign and scale such that it is not negative and its largest component is 1.
fn normalised(color: [f32; 3]) -> [f32; 3] {
    let sign = if color.iter().sum::<f32>() < 0.0 { -1.0 } else { 1.0 };
    let positive = color.map(|v| (sign * v).max(0.0));
    let largest = positive.iter().fold(0.0f32, |a, &b| a.max(b));
    if largest > 0.0 { positive.map(|v| v / largest) } else { [1.0; 3] }
}

/// The LRGB texel nearest to three functions given by their orthonormal coordinates: the coordinates of the
/// luminance are written to `luminance`, the colour is returned.
pub fn nearest_product(channels: [&[f32]; 3], luminance: &mut [f32]) -> [f32; 3] {
    let dot = |a: usize, b: usize| channels[a].iter().zip(channels[b]).map(|(x, y)| x * y).sum::<f32>();
    let color = leading_color([dot(0, 0), dot(0, 1), dot(0, 2), dot(1, 1), dot(1, 2), dot(2, 2)]);
    let norm = color.iter().map(|c| c * c).sum::<f32>();
    for (k, out) in luminance.iter_mut().enumerate() {
        *out = (0..3).map(|c| channels[c][k] * color[c]).sum::<f32>() / norm;
    }
    color
}

#[cfg(test)]
mod tests {
    use super::*;

    fn residual(channels: [&[f32]; 3], luminance: &[f32], color: [f32; 3]) -> f64 {
        let errors = (0..3).flat_map(|c| {
            luminance.iter().zip(channels[c]).map(move |(l, v)| f64::from(l * color[c] - v).powi(2))
        });
        errors.sum()
    }

    #[test]
    fn products_are_recovered() {
        let luminance = [0.4f32, -0.3, 0.9, 0.0];
        let color = [0.25f32, 1.0, 0.5];
        let channels: Vec<Vec<f32>> =
            color.iter().map(|c| luminance.iter().map(|l| l * c).collect()).collect();
        let mut found = [0.0; 4];
        let found_color = nearest_product([&channels[0], &channels[1], &channels[2]], &mut found);
        for (a, b) in found.iter().zip(luminance).chain(found_color.iter().zip(color)) {
            assert!((a - b).abs() < 1e-6);
        }
    }

    #[test]
    fn no_other_non_negative_colour_is_nearer() {
        let channels: [&[f32]; 3] = [&[0.9, 0.2, -0.1], &[0.7, 0.3, 0.0], &[0.2, 0.1, 0.3]];
        let mut luminance = [0.0; 3];
        let color = nearest_product(channels, &mut luminance);
        let best = residual(channels, &luminance, color);
        let steps = 40;
        for i in 0..=steps {
            for j in 0..=steps {
                let other = normalised([1.0, i as f32 / 20.0, j as f32 / 20.0]);
                let norm: f32 = other.iter().map(|c| c * c).sum();
                let l: Vec<f32> =
                    (0..3).map(|k| (0..3).map(|c| channels[c][k] * other[c]).sum::<f32>() / norm).collect();
                assert!(best <= residual(channels, &l, other) + 1e-7);
            }
        }
    }

    #[test]
    fn black_has_a_colour_and_a_dark_function() {
        let mut luminance = [1.0; 2];
        let color = nearest_product([&[0.0, 0.0]; 3], &mut luminance);
        assert_eq!((color, luminance), ([1.0; 3], [0.0; 2]));
    }
}
