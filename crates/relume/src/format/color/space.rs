//! An RGB colour space of three curves and a matrix (ICC.1:2022, F.3), and its conversion to sRGB.

use std::sync::Arc;

use crate::parallel;
use crate::space::Space;
use moxcms::{
    CicpColorPrimaries, CicpProfile, ColorPrimaries, ColorProfile, DataColorSpace, MatrixCoefficients,
    ProfileText, ToneReprCurve, TransferCharacteristics, XyY,
};

/// From an encoded to a linear value.
type Curve = Arc<dyn Fn(f32) -> f32 + Send + Sync>;

/// A colour space.
pub(in crate::format) struct ColorSpace {
    name: String,
    curves: [Curve; 3],
    /// From its linear values to those of sRGB.
    matrix: [[f64; 3]; 3],
}

/// The largest difference in 8-bit codes from sRGB that counts as none: small profiles of sRGB approximate its
/// curve by fewer points.
const NEAR: f32 = 2.0 / 255.0;
/// Texels that one thread converts together.
const TOGETHER: usize = 1 << 12;

impl ColorSpace {
    /// The space of an ICC profile, or the reason why it is not applied.
    pub(super) fn of_icc(bytes: &[u8]) -> Result<Self, String> {
        let profile = ColorProfile::new_from_slice(bytes).map_err(|_| "it is damaged".to_owned())?;
        let name = name_of(&profile).unwrap_or_else(|| "without a name".to_owned());
        match profile.color_space {
            DataColorSpace::Rgb => Self::of_profile(&profile, name),
            DataColorSpace::Gray => {
                let curve = curve(profile.gray_trc.as_ref(), &name)?;
                Ok(Self { name, curves: [curve.clone(), curve.clone(), curve], matrix: IDENTITY })
            }
            DataColorSpace::Cmyk => Err(format!("'{name}' describes CMYK colours, not RGB")),
            _ => Err(format!("'{name}' describes neither RGB nor grey")),
        }
    }

    /// The space of three code points of ITU-T H.273.
    pub(super) fn of_code_points(primaries: u8, transfer: u8) -> Result<Self, String> {
        let unknown = || format!("the code points {primaries} and {transfer} name no space that is read");
        let transfer_characteristics = TransferCharacteristics::try_from(transfer).map_err(|_| unknown())?;
        // PQ and HLG: brightness beyond white has no place in sRGB.
        if matches!(transfer, 16 | 18) {
            return Err("it is of high dynamic range".to_owned());
        }
        let profile = ColorProfile::new_from_cicp(CicpProfile {
            color_primaries: CicpColorPrimaries::try_from(primaries).map_err(|_| unknown())?,
            transfer_characteristics,
            matrix_coefficients: MatrixCoefficients::Identity,
            full_range: true,
        });
        Self::of_profile(&profile, format!("code points {primaries} and {transfer}")).map_err(|_| unknown())
    }

    /// The space of given primaries and white (x and y of each), and of a power; without a power the curve of
    /// sRGB.
    pub(super) fn of_primaries(
        white: [f32; 2],
        primaries: [[f32; 2]; 3],
        gamma: Option<f32>,
        name: String,
    ) -> Result<Self, String> {
        let [red, green, blue] = primaries.map(|[x, y]| moxcms::Chromaticity { x, y });
        let mut profile = ColorProfile::new_srgb();
        let white = XyY { x: white[0].into(), y: white[1].into(), yb: 1.0 };
        profile.update_rgb_colorimetry(white, ColorPrimaries { red, green, blue });
        let mut space = Self::of_profile(&profile, name)?;
        if let Some(gamma) = gamma {
            let curve: Curve = Arc::new(move |value: f32| value.powf(gamma));
            space.curves = [curve.clone(), curve.clone(), curve];
        }
        Ok(space)
    }

    fn of_profile(profile: &ColorProfile, name: String) -> Result<Self, String> {
        let curves = [&profile.red_trc, &profile.green_trc, &profile.blue_trc];
        let [red, green, blue] = curves.map(|trc| curve(trc.as_ref(), &name));
        let matrix = profile.transform_matrix(&ColorProfile::new_srgb()).v;
        if !matrix.as_flattened().iter().all(|v| v.is_finite()) || matrix == [[0.0; 3]; 3] {
            return Err(format!("'{name}' is damaged"));
        }
        Ok(Self { name, curves: [red?, green?, blue?], matrix })
    }

    /// Its name in its file.
    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// Whether colours in it have all but the codes of sRGB.
    pub(super) fn is_near_srgb(&self) -> bool {
        let steps = || (0..=17u16).map(|k| f32::from(k * 15) / 255.0);
        let colors = steps().flat_map(|r| steps().flat_map(move |g| steps().map(move |b| [r, g, b])));
        let mut differences = colors.flat_map(|color| {
            let linear = std::array::from_fn(|c| (self.curves[c])(color[c]));
            let found = self.encoded(linear);
            (0..3).map(move |c| (found[c] - color[c]).abs())
        });
        differences.all(|difference| difference <= NEAR)
    }

    /// A linear colour of this space, sRGB-encoded; colours outside sRGB are clamped.
    fn encoded(&self, linear: [f32; 3]) -> [f32; 3] {
        let [r, g, b] = linear.map(f64::from);
        self.matrix
            .map(|row| Space::Srgb.from_linear((row[0] * r + row[1] * g + row[2] * b).clamp(0.0, 1.0) as f32))
    }

    /// Codes of one or three channels, of which `most` is white, in sRGB.
    pub(super) fn convert<T: Copy + Send + Sync + Into<u32> + TryFrom<u32>>(
        &self,
        codes: &[T],
        channels: usize,
        most: u32,
    ) -> Vec<T> {
        let table = |curve: &Curve| -> Vec<f32> {
            (0..=most).map(|code| curve((f64::from(code) / f64::from(most)) as f32)).collect()
        };
        let tables = self.curves.each_ref().map(table);
        let code = |value: f32| {
            let rounded = (f64::from(value) * f64::from(most) + 0.5) as u32;
            T::try_from(rounded.min(most)).ok().expect("a code of the same depth")
        };
        let linear = |texel: &[T]| -> [f32; 3] {
            std::array::from_fn(|c| tables[c][texel[c.min(channels - 1)].into() as usize])
        };
        let mut out = codes.to_vec();
        let convert = |texel: &mut [T]| {
            let encoded = self.encoded(linear(texel));
            // Equal channels stay equal up to rounding; green stands for all of grey.
            let of = |c: usize| if channels == 1 { encoded[1] } else { encoded[c] };
            texel.iter_mut().enumerate().for_each(|(c, sample)| *sample = code(of(c)));
        };
        parallel::for_each(out.chunks_mut(TOGETHER * channels), |texels| {
            texels.chunks_exact_mut(channels).for_each(convert);
        });
        out
    }
}

const IDENTITY: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

fn curve(trc: Option<&ToneReprCurve>, name: &str) -> Result<Curve, String> {
    let trc = trc.ok_or_else(|| format!("'{name}' describes colours by tables, which are not read"))?;
    let evaluator = trc.make_linear_evaluator().map_err(|_| format!("'{name}' is damaged"))?;
    Ok(Arc::new(move |value| evaluator.evaluate_value(value)))
}

/// The name of a profile, as printable text.
fn name_of(profile: &ColorProfile) -> Option<String> {
    let name = match profile.description.as_ref()? {
        ProfileText::PlainString(text) => text,
        ProfileText::Localizable(texts) => &texts.first()?.value,
        ProfileText::Description(text) => &text.ascii_string,
    };
    let name: String = name.chars().filter(|c| !c.is_control()).take(60).collect();
    (!name.trim().is_empty()).then(|| name.trim().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of_points(primaries: u8, transfer: u8) -> ColorSpace {
        ColorSpace::of_code_points(primaries, transfer).unwrap()
    }

    #[test]
    fn srgb_by_any_name_is_near_itself_and_others_are_not() {
        let white = [0.3127, 0.3290];
        let rec709 = [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06]];
        assert!(of_points(1, 13).is_near_srgb());
        assert!(ColorSpace::of_primaries(white, rec709, None, String::new()).unwrap().is_near_srgb());
        assert!(!ColorSpace::of_primaries(white, rec709, Some(1.0), String::new()).unwrap().is_near_srgb());
        assert!(!of_points(12, 13).is_near_srgb() && !of_points(1, 8).is_near_srgb());
        assert!(ColorSpace::of_code_points(9, 16).is_err() && ColorSpace::of_code_points(0, 13).is_err());
    }

    #[test]
    fn display_p3_becomes_srgb() {
        // By the primaries of both (SMPTE RP 431-2, Rec. 709), with the same white and curve.
        let codes = of_points(12, 13).convert(&[52428u16, 26214, 13107, 1000, 1000, 1000], 3, 65535);
        for (code, expected) in codes.iter().zip([0.85957, 0.37040, 0.12343, 0.01526, 0.01526, 0.01526]) {
            let found = f32::from(*code) / 65535.0;
            assert!((found - expected).abs() < 1e-3, "{found} {expected}");
        }
    }

    #[test]
    fn greys_follow_their_curve() {
        let linear = of_points(1, 8);
        let codes = linear.convert(&[0u8, 55, 128, 255], 1, 255);
        let expected =
            [0, 55, 128, 255].map(|v| (Space::Srgb.from_linear(v as f32 / 255.0) * 255.0).round() as u8);
        assert_eq!(codes, expected);
    }
}
