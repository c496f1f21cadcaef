//! The coordinates of every cell of the exemplars, computed once.
//!
//! With the contraction A of [`Kernels`], |t - s|^2 >= |A t - A s|^2 + (r(t) - r(s))^2, where
//! r(x)^2 = |x|^2 - |A x|^2 is what the kernels leave of x: r(x) is the length of B x for the
//! completion B = (I - A'A)^(1/2), and lengths differ by no more than the vectors do (the reverse
//! triangle inequality, or Cauchy-Schwarz). Codes are first shifted by the mean of their plane,
//! which changes no difference and keeps r small.
//!
//! Projections are exact integers. Coordinates are scaled so that those of a whole neighbourhood are
//! no longer than [`LONGEST`], and rounded to 16 bits; each is off by half a unit at most. The
//! coordinates of the first look lie in planes, so that neighbouring positions are taken together;
//! the further ones, and the rest, lie together for each position.

use rayon::prelude::*;

use super::kernels::{FURTHER, Kernels, MOST_FIRST};
use super::product::{MOST, PairPlanes, Product, STRETCH, Stretch, pair};
use crate::numeric::pairs::{FACTORS, SUMS};
use crate::planes::Size;
use crate::synthesis::quantise::{IndexTexels, Quantised};
use crate::synthesis::search::summed_area::SummedArea;
use crate::synthesis::source_map::Texel;

/// Coordinates of a neighbourhood are no longer than this, so that twice a coordinate fits 16 bits
/// and sums of products, and of squares, of two neighbourhoods fit 32.
pub const LONGEST: f64 = 16_000.0;

/// Coordinates of all cells of one size.
#[derive(Debug)]
pub struct Table {
    kernels: Kernels,
    /// The kernels as factors of pairs of texels, for [`MOST`] kernels at a time.
    factors: Vec<Vec<[i32; MOST]>>,
    /// Where those pairs lie in a cell.
    offsets: Vec<(usize, usize)>,
    /// The shift of each plane.
    means: Vec<i16>,
    /// Units of the coordinates for one code.
    scale: f64,
    /// The length of the longest cell, in codes.
    radius: f64,
    grids: Vec<Grid>,
}

/// The coordinates of one exemplar's cells.
#[derive(Debug)]
pub struct Grid {
    places: Size,
    /// Those of the first look, in pairs, and their squared length, cut in two by [`split`].
    first: PairPlanes,
    /// Place after place.
    further: Vec<Further>,
}

/// The coordinates of one cell that the first look leaves out, and the length of the rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(align(64))]
pub struct Further(pub [i16; FACTORS]);

const _: () = assert!(FURTHER + 1 == FACTORS);

impl Grid {
    /// The first coordinates.
    pub fn first(&self) -> &PairPlanes {
        &self.first
    }

    /// The further coordinates of the place (x, y).
    #[inline(always)]
    pub fn further(&self, x: usize, y: usize) -> &Further {
        &self.further[self.places.index(x, y)]
    }
}

impl Table {
    /// Projects every cell of the exemplars, for neighbourhoods of at most `cells` cells.
    pub fn new(kernels: Kernels, exemplars: &Quantised, cells: usize) -> Self {
        let means = plane_means(exemplars);
        let offsets = pair_offsets(kernels.side);
        let chunks = kernels.weights.chunks(MOST);
        let factors =
            chunks.map(|weights| pair_factors(weights, &offsets, kernels.side, means.len())).collect();
        let mut table = Self { kernels, factors, offsets, means, scale: 1.0, radius: 0.0, grids: Vec::new() };
        let shifted: Vec<Shifted> =
            exemplars.texels().iter().map(|texels| Shifted::new(texels, &table.means)).collect();
        table.radius = shifted.iter().map(|s| s.longest(table.kernels.side)).max().unwrap_or(0) as f64;
        table.radius = table.radius.sqrt();
        table.scale = LONGEST / (table.radius.max(1.0) * (cells.max(1) as f64).sqrt());
        table.grids = shifted.iter().map(|shifted| table.grid(shifted)).collect();
        table
    }

    /// Texels along a side of a cell.
    pub fn side(&self) -> usize {
        self.kernels.side
    }

    /// Pairs of coordinates of a cell that the first look takes: at least one, of zeros where the
    /// exemplars have no variation and so no kernels.
    pub fn pairs(&self) -> usize {
        self.kernels.first.div_ceil(2).max(1)
    }

    /// The number of kernels, those of the second look included.
    pub fn kernels(&self) -> usize {
        self.kernels.weights.len()
    }

    /// The sum over a block's cells of the squared difference of one coordinate.
    pub fn squared_difference(
        &self,
        kernel: usize,
        cells: &[(usize, usize)],
        wanted: &[Coordinates],
        position: Texel,
    ) -> f64 {
        let grid = &self.grids[position.exemplar as usize];
        let of = |own: &Coordinates| match kernel.checked_sub(self.kernels.first) {
            Some(further) => own.further.0[further],
            None => own.first[kernel],
        };
        let at = |x: usize, y: usize| match kernel.checked_sub(self.kernels.first) {
            Some(further) => grid.further(x, y).0[further],
            None => grid.first.value(kernel, x, y),
        };
        let squares = cells.iter().zip(wanted).map(|(&(dx, dy), wanted)| {
            let there = at(position.x as usize + dx, position.y as usize + dy);
            (f64::from(there) - f64::from(of(wanted))).powi(2)
        });
        squares.sum()
    }

    /// Units of the coordinates for one code.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// The coordinates of an exemplar's cells.
    fn grid(&self, shifted: &Shifted) -> Grid {
        let size = shifted.size;
        let places = Size::new(size.width + 1 - self.kernels.side, size.height + 1 - self.kernels.side);
        let mut grid = Grid {
            places,
            first: PairPlanes::zeros(self.pairs() + 1, places.width, places.height),
            further: vec![Further([0; FACTORS]); places.texels()],
        };
        let length = grid.first.row_length();
        let first: Vec<&mut [i16]> = grid.first.rows_mut().collect();
        let rows = first.into_par_iter().zip(grid.further.par_chunks_exact_mut(places.width));
        rows.enumerate().for_each(|(y, (first, further))| {
            for x in (0..places.width).step_by(STRETCH) {
                let width = STRETCH.min(places.width - x);
                for (i, own) in self.project_stretch(shifted, x, y, width).into_iter().enumerate() {
                    further[x + i] = own.further;
                    let pairs = own.first.as_chunks::<2>().0[..self.pairs()].iter();
                    let pairs = pairs.copied().chain([split(own.square)]);
                    for (plane, pair) in first.chunks_exact_mut(length).zip(pairs) {
                        plane[2 * (x + i)..][..2].copy_from_slice(&pair);
                    }
                }
            }
        });
        grid
    }

    /// The coordinates of neighbouring cells of an exemplar.
    fn project_stretch(&self, shifted: &Shifted, x: usize, y: usize, length: usize) -> Vec<Coordinates> {
        let mut sums: Box<Stretch> = Box::new([[[0; SUMS]; STRETCH / SUMS]; MOST]);
        let count = self.kernels.weights.len();
        let mut projections = vec![0; count * length];
        for (factors, to) in self.factors.iter().zip(projections.chunks_mut(MOST * length)) {
            let sets = to.len() / length;
            let planes = &shifted.pairs;
            Product { planes, offsets: &self.offsets, factors, sets, x, y, length, sums: &mut sums }
                .compute();
            for (to, sums) in to.chunks_exact_mut(length).zip(&*sums) {
                to.copy_from_slice(&sums.as_flattened()[..length]);
            }
        }
        let side = self.kernels.side;
        let own = |i: usize| {
            let squares = shifted.squares.sum(x + i, y, side, side);
            self.coordinates_of((0..count).map(|k| projections[k * length + i]), squares)
        };
        (0..length).map(own).collect()
    }

    /// The grids, one for each exemplar.
    pub fn grids(&self) -> &[Grid] {
        &self.grids
    }

    /// The coordinates of a query's cell: rows of `stride` codes, from `start`.
    ///
    /// A query may be patched together of parts that no exemplar has side by side, and be longer than
    /// any cell of them. It is then drawn back into the ball that holds all of those, which brings it
    /// nearer to each.
    pub fn project(&self, codes: &[i16], start: usize, stride: usize) -> Coordinates {
        let length = self.kernels.side * self.means.len();
        let rows = (0..self.kernels.side).map(|y| &codes[start + y * stride..][..length]);
        let means = || self.means.iter().cycle();
        let shifted: Vec<i16> =
            rows.flat_map(|row| row.iter().zip(means()).map(|(c, mean)| c - mean)).collect();
        let products = |weights: &Vec<i16>| {
            let terms = weights.iter().zip(&shifted);
            terms.fold(0i32, |sum, (&w, &c)| sum.wrapping_add(i32::from(w) * i32::from(c)))
        };
        let squares = shifted.iter().map(|&code| i64::from(code).pow(2)).sum();
        self.coordinates_of(self.kernels.weights.iter().map(products), squares)
    }

    /// Coordinates from exact projections and the exact square of the length.
    fn coordinates_of(&self, projections: impl Iterator<Item = i32>, squares: i64) -> Coordinates {
        let mut out = Coordinates { first: [0; MOST_FIRST], square: 0, further: Further([0; FACTORS]) };
        let length = (squares as f64).sqrt();
        let inwards = if length > self.radius { self.radius / length } else { 1.0 };
        let unit = inwards * self.scale;
        let scale = unit * self.kernels.lambda.sqrt().recip();
        let mut rest = squares as f64 * unit * unit;
        let mut projections = projections.map(|projection| {
            let value = f64::from(projection) * scale;
            rest -= value * value;
            rounded(value)
        });
        let first = out.first.iter_mut().take(self.kernels.first);
        out.square = first.zip(&mut projections).fold(0, |square, (out, value)| {
            *out = value;
            square + i32::from(value).pow(2)
        });
        out.further.0.iter_mut().zip(&mut projections).for_each(|(out, value)| *out = value);
        drop(projections);
        out.further.0[FURTHER] = rounded(rest.max(0.0).sqrt());
        out
    }
}

/// The nearest integer; coordinates are below [`LONGEST`] and a little.
#[inline(always)]
fn rounded(value: f64) -> i16 {
    // Truncating a positive number is rounding it down.
    ((value + 32_768.5) as i32 - 32_768) as i16
}

/// The high and low bits of a squared length, whose sum of products with [`MINUS_SQUARE`] is the
/// squared length with a minus sign.
fn split(square: i32) -> [i16; 2] {
    [(square >> SPLIT) as i16, (square & ((1 << SPLIT) - 1)) as i16]
}

/// Squared lengths up to [`LONGEST`] squared, 28 bits, make two numbers of up to 14.
const SPLIT: u32 = 14;

/// The factors of a squared length.
pub const MINUS_SQUARE: [i16; 2] = [-(1 << SPLIT), -1];

/// The coordinates of one cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Coordinates {
    /// Those of the first look, and zeros past them.
    pub first: [i16; MOST_FIRST],
    /// Their squared length.
    pub square: i32,
    /// The further ones.
    pub further: Further,
}

/// One exemplar's codes less the planes' means.
struct Shifted {
    size: Size,
    /// Each texel's code and its right neighbour's, plane by plane.
    pairs: PairPlanes,
    squares: SummedArea,
}

impl Shifted {
    fn new(texels: &IndexTexels, means: &[i16]) -> Self {
        let (size, planes) = (texels.size(), means.len());
        let mut pairs = PairPlanes::zeros(planes, size.width, size.height);
        let length = pairs.row_length();
        let mut codes = texels.codes()[..size.texels() * planes].to_vec();
        codes.iter_mut().zip(means.iter().cycle()).for_each(|(code, mean)| *code -= mean);
        for (row, codes) in pairs.rows_mut().zip(codes.chunks_exact(size.width * planes)) {
            for (k, plane) in row.chunks_exact_mut(length).enumerate() {
                let right = codes.iter().skip(k + planes).step_by(planes).chain([&0]);
                let both = codes.iter().skip(k).step_by(planes).zip(right);
                plane.as_chunks_mut().0.iter_mut().zip(both).for_each(|(pair, (&a, &b))| *pair = [a, b]);
            }
        }
        let squares = SummedArea::of_squares(&codes, planes, size);
        Self { size, pairs, squares }
    }

    /// The largest sum of squares of a cell.
    fn longest(&self, side: usize) -> i64 {
        let size = self.size;
        let places = (0..=size.height - side).flat_map(|y| (0..=size.width - side).map(move |x| (x, y)));
        places.map(|(x, y)| self.squares.sum(x, y, side, side)).max().unwrap_or(0)
    }
}

/// Where the pairs of neighbouring texels lie that make up a cell; those of odd sides reach past it.
fn pair_offsets(side: usize) -> Vec<(usize, usize)> {
    (0..side).flat_map(|y| (0..side).step_by(2).map(move |x| (x, y))).collect()
}

/// For each pair of texels and each plane the weights of several kernels, zeros past the cell.
fn pair_factors(
    kernels: &[Vec<i16>],
    offsets: &[(usize, usize)],
    side: usize,
    planes: usize,
) -> Vec<[i32; MOST]> {
    let weight = |kernel: usize, x: usize, y: usize, plane: usize| match kernels.get(kernel) {
        Some(weights) if x < side => weights[(y * side + x) * planes + plane],
        _ => 0,
    };
    let factors = |(x, y): (usize, usize), plane: usize| {
        std::array::from_fn(|k| pair([weight(k, x, y, plane), weight(k, x + 1, y, plane)]))
    };
    offsets.iter().flat_map(|&offset| (0..planes).map(move |plane| factors(offset, plane))).collect()
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
