//! Index planes: coordinates in which the Euclidean distance of two texels is the distance of
//! their functions.
//!
//! The distance of two functions is dc' G dc with the Gram matrix G over a domain. With the
//! functions taken in graded order and G = L L', the coordinates b = L' c do it: this is the
//! Gram-Schmidt process, and over the square it gives the Legendre basis of Hel-Or, Malzbender,
//! Gelb, "Synthesis of Reflectance Function Textures from Examples" (HPL-2003-16, section 5.2).
//! Their printed matrix M turns *basis functions* (B = M A); coefficients need its inverse
//! transpose, b = M^-T a. Its closed form, b0 = 2 a5 + 2/3 (a0 + a1) and so on, is a test here.

use rayon::prelude::*;
use serde::Serialize;

use super::{Basis, ColorModel, Domain, ReflectanceField, lrgb};
use crate::error::{Error, Result};
use crate::numeric::Matrix;
use crate::planes::Planes;

/// What the distance of two texels means.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Metric {
    /// The distance of the coloured functions over the chosen domain: for LRGB the products
    /// (b_0..b_5) x (R, G, B).
    Function,
    /// The nine numbers of the report: Legendre coordinates of the luminance over the square, and
    /// the unscaled colour. LRGB fields only.
    Legendre9,
    /// The six numbers of the conference version: Legendre coordinates of the luminance alone.
    /// LRGB and luminance fields only.
    Legendre6,
}

/// The map from coefficients to index planes, and back.
#[derive(Debug, Clone)]
pub struct IndexSpace {
    metric: Metric,
    basis: Basis,
    color: ColorModel,
    /// b = forward c.
    forward: Matrix,
    /// c = backward b.
    backward: Matrix,
}

impl IndexSpace {
    /// The index space of fields like `field`.
    ///
    /// # Errors
    /// When the metric is not defined for the field's colour model.
    pub fn new(field: &ReflectanceField, metric: Metric, domain: Domain) -> Result<Self> {
        let (basis, color) = (field.basis(), field.color());
        let (defined, domain) = match metric {
            Metric::Function => (true, domain),
            Metric::Legendre9 => (color == ColorModel::Lrgb, Domain::Square),
            Metric::Legendre6 => (color != ColorModel::Rgb, Domain::Square),
        };
        if !defined {
            return Err(Error::usage(format!(
                "the metric {metric:?} compares a luminance function and does not exist for {} fields: use the metric function",
                color.name()
            )));
        }
        let n = basis.len();
        let order = basis.graded_order();
        let gram = basis.gram(domain);
        let factor = Matrix::from_fn(n, n, |j, k| gram[(order[j], order[k])]).cholesky()?;
        let inverse = factor.lower_inverse();
        let place = |k: usize| order.iter().position(|&o| o == k).expect("graded orders are permutations");
        Ok(Self {
            metric,
            basis,
            color,
            forward: Matrix::from_fn(n, n, |j, k| factor[(place(k), j)]),
            backward: Matrix::from_fn(n, n, |k, j| inverse[(j, place(k))]),
        })
    }

    /// The number of index planes.
    pub fn planes(&self) -> usize {
        let n = self.basis.len();
        match (self.metric, self.color) {
            (Metric::Function, color) => n * color.channels(),
            (Metric::Legendre9, _) => n + 3,
            (Metric::Legendre6, _) => n,
        }
    }

    /// The index planes of a field.
    ///
    /// # Panics
    /// When the field's basis or colour model is not the one this space was made for.
    pub fn index_planes(&self, field: &ReflectanceField) -> Planes {
        assert_eq!((field.basis(), field.color()), (self.basis, self.color), "the space of another field");
        let (n, size, source) = (self.basis.len(), field.size(), field.coefficients());
        let mut planes = Planes::zeros(size, self.planes());
        planes.as_mut_slice().par_chunks_exact_mut(size.texels()).enumerate().for_each(|(p, out)| {
            let product = self.metric == Metric::Function && self.color == ColorModel::Lrgb;
            if self.metric == Metric::Legendre9 && p >= n {
                out.copy_from_slice(source.plane(p));
                return;
            }
            let first = if product { 0 } else { p / n * n };
            combine(self.forward.row(p % n), source, first, out);
            if product {
                out.iter_mut().zip(source.plane(n + p / n)).for_each(|(o, c)| *o *= c);
            }
        });
        planes
    }

    /// The field of given index planes: the inverse of [`IndexSpace::index_planes`]. Index
    /// planes of an LRGB field under [`Metric::Function`] become the nearest product of a
    /// luminance and a colour, which is exact where they are one.
    ///
    /// # Errors
    /// When the number of planes is wrong, or the metric keeps too little ([`Metric::Legendre6`]
    /// of an LRGB field forgets the colour).
    pub fn field(&self, like: &ReflectanceField, index: &Planes) -> Result<ReflectanceField> {
        if index.count() != self.planes() {
            return Err(Error::invalid(format!(
                "this index space has {} planes, found {}",
                self.planes(),
                index.count()
            )));
        }
        let n = self.basis.len();
        let mut coefficients = Planes::zeros(index.size(), self.color.planes(n));
        match (self.metric, self.color) {
            (Metric::Legendre6, ColorModel::Lrgb) => {
                return Err(Error::usage(
                    "the metric legendre6 keeps no colour, so no LRGB field can be made from its planes",
                ));
            }
            (Metric::Function, ColorModel::Lrgb) => self.nearest_products(index, &mut coefficients),
            _ => {
                for (p, out) in coefficients.iter_mut().enumerate() {
                    if self.color == ColorModel::Lrgb && p >= n {
                        out.copy_from_slice(index.plane(p));
                    } else {
                        combine(self.backward.row(p % n), index, p / n * n, out);
                    }
                }
            }
        }
        like.with_coefficients(coefficients)
    }

    /// Splits each texel's 3 n coordinates into a luminance function and a colour.
    fn nearest_products(&self, index: &Planes, coefficients: &mut Planes) {
        let n = self.basis.len();
        let mut channels = vec![0.0f32; 3 * n];
        let mut luminance = vec![0.0f32; n];
        for texel in 0..index.size().texels() {
            for (p, value) in channels.iter_mut().enumerate() {
                *value = index.plane(p)[texel];
            }
            let (red, rest) = channels.split_at(n);
            let (green, blue) = rest.split_at(n);
            let color = lrgb::nearest_product([red, green, blue], &mut luminance);
            for k in 0..n {
                let sum: f64 = (0..n).map(|j| self.backward[(k, j)] * f64::from(luminance[j])).sum();
                coefficients.plane_mut(k)[texel] = sum as f32;
            }
            for (c, value) in color.into_iter().enumerate() {
                coefficients.plane_mut(n + c)[texel] = value;
            }
        }
    }
}

/// out = sum_k weights_k plane_(first + k), skipping zero weights.
fn combine(weights: &[f64], planes: &Planes, first: usize, out: &mut [f32]) {
    out.fill(0.0);
    for (k, &weight) in weights.iter().enumerate().filter(|(_, w)| **w != 0.0) {
        let weight = weight as f32;
        out.iter_mut().zip(planes.plane(first + k)).for_each(|(o, v)| *o += weight * v);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};
    use crate::planes::Size;
    use crate::space::Space;

    fn random_field(basis: Basis, color: ColorModel, seed: u64) -> ReflectanceField {
        let mut stream = Stream::new(seed, Purpose::Sample, [0]);
        let size = Size::new(5, 3);
        let count = color.planes(basis.len());
        let data = (0..size.texels() * count).map(|_| stream.unit() as f32 * 2.0 - 0.7).collect();
        let mut planes = Planes::from_vec(size, count, data).unwrap();
        if color == ColorModel::Lrgb {
            // Colours are not negative; black texels have none.
            (basis.len()..count)
                .for_each(|k| planes.plane_mut(k).iter_mut().for_each(|v| *v = v.abs() + 0.1));
        }
        ReflectanceField::new(basis, color, Space::Linear, planes).unwrap()
    }

    fn members() -> impl Iterator<Item = (Basis, ColorModel)> {
        let colors = [ColorModel::Luminance, ColorModel::Rgb, ColorModel::Lrgb];
        Basis::ALL.into_iter().flat_map(move |basis| colors.into_iter().map(move |color| (basis, color)))
    }

    /// The channel functions of a texel as coefficient vectors.
    fn channel_functions(field: &ReflectanceField, texel: usize) -> Vec<Vec<f64>> {
        let n = field.basis().len();
        let c = |k: usize| f64::from(field.coefficients().plane(k)[texel]);
        match field.color() {
            ColorModel::Luminance => vec![(0..n).map(c).collect()],
            ColorModel::Rgb => (0..3).map(|ch| (0..n).map(|k| c(ch * n + k)).collect()).collect(),
            ColorModel::Lrgb => (0..3).map(|ch| (0..n).map(|k| c(k) * c(n + ch)).collect()).collect(),
        }
    }

    #[test]
    fn index_distance_is_the_integrated_distance_of_the_functions() {
        for (basis, color) in members() {
            let field = random_field(basis, color, 7);
            for domain in Domain::ALL {
                let index = IndexSpace::new(&field, Metric::Function, domain).unwrap().index_planes(&field);
                for (a, b) in [(0, 1), (2, 9), (14, 3)] {
                    let distance: f64 = (0..index.count())
                        .map(|k| f64::from(index.plane(k)[a] - index.plane(k)[b]).powi(2))
                        .sum();
                    let (fa, fb) = (channel_functions(&field, a), channel_functions(&field, b));
                    let truth = domain.integrate(12, |u, v| {
                        let weights = basis.weights_at(u, v);
                        let channel = |(ca, cb): (&Vec<f64>, &Vec<f64>)| -> f64 {
                            weights
                                .iter()
                                .zip(ca.iter().zip(cb))
                                .map(|(w, (x, y))| w * (x - y))
                                .sum::<f64>()
                                .powi(2)
                        };
                        fa.iter().zip(&fb).map(channel).sum()
                    });
                    let error = (distance - truth).abs() / truth;
                    assert!(error < 1e-5, "{basis:?} {color:?} {domain:?}: {distance} vs {truth}");
                }
            }
        }
    }

    #[test]
    fn the_way_back_is_exact_to_rounding() {
        for (basis, color) in members() {
            let field = random_field(basis, color, 11);
            for domain in Domain::ALL {
                let space = IndexSpace::new(&field, Metric::Function, domain).unwrap();
                let back = space.field(&field, &space.index_planes(&field)).unwrap();
                for texel in 0..field.size().texels() {
                    let pairs =
                        channel_functions(&field, texel).into_iter().zip(channel_functions(&back, texel));
                    for (x, y) in pairs.flat_map(|(a, b)| a.into_iter().zip(b)) {
                        assert!((x - y).abs() < 2e-5, "{basis:?} {color:?} {domain:?}: {x} vs {y}");
                    }
                }
            }
        }
    }

    #[test]
    fn legendre_coordinates_are_the_documents_corrected() {
        let field = random_field(Basis::Ptm, ColorModel::Lrgb, 3);
        let index =
            IndexSpace::new(&field, Metric::Legendre9, Domain::Hemisphere).unwrap().index_planes(&field);
        let (s3, s45) = (3f64.sqrt(), 45f64.sqrt());
        for texel in 0..field.size().texels() {
            let a: Vec<f64> = (0..9).map(|k| f64::from(field.coefficients().plane(k)[texel])).collect();
            let b = [
                2.0 * a[5] + 2.0 / 3.0 * (a[0] + a[1]),
                2.0 / s3 * a[3],
                2.0 / s3 * a[4],
                2.0 / 3.0 * a[2],
                4.0 / s45 * a[0],
                4.0 / s45 * a[1],
                a[6],
                a[7],
                a[8],
            ];
            for (k, truth) in b.into_iter().enumerate() {
                assert!((f64::from(index.plane(k)[texel]) - truth).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn metrics_without_meaning_are_refused() {
        let rgb = random_field(Basis::Ptm, ColorModel::Rgb, 1);
        assert!(IndexSpace::new(&rgb, Metric::Legendre9, Domain::Square).is_err());
        assert!(IndexSpace::new(&rgb, Metric::Legendre6, Domain::Square).is_err());
        let luminance = random_field(Basis::Ptm, ColorModel::Luminance, 1);
        assert!(IndexSpace::new(&luminance, Metric::Legendre9, Domain::Square).is_err());
        assert_eq!(IndexSpace::new(&luminance, Metric::Legendre6, Domain::Square).unwrap().planes(), 6);
    }
}
