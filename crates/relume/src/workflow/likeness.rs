//! Whether the textures made by a model look like the material, decided from a made sample.
//!
//! The sample is compared with the texture by five of the measures of `docs/measures.md`. Their values mean
//! little alone: they depend on the material and its size. So the halves of the texture are compared with each
//! other, which tells how much samples of this material differ, and the texture with its own texels in random
//! order, which is what is left without any model. Functions of light are compared under one oblique light.

use std::fmt;

use serde::Serialize;

use super::trend::PLAIN_TREND;
use crate::analysis::trend;
use crate::direction::Direction;
use crate::error::Result;
use crate::field::{Basis, ReflectanceField};
use crate::job::Job;
use crate::metric::texture::{SlicedOptions, appearance, correlation, detail, histogram, sliced, steerable};
use crate::numeric::random::{Purpose, Stream};
use crate::planes::Planes;
use crate::random_field::{FieldModel, RealisationOptions};
use crate::rect::Rect;
use crate::render::relight;
use crate::size::Size;
use crate::space::Space;

/// The least side of textures whose halves can be compared.
pub const LEAST_SIDE: usize = 32;
/// The least side of textures whose halves differ so little that what is not like them does not pass.
pub const SURE_SIDE: usize = 128;
/// The largest side compared, in texels: a cut from the middle of larger textures.
const MOST_SIDE: usize = 256;
/// The seed of the sample: not that of the reference window, on which models are adjusted.
const SAMPLE_SEED: u64 = 1;
/// Fewer patches and directions than to compare methods: the differences that decide are large.
const PATCHES: SlicedOptions = SlicedOptions { patch: 7, levels: 5, directions: 16, patches: 4096, seed: 0 };

/// How many of a texture's measures there are.
const KINDS: usize = 5;
/// How often the distance between halves that of a sample may be: patches, shapes, autocorrelation, histogram and
/// detail. From `docs/models.md`.
const TOLERANCES: [f64; KINDS] = [1.5, 2.5, 2.0, 2.0, 2.0];
/// Distances between halves below these are taken for these: they are smaller than the eye sees.
const FLOORS: [f64; KINDS] = [0.03, 0.012, 0.03, 0.05, 0.07];
/// Steps between neighbours, over all channels, that count as none: beside the edges of a texture they are hardly seen.
const FAINT_STEP: f64 = 8.0 / 255.0;
/// The share of the way to shuffled texels beyond which nothing is alike, whatever the halves.
const MOST_OF_THE_WAY: f64 = 0.5;

/// Distances between two textures; see `docs/measures.md`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LikenessMeasures {
    /// Distributions of patches at several scales.
    pub patches: f64,
    /// Edges, lines and local order: 1 - STSIM-2 of the lightness.
    pub shapes: f64,
    /// Autocorrelations.
    pub autocorrelation: f64,
    /// Distributions of values.
    pub histogram: f64,
    /// Distributions of the steps between neighbours: grain where the material is smooth, and edges that are lost.
    pub detail: f64,
}

/// The likeness of a made sample, and what it is judged by.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Likeness {
    /// The distances of the sample from the texture.
    pub made: LikenessMeasures,
    /// The mean distances between the halves of the texture.
    pub halves: LikenessMeasures,
    /// The patch distance of the shuffled texture from the texture.
    pub shuffled: f64,
    /// The share of the texture's variance that is a slow change from side to side, which no model follows.
    pub trend: f64,
    /// The largest of the distances of the sample, each divided by the largest that would pass.
    pub excess: f64,
    /// The distance in appearance, by which a model with a structure and one without are compared.
    #[serde(skip)]
    pub appearance: f64,
    /// Whether all pass.
    pub alike: bool,
}

/// A texture to which samples are compared.
#[derive(Debug)]
pub struct LikenessReference {
    picture: Planes,
    appearance: appearance::Reference,
    halves: LikenessMeasures,
    shuffled: f64,
    trend: f64,
}

impl LikenessReference {
    /// The size of the samples compared with a texture of that size; `None` if it is too small.
    pub fn sample_size(size: Size) -> Option<Size> {
        let Size { width, height } = size;
        (width.min(height) >= LEAST_SIDE).then(|| Size::new(width.min(MOST_SIDE), height.min(MOST_SIDE)))
    }

    /// Prepares a field; `None` if it is too small.
    ///
    /// # Errors
    /// When the limits are exceeded, or the job is cancelled.
    pub fn of(field: &ReflectanceField, job: &Job) -> Result<Option<Self>> {
        if Self::sample_size(field.size()).is_none() {
            return Ok(None);
        }
        let picture = middle(&seen(field, job)?)?;
        let Size { width, height } = picture.size();
        let (w, h) = (width / 2, height / 2);
        let part = |x, y, w, h| picture.crop(x, y, Size::new(w, h));
        let across = measures(&part(0, 0, w, height)?, &part(width - w, 0, w, height)?, job)?;
        let down = measures(&part(0, 0, width, h)?, &part(0, height - h, width, h)?, job)?;
        let shuffled = patches(&picture, &shuffled(&picture), job)?;
        let (_, trend) = trend::removed(&picture);
        let appearance = appearance::Reference::new(&picture, 0, job)?;
        Ok(Some(Self { picture, appearance, halves: across.mean(&down), shuffled, trend }))
    }

    /// Compares a sample of a model.
    ///
    /// # Errors
    /// As [`Self::of`].
    pub fn likeness(&self, model: &FieldModel, job: &Job) -> Result<Likeness> {
        let size = self.picture.size();
        let sample = RealisationOptions { origin: [0, 0], size, seed: SAMPLE_SEED, period: None };
        let sample = seen(&model.synthesize(&sample, job)?, job)?;
        let appearance = self.appearance.distance(&sample, job)?.distance;
        let made = measures(&self.picture, &sample, job)?;
        let Self { halves, shuffled, trend, .. } = *self;
        let limits = halves.values().into_iter().zip(FLOORS).zip(TOLERANCES);
        let limits = limits.map(|((halves, floor), tolerance)| tolerance * halves.max(floor));
        let excess =
            made.values().into_iter().zip(limits).map(|(made, limit)| made / limit).fold(0.0, f64::max);
        // Noise is like its own shuffled texels, so both distances are small.
        let half_way = (MOST_OF_THE_WAY * shuffled).max(TOLERANCES[0] * FLOORS[0]);
        let excess = excess.max(made.patches / half_way);
        Ok(Likeness { made, halves, shuffled, trend, excess, appearance, alike: excess <= 1.0 })
    }
}

impl LikenessMeasures {
    fn values(&self) -> [f64; KINDS] {
        [self.patches, self.shapes, self.autocorrelation, self.histogram, self.detail]
    }

    fn mean(&self, other: &Self) -> Self {
        let mean = |f: fn(&Self) -> f64| 0.5 * (f(self) + f(other));
        Self {
            patches: mean(|m| m.patches),
            shapes: mean(|m| m.shapes),
            autocorrelation: mean(|m| m.autocorrelation),
            histogram: mean(|m| m.histogram),
            detail: mean(|m| m.detail),
        }
    }
}

impl fmt::Display for Likeness {
    /// The distances, and the verdict.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names = ["patches", "shapes", "autocorrelation", "histogram", "detail"];
        write!(f, "a made sample")?;
        for ((name, made), halves) in names.iter().zip(self.made.values()).zip(self.halves.values()) {
            write!(f, ", {name} {made:.3} (halves of the texture {halves:.3})")?;
        }
        let verdict = if self.alike { "looks like the material" } else { "does not look like the material" };
        write!(f, "; {:.0} % of the way to shuffled texels: {verdict}", 100.0 * self.way())
    }
}

impl Likeness {
    /// Whether the material changes plainly from side to side of the sample.
    pub fn changes(&self) -> bool {
        self.trend >= PLAIN_TREND
    }

    /// The patch distance of the sample as a fraction of that of shuffled texels.
    pub fn way(&self) -> f64 {
        if self.shuffled > 0.0 { self.made.patches / self.shuffled } else { 0.0 }
    }
}

/// A field as it is seen: a picture, or the functions under an oblique light.
fn seen(field: &ReflectanceField, job: &Job) -> Result<Planes> {
    job.check("the texture under a light", field.size(), 8 * field.layout().channels() as u64)?;
    let light = match field.basis() {
        Basis::Constant => Direction::ZENITH,
        _ => Direction::new(-0.5, 0.5, 0.7)?,
    };
    Ok(relight(field, light).to_space(Space::Srgb).planes)
}

/// The middle of planes, at most [`MOST_SIDE`] texels a side.
fn middle(planes: &Planes) -> Result<Planes> {
    let size = planes.size();
    let [width, height] = [size.width, size.height].map(|side| side.min(MOST_SIDE));
    let part = Rect::new((size.width - width) / 2, (size.height - height) / 2, Size::new(width, height));
    planes.crop(part.x, part.y, part.size)
}

fn measures(reference: &Planes, other: &Planes, job: &Job) -> Result<LikenessMeasures> {
    Ok(LikenessMeasures {
        patches: patches(reference, other, job)?,
        shapes: steerable::distance(&lightness(reference), &lightness(other), job)?,
        autocorrelation: correlation::distance(reference, other, job)?,
        histogram: histogram::distance(reference, other),
        detail: detail::distance(reference, other, FAINT_STEP),
    })
}

fn patches(reference: &Planes, other: &Planes, job: &Job) -> Result<f64> {
    let levels = sliced::levels(reference, other, &PATCHES, job)?;
    Ok(levels.iter().sum::<f64>() / levels.len() as f64)
}

/// The mean of the planes.
fn lightness(planes: &Planes) -> Planes {
    let mut mean = Planes::zeros(planes.size(), 1);
    let share = 1.0 / planes.count() as f32;
    for plane in planes.iter() {
        mean.as_mut_slice().iter_mut().zip(plane).for_each(|(m, v)| *m += share * v);
    }
    mean
}

/// The same texels in random order.
fn shuffled(planes: &Planes) -> Planes {
    let mut order: Vec<usize> = (0..planes.size().texels()).collect();
    let mut random = Stream::new(0, Purpose::ShuffledTexels, []);
    for i in (1..order.len()).rev() {
        order.swap(i, random.below(i + 1));
    }
    let mut out = Planes::zeros(planes.size(), planes.count());
    for (to, from) in out.iter_mut().zip(planes.iter()) {
        to.iter_mut().zip(&order).for_each(|(to, &place)| *to = from[place]);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::PlaneLayout;
    use crate::picture::Picture;
    use crate::random_field::{ModelOptions, model_field};

    fn field(value: impl Fn(usize, usize, &mut Stream) -> f32) -> ReflectanceField {
        let (size, mut random) = (Size::new(80, 72), Stream::new(6, Purpose::Sample, [0]));
        let data = (0..size.texels()).map(|i| value(i % 80, i / 80, &mut random)).collect();
        let planes = Planes::from_vec(size, 1, data).unwrap();
        let field = ReflectanceField::from_picture(Picture { planes, space: Space::Srgb });
        assert_eq!(*field.layout(), PlaneLayout::LUMINANCE);
        field
    }

    fn likeness(field: &ReflectanceField) -> Likeness {
        let options = ModelOptions { levels: 2, candidates: 12, ..ModelOptions::default() };
        let model = model_field(field, &options, &Job::default()).unwrap().0;
        LikenessReference::of(field, &Job::default())
            .unwrap()
            .unwrap()
            .likeness(&model, &Job::default())
            .unwrap()
    }

    #[test]
    fn noise_looks_like_itself_and_stones_do_not() {
        let noise = likeness(&field(|_, _, random| random.unit() as f32));
        assert!(noise.alike && noise.to_string().contains("looks like the material"), "{noise:?}");
        // Bright stones of ten texels, apart from a dark joint.
        let stones = likeness(&field(|x, y, random| {
            let joint = (x + y / 12 * 5) % 12 < 2 || y % 12 < 2;
            let grain = 0.05 * random.unit() as f32;
            if joint { 0.1 + grain } else { 0.7 + grain }
        }));
        assert!(!stones.alike && stones.excess > 1.0, "{stones:?}");
        assert!(stones.to_string().contains("does not look like the material"), "{stones}");
    }

    #[test]
    fn shuffled_texels_stay_whole_and_change_places() {
        let size = Size::new(9, 7);
        let data = (0..126).map(|i| (i % 63) as f32 + 100.0 * (i / 63) as f32).collect();
        let planes = Planes::from_vec(size, 2, data).unwrap();
        let mixed = shuffled(&planes);
        let pair = |planes: &Planes, t: usize| [planes.plane(0)[t], planes.plane(1)[t]];
        let mut moved = 0;
        let mut seen: Vec<f32> = Vec::new();
        for t in 0..63 {
            let [a, b] = pair(&mixed, t);
            assert!((b - a - 100.0).abs() < 1e-6);
            moved += usize::from(pair(&planes, t) != [a, b]);
            seen.push(a);
        }
        seen.sort_unstable_by(f32::total_cmp);
        assert_eq!(seen, planes.plane(0));
        assert!(moved > 50);
    }

    #[test]
    fn small_textures_are_not_judged() {
        let small = Planes::zeros(Size::new(31, 90), 1);
        let field = ReflectanceField::from_picture(Picture { planes: small, space: Space::Srgb });
        assert!(LikenessReference::of(&field, &Job::default()).unwrap().is_none());
    }
}
