//! Index planes: coordinates in which the Euclidean distance of two texels is the distance of
//! their functions.
//!
//! The distance of two functions is dc' G dc with the Gram matrix G over a domain. With the functions in
//! graded order and G = L L', the coordinates b = L' c have this distance. This is the Gram-Schmidt process,
//! and over the square it gives the Legendre basis of Hel-Or, Malzbender, Gelb, "Synthesis of Reflectance
//! Function Textures from Examples" (HPL-2003-16, section 5.2). Their printed matrix M transforms *basis
//! functions* (B = M A); coefficients need its inverse transpose, b = M^-T a. Its closed form, b0 = 2 a5 +
//! 2/3 (a0 + a1) and so on, is a test here. Orthogonal functions are only scaled, so a basis of any length
//! needs no matrix.

use serde::Serialize;

use super::coordinates::OrthonormalMap;
use super::{Basis, Domain, PlaneLayout, ReflectanceField, lrgb};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::parallel;
use crate::planes::Planes;

/// Texels of a plane between two questions whether the job goes on.
const PART: usize = 1 << 18;

/// The meaning of the distance of two texels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Metric {
    /// The distance of the functions of all channels: for LRGB the products (b_0..b_n) x (R, G, B).
    Function,
    /// The sum of the distances of the luminance functions and of the unscaled colours. LRGB fields only.
    /// Over the square it is that of the nine numbers of report HPL-2003-16.
    LuminanceAndColor,
    /// The distance of the luminance functions alone. LRGB and luminance fields only. Over the
    /// square it is that of the six numbers of the conference version.
    Luminance,
}

impl Metric {
    /// The name used in messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Function => "function",
            Self::LuminanceAndColor => "luminance-and-color",
            Self::Luminance => "luminance",
        }
    }

    fn is_defined_for(self, layout: &PlaneLayout) -> bool {
        match self {
            Self::Function => true,
            Self::LuminanceAndColor => layout.is_product(),
            Self::Luminance => layout.is_product() || *layout == PlaneLayout::LUMINANCE,
        }
    }
}

/// The map from coefficients to index planes, and back.
#[derive(Debug, Clone)]
pub struct IndexSpace {
    metric: Metric,
    basis: Basis,
    layout: PlaneLayout,
    coordinates: OrthonormalMap,
}

impl IndexSpace {
    /// The index space of fields like `field`.
    ///
    /// # Errors
    /// When the metric is not defined for the layout of the field, or its basis not over the domain.
    pub fn new(field: &ReflectanceField, metric: Metric, domain: Domain) -> Result<Self> {
        let (basis, layout) = (field.basis().clone(), field.layout().clone());
        if !metric.is_defined_for(&layout) {
            return Err(Error::usage(format!(
                "the metric {} compares a luminance function and does not exist for {} fields: use the metric function",
                metric.name(),
                layout.name()
            )));
        }
        let coordinates = OrthonormalMap::new(&basis, domain)?;
        Ok(Self { metric, basis, layout, coordinates })
    }

    /// The number of index planes.
    pub fn planes(&self) -> usize {
        let n = self.basis.len();
        match self.metric {
            Metric::Function if self.layout.is_product() => n * self.layout.channels(),
            Metric::Function => n * self.layout.functions(),
            Metric::LuminanceAndColor => self.layout.planes(n),
            Metric::Luminance => n,
        }
    }

    /// The index planes of a field.
    ///
    /// # Panics
    /// When the basis or layout of the field differs from the one this space was made for.
    pub fn index_planes(&self, field: &ReflectanceField) -> Planes {
        let mut planes = Planes::zeros(field.size(), self.planes());
        let parts = self.parts(&mut planes);
        parallel::for_each(parts, |(plane, texel, out)| self.coordinates_into(field, plane, texel, out));
        planes
    }

    /// [`IndexSpace::index_planes`] as a part of a job, whose memory they count against; `what` names them in
    /// the message.
    ///
    /// # Errors
    /// Limits exceeded, and a cancelled job.
    ///
    /// # Panics
    /// As [`IndexSpace::index_planes`].
    pub fn index_planes_within(&self, field: &ReflectanceField, job: &Job, what: &str) -> Result<Planes> {
        let mut planes = Planes::zeros_within(job, what, field.size(), self.planes())?;
        parallel::try_for_each(self.parts(&mut planes), |(plane, texel, out)| {
            job.proceed()?;
            self.coordinates_into(field, plane, texel, out);
            Ok(())
        })?;
        Ok(planes)
    }

    /// Parts of planes, each with the number of its plane and that of its first texel.
    fn parts<'a>(
        &self,
        planes: &'a mut Planes,
    ) -> impl Iterator<Item = (usize, usize, &'a mut [f32])> + use<'a> {
        planes.iter_mut().enumerate().flat_map(|(plane, values)| {
            let parts = values.chunks_mut(PART).enumerate();
            parts.map(move |(part, out)| (plane, part * PART, out))
        })
    }

    /// Index plane `p` of a field from texel `texel` on.
    fn coordinates_into(&self, field: &ReflectanceField, p: usize, texel: usize, out: &mut [f32]) {
        assert!((field.basis(), field.layout()) == (&self.basis, &self.layout), "the space of another field");
        let (n, source) = (self.basis.len(), field.coefficients());
        if self.metric == Metric::LuminanceAndColor && p >= n {
            return out.copy_from_slice(&source.plane(p)[texel..][..out.len()]);
        }
        let channel = p / n;
        self.coordinates.forward(p % n, source, self.layout.function_plane(channel, n), texel, out);
        let color = self.layout.color_plane(channel, n).filter(|_| self.metric == Metric::Function);
        if let Some(color) = color {
            out.iter_mut().zip(&source.plane(color)[texel..]).for_each(|(o, c)| *o *= c);
        }
    }

    /// The field of given index planes: the inverse of [`IndexSpace::index_planes`]. Index planes of an LRGB
    /// field under [`Metric::Function`] become the nearest product of a luminance and a colour, exactly if
    /// they are one.
    ///
    /// # Errors
    /// When the number of planes is wrong, or the metric retains too little ([`Metric::Luminance`] of an LRGB
    /// field loses the colour).
    pub fn field(&self, like: &ReflectanceField, index: &Planes) -> Result<ReflectanceField> {
        if index.count() != self.planes() {
            return Err(Error::invalid(format!(
                "this index space has {} planes, found {}",
                self.planes(),
                index.count()
            )));
        }
        let n = self.basis.len();
        let product = self.layout.is_product();
        let mut coefficients = Planes::zeros(index.size(), self.layout.planes(n));
        match self.metric {
            Metric::Luminance if product => {
                return Err(Error::usage(
                    "the metric luminance keeps no colour, so no LRGB field can be made from its planes",
                ));
            }
            Metric::Function if product => self.nearest_products(index, &mut coefficients),
            _ => {
                for (p, out) in coefficients.iter_mut().enumerate() {
                    if product && p >= n {
                        out.copy_from_slice(index.plane(p));
                    } else {
                        self.coordinates.backward(p % n, index, p / n * n, out);
                    }
                }
            }
        }
        like.with_coefficients(coefficients)
    }

    /// Splits the 3 n coordinates of each texel into a luminance function and a colour.
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
                coefficients.plane_mut(k)[texel] = self.coordinates.coefficient(k, &luminance);
            }
            for (c, value) in color.into_iter().enumerate() {
                coefficients.plane_mut(n + c)[texel] = value;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};
    use crate::size::Size;
    use crate::space::Space;

    fn random_field(basis: Basis, color: PlaneLayout, seed: u64) -> ReflectanceField {
        let mut stream = Stream::new(seed, Purpose::Sample, [0]);
        let size = Size::new(5, 3);
        let count = color.planes(basis.len());
        let data = (0..size.texels() * count).map(|_| stream.unit() as f32 * 2.0 - 0.7).collect();
        let mut planes = Planes::from_vec(size, count, data).unwrap();
        if color == PlaneLayout::LRGB {
            // Colours are not negative; black texels have no colour.
            (basis.len()..count)
                .for_each(|k| planes.plane_mut(k).iter_mut().for_each(|v| *v = v.abs() + 0.1));
        }
        ReflectanceField::new(basis, color, Space::Linear, planes).unwrap()
    }

    /// Every basis with every layout, and each domain over which it is defined.
    fn members() -> Vec<(Basis, PlaneLayout, Domain)> {
        let mut members = Vec::new();
        for basis in Basis::examples() {
            for layout in PlaneLayout::examples(&basis) {
                let domains = Domain::ALL.into_iter().filter(|domain| basis.is_defined_over(*domain));
                members.extend(domains.map(|domain| (basis.clone(), layout.clone(), domain)));
            }
        }
        members
    }

    /// The functions of a texel as coefficient vectors.
    fn channel_functions(field: &ReflectanceField, texel: usize) -> Vec<Vec<f64>> {
        let n = field.basis().len();
        let c = |k: usize| f64::from(field.coefficients().plane(k)[texel]);
        match field.layout().is_product() {
            false => {
                (0..field.layout().functions()).map(|f| (0..n).map(|k| c(f * n + k)).collect()).collect()
            }
            true => (0..3).map(|ch| (0..n).map(|k| c(k) * c(n + ch)).collect()).collect(),
        }
    }

    #[test]
    fn index_distance_is_the_integrated_distance_of_the_functions() {
        for (basis, layout, domain) in members() {
            let field = random_field(basis.clone(), layout.clone(), 7);
            let index = IndexSpace::new(&field, Metric::Function, domain).unwrap().index_planes(&field);
            for (a, b) in [(0, 1), (2, 9), (14, 3)] {
                let distance: f64 = (0..index.count())
                    .map(|k| f64::from(index.plane(k)[a] - index.plane(k)[b]).powi(2))
                    .sum();
                let (fa, fb) = (channel_functions(&field, a), channel_functions(&field, b));
                let square = |weights: &[f64]| {
                    let channel = |(ca, cb): (&Vec<f64>, &Vec<f64>)| -> f64 {
                        let terms = weights.iter().zip(ca.iter().zip(cb));
                        terms.map(|(w, (x, y))| w * (x - y)).sum::<f64>().powi(2)
                    };
                    fa.iter().zip(&fb).map(channel).sum()
                };
                let truth = basis.integrate(domain, 12, square).unwrap();
                let error = (distance - truth).abs() / truth;
                assert!(error < 1e-5, "{} {layout:?} {domain:?}: {distance} vs {truth}", basis.name());
            }
        }
    }

    #[test]
    fn the_way_back_is_exact_to_rounding() {
        for (basis, layout, domain) in members() {
            let field = random_field(basis.clone(), layout.clone(), 11);
            let space = IndexSpace::new(&field, Metric::Function, domain).unwrap();
            let back = space.field(&field, &space.index_planes(&field)).unwrap();
            for texel in 0..field.size().texels() {
                let pairs = channel_functions(&field, texel).into_iter().zip(channel_functions(&back, texel));
                for (x, y) in pairs.flat_map(|(a, b)| a.into_iter().zip(b)) {
                    assert!((x - y).abs() < 2e-5, "{} {layout:?} {domain:?}: {x} vs {y}", basis.name());
                }
            }
        }
    }

    #[test]
    fn legendre_coordinates_are_the_documents_corrected() {
        let field = random_field(Basis::Ptm, PlaneLayout::LRGB, 3);
        let index =
            IndexSpace::new(&field, Metric::LuminanceAndColor, Domain::Square).unwrap().index_planes(&field);
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
        let rgb = random_field(Basis::Ptm, PlaneLayout::RGB, 1);
        assert!(IndexSpace::new(&rgb, Metric::LuminanceAndColor, Domain::Square).is_err());
        assert!(IndexSpace::new(&rgb, Metric::Luminance, Domain::Square).is_err());
        let luminance = random_field(Basis::Ptm, PlaneLayout::LUMINANCE, 1);
        assert!(IndexSpace::new(&luminance, Metric::LuminanceAndColor, Domain::Square).is_err());
        assert_eq!(IndexSpace::new(&luminance, Metric::Luminance, Domain::Square).unwrap().planes(), 6);
    }

    #[test]
    fn the_nine_numbers_are_defined_where_their_basis_is() {
        let harmonics = random_field(Basis::HSH9, PlaneLayout::LRGB, 1);
        let space = |domain| IndexSpace::new(&harmonics, Metric::LuminanceAndColor, domain);
        assert!(
            space(Domain::Square).unwrap_err().to_string().contains("cannot be compared over the square")
        );
        let index = space(Domain::Hemisphere).unwrap();
        assert_eq!(index.planes(), 12);
        // Orthonormal by solid angle: the coefficients are the coordinates.
        assert_eq!(index.index_planes(&harmonics), *harmonics.coefficients());
    }
}
