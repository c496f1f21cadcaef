//! What a photograph shows that the texture relit under its light does not.

use super::error_map::squared;
use super::{LightQuality, SATURATED, SHADOW};
use crate::direction::Direction;
use crate::numeric::decibel::psnr_db;
use crate::numeric::shorth::shorth;
use crate::size::Size;

/// The greatest shift, in texels, that is tried in all directions, and the greatest that is followed as long as it gets better.
const TRIED_SHIFT: isize = 3;
const MOST_SHIFT: isize = 16;

/// A shift, or another orientation, has to lower the squared error to this share of it, if it is not one that can have other
/// reasons.
const BETTER: f64 = 0.9;
const CLEARLY_BETTER: f64 = 0.75;

/// The sine of the elevation of lights near the horizon: 30 degrees.
const LOW_LIGHT: f64 = 0.5;

/// Codes of the relit texture from which on a texel is lit well enough to compare brightnesses.
const LIT: u32 = 24;
/// A texel with less than this part of the codes of the relit one is in shadow: it has a twentieth of the light.
const DEEP_SHADOW: f64 = 0.25;
/// A photograph is black when less than one in so many texels is lit that are to be.
const BLACK: usize = 20;
/// Texels of which brightnesses are compared.
const COMPARED_TEXELS: usize = 1 << 16;

/// A relit texture and its photograph, as codes.
pub(super) struct PicturePair<'a> {
    pub relit: &'a [u8],
    pub photograph: &'a [u8],
    pub size: Size,
    pub mask: Option<&'a [bool]>,
}

impl PicturePair<'_> {
    /// The figures of the photograph, over so many texels inside the mask.
    pub fn figures(&self, name: &str, light: Direction, texels: usize) -> LightQuality {
        let (relit, photograph, size) = (self.relit, self.photograph, self.size);
        let error = squared(relit, photograph);
        let brightness = Brightness::of(relit, photograph);
        let shift = best_shift(relit, photograph, size, light.z() < LOW_LIGHT);
        let mut doubts = Vec::new();
        if shift != [0, 0] {
            doubts.push(format!("shows the surface {}: moved between photographs?", in_words(shift)));
        }
        if let Some(turn) = better_orientation(relit, photograph, size, error) {
            doubts.push(format!("fits better {turn}: another orientation than the others?"));
        }
        LightQuality {
            name: name.to_owned(),
            direction: light.to_array(),
            psnr_db: psnr_db(error as f64 / (255.0 * 255.0 * 3.0 * texels as f64)),
            shadow_share: self.share(texels, |code| code <= SHADOW),
            saturated_share: self.share(texels, |code| code >= SATURATED),
            brightness_factor: brightness.factor,
            brightness_spread: brightness.spread,
            shift,
            doubts,
        }
    }

    /// The share of the codes of the photograph inside the mask.
    fn share(&self, texels: usize, is: impl Fn(u8) -> bool) -> f64 {
        let inside = |texel: usize| self.mask.is_none_or(|mask| mask[texel]);
        let codes = self.photograph.iter().enumerate().filter(|(i, code)| is(**code) && inside(i / 3));
        codes.count() as f64 / (3 * texels) as f64
    }
}

/// A shift in words.
fn in_words([x, y]: [isize; 2]) -> String {
    let along = |by: isize, [less, more]: [&str; 2]| match by {
        0 => None,
        _ => Some(format!("{} {}", by.unsigned_abs(), if by < 0 { less } else { more })),
    };
    let parts = [along(x, ["to the left", "to the right"]), along(y, ["up", "down"])];
    format!("{} (in texels)", parts.into_iter().flatten().collect::<Vec<_>>().join(" and "))
}

/// How much brighter a photograph is than the relit texture.
struct Brightness {
    /// The factor between most of the texels that are lit in both.
    factor: f64,
    /// The natural logarithm of the ratio of the greatest to the least factor of these.
    spread: f64,
}

impl Brightness {
    /// From the half of the factors of texels that lie nearest to each other (the shorth): a longer exposure moves all factors,
    /// and shadows and highlights that only one of both has lie apart. Where most of what is lit in the relit texture is in shadow
    /// in the photograph, the rest says nothing, unless the photograph is black: then its lamp failed.
    fn of(relit: &[u8], photograph: &[u8]) -> Self {
        let sum = |texel: &[u8; 3]| texel.iter().map(|code| u32::from(*code)).sum::<u32>();
        let texels = relit.as_chunks::<3>().0.iter().zip(photograph.as_chunks::<3>().0);
        let step = (relit.len() / 3).div_ceil(COMPARED_TEXELS);
        let lit: Vec<(&[u8; 3], &[u8; 3])> =
            texels.step_by(step).filter(|(relit, _)| sum(relit) >= 3 * LIT).collect();
        let is_lit = |texel: &[u8; 3]| sum(texel) > 3 * u32::from(SHADOW);
        let in_both = lit.iter().filter(|(relit, photograph)| {
            is_lit(photograph) && f64::from(sum(photograph)) > DEEP_SHADOW * f64::from(sum(relit))
        });
        let in_both: Vec<_> = in_both.collect();
        if lit.len() > 2 * in_both.len() {
            let shown =
                photograph.as_chunks::<3>().0.iter().step_by(step).filter(|texel| is_lit(texel)).count();
            let factor = if lit.len() > BLACK * shown { 1.0 / 255.0 } else { 1.0 };
            return Self { factor, spread: 0.0 };
        }
        let is_measured = |texel: &[u8; 3]| texel.iter().all(|code| *code < SATURATED);
        let measured =
            in_both.into_iter().filter(|(relit, photograph)| is_measured(relit) && is_measured(photograph));
        let log_factor = |(relit, photograph): &(&[u8; 3], &[u8; 3])| {
            (f64::from(sum(photograph)) / f64::from(sum(relit))).ln()
        };
        let (middle, spread) = shorth(&mut measured.map(log_factor).collect::<Vec<_>>()).unwrap_or_default();
        Self { factor: middle.exp(), spread }
    }
}

/// The mean squared difference of green, of the photograph moved against the relit texture, but for a margin.
fn moved_error(relit: &[u8], photograph: &[u8], size: Size, margin: isize, [dx, dy]: [isize; 2]) -> f64 {
    let margin = margin.unsigned_abs();
    let (mut sum, mut count) = (0u64, 0u64);
    for y in margin..size.height - margin {
        for x in margin..size.width - margin {
            let from = size.index(x.wrapping_add_signed(dx), y.wrapping_add_signed(dy));
            let difference = relit[3 * size.index(x, y) + 1].abs_diff(photograph[3 * from + 1]);
            sum += u64::from(difference).pow(2);
            count += 1;
        }
    }
    sum as f64 / count as f64
}

/// The shift by which the photograph fits clearly better, and better than by any near it; or none. Where brightness changes slowly
/// the error may fall with every step, and there is no such shift.
fn best_shift(relit: &[u8], photograph: &[u8], size: Size, is_low: bool) -> [isize; 2] {
    let most = MOST_SHIFT.min(size.width.min(size.height) as isize / 8);
    if most < TRIED_SHIFT {
        return [0, 0];
    }
    let error = |shift: [isize; 2]| moved_error(relit, photograph, size, most, shift);
    let around = |[x, y]: [isize; 2], reach: isize| {
        (-reach..=reach).flat_map(move |dy| (-reach..=reach).map(move |dx| [x + dx, y + dy]))
    };
    let least = |shifts: &mut dyn Iterator<Item = [isize; 2]>| {
        let errors = shifts.filter(|s| s.iter().all(|d| d.abs() <= most)).map(|shift| (error(shift), shift));
        errors.min_by(|a, b| a.0.total_cmp(&b.0)).expect("a shift at least")
    };
    let still = error([0, 0]);
    let mut best = least(&mut around([0, 0], TRIED_SHIFT));
    loop {
        let next = least(&mut around(best.1, 1));
        if next.0 >= best.0 {
            break;
        }
        best = next;
    }
    let is_end = best.1.iter().any(|d| d.abs() == most);
    // The fit is a little blurred, which moves edges by a texel; and the shadows of a relief move with a light near the horizon.
    let is_near = best.1.iter().all(|d| d.abs() <= 1);
    let needed = if is_near { CLEARLY_BETTER } else { BETTER } * if is_low { CLEARLY_BETTER } else { 1.0 };
    if is_end || best.0 >= needed * still { [0, 0] } else { best.1 }
}

/// The orientation in which the photograph fits clearly better, or none.
fn better_orientation(relit: &[u8], photograph: &[u8], size: Size, error: u64) -> Option<&'static str> {
    let Size { width, height } = size;
    let turned = |place: &dyn Fn(usize, usize) -> usize| -> u64 {
        let texels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        texels
            .map(|(x, y)| squared(&relit[3 * size.index(x, y)..][..3], &photograph[3 * place(x, y)..][..3]))
            .sum()
    };
    let flips: [(&'static str, u64); 3] = [
        ("upside down", turned(&|x, y| size.index(width - 1 - x, height - 1 - y))),
        ("mirrored from left to right", turned(&|x, y| size.index(width - 1 - x, y))),
        ("mirrored from top to bottom", turned(&|x, y| size.index(x, height - 1 - y))),
    ];
    let best = flips.into_iter().min_by_key(|(_, error)| *error)?;
    (best.1 < (CLEARLY_BETTER * error as f64) as u64).then_some(best.0)
}
