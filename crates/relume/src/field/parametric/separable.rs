//! The matrix factorisation of each texel by itself: B(v, l) = Σ g_k(v) h_k(l), where g_k is a function of the view and h_k one of
//! the light in each channel, both as tables of measured directions (of reflectances: J. Kautz, M. D. McCool, "Interactive
//! Rendering with Arbitrary BRDFs using Separable Approximations", Rendering Techniques 1999; of the texels of a texture: F.
//! Suykens, K. vom Berge, A. Lagae, P. Dutré, "Interactive Rendering with Bidirectional Texture Functions", Eurographics 2003).
//!
//! The numbers of a texel are, product after product, the values of the function of the view, then channel after channel
//! those of the function of the light. Between measured directions both are linear in the triangles of [`Triangulation`],
//! and beyond the last ring the nearest point of its border counts.

use std::sync::Arc;

use super::per_view::{MOST_NUMBERS, check_directions};
use crate::direction::{Direction, Directions};
use crate::error::{Error, Result};
use crate::field::{Basis, Interpolated, Interpolation, PlaneLayout, ReflectanceField};
use crate::job::Job;
use crate::numeric::between::{Shares, Triangulation};
use crate::planes::Planes;
use crate::space::Space;

/// The most products.
pub const MOST_PRODUCTS: usize = 16;

/// The directions of separable texels, and the number of their products.
#[derive(Debug, Clone)]
pub struct SeparableModel {
    views: Arc<[Direction]>,
    lights: Arc<[Direction]>,
    around: Arc<[Triangulation; 2]>,
    products: usize,
    space: Space,
}

/// The measured views and lights around a pair.
#[derive(Debug, Clone, Copy)]
pub(super) struct SeparableShares {
    views: Shares,
    lights: Shares,
}

impl SeparableModel {
    /// So many products of functions of distinct views and lights, with values in a space.
    ///
    /// # Errors
    /// No product or too many, no view or light or too many, and two that are equal.
    pub fn new(views: &[Direction], lights: &[Direction], products: usize, space: Space) -> Result<Self> {
        if !(1..=MOST_PRODUCTS).contains(&products) {
            return Err(Error::invalid(format!(
                "a texel is a sum of 1 to {MOST_PRODUCTS} products, not of {products}"
            )));
        }
        check_directions("separable texels", "view", views)?;
        check_directions("separable texels", "light", lights)?;
        let model = Self {
            views: views.into(),
            lights: lights.into(),
            around: Arc::new([Triangulation::new(views), Triangulation::new(lights)]),
            products,
            space,
        };
        let numbers = model.numbers(3);
        if numbers > MOST_NUMBERS {
            return Err(Error::invalid(format!(
                "{products} products of {} views and {} lights have {numbers} numbers a texel: more than {MOST_NUMBERS} are not kept",
                views.len(),
                lights.len()
            )));
        }
        Ok(model)
    }

    /// The measured views.
    pub fn views(&self) -> &[Direction] {
        &self.views
    }

    /// The measured lights.
    pub fn lights(&self) -> &[Direction] {
        &self.lights
    }

    /// The number of products.
    pub fn products(&self) -> usize {
        self.products
    }

    /// The space of the values.
    pub fn space(&self) -> Space {
        self.space
    }

    /// The numbers of a texel of so many channels.
    pub fn numbers(&self, channels: usize) -> usize {
        self.products * self.of_product(channels)
    }

    /// The numbers of one product.
    fn of_product(&self, channels: usize) -> usize {
        self.views.len() + channels * self.lights.len()
    }

    pub(super) fn names(&self, channels: &[&str]) -> Vec<String> {
        let of_product = |k: usize| {
            let of_views = (0..self.views.len()).map(move |v| format!("product{k}.view{v}"));
            let of_channel = move |c: &&str| {
                (0..self.lights.len()).map(move |l| format!("product{k}.light{l}.{c}")).collect::<Vec<_>>()
            };
            of_views.chain(channels.iter().flat_map(of_channel))
        };
        (0..self.products).flat_map(of_product).collect()
    }

    pub(super) fn shares(&self, pair: Directions) -> SeparableShares {
        let [views, lights] = &*self.around;
        SeparableShares { views: views.shares(pair.view), lights: lights.shares(pair.light) }
    }

    /// The values of adjacent texels from `first` on, a row for each channel.
    pub(super) fn rows_into(
        &self,
        shares: &SeparableShares,
        planes: &Planes,
        first: usize,
        out: &mut [&mut [f32]],
    ) {
        let (channels, texels) = (out.len(), first..first + out[0].len());
        let mut sums = vec![vec![0.0; texels.len()]; channels];
        let (mut of_view, mut of_light) = (vec![0.0; texels.len()], vec![0.0; texels.len()]);
        for number in self.firsts(channels) {
            let row = |k: usize| &planes.plane(number + k)[texels.clone()];
            blend(&shares.views, row, &mut of_view);
            for (c, sums) in sums.iter_mut().enumerate() {
                blend(
                    &shares.lights,
                    |light| row(self.views.len() + c * self.lights.len() + light),
                    &mut of_light,
                );
                let products = of_view.iter().zip(&of_light);
                sums.iter_mut().zip(products).for_each(|(sum, (a, b))| *sum += a * b);
            }
        }
        for (out, sums) in out.iter_mut().zip(&sums) {
            out.iter_mut().zip(sums).for_each(|(value, sum)| *value = *sum as f32);
        }
    }

    /// The functions of the light that are seen from a view: tables of the same lights.
    pub(super) fn seen_from(
        &self,
        view: Direction,
        planes: &Planes,
        channels: usize,
        job: &Job,
    ) -> Result<ReflectanceField> {
        let basis = Basis::Interpolated(Interpolated::new(&self.lights, Interpolation::Triangles)?);
        let count = channels * self.lights.len();
        let mut out = Planes::zeros_within(job, "the functions seen from above", planes.size(), count)?;
        let [views, _] = &*self.around;
        for first in self.firsts(channels) {
            let mut of_view = vec![0.0; planes.size().texels()];
            blend(&views.shares(view), |v| planes.plane(first + v), &mut of_view);
            for (k, plane) in out.iter_mut().enumerate() {
                job.proceed()?;
                let values = of_view.iter().zip(planes.plane(first + self.views.len() + k));
                plane.iter_mut().zip(values).for_each(|(sum, (a, b))| *sum += *a as f32 * b);
            }
        }
        let layout = if channels == 1 { PlaneLayout::LUMINANCE } else { PlaneLayout::RGB };
        ReflectanceField::new(basis, layout, self.space, out)
    }

    /// The place of the first number of each product.
    fn firsts(&self, channels: usize) -> impl Iterator<Item = usize> {
        let own = self.of_product(channels);
        (0..self.products).map(move |k| k * own)
    }
}

/// The sum of rows by their shares.
fn blend<'a>(shares: &Shares, row: impl Fn(usize) -> &'a [f32], out: &mut [f64]) {
    out.fill(0.0);
    for &(i, share) in shares.iter().filter(|(_, share)| *share != 0.0) {
        out.iter_mut().zip(row(i)).for_each(|(sum, value)| *sum += share * f64::from(*value));
    }
}

/// Equal directions and products: the triangles follow from the directions.
impl PartialEq for SeparableModel {
    fn eq(&self, other: &Self) -> bool {
        let own = (&self.views, &self.lights, self.products, self.space);
        own == (&other.views, &other.lights, other.products, other.space)
    }
}
