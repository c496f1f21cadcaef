//! An environment map as lights: rectangles of texels, each with its light at its centre of light.
//!
//! The rectangle whose light times the square of its extent is the greatest is halved along its longer side until there
//! are enough (after K. Viriyothai, P. Debevec, Variance Minimization Light Probe Sampling, SIGGRAPH posters 2009): what
//! that product sums up is the error of integrals of smooth functions.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::f64::consts::{PI, TAU};

use super::super::vector::{Vec3, length};
use super::{Environment, luminance, row_cosine};
use crate::rect::Rect;
use crate::size::Size;

/// The finest division of the sphere: texels of larger maps are joined to these.
const FINEST: Size = Size::new(1024, 512);

/// Texels of narrower maps are divided, so that no light stands for a large patch.
const LEAST_WIDTH: usize = 256;

/// A part of the environment.
#[derive(Debug, Clone, Copy)]
pub(super) struct LightCell {
    pub direction: Vec3,
    /// The integral of its radiance.
    pub power: [f64; 3],
}

/// The light of the texels of a map of at most [`FINEST`] texels.
struct CoarseMap<'a> {
    environment: &'a Environment,
    size: Size,
    power: Vec<[f32; 3]>,
}

/// At most `count` cells with light, which hold all of it.
pub(super) fn cells(environment: &Environment, count: usize) -> Vec<LightCell> {
    let map = CoarseMap::new(environment);
    let whole = Rect::new(0, 0, map.size);
    let mut all = vec![(whole, map.cell(whole))];
    // Keys are not negative, so their bits are in their order.
    let mut heap = BinaryHeap::from([(map.key(whole, &all[0].1), Reverse(0))]);
    while all.len() < count
        && let Some((key, Reverse(index))) = heap.pop()
        && key > 0
    {
        let [first, second] = map.halves(all[index].0);
        all[index] = (first, map.cell(first));
        all.push((second, map.cell(second)));
        for index in [index, all.len() - 1] {
            heap.push((map.key(all[index].0, &all[index].1), Reverse(index)));
        }
    }
    all.into_iter().map(|(_, cell)| cell).filter(|cell| cell.power.iter().any(|&p| p > 0.0)).collect()
}

impl<'a> CoarseMap<'a> {
    fn new(environment: &'a Environment) -> Self {
        let from = environment.size();
        let parts = LEAST_WIDTH.div_ceil(from.width).max(LEAST_WIDTH.div_ceil(2 * from.height));
        let (width, height) = (from.width * parts, from.height * parts);
        let size = Size::new(width.min(FINEST.width), height.min(FINEST.height));
        let mut power = vec![[0.0f64; 3]; size.texels()];
        for y in 0..height {
            let solid_angle = TAU * (row_cosine(y, height) - row_cosine(y + 1, height)) / width as f64;
            for x in 0..width {
                let to = size.index(x * size.width / width, y * size.height / height);
                let radiance = environment.texel(x / parts, y / parts);
                (0..3).for_each(|c| power[to][c] += radiance[c] * solid_angle);
            }
        }
        let power = power.into_iter().map(|p| p.map(|v| v as f32)).collect();
        Self { environment, size, power }
    }

    fn cell(&self, rect: Rect<usize>) -> LightCell {
        let mut power = [0.0; 3];
        let mut center = Vec3::splat(0.0);
        for y in rect.y..rect.y + rect.size.height {
            let cosine = 0.5 * (row_cosine(y, self.size.height) + row_cosine(y + 1, self.size.height));
            for x in rect.x..rect.x + rect.size.width {
                let texel = self.power[self.size.index(x, y)].map(f64::from);
                let u = (x as f64 + 0.5) / self.size.width as f64;
                center = center + self.environment.direction(u, cosine) * luminance(texel);
                (0..3).for_each(|c| power[c] += texel[c]);
            }
        }
        let (top, bottom) =
            (row_cosine(rect.y, self.size.height), row_cosine(rect.y + rect.size.height, self.size.height));
        let middle = (rect.x as f64 + 0.5 * rect.size.width as f64) / self.size.width as f64;
        let middle = self.environment.direction(middle, 0.5 * (top + bottom));
        let direction = if length(center) > 0.0 { center.unit().unwrap_or(middle) } else { middle };
        LightCell { direction, power }
    }

    /// Angles along both sides.
    fn extents(&self, rect: Rect<usize>) -> [f64; 2] {
        let row = PI / self.size.height as f64;
        let middle = (rect.y as f64 + 0.5 * rect.size.height as f64) * row;
        [TAU * rect.size.width as f64 / self.size.width as f64 * middle.sin(), rect.size.height as f64 * row]
    }

    /// The bits of the light times the square of the extent; 0 for what cannot be halved.
    fn key(&self, rect: Rect<usize>, cell: &LightCell) -> u64 {
        if rect.size.texels() == 1 {
            return 0;
        }
        let [across, down] = self.extents(rect);
        (luminance(cell.power) * (across * across + down * down)).max(0.0).to_bits()
    }

    fn halves(&self, rect: Rect<usize>) -> [Rect<usize>; 2] {
        let [across, down] = self.extents(rect);
        let (Size { width, height }, [x, y]) = (rect.size, rect.origin());
        if height == 1 || (width > 1 && across >= down) {
            let half = width / 2;
            let rest = Size::new(width - half, height);
            return [Rect::new(x, y, Size::new(half, height)), Rect::new(x + half, y, rest)];
        }
        let half = height / 2;
        let rest = Size::new(width, height - half);
        [Rect::new(x, y, Size::new(width, half)), Rect::new(x, y + half, rest)]
    }
}
