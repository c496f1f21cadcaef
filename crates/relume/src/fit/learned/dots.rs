//! Inner products of rows of texels with planes.
//!
//! The planes are interleaved in groups of sixteen, so that the sums of a group are side by side: each is a chain of
//! plain multiplications and additions in the order of the texels, whatever the width of the machine's vectors.

use pulp::{Arch, Simd, WithSimd};

use crate::fit::products::BAND;
use crate::planes::Planes;

/// Planes side by side.
const GROUP: usize = 16;

/// Rows whose sums share the registers.
const ROWS: usize = 6;

/// Planes for inner products, band after band: of each group of planes the sixteen values of each texel together,
/// zero where there are fewer planes.
pub(super) struct Interleaved {
    count: usize,
    texels: usize,
    values: Vec<f32>,
}

impl Interleaved {
    /// The bytes for planes of so many texels.
    pub fn bytes(count: usize, texels: usize) -> u64 {
        4 * (count.div_ceil(GROUP) * GROUP * texels) as u64
    }

    pub fn new(planes: &Planes) -> Self {
        let (count, texels) = (planes.count(), planes.size().texels());
        let groups = count.div_ceil(GROUP);
        let mut values = vec![0.0; groups * GROUP * texels];
        for (k, plane) in planes.iter().enumerate() {
            for (b, plane) in plane.chunks(BAND).enumerate() {
                let start = GROUP * (groups * b * BAND + k / GROUP * plane.len());
                let band = values[start..][..GROUP * plane.len()].as_chunks_mut::<GROUP>().0;
                band.iter_mut().zip(plane).for_each(|(texel, value)| texel[k % GROUP] = *value);
            }
        }
        Self { count, texels, values }
    }

    /// The number of planes.
    pub fn count(&self) -> usize {
        self.count
    }

    /// The number of bands.
    pub fn bands(&self) -> usize {
        self.texels.div_ceil(BAND)
    }

    /// The number of texels of a band.
    pub fn band_texels(&self, band: usize) -> usize {
        BAND.min(self.texels - band * BAND)
    }

    /// `out[r * count + k] = sum_t rows[r][t] plane_k[t]` over a band, for rows of [`BAND`] values each of which the
    /// first are those of the band.
    pub fn dots(&self, arch: Arch, band: usize, rows: &[f32], out: &mut [f32]) {
        let (groups, texels) = (self.count.div_ceil(GROUP), self.band_texels(band));
        let values = &self.values[GROUP * groups * band * BAND..][..GROUP * groups * texels];
        for (g, group) in values.chunks_exact(GROUP * texels).enumerate() {
            let kept = GROUP.min(self.count - g * GROUP);
            let mut store = |row: usize, sums: &[f32; GROUP]| {
                out[row * self.count + g * GROUP..][..kept].copy_from_slice(&sums[..kept]);
            };
            let mut first = 0;
            for rows in rows.chunks(ROWS * BAND) {
                let row = |r: usize| &rows[r * BAND..][..texels];
                if rows.len() == ROWS * BAND {
                    let sums = arch.dispatch(Dots { rows: std::array::from_fn::<_, ROWS, _>(row), group });
                    sums.iter().enumerate().for_each(|(r, sums)| store(first + r, sums));
                } else {
                    for r in 0..rows.len() / BAND {
                        store(first + r, &arch.dispatch(Dots { rows: [row(r)], group })[0]);
                    }
                }
                first += ROWS;
            }
        }
    }
}

struct Dots<'a, const R: usize> {
    rows: [&'a [f32]; R],
    group: &'a [f32],
}

impl<const R: usize> WithSimd for Dots<'_, R> {
    type Output = [[f32; GROUP]; R];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let texels = self.group.len() / GROUP;
        let rows = self.rows.map(|row| &row[..texels]);
        let (vectors, _) = S::as_simd_f32s(self.group);
        let parts = vectors.len() / texels;
        let mut out = [[0.0; GROUP]; R];
        for part in 0..parts {
            let mut sums = [simd.splat_f32s(0.0); R];
            for (t, values) in vectors.chunks_exact(parts).enumerate() {
                for r in 0..R {
                    sums[r] =
                        simd.add_f32s(sums[r], simd.mul_f32s(simd.splat_f32s(rows[r][t]), values[part]));
                }
            }
            let width = GROUP / parts;
            for r in 0..R {
                let (out, _) = S::as_mut_simd_f32s(&mut out[r][part * width..][..width]);
                out[0] = sums[r];
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};
    use crate::size::Size;

    #[test]
    fn products_are_those_of_doubles_at_any_length_and_count() {
        let mut stream = Stream::new(3, Purpose::Sample, [0]);
        for (texels, count, row_count) in
            [(1, 1, 1), (17, 3, 7), (1024, 16, 6), (1500, 21, 13), (2049, 33, 2)]
        {
            let mut numbers = |n: usize| (0..n).map(|_| stream.unit() as f32 - 0.3).collect::<Vec<f32>>();
            let planes = Planes::from_vec(Size::new(texels, 1), count, numbers(count * texels)).unwrap();
            let rows: Vec<Vec<f32>> = (0..row_count).map(|_| numbers(texels)).collect();
            let interleaved = Interleaved::new(&planes);
            let mut sums = vec![0.0f64; row_count * count];
            for band in 0..interleaved.bands() {
                let length = interleaved.band_texels(band);
                let mut padded = vec![9.0; row_count * BAND];
                for (padded, row) in padded.chunks_exact_mut(BAND).zip(&rows) {
                    padded[..length].copy_from_slice(&row[band * BAND..][..length]);
                }
                let mut out = vec![0.0; row_count * count];
                interleaved.dots(Arch::new(), band, &padded, &mut out);
                sums.iter_mut().zip(out).for_each(|(sum, product)| *sum += f64::from(product));
            }
            for (r, row) in rows.iter().enumerate() {
                for k in 0..count {
                    let terms = row.iter().zip(planes.plane(k));
                    let truth: f64 = terms.map(|(a, b)| f64::from(*a) * f64::from(*b)).sum();
                    let found = sums[r * count + k];
                    assert!((truth - found).abs() < 1e-5 * texels as f64, "{truth} and {found}");
                }
            }
        }
    }

    /// The sums are chains in the order of the texels: what any width of vectors gives.
    #[test]
    fn products_of_a_band_are_plain_chains_to_the_bit() {
        let mut stream = Stream::new(5, Purpose::Sample, [0]);
        let mut numbers = |n: usize| (0..n).map(|_| stream.unit() as f32 - 0.5).collect::<Vec<f32>>();
        let planes = Planes::from_vec(Size::new(BAND, 1), 19, numbers(19 * BAND)).unwrap();
        let rows = numbers(8 * BAND);
        let mut out = vec![0.0; 8 * 19];
        Interleaved::new(&planes).dots(Arch::new(), 0, &rows, &mut out);
        for (r, row) in rows.chunks(BAND).enumerate() {
            for k in 0..19 {
                let chain = row.iter().zip(planes.plane(k)).fold(0.0f32, |sum, (a, b)| sum + a * b);
                assert_eq!(out[r * 19 + k].to_bits(), chain.to_bits());
            }
        }
    }
}
