//! Products of functions of the view and of the light for each texel: the leading singular vectors of its matrix of values, whose
//! rows are views and whose columns are lights and channels.
//!
//! They are found by orthogonal iteration on the product of the matrix with its transpose, and exactly within the space that
//! this reaches (Golub, Van Loan, "Matrix Computations", sections 8.2.4 and 8.3.2).

use crate::direction::{Direction, Directions};
use crate::error::{Error, Result};
use crate::numeric::between::PairGrid;
use crate::numeric::random::{Purpose, Stream};
use crate::numeric::{Matrix, dot, eigen};

/// Vectors of the iteration beyond those that are asked for.
const BESIDE: usize = 4;
/// Rounds of the iteration.
const ROUNDS: usize = 6;

/// The photographs of each light with each view.
pub(super) struct PhotographGrid {
    pub views: Vec<Direction>,
    pub lights: Vec<Direction>,
    /// Their numbers, view by view.
    pub photographs: Vec<usize>,
}

impl PhotographGrid {
    /// Of the photographs of those numbers, of which `directions` gives the light and the view.
    ///
    /// # Errors
    /// Pairs that are not each light with each view, once.
    pub fn new(numbers: &[usize], directions: impl Fn(usize) -> Directions) -> Result<Self> {
        let pairs: Vec<Directions> = numbers.iter().map(|&i| directions(i)).collect();
        let grid = PairGrid::new(&pairs).ok_or_else(|| {
            Error::usage(format!(
                "products of functions of the view and of the light need each light with each view, once, and the {} photographs that \
                 are fitted are others: fit another model, or fill what is missing with --missing fill",
                pairs.len()
            ))
        })?;
        let (views, lights) = (grid.views().points().len(), grid.lights().points().len());
        let pair = |view: usize, light: usize| grid.pair(light, view);
        Ok(Self {
            views: (0..views).map(|view| pairs[pair(view, 0)].view).collect(),
            lights: (0..lights).map(|light| pairs[pair(0, light)].light).collect(),
            photographs: (0..views * lights).map(|i| numbers[pair(i / lights, i % lights)]).collect(),
        })
    }
}

/// The factorisation of a texel.
pub(super) struct TexelFactors {
    views: usize,
    lights: usize,
    channels: usize,
    products: usize,
    /// From which the iteration begins, the same of all texels.
    start: Vec<Vec<f32>>,
}

impl TexelFactors {
    pub fn new(grid: &PhotographGrid, channels: usize, products: usize) -> Self {
        let views = grid.views.len();
        let vector = |k: usize| {
            let mut stream = Stream::new(0, Purpose::TexelFactors, [k as u64]);
            (0..views).map(|_| stream.unit() as f32 - 0.5).collect()
        };
        let start = (0..views.min(products + BESIDE)).map(vector).collect();
        Self { views, lights: grid.lights.len(), channels, products, start }
    }

    /// The numbers of a texel: of each product the function of the view, and those of the light of each channel. `values` are
    /// those of the photographs, view by view, all channels of a photograph adjacent.
    pub fn fit(&self, values: &[f32]) -> Vec<f32> {
        let columns = self.lights * self.channels;
        let row = |view: usize| &values[view * columns..][..columns];
        let gram: Vec<f32> = (0..self.views * self.views)
            .map(|i| (i / self.views, i % self.views))
            .map(|(a, b)| if b <= a { dot(row(a), row(b)) } else { 0.0 })
            .collect();
        let gram = |a: usize, b: usize| gram[a.max(b) * self.views + a.min(b)];
        let times = |vector: &[f32]| -> Vec<f32> {
            (0..self.views).map(|a| (0..self.views).map(|b| gram(a, b) * vector[b]).sum()).collect()
        };
        let mut vectors = self.start.clone();
        for _ in 0..ROUNDS {
            vectors = vectors.iter().map(|vector| times(vector)).collect();
            orthonormalise(&mut vectors);
        }
        let mut numbers = Vec::with_capacity(self.products * (self.views + columns));
        for of_view in leading(&vectors, &times, self.products) {
            let mut of_light = vec![0.0; columns];
            for (view, factor) in of_view.iter().enumerate() {
                of_light.iter_mut().zip(row(view)).for_each(|(sum, value)| *sum += factor * value);
            }
            // Both functions have the same share of the singular value.
            let scale = dot(&of_light, &of_light).sqrt().sqrt();
            let inverse = if scale > 0.0 { scale.recip() } else { 0.0 };
            numbers.extend(of_view.iter().map(|value| value * scale));
            let of_channel =
                |c: usize| of_light.iter().skip(c).step_by(self.channels).map(|value| value * inverse);
            (0..self.channels).for_each(|c| numbers.extend(of_channel(c)));
        }
        numbers.resize(self.products * (self.views + columns), 0.0);
        numbers
    }
}

/// The leading eigenvectors within the space of orthonormal vectors, with sums that are not negative.
fn leading(vectors: &[Vec<f32>], times: &impl Fn(&[f32]) -> Vec<f32>, count: usize) -> Vec<Vec<f32>> {
    let images: Vec<Vec<f32>> = vectors.iter().map(|vector| times(vector)).collect();
    let within = Matrix::from_fn(vectors.len(), vectors.len(), |i, j| {
        f64::from(dot(&vectors[i.max(j)], &images[i.min(j)]))
    });
    let (_, axes) = eigen::symmetric(&within);
    let of_axis = |k: usize| {
        let mut sum = vec![0.0f32; vectors[0].len()];
        for (vector, share) in vectors.iter().zip(axes.row(k)) {
            sum.iter_mut().zip(vector).for_each(|(s, v)| *s += *share as f32 * v);
        }
        if sum.iter().sum::<f32>() < 0.0 {
            sum.iter_mut().for_each(|v| *v = -*v);
        }
        sum
    };
    (0..count.min(vectors.len())).map(of_axis).collect()
}

/// Makes vectors orthonormal, one after another; those that depend on others become zero.
fn orthonormalise(vectors: &mut [Vec<f32>]) {
    for k in 0..vectors.len() {
        let (before, rest) = vectors.split_at_mut(k);
        let vector = &mut rest[0];
        let own = dot(vector, vector).sqrt();
        // Twice is enough against rounding (Kahan, in Parlett, "The Symmetric Eigenvalue Problem", section 6.9).
        for _ in 0..2 {
            for other in before.iter() {
                let share = dot(vector, other);
                vector.iter_mut().zip(other).for_each(|(v, o)| *v -= share * o);
            }
        }
        let length = dot(vector, vector).sqrt();
        let scale = if length > 1e-6 * own { length.recip() } else { 0.0 };
        vector.iter_mut().for_each(|v| *v *= scale);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::learned::exact;

    fn grid(views: usize, lights: usize) -> PhotographGrid {
        let direction = |i: usize| Direction::from_angles(0.1 + 0.05 * i as f64, 2.4 * i as f64);
        let all = |count: usize| (0..count).map(direction).collect::<Vec<_>>();
        PhotographGrid { views: all(views), lights: all(lights), photographs: (0..views * lights).collect() }
    }

    /// The squares of what products leave of a texel.
    fn left(factors: &TexelFactors, values: &[f32]) -> f64 {
        let numbers = factors.fit(values);
        let own = numbers.len() / factors.products;
        let value = |i: usize| {
            let (view, light, c) = (
                i / factors.channels / factors.lights,
                i / factors.channels % factors.lights,
                i % factors.channels,
            );
            let product = |k: usize| {
                let numbers = &numbers[k * own..][..own];
                f64::from(numbers[view]) * f64::from(numbers[factors.views + c * factors.lights + light])
            };
            (0..factors.products).map(product).sum::<f64>()
        };
        values.iter().enumerate().map(|(i, v)| (f64::from(*v) - value(i)).powi(2)).sum()
    }

    #[test]
    fn products_are_nearly_those_of_the_exact_decomposition() {
        let grid = grid(12, 15);
        let mut stream = Stream::new(5, Purpose::Sample, []);
        // A matt part, a highlight that moves with the view, and noise.
        let values: Vec<f32> = (0..12 * 15 * 3)
            .map(|i| {
                let (view, light) = (grid.views[i / 45], grid.lights[i / 3 % 15]);
                let half =
                    Direction::new(view.x() + light.x(), view.y() + light.y(), view.z() + light.z()).unwrap();
                (0.5 * light.z() + half.z().powi(60) + 0.05 * stream.unit()) as f32
            })
            .collect();
        let matrix = Matrix::from_fn(12, 45, |r, c| f64::from(values[r * 45 + c]));
        let errors = exact(&matrix);
        for products in [1, 2, 4] {
            let truth = values.len() as f64 * errors[products - 1].powi(2);
            let found = left(&TexelFactors::new(&grid, 3, products), &values);
            assert!(found < 1.01 * truth && found > 0.999 * truth, "{products}: {found} and {truth}");
        }
    }

    #[test]
    fn texels_of_fewer_products_than_asked_for_are_exact() {
        let grid = grid(3, 4);
        let values: Vec<f32> = (0..12).map(|i| (1 + i / 4) as f32 * (0.1 + 0.2 * (i % 4) as f32)).collect();
        assert!(left(&TexelFactors::new(&grid, 1, 5), &values) < 1e-9);
        assert_eq!(TexelFactors::new(&grid, 1, 2).fit(&[0.0; 12]), [0.0; 14]);
    }
}
