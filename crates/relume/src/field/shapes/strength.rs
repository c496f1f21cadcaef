//! How far the corrections are to be trusted: the factors by which each photograph is best predicted from the others.
//!
//! With light j left out, r is what linear interpolation of the others lacks of photograph j, and g and h are the whole
//! corrections of shadows and highlights; the factors minimise the sum of (r - a g - b h)² over texels, channels and lights.
//! Without a light the gap between its neighbours is twice as wide, and in the four captures of the benchmark SynthRTI the
//! best factor of highlights, which are small, is about half as large between the lights as in such a gap; that of shadows is
//! the same.

use super::{Shapes, contrasts, texel};
use crate::error::Result;
use crate::field::Interpolated;
use crate::job::Job;
use crate::parallel;

/// Texels that are predicted, in whole rows.
const SAMPLE: usize = 16_384;

/// What of the factor of highlights is taken.
const HIGHLIGHT_SHARE: f64 = 0.5;

/// The largest factors.
const MOST: [f64; 2] = [0.7, 0.5];

/// A penalty on the factors, of squared values: without shadows or highlights they are zero.
const RIDGE: f64 = 1e-6;

/// Sums of products of the corrections with each other and with what is to be corrected.
#[derive(Debug, Clone, Copy, Default)]
struct LeftOutSums {
    squares: [f64; 2],
    mixed: f64,
    wanted: [f64; 2],
}

/// The factors of shadows and highlights.
pub(super) fn by_leaving_out(shapes: &Shapes<'_>, lights: &Interpolated, job: &Job) -> Result<[f32; 2]> {
    let of_light = |j: usize| {
        job.proceed()?;
        Ok(without(shapes, lights, j).unwrap_or_default())
    };
    let all: Result<Vec<LeftOutSums>> = parallel::try_map(0..lights.lights().len(), of_light);
    let sums = all?.into_iter().fold(LeftOutSums::default(), |sums, one| LeftOutSums {
        squares: [sums.squares[0] + one.squares[0], sums.squares[1] + one.squares[1]],
        mixed: sums.mixed + one.mixed,
        wanted: [sums.wanted[0] + one.wanted[0], sums.wanted[1] + one.wanted[1]],
    });
    let [a, d] = sums.squares.map(|square| square + RIDGE);
    let determinant = a * d - sums.mixed * sums.mixed;
    let [p, q] = sums.wanted;
    let factors = [d * p - sums.mixed * q, HIGHLIGHT_SHARE * (a * q - sums.mixed * p)];
    let factor = |k: usize| (factors[k] / determinant).clamp(0.0, MOST[k]) as f32;
    Ok(if determinant > 0.0 { [factor(0), factor(1)] } else { [0.0; 2] })
}

/// The products with light `j` left out; `None` where the others do not suffice.
fn without(shapes: &Shapes<'_>, lights: &Interpolated, j: usize) -> Option<LeftOutSums> {
    let light = lights.lights()[j];
    let others = lights.without(j)?;
    let mut weights = vec![0.0; lights.lights().len() - 1];
    others.weights_into(light, &mut weights);
    weights.insert(j, 0.0);
    let weights: Vec<f32> = weights.into_iter().map(|w| w as f32).collect();
    let (field, terms, n) = (shapes.field, texel::terms(light), weights.len());
    let size = field.size();
    let step = (size.texels() / SAMPLE).max(1);
    let mut products = LeftOutSums::default();
    let mut linear = vec![0.0f32; size.width];
    for y in (step / 2..size.height).step_by(step) {
        let first = y * size.width;
        let moved = shapes.moved(&weights, first, size.width);
        for c in 0..field.layout().channels() {
            let photograph = |i: usize| &field.coefficients().plane(c * n + i)[first..][..size.width];
            linear.fill(0.0);
            for (i, weight) in weights.iter().enumerate() {
                linear.iter_mut().zip(photograph(i)).for_each(|(sum, value)| *sum += weight * value);
            }
            for (t, (truth, linear)) in photograph(j).iter().zip(&linear).enumerate() {
                let contrasts = contrasts(shapes.levels_of(first + t, c), terms);
                let [g, h] = [0, 1].map(|k| f64::from(moved[k][t] * contrasts[k]));
                let lacking = f64::from(truth - linear.clamp(0.0, 1.0));
                products.squares[0] += g * g;
                products.squares[1] += h * h;
                products.mixed += g * h;
                products.wanted[0] += g * lacking;
                products.wanted[1] += h * lacking;
            }
        }
    }
    Some(products)
}
