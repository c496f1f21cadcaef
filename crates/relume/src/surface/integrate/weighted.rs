//! Heights of a part of a picture, and heights with cliffs: the Poisson problem with a weight for each pair of
//! neighbours.
//!
//! Each texel says twice what its slope is: as the difference to the neighbour before it and to the one after it. With
//! [`Discontinuities::Smooth`] both count equally. With [`Discontinuities::Preserve`] the one that disagrees, as across
//! a cliff, gradually loses its weight: w = 1 / (1 + exp(k (r_after^2 - r_before^2))), with the residuals r of both
//! differences times the cosine of the slope (X. Cao, H. Santo, B. Shi, F. Okura, Y. Matsushita, Bilateral normal
//! integration, ECCV 2022, eq. 13 to 16). Weights and heights are found in turns.
//!
//! Texels outside the mask have no neighbours. The mean height of each connected part is unknown and set to zero, and so
//! are texels outside. The equations are solved by conjugate gradients with the diagonal as a preconditioner.

use super::SurfaceBorder;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::names::named;
use crate::planes::Planes;
use crate::size::Size;
use crate::surface::slopes::Slopes;

/// Whether a surface may break.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Discontinuities {
    /// The surface is continuous: cliffs become ramps.
    #[default]
    Smooth,
    /// Differences that disagree with the slopes lose their weight: cliffs stay.
    Preserve,
}

named!(Discontinuities { Smooth => "smooth", Preserve => "preserve" });

/// The steepness of the weights, as in the source.
const STEEPNESS: f64 = 2.0;
/// Rounds of weights and heights.
const ROUNDS: usize = 25;
/// Conjugate gradients end when the residual has this part of its first size.
const ENOUGH: f64 = 1e-7;
/// Bytes of a texel while heights are solved for.
const BYTES: u64 = 8 * 12;
/// No neighbour.
const NONE: usize = usize::MAX;

/// One plane of heights in texels; `mask` says which texels belong to the surface, all of them without one.
///
/// # Errors
/// A mask of another size or without a texel, and the limits of the job.
pub fn integrate_weighted(
    slopes: &Slopes,
    mask: Option<&[bool]>,
    border: SurfaceBorder,
    discontinuities: Discontinuities,
    job: &Job,
) -> Result<Planes> {
    let size = slopes.size();
    if let Some(mask) = mask.filter(|mask| mask.len() != size.texels()) {
        return Err(Error::invalid(format!(
            "the mask has {} texels and the surface {size}: they must have the same size",
            mask.len()
        )));
    }
    if mask.is_some_and(|mask| !mask.contains(&true)) {
        return Err(Error::invalid("the mask leaves no texel of the surface"));
    }
    job.check("the integration of slopes", size, BYTES)?;
    let graph = Graph::new(size, mask, border);
    let rounds = if discontinuities == Discontinuities::Preserve { ROUNDS } else { 1 };
    job.start("integrating slopes", rounds as u64);
    let mut heights = vec![0.0; size.texels()];
    for round in 0..rounds {
        let edges = WeightedEdges::of(&graph, slopes, &heights, round > 0);
        edges.solve(&graph, &mut heights, job)?;
        job.advance(1)?;
    }
    graph.level_parts(&mut heights);
    Planes::from_vec(size, 1, heights.into_iter().map(|h| h as f32).collect())
}

/// The neighbour after each texel, to the right and below.
struct Graph {
    right: Vec<usize>,
    below: Vec<usize>,
}

impl Graph {
    fn new(size: Size, mask: Option<&[bool]>, border: SurfaceBorder) -> Self {
        let inside = |texel: usize| mask.is_none_or(|mask| mask[texel]);
        let next = |dx: usize, dy: usize| -> Vec<usize> {
            let of = |texel: usize| {
                let (x, y) = (texel % size.width + dx, texel / size.width + dy);
                let beyond = x == size.width || y == size.height;
                if beyond && border == SurfaceBorder::Open {
                    return NONE;
                }
                let other = size.index(x % size.width, y % size.height);
                if other != texel && inside(texel) && inside(other) { other } else { NONE }
            };
            (0..size.texels()).map(of).collect()
        };
        Self { right: next(1, 0), below: next(0, 1) }
    }

    /// Subtracts from each connected part its mean height.
    fn level_parts(&self, heights: &mut [f64]) {
        let mut part: Vec<usize> = (0..heights.len()).collect();
        for (texel, (&right, &below)) in self.right.iter().zip(&self.below).enumerate() {
            for other in [right, below].into_iter().filter(|other| *other != NONE) {
                let (a, b) = (root(&mut part, texel), root(&mut part, other));
                part[a.max(b)] = a.min(b);
            }
        }
        let mut sums = vec![(0.0, 0usize); heights.len()];
        for (texel, height) in heights.iter().enumerate() {
            let sum = &mut sums[root(&mut part, texel)];
            *sum = (sum.0 + height, sum.1 + 1);
        }
        for (texel, height) in heights.iter_mut().enumerate() {
            let (sum, count) = sums[root(&mut part, texel)];
            *height -= sum / count as f64;
        }
    }
}

/// The representative of the part that a texel belongs to; the way to it is shortened.
fn root(part: &mut [usize], mut texel: usize) -> usize {
    while part[texel] != texel {
        part[texel] = part[part[texel]];
        texel = part[texel];
    }
    texel
}

/// The weight of each pair of neighbours, and the product of weight and rise.
struct WeightedEdges {
    right: Vec<(f64, f64)>,
    below: Vec<(f64, f64)>,
}

impl WeightedEdges {
    /// Pairs weighted by the heights so far, or equally.
    fn of(graph: &Graph, slopes: &Slopes, heights: &[f64], by_heights: bool) -> Self {
        let cosine = |texel: usize| 1.0 / (1.0 + slopes.p[texel].powi(2) + slopes.q[texel].powi(2)).sqrt();
        let along = |next: &[usize], rise: &dyn Fn(usize) -> f64| {
            let mut before = vec![NONE; next.len()];
            for (texel, &other) in next.iter().enumerate().filter(|(_, other)| **other != NONE) {
                before[other] = texel;
            }
            let mut edges = vec![(0.0, 0.0); next.len()];
            for texel in 0..next.len() {
                let residual = |from: usize, to: usize| {
                    if from == NONE || to == NONE || !by_heights {
                        return 0.0;
                    }
                    ((heights[to] - heights[from] - rise(texel)) * cosine(texel)).powi(2)
                };
                let (ahead, behind) = (residual(texel, next[texel]), residual(before[texel], texel));
                let after = 1.0 / (1.0 + (STEEPNESS * (ahead - behind)).exp());
                let mut add = |edge: usize, weight: f64| {
                    edges[edge].0 += weight;
                    edges[edge].1 += weight * rise(texel);
                };
                if next[texel] != NONE {
                    add(texel, after);
                }
                if before[texel] != NONE {
                    add(before[texel], 1.0 - after);
                }
            }
            edges
        };
        Self {
            right: along(&graph.right, &|texel| slopes.p[texel]),
            below: along(&graph.below, &|texel| -slopes.q[texel]),
        }
    }

    /// The pairs: from, to, weight, and weight times rise.
    fn pairs<'a>(&'a self, graph: &'a Graph) -> impl Iterator<Item = (usize, usize, f64, f64)> + 'a {
        let of = |next: &'a [usize], edges: &'a [(f64, f64)]| {
            let all = next.iter().zip(edges).enumerate();
            all.filter(|(_, (to, _))| **to != NONE).map(|(from, (&to, &(w, rise)))| (from, to, w, rise))
        };
        of(&graph.right, &self.right).chain(of(&graph.below, &self.below))
    }

    /// Conjugate gradients from the heights so far.
    fn solve(&self, graph: &Graph, heights: &mut [f64], job: &Job) -> Result<()> {
        let count = heights.len();
        let (mut diagonal, mut rest) = (vec![0.0; count], vec![0.0; count]);
        for (from, to, weight, rise) in self.pairs(graph) {
            diagonal[from] += weight;
            diagonal[to] += weight;
            let left = rise - weight * (heights[to] - heights[from]);
            rest[to] += left;
            rest[from] -= left;
        }
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let scaled = |rest: &[f64]| -> Vec<f64> {
            rest.iter().zip(&diagonal).map(|(r, d)| if *d > 1e-12 { r / d } else { 0.0 }).collect()
        };
        let mut conditioned = scaled(&rest);
        let mut direction = conditioned.clone();
        let mut square = dot(&rest, &conditioned);
        let enough = ENOUGH * ENOUGH * square;
        let mut image = vec![0.0; count];
        for _ in 0..10 * (count as f64).sqrt() as usize + 100 {
            if square <= enough || square <= 1e-18 {
                break;
            }
            job.proceed()?;
            image.fill(0.0);
            for (from, to, weight, _) in self.pairs(graph) {
                let flow = weight * (direction[to] - direction[from]);
                image[to] += flow;
                image[from] -= flow;
            }
            let along = dot(&direction, &image);
            if along <= 0.0 {
                break;
            }
            let step = square / along;
            heights.iter_mut().zip(&direction).for_each(|(h, d)| *h += step * d);
            rest.iter_mut().zip(&image).for_each(|(r, i)| *r -= step * i);
            conditioned = scaled(&rest);
            let next = dot(&rest, &conditioned);
            direction.iter_mut().zip(&conditioned).for_each(|(d, c)| *d = c + next / square * *d);
            square = next;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};
    use crate::surface::integrate::reference;

    fn random_slopes(size: Size) -> Slopes {
        let mut stream = Stream::new(9, Purpose::Sample, [size.texels() as u64]);
        let mut slopes = Slopes::level(size);
        slopes.p.iter_mut().chain(&mut slopes.q).for_each(|s| *s = 2.0 * stream.unit() - 1.0);
        slopes
    }

    fn solved(slopes: &Slopes, mask: Option<&[bool]>, how: Discontinuities) -> Vec<f32> {
        integrate_weighted(slopes, mask, SurfaceBorder::Open, how, &Job::default())
            .unwrap()
            .as_slice()
            .to_vec()
    }

    #[test]
    fn without_a_mask_it_is_the_poisson_solution() {
        for (width, height) in [(1, 1), (1, 7), (6, 1), (5, 8), (13, 11)] {
            let slopes = random_slopes(Size::new(width, height));
            for border in [SurfaceBorder::Open, SurfaceBorder::Periodic] {
                let truth = reference::poisson(&slopes, border);
                let found =
                    integrate_weighted(&slopes, None, border, Discontinuities::Smooth, &Job::default())
                        .unwrap();
                let worst = found
                    .as_slice()
                    .iter()
                    .zip(&truth)
                    .map(|(a, b)| (f64::from(*a) - b).abs())
                    .fold(0.0, f64::max);
                assert!(worst < 1e-4, "{width} x {height} {border:?}: {worst}");
            }
        }
    }

    #[test]
    fn what_lies_outside_the_mask_has_no_say_and_parts_are_level_each() {
        let size = Size::new(24, 16);
        let mut slopes = Slopes::level(size);
        // Two slopes with different rises on both sides of a gap full of nonsense.
        let mask: Vec<bool> = (0..size.texels()).map(|i| !(10..14).contains(&(i % 24))).collect();
        for (i, p) in slopes.p.iter_mut().enumerate() {
            *p = if !mask[i] {
                99.0
            } else if i % 24 < 10 {
                0.5
            } else {
                -0.25
            };
        }
        let heights = solved(&slopes, Some(&mask), Discontinuities::Smooth);
        for (i, height) in heights.iter().enumerate() {
            let x = (i % 24) as f32;
            let truth = match mask[i] {
                false => 0.0,
                true if i % 24 < 10 => 0.5 * (x - 4.5),
                true => -0.25 * (x - 18.5),
            };
            assert!((height - truth).abs() < 1e-3, "{x}: {height} {truth}");
        }
    }

    #[test]
    fn cliffs_stay_where_they_are_to_be_preserved() {
        // A raised square whose slopes say nothing of its sides.
        let size = Size::new(40, 32);
        let inside = |i: usize| (12..28).contains(&(i % 40)) && (8..24).contains(&(i / 40));
        let bowl = |i: usize| {
            let (x, y) = ((i % 40) as f64 - 20.0, (i / 40) as f64 - 16.0);
            (0.16 * x, -0.16 * y)
        };
        let mut slopes = Slopes::level(size);
        for i in 0..size.texels() {
            let (p, q) = bowl(i);
            (slopes.p[i], slopes.q[i]) = if inside(i) { (p, q) } else { (1.0, 0.0) };
        }
        let flat_join = solved(&slopes, None, Discontinuities::Smooth);
        let kept = solved(&slopes, None, Discontinuities::Preserve);
        let rough = |heights: &[f32]| {
            // The error of the slope inside the square, away from its sides.
            let at = |x: usize, y: usize| f64::from(heights[size.index(x, y)]);
            (13..26).map(|x| (at(x + 1, 16) - at(x, 16) - 0.16 * (x as f64 + 0.5 - 20.0)).abs()).sum::<f64>()
        };
        assert!(rough(&kept) < 0.5 * rough(&flat_join), "{} {}", rough(&kept), rough(&flat_join));
    }

    #[test]
    fn masks_that_do_not_fit_are_refused() {
        let slopes = Slopes::level(Size::new(3, 3));
        let refused = |mask: &[bool]| {
            let how = Discontinuities::Smooth;
            let error = integrate_weighted(&slopes, Some(mask), SurfaceBorder::Open, how, &Job::default());
            error.unwrap_err().to_string()
        };
        assert!(refused(&[true; 4]).contains("the mask has 4 texels"));
        assert!(refused(&[false; 9]).contains("leaves no texel"));
    }
}
