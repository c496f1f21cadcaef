//! The joint distribution of the three channels of a colour.
//!
//! Channels that are modelled one by one mix colours that the material does not have: violet and neon texels
//! on moss. The colour is therefore modelled in the axes of Ohta, Kanade and Sakai ("Color Information for
//! Region Segmentation", Computer Graphics and Image Processing 13, 1980), nearly the principal axes of
//! photographs: lightness (r + g + b) / 3, then (r - b) / 2, then (2 g - r - b) / 4, each given those before
//! it ([`super::conditional`]). The axes are the same for all textures, so components of similar ones
//! correspond.

use super::conditional::Conditional;
use super::estimate::score;
use super::marginal::Marginal;
use crate::parallel;
use crate::planes::Planes;

/// Texels of a piece of work.
const PIECE: usize = 1 << 14;

/// The distribution of the colours in three successive planes.
#[derive(Debug, Clone, PartialEq)]
pub struct JointColor {
    /// The number of the first of the planes.
    pub first: usize,
    /// The distribution of the lightness.
    pub lightness: Marginal,
    /// That of the second axis given the lightness, and of the third given both.
    pub opponents: [Conditional; 2],
}

/// The axes of a colour.
fn axes([r, g, b]: [f32; 3]) -> [f32; 3] {
    [(r + g + b) / 3.0, (r - b) / 2.0, (2.0 * g - r - b) / 4.0]
}

/// The colour of given axes.
fn channels([lightness, second, third]: [f32; 3]) -> [f32; 3] {
    let part = third * (2.0 / 3.0);
    [lightness + second - part, lightness + 2.0 * part, lightness - second - part]
}

impl JointColor {
    /// The distribution of the colours in three planes, [`in_axes`], which become their scores.
    ///
    /// # Panics
    /// When there are not three planes from `first` on.
    pub fn scored(planes: &mut Planes, first: usize) -> Self {
        let [a, b, c] = three(planes, first);
        let lightness = Marginal::curve(a);
        score(a, &lightness);
        let second = Conditional::of(b, &[a]);
        score_second(b, a, &second);
        let third = Conditional::of(c, &[a, b]);
        score_third(c, [a, b], &third);
        Self { first, lightness, opponents: [second, third] }
    }

    /// The distribution that turns the colour planes of made scores into colours distributed as those of
    /// planes, [`in_axes`].
    ///
    /// # Panics
    /// When there are not three planes from `first` on in either.
    pub fn matched(planes: &Planes, scores: &Planes, first: usize) -> Self {
        let mut colors = planes.clone();
        let [a, b, c] = three(&mut colors, first);
        let [x, y, z] = [0, 1, 2].map(|k| scores.plane(first + k));
        let lightness = Marginal::matched(a, x);
        score(a, &lightness);
        let second = Conditional::matched(b, &[a], y, &[x]);
        score_second(b, a, &second);
        let third = Conditional::matched(c, &[a, b], z, &[x, y]);
        Self { first, lightness, opponents: [second, third] }
    }

    /// Turns scores into colours; each plane's are multiplied by its gain.
    ///
    /// # Panics
    /// When there are not as many planes and gains.
    pub fn apply(&self, planes: &mut Planes, gains: &[f32]) {
        let (lightness, tables) =
            (self.lightness.values(), self.opponents.each_ref().map(Conditional::table));
        let gains: [f32; 3] = std::array::from_fn(|k| gains[self.first + k]);
        let [a, b, c] = three(planes, self.first).map(|plane| plane.chunks_mut(PIECE));
        parallel::for_each(a.zip(b).zip(c), |((a, b), c)| {
            for ((a, b), c) in a.iter_mut().zip(b).zip(c) {
                let [x, y, z] = [gains[0] * *a, gains[1] * *b, gains[2] * *c];
                let axes = [lightness(x), tables[0].value(y, [x, 0.0]), tables[1].value(z, [x, y])];
                [*a, *b, *c] = channels(axes);
            }
        });
    }
}

/// Planes in which the three from `first` on hold the axes of a colour instead of its channels.
///
/// # Panics
/// When there are not three planes from `first` on.
pub fn in_axes(mut planes: Planes, first: usize) -> Planes {
    let [a, b, c] = three(&mut planes, first);
    for ((a, b), c) in a.iter_mut().zip(b).zip(c) {
        [*a, *b, *c] = axes([*a, *b, *c]);
    }
    planes
}

/// How much of a colour, as the root of the sum of squares over its channels, a unit along each axis is.
pub const LENGTHS: [f64; 3] = [1.732_050_8, std::f64::consts::SQRT_2, 1.632_993_2];

/// Scores instead of values, given those of an earlier plane; 0 for constant planes.
fn score_second(values: &mut [f32], earlier: &[f32], of: &Conditional) {
    if of.is_constant() {
        return values.fill(0.0);
    }
    let table = of.table();
    parallel::for_each_value(values, |at, v| *v = table.score(*v, [earlier[at], 0.0]));
}

/// The same given two earlier planes.
fn score_third(values: &mut [f32], [first, second]: [&[f32]; 2], of: &Conditional) {
    if of.is_constant() {
        return values.fill(0.0);
    }
    let table = of.table();
    parallel::for_each_value(values, |at, v| *v = table.score(*v, [first[at], second[at]]));
}

/// Three successive planes.
fn three(planes: &mut Planes, first: usize) -> [&mut [f32]; 3] {
    let texels = planes.size().texels();
    let (a, rest) = planes.as_mut_slice()[first * texels..].split_at_mut(texels);
    let (b, rest) = rest.split_at_mut(texels);
    [a, b, &mut rest[..texels]]
}

#[cfg(test)]
mod tests {
    use super::super::mixing::Mixing;
    use super::*;
    use crate::numeric::random::{Purpose, Stream};
    use crate::size::Size;

    /// Texels of two kinds of colour, ochre and slate, each with its own scatter.
    fn ochre_and_slate(size: Size, seed: u64) -> Planes {
        let mut random = Stream::new(seed, Purpose::Sample, [0]);
        let mut planes = Planes::zeros(size, 3);
        for t in 0..size.texels() {
            let light = 0.3 * random.unit() as f32;
            let base = if random.unit() < 0.6 { [0.55, 0.4, 0.15] } else { [0.3, 0.35, 0.5] };
            (0..3).for_each(|k| planes.plane_mut(k)[t] = base[k] + light);
        }
        planes
    }

    fn noise(size: Size, seed: u64) -> Planes {
        let mut random = Stream::new(seed, Purpose::Sample, [0]);
        let data = (0..3 * size.texels()).map(|_| random.normal() as f32).collect();
        Planes::from_vec(size, 3, data).unwrap()
    }

    /// The share of texels farther than `far` from every colour of the other planes.
    fn foreign(made: &Planes, of: &Planes, far: f32) -> f64 {
        let color = |planes: &Planes, t: usize| [0, 1, 2].map(|k| planes.plane(k)[t]);
        let known: Vec<[f32; 3]> = (0..of.size().texels()).map(|t| color(of, t)).collect();
        let is_foreign = |t: &usize| {
            let c = color(made, *t);
            let near = |k: &[f32; 3]| (0..3).map(|i| (k[i] - c[i]).powi(2)).sum::<f32>() <= far * far;
            !known.iter().any(near)
        };
        let texels = made.size().texels();
        (0..texels).filter(is_foreign).count() as f64 / texels as f64
    }

    #[test]
    fn axes_lead_back_to_channels() {
        let color = [0.7, 0.2, 0.4];
        let back = channels(axes(color));
        assert!((0..3).all(|k| (back[k] - color[k]).abs() < 1e-6), "{back:?}");
        for (axis, length) in LENGTHS.into_iter().enumerate() {
            let unit: [f32; 3] = std::array::from_fn(|k| f32::from(u8::from(k == axis)));
            let square: f32 = channels(unit).iter().map(|v| v * v).sum();
            assert!((f64::from(square).sqrt() - length).abs() < 1e-6, "{axis}");
        }
    }

    #[test]
    fn independent_scores_make_no_colour_that_was_not_there() {
        let size = Size::new(64, 48);
        let planes = ochre_and_slate(size, 3);
        let color = JointColor::scored(&mut in_axes(planes.clone(), 0), 0);
        let mut made = noise(size, 8);
        color.apply(&mut made, &[1.0; 3]);
        // The channels one by one, with their correlations.
        let curves: Vec<Marginal> = planes.iter().map(Marginal::curve).collect();
        let mut scores = planes.clone();
        scores.iter_mut().zip(&curves).for_each(|(plane, curve)| score(plane, curve));
        let mut single = Mixing::of(&scores, 1e-4).planes_of(&noise(size, 8));
        for (plane, curve) in single.iter_mut().zip(&curves) {
            let values = curve.values();
            plane.iter_mut().for_each(|v| *v = values(*v));
        }
        let (joint, single) = (foreign(&made, &planes, 0.05), foreign(&single, &planes, 0.05));
        println!("foreign colours: {joint:.3} jointly, {single:.3} channel by channel");
        assert!(joint < 0.25 && joint < 0.6 * single, "{joint} {single}");
    }

    #[test]
    fn scores_of_a_picture_lead_back_to_it() {
        let size = Size::new(40, 40);
        let planes = ochre_and_slate(size, 5);
        let mut scores = in_axes(planes.clone(), 0);
        let color = JointColor::scored(&mut scores, 0);
        color.apply(&mut scores, &[1.0; 3]);
        let error: f32 =
            scores.as_slice().iter().zip(planes.as_slice()).map(|(a, b)| (a - b).abs()).sum::<f32>();
        assert!(error / (scores.as_slice().len() as f32) < 0.02);
    }
}
