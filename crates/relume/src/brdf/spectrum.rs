//! Linear sRGB of reflectance spectra under the illuminant D65, for the standard observer of the CIE of 1931 in the
//! approximation of C. Wyman, P.-P. Sloan, P. Shirley, "Simple Analytic Approximations to the CIE XYZ Color Matching
//! Functions", Journal of Computer Graphics Techniques 2(2), 2013, equation 4: within 0.02 of the tables.

/// The first wavelength of the illuminant, in nm.
const FIRST: usize = 360;
/// The last.
const LAST: usize = 830;

/// The relative power of D65 from 360 to 830 nm in steps of 10 nm (CIE 15:2018, table 1).
const D65: [f64; 48] = [
    46.6383, 52.0891, 49.9755, 54.6482, 82.7549, 91.4860, 93.4318, 86.6823, 104.865, 117.008, 117.812,
    114.861, 115.923, 108.811, 109.354, 107.802, 104.790, 107.689, 104.405, 104.046, 100.000, 96.3342,
    95.7880, 88.6856, 90.0062, 89.5991, 87.6987, 83.2886, 83.6992, 80.0268, 80.2146, 82.2778, 78.2842,
    69.7213, 71.6091, 74.3490, 61.6040, 69.8856, 75.0870, 63.5927, 46.4182, 66.8054, 63.3828, 64.3040,
    59.4519, 51.9590, 57.4406, 60.3125,
];

/// XYZ of white under D65, with which sRGB is defined.
const WHITE: [f64; 3] = [0.95047, 1.0, 1.08883];

/// From XYZ to linear sRGB (B. Lindbloom, "RGB/XYZ Matrices").
const RGB_FROM_XYZ: [[f64; 3]; 3] = [
    [3.2404542, -1.5371385, -0.4985314],
    [-0.9692660, 1.8760108, 0.0415560],
    [0.0556434, -0.2040259, 1.0572252],
];

/// The weights of the samples of a reflectance spectrum in linear red, green and blue, where a reflectance of 1 is
/// white. Wavelengths are in nm and ascend; reflectances are interpolated linearly between them and constant beyond.
///
/// # Panics
/// Without a wavelength.
pub fn rgb_weights(wavelengths_nm: &[f32]) -> Vec<[f64; 3]> {
    assert!(!wavelengths_nm.is_empty(), "a spectrum has wavelengths");
    let mut weights = vec![[0.0; 3]; wavelengths_nm.len()];
    let mut white = [0.0; 3];
    for nm in FIRST..=LAST {
        let nm = nm as f64;
        let (i, share) = between(wavelengths_nm, nm);
        for ((c, matched), white) in matching(nm).into_iter().enumerate().zip(&mut white) {
            let power = illuminant(nm) * matched;
            *white += power;
            weights[i][c] += (1.0 - share) * power;
            if share > 0.0 {
                weights[i + 1][c] += share * power;
            }
        }
    }
    let rgb = |xyz: [f64; 3]| {
        let xyz: [f64; 3] = std::array::from_fn(|c| xyz[c] / white[c] * WHITE[c]);
        RGB_FROM_XYZ.map(|row| row.iter().zip(xyz).map(|(m, v)| m * v).sum())
    };
    weights.into_iter().map(rgb).collect()
}

/// The sample at or before a wavelength, and the share of the next.
fn between(wavelengths: &[f32], nm: f64) -> (usize, f64) {
    let after = wavelengths.partition_point(|&w| f64::from(w) <= nm);
    if after == 0 || after == wavelengths.len() {
        return (after.saturating_sub(1), 0.0);
    }
    let (a, b) = (f64::from(wavelengths[after - 1]), f64::from(wavelengths[after]));
    (after - 1, (nm - a) / (b - a))
}

fn illuminant(nm: f64) -> f64 {
    let step = (nm - FIRST as f64) / 10.0;
    let i = (step as usize).min(D65.len() - 2);
    let share = step - i as f64;
    D65[i] * (1.0 - share) + D65[i + 1] * share
}

/// The three matching functions.
fn matching(nm: f64) -> [f64; 3] {
    let lobe = |height: f64, center: f64, below: f64, above: f64| {
        let t = (nm - center) * if nm < center { below } else { above };
        height * (-0.5 * t * t).exp()
    };
    [
        lobe(0.362, 442.0, 0.0624, 0.0374)
            + lobe(1.056, 599.8, 0.0264, 0.0323)
            + lobe(-0.065, 501.1, 0.0490, 0.0382),
        lobe(0.821, 568.8, 0.0213, 0.0247) + lobe(0.286, 530.9, 0.0613, 0.0322),
        lobe(1.217, 437.0, 0.0845, 0.0278) + lobe(0.681, 459.0, 0.0385, 0.0725),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Entries of the table of the CIE.
    #[test]
    fn matching_functions_are_near_the_tables() {
        let table = [
            (450.0, [0.3362, 0.0380, 1.77211]),
            (500.0, [0.0049, 0.3230, 0.2720]),
            (550.0, [0.43345, 0.99495, 0.00875]),
            (600.0, [1.0622, 0.6310, 0.0008]),
            (650.0, [0.2835, 0.1070, 0.0]),
        ];
        for (nm, expected) in table {
            for (found, expected) in matching(nm).into_iter().zip(expected) {
                assert!((found - expected).abs() < 0.025, "{nm}: {found} {expected}");
            }
        }
    }

    #[test]
    fn a_white_reflectance_is_white_at_any_sampling() {
        for count in [1usize, 2, 16, 195] {
            let step = 640.0 / count as f32;
            let wavelengths: Vec<f32> = (0..count).map(|i| 360.0 + step * i as f32).collect();
            for c in 0..3 {
                let sum: f64 = rgb_weights(&wavelengths).iter().map(|weights| weights[c]).sum();
                assert!((sum - 1.0).abs() < 1e-6, "{count}: {sum}");
            }
        }
    }

    #[test]
    fn the_white_of_the_illuminant_is_near_that_of_srgb() {
        let mut xyz = [0.0; 3];
        for nm in FIRST..=LAST {
            let power = illuminant(nm as f64);
            xyz.iter_mut().zip(matching(nm as f64)).for_each(|(sum, m)| *sum += power * m);
        }
        for c in 0..3 {
            assert!((xyz[c] / xyz[1] - WHITE[c]).abs() < 0.015, "{:?}", xyz.map(|v| v / xyz[1]));
        }
    }

    #[test]
    fn long_waves_are_red_and_short_ones_blue() {
        let wavelengths: Vec<f32> = (36..=83).map(|i| 10.0 * i as f32).collect();
        let weights = rgb_weights(&wavelengths);
        let of = |from: f32, to: f32| {
            let inside = wavelengths.iter().zip(&weights).filter(|(w, _)| (from..to).contains(*w));
            inside.fold([0.0; 3], |sum: [f64; 3], (_, w)| std::array::from_fn(|c| sum[c] + w[c]))
        };
        let ([r, g, b], blue) = (of(600.0, 830.0), of(360.0, 480.0));
        assert!(r > 0.5 && g < 0.3 && b < 0.1, "{r} {g} {b}");
        assert!(blue[2] > 0.5 && blue[0] < 0.3 && blue[1] < 0.1, "{blue:?}");
    }
}
