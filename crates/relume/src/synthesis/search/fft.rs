//! Exact search by correlation in the Fourier domain: |t - s|^2 = |t|^2 + |s|^2 - 2 t.s for all
//! positions at once. The usual fast exact method; its cost does not depend on the neighbourhood.
//!
//! Kwatra et al., "Graphcut Textures", SIGGRAPH 2003, section 6 (sums of squares from a summed-area table,
//! the product by the convolution theorem). Squares are exact integers. The correlation is computed in 64-bit
//! floating point with a stated error; every position about which it leaves a doubt is decided by its exact integer distance.

use pulp::Arch;
use realfft::num_complex::Complex64;

use super::distance::BlockTarget;
use super::{BlockQuery, Candidates, Effort, Found, Search};
use crate::numeric::fourier::Fourier;
use crate::numeric::summed_area::SummedArea;
use crate::parallel;
use crate::size::Size;
use crate::synthesis::positions::{PositionRun, Positions};
use crate::synthesis::quantise::{IndexTexels, Quantised, squared_length, squared_lengths};
use crate::synthesis::source_map::Texel;

/// Error of a correlation relative to the product of the lengths of its factors: 2^-53 times a few for each
/// of the 2 x 2 log2(n) butterflies that a value passes through (Higham, Accuracy and Stability of Numerical
/// Algorithms, 2nd ed. 2002, theorem 24.2), generously.
const RELATIVE_ERROR: f64 = 1e-13;

/// Correlates with every position of the exemplars.
pub struct Fft<'a> {
    exemplars: &'a Quantised,
    positions: &'a Positions,
    spectra: Vec<Spectra>,
}

/// The prepared data of one exemplar.
pub(super) struct Spectra {
    /// Positions at which a block lies inside the exemplar never wrap around, so there is no padding.
    transform: Fourier,
    /// The spectrum of each plane.
    planes: Vec<Vec<Complex64>>,
    /// Sums of squared codes.
    squares: SummedArea,
    /// The length of all codes as one vector.
    norm: f64,
}

impl<'a> Fft<'a> {
    /// Transforms all planes of the exemplars.
    pub fn new(exemplars: &'a Quantised, positions: &'a Positions) -> Self {
        let spectra =
            exemplars.texels().iter().map(|texels| Spectra::new(texels, exemplars.planes())).collect();
        Self { exemplars, positions, spectra }
    }
}

impl Spectra {
    /// The size of the exemplar.
    pub fn size(&self) -> Size {
        self.transform.size()
    }

    /// The approximate squared distances of all positions, row by row, and their error; places that are no positions
    /// hold anything.
    pub fn distances(&self, query: &BlockQuery, planes: usize) -> (Vec<f64>, f64) {
        let shape = query.neighbourhood;
        let size = self.transform.size();
        let rects: Vec<_> = shape.rects().collect();
        let filled = |x: usize, y: usize| shape.contains(x, y);
        let own: u64 = rects
            .iter()
            .flat_map(|r| (r.y..r.y + r.size.height).map(move |y| (r.x, y, r.size.width)))
            .map(|(x, y, w)| squared_length(&query.codes[shape.extent.index(x, y) * planes..][..w * planes]))
            .sum();
        let mut product = vec![Complex64::ZERO; self.planes[0].len()];
        for (k, exemplar) in self.planes.iter().enumerate() {
            let mut image = vec![0.0; size.width * shape.extent.height];
            for (x, y) in (0..shape.extent.texels()).map(|i| (i % shape.extent.width, i / shape.extent.width))
            {
                if filled(x, y) {
                    image[size.index(x, y)] = f64::from(query.codes[shape.extent.index(x, y) * planes + k]);
                }
            }
            let spectrum = self.transform.forward_top(image);
            Arch::new().dispatch(
                #[inline(always)]
                || {
                    for ((sum, t), s) in product.iter_mut().zip(&spectrum).zip(exemplar) {
                        *sum += t.conj() * s;
                    }
                },
            );
        }
        let mut distances = self.transform.inverse(product);
        // Only where the neighbourhood lies inside: nothing else is a position.
        let valid = Size::new(size.width + 1 - shape.extent.width, size.height + 1 - shape.extent.height);
        let mut there = vec![0; valid.width];
        for (y, row) in distances.chunks_exact_mut(size.width).take(valid.height).enumerate() {
            there.fill(own);
            for r in &rects {
                self.squares.add_row((r.x, y + r.y), (r.size.width, r.size.height), &mut there);
            }
            row.iter_mut().zip(&there).for_each(|(value, sum)| *value = *sum as f64 - 2.0 * *value);
        }
        let error = 2.0 * RELATIVE_ERROR * self.norm * (own as f64).sqrt() * (planes as f64).sqrt();
        (distances, error + 0.5)
    }
}

impl Search for Fft<'_> {
    fn candidates(&self, queries: &[BlockQuery]) -> Vec<Found> {
        parallel::map(queries.iter(), |query| self.correlate(query))
    }
}

impl Fft<'_> {
    /// Leaves positions out.
    fn strike(&self, query: &BlockQuery, distances: &mut [(Vec<f64>, f64)]) {
        for PositionRun { first, length } in self.positions.runs() {
            let start =
                self.spectra[first.exemplar as usize].size().index(first.x as usize, first.y as usize);
            let (values, _) = &mut distances[first.exemplar as usize];
            query.avoided.strike(*first, &mut values[start..start + length], f64::INFINITY);
        }
    }

    fn correlate(&self, query: &BlockQuery) -> Found {
        let planes = self.exemplars.planes();
        let mut approximate: Vec<(Vec<f64>, f64)> =
            parallel::map(self.spectra.iter(), |spectra| spectra.distances(query, planes));
        self.strike(query, &mut approximate);
        let targets = BlockTarget::all(query, self.exemplars);
        let runs = || {
            self.positions.runs().iter().map(|run| {
                let (e, first) = (run.first.exemplar as usize, run.first);
                let (distances, error) = &approximate[e];
                let start = self.spectra[e].transform.size().index(first.x as usize, first.y as usize);
                (first, &distances[start..start + run.length], *error)
            })
        };
        let mut effort = Effort { examined: self.positions.count() as u64, verified: 0 };
        let mut exact = |Texel { exemplar, y, x }: Texel, limit: u64| {
            effort.verified += 1;
            targets[exemplar as usize].distance_within(x as usize, y as usize, limit)
        };
        // No distance is larger than this one, so neither is the smallest.
        let least = |values: &[f64]| values.iter().copied().fold(f64::INFINITY, f64::min);
        let above = runs().map(|(_, values, error)| least(values) + error).fold(f64::INFINITY, f64::min);
        let mut best = u64::MAX;
        for (first, values, error) in runs() {
            for (i, _) in values.iter().enumerate().filter(|(_, value)| **value - error <= above) {
                best = best.min(exact(first.offset(i, 0), best).unwrap_or(best));
            }
        }
        let limit = query.acceptance.limit(best);
        let mut positions = Vec::new();
        for (first, values, error) in runs() {
            for (i, value) in values.iter().enumerate().filter(|(_, value)| **value - error <= limit as f64) {
                let position = first.offset(i, 0);
                // Only those about the limit are compared.
                if value + error <= limit as f64 || exact(position, limit).is_some() {
                    positions.push(position);
                }
            }
        }
        Found { candidates: Candidates { best, positions }, effort }
    }
}

impl Spectra {
    /// Transforms all planes of an exemplar.
    pub fn new(texels: &IndexTexels, planes: usize) -> Self {
        let transform = Fourier::new(texels.size());
        let codes = &texels.codes()[..texels.size().texels() * planes];
        let plane = |k: usize| {
            let image: Vec<f64> = codes[k..].iter().step_by(planes).map(|&code| f64::from(code)).collect();
            transform.forward(image)
        };
        let squares = SummedArea::new(texels.size(), &squared_lengths(codes, planes));
        let norm = (squares.sum(0, 0, texels.size().width, texels.size().height) as f64).sqrt();
        Self { planes: parallel::map(0..planes, plane), transform, squares, norm }
    }
}
