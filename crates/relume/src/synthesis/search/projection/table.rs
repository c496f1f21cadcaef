//! The projections of every rectangle of the exemplars on the kernels, computed once.
//!
//! With the contraction A of [`Kernels`], |t - s|^2 >= |A t - A s|^2 + (r(t) - r(s))^2, where
//! r(x)^2 = |x|^2 - |A x|^2 is what the kernels leave of x: r(x) is the length of B x for the
//! completion B = (I - A'A)^(1/2), and lengths differ by no more than the vectors do (the reverse
//! triangle inequality, or Cauchy-Schwarz). Codes are first shifted by the mean of their plane,
//! which changes no difference and keeps r small.

use rayon::prelude::*;

use super::kernels::Kernels;
use crate::planes::Size;
use crate::synthesis::quantise::{IndexTexels, MAX_CODE, Quantised};
use crate::synthesis::search::summed_area::SummedArea;

/// Codes multiplied at a time.
const LANES: usize = 16;

/// Kernels that share the loads of codes.
const TOGETHER: usize = 4;

/// Projections of all rectangles of one size.
#[derive(Debug)]
pub struct Table {
    kernels: Kernels,
    /// Kernels in rows of whole groups of lanes.
    padded: Vec<Vec<[i16; LANES]>>,
    /// Groups in each row.
    groups: usize,
    /// The shift of each plane.
    means: Vec<i16>,
    /// For each exemplar, coordinate after coordinate, place after place; the rest r is the last.
    coordinates: Vec<Vec<Vec<f32>>>,
    sizes: Vec<Size>,
}

impl Table {
    /// Projects every rectangle.
    pub fn new(kernels: Kernels, exemplars: &Quantised) -> Self {
        let planes = exemplars.planes();
        let groups = (kernels.width * planes).div_ceil(LANES);
        let padded = kernels.weights.iter().map(|w| padded_rows(w, kernels.width * planes, groups)).collect();
        let means = plane_means(exemplars);
        let sizes = exemplars.texels().iter().map(|texels| places(texels.size(), &kernels)).collect();
        let mut table = Self { kernels, padded, groups, means, coordinates: Vec::new(), sizes };
        table.coordinates = exemplars.texels().iter().map(|texels| table.project_all(texels)).collect();
        table
    }

    /// Texels of the rectangles along x and y.
    pub fn rectangle(&self) -> Size {
        Size::new(self.kernels.width, self.kernels.height)
    }

    /// The number of coordinates: kernels and the rest.
    pub fn count(&self) -> usize {
        self.kernels.weights.len() + 1
    }

    /// Coordinate `c` of `length` rectangles of an exemplar from the one at (x, y) to the right.
    pub fn row(&self, exemplar: usize, c: usize, x: usize, y: usize, length: usize) -> &[f32] {
        &self.coordinates[exemplar][c][self.sizes[exemplar].index(x, y)..][..length]
    }

    /// How far a coordinate may be off by rounding to `f32`.
    pub fn error(&self) -> f64 {
        let texels = self.kernels.width * self.kernels.height * self.means.len();
        f64::from(MAX_CODE) * (texels as f64).sqrt() * f64::from(f32::EPSILON)
    }

    /// The coordinates of a rectangle of a query: rows of `stride` codes, from `start`.
    pub fn project(&self, codes: &[i16], start: usize, stride: usize) -> Vec<f32> {
        let length = self.kernels.width * self.means.len();
        let mut rows = vec![[0i16; LANES]; self.groups * self.kernels.height];
        for (y, row) in rows.chunks_exact_mut(self.groups).enumerate() {
            let source = codes[start + y * stride..][..length].chunks(LANES);
            row.iter_mut().zip(source).for_each(|(to, from)| to[..from.len()].copy_from_slice(from));
            self.shift(row.as_flattened_mut(), length);
        }
        let kernels = self.padded.iter().map(|kernel| {
            let terms = kernel.iter().zip(&rows).flat_map(|(k, r)| k.iter().zip(r));
            terms.map(|(k, r)| i64::from(*k) * i64::from(*r)).sum::<i64>() as i32
        });
        let squares = rows.as_flattened().iter().map(|&code| i64::from(code).pow(2)).sum();
        self.coordinates_of(kernels, squares).collect()
    }

    fn shift(&self, row: &mut [i16], length: usize) {
        let means = self.means.iter().cycle();
        row[..length].iter_mut().zip(means).for_each(|(code, mean)| *code -= mean);
    }

    /// Exact projections and the exact square of the length as coordinates.
    fn coordinates_of(
        &self,
        projections: impl Iterator<Item = i32> + Clone,
        squares: i64,
    ) -> impl Iterator<Item = f32> {
        let scale = self.kernels.lambda.sqrt().recip();
        let held: f64 = projections.clone().map(|p| (f64::from(p) * scale).powi(2)).sum();
        let rest = (squares as f64 - held).max(0.0).sqrt();
        projections.map(move |p| (f64::from(p) * scale) as f32).chain([rest as f32])
    }

    fn project_all(&self, texels: &IndexTexels) -> Vec<Vec<f32>> {
        let places = places(texels.size(), &self.kernels);
        let shifted = self.shifted(texels);
        let squares = SummedArea::of_squares(&shifted, self.means.len(), texels.size());
        let (width, height) = (self.kernels.width, self.kernels.height);
        let mut coordinates = vec![vec![0.0f32; places.texels()]; self.count()];
        let mut rows: Vec<Vec<&mut [f32]>> = (0..places.height).map(|_| Vec::new()).collect();
        for coordinate in &mut coordinates {
            rows.iter_mut().zip(coordinate.chunks_exact_mut(places.width)).for_each(|(row, c)| row.push(c));
        }
        rows.par_iter_mut().enumerate().for_each(|(y, row)| {
            let mut projections = vec![0i32; places.width * self.padded.len()];
            self.project_row(&shifted, texels.start(0, y), texels.start(0, 1), &mut projections);
            for x in 0..places.width {
                let own = (0..self.padded.len()).map(|k| projections[k * places.width + x]);
                let values = self.coordinates_of(own, squares.sum(x, y, width, height));
                row.iter_mut().zip(values).for_each(|(to, value)| to[x] = value);
            }
        });
        coordinates
    }

    /// The projections of one row of rectangles, kernel after kernel.
    fn project_row(&self, codes: &[i16], start: usize, stride: usize, out: &mut [i32]) {
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = pulp::x86::V3::try_new() {
            return simd.vectorize(
                #[inline(always)]
                || {
                    self.project_with(
                        |sums, c, w| avx2_multiply_add(simd, sums, c, w),
                        codes,
                        start,
                        stride,
                        out,
                    )
                },
            );
        }
        self.project_with(multiply_add, codes, start, stride, out);
    }

    /// [`Table::project_row`] by a given way to multiply and add a group.
    #[inline(always)]
    fn project_with(
        &self,
        multiply_add: impl Fn(&mut Sums, &[i16; LANES], &[i16; LANES]),
        codes: &[i16],
        start: usize,
        stride: usize,
        out: &mut [i32],
    ) {
        // Exemplars without variation have no kernels.
        let Some(width) = out.len().checked_div(self.padded.len()) else { return };
        for (kernels, out) in self.padded.chunks(TOGETHER).zip(out.chunks_mut(TOGETHER * width)) {
            for x in 0..width {
                let mut sums = [[0i32; LANES / 2]; TOGETHER];
                for y in 0..self.kernels.height {
                    let row = &codes[start + x * self.means.len() + y * stride..][..self.groups * LANES];
                    for (g, group) in row.as_chunks::<LANES>().0.iter().enumerate() {
                        for (sum, kernel) in sums.iter_mut().zip(kernels) {
                            multiply_add(sum, group, &kernel[y * self.groups + g]);
                        }
                    }
                }
                for (k, sum) in sums.iter().take(kernels.len()).enumerate() {
                    out[k * width + x] = sum.iter().fold(0i32, |a, &b| a.wrapping_add(b));
                }
            }
        }
    }

    /// The codes of an exemplar less the planes' means; padding stays zero.
    fn shifted(&self, texels: &IndexTexels) -> Vec<i16> {
        let length = texels.size().texels() * self.means.len();
        let mut codes = texels.codes().to_vec();
        self.shift(&mut codes, length);
        codes
    }
}

/// Partial sums, which wrap harmlessly: the whole sum fits 32 bits.
type Sums = [i32; LANES / 2];

/// Adds products in pairs.
fn multiply_add(sums: &mut Sums, codes: &[i16; LANES], weights: &[i16; LANES]) {
    for i in 0..LANES {
        sums[i / 2] = sums[i / 2].wrapping_add(i32::from(codes[i]) * i32::from(weights[i]));
    }
}

/// [`multiply_add`] in AVX2 instructions.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn avx2_multiply_add(simd: pulp::x86::V3, sums: &mut Sums, codes: &[i16; LANES], weights: &[i16; LANES]) {
    let products = simd.avx2._mm256_madd_epi16(pulp::cast(*codes), pulp::cast(*weights));
    *sums = pulp::cast(simd.avx2._mm256_add_epi32(pulp::cast(*sums), products));
}

/// The rectangles an exemplar has room for.
fn places(size: Size, kernels: &Kernels) -> Size {
    Size::new(size.width + 1 - kernels.width, size.height + 1 - kernels.height)
}

/// A kernel's rows, each filled up with zeros to whole groups.
fn padded_rows(weights: &[i16], length: usize, groups: usize) -> Vec<[i16; LANES]> {
    let mut padded = Vec::with_capacity(weights.len() / length * groups);
    for row in weights.chunks_exact(length) {
        for part in row.chunks(LANES) {
            let mut group = [0; LANES];
            group[..part.len()].copy_from_slice(part);
            padded.push(group);
        }
    }
    padded
}

/// The mean code of each plane over all exemplars, rounded.
fn plane_means(exemplars: &Quantised) -> Vec<i16> {
    let planes = exemplars.planes();
    let mut sums = vec![0i64; planes];
    let mut texels = 0;
    for exemplar in exemplars.texels() {
        let length = exemplar.size().texels() * planes;
        texels += exemplar.size().texels() as i64;
        for texel in exemplar.codes()[..length].chunks_exact(planes) {
            sums.iter_mut().zip(texel).for_each(|(sum, &code)| *sum += i64::from(code));
        }
    }
    sums.into_iter().map(|sum| (sum / texels.max(1)) as i16).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::Limits;
    use crate::numeric::random::Stream;
    use crate::planes::Planes;
    use crate::synthesis::quantise::Exemplar;
    use crate::synthesis::search::KernelBasis;

    #[test]
    fn coordinates_never_exceed_distances_and_a_query_has_those_of_its_equal() {
        for (seed, basis) in
            [KernelBasis::Svd, KernelBasis::Dct, KernelBasis::WalshHadamard].into_iter().enumerate()
        {
            let mut stream = Stream::new(seed as u64, 0);
            let size = Size::new(17, 14);
            let planes = 1 + stream.below(7);
            let data = (0..size.texels() * planes).map(|_| stream.unit() as f32).collect();
            let field = Planes::from_vec(size, planes, data).unwrap();
            let exemplars =
                Quantised::new(&[Exemplar { index: &field, excluded: None }], &Limits::default()).unwrap();
            let texels = &exemplars.texels()[0];
            let (width, height) = (5, 3);
            let table = Table::new(Kernels::new(basis, 6, &exemplars, width, height), &exemplars);
            let at = |x: usize, y: usize| -> Vec<f32> {
                (0..table.count()).map(|c| table.row(0, c, x, y, 1)[0]).collect()
            };
            let codes =
                |x: usize, y: usize| (y..y + height).flat_map(move |y| texels.run(x, y, width).to_vec());
            for _ in 0..200 {
                let [ax, bx] = [0; 2].map(|_| stream.below(size.width - width + 1));
                let [ay, by] = [0; 2].map(|_| stream.below(size.height - height + 1));
                let start = texels.start(ax, ay);
                assert_eq!(table.project(texels.codes(), start, texels.start(0, 1)), at(ax, ay));
                let distance: f64 =
                    codes(ax, ay).zip(codes(bx, by)).map(|(a, b)| f64::from(a - b).powi(2)).sum();
                let bound: f64 =
                    at(ax, ay).iter().zip(at(bx, by)).map(|(a, b)| f64::from(a - b).powi(2)).sum();
                assert!(
                    bound.sqrt() <= distance.sqrt() + 3.0 * table.error(),
                    "{basis:?}: {bound} {distance}"
                );
            }
        }
    }
}
