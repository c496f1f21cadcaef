//! The colour models of `.btf` files: how RGB comes from the channels that are factored.

use super::source::BtfCursor;
use crate::error::{Error, Result};

/// Added before logarithms are taken, so that black has one.
pub(super) const EPSILON: f32 = 1e-5;

/// From YUV to RGB.
const RGB_FROM_YUV: [[f32; 3]; 3] = [[1.0, 0.0, 1.13983], [1.0, -0.39465, -0.5806], [1.0, 2.03211, 0.0]];
/// From YCoCg to RGB.
const RGB_FROM_YCOCG: [[f32; 3]; 3] = [[1.0, 1.0, -1.0], [1.0, 0.0, 1.0], [1.0, -1.0, -1.0]];
const IDENTITY: [[f32; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// From XYZ under D50, the white of Lab in ICC profiles, to linear sRGB (B. Lindbloom, "RGB/XYZ Matrices", sRGB
/// with adaptation by Bradford's method).
const RGB_FROM_XYZ_D50: [[f32; 3]; 3] = [
    [3.133_856, -1.616_866_7, -0.490_614_6],
    [-0.978_768_4, 1.916_141_5, 0.033_454],
    [0.071_945_3, -0.228_991_4, 1.405_242_7],
];
/// XYZ of white under D50 (ICC.1:2022, 6.3.4.3).
const WHITE_D50: [f32; 3] = [0.9642, 1.0, 0.8249];

/// A colour model, with the number that files give it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum BtfColorModel {
    /// 0: the channels themselves.
    Rgb,
    /// 1: luminance and two differences.
    Yuv,
    /// 2: CIELAB under D50.
    Lab,
    /// 3: scores of a principal component analysis, of which `matrix` has a row for each: RGB is their weighted sum
    /// plus the mean.
    Pca {
        /// Added to each channel.
        mean: [f32; 3],
        /// Row i is the colour of score i.
        matrix: [[f32; 3]; 3],
    },
    /// 4: luminance, orange and green.
    YCoCg,
    /// 5: the sum of all channels, and the shares of all but the first.
    Spectral,
    /// 6: as the usual library decodes it, from the mean of all channels.
    SpectralLinear,
    /// 9: YUV with the logarithm of the luminance.
    LogYuv,
    /// 10: YUV with logarithms of all three.
    LogYLogULogV,
    /// 11: YUV with the logarithm of the luminance and the differences over the luminance; the usual one.
    LogYRatios,
    /// 12: the logarithm of each channel.
    LogRgb,
}

impl BtfColorModel {
    /// Reads the number, the mean and the matrix.
    pub(super) fn read(cursor: &mut BtfCursor, channels: usize) -> Result<Self> {
        const WHAT: &str = "the colour model";
        let number = cursor.u32(WHAT)?;
        let mut numbers = [0.0; 12];
        for value in &mut numbers {
            *value = cursor.f32(WHAT)?;
        }
        let model = Self::of_number(number, &numbers)?;
        if model.needs_three() && channels != 3 {
            return Err(Error::invalid(format!(
                "the colour model {number} of the BTF file is one of three channels, and it has {channels}"
            )));
        }
        Ok(model)
    }

    fn of_number(number: u32, numbers: &[f32; 12]) -> Result<Self> {
        Ok(match number {
            0 => Self::Rgb,
            1 => Self::Yuv,
            2 => Self::Lab,
            3 if numbers.iter().all(|number| number.is_finite()) => Self::Pca {
                mean: [numbers[0], numbers[1], numbers[2]],
                matrix: std::array::from_fn(|r| std::array::from_fn(|c| numbers[3 + 3 * r + c])),
            },
            3 => {
                return Err(Error::invalid(
                    "the colour matrix of the BTF file is not finite: the file is damaged",
                ));
            }
            4 => Self::YCoCg,
            5 => Self::Spectral,
            6 => Self::SpectralLinear,
            9 => Self::LogYuv,
            10 => Self::LogYLogULogV,
            11 => Self::LogYRatios,
            12 => Self::LogRgb,
            _ => {
                return Err(Error::unsupported(format!(
                    "the colour model {} of the BTF file is not read: expected 0 to 6 or 9 to 12",
                    number.cast_signed()
                )));
            }
        })
    }

    /// The number in files.
    pub fn number(self) -> u32 {
        match self {
            Self::Rgb => 0,
            Self::Yuv => 1,
            Self::Lab => 2,
            Self::Pca { .. } => 3,
            Self::YCoCg => 4,
            Self::Spectral => 5,
            Self::SpectralLinear => 6,
            Self::LogYuv => 9,
            Self::LogYLogULogV => 10,
            Self::LogYRatios => 11,
            Self::LogRgb => 12,
        }
    }

    fn needs_three(self) -> bool {
        !matches!(self, Self::Rgb | Self::Spectral | Self::SpectralLinear | Self::LogRgb)
    }

    /// Where RGB is a matrix times the channels plus a mean: both, for three channels.
    pub(super) fn affine(self) -> Option<([[f32; 3]; 3], [f32; 3])> {
        match self {
            Self::Rgb => Some((IDENTITY, [0.0; 3])),
            Self::Yuv => Some((RGB_FROM_YUV, [0.0; 3])),
            Self::YCoCg => Some((RGB_FROM_YCOCG, [0.0; 3])),
            Self::Pca { mean, matrix } => {
                Some((std::array::from_fn(|r| std::array::from_fn(|c| matrix[c][r])), mean))
            }
            _ => None,
        }
    }

    /// RGB, or the named channels, in place of the channels of one texel.
    pub(super) fn decode(self, v: &mut [f32]) {
        match self {
            Self::Rgb => {}
            Self::Yuv | Self::YCoCg | Self::Pca { .. } => {
                let (matrix, mean) = self.affine().expect("these are affine");
                apply(&matrix, v);
                v.iter_mut().zip(mean).for_each(|(v, mean)| *v += mean);
            }
            Self::Lab => rgb_of_lab(v),
            Self::Spectral => spectral(v),
            Self::SpectralLinear => spectral_linear(v),
            Self::LogYuv => {
                v[0] = v[0].exp() - EPSILON;
                apply(&RGB_FROM_YUV, v);
            }
            Self::LogYLogULogV => {
                v[0] = v[0].exp() - EPSILON;
                v[1..].iter_mut().for_each(|v| *v = sign(*v) * (v.abs() + EPSILON.ln()).exp());
                apply(&RGB_FROM_YUV, v);
            }
            Self::LogYRatios => {
                let luminance = v[0].exp();
                v[0] = luminance - EPSILON;
                v[1..].iter_mut().for_each(|v| *v *= luminance);
                apply(&RGB_FROM_YUV, v);
            }
            Self::LogRgb => v.iter_mut().for_each(|v| *v = v.exp() - EPSILON),
        }
    }

    /// The channels of model 11 of a colour, whose luminance may not be below 0: the inverse of decoding.
    pub fn log_ratios_of([r, g, b]: [f32; 3]) -> [f32; 3] {
        // Rows of the inverse of the matrix above, to the digits of `f32`.
        let [r, g, b] = [f64::from(r), f64::from(g), f64::from(b)];
        let [v_r, u_b] = [1.139_83, 2.032_11];
        let [u_g, v_g] = [-0.394_65, -0.580_6];
        // Y = R - v_r V = B - u_b U = G - u_g U - v_g V.
        let y = (g - u_g * b / u_b - v_g * r / v_r) / (1.0 - u_g / u_b - v_g / v_r);
        let epsilon = f64::from(EPSILON);
        let luminance = y.max(0.0) + epsilon;
        [luminance.ln(), (b - y) / u_b / luminance, (r - y) / v_r / luminance].map(|v| v as f32)
    }
}

/// The sign, which for 0 is 0.
fn sign(v: f32) -> f32 {
    if v == 0.0 { 0.0 } else { v.signum() }
}

fn apply(matrix: &[[f32; 3]; 3], v: &mut [f32]) {
    let by = [v[0], v[1], v[2]];
    for (out, row) in v.iter_mut().zip(matrix) {
        *out = row[0] * by[0] + row[1] * by[1] + row[2] * by[2];
    }
}

/// Linear sRGB of L, a, b (CIE 15:2018, 8.2.1).
fn rgb_of_lab(v: &mut [f32]) {
    const BEND: f32 = 6.0 / 29.0;
    let fy = (v[0] + 16.0) / 116.0;
    let cube = |t: f32| if t > BEND { t * t * t } else { 3.0 * BEND * BEND * (t - 4.0 / 29.0) };
    let relative = [cube(fy + v[1] / 500.0), cube(fy), cube(fy - v[2] / 200.0)];
    v.iter_mut().zip(relative).zip(WHITE_D50).for_each(|((v, relative), white)| *v = relative * white);
    apply(&RGB_FROM_XYZ_D50, v);
}

fn spectral(v: &mut [f32]) {
    let (sum, mut first) = (v[0], 1.0);
    for share in &mut v[1..] {
        first -= *share;
        *share *= sum;
    }
    v[0] = first * sum;
}

fn spectral_linear(v: &mut [f32]) {
    let count = v.len() as f32;
    let sum = v[0] * count;
    let mut first = sum;
    for other in &mut v[1..] {
        first -= *other / count;
        *other = sum + *other * sum;
    }
    v[0] = first;
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decoded(model: BtfColorModel, channels: &[f32]) -> Vec<f32> {
        let mut v = channels.to_vec();
        model.decode(&mut v);
        v
    }

    fn assert_near(found: &[f32], expected: &[f32]) {
        assert_within(2e-5, found, expected);
    }

    fn assert_within(tolerance: f32, found: &[f32], expected: &[f32]) {
        let near = found.iter().zip(expected).all(|(f, e)| (f - e).abs() < tolerance * (1.0 + e.abs()));
        assert!(near && found.len() == expected.len(), "{found:?} {expected:?}");
    }

    /// Values worked out by hand from the definitions.
    #[test]
    fn every_model_decodes_to_the_values_of_its_definition() {
        use BtfColorModel as Model;
        assert_near(&decoded(Model::Rgb, &[0.1, 2.0, -3.0, 4.0]), &[0.1, 2.0, -3.0, 4.0]);
        assert_near(&decoded(Model::Yuv, &[0.5, 0.1, -0.2]), &[0.272_034, 0.576_655, 0.703_211]);
        assert_near(&decoded(Model::YCoCg, &[0.5, 0.1, -0.2]), &[0.8, 0.3, 0.6]);
        // The white of the profile connection space is rounded to four digits, and the matrix is not.
        assert_within(5e-4, &decoded(Model::Lab, &[100.0, 0.0, 0.0]), &[1.0, 1.0, 1.0]);
        // Middle grey has a fifth of the light: ((50 + 16) / 116)^3.
        assert_within(5e-4, &decoded(Model::Lab, &[50.0, 0.0, 0.0]), &[0.184_187; 3]);
        let matrix = [[1.0, 2.0, 3.0], [0.0, 1.0, 0.0], [4.0, 0.0, 0.0]];
        let pca = Model::Pca { mean: [10.0, 20.0, 30.0], matrix };
        assert_near(&decoded(pca, &[1.0, 2.0, 0.5]), &[13.0, 24.0, 33.0]);
        assert_near(&decoded(Model::Spectral, &[4.0, 0.25, 0.5, 0.125]), &[0.5, 1.0, 2.0, 0.5]);
        assert_near(&decoded(Model::SpectralLinear, &[0.5, 0.25, -0.5]), &[1.583_333, 1.875, 0.75]);
        let y = (0.5f32 + EPSILON).ln();
        let rgb = [0.272_034, 0.576_655, 0.703_211];
        assert_near(&decoded(Model::LogYuv, &[y, 0.1, -0.2]), &rgb);
        let logs = [y, (0.1f32 / EPSILON).ln(), -(0.2f32 / EPSILON).ln()];
        assert_near(&decoded(Model::LogYLogULogV, &logs), &rgb);
        let ratios = [y, 0.1 / (0.5 + EPSILON), -0.2 / (0.5 + EPSILON)];
        assert_near(&decoded(Model::LogYRatios, &ratios), &rgb);
        assert_near(&decoded(Model::LogRgb, &[0.0, 1.0]), &[1.0 - EPSILON, 1f32.exp() - EPSILON]);
    }

    #[test]
    fn the_channels_of_a_colour_decode_to_it() {
        for color in [[0.2, 0.5, 0.9], [3.0, 0.01, 0.4], [0.0, 0.0, 0.0], [1.0, 1.0, 1.0]] {
            let channels = BtfColorModel::log_ratios_of(color);
            assert_near(&decoded(BtfColorModel::LogYRatios, &channels), &color);
        }
    }

    #[test]
    fn numbers_name_models_and_others_are_refused() {
        let numbers = [0.5; 12];
        for number in (0..7).chain(9..13) {
            assert_eq!(BtfColorModel::of_number(number, &numbers).unwrap().number(), number);
        }
        for number in [7, 8, 13, u32::MAX] {
            let message = BtfColorModel::of_number(number, &numbers).unwrap_err().to_string();
            assert!(message.contains(&number.cast_signed().to_string()), "{message}");
        }
        assert!(BtfColorModel::of_number(3, &[f32::NAN; 12]).is_err());
    }
}
