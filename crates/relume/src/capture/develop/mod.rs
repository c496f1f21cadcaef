//! Photographs made comparable before anything is fitted to them: what differs between them should be the direction of
//! the light alone.
//!
//! Each step is optional. In this order, on linear values: the declared space of integer samples; light of the room
//! taken away (a photograph without the lamp); uneven light made even (a white card); intensities of the lamps and
//! exposures divided out; a grey patch made grey; fall-off of near lamps undone; frames moved onto each other; cropped;
//! reduced; texels outside a mask set to black. A development without steps returns its photographs as they are, in
//! the depth of their files.
//!
//! | file | content |
//! |---|---|
//! | `sample` | few texels of all photographs, for the checks |
//! | `lambert` | matt surfaces fitted to them |
//! | `reading` | whether integer samples are linear or sRGB-encoded: both are tried |
//! | `exposure` | exposures that differ |
//! | `mask` | which texels belong to the surface |
//! | `shift` | frames that moved: phase correlation of gradient magnitudes |

mod exposure;
mod lambert;
mod mask;
mod reading;
mod sample;
mod shift;
mod shift_by_light;

pub use exposure::{Exposures, LARGEST_GAIN, exposures, share_by_direction};
pub use reading::{InputSpace, ReadingCheck, check_reading};
pub use sample::{TexelSample, sample_texels};
pub use shift::{MOST_SHIFT, Shifts, shifts};

use std::sync::Arc;

use crate::error::{Error, Result};
use crate::lamps::LampPositions;
use crate::names::named;
use crate::planes::Planes;
use crate::raster::{Raster, Samples};
use crate::rect::Rect;
use crate::size::Size;
use crate::space::Space;

/// What is done with the orientations that cameras record in photographs (EXIF), which a camera that looks straight down
/// chooses by chance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum TurnedFrames {
    /// They are applied, and photographs refused that are turned unlike the first.
    #[default]
    Alike,
    /// They are applied, whatever they are.
    Apply,
    /// They are ignored.
    Ignore,
}

named!(TurnedFrames { Alike => "alike", Apply => "apply", Ignore => "ignore" });

/// The steps from photographs as stored to photographs that are fitted.
#[derive(Debug, Clone, Default)]
pub struct Development {
    /// The space of the samples, if it is not that of the convention (integers sRGB-encoded, floats linear).
    pub space: Option<Space>,
    /// A linear photograph of the light of the room, to take away.
    pub ambient: Option<Planes>,
    /// Linear photographs of a white card to divide by: one for all lamps, or one for each; see [`even_field`].
    pub flat: Vec<Arc<Planes>>,
    /// For each lamp, its strength in red, green and blue, to divide by.
    pub intensities: Vec<[f64; 3]>,
    /// For each photograph, a factor that undoes its exposure.
    pub gains: Vec<f64>,
    /// A factor for each channel that makes a grey patch grey.
    pub white: Option<[f64; 3]>,
    /// Places of lamps whose light falls off over the surface.
    pub lamps: Option<LampPositions>,
    /// For each photograph, by how many pixels (right, down) it is moved against the first.
    pub shifts: Vec<[f64; 2]>,
    /// The part to keep.
    pub crop: Option<Rect<usize>>,
    /// Squares of this many pixels become one texel; 0 and 1 leave them.
    pub reduction: usize,
    /// Of developed photographs: texels outside are set to black; see [`Development::mask_of_texels`].
    pub mask: Option<Vec<bool>>,
}

impl Development {
    /// Whether values change, so that integers become linear floats.
    pub fn changes_values(&self) -> bool {
        let lists = [self.flat.is_empty(), self.intensities.is_empty(), self.gains.is_empty()];
        let is_same = self.space.is_none()
            && self.ambient.is_none()
            && self.white.is_none()
            && self.lamps.is_none()
            && lists.iter().all(|empty| *empty)
            && self.shifts.is_empty()
            && self.reduction < 2;
        !is_same
    }

    /// Photograph `i`, developed.
    ///
    /// # Errors
    /// A white card, ambient photograph or mask of another size, a part outside, and an intensity that is not above 0.
    pub fn apply(&self, i: usize, photograph: Raster) -> Result<Raster> {
        let developed = match (self.changes_values(), self.crop) {
            (true, _) => self.evened(i, &photograph)?,
            (false, Some(part)) => photograph.crop(part.x, part.y, part.size)?,
            (false, None) => photograph,
        };
        match &self.mask {
            Some(mask) => developed.blackened(mask),
            None => Ok(developed),
        }
    }

    /// Photograph `i` in linear light, without the mask.
    fn evened(&self, i: usize, photograph: &Raster) -> Result<Raster> {
        self.size_of(photograph.size())?;
        let mut planes = linear(photograph, self.space);
        self.even_out(i, &mut planes)?;
        if let Some(&[right, down]) = self.shifts.get(i).filter(|s| **s != [0.0, 0.0]) {
            planes = shift::moved(&planes, right, down);
        }
        interleaved(&self.framed(planes)?)
    }

    /// Cropped and reduced.
    fn framed(&self, mut planes: Planes) -> Result<Planes> {
        if let Some(part) = self.crop {
            planes = planes.crop(part.x, part.y, part.size)?;
        }
        Ok(if self.reduction > 1 { planes.reduced(self.reduction) } else { planes })
    }

    /// Differences of the light undone, texel by texel.
    fn even_out(&self, i: usize, planes: &mut Planes) -> Result<()> {
        if let Some(ambient) = &self.ambient {
            check_like(planes, ambient, "the photograph of the ambient light")?;
            combine(planes, ambient, |value, room| (value - room).max(0.0));
        }
        if let Some(card) = self.flat.get(if self.flat.len() == 1 { 0 } else { i }) {
            check_like(planes, card, "the photograph of the white card")?;
            combine(planes, card, |value, card| value / card);
        }
        let strength = self.intensities.get(i).copied().unwrap_or([1.0; 3]);
        if let Some(wrong) = strength.iter().find(|s| !(**s > 0.0 && s.is_finite())) {
            return Err(Error::invalid(format!(
                "the intensity of light {} is {wrong}: expected numbers above 0",
                i + 1
            )));
        }
        let gain = self.gains.get(i).copied().unwrap_or(1.0);
        let white = self.white.unwrap_or([1.0; 3]);
        let count = planes.count();
        for c in 0..count {
            // A grey photograph has the strength of its lamp's luminance.
            let strength = if count == 1 { luminance_of(strength) } else { strength[c] };
            let factor = (gain * white[c] / strength) as f32;
            planes.plane_mut(c).iter_mut().for_each(|v| *v *= factor);
        }
        if let Some(lamps) = &self.lamps {
            undo_fall_off(planes, lamps, i);
        }
        Ok(())
    }

    /// The size of developed photographs.
    ///
    /// # Errors
    /// A reduction that leaves nothing.
    pub fn size_of(&self, whole: Size) -> Result<Size> {
        let part = self.crop.map_or(whole, |part| part.size);
        let by = self.reduction.max(1);
        let size = Size::new(part.width / by, part.height / by);
        if size.texels() == 0 {
            return Err(Error::usage(format!(
                "{part} pixels cannot be reduced by {by}: nothing would be left"
            )));
        }
        Ok(size)
    }

    /// The lamps over the texels of developed photographs.
    pub fn lamps_over_texels(&self) -> Option<LampPositions> {
        let (x, y) = self.crop.map_or((0, 0), |part| (part.x, part.y));
        self.lamps.as_ref().map(|lamps| lamps.over_part((x, y), self.reduction.max(1)))
    }
}

fn luminance_of([r, g, b]: [f64; 3]) -> f64 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// Linear planes of a photograph, whose samples are in `space`, or in that of the convention.
pub fn linear(photograph: &Raster, space: Option<Space>) -> Planes {
    let stored = photograph.samples().space();
    match space {
        Some(space) if space != stored => {
            // As stored, without a conversion.
            let mut planes = photograph.to_picture(stored).planes;
            planes.as_mut_slice().iter_mut().for_each(|v| *v = space.to_linear(*v));
            planes
        }
        _ => photograph.to_picture(Space::Linear).planes,
    }
}

/// A photograph of a white card as a field to divide by: 1 where it is as bright as in its middle part, each channel
/// by itself.
///
/// # Errors
/// A card that is black somewhere.
pub fn even_field(mut card: Planes) -> Result<Planes> {
    let size = card.size();
    let (x, y) = (size.width / 4, size.height / 4);
    let part = Size::new((size.width / 2).max(1), (size.height / 2).max(1));
    let middle = card.crop(x, y, part)?;
    for c in 0..card.count() {
        let mean = middle.plane(c).iter().map(|v| f64::from(*v)).sum::<f64>() / part.texels() as f64;
        let least = (0.02 * mean) as f32;
        if let Some(texel) = card.plane(c).iter().position(|v| !(*v > least && *v > 0.0)) {
            return Err(Error::invalid(format!(
                "the photograph of the white card is black at ({}, {}): it must show the card everywhere",
                texel % size.width,
                texel / size.width
            )));
        }
        card.plane_mut(c).iter_mut().for_each(|v| *v /= mean as f32);
    }
    Ok(card)
}

/// The factors that make a patch of developed photographs grey, with the green as it is; `patches` are the sums of its
/// channels.
///
/// # Errors
/// A patch without light in a channel.
pub fn grey_factors(sums: [f64; 3]) -> Result<[f64; 3]> {
    if sums.iter().any(|sum| !(*sum > 0.0 && sum.is_finite())) {
        return Err(Error::usage("the grey patch is black in all photographs: name another rectangle"));
    }
    Ok(sums.map(|sum| sums[1] / sum))
}

fn check_like(planes: &Planes, other: &Planes, what: &str) -> Result<()> {
    if planes.size() == other.size() && [1, planes.count()].contains(&other.count()) {
        return Ok(());
    }
    Err(Error::invalid(format!(
        "{what} is {} pixels with {} channels and the photographs {} with {}: both must be alike",
        other.size(),
        other.count(),
        planes.size(),
        planes.count()
    )))
}

fn combine(planes: &mut Planes, other: &Planes, with: impl Fn(f32, f32) -> f32) {
    for c in 0..planes.count() {
        let other = other.plane(c.min(other.count() - 1));
        planes.plane_mut(c).iter_mut().zip(other).for_each(|(v, o)| *v = with(*v, *o));
    }
}

fn undo_fall_off(planes: &mut Planes, lamps: &LampPositions, i: usize) {
    let width = planes.size().width;
    let share = |texel: usize| lamps.at(i, texel % width, texel / width).1 as f32;
    let shares: Vec<f32> = (0..planes.size().texels()).map(share).collect();
    for plane in planes.iter_mut() {
        plane.iter_mut().zip(&shares).for_each(|(v, share)| *v /= share);
    }
}

fn interleaved(planes: &Planes) -> Result<Raster> {
    let (texels, channels) = (planes.size().texels(), planes.count());
    let mut samples = Vec::with_capacity(texels * channels);
    for texel in 0..texels {
        samples.extend((0..channels).map(|c| planes.plane(c)[texel]));
    }
    Raster::new(planes.size(), channels, Samples::F32(samples))
}

#[cfg(test)]
mod tests;
