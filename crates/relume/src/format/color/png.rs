//! The colour chunks of PNG, by their precedence (W3C PNG, third edition, 4.3): `cICP`, `iCCP`, `sRGB`, then
//! `gAMA` with `cHRM`.

use std::io::Cursor;

use super::ColorTag;
use super::space::ColorSpace;

/// Powers and chromaticities that stand for sRGB: what encoders write for it, and rounding.
const NEAR_POWER: f32 = 0.05;
const NEAR_CHROMATICITY: f32 = 0.005;

const WHITE: [f32; 2] = [0.3127, 0.3290];
const REC709: [[f32; 2]; 3] = [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06]];

/// What the chunks of a PNG file say. A file that cannot be read says nothing here: its texels will not be
/// read either.
pub(in crate::format) fn tag_of_png(bytes: &[u8]) -> ColorTag {
    let Ok(reader) = ::png::Decoder::new(Cursor::new(bytes)).read_info() else { return ColorTag::Silent };
    let info = reader.info();
    if let Some(points) = &info.coding_independent_code_points {
        if !points.is_video_full_range_image {
            return ColorTag::Unusable("it is of narrow range".to_owned());
        }
        return tagged(ColorSpace::of_code_points(points.color_primaries, points.transfer_function));
    }
    if let Some(profile) = &info.icc_profile {
        return ColorTag::of_icc(profile);
    }
    if has_profile(bytes) {
        return ColorTag::Unusable("it is damaged".to_owned());
    }
    if info.srgb.is_some() {
        return ColorTag::Silent;
    }
    let gamma = info.gama_chunk.map(|gamma| gamma.into_value()).filter(|gamma| *gamma > 0.0);
    let pair = |(x, y): (::png::ScaledFloat, ::png::ScaledFloat)| [x.into_value(), y.into_value()];
    let primaries = info.chrm_chunk.map(|c| (pair(c.white), [pair(c.red), pair(c.green), pair(c.blue)]));
    of_gamma(gamma, primaries)
}

fn tagged(space: Result<ColorSpace, String>) -> ColorTag {
    match space {
        Ok(space) if space.is_near_srgb() => ColorTag::Silent,
        Ok(space) => ColorTag::Space(space),
        Err(reason) => ColorTag::Unusable(reason),
    }
}

/// What an encoding power, a white and primaries say.
fn of_gamma(gamma: Option<f32>, chromaticities: Option<([f32; 2], [[f32; 2]; 3])>) -> ColorTag {
    let power = gamma.map(|gamma| 1.0 / gamma).filter(|power| (power / 2.2 - 1.0).abs() > NEAR_POWER);
    let (white, primaries) = chromaticities.unwrap_or((WHITE, REC709));
    let near = |a: [f32; 2], b: [f32; 2]| (0..2).all(|k| (a[k] - b[k]).abs() <= NEAR_CHROMATICITY);
    let is_rec709 = near(white, WHITE) && (0..3).all(|c| near(primaries[c], REC709[c]));
    if is_rec709 && power.is_none() {
        return ColorTag::Silent;
    }
    let curve = power.map_or("the curve of sRGB".to_owned(), |power| format!("the power {power:.2}"));
    let of = if is_rec709 { "the primaries of sRGB" } else { "primaries of its own" };
    tagged(ColorSpace::of_primaries(white, primaries, power, format!("{of}, {curve}")))
}

/// Whether a file has a profile, which a decoder leaves out if it is damaged.
fn has_profile(bytes: &[u8]) -> bool {
    let mut at = 8;
    while let Some(&[a, b, c, d, ref kind @ ..]) = bytes.get(at..at + 8) {
        match kind {
            b"iCCP" => return true,
            b"IDAT" => return false,
            _ => at = at.saturating_add(u32::from_be_bytes([a, b, c, d]) as usize).saturating_add(12),
        }
    }
    false
}
