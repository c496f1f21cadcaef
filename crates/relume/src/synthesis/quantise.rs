//! Exemplars as integers, so that deciding distances are exact.
//!
//! All planes of all exemplars share one step, which keeps distances proportional; each plane is shifted by
//! its own minimum, which cancels in differences. Values that lie on at most 256 evenly spaced levels (8-bit
//! pictures, in any scale) become the numbers of their levels, without loss; others are rounded to 1/4095 of
//! the range of the widest plane. Either way codes are 0 to 4095 and their differences fit 13 bits.

use crate::error::{Error, Result};
use crate::job::Job;
use crate::parallel;
use crate::planes::Planes;
use crate::size::Size;

/// The largest code.
pub const MAX_CODE: i16 = 4095;

/// Codes past the last texel, so that a search may read a whole register from any texel on.
pub const PADDING: usize = 32;

/// A source of blocks: index planes, and texels that may not be used.
#[derive(Debug, Clone, Copy)]
pub struct Exemplar<'a> {
    /// Planes whose Euclidean distance is the distance of texels.
    pub index: &'a Planes,
    /// For each texel, row by row, whether blocks must avoid it.
    pub excluded: Option<&'a [bool]>,
}

/// The codes of one exemplar, the planes of a texel adjacent, row by row.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct IndexTexels {
    size: Size,
    planes: usize,
    codes: Vec<i16>,
}

impl IndexTexels {
    /// Width and height.
    pub fn size(&self) -> Size {
        self.size
    }

    /// The position of the codes of texel (x, y) in [`IndexTexels::codes`].
    pub fn start(&self, x: usize, y: usize) -> usize {
        self.size.index(x, y) * self.planes
    }

    /// All codes, followed by [`PADDING`] zeros.
    pub fn codes(&self) -> &[i16] {
        &self.codes
    }

    /// The number of planes.
    pub fn planes(&self) -> usize {
        self.planes
    }

    /// Half the size, rounded up: rounded means of 4 x 4 texels, weighted 1 3 3 1 along both axes; edge
    /// texels are repeated beyond the edges. Excluded texels do not count, unless all 16 are excluded.
    pub(super) fn halved(&self, excluded: Option<&[bool]>) -> Self {
        let size = Size::new(self.size.width.div_ceil(2), self.size.height.div_ceil(2));
        let mut codes = Vec::with_capacity(size.texels() * self.planes + PADDING);
        for (x, y) in (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y))) {
            let around = HalvingWindow::new(self.size, x, y);
            let weights = excluded.map(|mask| around.weights(mask)).filter(|weights| *weights != [0; 16]);
            let weights = weights.unwrap_or(HalvingWindow::WEIGHTS);
            let total: i32 = weights.iter().sum();
            for k in 0..self.planes {
                let code = |&texel: &usize| i32::from(self.codes[texel * self.planes + k]);
                let sum: i32 = around.texels.iter().map(code).zip(weights).map(|(code, w)| w * code).sum();
                codes.push((sum + total / 2).div_euclid(total) as i16);
            }
        }
        codes.resize(codes.len() + PADDING, 0);
        Self { size, planes: self.planes, codes }
    }

    /// The codes of `width` texels from (x, y) to the right.
    pub fn run(&self, x: usize, y: usize, width: usize) -> &[i16] {
        &self.codes[self.start(x, y)..][..width * self.planes]
    }

    /// At half the resolution, rounded down: the means of squares of four texels.
    fn averaged(&self) -> Self {
        let size = Size::new((self.size.width / 2).max(1), (self.size.height / 2).max(1));
        let mut codes = Vec::with_capacity(size.texels() * self.planes + PADDING);
        for (x, y) in (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y))) {
            let near = |at: usize, length: usize| at.min(length - 1);
            let corner = |i: usize| {
                self.start(near(2 * x + i % 2, self.size.width), near(2 * y + i / 2, self.size.height))
            };
            let corners = [0, 1, 2, 3].map(corner);
            codes.extend((0..self.planes).map(|k| mean(corners.map(|at| self.codes[at + k]))));
        }
        codes.resize(codes.len() + PADDING, 0);
        Self { size, planes: self.planes, codes }
    }
}

/// The mean of four codes, rounded.
pub(in crate::synthesis) fn mean(codes: [i16; 4]) -> i16 {
    (codes.iter().map(|code| i32::from(*code)).sum::<i32>() + 2).div_euclid(4) as i16
}

/// The 4 x 4 texels that a texel of half the resolution averages, row by row.
pub(super) struct HalvingWindow {
    texels: [usize; 16],
}

impl HalvingWindow {
    /// Their weights: 1 3 3 1 along both axes.
    pub const WEIGHTS: [i32; 16] = [1, 3, 3, 1, 3, 9, 9, 3, 3, 9, 9, 3, 1, 3, 3, 1];

    /// Those of the coarser texel (x, y); edge texels are repeated beyond the edges.
    pub fn new(fine: Size, x: usize, y: usize) -> Self {
        let near = |at: usize, i: usize, length: usize| (2 * at + i).saturating_sub(1).min(length - 1);
        let place = |i: usize| fine.index(near(x, i % 4, fine.width), near(y, i / 4, fine.height));
        Self { texels: std::array::from_fn(place) }
    }

    /// The weights, 0 for excluded texels.
    pub fn weights(&self, excluded: &[bool]) -> [i32; 16] {
        std::array::from_fn(|i| if excluded[self.texels[i]] { 0 } else { Self::WEIGHTS[i] })
    }
}

/// The exemplars of one synthesis in a common step.
#[derive(Debug, Clone, PartialEq)]
pub struct Quantised {
    texels: Vec<IndexTexels>,
    planes: usize,
    step: f64,
}

impl Quantised {
    /// Quantises exemplars that have the same planes.
    ///
    /// # Errors
    /// When there are none, their planes differ in number, or a value is not finite.
    pub fn new(exemplars: &[Exemplar<'_>], job: &Job) -> Result<Self> {
        let planes = check(exemplars)?;
        let channels: Vec<Channels<'_>> = exemplars.iter().map(Channels::of).collect();
        job.check_bytes("the index of the exemplars", channels.iter().map(Channels::code_bytes).sum())?;
        let scale = Scale::common(&channels);
        let texels = channels.iter().map(|channels| scale.codes(channels)).collect();
        Ok(Self::of(texels, planes, scale.step))
    }

    /// Codes of the given number of planes in a common step.
    pub(super) fn of(texels: Vec<IndexTexels>, planes: usize, step: f64) -> Self {
        Self { texels, planes, step }
    }

    /// The exemplars in order.
    pub fn texels(&self) -> &[IndexTexels] {
        &self.texels
    }

    /// The number of index planes.
    pub fn planes(&self) -> usize {
        self.planes
    }

    /// The memory of all codes.
    pub fn bytes(&self) -> u64 {
        self.texels.iter().map(|texels| size_of_val(texels.codes()) as u64).sum()
    }

    /// The same exemplars at half the size, made of the texels that are not excluded.
    pub(super) fn halved(&self, masks: &[Option<Vec<bool>>]) -> Self {
        let masks = masks.iter().map(Option::as_deref);
        let texels = self.texels.iter().zip(masks).map(|(texels, mask)| texels.halved(mask)).collect();
        Self { texels, ..*self }
    }

    /// Sets every code, for tests at the limit of the range.
    /// At half the resolution, rounded down: the means of squares of four texels.
    pub(super) fn averaged(&self) -> Self {
        let texels = self.texels.iter().map(IndexTexels::averaged).collect();
        Self { texels, ..*self }
    }

    #[cfg(test)]
    pub(super) fn fill_for_tests(&mut self, code: i16) {
        self.texels.iter_mut().for_each(|texels| texels.codes.fill(code));
    }

    /// The difference in index space of one code.
    pub fn step(&self) -> f64 {
        self.step
    }
}

/// The squared length of codes.
pub fn squared_length(codes: &[i16]) -> u64 {
    codes.iter().map(|&code| i64::from(code).pow(2).unsigned_abs()).sum()
}

/// The squared length of the codes of each texel.
pub fn squared_lengths(codes: &[i16], planes: usize) -> Vec<u64> {
    codes.chunks_exact(planes).map(squared_length).collect()
}

/// Checks that exemplars can be compared, and returns their number of planes.
pub(super) fn check(exemplars: &[Exemplar<'_>]) -> Result<usize> {
    let Some(first) = exemplars.first() else {
        return Err(Error::usage("synthesis needs at least one exemplar"));
    };
    let planes = first.index.count();
    for (number, exemplar) in exemplars.iter().enumerate() {
        let (index, size) = (exemplar.index, exemplar.index.size());
        if index.count() != planes || planes == 0 {
            return Err(Error::usage(format!(
                "exemplar {} has {} index planes, the first {planes}: exemplars must be of one kind",
                number + 1,
                index.count()
            )));
        }
        if let Some(at) = index.as_slice().iter().position(|v| !v.is_finite()) {
            let texel = at % size.texels();
            return Err(Error::invalid(format!(
                "exemplar {} holds {} at texel ({}, {}), where a finite number is needed",
                number + 1,
                index.as_slice()[at],
                texel % size.width,
                texel / size.width
            )));
        }
        if let Some(mask) = exemplar.excluded.filter(|mask| mask.len() != size.texels()) {
            return Err(Error::usage(format!(
                "the mask of exemplar {} has {} texels, the exemplar {size}",
                number + 1,
                mask.len()
            )));
        }
    }
    Ok(planes)
}

/// Planes that are quantised together, the planes of a texel adjacent.
#[derive(Debug, Clone)]
pub(super) struct Channels<'a> {
    pub size: Size,
    /// The number of the first plane: those of a guide alone come after all index planes.
    pub first: usize,
    pub planes: Vec<&'a [f32]>,
}

impl<'a> Channels<'a> {
    /// The index planes of an exemplar.
    pub fn of(exemplar: &Exemplar<'a>) -> Self {
        Self { size: exemplar.index.size(), first: 0, planes: exemplar.index.iter().collect() }
    }

    /// Memory of their codes.
    pub fn code_bytes(&self) -> u64 {
        2 * (self.size.texels() * self.planes.len() + PADDING) as u64
    }

    /// Each plane with its number.
    fn numbered(&self) -> impl Iterator<Item = (usize, &'a [f32])> {
        (self.first..).zip(self.planes.iter().copied())
    }
}

/// The conversion of values to codes: each plane is shifted by its minimum, and all are divided by one step.
#[derive(Debug)]
pub(super) struct Scale {
    lows: Vec<f64>,
    /// The difference of one code.
    pub step: f64,
}

impl Scale {
    /// The scale of all planes: planes of the same number share their shift.
    pub fn common(all: &[Channels<'_>]) -> Self {
        let planes = all.iter().map(|channels| channels.first + channels.planes.len()).max().unwrap_or(0);
        let mut ranges = vec![(f64::INFINITY, f64::NEG_INFINITY); planes];
        for (k, plane) in all.iter().flat_map(Channels::numbered) {
            let widen = |(low, high): (f64, f64), value: &f32| {
                (low.min(f64::from(*value)), high.max(f64::from(*value)))
            };
            ranges[k] = plane.iter().fold(ranges[k], widen);
        }
        let widest = ranges.iter().map(|(low, high)| high - low).fold(0.0, f64::max);
        let lows: Vec<f64> = ranges.iter().map(|(low, _)| *low).collect();
        let levels = even_levels(all, &lows, widest).unwrap_or(u32::from(MAX_CODE.unsigned_abs()));
        Self { lows, step: if widest > 0.0 { widest / f64::from(levels) } else { 1.0 } }
    }

    /// The codes of planes.
    pub fn codes(&self, channels: &Channels<'_>) -> IndexTexels {
        let (size, planes) = (channels.size, channels.planes.len());
        let length = size.texels() * planes;
        let mut codes = vec![0i16; length + PADDING];
        parallel::for_each(codes[..length].chunks_exact_mut(size.width * planes).enumerate(), |(y, row)| {
            for (at, (k, plane)) in channels.numbered().enumerate() {
                let values = &plane[size.index(0, y)..][..size.width];
                for (code, value) in row[at..].iter_mut().step_by(planes).zip(values) {
                    *code = ((f64::from(*value) - self.lows[k]) / self.step + 0.5) as i16;
                }
            }
        });
        IndexTexels { size, planes, codes }
    }
}

/// The number n of even steps in the widest range such that every value is a whole number of them above the
/// minimum of its plane; `None` when that needs more than 255. Values may be off by a thousandth of 1/255 of
/// the range: less than the least difference of two fractions with denominators up to 255, and more than the
/// error of rounding to `f32`.
fn even_levels(all: &[Channels<'_>], lows: &[f64], widest: f64) -> Option<u32> {
    if widest <= 0.0 {
        return None;
    }
    let off = |fraction: f64, n: u32| {
        let place = fraction * f64::from(n);
        (place - (place + 0.5).floor()).abs() > f64::from(n) / 255.0 * 0.001
    };
    let mut n = 1;
    for (k, plane) in all.iter().flat_map(Channels::numbered) {
        let (low, scale) = (lows[k], 1.0 / widest);
        for value in plane {
            let fraction = (f64::from(*value) - low) * scale;
            if off(fraction, n) {
                n = (2..=255 / n).map(|times| times * n).find(|&finer| !off(fraction, finer))?;
            }
        }
    }
    Some(n)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};

    fn quantised(planes: &Planes) -> Quantised {
        Quantised::new(&[Exemplar { index: planes, excluded: None }], &Job::default()).unwrap()
    }

    #[test]
    fn eight_bit_pictures_keep_their_codes_in_any_scale() {
        let mut stream = Stream::new(1, Purpose::Sample, [0]);
        let size = Size::new(31, 17);
        let picture: Vec<u8> = (0..size.texels() * 3).map(|_| stream.below(200) as u8 + 7).collect();
        for scale in [1.0, 2.0, std::f64::consts::TAU.sqrt(), std::f64::consts::PI.sqrt()] {
            let values = picture.iter().map(|&c| f32::from(c) / 255.0 * scale as f32).collect();
            let planes = Planes::from_vec(size, 3, values).unwrap();
            let q = quantised(&planes);
            let n = size.texels();
            for k in 0..3 {
                let least = i16::from(*picture[k * n..][..n].iter().min().unwrap());
                for (texel, &code) in picture[k * n..][..n].iter().enumerate() {
                    assert_eq!(q.texels()[0].codes()[texel * 3 + k], i16::from(code) - least);
                }
            }
            assert!((q.step() / (scale / 255.0) - 1.0).abs() < 1e-5);
        }
    }

    #[test]
    fn other_values_are_off_by_half_a_step_at_most() {
        let mut stream = Stream::new(2, Purpose::Sample, [0]);
        let size = Size::new(40, 9);
        let values: Vec<f32> =
            (0..size.texels() * 4).map(|i| (stream.unit() * (1 + i % 7) as f64) as f32).collect();
        let planes = Planes::from_vec(size, 4, values).unwrap();
        let q = quantised(&planes);
        for k in 0..4 {
            let low = f64::from(planes.range(k).0);
            for (texel, value) in planes.plane(k).iter().enumerate() {
                let code = q.texels()[0].codes()[texel * 4 + k];
                assert!((0..=MAX_CODE).contains(&code));
                let error = (low + f64::from(code) * q.step() - f64::from(*value)).abs();
                assert!(error <= 0.501 * q.step());
            }
        }
    }

    #[test]
    fn exemplars_share_step_and_shift() {
        let a = Planes::from_vec(Size::new(2, 1), 1, vec![0.0, 0.3]).unwrap();
        let b = Planes::from_vec(Size::new(3, 1), 1, vec![0.3, 1.0, std::f32::consts::FRAC_1_PI]).unwrap();
        let both = [Exemplar { index: &a, excluded: None }, Exemplar { index: &b, excluded: None }];
        let q = Quantised::new(&both, &Job::default()).unwrap();
        assert_eq!(q.texels()[0].run(1, 0, 1), q.texels()[1].run(0, 0, 1));
    }

    #[test]
    fn what_cannot_be_compared_is_refused() {
        let size = Size::new(2, 2);
        let good = Planes::zeros(size, 2);
        let other = Planes::zeros(size, 1);
        let nan = Planes::from_vec(size, 2, vec![0.0, 0.0, 0.0, 0.0, 0.0, f32::NAN, 0.0, 0.0]).unwrap();
        let plain = |index| Exemplar { index, excluded: None };
        let refused = |e: &[Exemplar<'_>]| Quantised::new(e, &Job::default()).unwrap_err();
        refused(&[]);
        refused(&[plain(&good), plain(&other)]);
        refused(&[Exemplar { index: &good, excluded: Some(&[true]) }]);
        assert!(refused(&[plain(&nan)]).message().contains("texel (1, 0)"));
        assert_eq!(quantised(&good).texels()[0].run(0, 1, 2), [0; 4]);
        let huge = Planes::from_vec(size, 1, vec![f32::MAX, f32::MIN, 0.0, 1.0]).unwrap();
        assert_eq!(quantised(&huge).texels()[0].run(1, 0, 1), [0]);
    }
}
