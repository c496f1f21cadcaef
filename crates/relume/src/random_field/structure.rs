//! The structure of a regular texture: a set of tiles in a few kilobytes.
//!
//! The random fields of Haindl and Filip lose periodic structure, and copies of blocks keep it; the
//! publication leaves regular parts to sampling and the rest to the field. Here a set of tiles of the
//! components (made by any method that copies, such as the Roller) is stored as quantised wavelet
//! coefficients. A coarse step keeps strong coefficients, outlines and periodic structure at any frequency,
//! and none of the grain. The residual, about as strong as the step at all frequencies, is modelled by the
//! random field, and the output is the sum of both.
//!
//! Of k tiles with one border the first is stored itself and the others as differences from it, which vanish
//! at the border. So all are altered there in nearly the same way, and still fit together.

use crate::error::Result;
use crate::job::Job;
use crate::numeric::endless::Endless;
use crate::numeric::pyramid::{self, Kernel};
use crate::numeric::wavelet;
use crate::planes::Planes;
use crate::rect::Rect;
use crate::size::Size;

/// The least side of the coarsest averages.
const LEAST_SIDE: usize = 6;

/// The most scales of the wavelets.
pub const MOST_SCALES: usize = 12;

/// A coefficient becomes the integer part of its number of steps plus this: fewer than 0.6 steps become zero.
const ROUNDING: f32 = 0.4;

/// The largest magnitude of a code.
pub const MOST_CODE: i32 = 1 << 20;

/// The range of steps tried, in deviations of the components.
const STEP_RANGE: [f64; 2] = [0.01, 100.0];

/// The number of halvings of that range.
const HALVINGS: usize = 14;

/// Tiles as quantised wavelet coefficients.
#[derive(Debug, Clone, PartialEq)]
pub struct Structure {
    /// The size of a tile.
    pub tile: Size,
    /// The number of tiles.
    pub tiles: usize,
    /// The number of scales of the wavelets.
    pub scales: usize,
    /// Whether the detail is predicted from the structure, as all new models have it: files of former versions have a detail
    /// that does not depend on it.
    pub predicts: bool,
    /// The quantisation step of the coefficients of each component.
    pub steps: Vec<f32>,
    /// Coefficients in steps, tile after tile, component after component, row by row; those of further tiles
    /// are differences from the first.
    pub codes: Vec<i32>,
}

/// Tiles of a texture, stacked one below the other.
#[derive(Debug)]
pub struct Tiles<'a, T> {
    /// The content of the tiles.
    pub texels: &'a T,
    /// The size of a tile.
    pub size: Size,
}

impl<T> Clone for Tiles<'_, T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for Tiles<'_, T> {}

impl Structure {
    /// The tiles of given components with these steps.
    ///
    /// # Panics
    /// When the planes do not consist of whole tiles, or the number of steps differs.
    pub fn nearest(tiles: Tiles<'_, Planes>, steps: Vec<f32>) -> Self {
        let (tile, planes) = (tiles.size, tiles.texels);
        let count = planes.size().height / tile.height;
        assert_eq!((planes.size(), planes.count()), (stacked(tile, count), steps.len()), "whole tiles");
        let scales = scales(tile);
        let mut whole = Self { tile, tiles: count, scales, predicts: true, steps, codes: Vec::new() };
        for number in 0..count {
            let mut part = planes.crop(0, number * tile.height, tile).expect("inside the planes");
            wavelet::forward(&mut part, scales);
            for (k, plane) in part.iter().enumerate() {
                let first = if number == 0 { None } else { Some(whole.codes_of(0, k).to_vec()) };
                let step = whole.steps[k];
                let base = |i: usize| first.as_ref().map_or(0.0, |codes| codes[i] as f32 * step);
                let codes = plane.iter().enumerate().map(|(i, &v)| code((v - base(i)) / step));
                let codes: Vec<i32> = codes.collect();
                whole.codes.extend(codes);
            }
        }
        whole
    }

    /// The tiles with the finest steps whose `cost` is at most `budget`. The step of a component is inversely
    /// proportional to its magnitude in the planes, `weights`: errors of all planes have equal weight.
    ///
    /// # Panics
    /// As [`Self::nearest`].
    pub fn within(
        tiles: Tiles<'_, Planes>,
        weights: &[f64],
        budget: usize,
        cost: &dyn Fn(&Self) -> usize,
    ) -> Self {
        let made = |log_step: f64| {
            let step = |weight: &f64| half::f16::from_f64(log_step.exp() / weight.max(1e-3)).to_f32();
            Self::nearest(tiles, weights.iter().map(step).collect())
        };
        let [mut fine, mut coarse] = STEP_RANGE.map(f64::ln);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (fine + coarse);
            match cost(&made(middle)) <= budget {
                true => coarse = middle,
                false => fine = middle,
            }
        }
        made(coarse)
    }

    /// The number of components.
    pub fn components(&self) -> usize {
        self.steps.len()
    }

    /// The codes of one component of a tile.
    ///
    /// # Panics
    /// When there are none.
    pub fn codes_of(&self, tile: usize, component: usize) -> &[i32] {
        let texels = self.tile.texels();
        &self.codes[(tile * self.components() + component) * texels..][..texels]
    }

    /// The components of all tiles, one below the other.
    pub fn decoded(&self) -> Planes {
        let texels = self.tile.texels();
        let mut all = Planes::zeros(stacked(self.tile, self.tiles), self.components());
        for number in 0..self.tiles {
            let mut part = Planes::zeros(self.tile, self.components());
            for (k, plane) in part.iter_mut().enumerate() {
                let own = self.codes_of(number, k).iter();
                let first = self.codes_of(0, k);
                let sum = |(i, &code): (usize, &i32)| if number == 0 { code } else { code + first[i] };
                plane.iter_mut().zip(own.enumerate().map(sum)).for_each(|(v, code)| {
                    *v = code as f32 * self.steps[k];
                });
            }
            wavelet::inverse(&mut part, self.scales);
            for (to, from) in all.iter_mut().zip(part.iter()) {
                to[number * texels..][..texels].copy_from_slice(from);
            }
        }
        all
    }

    /// The part of the endless plane of tiles over an area. With a period of a whole number of tiles along x
    /// and y, it repeats.
    ///
    /// # Errors
    /// More memory than the limits allow.
    pub fn window(&self, area: Rect, seed: u64, period: Option<[i64; 2]>, job: &Job) -> Result<Planes> {
        self.laid(&self.decoded(), area, seed, period, job)
    }

    /// A level of the Gaussian pyramid of the endless plane over an area of that level.
    ///
    /// # Errors
    /// As [`Self::window`].
    pub fn reduced_window(
        &self,
        (kernel, level): (&Kernel, usize),
        area: Rect,
        seed: u64,
        period: Option<[i64; 2]>,
        job: &Job,
    ) -> Result<Planes> {
        // One texel more on each side than a level gives to the next.
        let finer = |area: Rect| {
            let (n, Size { width, height }) = (kernel.factor(), area.size);
            let size = Size::new(n * (width + 2), n * (height + 2));
            Rect::new(n as i64 * (area.x - 1), n as i64 * (area.y - 1), size)
        };
        if level == 0 {
            return self.window(area, seed, period, job);
        }
        let fine = self.reduced_window((kernel, level - 1), finer(area), seed, period, job)?;
        pyramid::reduce(&fine, kernel).crop(1, 1, area.size)
    }

    /// The part of the endless plane of decoded tiles over an area.
    fn laid(
        &self,
        decoded: &Planes,
        area: Rect,
        seed: u64,
        period: Option<[i64; 2]>,
        job: &Job,
    ) -> Result<Planes> {
        let plane = Endless::new(self.tile, self.tiles, seed)?;
        let [x, y] = area.origin();
        let Some([across, down]) = period else { return plane.window(decoded, x, y, area.size, job) };
        let mut window = Planes::zeros_within(job, "the structure", area.size, decoded.count())?;
        for (to, from) in window.iter_mut().zip(decoded.iter()) {
            for (j, row) in to.chunks_exact_mut(area.size.width).enumerate() {
                let y = (y + j as i64).rem_euclid(down);
                repeating(row, x, across, |x, part| plane.copy_row(from, 1, x, y, part));
            }
        }
        Ok(window)
    }
}

/// Fills a row from column `x` on with parts of a row of period `period`.
fn repeating(row: &mut [f32], x: i64, period: i64, mut copy: impl FnMut(i64, &mut [f32])) {
    let (mut x, mut rest) = (x.rem_euclid(period), row);
    while !rest.is_empty() {
        let (now, later) = rest.split_at_mut(rest.len().min((period - x) as usize));
        copy(x, now);
        (x, rest) = (0, later);
    }
}

/// Tiles one below the other.
fn stacked(tile: Size, tiles: usize) -> Size {
    Size::new(tile.width, tile.height * tiles)
}

/// As many scales as leave averages of the least size.
fn scales(tile: Size) -> usize {
    let sizes = wavelet::sizes(tile, MOST_SCALES);
    sizes[1..].iter().take_while(|s| s.width.min(s.height) >= LEAST_SIDE).count()
}

fn code(value: f32) -> i32 {
    let size = (value.abs() + ROUNDING).floor().min(MOST_CODE as f32) as i32;
    if value < 0.0 { -size } else { size }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};
    use proptest::prelude::*;

    fn random(size: Size, count: usize, seed: u64) -> Planes {
        let mut stream = Stream::new(seed, Purpose::Sample, [0]);
        let data = (0..size.texels() * count).map(|_| stream.unit() as f32 - 0.5).collect();
        Planes::from_vec(size, count, data).unwrap()
    }

    fn rmse(a: &Planes, b: &Planes) -> f64 {
        let square = |(a, b): (&f32, &f32)| f64::from(a - b).powi(2);
        let sum: f64 = a.as_slice().iter().zip(b.as_slice()).map(square).sum();
        (sum / a.as_slice().len() as f64).sqrt()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]
        #[test]
        fn tiles_come_back_within_their_steps(
            (w, h, count, planes) in (1usize..40, 1usize..30, 1usize..4, 1usize..4), step in 0.01f32..0.3, seed: u64,
        ) {
            let (tile, all) = (Size::new(w, h), random(Size::new(w, h * count), planes, seed));
            let steps: Vec<f32> = (1..=planes).map(|k| step / k as f32).collect();
            let structure = Structure::nearest(Tiles { texels: &all, size: tile }, steps);
            prop_assert_eq!((structure.tiles, structure.codes.len()), (count, all.as_slice().len()));
            prop_assert!(rmse(&structure.decoded(), &all) < f64::from(step));
        }

        #[test]
        fn windows_are_the_same_however_they_are_cut_and_repeat_with_their_period(
            (w, h, count) in (2usize..9, 2usize..9, 1usize..4),
            (x, y, width, height) in (-30i64..30, -30i64..30, 1usize..20, 1usize..20), seed: u64,
        ) {
            let all = random(Size::new(w, h * count), 2, 3);
            let structure = Structure::nearest(Tiles { texels: &all, size: Size::new(w, h) }, vec![0.05; 2]);
            let cut = |x: i64, y: i64, width, height, period| {
                let area = Rect::new(x, y, Size::new(width, height));
                structure.window(area, seed, period, &Job::default()).unwrap()
            };
            let whole = cut(x, y, width + 5, height + 4, None);
            prop_assert_eq!(whole.crop(3, 2, Size::new(width, height)).unwrap(), cut(x + 3, y + 2, width, height, None));
            let period = [3 * w as i64, 2 * h as i64];
            let tile = cut(x, y, width, height, Some(period));
            prop_assert_eq!(&tile, &cut(x - period[0], y + 3 * period[1], width, height, Some(period)));
            let inside = cut(0, 0, 3 * w, 2 * h, Some(period));
            prop_assert_eq!(inside, cut(0, 0, 3 * w, 2 * h, None));
        }
    }

    #[test]
    fn finer_steps_are_taken_where_there_is_room() {
        let all = random(Size::new(40, 32), 2, 1);
        let tiles = Tiles { texels: &all, size: all.size() };
        let used = |s: &Structure| s.codes.iter().filter(|&&code| code != 0).count();
        let made = |budget| Structure::within(tiles, &[1.0, 0.5], budget, &used);
        let (few, many) = (made(100), made(900));
        assert!(used(&few) <= 100 && used(&few) > 60 && used(&many) <= 900 && used(&many) > 700);
        assert!((few.steps[1] / few.steps[0] - 2.0).abs() < 0.01);
        assert!(rmse(&many.decoded(), &all) < rmse(&few.decoded(), &all));
    }
}
